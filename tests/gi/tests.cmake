# Every floating-point operation of every twin is `precise`, with taps and without.
find_program(SPIRV_DIS spirv-dis)
if(PLUMB_COMPILE_TWINS AND GLSLANG AND SPIRV_DIS)
  add_test(NAME twins_precise COMMAND ${CMAKE_CURRENT_LIST_DIR}/check_precise.sh ${CMAKE_BINARY_DIR}/twins)
  if(TARGET plumb_vulkan)
    add_test(NAME twins_precise_tapped
      COMMAND ${CMAKE_CURRENT_LIST_DIR}/check_precise.sh ${CMAKE_BINARY_DIR}/twins/tapped)
  endif()
endif()

# Fewer scenes under the sanitizers than without, but where they watch everything.
if(PLUMB_SANITIZE AND NOT PLUMB_SANITIZE_TESTS)
  target_compile_definitions(test_gi PRIVATE PLUMB_FEW_SCENES)
endif()

# Eigen's decompositions are the truth that ours are held against.
target_link_libraries(test_gi PRIVATE Eigen3::Eigen)

# Of one buffer, a shader of raster and one of gi must say the same.
add_test(NAME gi_numbers_differ COMMAND plumb_twin_layout raster/mixed ${CMAKE_BINARY_DIR}/twins/mixed.h
  ${CMAKE_BINARY_DIR}/twins/raster.item.vert.spv ${CMAKE_BINARY_DIR}/twins/gi.isr.bounce.comp.spv)
set_tests_properties(gi_numbers_differ PROPERTIES LABELS unit
  PASS_REGULAR_EXPRESSION "twin layout: raster/mixed: binding 2 is buffer \"triangles\" of int in one shader")
