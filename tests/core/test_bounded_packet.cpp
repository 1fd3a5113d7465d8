// BoundedPacket has, item by item, the bits of Bounded: each operation on numbers of every kind, and long random
// programs. Expected is always what Bounded computes alone.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/bounded_packet.h"
#include "core/device_profile.h"
#include "core/inexact_inputs.h"
#include "legal_device.h"

using namespace plumb;

namespace {

constexpr int lanes = PacketData::lanes;
constexpr float infinite = __builtin_inff(), not_a_number = __builtin_nanf("");

// The same bits; of a NaN no more than that it is one.
template <class T>
bool same(T a, T b) {
    return std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b);
}
bool same(const Bounded& a, const Bounded& b) {
    return same(a.value, b.value) && same(a.shadow, b.shadow) && same(a.bound, b.bound) && a.additions == b.additions &&
           a.blend == b.blend && (a.additions == 0 || same(a.magnitude, b.magnitude));
}

// One number of a program, sixteen times: as a packet, and each alone.
struct Both {
    BoundedPacket packet;
    Bounded alone[lanes];
};

Both exactly(const float* values) {
    Both r;
    r.packet = number<BoundedPacket>::fetch(values, number<BoundedPacket>::iota(0));
    for (int i = 0; i < lanes; ++i) r.alone[i] = Bounded(values[i]);
    return r;
}

// What Bounded alone finds undecided; items are compared as long as nothing was.
struct Reference {
    Decisions decisions;
    std::uint32_t left = 0;

    template <class Of>
    void each(Of of) {
        const DecisionScope scope(decisions);
        for (int i = 0; i < lanes; ++i) {
            decisions.begin();
            of(i);
            if (decisions.met() > 0 || decisions.ambiguous) left |= 1u << i;
        }
    }
};

struct Programs {
    test::Random random;
    Reference reference;
    std::vector<Both> numbers;
    int wrong = 0, compared = 0;

    explicit Programs(int seed) : random(std::uint64_t(seed)) {}

    float special() {
        static const float of[] = {0, -0.0f, 1, -1, 2, 0.5f, -4, 1e-3f, 3, 0x1p-126f, 0x1p-130f, 0x1.8p-127f, 0x1p126f,
                                   0x1.fffffep127f, infinite, -infinite, not_a_number};
        return of[random.below(17)];
    }
    float plain() { return float(random.between(-3, 3)) * (random.below(4) ? 1.0f : float(std::exp2(random.between(-20, 20)))); }
    // `strange`: one in so many numbers is a special one; 0: none.
    Both input(int strange) {
        float values[lanes];
        const bool flat = random.below(3) == 0;  // one number for many items, as an axis or a plane is
        const float common = random.below(2) ? 0.0f : plain();
        for (float& v : values) {
            v = flat && random.below(4) ? common : plain();
            if (strange && random.below(strange) == 0) v = special();
        }
        return exactly(values);
    }

    template <class Packet, class Alone>
    void compute(Packet packet, Alone alone) {
        Both r;
        r.packet = packet();
        reference.each([&](int i) { r.alone[i] = alone(i); });
        check(r);
        numbers[std::size_t(random.below(int(numbers.size())))] = std::move(r);
    }
    void check(const Both& b) {
        for (int i = 0; i < lanes; ++i) {
            if ((packet_state.left | reference.left) >> i & 1) continue;
            ++compared, wrong += !same(BoundedPacket::lane(*b.packet, i), b.alone[i]);
        }
    }

    template <class Packet, class Alone>
    void decide(Packet packet, Alone alone, const Both& a, const Both& b) {
        const PacketMask m = packet();
        bool value[lanes], undecided[lanes];
        reference.each([&](int i) {
            const BoundedMask own = alone(i);
            value[i] = own.value, undecided[i] = own.slot != 0;
        });
        for (int i = 0; i < lanes; ++i) {
            if ((packet_state.left | reference.left) >> i & 1) continue;
            ++compared;
            wrong += (m.value >> i & 1) != value[i] || (m.undecided >> i & 1) != undecided[i];
            if (undecided[i]) reference.left |= 1u << i;
        }
        compute([&] { return select(m, a.packet, b.packet); },
                [&](int i) { return value[i] ? a.alone[i] : b.alone[i]; });
    }

    void step(bool functions) {
        const Both a = pick(), b = pick(), c = pick();
        const auto two = [&](auto f) {
            compute([&] { return f(a.packet, b.packet); }, [&](int i) { return f(a.alone[i], b.alone[i]); });
        };
        const auto one = [&](auto f) {
            compute([&] { return f(a.packet); }, [&](int i) { return f(a.alone[i]); });
        };
        switch (random.below(functions ? 24 : 16)) {
            case 0: case 1: return two([](auto x, auto y) { return x + y; });
            case 2: case 3: return two([](auto x, auto y) { return x - y; });
            case 4: case 5: case 6: return two([](auto x, auto y) { return x * y; });
            case 7: return two([](auto x, auto y) { return x / y; });
            case 8: return two([](auto x, auto y) { return min(x, y); });
            case 9: return two([](auto x, auto y) { return max(x, y); });
            case 10: return one([](auto x) { return -x; });
            case 11: return one([](auto x) { return abs(x); });
            case 12: return one([](auto x) { return sqrt(abs(x)); });
            case 13:
                return decide([&] { return a.packet < b.packet; }, [&](int i) { return a.alone[i] < b.alone[i]; }, a, b);
            case 14:
                return decide([&] { return a.packet <= c.packet; }, [&](int i) { return a.alone[i] <= c.alone[i]; }, a, b);
            case 15:
                return compute([&] { return clamp(a.packet, b.packet, c.packet); },
                               [&](int i) { return clamp(a.alone[i], b.alone[i], c.alone[i]); });
            case 16: return one([](auto x) { return sqrt(x); });
            case 17: return one([](auto x) { return floor(x); });
            case 18: return one([](auto x) { return detmath::exp2(x); });
            case 19: return one([](auto x) { return detmath::log(abs(x)); });
            case 20: return two([](auto x, auto y) { return detmath::pow(abs(x), y); });
            case 21: return one([](auto x) { return detmath::sin(x); });
            case 22: return one([](auto x) {
                using F = decltype(x);
                return number<F>::from_index(number<F>::truncate_to_index(clamp(x, F(-1000.0f), F(1000.0f))));
            });
            case 23:
                return decide([&] { return a.packet == b.packet; }, [&](int i) { return a.alone[i] == b.alone[i]; }, a, b);
        }
    }
    const Both& pick() { return numbers[std::size_t(random.below(int(numbers.size())))]; }

    void run(int steps, int strange, bool functions) {
        for (int i = 0; i < 12; ++i) numbers.push_back(input(strange));
        for (int i = 0; i < steps; ++i) {
            if (random.below(6) == 0) numbers[std::size_t(random.below(12))] = input(strange);
            step(functions);
        }
    }
};

template <class F>
F gather(const float* in, std::ptrdiff_t stride, index_t<F> item) {
    const auto at = [&](int k) { return number<F>::fetch(in + k * stride, item); };
    F sum(0.0f);
    for (int k = 0; k < 400; ++k) {
        const F x = at(3 * k) - at(0), y = at(3 * k + 1) - at(1), z = at(3 * k + 2) - at(2);
        const F square = max(x * x + y * y + z * z, F(1e-37f)), cosine = max(F(0.0f), x * F(0.6f) + z * F(0.8f));
        sum += F(0.25f) * (cosine / (square * square));
    }
    return sum * F(0.318309873f);
}

}  // namespace

TEST_CASE("bounded packets: random programs have Bounded's bits in every lane, on every instruction set", "[bounded][packet]") {
    for (const Isa isa : supported_isas())
        for (const char* profile : {"ideal", "lavapipe-22.3-fma", "nvidia-hopper-580"}) {
            const PrecisionScope precision(find_profile(profile, "test").precision);
            int compared = 0, wrong = 0;
            for (int seed = 0; seed < 400; ++seed) {
                const PacketScope scope(isa);
                Programs p(seed);
                p.run(60, seed % 4 == 0 ? 0 : 40 >> seed % 4, seed % 3 == 0);
                compared += p.compared, wrong += p.wrong;
            }
            INFO(isa_name(isa) << ", " << profile);
            CHECK(compared > 150000);
            CHECK(wrong == 0);
        }
}

TEST_CASE("bounded packets: every operation on every pair of special numbers", "[bounded][packet]") {
    const float of[] = {0, -0.0f, 1, -1, 2, -0.5f, 0.3f, -7.7f, 1e-3f, 0x1p-126f, -0x1p-130f, 0x1.8p-127f, 0x1p126f,
                        -0x1.fffffep127f, infinite, not_a_number};
    for (const Isa isa : supported_isas()) {
        const PacketScope scope(isa);
        int wrong = 0;
        const Both a = exactly(of);
        for (int turn = 0; turn < lanes; ++turn) {
            float turned[lanes];
            for (int i = 0; i < lanes; ++i) turned[i] = of[(i + turn) % lanes];
            const Both b = exactly(turned);
            const auto check = [&](auto f) {
                const BoundedPacket r = f(a.packet, b.packet);
                for (int i = 0; i < lanes; ++i) wrong += !same(BoundedPacket::lane(*r, i), f(a.alone[i], b.alone[i]));
            };
            check([](auto x, auto y) { return x + y; });
            check([](auto x, auto y) { return x - y; });
            check([](auto x, auto y) { return x * y; });
            check([](auto x, auto y) { return x / y; });
            check([](auto x, auto y) { return min(x, y); });
            check([](auto x, auto y) { return max(x, y); });
            check([](auto x, auto y) { return clamp(x, y, -y); });
            check([](auto x, auto y) { return sqrt(x * y); });
            check([](auto x, auto y) { return (x + y) * y - x * (x - y); });
            check([](auto x, auto y) { return (x * y + y * y) * (x / y) + (x - y) * (y + x); });
            check([](auto x, auto y) { return -abs(x - y * y); });
        }
        INFO(isa_name(isa));
        CHECK(wrong == 0);
    }
}

// Sums of 400 terms, in which additions, totals and zeros add up; as many as a gather has.
TEST_CASE("bounded packets: a gather of 400 samples", "[bounded][packet]") {
    test::Random random(7);
    std::vector<float> in(1200 * lanes);
    for (float& x : in) x = random.below(9) ? float(random.between(-2, 2)) : 0.5f;
    for (const Isa isa : supported_isas()) {
        const PacketScope scope(isa);
        const BoundedPacket packet = gather<BoundedPacket>(in.data(), lanes, number<BoundedPacket>::iota(0));
        int wrong = 0;
        for (int i = 0; i < lanes; ++i)
            wrong += !same(BoundedPacket::lane(*packet, i), gather<Bounded>(in.data(), lanes, i));
        INFO(isa_name(isa));
        CHECK(wrong == 0);
        CHECK(scope.left() == 0);
        CHECK(packet->bound[0] > 0);
    }
}

TEST_CASE("bounded packets: what is undecided leaves an item, and only where it matters", "[bounded][packet]") {
    const PacketScope scope(best_isa());
    float a[lanes], b[lanes];
    for (int i = 0; i < lanes; ++i) a[i] = 1.3f + float(i), b[i] = a[i];
    b[3] = 5.0f;
    const auto x = exactly(a).packet * BoundedPacket(0.3f), y = exactly(b).packet * BoundedPacket(0.3f);
    const PacketMask less = x < y, never = BoundedPacket(1.0f) < BoundedPacket(0.0f);
    CHECK(less.undecided == (PacketData::all & ~8u));
    CHECK(less.value == 8);
    CHECK_FALSE(any(less & never));
    CHECK(any(less | !never));
    CHECK(scope.left() == 0);
    (void)select(less & (number<BoundedPacket>::iota(0) < PacketIndex(5)), x, y);
    CHECK(scope.left() == (0x1fu & ~8u));
    // An index between two numbers; bits of what is inexact.
    (void)number<BoundedPacket>::round_to_index(BoundedPacket(0.5f));
    CHECK(scope.left() == (0x1fu & ~8u));
    (void)chosen(x / BoundedPacket(0.3f) - BoundedPacket(0.3f));
    CHECK((scope.left() >> 8) == 0xff);
    (void)number<BoundedPacket>::bits(x);
    CHECK(scope.left() == PacketData::all);
}

TEST_CASE("bounded packets: indices wrap, shift and compare as one index does", "[bounded][packet]") {
    test::Random random(5);
    const PacketScope scope(best_isa());
    using I = PacketIndex;
    int wrong = 0;
    for (int trial = 0; trial < 200; ++trial) {
        I a, b;
        for (int i = 0; i < lanes; ++i) a.v[i] = std::int32_t(random.next()) >> random.below(31), b.v[i] = std::int32_t(random.next()) >> random.below(31);
        const auto check = [&](auto f) {
            const I r = f(a, b);
            for (int i = 0; i < lanes; ++i) wrong += r.v[i] != f(std::int32_t(a.v[i]), std::int32_t(b.v[i]));
        };
        const auto compare = [&](auto f) {
            const PacketMask m = f(a, b);
            for (int i = 0; i < lanes; ++i)
                wrong += (m.value >> i & 1) != std::uint32_t(f(std::int32_t(a.v[i]), std::int32_t(b.v[i]))) || m.undecided;
        };
        check([](auto x, auto y) { return x + y; });
        check([](auto x, auto y) { return x - y; });
        check([](auto x, auto y) { return x * y; });
        check([](auto x, auto y) { return (x & y) ^ (x | ~y); });
        check([](auto x, auto) { return (x << 3) ^ (x >> 2); });
        check([](auto x, auto) { return shift_right(x, 5); });
        check([](auto x, auto y) { return min(x, y); });
        check([](auto x, auto y) { return max(x, y); });
        check([](auto x, auto y) { return select(x < y, x, y); });
        compare([](auto x, auto y) { return x < y; });
        compare([](auto x, auto y) { return x <= y; });
        compare([](auto x, auto y) { return x > y; });
        compare([](auto x, auto y) { return x >= y; });
        compare([](auto x, auto y) { return x == y; });
        compare([](auto x, auto y) { return in_range(x, max(y, decltype(y)(1))); });
    }
    CHECK(wrong == 0);
}

TEST_CASE("bounded packets: what is fetched alone is as inexact as its texel", "[bounded][packet]") {
    test::Random random(11);
    std::vector<float> numbers(4 * lanes), moved(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = float(random.between(-2, 2)), moved[i] = float(i % 3) * 1e-4f;
    const InexactRange range{numbers.data(), moved.data(), std::ptrdiff_t(numbers.size())};
    const InexactScope inexact(std::span(&range, 1));
    for (const Isa isa : supported_isas()) {
        const PacketScope scope(isa);
        const PacketIndex at = number<BoundedPacket>::iota(7) * PacketIndex(2);
        const BoundedPacket fetched = number<BoundedPacket>::fetch(numbers.data(), at);
        for (int i = 0; i < lanes; ++i) {
            const Bounded alone = number<Bounded>::fetch(numbers.data(), at.v[i]);
            CAPTURE(isa_name(isa), i);
            CHECK(same(BoundedPacket::lane(*fetched, i), alone));
            CHECK(alone.bound == double(moved[std::size_t(at.v[i])]));
        }
    }
}
