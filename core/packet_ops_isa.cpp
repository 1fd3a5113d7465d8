// The operations of core/bounded.h on sixteen lanes at a time: the same formulas in the same order, so that every lane
// has the bits of the scalar one. What is said there of an operation is not said again here. A lane that is not plain
// (core/packet_data.h), or on its way out of the floats, is left to the scalar operation.
#include "core/packet_data.h"

#include <type_traits>

#include "core/native_double.h"
#include "core/wide.h"

namespace plumb::PLUMB_ISA {
namespace {

using Lanes = PacketOps::Lanes;
using Mask = DoubleMask;
using plumb::abs, plumb::any, plumb::max, plumb::min, plumb::sqrt;  // of one lane; those of Double by argument

constexpr int step = Double::lanes;
constexpr Lanes step_bits = (1u << step) - 1;
constexpr double least_normal = 0x1p-126, largest_float = 0x1.fffffep127, long_sum = 16;

// What `values` makes of each lane's floats.
template <class Values>
PLUMB_INLINE void each_value(PacketData& r, Values values) {
    for (int i = 0; i < PacketData::lanes; i += number<Real>::width) number<Real>::save(r.value + i, values(i));
}
PLUMB_INLINE Real value_of(const PacketData& a, int i) { return number<Real>::load(a.value + i); }

// `step` lanes of an operand. `exact`: its packet's form.
template <bool exact>
struct Part {
    Double shadow, bound, terms, additions, magnitude, size;

    PLUMB_INLINE Part(const PacketData& a, int i) {
        if constexpr (exact) {
            shadow = widen(a.value + i), magnitude = abs(shadow);
            bound = additions = Double(0.0), size = terms = magnitude;
        } else {
            shadow = load(a.shadow + i), magnitude = abs(shadow);
            bound = load(a.bound + i), terms = load(a.terms + i), additions = load(a.additions + i);
            size = magnitude + bound;
        }
    }
    PLUMB_INLINE Mask zero() const { return size == Double(0.0); }
    PLUMB_INLINE Double low() const { return exact ? shadow : shadow - bound; }
    PLUMB_INLINE Double high() const { return exact ? shadow : shadow + bound; }
};

// Calls f with the form of a packet, or of two, as a type.
template <class F>
PLUMB_INLINE auto with_form(const PacketData& a, F f) {
    return a.exact ? f(std::true_type{}) : f(std::false_type{});
}
template <class F>
PLUMB_INLINE auto with_forms(const PacketData& a, const PacketData& b, F f) {
    return with_form(a, [&](auto of_a) __attribute__((always_inline)) {
        return with_form(b, [&](auto of_b) __attribute__((always_inline)) { return f(of_a, of_b); });
    });
}

// Lanes that are not plain.
PLUMB_INLINE Lanes odd_of(Double magnitude, Double size) {
    const Mask suspect = (magnitude < Double(least_normal)) | !(size <= Double(largest_float));
    if (!any(suspect)) [[likely]]
        return 0;
    return bits(suspect & !((magnitude == Double(0.0)) & (size <= Double(largest_float))));
}

// Keeps `step` lanes of a result that is no sum; returns those that are not plain.
PLUMB_INLINE Lanes keep(PacketData& r, int i, Double shadow, Double bound) {
    const Double magnitude = abs(shadow), size = magnitude + bound;
    save(r.shadow + i, shadow), save(r.bound + i, bound), save(r.terms + i, size), save(r.additions + i, Double(0.0));
    return odd_of(magnitude, size);
}

template <bool exact_a, bool exact_b, bool minus>
PLUMB_INLINE Lanes sum(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r) {
    const Double add(grants.add), flushed(2 * grants.flushed), underflow(grants.underflow);
    const bool blends = a.blend | b.blend, long_sums = a.sums & b.sums;
    Lanes odd = 0, sums = 0, blend = 0;
    for (int i = 0; i < PacketData::lanes; i += step) {
        Part<exact_a> x(a, i);
        Part<exact_b> y(b, i);
        if constexpr (minus) y.shadow = -y.shadow;
        Double shadow = x.shadow + y.shadow;
        const Double total = x.terms + y.terms;
        Double m = x.additions, n = y.additions;
        if (long_sums) {
            const Mask is_long = (Double(0.0) < m) & (Double(0.0) < n) & ((Double(long_sum) < m) | (Double(long_sum) < n));
            if (any(is_long)) {
                const Mask second = m < n;
                const Double kept = select(is_long & second, Double(0.0), n);
                m = select(is_long & !second, Double(0.0), m), n = kept;
            }
        }
        Double charge = total;
        if constexpr (!exact_a) charge = charge + m * y.terms;
        if constexpr (!exact_b) charge = charge + n * x.terms;
        Lanes blend_a = 0, blend_b = 0;
        if (blends) {
            blend_a = a.blend >> i & step_bits, blend_b = b.blend >> i & step_bits;
            if (blend_a != blend_b) {
                const Mask of_a = lanes_of(blend_a);
                const Mask counts = Double(0.0) < select(of_a, m, n);
                const Double times = select(counts, Double(1.0), Double(3.0));
                const Double more = charge + times * select(of_a, y.terms, x.terms);
                charge = select(lanes_of(blend_a ^ blend_b), more, charge);
            }
        }
        const Double rounding = add * charge + flushed + underflow;
        Double bound = x.bound + y.bound + rounding, terms = total + rounding;
        Double additions = min(m + n + Double(1.0), Double(65535.0));
        Lanes summed = step_bits, blended = blend_a & blend_b;
        const Mask zero_a = x.zero(), zero_b = y.zero();
        if (any(zero_a | zero_b)) {
            shadow = select(zero_b, x.shadow, select(zero_a, y.shadow, shadow));
            bound = select(zero_b, x.bound, select(zero_a, y.bound, bound));
            terms = select(zero_b, x.terms, select(zero_a, y.terms, terms));
            additions = select(zero_b, x.additions, select(zero_a, y.additions, additions));
            const Lanes za = bits(zero_a), zb = bits(zero_b);
            summed = (zb & a.sums >> i) | (~zb & ((za & b.sums >> i) | (~za & step_bits)));
            blended = (zb & blend_a) | (~zb & ((za & blend_b) | (~za & blended)));
        }
        save(r.shadow + i, shadow), save(r.bound + i, bound), save(r.terms + i, terms);
        save(r.additions + i, additions);
        const Double magnitude = abs(shadow);
        odd |= odd_of(magnitude, magnitude + bound) << i, sums |= summed << i, blend |= blended << i;
    }
    each_value(r, [&](int i) __attribute__((always_inline)) {
        return minus ? value_of(a, i) - value_of(b, i) : value_of(a, i) + value_of(b, i);
    });
    r.sums = sums, r.blend = blend, r.exact = false;
    return a.odd | b.odd | odd;
}
template <bool minus>
Lanes sum(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r) {
    return with_forms(a, b, [&](auto of_a, auto of_b) __attribute__((always_inline)) {
        return sum<of_a(), of_b(), minus>(a, b, grants, r);
    });
}

// |x| - bound is no denormal, or all is 0.
template <class P>
PLUMB_INLINE Mask normal(const P& x) {
    return (Double(least_normal) <= x.magnitude - x.bound) | x.zero();
}

template <bool exact_a, bool exact_b>
PLUMB_INLINE Lanes product(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r) {
    const Double multiply(grants.multiply), flushed(grants.flushed), underflow(grants.underflow), zero(0.0);
    const Lanes of_sum = a.sums ^ b.sums;
    Lanes odd = 0, sums = 0;
    for (int i = 0; i < PacketData::lanes; i += step) {
        const Part<exact_a> x(a, i);
        const Part<exact_b> y(b, i);
        const Double shadow = x.shadow * y.shadow, magnitude = abs(shadow);
        Double bound = zero;
        if constexpr (exact_a && !exact_b) bound = x.magnitude * y.bound;
        if constexpr (!exact_a && exact_b) bound = y.magnitude * x.bound;
        if constexpr (!exact_a && !exact_b) bound = x.magnitude * y.bound + y.magnitude * x.bound + x.bound * y.bound;

        const Lanes of_sum_here = of_sum >> i & step_bits;
        Double rounds = magnitude + bound, terms = zero;
        if (of_sum_here) {
            const Mask m = lanes_of(of_sum_here);
            terms = x.terms * y.terms;
            rounds = select(m, terms, rounds);
        }
        const Double rounding = multiply * rounds + (x.size + y.size + flushed) * flushed + underflow;
        Double all = bound + rounding;
        Mask scales_a = no_fraction(x.shadow), scales_b = no_fraction(y.shadow);
        if (any(scales_a | scales_b)) {
            if constexpr (!exact_a) scales_a = scales_a & (x.bound == zero);
            if constexpr (!exact_b) scales_b = scales_b & (y.bound == zero);
            const Mask stays = (Double(least_normal) <= magnitude - bound) | (magnitude + bound == zero);
            const Mask exact = x.zero() | y.zero() | ((scales_a | scales_b) & normal(x) & normal(y) & stays);
            all = select(exact, bound, all);
        }
        const Double size = magnitude + all;
        Double additions = zero, kept = size;
        if (of_sum_here) {
            const Double count = x.additions + y.additions;
            const Mask m = lanes_of(of_sum_here) & (count <= Double(long_sum));
            additions = select(m, count, zero);
            kept = select(m, terms + multiply * terms, size);
            sums |= bits(m) << i;
        }
        save(r.shadow + i, shadow), save(r.bound + i, all), save(r.terms + i, kept), save(r.additions + i, additions);
        odd |= odd_of(magnitude, size) << i;
    }
    each_value(r, [&](int i) __attribute__((always_inline)) { return value_of(a, i) * value_of(b, i); });
    r.sums = sums, r.blend = a.sums | b.sums, r.exact = false;
    return a.odd | b.odd | odd;
}
Lanes product(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r) {
    return with_forms(a, b, [&](auto of_a, auto of_b) __attribute__((always_inline)) {
        return product<of_a(), of_b()>(a, b, grants, r);
    });
}

template <bool exact_a, bool exact_b>
PLUMB_INLINE Lanes quotient(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r) {
    const Double divide(grants.divide), flushed(grants.flushed), underflow(grants.underflow), zero(0.0);
    Lanes odd = 0;
    for (int i = 0; i < PacketData::lanes; i += step) {
        const Part<exact_a> x(a, i);
        const Part<exact_b> y(b, i);
        const Double shadow = x.shadow / y.shadow, least = exact_b ? y.magnitude : y.magnitude - y.bound;
        const Double size = abs(shadow);
        const Double moved = exact_b ? x.bound : x.bound + size * y.bound;
        Double bound = (moved + flushed) / least;
        bound = bound + (divide * (size + bound) + underflow);
        bound = select(x.zero(), zero, bound);
        const Mask plain = (Double(least_normal) <= least) & (y.size <= Double(0x1p126));
        odd |= (keep(r, i, shadow, bound) | bits(!plain)) << i;
    }
    each_value(r, [&](int i) __attribute__((always_inline)) { return value_of(a, i) / value_of(b, i); });
    r.sums = r.blend = 0, r.exact = false;
    return a.odd | b.odd | (odd & PacketData::all);
}
Lanes quotient(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r) {
    return with_forms(a, b, [&](auto of_a, auto of_b) __attribute__((always_inline)) {
        return quotient<of_a(), of_b()>(a, b, grants, r);
    });
}

// within_ends(), of plain lanes.
PLUMB_INLINE Lanes keep_ends(PacketData& r, int i, Double shadow, Double low, Double high) {
    const Double bound = select(low == high, Double(0.0), max(high - shadow, shadow - low));
    return keep(r, i, shadow, bound);
}

template <class Pick, class PickValue>
PLUMB_INLINE Lanes picked(const PacketData& a, const PacketData& b, PacketData& r, Pick pick, PickValue pick_value) {
    const Lanes odd = with_forms(a, b, [&](auto of_a, auto of_b) __attribute__((always_inline)) {
        Lanes found = 0;
        for (int i = 0; i < PacketData::lanes; i += step) {
            const Part<of_a()> x(a, i);
            const Part<of_b()> y(b, i);
            found |= keep_ends(r, i, pick(x.shadow, y.shadow), pick(x.low(), y.low()), pick(x.high(), y.high())) << i;
        }
        return found;
    });
    each_value(r, [&](int i) __attribute__((always_inline)) { return pick_value(value_of(a, i), value_of(b, i)); });
    r.sums = r.blend = 0, r.exact = false;
    return a.odd | b.odd | odd;
}
Lanes least(const PacketData& a, const PacketData& b, const PacketGrants&, PacketData& r) {
    return picked(a, b, r, [](Double x, Double y) __attribute__((always_inline)) { return min(x, y); },
                  [](Real x, Real y) __attribute__((always_inline)) { return min(x, y); });
}
Lanes largest(const PacketData& a, const PacketData& b, const PacketGrants&, PacketData& r) {
    return picked(a, b, r, [](Double x, Double y) __attribute__((always_inline)) { return max(x, y); },
                  [](Real x, Real y) __attribute__((always_inline)) { return max(x, y); });
}

Lanes clamped(const PacketData& a, const PacketData& low, const PacketData& high, PacketData& r) {
    const auto held = [](auto x, auto from, auto to) __attribute__((always_inline)) { return min(max(x, from), to); };
    Lanes odd = 0;
    for (int i = 0; i < PacketData::lanes; i += step) {
        const auto ends = [&](const PacketData& p) __attribute__((always_inline)) {
            struct Ends {
                Double shadow, low, high;
            };
            const Double shadow = p.exact ? widen(p.value + i) : load(p.shadow + i);
            const Double bound = p.exact ? Double(0.0) : load(p.bound + i);
            return Ends{shadow, shadow - bound, shadow + bound};
        };
        const auto x = ends(a), from = ends(low), to = ends(high);
        odd |= keep_ends(r, i, held(x.shadow, from.shadow, to.shadow), held(x.low, from.low, to.low),
                         held(x.high, from.high, to.high)) << i;
    }
    each_value(r, [&](int i) __attribute__((always_inline)) { return held(value_of(a, i), value_of(low, i), value_of(high, i)); });
    r.sums = r.blend = 0, r.exact = false;
    return a.odd | low.odd | high.odd | odd;
}

Lanes root(const PacketData& a, const PacketGrants& grants, PacketData& r) {
    const Double grant(grants.sqrt), zero(0.0), of_flushed(__builtin_sqrt(grants.flushed));
    const Lanes odd = with_form(a, [&](auto of_a) __attribute__((always_inline)) {
        Lanes found = 0;
        for (int i = 0; i < PacketData::lanes; i += step) {
            const Part<of_a()> x(a, i);
            const Double shadow = sqrt(x.shadow), low = sqrt(max(x.low(), zero));
            const Mask above = zero < low;
            Double bound = x.bound / (shadow + low);
            if (any(!above)) bound = select(above, bound, max(shadow, sqrt(x.high()) - shadow));
            bound = bound + grant * (shadow + bound);
            const Mask near = x.low() < Double(least_normal);
            if (any(near)) bound = select(near, bound + of_flushed, bound);
            bound = select(x.zero(), zero, bound);
            found |= (keep(r, i, shadow, bound) | bits(x.shadow < zero)) << i;
        }
        return found;
    });
    each_value(r, [&](int i) __attribute__((always_inline)) { return sqrt(value_of(a, i)); });
    r.sums = r.blend = 0, r.exact = false;
    return a.odd | odd;
}

// The same but for the sign; of |a| no sum is left.
template <bool negates>
void sign(const PacketData& a, PacketData& r) {
    for (int i = 0; i < PacketData::lanes && !a.exact; i += step) {
        const Double shadow = load(a.shadow + i);
        save(r.shadow + i, negates ? -shadow : abs(shadow));
        const Double bound = load(a.bound + i);
        save(r.bound + i, bound);
        save(r.terms + i, negates ? load(a.terms + i) : abs(shadow) + bound);
        save(r.additions + i, negates ? load(a.additions + i) : Double(0.0));
    }
    each_value(r, [&](int i) __attribute__((always_inline)) { return negates ? -value_of(a, i) : abs(value_of(a, i)); });
    r.sums = negates ? a.sums : 0, r.blend = negates ? a.blend : 0, r.odd = a.odd, r.exact = a.exact;
}

void blended(Lanes mask, const PacketData& a, const PacketData& b, PacketData& r) {
    r.exact = a.exact && b.exact;
    for (int i = 0; i < PacketData::lanes && !r.exact; i += step) {
        const Mask m = lanes_of(mask >> i & step_bits);
        const auto either = [&](double* to, Double x, Double y) __attribute__((always_inline)) { save(to + i, select(m, x, y)); };
        const Double zero(0.0), x = a.exact ? widen(a.value + i) : load(a.shadow + i);
        const Double y = b.exact ? widen(b.value + i) : load(b.shadow + i);
        either(r.shadow, x, y);
        either(r.bound, a.exact ? zero : load(a.bound + i), b.exact ? zero : load(b.bound + i));
        either(r.terms, a.exact ? abs(x) : load(a.terms + i), b.exact ? abs(y) : load(b.terms + i));
        either(r.additions, a.exact ? zero : load(a.additions + i), b.exact ? zero : load(b.additions + i));
    }
    typedef std::int32_t Words __attribute__((vector_size(sizeof a.value)));
    Words u, v;
    std::memcpy(&u, a.value, sizeof u), std::memcpy(&v, b.value, sizeof v);
    const Words bit = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
    const Words on = ((Words{} + std::int32_t(mask)) & bit) != 0;
    u = (u & on) | (v & ~on);
    std::memcpy(r.value, &u, sizeof u);
    r.sums = (a.sums & mask) | (b.sums & ~mask);
    r.blend = (a.blend & mask) | (b.blend & ~mask);
    r.odd = (a.odd & mask) | (b.odd & ~mask);
}

// a < b where `strict`, else a <= b.
template <bool strict>
Lanes below(const PacketData& a, const PacketData& b) {
    return with_forms(a, b, [&](auto of_a, auto of_b) __attribute__((always_inline)) {
        Lanes own = 0, undecided = 0;
        for (int i = 0; i < PacketData::lanes; i += step) {
            const Part<of_a()> x(a, i);
            const Part<of_b()> y(b, i);
            const Double u = widen(a.value + i), v = widen(b.value + i);
            own |= bits(strict ? u < v : u <= v) << i;
            const Mask decided = strict ? (x.high() < y.low()) | (y.high() <= x.low())
                                        : (x.high() <= y.low()) | (y.high() < x.low());
            undecided |= (bits(!decided) & step_bits) << i;
        }
        return own | undecided << 16;
    });
}

// ---- What is exact -----------------------------------------------------------------------------------------------------

PLUMB_INLINE void exactly(PacketData& r) {
    bool suspect = false;
    for (int i = 0; i < PacketData::lanes; i += number<Real>::width) {
        const Real magnitude = abs(value_of(r, i));
        const mask_t<Real> some = (magnitude < Real(0x1p-126f)) | !(magnitude <= Real(0x1.fffffep127f));
        suspect |= any(some);
    }
    Lanes odd = 0;
    for (int i = 0; i < PacketData::lanes && suspect; i += step) {
        const Double magnitude = abs(widen(r.value + i));
        odd |= odd_of(magnitude, magnitude) << i;
    }
    r.sums = r.blend = 0, r.odd = odd & PacketData::all, r.exact = true;
}
void splat(float x, PacketData& r) {
    each_value(r, [&](int) __attribute__((always_inline)) { return Real(x); });
    exactly(r);
}
PLUMB_INLINE index_t<Real> places(const std::int32_t* at) {
    index_t<Real> i;
    std::memcpy(&i, at, sizeof i);
    return i;
}
void numbers(const float* p, const std::int32_t* at, PacketData& r) {
    each_value(r, [&](int i) __attribute__((always_inline)) { return number<Real>::fetch(p, places(at + i)); });
    exactly(r);
}
PLUMB_INLINE void put(PacketData* const* to, int i, const vec4<Real>& texel) {
    number<Real>::save(to[0]->value + i, texel.x), number<Real>::save(to[1]->value + i, texel.y);
    number<Real>::save(to[2]->value + i, texel.z), number<Real>::save(to[3]->value + i, texel.w);
}
template <class Component>
void texels(const Component* p, const std::int32_t* at, PacketData* const* four) {
    for (int i = 0; i < PacketData::lanes; i += number<Real>::width)
        put(four, i, number<Real>::fetch4(p, places(at + i)));
    for (int c = 0; c < 4; ++c) exactly(*four[c]);
}
template <class Component>
void records(const Component* p, const std::int32_t* at, PacketData* const* twelve) {
    for (int i = 0; i < PacketData::lanes; i += number<Real>::width) {
        const Record<Real> record = number<Real>::fetch_record(p, places(at + i));
        put(twelve, i, record.a), put(twelve + 4, i, record.b), put(twelve + 8, i, record.c);
    }
    for (int c = 0; c < 12; ++c) exactly(*twelve[c]);
}

}  // namespace
}  // namespace plumb::PLUMB_ISA

namespace plumb {

template <>
const PacketOps PacketOpsOf<Isa::PLUMB_ISA>::ops = {
    .add = PLUMB_ISA::sum<false>, .subtract = PLUMB_ISA::sum<true>, .multiply = PLUMB_ISA::product,
    .divide = PLUMB_ISA::quotient, .min = PLUMB_ISA::least, .max = PLUMB_ISA::largest, .sqrt = PLUMB_ISA::root,
    .clamp = PLUMB_ISA::clamped, .negate = PLUMB_ISA::sign<true>, .abs = PLUMB_ISA::sign<false>,
    .blend = PLUMB_ISA::blended, .less = PLUMB_ISA::below<true>, .less_equal = PLUMB_ISA::below<false>,
    .splat = PLUMB_ISA::splat, .number = PLUMB_ISA::numbers, .texel = PLUMB_ISA::texels<float>,
    .half_texel = PLUMB_ISA::texels<Half>, .record = PLUMB_ISA::records<float>,
    .half_record = PLUMB_ISA::records<Half>,
};

}  // namespace plumb
