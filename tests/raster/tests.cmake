# The scenes of data/, for the passes bound to their data.
target_link_libraries(test_raster PRIVATE plumb::io)

# Twins and what is said of them: where they differ, the build stops at a line that says where.
add_test(NAME raster_block_differs COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only -I${PROJECT_SOURCE_DIR}
  -I${CMAKE_BINARY_DIR}/layouts ${CMAKE_CURRENT_LIST_DIR}/block_differs.cpp)
set_tests_properties(raster_block_differs PROPERTIES LABELS unit
  PASS_REGULAR_EXPRESSION "raster/gbuffer: GBufferUniforms\\.eye")
set(twins ${CMAKE_BINARY_DIR}/twins)
add_test(NAME raster_shaders_differ COMMAND plumb_twin_layout raster/mixed ${twins}/mixed.h
  ${twins}/raster.gbuffer.frag.spv ${twins}/raster.rsm.frag.spv)
set_tests_properties(raster_shaders_differ PROPERTIES LABELS unit
  PASS_REGULAR_EXPRESSION "twin layout: raster/mixed: its shaders have different uniform blocks")
