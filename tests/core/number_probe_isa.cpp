#include "tests/core/number_probe.h"

#include "core/wide.h"

namespace plumb {
namespace {

using F = PLUMB_ISA::Real;
using I = index_t<F>;
using N = number<F>;

// One packet of elements, from `lanes` on, of every row.
struct Packet {
    const ProbeInput& in;
    ProbeOutput& out;
    I lanes;

    PLUMB_INLINE void put(int row, F value) const {
        N::store(out.reals + std::ptrdiff_t(row) * in.count, lanes, value, lanes < I(in.count));
    }
    PLUMB_INLINE void put4(int row, const vec4<F>& v) const {
        put(row, v.x), put(row + 1, v.y), put(row + 2, v.z), put(row + 3, v.w);
    }
    PLUMB_INLINE void put_record(int row, const Record<F>& r) const {
        put4(row, r.a), put4(row + 4, r.b), put4(row + 8, r.c);
    }
    // The layer stores floats alone: integers go through memory by their bits.
    PLUMB_INLINE void put(IntegerRow row, I value) const {
        std::memcpy(out.integers + std::ptrdiff_t(row) * in.count + first(), &value, sizeof value);
    }
    PLUMB_INLINE void put(IntegerRow row, mask_t<F> m) const { put(row, select(m, I(1), I(0))); }
    PLUMB_INLINE std::int32_t first() const {
        std::int32_t i;
        std::memcpy(&i, &lanes, 4);
        return i;
    }
};

void probe_reals(const Packet& p, F a, F b, F c, I at) {
    p.put(row_add, a + b), p.put(row_subtract, a - b), p.put(row_multiply, a * b), p.put(row_divide, a / b);
    p.put(row_negate, -a), p.put(row_abs, abs(a)), p.put(row_sqrt, sqrt(a)), p.put(row_floor, floor(a));
    p.put(row_min, min(a, b)), p.put(row_max, max(a, b)), p.put(row_clamp, clamp(a, b, c));
    p.put(row_select, select(a < b, a, c));
    F x = a;
    x += b, x *= c, x -= a, x /= b;
    p.put(row_assign, x);
    const vec3<F> u{a, b, c}, v{c, a, b};
    p.put(row_dot3, dot3(u, v)), p.put(row_normalize3, normalize3(u).y);
    p.put(row_from_index, N::from_index(N::bits(a))), p.put(row_from_bits, N::from_bits(N::bits(a) ^ I(1)));

    // Reads and writes of memory.
    p.put(row_fetch, N::fetch(p.in.a, at));
    p.put4(row_texel, N::fetch4(p.in.texels, at & I(16383)));
    p.put4(row_half_texel, N::fetch4(p.in.half_texels, at & I(16383)));
    p.put_record(row_record, N::fetch_record(p.in.texels, at & I(4095)));
    p.put_record(row_half_record, N::fetch_record(p.in.half_texels, at & I(4095)));
    const mask_t<F> active = (at < I(p.in.active)) & !(a < b);
    N::store(p.out.reals + std::ptrdiff_t(row_stored) * p.in.count, at, a, active);
    N::store4(p.out.reals + std::ptrdiff_t(row_stored4) * p.in.count, at, {a, b, c, a}, active);
    N::store4(p.out.reals + std::ptrdiff_t(row_stored4_whole) * p.in.count, at, {c, a, b, c}, I(0) < I(1));
}

void probe_conversions_and_comparisons(const Packet& p, F a, F b, F c) {
    p.put(row_round, N::round_to_index(a)), p.put(row_truncate, N::truncate_to_index(a)), p.put(row_bits, N::bits(a));
    p.put(row_less, a < b), p.put(row_less_equal, a <= b), p.put(row_greater, a > b), p.put(row_greater_equal, a >= b);
    p.put(row_equal, a == b), p.put(row_and, mask_t<F>((a < b) & (b < c))), p.put(row_or, mask_t<F>((a < b) | (b < c)));
    p.put(row_not, mask_t<F>(!(a < b))), p.put(row_iota, p.lanes);

    // any() sees each lane alone, and nothing where no lane is set.
    bool right = !any(p.lanes < I(0));
    for (int k = 0; k < N::width; ++k) right = right && any(p.lanes == I(p.first() + k));
    p.put(row_any, I(right));
}

void probe_integers(const Packet& p, I a, I b, I at) {
    p.put(row_int_add, a + b), p.put(row_int_subtract, a - b), p.put(row_int_multiply, a * b);
    p.put(row_int_and, a & b), p.put(row_int_or, a | b), p.put(row_int_xor, a ^ b), p.put(row_int_not, ~a);
    p.put(row_shift_left, a << 7), p.put(row_shift_right, a >> 5), p.put(row_shift_right_logical, shift_right(a, 5));
    p.put(row_shift_left_by_lane, a << (b & I(31))), p.put(row_shift_right_by_lane, shift_right(a, b & I(31)));
    p.put(row_int_less, mask_t<F>(a < b)), p.put(row_int_greater, mask_t<F>(a > b));
    p.put(row_int_less_equal, mask_t<F>(a <= b)), p.put(row_int_greater_equal, mask_t<F>(a >= b));
    p.put(row_int_equal, mask_t<F>(a == b)), p.put(row_int_select, select(a < b, b, at));
    p.put(row_int_min, min(a, b)), p.put(row_int_max, max(a, b)), p.put(row_int_fetch, N::fetch(p.in.at, at));
}

}  // namespace

template <>
void number_probe<Isa::PLUMB_ISA>(const ProbeInput& in, ProbeOutput& out) {
    for (int i = 0; i < in.count; i += N::width) {
        const Packet p{in, out, N::iota(i)};
        const F a = N::fetch(in.a, p.lanes), b = N::fetch(in.b, p.lanes), c = N::fetch(in.c, p.lanes);
        const I at = N::fetch(in.at, p.lanes);
        probe_reals(p, a, b, c, at);
        probe_conversions_and_comparisons(p, a, b, c);
        probe_integers(p, N::bits(a), N::bits(b), at);
    }
    float* fused_row = out.reals + std::ptrdiff_t(row_fused) * in.count;
    for (int i = 0; i < in.count; ++i) fused_row[i] = fused(in.a[i], in.b[i], in.c[i]);
}

}  // namespace plumb
