#include "core/isa.h"

#include <atomic>

#include "core/error.h"

namespace plumb {

const char* isa_name(Isa isa) {
    switch (isa) {
        case Isa::scalar: return "scalar";
        case Isa::sse: return "sse";
        case Isa::avx2: return "avx2";
        case Isa::avx512: return "avx512";
    }
    return "?";
}

std::vector<Isa> supported_isas() {
    std::vector<Isa> isas{Isa::scalar};
    auto add = [&](Isa isa, bool supported) {
        if (supported && has_kernels(isa)) isas.push_back(isa);
    };
    add(Isa::sse, __builtin_cpu_supports("sse4.2"));
    // f16c comes with every processor that has AVX2; GCC 12 cannot ask for it by name in clang's spelling.
    add(Isa::avx2, __builtin_cpu_supports("avx2"));
    add(Isa::avx512, __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"));
    return isas;
}

namespace {
std::atomic<Isa> dispatched{Isa::scalar};
}

Isa last_dispatched_isa() { return dispatched; }
void note_dispatch(Isa isa) { dispatched = isa; }

void refuse_without_kernels(Isa isa) {
    throw InputError(std::string("this program was built without kernels for ") + isa_name(isa));
}

Isa best_isa() { return supported_isas().back(); }

Isa parse_isa(const std::string& name) {
    if (name == "auto") return best_isa();
    for (Isa isa : {Isa::scalar, Isa::sse, Isa::avx2, Isa::avx512}) {
        if (name != isa_name(isa)) continue;
        for (Isa supported : supported_isas())
            if (supported == isa) return isa;
        if (!has_kernels(isa)) refuse_without_kernels(isa);
        throw InputError("--isa " + name + ": this processor does not have that instruction set");
    }
    throw InputError("--isa " + name + ": expected auto, scalar, sse, avx2 or avx512");
}

}  // namespace plumb
