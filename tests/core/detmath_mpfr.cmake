# detmath against MPFR. PLUMB_FULL=1 in the environment takes all floats instead of 2^24 inputs a function.
find_library(MPFR_LIBRARY mpfr)
find_library(GMP_LIBRARY gmp)
if(MPFR_LIBRARY AND GMP_LIBRARY)
  add_executable(test_detmath_mpfr ${CMAKE_CURRENT_LIST_DIR}/detmath_mpfr.cpp)
  target_link_libraries(test_detmath_mpfr PRIVATE plumb::core plumb_catch_main plumb_warnings
    ${MPFR_LIBRARY} ${GMP_LIBRARY} Threads::Threads)
  plumb_add_kernels(test_detmath_mpfr ${CMAKE_CURRENT_LIST_DIR}/detmath_batch_isa.cpp)
  add_test(NAME detmath_mpfr COMMAND test_detmath_mpfr)
  set_tests_properties(detmath_mpfr PROPERTIES LABELS unit PROCESSORS 2)
else()
  message(WARNING "MPFR not found: detmath is not measured")
endif()

# The twin of core/detmath.h, compiled on its own.
plumb_compile_twins(twins_detmath ${CMAKE_CURRENT_LIST_DIR}/detmath.comp)

# The same bits and the same hashes where the C library believes that the processor has neither AVX2 nor FMA.
if(TARGET test_core)
  add_test(NAME core_without_avx2_and_fma COMMAND test_core "[number],[detmath],[host_math]")
  set_tests_properties(core_without_avx2_and_fma PROPERTIES LABELS unit ENVIRONMENT
    "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA")
endif()
