// The instruction sets by name, for kernel files.
#pragma once

namespace plumb {

enum class Isa { scalar, sse, avx2, avx512 };

}  // namespace plumb
