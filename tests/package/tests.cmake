# The package as a user meets it: installed elsewhere, found by find_package, linked into a program outside the tree.
if(NOT PLUMB_SANITIZE)
  add_test(NAME package COMMAND ${CMAKE_COMMAND} -D BUILD=${CMAKE_BINARY_DIR} -D GENERATOR=${CMAKE_GENERATOR}
    -D COMPILER=${CMAKE_CXX_COMPILER} -D CONFIG=${CMAKE_BUILD_TYPE} -P ${CMAKE_CURRENT_LIST_DIR}/test_package.cmake)
endif()
