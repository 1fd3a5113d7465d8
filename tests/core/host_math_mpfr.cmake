# host_math against MPFR, 2^22 inputs a function. Slow, so on its own; PLUMB_FULL=1 in the environment takes 2^26.
find_library(MPFR_LIBRARY mpfr)
find_library(GMP_LIBRARY gmp)
if(MPFR_LIBRARY AND GMP_LIBRARY)
  find_package(Threads REQUIRED)
  add_executable(test_host_math_mpfr ${CMAKE_CURRENT_LIST_DIR}/host_math_mpfr.cpp)
  target_link_libraries(test_host_math_mpfr PRIVATE plumb::core plumb_catch_main plumb_warnings
    ${MPFR_LIBRARY} ${GMP_LIBRARY} Threads::Threads)
  add_test(NAME host_math_mpfr COMMAND test_host_math_mpfr)
  set_tests_properties(host_math_mpfr PROPERTIES LABELS numbers PROCESSORS 2)
else()
  message(WARNING "MPFR not found: host_math is not measured")
endif()
