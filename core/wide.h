// Wide: as many floats as the instruction set of this file has lanes, behind the interface of core/number.h.
//
// Only kernel files (*_isa.cpp) include this header. It is compiled once per instruction set, each time into a namespace
// of its own (plumb::sse, plumb::avx2, plumb::avx512), so that no linker can mistake one copy for another. What differs
// between the sets is in native_<set>.h: a dozen and a half functions. In the scalar set, and outside kernels, Real is
// float.
#pragma once

#include "core/number.h"

#ifndef PLUMB_ISA
#error "core/wide.h is for kernel files, which cmake/kernels.cmake compiles with PLUMB_ISA"
#endif

#if defined(__AVX512F__)
#include "core/native_avx512.h"
#elif defined(__AVX2__)
#include "core/native_avx2.h"
#elif defined(__SSE4_2__)
#include "core/native_sse.h"
#else
namespace plumb::PLUMB_ISA {
using Real = float;
}
#define PLUMB_NO_WIDE
#endif

#ifndef PLUMB_NO_WIDE

namespace plumb::PLUMB_ISA {

struct WideMask {
    native::Mask m;
    friend PLUMB_INLINE WideMask operator&(WideMask a, WideMask b) { return {native::mask_and(a.m, b.m)}; }
    friend PLUMB_INLINE WideMask operator|(WideMask a, WideMask b) { return {native::mask_or(a.m, b.m)}; }
    friend PLUMB_INLINE WideMask operator!(WideMask a) { return {native::mask_not(a.m)}; }
    friend PLUMB_INLINE bool any(WideMask a) { return native::any(a.m); }
};

struct WideIndex {
    native::Int v;
    WideIndex() = default;
    PLUMB_INLINE WideIndex(native::Int x) : v(x) {}
    PLUMB_INLINE WideIndex(native::UInt x) : v((native::Int)x) {}
    PLUMB_INLINE WideIndex(std::int32_t x) : v(native::Int{} + x) {}

    // Sums, products and shifts go through unsigned lanes: they wrap.
    friend PLUMB_INLINE WideIndex operator+(WideIndex a, WideIndex b) { return native::UInt(a.v) + native::UInt(b.v); }
    friend PLUMB_INLINE WideIndex operator-(WideIndex a, WideIndex b) { return native::UInt(a.v) - native::UInt(b.v); }
    friend PLUMB_INLINE WideIndex operator*(WideIndex a, WideIndex b) { return native::UInt(a.v) * native::UInt(b.v); }
    friend PLUMB_INLINE WideIndex operator&(WideIndex a, WideIndex b) { return a.v & b.v; }
    friend PLUMB_INLINE WideIndex operator|(WideIndex a, WideIndex b) { return a.v | b.v; }
    friend PLUMB_INLINE WideIndex operator^(WideIndex a, WideIndex b) { return a.v ^ b.v; }
    friend PLUMB_INLINE WideIndex operator~(WideIndex a) { return ~a.v; }
    friend PLUMB_INLINE WideIndex operator<<(WideIndex a, int n) { return native::UInt(a.v) << unsigned(n); }
    friend PLUMB_INLINE WideIndex operator>>(WideIndex a, int n) { return a.v >> n; }
    friend PLUMB_INLINE WideIndex shift_right(WideIndex a, int n) { return native::UInt(a.v) >> unsigned(n); }
    friend PLUMB_INLINE WideIndex operator<<(WideIndex a, WideIndex n) { return native::UInt(a.v) << native::UInt(n.v); }
    friend PLUMB_INLINE WideIndex shift_right(WideIndex a, WideIndex n) {
        return native::UInt(a.v) >> native::UInt(n.v);
    }
    friend PLUMB_INLINE WideMask operator<(WideIndex a, WideIndex b) { return {native::less(a.v, b.v)}; }
    friend PLUMB_INLINE WideMask operator>(WideIndex a, WideIndex b) { return b < a; }
    friend PLUMB_INLINE WideMask operator<=(WideIndex a, WideIndex b) { return !(b < a); }
    friend PLUMB_INLINE WideMask operator>=(WideIndex a, WideIndex b) { return !(a < b); }
    friend PLUMB_INLINE WideMask operator==(WideIndex a, WideIndex b) { return {native::equal(a.v, b.v)}; }
    friend PLUMB_INLINE WideMask in_range(WideIndex i, WideIndex n) { return {native::less_unsigned(i.v, n.v)}; }
    friend PLUMB_INLINE WideIndex select(WideMask m, WideIndex a, WideIndex b) { return native::select(m.m, a.v, b.v); }
    friend PLUMB_INLINE WideIndex min(WideIndex a, WideIndex b) { return native::min(a.v, b.v); }
    friend PLUMB_INLINE WideIndex max(WideIndex a, WideIndex b) { return native::max(a.v, b.v); }
};

struct Wide {
    native::Real v;
    Wide() = default;
    PLUMB_INLINE Wide(native::Real x) : v(x) {}
    PLUMB_INLINE Wide(float x) : v(native::splat(x)) {}
    PLUMB_INLINE explicit Wide(double x) : v(native::splat(float(x))) {}
    PLUMB_INLINE explicit Wide(int x) : v(native::splat(float(x))) {}

    friend PLUMB_INLINE Wide operator+(Wide a, Wide b) { return a.v + b.v; }
    friend PLUMB_INLINE Wide operator-(Wide a, Wide b) { return a.v - b.v; }
    friend PLUMB_INLINE Wide operator*(Wide a, Wide b) { return a.v * b.v; }
    friend PLUMB_INLINE Wide operator/(Wide a, Wide b) { return a.v / b.v; }
    friend PLUMB_INLINE Wide operator-(Wide a) { return native::negate(a.v); }
    PLUMB_INLINE Wide& operator+=(Wide b) { return v = v + b.v, *this; }
    PLUMB_INLINE Wide& operator-=(Wide b) { return v = v - b.v, *this; }
    PLUMB_INLINE Wide& operator*=(Wide b) { return v = v * b.v, *this; }
    PLUMB_INLINE Wide& operator/=(Wide b) { return v = v / b.v, *this; }
    friend PLUMB_INLINE WideMask operator<(Wide a, Wide b) { return {native::less(a.v, b.v)}; }
    friend PLUMB_INLINE WideMask operator<=(Wide a, Wide b) { return {native::less_equal(a.v, b.v)}; }
    friend PLUMB_INLINE WideMask operator>(Wide a, Wide b) { return b < a; }
    friend PLUMB_INLINE WideMask operator>=(Wide a, Wide b) { return b <= a; }
    friend PLUMB_INLINE WideMask operator==(Wide a, Wide b) { return {native::equal(a.v, b.v)}; }
    friend PLUMB_INLINE Wide select(WideMask m, Wide a, Wide b) { return native::select(m.m, a.v, b.v); }
    // The processor's min and max return their second operand when the comparison fails: hence the order.
    friend PLUMB_INLINE Wide min(Wide a, Wide b) { return native::min(b.v, a.v); }
    friend PLUMB_INLINE Wide max(Wide a, Wide b) { return native::max(b.v, a.v); }
    friend PLUMB_INLINE Wide abs(Wide a) { return native::abs(a.v); }
    friend PLUMB_INLINE Wide sqrt(Wide a) { return native::sqrt(a.v); }
    friend PLUMB_INLINE Wide floor(Wide a) { return native::floor(a.v); }
};

using Real = Wide;

}  // namespace plumb::PLUMB_ISA

namespace plumb {

template <>
struct number<PLUMB_ISA::Wide> {
    using F = PLUMB_ISA::Wide;
    using mask = PLUMB_ISA::WideMask;
    using index = PLUMB_ISA::WideIndex;
    static constexpr int width = PLUMB_ISA::native::width;

    static PLUMB_INLINE index iota(int first) { return PLUMB_ISA::native::iota() + first; }
    static PLUMB_INLINE F from_index(index i) { return PLUMB_ISA::native::from_int(i.v); }
    static PLUMB_INLINE index round_to_index(F x) { return PLUMB_ISA::native::round_to_int(x.v); }
    static PLUMB_INLINE index truncate_to_index(F x) { return PLUMB_ISA::native::truncate_to_int(x.v); }
    static PLUMB_INLINE index bits(F x) { return (PLUMB_ISA::native::Int)x.v; }
    static PLUMB_INLINE F from_bits(index i) { return (PLUMB_ISA::native::Real)i.v; }

    static PLUMB_INLINE F fetch(const float* p, index i) { return PLUMB_ISA::native::gather(p, i.v); }
    static PLUMB_INLINE index fetch(const std::int32_t* p, index i) { return PLUMB_ISA::native::gather(p, i.v); }
    static PLUMB_INLINE F load(const float* p) {
        PLUMB_ISA::native::Real v;
        std::memcpy(&v, p, sizeof v);
        return v;
    }
    static PLUMB_INLINE void save(float* p, F value) { std::memcpy(p, &value.v, sizeof value.v); }
    template <class Component>
    static PLUMB_INLINE vec4<F> fetch4(const Component* p, index i) {
        PLUMB_ISA::native::Real t[4];
        PLUMB_ISA::native::load_texels(p, 4, i.v, t);
        return {F(t[0]), F(t[1]), F(t[2]), F(t[3])};
    }
    // The places of records i, and the records that lie there, counted from p.
    using places = PLUMB_ISA::native::Places;
    template <class Component>
    static PLUMB_INLINE places record_places(index i) {
        return places(i.v, record_stride * std::int64_t(sizeof(Component)));
    }
    template <class Component>
    static PLUMB_INLINE Record<F> fetch_record(const Component* p, index i) {
        return fetch_record(p, record_places<Component>(i));
    }
    template <class Component>
    static PLUMB_INLINE Record<F> fetch_record(const Component* p, const places& at) {
        PLUMB_ISA::native::Real t[12];
        PLUMB_ISA::native::load_records(p, at, t);
        return {{F(t[0]), F(t[1]), F(t[2]), F(t[3])},
                {F(t[4]), F(t[5]), F(t[6]), F(t[7])},
                {F(t[8]), F(t[9]), F(t[10]), F(t[11])}};
    }
    static PLUMB_INLINE void store(float* p, index i, F value, mask active) {
        const Lanes<float> v(canonical(value).v);
        const Lanes<std::int32_t> at(i.v), on(select(active, index(-1), index(0)).v);
        for (int k = 0; k < width; ++k)
            if (on.lane[k]) p[at.lane[k]] = v.lane[k];
    }
    static PLUMB_INLINE void store4(float* p, index i, const vec4<F>& value, mask active) {
        const PLUMB_ISA::native::Real t[4] = {canonical(value.x).v, canonical(value.y).v, canonical(value.z).v,
                                              canonical(value.w).v};
        if (!any(!active)) return PLUMB_ISA::native::store_texels(p, i.v, t);
        const Lanes<float> x(t[0]), y(t[1]), z(t[2]), w(t[3]);
        const Lanes<std::int32_t> at(i.v), on(select(active, index(-1), index(0)).v);
        for (int k = 0; k < width; ++k) {
            if (!on.lane[k]) continue;
            float* texel = p + 4 * std::ptrdiff_t(at.lane[k]);
            texel[0] = x.lane[k], texel[1] = y.lane[k], texel[2] = z.lane[k], texel[3] = w.lane[k];
        }
    }

  private:
    // Every NaN is stored as 7fc00000: compilers give it this sign or that.
    static PLUMB_INLINE F canonical(F value) { return select(value == value, value, F(__builtin_nanf(""))); }

    template <class T>
    struct Lanes {
        alignas(64) T lane[width];
        template <class V>
        PLUMB_INLINE explicit Lanes(V v) {
            std::memcpy(lane, &v, sizeof lane);
        }
    };
};

}  // namespace plumb

// GLM takes a number for a floating-point one when numeric_limits says that it is.
template <>
struct std::numeric_limits<plumb::PLUMB_ISA::Wide> {
    static constexpr bool is_specialized = true, is_iec559 = true, is_signed = true, is_integer = false;
};

#endif
