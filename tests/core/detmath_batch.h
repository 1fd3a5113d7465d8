// core/detmath.h applied to arrays, compiled for every instruction set.
#pragma once

#include "core/isa.h"

namespace plumb {

enum class Elementary { exp, exp2, log, log2, sin, cos, acos, pow, expm1 };
inline constexpr const char* elementary_names[] = {"exp", "exp2", "log", "log2", "sin", "cos", "acos", "pow",
                                                  "expm1"};
inline constexpr int elementary_count = 9;

// result[i] = f(x[i]), or pow(x[i], y[i]); count is a multiple of 16.
template <Isa isa>
void detmath_batch(Elementary f, const float* x, const float* y, float* result, int count);

template <>
void detmath_batch<Isa::scalar>(Elementary, const float*, const float*, float*, int);
template <>
void detmath_batch<Isa::sse>(Elementary, const float*, const float*, float*, int);
template <>
void detmath_batch<Isa::avx2>(Elementary, const float*, const float*, float*, int);
template <>
void detmath_batch<Isa::avx512>(Elementary, const float*, const float*, float*, int);

inline void detmath_batch(Isa isa, Elementary f, const float* x, const float* y, float* result, int count) {
    dispatch(isa, [&](auto set) { detmath_batch<set.value>(f, x, y, result, count); });
}

}  // namespace plumb
