// Bounded by experiment: no device that keeps Vulkan's precision table leaves the bound, and small mistakes do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <set>
#include <string>

#include "core/detmath.h"
#include "core/device_profile.h"
#include "core/error.h"
#include "core/outcomes.h"
#include "core/tap.h"
#include "gi/rsm/gather_kernel.h"
#include "legal_device.h"
#include "raster/light_kernel.h"
#include "raster/surface_kernel.h"

using namespace plumb;
using namespace plumb::test;

namespace {

// ---- Expressions of the kernels, with the other forms that a shader may give them
// --------------------------------------

template <class F>
constexpr bool other_forms = std::is_same_v<F, Legal>;

template <class F>
bool other_form() {
    if constexpr (other_forms<F>) return device.reorders && device.coin();
    return false;
}

// Any two at a time.
inline Legal sum_in_other_order(std::vector<Legal> terms) {
    const int shape = device.random.below(4);
    if (shape == 0) std::reverse(terms.begin(), terms.end());
    if (shape == 1) std::sort(terms.begin(), terms.end(), [](Legal a, Legal b) { return abs(b) < abs(a); });
    while (terms.size() > 1) {
        const int last = int(terms.size()) - 1;
        if (shape == 2) std::swap(terms[0], terms[std::size_t(device.random.below(last + 1))]);
        const int j = shape > 1 ? 1 + device.random.below(last) : 1;
        terms[0] = terms[0] + terms[std::size_t(j)];
        terms.erase(terms.begin() + j);
    }
    return terms[0];
}
template <class F>
F sum_of(const std::vector<F>& terms) {
    if constexpr (other_forms<F>)
        if (other_form<F>()) return sum_in_other_order(terms);
    F sum = terms[0];
    for (std::size_t i = 1; i < terms.size(); ++i) sum += terms[i];
    return sum;
}

template <class F>
vec3<F> vec(const float* in) {
    return {F(in[0]), F(in[1]), F(in[2])};
}
template <class F>
F dot(const vec3<F>& a, const vec3<F>& b) {
    return sum_of<F>({a.x * b.x, a.y * b.y, a.z * b.z});
}

// A row of a matrix times (x, 1).
template <class F>
F row(const float* in) {
    return sum_of<F>({F(in[0]) * F(in[4]), F(in[1]) * F(in[5]), F(in[2]) * F(in[6]), F(in[3])});
}
template <class F>
F projected(const float* in) {
    const float bottom[] = {in[7], in[8], in[9], 9, in[4], in[5], in[6]};
    return row<F>(in) / row<F>(bottom);
}

// The x of a unit vector.
template <class F>
F normalised_x(const float* in) {
    const vec3<F> v = vec<F>(in);
    const F square = dot(v, v);
    if constexpr (other_forms<F>) {
        const int form = device.reorders ? device.random.below(3) : 0;
        if (form == 1) return v.x * inverse_sqrt(square);
        if (form == 2) return v.x * (F(1.0f) / sqrt(square));
    }
    return v.x / sqrt(square);
}

template <class F>
F mixed(F a, F b, F c) {
    return other_form<F>() ? a * (F(1.0f) - c) + b * c : a + c * (b - a);
}
template <class F>
F bilinear(const float* in) {
    const F u(std::abs(in[4])), v(std::abs(in[5]));
    return mixed(mixed(F(in[0]), F(in[1]), u), mixed(F(in[2]), F(in[3]), u), v);
}
template <class F>
F interpolated(const float* in) {
    const F a(in[0]), b(in[1]), c(in[2]), l1(std::abs(in[3]) / 2), l2(std::abs(in[4]) / 2);
    if (other_form<F>()) return sum_of<F>({(F(1.0f) - l1 - l2) * a, l1 * b, l2 * c});
    return raster::interpolate<F>(a, b - a, c - a, {l1, l2});
}

// A spot's irradiance: direction, falloff, cosine, inverse square.
template <class F>
F light(const float* in) {
    const raster::LightArgs spot{{3, 4, 5}, 0.2f, {-0.42426407f, -0.56568542f, -0.70710678f}, 1.7f, {7, 5, 3}, 0};
    const vec3<F> x = vec<F>(in);
    const vec3<F> v{F(spot.position[0]) - x.x, F(spot.position[1]) - x.y, F(spot.position[2]) - x.z};
    const F square = dot(v, v);
    F inverse = F(1.0f) / sqrt(square);
    if constexpr (other_forms<F>)
        if (device.reorders && device.coin()) inverse = inverse_sqrt(square);
    const vec3<F> w{v.x * inverse, v.y * inverse, v.z * inverse}, axis = vec<F>(spot.direction);
    const F falloff = raster::spot_falloff<F>(spot, -dot(w, axis));
    const F cosine = max(F(0.0f), dot(vec<F>(in + 3), w));
    if (other_form<F>()) return (F(7.0f) * falloff * cosine) / square;
    return (F(7.0f) * falloff) * (cosine * inverse * inverse);
}

// VRSM (3.2) times a flux: in[0..2] x, [3..5] n, [6..8] x_p, [9..11] n_p.
template <class F>
F form(const float* in) {
    NoTap tap;
    const vec3<F> x = vec<F>(in), n = vec<F>(in + 3), x_p = vec<F>(in + 6), n_p = vec<F>(in + 9);
    if (other_form<F>()) {
        const vec3<F> d{x_p.x - x.x, x_p.y - x.y, x_p.z - x.z};
        const F square = dot(d, d);
        return max(F(0.0f), -dot(n_p, d)) * max(F(0.0f), dot(n, d)) / (square * square);
    }
    return rsm::form<F>(x, n, x_p, n_p, F(1e-37f), tap);
}

// 400 samples: the receiver, and for each the offset of its texel, some cancelling.
template <class F>
F gather_by(const float* in, float scale, int missing) {
    std::vector<F> terms;
    for (int k = 0; k < 400; ++k) {
        if (k == missing) continue;
        const float sample[12] = {
            in[0], in[1], in[2], 0.1f, -0.2f, 0.97f, in[3 + k % 7], in[4 + k % 5], 2 + 0.01f * float(k % 13),
            0.3f,  0.1f,  -0.94f};
        terms.push_back(F(in[(k * 5) % 12] * float(1 + k % 3)) * form<F>(sample));
    }
    return sum_of<F>(terms) * F(scale);
}
template <class F>
F gather(const float* in) {
    return gather_by<F>(in, 0.318309873f, -1);
}

// The height of a point close by over a tangent plane, n.(x_p - x): in[0..2] x, [3..5] n, [6..8] x_p - x.
template <class F>
F height(const float* in) {
    const vec3<F> x = vec<F>(in), n = vec<F>(in + 3);
    const vec3<F> x_p{F(in[0] + 1e-3f * in[6]), F(in[1] + 1e-3f * in[7]), F(in[2] + 1e-3f * in[8])};
    if (other_form<F>()) return dot(n, x_p) - dot(n, x);
    return dot(n, {x_p.x - x.x, x_p.y - x.y, x_p.z - x.z});
}
// Sums that cancel, multiplied out: times two factors, and times one with a term to follow.
template <class F>
F distributed(const float* in) {
    const F a(in[0]), b(-in[0] * (1 + 1e-6f * in[1])), c(in[2]), e(in[4]);
    if (other_form<F>()) return a * c * e + b * c * e;
    return ((a + b) * c) * e;
}
template <class F>
F distributed_sum(const float* in) {
    const F a(in[0]), b(-in[0] * (1 + 1e-6f * in[1])), c(in[2]), d(1e-7f * in[3]);
    if (other_form<F>()) return sum_of<F>({a * c, b * c, d});
    return (a + b) * c + d;
}

// Nothing but the order of a sum, of which the largest term comes last and half cancels.
template <class F>
F long_sum(const float* in) {
    std::vector<F> terms;
    for (int k = 0; k < 99; ++k) terms.push_back(F(in[k % 12]) * F(float(1 + (k * k) % 31)));
    terms.push_back(F(in[0]) * F(4096.0f));
    return sum_of<F>(terms);
}

struct Expression {
    const char* name;
    float (*of_float)(const float*);
    Bounded (*bounded)(const float*);
    Legal (*legal)(const float*);
    int inputs;
};
#define EXPRESSION(f, inputs) \
    { #f, f < float>, f < Bounded>, f < Legal>, inputs }

const Expression expressions[] = {
    EXPRESSION(row, 4000),      EXPRESSION(projected, 4000),    EXPRESSION(normalised_x, 4000),
    EXPRESSION(bilinear, 4000), EXPRESSION(interpolated, 4000), EXPRESSION(light, 4000),
    EXPRESSION(form, 4000),     EXPRESSION(long_sum, 200),      EXPRESSION(gather, 8),
    EXPRESSION(height, 4000),   EXPRESSION(distributed, 4000),
    EXPRESSION(distributed_sum, 4000)};
constexpr int variants = 20 * roundings;

std::vector<float> random_inputs(Random& random) {
    std::vector<float> in;
    for (int k = 0; k < 12; ++k) in.push_back(float(random.between(-1, 1)));
    return in;
}

// The n-th kind of legal device.
void choose_device(int n) {
    device.rounding = Rounding(n % roundings);
    device.contracts = n & 1, device.by_reciprocal = n & 2, device.flushes = n & 4, device.reorders = n % 5 != 0;
    device.half_at = -1, device.operations = 0;
}

bool same_bits(float a, float b) { return std::memcmp(&a, &b, 4) == 0 || (a != a && b != b); }

}  // namespace

TEST_CASE("bounded: no legal device leaves the bound, and the bound is not far away", "[bounded]") {
    long evaluations = 0;
    for (const Expression& e : expressions) {
        Random random(7);
        double worst = 0;
        for (int i = 0; i < e.inputs; ++i) {
            const std::vector<float> in = random_inputs(random);
            const Bounded b = e.bounded(in.data());
            REQUIRE(same_bits(b.value, e.of_float(in.data())));
            for (int n = 0; n < variants; ++n, ++evaluations) {
                choose_device(n);
                const double off = std::abs(double(e.legal(in.data()).value) - b.shadow);
                if (!(off <= b.bound))
                    FAIL(e.name << " input " << i << " variant " << n << ": " << off << " > " << b.bound);
                worst = std::max(worst, off / b.bound);
            }
        }
        CAPTURE(e.name, worst);
        CHECK(worst >= 0.1);  // so the bound is at most ten times what was found
    }
    CHECK(evaluations > 1000000);
}

TEST_CASE("bounded: no legal device leaves the bound of one operation, whatever its operands", "[bounded]") {
    Random random(3);
    auto any_float = [&] {
        const std::uint32_t bits = random.next();
        float x;
        std::memcpy(&x, &bits, 4);
        // A third around the ends of what is normal.
        if (bits % 3 == 0) x = float(random.between(-4, 4)) * (bits & 64 ? 0x1p-126f : 0x1p125f);
        return x;
    };
    for (int i = 0; i < 200000; ++i) {
        const float a = any_float(), b = i % 7 == 0 ? a : any_float();
        const Bounded x(a), y(b);
        const Bounded bounded[] = {x + y, x - y, x * y, x / y, min(x, y), max(x, y), abs(x), sqrt(abs(y))};
        const float of_float[] = {a + b, a - b, a * b, a / b, min(a, b), max(a, b), plumb::abs(a), sqrt(plumb::abs(b))};
        for (int n = 0; n < 2 * roundings; ++n) {
            choose_device(n % roundings);
            device.flushes = n >= roundings, device.by_reciprocal = n & 1, device.contracts = false;
            const Legal p(a), q(b);
            const Legal legal[] = {p + q, p - q, p * q, p / q, min(p, q), max(p, q), abs(p), sqrt(abs(q))};
            for (int k = 0; k < 8; ++k) {
                if (!same_bits(bounded[k].value, of_float[k]))
                    FAIL("value of operation " << k << ": " << a << ", " << b);
                const double r = legal[k].value;
                const bool inside = std::abs(r - bounded[k].shadow) <= bounded[k].bound ||
                                    bounded[k].bound == INFINITY || r == bounded[k].shadow || a != a || b != b;
                if (!inside)
                    FAIL("operation " << k << " of " << a << ", " << b << ": " << r << " against " << bounded[k].shadow
                                      << " +- " << bounded[k].bound);
            }
        }
    }
}

TEST_CASE("bounded: what every device computes exactly has no bound of its own", "[bounded]") {
    // Vulkan 1.3, "Precision of core SPIR-V instructions": a correctly rounded result is exact where it can be.
    const Bounded third = Bounded(1.0f) / Bounded(3.0f), zero(0.0f);
    CHECK((third * zero).exact());
    CHECK((zero / third).exact());
    CHECK((third + zero).bound == third.bound);
    CHECK((third * Bounded(0.25f)).bound == third.bound / 4);
    CHECK(Bounded(16777216).exact());
    CHECK(Bounded(16777217).bound >= 1);
    CHECK(max(zero, -third).exact());
    CHECK(clamp(third + Bounded(2.0f), zero, Bounded(1.0f)).exact());
    CHECK(floor(third).exact());
    // 1 +- 0.5 squared is 0.25 .. 2.25.
    CHECK((Bounded::within(1, 1, 0.5) * Bounded::within(1, 1, 0.5)).bound >= 1.25);
    // The product by a power of two may be flushed.
    CHECK((Bounded(0x1p-100f) * Bounded(0x1p-30f)).bound >= 0x1p-130);
}

// Vulkan 1.3: an implementation may take denormal operands and results for 0 (DenormFlushToZero is optional).
TEST_CASE("bounded: what may be flushed is inside the bound, and what a driver keeps is not charged", "[bounded]") {
    const Bounded tiny(1e-40f), small(1e-20f), least(1.2e-38f), zero(0.0f);
    auto bounds = [&] {
        return std::vector<double>{(tiny * Bounded(1e30f)).bound / 1e-10,      // the operand
                                   (small * small).bound / 1e-40,              // the result
                                   (tiny + Bounded(2e-38f)).bound / 1e-40,     // the operand
                                   (least - Bounded(1.3e-38f)).bound / 1e-39,  // the result
                                   (tiny / Bounded(1e-30f)).bound / 1e-10,     // the operand
                                   (Bounded(1e-30f) / Bounded(1e10f)).bound / 1e-40,
                                   sqrt(tiny).bound / 1e-20,
                                   detmath::exp(Bounded(-95.0f)).bound / 5e-42};
    };
    Precision p;
    {
        const PrecisionScope scope(p);
        for (const double b : bounds()) CHECK(b >= 0.99);
        CHECK((tiny == zero).slot != 0);
        CHECK((zero < tiny).slot != 0);
    }
    p.flushes_denormals = false;
    const PrecisionScope scope(p);
    const std::vector<double> kept = bounds();
    for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
        CAPTURE(k);
        CHECK(kept[k] < 1e-3);
    }
    CHECK((tiny == zero).slot == 0);
    CHECK((zero < tiny).slot == 0);
}

TEST_CASE("bounded: a quotient is granted the reciprocal's units and the product's", "[bounded]") {
    // Vulkan 1.3: 2.5 units for 1 / b, one more for a (1 / b); just above a power of two a unit is 2^-23 of it.
    const Bounded a(3.0f), b(2.99999f);
    CHECK((a / b).bound >= 3.5 * 0x1p-23);
    Precision p;
    p.multiply = 2;
    const PrecisionScope scope(p);
    CHECK((a / b).bound >= 4.5 * 0x1p-23);
    CHECK((a / b).bound < 4.6 * 0x1p-23);
}

TEST_CASE("bounded: a 16-bit intermediate leaves the bound", "[bounded]") {
    // binary16 keeps 11 bits: its rounding moves a result by 2^-13 of it on average, the bound is near 2^-19.
    const struct {
        const Expression& of;
        double least;  // share of those that move the result at all
    } cases[] = {{expressions[0], 0.9},
                 {expressions[2], 0.9},
                 {expressions[4], 0.9},
                 {expressions[5], 0.9},
                 {expressions[6], 0.9}};
    for (const auto& c : cases) {
        Random random(11);
        int moved = 0, outside = 0;
        for (int i = 0; i < 4000; ++i) {
            const std::vector<float> in = random_inputs(random);
            const Bounded b = c.of.bounded(in.data());
            if (b.exact()) continue;
            choose_device(int(Rounding::nearest));
            device.contracts = device.by_reciprocal = device.flushes = device.reorders = false;
            const float right = c.of.legal(in.data()).value;
            const int operations = device.operations;
            device.operations = 0, device.half_at = device.random.below(operations);
            const float wrong = c.of.legal(in.data()).value;
            moved += std::abs(double(wrong) - right) > 1e-5 * std::abs(right);
            outside += std::abs(double(wrong) - b.shadow) > b.bound &&
                       std::abs(double(wrong) - right) > 1e-5 * std::abs(right);
        }
        CAPTURE(c.of.name, moved, outside);
        CHECK(moved > 800);
        CHECK(outside > c.least * moved);
    }
}

TEST_CASE("bounded: a gather with a constant off by 1e-4, or without one of 400 samples, is outside", "[bounded]") {
    Random random(5);
    for (int i = 0; i < 50; ++i) {
        std::vector<float> in = random_inputs(random);
        for (float& x : in) x = 0.2f + std::abs(x);
        const Bounded right = gather<Bounded>(in.data());
        CAPTURE(right.shadow, right.bound);
        auto outside = [&](float wrong) { return std::abs(double(wrong) - right.shadow) > right.bound; };
        CHECK_FALSE(outside(gather<float>(in.data())));
        CHECK(outside(gather_by<float>(in.data(), 0.318309873f * 1.0001f, -1)));
        CHECK(outside(gather_by<float>(in.data(), 0.318309873f, random.below(400))));
    }
}

TEST_CASE("bounded: pow, exp and logarithms hold what a driver may make of them", "[bounded]") {
    // Vulkan 1.3: exp2 3 + 2 |x| units, log2 3 units outside [0.5, 2] and 2^-21 inside; pow by exp2(y log2 x), exp and
    // log by a factor.
    auto exp2_of = [](Legal x) { return Legal(legal_result(host::exp2(x.read()), 3 + 2 * std::abs(x.read()))); };
    auto log2_of = [](Legal x) {
        const double exact = host::log2(x.read());
        if (x.value < 0.5f || x.value > 2) return Legal(legal_result(exact, 3));
        return Legal(float(exact + device.random.between(-1, 1) * (0x1p-21 - 0x1p-25 * std::abs(exact))));
    };
    Random random(13);
    double worst[5] = {};
    for (int i = 0; i < 5000; ++i) {
        const float a = float(random.between(0.003, i & 1 ? 1 : 40)), c = float(random.between(0.1, 1)),
                    y = float(random.between(0.2, 3));
        const Bounded x = Bounded(a) * Bounded(c);
        const Bounded bounded[] = {detmath::pow(x, Bounded(y)), detmath::exp2(-x), detmath::log2(x), detmath::exp(-x),
                                   detmath::log(x)};
        const float of_float[] = {detmath::pow(a * c, y), detmath::exp2(-(a * c)), detmath::log2(a * c),
                                  detmath::exp(-(a * c)), detmath::log(a * c)};
        for (int n = 0; n < 2 * roundings; ++n) {
            choose_device(n);
            const Legal p = Legal(a) * Legal(c);
            const Legal legal[] = {exp2_of(Legal(y) * log2_of(p)), exp2_of(-p), log2_of(p),
                                   exp2_of(Legal(1.44269502f) * -p), log2_of(p) * Legal(0.693147182f)};
            for (int k = 0; k < 5; ++k) {
                const double off = std::abs(double(legal[k].value) - bounded[k].shadow);
                if (!(off <= bounded[k].bound))
                    FAIL(k << " of " << a * c << ", " << y << ": " << off << " > " << bounded[k].bound);
                REQUIRE(bounded[k].value == of_float[k]);
                worst[k] = std::max(worst[k], off / bounded[k].bound);
            }
        }
    }
    for (double w : worst) CHECK(w > 0.3);
    // Black stays black.
    CHECK(detmath::pow(Bounded(0.0f), Bounded(0.4f)).bound < 1e-37);
    CHECK(detmath::pow(Bounded::within(0, 0, 1e-6), Bounded(0.5f)).high() >= 1e-3);
    // What is 0 within an underflow's reach is nearly 0 still: 1e-38^0.4 = 6e-16.
    CHECK(detmath::pow(Bounded::within(0, 0, 1e-38), Bounded(0.4f)).bound < 1e-14);
    CHECK(detmath::pow(Bounded::within(0, 0, 1e-38), Bounded(0.4f)).high() >= 6.3e-16);
    CHECK(detmath::pow(-Bounded(1.0f), Bounded(0.5f)).bound == INFINITY);
}

// Expected: monotone in each argument, so that the extremes lie at the ends, whichever of them is the farthest.
TEST_CASE("bounded: exp, log and pow hold both ends of what they are given", "[bounded]") {
    auto holds = [](const Bounded& b, double x) { return b.low() <= x && x <= b.high(); };
    for (const double middle : {-2.0, 0.0, 0.5}) {
        const Bounded x = Bounded::within(float(middle), middle, 1);
        for (const double end : {middle - 1, middle + 1}) {
            CHECK(holds(detmath::exp(x), host::exp(end)));
            CHECK(holds(detmath::exp2(x), host::exp2(end)));
        }
    }
    const Bounded x = Bounded::within(1, 1, 0.75);
    for (const double end : {0.25, 1.75}) {
        CHECK(holds(detmath::log(x), host::log(end)));
        CHECK(holds(detmath::log2(x), host::log2(end)));
    }
    // Farthest are (high, high), (low, high), (low, low), (high, low).
    const struct {
        double x, x_bound, y, y_bound;
    } boxes[] = {{2, 1, 1, 1}, {0.5, 0.25, 1, 0.5}, {0.5, 0.25, -1, 0.5}, {0.2, 0.1, 1, 0.5}};
    for (const auto& box : boxes) {
        const Bounded power = detmath::pow(Bounded::within(float(box.x), box.x, box.x_bound),
                                           Bounded::within(float(box.y), box.y, box.y_bound));
        for (const double a : {box.x - box.x_bound, box.x + box.x_bound})
            for (const double b : {box.y - box.y_bound, box.y + box.y_bound}) {
                CAPTURE(a, b);
                CHECK(holds(power, host::pow(a, b)));
            }
    }
}

TEST_CASE("bounded: what may divide by 0, overflow or be no number can be anything", "[bounded]") {
    const Bounded zero(0.0f), one(1.0f), large(3e38f), nan(NAN), infinite(INFINITY);
    const Bounded small = one / Bounded(3.0f) - Bounded(0.333333333f);  // 0, as far as anybody knows
    for (const Bounded& x :
         {one / zero, one / small, one / Bounded(1e-40f), large + large, large * large, infinite - infinite,
          infinite * zero, sqrt(-one), nan + one, infinite + one, zero / zero}) {
        CAPTURE(x.value, x.shadow);
        CHECK(x.bound == INFINITY);
        CHECK((x + one).bound == INFINITY);
        CHECK((x * zero).bound == INFINITY);
        CHECK(sqrt(x).bound == INFINITY);
        CHECK(min(x, one).bound == INFINITY);
        // It can be held within a range, and then it may be anywhere in there; not so NaN.
        const Bounded held = clamp(x, Bounded(2.0f), Bounded(5.0f));
        CHECK(held.low() <= 2);
        CHECK(held.high() >= 5);
        CHECK((held.shadow != held.shadow || held.bound <= 3));
        // No comparison with it is decided.
        CHECK((x < one).slot != 0);
        CHECK((x == x).slot != 0);
    }
    CHECK((infinite < one).slot == 0);
    CHECK((Bounded(1e-40f) == zero).slot != 0);  // may be flushed
    CHECK((Bounded(-0.0f) == zero).slot == 0);
}

// ---- Decisions
// --------------------------------------------------------------------------------------------------------

namespace {

// The shadow of each component of each outcome.
std::vector<std::vector<double>> shadows(const std::vector<Outcome>& outcomes) {
    std::vector<std::vector<double>> all;
    for (const Outcome& o : outcomes) {
        all.emplace_back();
        for (const BoundedValue& v : o.values) all.back().push_back(v.shadow);
    }
    return all;
}

// 1 within a rounding or two: whether it is less than 1 is undecided.
Bounded nearly_one() { return Bounded(1.0f) / Bounded(3.0f) * Bounded(3.0f); }

// Texel (x / 1, y / 1): on a device a division by 1 may err.
void project(float x, float y, std::vector<Bounded>& values) {
    const raster::Projection map{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}, 1e-6f, -1048576, 1048576, 8};
    NoTap tap;
    const ivec2<std::int32_t> texel = raster::project<Bounded>(map, {Bounded(x), Bounded(y), Bounded(0.0f)}, tap);
    values.insert(values.end(), {Bounded(texel.x), Bounded(texel.y)});
}

}  // namespace

TEST_CASE("decisions: every comparison within the bound is undecided, and none outside", "[bounded]") {
    const Bounded near = nearly_one(), one(1.0f), two(2.0f);
    for (const BoundedMask& m : {near < one, one < near, near <= one, one <= near, near > one, near >= one, one > near,
                                 one >= near, near == one, one == near})
        CHECK(m.slot != 0);
    for (const BoundedMask& m :
         {near < two, near <= two, two > near, two >= near, one <= one, one >= one, one == one}) {
        CHECK(m.slot == 0);
        CHECK(m.value);
    }
    for (const BoundedMask& m : {two < near, two <= near, near > two, near >= two, one < one, one > one, near == two}) {
        CHECK(m.slot == 0);
        CHECK_FALSE(m.value);
    }
}

TEST_CASE("decisions: where nobody enumerates, what hangs on an undecided comparison says so", "[bounded]") {
    const BoundedMask m = nearly_one() < Bounded(1.0f);
    REQUIRE(m.slot < 0);
    const Bounded picked = select(m, Bounded(1.0f), Bounded(2.0f));
    CHECK(picked.ambiguous);
    // It stays so through every operation, and the outcome has it from any of its values.
    const Bounded three(3.0f), zero(0.0f);
    for (const Bounded& b : {picked + three, three - picked, picked * three, three * picked, picked / three,
                             three / picked, picked + zero, min(three, picked), max(picked, three),
                             clamp(picked, zero, three), abs(picked), -picked, sqrt(picked), detmath::exp(picked),
                             detmath::pow(three, picked), floor(picked), select(m, picked, picked)}) {
        CHECK(b.ambiguous);
        CHECK(outcome_of({three, b}, false).ambiguous);
    }
    CHECK(outcome_of({three}, true).ambiguous);
    CHECK_FALSE(outcome_of({three, zero}, false).ambiguous);
}

TEST_CASE("decisions: a widened select holds all that both operands may be", "[bounded]") {
    Decisions decisions;
    decisions.widen = true;
    const DecisionScope scope(decisions);
    const BoundedMask m = nearly_one() < Bounded(1.0f);
    const Bounded a = Bounded::within(1, 1, 0.25), b = Bounded::within(2, 2, 0.5);
    for (const Bounded& hull : {select(m, a, b), select(m, b, a)}) {
        CHECK(hull.low() <= 0.75);
        CHECK(hull.high() >= 2.5);
        CHECK_FALSE(hull.ambiguous);
    }
}

TEST_CASE("decisions: a projection within the bound of a texel's border gives both texels", "[bounded]") {
    std::vector<Outcome> out;
    auto at = [&](float x, float y, std::vector<std::int32_t> choices = {}) {
        enumerate_outcomes([&](std::vector<Bounded>& v) { project(x, y, v); }, most_outcomes, out, choices);
        return shadows(out);
    };
    using Texels = std::vector<std::vector<double>>;
    CHECK(at(2.5f, 1.5f) == Texels{{2, 1}});
    CHECK(at(2, 1.5f) == Texels{{2, 1}, {1, 1}});
    CHECK(at(neighbour(2, -1), 1.5f) == Texels{{1, 1}, {2, 1}});  // the float kernel's own comes first
    CHECK(at(neighbour(2, -40), 1.5f) == Texels{{1, 1}});
    CHECK(at(2, 3) == Texels{{2, 3}, {2, 2}, {1, 3}, {1, 2}});
    for (const Outcome& o : out) {
        CHECK_FALSE(o.ambiguous);
        CHECK(o.values[0].bound == 0);
    }

    // A device that says what it chose is followed, if it may choose that.
    CHECK(at(2, 1.5f, {1, 1}) == Texels{{1, 1}});
    CHECK(at(2, 1.5f, {2, 1}) == Texels{{2, 1}});
    CHECK(at(2, 1.5f, {3, 1}).empty());
    CHECK(at(2, 1.5f, {1, 0}).empty());
    CHECK(at(2.5f, 1.5f, {2, 1}) == Texels{{2, 1}});
    CHECK(at(2, 3, {1}) == Texels{{1, 3}, {1, 2}});

    // Too many texels to follow: one outcome, and nobody knows.
    CHECK(at(1e7f, 1.5f) == Texels{{1048576, 1}});
    enumerate_outcomes([&](std::vector<Bounded>& v) { v.push_back(Bounded(chosen(Bounded::within(4.5f, 4.5, 100)))); },
                       32, out);
    REQUIRE(out.size() == 1);
    CHECK(out[0].ambiguous);
}

TEST_CASE("decisions: every texel that a legal device chooses is among the outcomes", "[bounded]") {
    // Of a perspective map of 64 texels, points whose projections lie within some roundings of a border in x.
    raster::Projection map{{31, 2, 3, 40}, {1, 29, 3, 35}, {0.2f, 0.1f, 0.9f, 1.1f}, 1e-6f, -1048576, 1048576, 64};
    Random random(17);
    NoTap tap;
    std::vector<Outcome> out;
    int several = 0, differ = 0;
    for (int i = 0; i < 3000; ++i) {
        vec3<double> x{random.between(-1, 1), random.between(-1, 1), random.between(0, 1)};
        auto row = [&](const float* m) { return m[0] * x.x + m[1] * x.y + m[2] * x.z + m[3]; };
        // Solves (to_texel_x . x) = border (to_texel_w . x) for x.x, and misses it by a little.
        const double border = std::rint(row(map.to_texel_x) / row(map.to_texel_w));
        x.x -= (row(map.to_texel_x) - border * row(map.to_texel_w)) /
               (double(map.to_texel_x[0]) - border * map.to_texel_w[0]);
        x.x += random.between(-3e-6, 3e-6);
        const vec3<float> point(x);
        enumerate_outcomes(
            [&](std::vector<Bounded>& v) {
                const auto t = raster::project<Bounded>(map, vec3<Bounded>(point), tap);
                v = {Bounded(t.x), Bounded(t.y)};
            },
            most_outcomes, out);
        several += out.size() > 1;
        for (int n = 0; n < variants; ++n) {
            choose_device(n);
            const auto t = raster::project<Legal>(map, vec3<Legal>(point), tap);
            const bool found = std::any_of(out.begin(), out.end(), [&](const Outcome& o) {
                return o.values[0].shadow == t.x && o.values[1].shadow == t.y;
            });
            if (!found) FAIL("point " << i << ", device " << n << ": texel " << t.x << ", " << t.y);
            differ += out[0].values[0].shadow != t.x;
        }
    }
    CAPTURE(several, differ);
    CHECK(several < 2700);  // points lie up to 6e-5 texels from a border
    CHECK(differ > 100);
}

TEST_CASE("decisions: three undecided comparisons have eight outcomes, of six all are in the widened one", "[bounded]") {
    auto kernel = [](int comparisons) {
        return [=](std::vector<Bounded>& values) {
            Bounded sum(0.0f);
            for (int k = 0; k < comparisons; ++k)
                sum += select(nearly_one() < Bounded(1.0f), Bounded(float(1 << k)), Bounded(0.0f));
            values.push_back(sum);
        };
    };
    std::vector<Outcome> out;
    enumerate_outcomes(kernel(3), 32, out);
    REQUIRE(out.size() == 8);
    std::set<double> sums;
    for (const Outcome& o : out) {
        CHECK_FALSE(o.ambiguous);
        CHECK(o.values[0].bound < 1e-5);
        sums.insert(o.values[0].shadow);
    }
    CHECK(sums == std::set<double>{0, 1, 2, 3, 4, 5, 6, 7});
    CHECK(out[0].values[0].shadow == (nearly_one().value < 1 ? 7 : 0));

    for (int comparisons : {6, 20}) {
        enumerate_outcomes(kernel(comparisons), 16, out);
        // Among others the float kernel's own, and those that differ from it by one comparison, unless these are too many.
        const double all = double((1 << comparisons) - 1), own = out[0].values[0].shadow;
        CHECK(own == (nearly_one().value < 1 ? all : 0));
        std::set<double> found;
        for (std::size_t i = 0; i + 1 < out.size(); ++i) {
            found.insert(std::abs(out[i].values[0].shadow - own));
            CHECK(out[i].values[0].bound < 1e-4);
        }
        for (int k = 0; k < comparisons; ++k) CHECK(found.count(double(1 << k)) == (comparisons == 6 ? 1 : 0));
        for (const Outcome& o : out) CHECK_FALSE(o.ambiguous);
        const BoundedValue v = out.back().values[0];
        CHECK(v.shadow - v.bound <= 0);
        CHECK(v.shadow + v.bound >= all);
        CHECK(v.bound <= 1.0001 * all);
    }
}

TEST_CASE("decisions: of many undecided texels each is an outcome, and what they add up to is ambiguous", "[bounded]") {
    // Six samples, each on a border between a texel with 0 and one with 2^k: their sum is any number up to 63.
    auto kernel = [](std::vector<Bounded>& values) {
        Bounded sum(0.0f);
        for (int k = 0; k < 6; ++k)
            sum += Bounded(float(1 << k)) * Bounded(number<Bounded>::from_index(chosen(nearly_one())));
        values.push_back(sum);
    };
    std::vector<Outcome> out;
    enumerate_outcomes(kernel, 16, out);
    REQUIRE(out.size() > 2);
    const double own = out[0].values[0].shadow;
    std::set<double> decided;
    for (const Outcome& o : out)
        if (!o.ambiguous) decided.insert(std::abs(o.values[0].shadow - own));
    for (int k = 0; k < 6; ++k) CHECK(decided.count(double(1 << k)) == 1);
    CHECK(out[out.size() - 2].ambiguous);  // widened: an index says nothing
    const BoundedValue sum = out.back().values[0];
    CHECK(out.back().ambiguous);
    CHECK(sum.shadow - sum.bound <= 0);
    CHECK(sum.shadow - sum.bound > -0.01);
    CHECK(sum.shadow + sum.bound >= 63);
    CHECK(sum.shadow + sum.bound < 63.01);
}

TEST_CASE("decisions: a texel that decides is found behind five that do not", "[bounded]") {
    auto kernel = [](std::vector<Bounded>& values) {
        for (int k = 0; k < 5; ++k) chosen(nearly_one());
        values.push_back(Bounded(chosen(nearly_one()) == 1 ? 7.0f : 3.0f));
    };
    std::vector<Outcome> out;
    enumerate_outcomes(kernel, 16, out);
    std::set<double> decided;
    for (const Outcome& o : out)
        if (!o.ambiguous) decided.insert(o.values[0].shadow);
    CHECK(decided == std::set<double>{3, 7});
}

TEST_CASE("decisions: only those that matter are followed, and those of another branch too", "[bounded]") {
    std::vector<Outcome> out;
    // One comparison that picks three values is one decision, also when it is negated.
    enumerate_outcomes(
        [](std::vector<Bounded>& v) {
            const BoundedMask m = nearly_one() < Bounded(1.0f);
            for (float x : {1.0f, 2.0f}) v.push_back(select(m, Bounded(x), Bounded(-x)));
            v.push_back(select(!m, Bounded(-4.0f), Bounded(4.0f)));
        },
        32, out);
    REQUIRE(out.size() == 2);
    for (const auto& s : shadows(out))
        CHECK((s == std::vector<double>{1, 2, 4} || s == std::vector<double>{-1, -2, -4}));

    // false & undecided is false, true | undecided is true.
    enumerate_outcomes(
        [](std::vector<Bounded>& v) {
            const BoundedMask m = nearly_one() < Bounded(1.0f), no = Bounded(2.0f) < Bounded(1.0f);
            v = {select(no & m, Bounded(1.0f), Bounded(0.0f)), select(m & no, Bounded(1.0f), Bounded(0.0f)),
                 select((!no) | m, Bounded(1.0f), Bounded(0.0f)), select(m | (!no), Bounded(1.0f), Bounded(0.0f))};
        },
        32, out);
    CHECK(shadows(out) == std::vector<std::vector<double>>{{0, 0, 1, 1}});

    // Of m & n three outcomes: n is asked where m holds.
    int runs = 0;
    enumerate_outcomes(
        [&](std::vector<Bounded>& v) {
            ++runs;
            const BoundedMask m = nearly_one() < Bounded(1.0f), n = Bounded(1.0f) < nearly_one();
            v.push_back(select(m & n, Bounded(1.0f), Bounded(0.0f)));
        },
        32, out);
    CHECK(runs == 3);

    // A branch that only a device takes has a choice of its own.
    enumerate_outcomes(
        [](std::vector<Bounded>& v) {
            const bool own = nearly_one().value < 1;
            if (any(nearly_one() < Bounded(1.0f)) == own) return v.push_back(Bounded(1.0f));
            v.push_back(floor(nearly_one() * Bounded(8.0f)));
        },
        32, out);
    REQUIRE(out.size() == 3);
    CHECK(shadows(out)[0][0] == 1);
    CHECK(std::abs(shadows(out)[1][0] - shadows(out)[2][0]) == 1);
}

TEST_CASE("decisions: an index or bits that hang on what is undecided make a widened outcome ambiguous", "[bounded]") {
    std::vector<Outcome> out;
    auto ambiguous = [&](auto&& kernel) {
        enumerate_outcomes([&](std::vector<Bounded>& v) { v.push_back(kernel()); }, 1, out);
        return out.back().ambiguous;
    };
    using N = number<Bounded>;
    CHECK(ambiguous([] { return Bounded(select(nearly_one() < Bounded(1.0f), 1, 2)); }));
    CHECK_FALSE(ambiguous([] { return Bounded(select(nearly_one() < Bounded(1.0f), 2, 2)); }));
    CHECK(ambiguous([] { return Bounded(N::truncate_to_index(nearly_one())); }));
    CHECK(ambiguous([] { return Bounded(N::round_to_index(nearly_one() * Bounded(2.5f))); }));
    CHECK(ambiguous([] { return N::from_bits(N::bits(nearly_one())); }));
    CHECK(ambiguous([] { return Bounded(N::truncate_to_index(Bounded(INFINITY))); }));
    CHECK_FALSE(ambiguous([] { return Bounded(N::round_to_index(nearly_one())); }));
    CHECK_FALSE(ambiguous([] { return floor(nearly_one()); }));  // its bound is 1 then
    CHECK(out.back().values[0].bound >= 1);
}

// ---- Device profiles
// --------------------------------------------------------------------------------------------------

TEST_CASE("device profiles: those that are known, and the name that was meant", "[bounded]") {
    std::vector<std::string> names;
    for (const DeviceProfile& d : device_profiles()) names.push_back(d.name);
    CHECK(names == std::vector<std::string>{"ideal", "lavapipe-22.3-fma", "lavapipe-22.3-sse4.1", "swiftshader", "nvidia-hopper-580"});
    const DeviceProfile& d = find_profile("lavapipe-22.3-sse4.1", "--profile");
    CHECK(d.half_store == HalfStore::truncate);
    CHECK_FALSE(d.half_store_either);
    CHECK_FALSE(d.fused_raster);
    CHECK(find_profile("lavapipe-22.3-fma", "--profile").fused_raster);
    CHECK(find_profile("swiftshader", "--profile").subpixel_bits == 4);
    // As probes found them (data/parity): lavapipe's planes start at the origin and its halves are cut, SwiftShader's
    // start at a corner; both take fp32 weights and place vertices where they are emulated.
    for (const char* name : {"lavapipe-22.3-fma", "lavapipe-22.3-sse4.1", "swiftshader"}) {
        const DeviceProfile& p = find_profile(name, "--profile");
        const bool lavapipe = p.name != "swiftshader";
        CAPTURE(p.name);
        CHECK(p.driver == (lavapipe ? "llvmpipe, Mesa 22.3." : "SwiftShader"));
        CHECK(p.interpolation == (lavapipe ? Interpolation::plane_equation : Interpolation::snapped_planes));
        CHECK(p.subpixel_bits == (lavapipe ? 8 : 4));
        CHECK(p.snap_uncertainty == 0);
        CHECK(p.bilinear_weight_bits == 0);
        CHECK(p.half_store == (lavapipe ? HalfStore::truncate : HalfStore::nearest));
        CHECK(p.half_store_either == !lavapipe);
        CHECK(p.precision.flushes_denormals == !lavapipe);
        for (const double correct : {p.precision.add, p.precision.multiply, p.precision.divide, p.precision.sqrt})
            CHECK(correct == 0.5);
        CHECK(p.precision.inverse_sqrt == 1.5);
        CHECK(p.precision.exp2 == (lavapipe ? 3.5 : 3));
        CHECK(p.precision.exp2_slope == (lavapipe ? 1.2 : 2));
        CHECK(p.precision.log2_absolute == (lavapipe ? 2e-6 : 0x1p-21));
    }
    try {
        find_profile("swiftshade", "plumb.toml: device");
        FAIL("accepted");
    } catch (const InputError& e) {
        CHECK(std::string(e.what()) ==
              "plumb.toml: device: device profile \"swiftshade\" is unknown; the nearest known one is \"swiftshader\"");
    }
}

TEST_CASE("device profiles: a scope sets what operations may err, and ends", "[bounded]") {
    auto quotient = [] { return (Bounded(2.0f) / Bounded(3.0f)).bound; };
    const double by_vulkan = quotient();
    {
        const PrecisionScope scope(find_profile("lavapipe-22.3-fma", "").precision);  // keeps denormals
        CHECK(quotient() < by_vulkan / 3);
        CHECK((Bounded(1e-40f) * Bounded(0.7f)).bound < 1e-44);
        // Bits of IEEE arithmetic stay inside.
        Random random(9);
        for (int i = 0; i < 20000; ++i) {
            const std::vector<float> in = random_inputs(random);
            for (const Expression& e : expressions) {
                if (i >= e.inputs) continue;
                const Bounded b = e.bounded(in.data());
                if (!(std::abs(double(b.value) - b.shadow) <= b.bound)) FAIL(e.name);
            }
        }
    }
    {
        const PrecisionScope scope(find_profile("swiftshader", "").precision);  // takes them for 0
        CHECK((Bounded(1e-40f) * Bounded(0.7f)).bound > 1e-41);
    }
    CHECK(quotient() == by_vulkan);
}
