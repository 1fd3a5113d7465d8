# The program as its user meets it.
if(TARGET plumb)
  add_test(NAME same_bits COMMAND ${CMAKE_CURRENT_LIST_DIR}/same_bits.sh ${CMAKE_BINARY_DIR}/same_bits $<TARGET_FILE:plumb>)
endif()
