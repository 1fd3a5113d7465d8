# The GLSL twins that lie beside their kernels are compiled to SPIR-V and validated; a twin that does not compile breaks
# the build.
find_program(GLSLANG glslangValidator)
find_program(SPIRV_VAL spirv-val)

# plumb_compile_twins(<target> <file>...): SPIR-V of each file, under <build>/twins, as part of the target ALL.
function(plumb_compile_twins target)
  if(NOT PLUMB_COMPILE_TWINS OR NOT ARGN)
    return()
  endif()
  if(NOT GLSLANG OR NOT SPIRV_VAL)
    message(WARNING "glslangValidator or spirv-val not found: the GLSL twins are not compiled")
    return()
  endif()
  file(GLOB_RECURSE includes CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/core/*.glsl ${PROJECT_SOURCE_DIR}/raster/*.glsl
    ${PROJECT_SOURCE_DIR}/gi/*.glsl)
  foreach(file IN LISTS ARGN)
    file(RELATIVE_PATH name ${PROJECT_SOURCE_DIR} ${file})
    string(REPLACE "/" "." name ${name})
    set(spirv ${CMAKE_BINARY_DIR}/twins/${name}.spv)
    add_custom_command(OUTPUT ${spirv}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/twins
      COMMAND ${GLSLANG} -V --quiet --target-env vulkan1.1 -I${PROJECT_SOURCE_DIR} -o ${spirv} ${file}
      COMMAND ${SPIRV_VAL} --target-env vulkan1.1 ${spirv}
      DEPENDS ${file} ${includes} VERBATIM)
    list(APPEND outputs ${spirv})
  endforeach()
  add_custom_target(${target} ALL DEPENDS ${outputs})
endfunction()
