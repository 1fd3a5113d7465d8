# How often the product spells a stage's name outside the stage's own folder, and branches on one. None may.
if(TARGET plumb)
  add_test(NAME seams COMMAND ${CMAKE_CURRENT_LIST_DIR}/count_spellings.sh ${PROJECT_SOURCE_DIR} $<TARGET_FILE:plumb> 0 0)
endif()
