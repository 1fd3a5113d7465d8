# How a test executable is built, and how it comes to an entry of ctest a file.

option(PLUMB_SANITIZE_TESTS "With PLUMB_SANITIZE, also watch the test files, not only what they test" OFF)

# Less optimisation for a test file, which seldom computes much, halves its time to compile; unwatched, it takes a quarter.
# Kernels and libraries are compiled as ever.
add_library(plumb_test_flags INTERFACE)
target_compile_options(plumb_test_flags INTERFACE $<$<CONFIG:Release>:-O1>
  # GCC 12 warns of its own strings when it optimises that little.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds> $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
if(PLUMB_SANITIZE)
  target_compile_definitions(plumb_test_flags INTERFACE PLUMB_SANITIZED)  # also where the test files are not
endif()
if(PLUMB_SANITIZE AND NOT PLUMB_SANITIZE_TESTS)
  target_compile_options(plumb_test_flags INTERFACE -fno-sanitize=all)
endif()

# One precompiled header for all of them, compiled as an executable's file is.
if(PLUMB_PRECOMPILE)
  add_library(plumb_test_headers OBJECT test_headers.cpp)
  set_target_properties(plumb_test_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(plumb_test_headers PRIVATE -fPIE)
  target_link_libraries(plumb_test_headers PRIVATE plumb_catch_main plumb_warnings plumb::core plumb_test_flags)
  plumb_precompile(plumb_test_headers <catch2/catch.hpp>)
endif()

# plumb_add_test_executable(<name> <file>...)
function(plumb_add_test_executable name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE plumb_catch_main plumb_warnings plumb_test_flags plumb::core)
  target_compile_definitions(${name} PRIVATE PLUMB_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    PLUMB_BINARY_DIR="${CMAKE_BINARY_DIR}")
  if(PLUMB_PRECOMPILE)
    target_precompile_headers(${name} REUSE_FROM plumb_test_headers)
  endif()
  set_property(GLOBAL APPEND PROPERTY PLUMB_TEST_EXECUTABLES ${name})
endfunction()

# plumb_add_test_entries(<executable> <prefix> <file>...): an entry <prefix>_<x> for each file test_<x>.cpp, so that they
# run side by side, and one that finds test cases of no entry or of two. Names them all in tests_<prefix>.
function(plumb_add_test_entries executable prefix)
  foreach(file IN LISTS ARGN)
    cmake_path(GET file STEM stem)
    string(REGEX REPLACE "^test_" "" name ${stem})
    # A tag selects hidden cases too: they stay hidden.
    add_test(NAME ${prefix}_${name} COMMAND ${executable} -\# [\#${stem}]~[.])
    list(APPEND entries ${prefix}_${name})
    list(APPEND stems ${stem})
  endforeach()
  add_test(NAME ${prefix}_cases COMMAND ${PROJECT_SOURCE_DIR}/tests/same_cases.sh $<TARGET_FILE:${executable}> ${stems})
  set(tests_${prefix} ${entries} ${prefix}_cases PARENT_SCOPE)
endfunction()

# One executable a folder: tests/<folder>/test_*.cpp, and tests/<folder>/*_isa.cpp as kernels.
function(plumb_add_tests folder)
  set(directory ${PROJECT_SOURCE_DIR}/tests/${folder})
  file(GLOB sources CONFIGURE_DEPENDS ${directory}/test_*.cpp)
  list(FILTER sources EXCLUDE REGEX "_isa\\.cpp$")
  file(GLOB kernels CONFIGURE_DEPENDS ${directory}/*_isa.cpp)
  if(NOT sources)
    return()
  endif()
  plumb_add_test_executable(test_${folder} ${sources})
  target_link_libraries(test_${folder} PRIVATE ${ARGN})
  plumb_add_kernels(test_${folder} ${kernels})
  # What needs a driver is not among the tests that are watched by sanitizers: drivers leak.
  if(NOT folder MATCHES "^(foreign|parity|vulkan)$")
    add_dependencies(unit_tests test_${folder})
  endif()
  plumb_add_test_entries(test_${folder} ${folder} ${sources})
  set_tests_properties(${tests_${folder}} PROPERTIES LABELS unit)
  set(tests_${folder} ${tests_${folder}} PARENT_SCOPE)
endfunction()

# The static libraries of this project that a target links, and theirs.
function(plumb_static_libraries target result)
  get_target_property(linked ${target} LINK_LIBRARIES)
  foreach(library IN LISTS linked)
    if(NOT TARGET ${library})
      continue()
    endif()
    get_target_property(original ${library} ALIASED_TARGET)
    if(original)
      set(library ${original})
    endif()
    get_target_property(type ${library} TYPE)
    get_target_property(imported ${library} IMPORTED)
    if(type STREQUAL "STATIC_LIBRARY" AND NOT imported AND NOT library STREQUAL "plumb_catch_main")
      plumb_static_libraries(${library} below)
      list(APPEND found ${library} ${below})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES found)
  set(${result} ${found} PARENT_SCOPE)
endfunction()

# A linker takes an inline function from the first object that has it. Libraries come first, so that tests run the copy
# that the program has, and not a test file's, which is less optimised or unwatched.
function(plumb_link_libraries_first)
  get_property(executables GLOBAL PROPERTY PLUMB_TEST_EXECUTABLES)
  foreach(executable IN LISTS executables)
    plumb_static_libraries(${executable} libraries)
    foreach(library IN LISTS libraries)
      target_link_options(${executable} BEFORE PRIVATE $<TARGET_FILE:${library}>)
      set_property(TARGET ${executable} APPEND PROPERTY LINK_DEPENDS $<TARGET_FILE:${library}>)
    endforeach()
    target_link_options(${executable} BEFORE PRIVATE LINKER:--whole-archive)
    target_link_options(${executable} PRIVATE LINKER:--no-whole-archive)
  endforeach()
endfunction()
