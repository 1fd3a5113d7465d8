# Verdicts on GPU dumps in somebody else's test suite:
#
#     find_package(plumbline REQUIRED COMPONENTS validate)
#     plumbline_add_validation(NAME gather_is_right MANIFEST ${CMAKE_BINARY_DIR}/dumps/manifest.toml DEPENDS dump_gather)
#
#   NAME            the test's
#   MANIFEST        what was dumped, and how (`plumb validate --help`); relative to the current source folder
#   DEPENDS         tests that write the dumps: they run first, and where one fails there is no verdict
#   PROFILE         how the device rounds; the manifest's otherwise
#   MAX_AMBIGUOUS   share of a stage's pixels that may be ambiguous; the manifest's otherwise
#
# The test leaves <NAME>.html and <NAME>.xml (JUnit) in the current binary folder.
include_guard()

function(plumbline_add_validation)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME;MANIFEST;PROFILE;MAX_AMBIGUOUS" "DEPENDS")
  if(arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "plumbline_add_validation: what is ${arg_UNPARSED_ARGUMENTS}${arg_KEYWORDS_MISSING_VALUES}?")
  endif()
  foreach(needed IN ITEMS NAME MANIFEST)
    if(NOT arg_${needed})
      message(FATAL_ERROR "plumbline_add_validation: expected ${needed}")
    endif()
  endforeach()
  cmake_path(ABSOLUTE_PATH arg_MANIFEST BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  set(report ${CMAKE_CURRENT_BINARY_DIR}/${arg_NAME})
  set(options --html ${report}.html --junit ${report}.xml)
  if(DEFINED arg_PROFILE)
    list(APPEND options --profile ${arg_PROFILE})
  endif()
  if(DEFINED arg_MAX_AMBIGUOUS)
    list(APPEND options --max-ambiguous ${arg_MAX_AMBIGUOUS})
  endif()
  add_test(NAME ${arg_NAME} COMMAND ${plumbline_PROGRAM} validate ${arg_MANIFEST} ${options})

  # A test that writes dumps is a fixture: without it there is nothing to judge.
  foreach(test IN LISTS arg_DEPENDS)
    set_property(TEST ${test} APPEND PROPERTY FIXTURES_SETUP ${test})
    set_property(TEST ${arg_NAME} APPEND PROPERTY FIXTURES_REQUIRED ${test})
  endforeach()
endfunction()
