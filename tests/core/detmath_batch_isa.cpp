#include "tests/core/detmath_batch.h"

#include "core/detmath.h"
#include "core/wide.h"

namespace plumb {
namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;

template <F (*function)(F)>
void apply(const float* x, float* result, int count) {
    for (int i = 0; i < count; i += N::width) {
        const index_t<F> lanes = N::iota(i);
        N::store(result, lanes, function(N::fetch(x, lanes)), lanes < index_t<F>(count));
    }
}

}  // namespace

template <>
void detmath_batch<Isa::PLUMB_ISA>(Elementary f, const float* x, const float* y, float* result, int count) {
    switch (f) {
        case Elementary::exp: return apply<detmath::exp<F>>(x, result, count);
        case Elementary::exp2: return apply<detmath::exp2<F>>(x, result, count);
        case Elementary::log: return apply<detmath::log<F>>(x, result, count);
        case Elementary::log2: return apply<detmath::log2<F>>(x, result, count);
        case Elementary::sin: return apply<detmath::sin<F>>(x, result, count);
        case Elementary::cos: return apply<detmath::cos<F>>(x, result, count);
        case Elementary::acos: return apply<detmath::acos<F>>(x, result, count);
        case Elementary::expm1: return apply<detmath::expm1<F>>(x, result, count);
        case Elementary::pow: break;
    }
    for (int i = 0; i < count; i += N::width) {
        const index_t<F> lanes = N::iota(i);
        N::store(result, lanes, detmath::pow(N::fetch(x, lanes), N::fetch(y, lanes)), lanes < index_t<F>(count));
    }
}

}  // namespace plumb
