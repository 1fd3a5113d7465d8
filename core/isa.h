// Instruction sets that kernels are compiled for, and the choice among them at run time.
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace plumb {

enum class Isa { scalar, sse, avx2, avx512 };

const char* isa_name(Isa isa);

// The sets this processor and its operating system support, widest last. scalar is always among them.
std::vector<Isa> supported_isas();
Isa best_isa();

// "auto" | "scalar" | "sse" | "avx2" | "avx512"; throws InputError for other names and for sets this machine lacks.
Isa parse_isa(const std::string& name);

// How a stage is run; never changes a bit of its result.
struct RunOptions {
    Isa isa = best_isa();
    int threads = 0;                       // 0: all
    std::function<void(double)> progress;  // called with the share that is done, by any thread; may be empty
};

// The set whose kernels the last dispatch() of this process chose: what run.json names.
Isa last_dispatched_isa();
void note_dispatch(Isa isa);

// Calls f(std::integral_constant<Isa, isa>{}), so that f can name the kernel compiled for that set.
template <class F>
decltype(auto) dispatch(Isa isa, F&& f) {
    note_dispatch(isa);
    switch (isa) {
        case Isa::avx512: return f(std::integral_constant<Isa, Isa::avx512>{});
        case Isa::avx2: return f(std::integral_constant<Isa, Isa::avx2>{});
        case Isa::sse: return f(std::integral_constant<Isa, Isa::sse>{});
        default: return f(std::integral_constant<Isa, Isa::scalar>{});
    }
}

}  // namespace plumb
