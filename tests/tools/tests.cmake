# The parts of the program that can be tested without running it.
if(TARGET test_tools)
  target_sources(test_tools PRIVATE ${PROJECT_SOURCE_DIR}/tools/plumb/explain_marks.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/explain_page.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/explain_pictures.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/explain_samples.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/options.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/progress.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/reference_files.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/reports.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/sweep_curves.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/sweep_page.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/sweep_report.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/sweep_stats.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/table.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/truth.cpp)
  target_link_libraries(test_tools PRIVATE plumb_page)
  # A page in a real browser, where one is installed.
  add_test(NAME page_in_browser COMMAND ${CMAKE_CURRENT_LIST_DIR}/page_in_browser.sh ${CMAKE_BINARY_DIR}
    $<TARGET_FILE:test_tools>)
  set_tests_properties(page_in_browser PROPERTIES SKIP_RETURN_CODE 77)
endif()
