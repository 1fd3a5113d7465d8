# The program as its user meets it.
if(TARGET plumb)
  add_test(NAME same_bits COMMAND ${CMAKE_CURRENT_LIST_DIR}/same_bits.sh ${CMAKE_BINARY_DIR}/same_bits $<TARGET_FILE:plumb>)

  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
  add_executable(test_program ${sources})
  add_dependencies(test_program plumb)
  target_link_libraries(test_program PRIVATE plumb_catch_main plumb_warnings plumb::io nlohmann_json::nlohmann_json)
  target_precompile_headers(test_program PRIVATE <catch2/catch.hpp>)
  target_compile_definitions(test_program PRIVATE PLUMB_PROGRAM="$<TARGET_FILE:plumb>"
    PLUMB_BINARY_DIR="${CMAKE_BINARY_DIR}")
  foreach(area IN ITEMS usage devices probe_device render frames truth sweep compare explain explain_device export validate malformed
    refusals pov stability experiment_vrsm batch experiment_isr)
    # One test a file, so that they run side by side.
    add_test(NAME program_${area} COMMAND test_program -\# [\#test_${area}])
  endforeach()
endif()
