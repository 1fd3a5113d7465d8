# The parts of the program that can be tested without running it.
if(TARGET test_tools)
  target_link_libraries(test_tools PRIVATE plumb_parts)
  if(TARGET plumb_experiments)
    target_link_libraries(test_tools PRIVATE plumb_experiments)
  endif()
  # A page in a real browser, where one is installed.
  add_test(NAME page_in_browser COMMAND ${CMAKE_CURRENT_LIST_DIR}/page_in_browser.sh ${CMAKE_BINARY_DIR}
    $<TARGET_FILE:test_tools>)
  set_tests_properties(page_in_browser PROPERTIES SKIP_RETURN_CODE 77)
endif()
