# Kernel files (*_isa.cpp) are compiled once per instruction set. Each copy defines the specialisations for its own Isa,
# so the copies share no symbol; tests/objects checks that.
set(PLUMB_ISAS scalar sse avx2 avx512)
set(PLUMB_ISA_FLAGS_scalar "")
set(PLUMB_ISA_FLAGS_sse -msse4.2)
set(PLUMB_ISA_FLAGS_avx2 -mavx2 -mf16c -mno-fma)
set(PLUMB_ISA_FLAGS_avx512 -mavx512f -mavx512dq -mavx512bw -mavx512vl -mf16c -mno-fma -mprefer-vector-width=512 -mtune=icelake-server
  # GCC 12 warns of its own intrinsics (bug 105593).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized> $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)

# plumb_add_kernels(<target> <file>...): adds one object library per instruction set to <target>.
function(plumb_add_kernels target)
  if(NOT ARGN)
    return()
  endif()
  foreach(isa IN LISTS PLUMB_ISAS)
    set(objects ${target}_kernels_${isa})
    add_library(${objects} OBJECT ${ARGN})
    target_compile_definitions(${objects} PRIVATE PLUMB_ISA=${isa})
    target_compile_options(${objects} PRIVATE ${PLUMB_ISA_FLAGS_${isa}})
    if(PLUMB_SANITIZE)
      # A kernel inlined into its loop has thousands of scopes: to watch the end of each takes minutes to compile.
      target_compile_options(${objects} PRIVATE -fno-sanitize-address-use-after-scope)
    endif()
    target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${objects} PRIVATE plumb_flags plumb_warnings glm::glm)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
    set_property(GLOBAL APPEND PROPERTY PLUMB_KERNEL_OBJECTS_${isa} $<TARGET_OBJECTS:${objects}>)
  endforeach()
endfunction()
