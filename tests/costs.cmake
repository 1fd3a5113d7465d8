# Entries that take minutes start first: what is left for the end is short. Seconds, roughly.
foreach(cost IN ITEMS mutants=300 gi_pruning=180 detmath_mpfr=150 host_math_mpfr=120 parity_twins_run=100 same_bits=60 foreign_bugs=30)
  string(REPLACE "=" ";" cost ${cost})
  list(GET cost 0 entry)
  list(GET cost 1 seconds)
  if(TEST ${entry})
    set_tests_properties(${entry} PROPERTIES COST ${seconds})
  endif()
endforeach()
