# Precompiled headers: those of the standard library and of packages, which do not change while somebody works here.
# A build without them (PLUMB_PRECOMPILE=OFF; tools/check --full makes one) finds the #include that a file forgot.
option(PLUMB_PRECOMPILE "Precompile the headers of others that most files include" ON)

# plumb_precompile(<target> <header>...): the headers below, and those that are named.
function(plumb_precompile target)
  if(PLUMB_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE <algorithm> <array> <cmath> <cstdint> <cstring> <filesystem> <functional>
      <limits> <map> <memory> <optional> <set> <string> <vector> <fmt/format.h> <glm/glm.hpp> ${ARGN})
  endif()
endfunction()
