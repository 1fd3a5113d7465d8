# Flags that every object shares. They are part of the promise of equal bits: no contraction, no reassociation, and
# integers that wrap as GLSL's do.
add_library(plumb_flags INTERFACE)
target_compile_features(plumb_flags INTERFACE cxx_std_20)
target_compile_options(plumb_flags INTERFACE
  -ffp-contract=off -fno-math-errno -fno-trapping-math -fwrapv -fno-fast-math)
# Eigen takes an allocator of its own where it sees the address sanitizer; tests without it share its inline functions.
target_compile_definitions(plumb_flags INTERFACE GLM_FORCE_INLINE GLM_FORCE_XYZW_ONLY EIGEN_MALLOC_ALREADY_ALIGNED=1)

add_library(plumb_warnings INTERFACE)
target_compile_options(plumb_warnings INTERFACE -Wall -Wextra -Wno-unknown-pragmas -Wno-ignored-attributes
  -Wno-psabi
  # A mask of the scalar kernels is a bool; `&` of masks has no branch.
  $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>)

# -O2 also where CMake's default would be -O3: one optimisation level, in every configuration that optimises.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g")

option(PLUMB_SANITIZE "Build with the address and undefined-behaviour sanitizers" OFF)
if(PLUMB_SANITIZE)
  # Half the time to compile; traces keep their lines.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()

option(PLUMB_FUZZ "Build what tests/fuzz runs: clang, libFuzzer's coverage and both sanitizers in every object" OFF)
if(PLUMB_FUZZ)
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1")
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
