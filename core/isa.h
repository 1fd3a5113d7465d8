// Instruction sets that kernels are compiled for, and the choice among them at run time.
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/isa_name.h"

namespace plumb {

const char* isa_name(Isa isa);

// Whether this program has kernels for the set: for all of them, unless the build was told PLUMB_FEW_ISAS.
constexpr bool has_kernels([[maybe_unused]] Isa isa) {
#ifdef PLUMB_WITHOUT_sse
    if (isa == Isa::sse) return false;
#endif
#ifdef PLUMB_WITHOUT_avx2
    if (isa == Isa::avx2) return false;
#endif
#ifdef PLUMB_WITHOUT_avx512
    if (isa == Isa::avx512) return false;
#endif
    return true;
}

// The sets that this program has kernels for and that the processor and its operating system support, widest last. scalar
// is always among them.
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

[[noreturn]] void refuse_without_kernels(Isa isa);

template <Isa isa, class F>
decltype(auto) call_with(F&& f) {
    if constexpr (has_kernels(isa)) {
        return f(std::integral_constant<Isa, isa>{});
    } else {
        refuse_without_kernels(isa);
        return f(std::integral_constant<Isa, Isa::scalar>{});  // for its type
    }
}

// Calls f(std::integral_constant<Isa, isa>{}), so that f can name the kernel compiled for that set.
template <class F>
decltype(auto) dispatch(Isa isa, F&& f) {
    note_dispatch(isa);
    switch (isa) {
        case Isa::avx512: return call_with<Isa::avx512>(f);
        case Isa::avx2: return call_with<Isa::avx2>(f);
        case Isa::sse: return call_with<Isa::sse>(f);
        default: return call_with<Isa::scalar>(f);
    }
}

}  // namespace plumb
