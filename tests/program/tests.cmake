# The program as its user meets it.
if(TARGET plumb)
  add_test(NAME same_bits COMMAND ${CMAKE_CURRENT_LIST_DIR}/same_bits.sh ${CMAKE_BINARY_DIR}/same_bits $<TARGET_FILE:plumb>)

  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/test_*.cpp)
  plumb_add_test_executable(test_program ${sources} ${CMAKE_CURRENT_LIST_DIR}/program.cpp)
  add_dependencies(test_program plumb)
  target_link_libraries(test_program PRIVATE plumb::io nlohmann_json::nlohmann_json)
  target_compile_definitions(test_program PRIVATE PLUMB_PROGRAM="$<TARGET_FILE:plumb>")
  plumb_add_test_entries(test_program program ${sources})
endif()
