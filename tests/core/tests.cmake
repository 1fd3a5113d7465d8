include(${CMAKE_CURRENT_LIST_DIR}/host_math_mpfr.cmake OPTIONAL)
include(${CMAKE_CURRENT_LIST_DIR}/detmath_mpfr.cmake OPTIONAL)
