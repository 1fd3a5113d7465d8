# The parts of the program that can be tested without running it.
if(TARGET test_tools)
  target_sources(test_tools PRIVATE ${PROJECT_SOURCE_DIR}/tools/plumb/options.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/progress.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/reference_files.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/reports.cpp ${PROJECT_SOURCE_DIR}/tools/plumb/table.cpp
    ${PROJECT_SOURCE_DIR}/tools/plumb/truth.cpp)
endif()
