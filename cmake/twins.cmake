# The GLSL twins that lie beside their kernels are compiled to SPIR-V and validated; a twin that does not compile breaks
# the build.
find_program(GLSLANG glslangValidator)
find_program(SPIRV_VAL spirv-val)
if(NOT GLSLANG OR NOT SPIRV_VAL)
  message(FATAL_ERROR "glslangValidator or spirv-val not found (glslang-tools, spirv-tools; tools/install-deps installs "
    "them): binding numbers and block layouts are read from the twins' SPIR-V")
endif()

# The files that any twin may include.
file(GLOB_RECURSE PLUMB_TWIN_INCLUDES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/core/*.glsl
  ${PROJECT_SOURCE_DIR}/raster/*.glsl ${PROJECT_SOURCE_DIR}/gi/*.glsl ${PROJECT_SOURCE_DIR}/tools/probe/*.glsl)

# plumb_compile_twins(<target> <file>...): SPIR-V of each file, under <build>/twins, as part of the target ALL.
function(plumb_compile_twins target)
  if(NOT ARGN)
    return()
  endif()
  foreach(file IN LISTS ARGN)
    file(RELATIVE_PATH name ${PROJECT_SOURCE_DIR} ${file})
    string(REPLACE "/" "." name ${name})
    set(spirv ${CMAKE_BINARY_DIR}/twins/${name}.spv)
    add_custom_command(OUTPUT ${spirv}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/twins
      COMMAND ${GLSLANG} -V --quiet --target-env vulkan1.1 -I${PROJECT_SOURCE_DIR} -o ${spirv} ${file}
      COMMAND ${SPIRV_VAL} --target-env vulkan1.1 ${spirv}
      DEPENDS ${file} ${PLUMB_TWIN_INCLUDES} VERBATIM)
    list(APPEND outputs ${spirv})
  endforeach()
  add_custom_target(${target} ALL DEPENDS ${outputs})
endfunction()

# plumb_twin_layouts(<target> <file>...): a header a twin with its bindings and its block (core/twin_layout.h), one for
# a .vert and its .frag, for <target> to include as "twins/<folder>.<name>.h"; the twins of <target> are those that
# plumb_compile_twins() compiled.
add_executable(plumb_twin_layout ${PROJECT_SOURCE_DIR}/tools/twins/layout.cpp)
target_include_directories(plumb_twin_layout PRIVATE ${PROJECT_SOURCE_DIR})
function(plumb_twin_layouts target)
  foreach(file IN LISTS ARGN)
    file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${file})
    string(REPLACE "/" "." name ${path})
    list(APPEND all ${CMAKE_BINARY_DIR}/twins/${name}.spv)
    if(path MATCHES "\\.vert$")
      continue()  # goes with its .frag
    endif()
    set(spirv ${CMAKE_BINARY_DIR}/twins/${name}.spv)
    if(path MATCHES "\\.frag$")
      string(REGEX REPLACE "\\.frag$" "" path ${path})
      string(REGEX REPLACE "\\.frag$" "" name ${name})
      list(PREPEND spirv ${CMAKE_BINARY_DIR}/twins/${name}.vert.spv)
    endif()
    set(header ${CMAKE_BINARY_DIR}/layouts/twins/${name}.h)
    add_custom_command(OUTPUT ${header} COMMAND plumb_twin_layout ${path} ${header} ${spirv}
      DEPENDS plumb_twin_layout ${spirv} VERBATIM)
    list(APPEND headers ${header})
  endforeach()
  # A member of a block that no twin reads breaks the build.
  set(checked ${CMAKE_BINARY_DIR}/layouts/${target}.checked)
  add_custom_command(OUTPUT ${checked} COMMAND plumb_twin_layout --unread ${all}
    COMMAND ${CMAKE_COMMAND} -E touch ${checked} DEPENDS plumb_twin_layout ${all} VERBATIM)
  target_sources(${target} PRIVATE ${checked})
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/layouts/twins)
  target_sources(${target} PRIVATE ${headers})
  target_include_directories(${target} PRIVATE ${CMAKE_BINARY_DIR}/layouts)
endfunction()

# The same twin with its taps: preprocessed with TAP() left as it is, its sites numbered (tools/twins/number_taps.cpp),
# and compiled. <build>/twins/tapped/<name>: the numbered text; .spv; .names: a site's name a line.
function(plumb_tap_twin file name)
  set(tapped ${CMAKE_BINARY_DIR}/twins/tapped/${name})
  add_custom_command(OUTPUT ${tapped}.spv ${tapped}.names
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/twins/tapped
    COMMAND ${GLSLANG} -E -DPLUMB_TAPS -I${PROJECT_SOURCE_DIR} ${file} > ${tapped}.preprocessed
    COMMAND plumb_number_taps ${tapped}.preprocessed ${tapped} ${tapped}.names
    COMMAND ${GLSLANG} -V --quiet --target-env vulkan1.1 -o ${tapped}.spv ${tapped}
    COMMAND ${SPIRV_VAL} --target-env vulkan1.1 ${tapped}.spv
    DEPENDS ${file} ${PLUMB_TWIN_INCLUDES} plumb_number_taps VERBATIM)
endfunction()

# The same twin storing its discrete choices: CHOICE() of core/tap.glsl.
function(plumb_choosing_twin file spirv)
  get_filename_component(folder ${spirv} DIRECTORY)
  add_custom_command(OUTPUT ${spirv}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${folder}
    COMMAND ${GLSLANG} -V --quiet --target-env vulkan1.1 -DPLUMB_CHOICES -I${PROJECT_SOURCE_DIR} -o ${spirv} ${file}
    COMMAND ${SPIRV_VAL} --target-env vulkan1.1 ${spirv}
    DEPENDS ${file} ${PLUMB_TWIN_INCLUDES} VERBATIM)
endfunction()

# plumb_embed_twins(<target>): every twin of raster and gi and every probe, plain and tapped, as a source of the target:
# what tools/vulkan/twins.h finds. With PLUMB_COMPILE_TWINS off the table is empty.
function(plumb_embed_twins target)
  set(source ${CMAKE_BINARY_DIR}/twins/embedded_twins.cpp)
  if(NOT PLUMB_COMPILE_TWINS)
    set(source ${CMAKE_BINARY_DIR}/twins/no_twins.cpp)
    file(WRITE ${source} "#include \"tools/vulkan/embedded_twins.h\"\n\n"
      "std::span<const plumb::vulkan::EmbeddedTwin> plumb::vulkan::embedded_twins() { return {}; }\n")
    target_sources(${target} PRIVATE ${source})
    return()
  endif()

  add_executable(plumb_number_taps ${PROJECT_SOURCE_DIR}/tools/twins/number_taps.cpp)
  add_executable(plumb_embed_spirv ${PROJECT_SOURCE_DIR}/tools/twins/embed_twins.cpp)
  foreach(program plumb_number_taps plumb_embed_spirv)
    target_link_libraries(${program} PRIVATE plumb_warnings)
  endforeach()
  foreach(folder raster gi tools/probe)
    foreach(stage comp vert frag)
      file(GLOB_RECURSE found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.${stage})
      list(APPEND twins ${found})
    endforeach()
  endforeach()
  foreach(file IN LISTS twins)
    file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${file})
    string(REPLACE "/" "." name ${path})
    set(spirv ${CMAKE_BINARY_DIR}/twins/${name}.spv)
    set(tapped ${CMAKE_BINARY_DIR}/twins/tapped/${name})
    plumb_tap_twin(${file} ${name})
    set(choosing -)
    if(file MATCHES "\\.comp$")
      set(choosing ${CMAKE_BINARY_DIR}/twins/choosing/${name}.spv)
      plumb_choosing_twin(${file} ${choosing})
      list(APPEND compiled ${choosing})
    endif()
    list(APPEND arguments ${path} ${spirv} ${tapped}.spv ${tapped}.names ${choosing})
    list(APPEND compiled ${spirv} ${tapped}.spv ${tapped}.names)
  endforeach()
  add_custom_command(OUTPUT ${source} COMMAND plumb_embed_spirv ${source} ${arguments}
    DEPENDS ${compiled} plumb_embed_spirv VERBATIM)
  target_sources(${target} PRIVATE ${source})
  add_dependencies(${target} plumb_raster_twins plumb_gi_twins plumb_probe_twins)
endfunction()
