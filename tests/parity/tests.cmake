# The twins on a device, held against the kernels. Skipped, and said so, where the library, the driver or the shaders are
# not there.
if(TARGET plumb_vulkan)
  file(GLOB parity_shaders CONFIGURE_DEPENDS parity/*.vert parity/*.frag parity/*.comp)
  plumb_compile_twins(parity_shaders ${parity_shaders})
  plumb_add_tests(parity plumb_vulkan plumb::io plumb::gi)
endif()
if(TARGET test_parity)
  target_compile_definitions(test_parity PRIVATE PLUMB_SPIRV_DIR="${CMAKE_BINARY_DIR}/twins")
  # The generator of generic mutants, on a shader of its own with its lines.
  set(kinds tests/parity/mutants/generic/kinds.comp)
  set(kinds_spirv ${CMAKE_BINARY_DIR}/twins/kinds.lines.spv)
  if(GLSLANG AND SPIRV_VAL)
    add_custom_command(OUTPUT ${kinds_spirv}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/twins
      COMMAND ${GLSLANG} -V -g --quiet --target-env vulkan1.1 -o ${kinds_spirv} ${PROJECT_SOURCE_DIR}/${kinds}
      DEPENDS ${PROJECT_SOURCE_DIR}/${kinds} VERBATIM)
    add_custom_target(mutant_kinds DEPENDS ${kinds_spirv})
    add_dependencies(test_parity mutant_kinds)
    foreach(file spirv sites edit marks guards selectable generic survivors mutant)
      target_sources(test_parity PRIVATE ${PROJECT_SOURCE_DIR}/tools/mutants/${file}.cpp)
    endforeach()
    target_compile_definitions(test_parity PRIVATE PLUMB_MUTANT_KINDS="${kinds_spirv}" PLUMB_SPIRV_VAL="${SPIRV_VAL}")
  else()
    get_target_property(sources test_parity SOURCES)
    list(FILTER sources EXCLUDE REGEX "test_(generic_mutants|selectable)")
    set_target_properties(test_parity PROPERTIES SOURCES "${sources}")
  endif()
  foreach(shaders parity_shaders plumb_gi_twins plumb_raster_twins)
    if(TARGET ${shaders})
      add_dependencies(test_parity ${shaders})
    endif()
  endforeach()
  # lavapipe rasterises otherwise on a processor without fused multiply-adds: a device of its own.
  add_test(NAME parity_without_fma COMMAND test_parity "device raster*,probes*")
  set_tests_properties(parity_without_fma PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 3000
    ENVIRONMENT GALLIUM_OVERRIDE_CPU_CAPS=sse4.1)
  find_file(SWIFTSHADER_ICD vk_swiftshader_icd.json PATHS /usr/lib/chromium NO_DEFAULT_PATH)
  if(SWIFTSHADER_ICD)
    add_test(NAME parity_swiftshader COMMAND test_parity "device raster*,probes*,twins: every *")
    set_tests_properties(parity_swiftshader PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 3000
      ENVIRONMENT VK_ICD_FILENAMES=${SWIFTSHADER_ICD})
  endif()
else()
  add_test(NAME parity COMMAND ${CMAKE_COMMAND} -E echo "SKIPPED: built without Vulkan (libvulkan-dev)")
  set(tests_parity parity)
endif()
set_tests_properties(${tests_parity} PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 3000)

# Errors planted in twins, all of which the judge must find, and legal changes, none of which it may call wrong: of each stage
# a third that changes with the commit; PLUMB_FULL=1 runs all.
if(TARGET plumb_mutants)
  add_test(NAME mutants COMMAND plumb_mutants --lists ${PROJECT_SOURCE_DIR}/tests/parity/mutants
    --share 3 --seed commit --least-wrong 425 --least-a-stage 7 --least-legal 230)
  set_tests_properties(mutants PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 3000)
  # Errors made from the twins' SPIR-V: of each stage a sample that its text draws, so that it changes where the stage does and
  # nowhere else; PLUMB_FULL=1 runs all.
  add_test(NAME generic_mutants COMMAND plumb_mutants --generic --sample 8)
  set_tests_properties(generic_mutants PROPERTIES LABELS vulkan SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 3000)
endif()
