// The number layer: what a kernel may ask of its number type F.
//
// A kernel is one template over F. F is float or double (one pixel), avx512::Wide and its siblings (a packet of pixels,
// core/wide.h) or Bounded (a value with its error bound, core/bounded.h). Whatever differs between them is listed here:
//
//     mask_t<F>               result of a comparison; combine with & | !, ask with any(), use with select()
//     index_t<F>              32-bit integers, one a lane; they wrap as GLSL's do
//     number<F>::...          conversions, reads and writes of memory
//     select, min, max, ...   free functions, found by argument; in_range(i, n) for indices
//
// Semantics are those of GLSL, to the bit: min(a, b) is b < a ? b : a, max(a, b) is a < b ? b : a (so that a NaN in the
// second place loses), round is to nearest even.
#pragma once

#include <emmintrin.h>

#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>

#define PLUMB_INLINE inline __attribute__((always_inline))

namespace plumb {

template <class F>
struct number;
template <class F>
using mask_t = typename number<F>::mask;
template <class F>
using index_t = typename number<F>::index;

template <class F>
using vec2 = glm::vec<2, F, glm::defaultp>;
template <class F>
using vec3 = glm::vec<3, F, glm::defaultp>;
template <class F>
using vec4 = glm::vec<4, F, glm::defaultp>;

template <class I>
struct ivec2 {
    I x, y;
};

// A 16-bit float as it lies in memory.
struct Half {
    std::uint16_t bits;
};

// Three RGBA texels that lie side by side in one cache line (fp32: 64 bytes a record) or half of one (half: 32 bytes);
// the last quarter is padding. A gather reads a record whole: this is how it costs one line of cache.
template <class F>
struct Record {
    vec4<F> a, b, c;
};
inline constexpr int record_stride = 16;  // in components, for both kinds

// ---- float and double: one lane ---------------------------------------------------------------------------------------

PLUMB_INLINE float half_to_float(Half h) {
    const std::uint32_t sign = std::uint32_t(h.bits & 0x8000) << 16, magnitude = h.bits & 0x7fff;
    // A denormal half counts steps of 2^-24; any other moves its exponent from bias 15 to bias 127.
    const float denormal = float(magnitude) * 0x1p-24f;
    std::uint32_t bits = (magnitude << 13) + (112u << 23);
    if (magnitude >= 0x7c00) bits |= 0x7f800000;  // infinity and NaN
    if (magnitude < 0x0400) std::memcpy(&bits, &denormal, 4);
    bits |= sign;
    float f;
    std::memcpy(&f, &bits, 4);
    return f;
}

template <class T>
struct ScalarNumber {
    using mask = bool;
    using index = std::int32_t;
    static constexpr int width = 1;

    static PLUMB_INLINE index iota(int first) { return first; }
    static PLUMB_INLINE T from_index(index i) { return T(i); }
    static PLUMB_INLINE T fetch(const float* p, index i) { return T(p[i]); }
    static PLUMB_INLINE index fetch(const std::int32_t* p, index i) { return p[i]; }
    // As many floats as there are lanes, side by side; no alignment is asked for.
    static PLUMB_INLINE T load(const float* p) { return T(*p); }
    static PLUMB_INLINE void save(float* p, T value) { *p = float(value); }
    static PLUMB_INLINE T widen(float x) { return T(x); }
    static PLUMB_INLINE T widen(Half x) { return T(half_to_float(x)); }

    // The texel of four components at p + 4 i.
    template <class Component>
    static PLUMB_INLINE vec4<T> fetch4(const Component* p, index i) {
        return texel(p + 4 * std::ptrdiff_t(i));
    }
    template <class Component>
    static PLUMB_INLINE Record<T> fetch_record(const Component* p, index i) {
        p += record_stride * std::ptrdiff_t(i);
        return {texel(p), texel(p + 4), texel(p + 8)};
    }
    // Writes where `active`; rounds to float. Every NaN is stored as 7fc00000: compilers give it this sign or that.
    static PLUMB_INLINE void store(float* p, index i, T value, mask active) {
        if (active) p[i] = value == value ? float(value) : __builtin_nanf("");
    }
    static PLUMB_INLINE void store4(float* p, index i, const vec4<T>& value, mask active) {
        store(p, 4 * i + 0, value.x, active);
        store(p, 4 * i + 1, value.y, active);
        store(p, 4 * i + 2, value.z, active);
        store(p, 4 * i + 3, value.w, active);
    }

  private:
    template <class Component>
    static PLUMB_INLINE vec4<T> texel(const Component* p) {
        return {widen(p[0]), widen(p[1]), widen(p[2]), widen(p[3])};
    }
};

template <>
struct number<float> : ScalarNumber<float> {
    static PLUMB_INLINE index round_to_index(float x) { return _mm_cvtss_si32(_mm_set_ss(x)); }
    static PLUMB_INLINE index truncate_to_index(float x) { return _mm_cvttss_si32(_mm_set_ss(x)); }
    static PLUMB_INLINE index bits(float x) {
        index i;
        std::memcpy(&i, &x, 4);
        return i;
    }
    static PLUMB_INLINE float from_bits(index i) {
        float x;
        std::memcpy(&x, &i, 4);
        return x;
    }
};

template <>
struct number<double> : ScalarNumber<double> {
    static PLUMB_INLINE index round_to_index(double x) { return _mm_cvtsd_si32(_mm_set_sd(x)); }
    static PLUMB_INLINE index truncate_to_index(double x) { return _mm_cvttsd_si32(_mm_set_sd(x)); }
};

PLUMB_INLINE float select(bool m, float a, float b) { return m ? a : b; }
PLUMB_INLINE double select(bool m, double a, double b) { return m ? a : b; }
PLUMB_INLINE std::int32_t select(bool m, std::int32_t a, std::int32_t b) { return m ? a : b; }
PLUMB_INLINE bool any(bool m) { return m; }

PLUMB_INLINE float min(float a, float b) { return b < a ? b : a; }
PLUMB_INLINE float max(float a, float b) { return a < b ? b : a; }
PLUMB_INLINE double min(double a, double b) { return b < a ? b : a; }
PLUMB_INLINE double max(double a, double b) { return a < b ? b : a; }
PLUMB_INLINE std::int32_t min(std::int32_t a, std::int32_t b) { return b < a ? b : a; }
PLUMB_INLINE std::int32_t max(std::int32_t a, std::int32_t b) { return a < b ? b : a; }

PLUMB_INLINE float abs(float a) { return __builtin_fabsf(a); }
PLUMB_INLINE double abs(double a) { return __builtin_fabs(a); }
PLUMB_INLINE float sqrt(float a) { return _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(a))); }
PLUMB_INLINE double sqrt(double a) { return __builtin_sqrt(a); }
PLUMB_INLINE float floor(float a) { return __builtin_floorf(a); }
PLUMB_INLINE double floor(double a) { return __builtin_floor(a); }

// 0 <= i < n, for n > 0: one comparison of unsigned numbers.
PLUMB_INLINE bool in_range(std::int32_t i, std::int32_t n) { return std::uint32_t(i) < std::uint32_t(n); }

// Logical shift: zeros come in from the left.
PLUMB_INLINE std::int32_t shift_right(std::int32_t a, int n) { return std::int32_t(std::uint32_t(a) >> n); }

// a * b + c, rounded once, without the processor's fma: the product of two floats is exact in double; the sum is rounded
// to odd, so that the second rounding, to float, sees on which side of a tie it lies (Boldo and Melquiond 2008,
// "Emulation of a FMA and correctly rounded sums"). Only a device profile's rasterisation asks for it.
PLUMB_INLINE float fused(float a, float b, float c) {
    const double product = double(a) * double(b), addend = c;
    const double sum = product + addend;
    const double from_product = sum - addend, from_addend = sum - from_product;
    const double error = (product - from_product) + (addend - from_addend);
    std::int64_t bits;
    std::memcpy(&bits, &sum, 8);
    // Where the sum is inexact and its last bit even, its neighbour on the side of the error is odd.
    if (error != 0 && error == error && (bits & 1) == 0 && sum - sum == 0) bits += ((error > 0) == (sum > 0)) ? 1 : -1;
    double odd;
    std::memcpy(&odd, &bits, 8);
    return float(odd);
}

// ---- for every F ------------------------------------------------------------------------------------------------------

// Dots are written out, left to right, because compilers of shaders treat dot() as theirs to rearrange.
template <class F>
PLUMB_INLINE F dot3(const vec3<F>& a, const vec3<F>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class F>
PLUMB_INLINE vec3<F> xyz(const vec4<F>& v) {
    return {v.x, v.y, v.z};
}
template <class F>
PLUMB_INLINE F clamp(F x, F low, F high) {
    return min(max(x, low), high);
}
// v / sqrt(v . v), by division: what normalize() is on the drivers that were measured.
template <class F>
PLUMB_INLINE vec3<F> normalize3(const vec3<F>& v) {
    const F length = sqrt(dot3(v, v));
    return {v.x / length, v.y / length, v.z / length};
}
template <class F, class V>
PLUMB_INLINE vec3<F> splat3(const V& v) {
    return {F(v.x), F(v.y), F(v.z)};
}
template <class F>
PLUMB_INLINE vec3<F> select3(const mask_t<F>& m, const vec3<F>& a, const vec3<F>& b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}

}  // namespace plumb
