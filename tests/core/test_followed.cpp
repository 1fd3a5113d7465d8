// Followed: a float to the bit, a double along its decisions, and nothing that either decides by itself.
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "core/detmath.h"

namespace plumb::test {

// A formula with every kind of decision: branches, an index, a floor; and min, max and abs, which decide nothing.
template <class F>
static F winding(F a, F b) {
    using N = number<F>;
    const index_t<F> k = N::truncate_to_index(floor(a * F(3.0f))) & 7;
    F sum = a / (b + F(1.5f));
    for (index_t<F> i = 0; i < k; ++i) sum += sqrt(abs(a - b)) * N::from_index(i);
    sum = select((a < b) & !(sum >= F(4.0f)), sum * b, sum - min(a, max(b, F(0.25f))));
    return sum + N::from_index(N::round_to_index(b * F(10.0f)));
}

static Followed followed(DecisionTape& tape, float a, float b) {
    const FollowScope scope(tape);
    return winding(Followed(a), Followed(b));
}

}  // namespace plumb::test

using namespace plumb;
using namespace plumb::test;

TEST_CASE("followed: the value is the float kernel's to the bit, the other the double kernel's", "[followed]") {
    int flipped = 0;
    for (int i = 0; i < 4000; ++i) {
        // 10 b lies on a tie for every other b, where no float does: there float and double round to other numbers.
        const float a = float(i % 63 - 21) / 30, b = float(i / 63 - 18) / 20;
        CAPTURE(a, b);
        DecisionTape tape;
        const Followed f = followed(tape, a, b);
        const float value = winding(a, b);
        REQUIRE(number<float>::bits(f.value) == number<float>::bits(value));
        if (tape.flips() == 0)
            CHECK(f.exact == winding(double(a), double(b)));
        else
            ++flipped;
        tape.follow();
        CHECK(followed(tape, a, b).exact == f.exact);
        CHECK(tape.at_end());
    }
    CHECK(flipped > 0);
    CHECK(flipped < 2000);
}

TEST_CASE("followed: double takes float's side of a comparison, and that is counted", "[followed]") {
    DecisionTape tape;
    const FollowScope scope(tape);
    const Followed one(1.0f), small(1e-9f);
    // 1 + 1e-9 is 1 in float.
    const Followed r = select(one + small > one, Followed(7.0f), Followed(3.0f));
    CHECK(r.value == 3);
    CHECK(r.exact == 3);
    CHECK(tape.flips() == 1);
    CHECK(tape.size() == 1);

    // min, max and abs have no side to take.
    const Followed m = max(one + small, one);
    CHECK(m.value == 1);
    CHECK(m.exact == 1.0 + double(1e-9f));
    CHECK(abs(-small).exact == double(1e-9f));
    CHECK(tape.size() == 1);
}

TEST_CASE("followed: what was recorded is followed, whatever the inputs have become", "[followed]") {
    auto run = [](DecisionTape& tape, float x) {
        const FollowScope scope(tape);
        const Followed whole = floor(Followed(x));
        return Followed(x) - whole + select(Followed(x) < Followed(2.0f), Followed(10.0f), Followed(20.0f));
    };
    DecisionTape tape;
    CHECK(run(tape, 1.75f).exact == 10.75);
    tape.follow();
    CHECK(run(tape, 2.25f).exact == 11.25);  // from 1, and on the side below 2
    CHECK(tape.flips() == 2);
    tape.record();
    CHECK(run(tape, 2.25f).exact == 20.25);
    CHECK(tape.flips() == 0);
}

TEST_CASE("followed: more decisions than were recorded are an error, fewer are seen", "[followed]") {
    DecisionTape tape;
    auto ask = [&](int times) {
        const FollowScope scope(tape);
        for (int i = 0; i < times; ++i) (void)(Followed(1.0f) < Followed(2.0f));
    };
    ask(2);
    tape.follow();
    CHECK_THROWS_AS(ask(3), std::logic_error);
    tape.follow();
    ask(1);
    CHECK_FALSE(tape.at_end());
    ask(1);
    CHECK(tape.at_end());
}

TEST_CASE("followed: whole parts of what is huge, negative or no number", "[followed]") {
    for (const float x : {-0.0f, -0.5f, -1e-40f, 1e9f, -3e38f, 8388609.0f, INFINITY, -INFINITY}) {
        CAPTURE(x);
        DecisionTape tape;
        const FollowScope scope(tape);
        const Followed f = floor(Followed(x));
        CHECK(number<float>::bits(f.value) == number<float>::bits(floor(x)));
        CHECK(f.exact == std::floor(double(x)));
        CHECK(tape.flips() == 0);
    }
    DecisionTape tape;
    const FollowScope scope(tape);
    CHECK(std::isnan(floor(Followed(NAN)).value));
}

TEST_CASE("followed: elementary functions decide nothing", "[followed][detmath]") {
    DecisionTape tape;
    const FollowScope scope(tape);
    for (const float x : {1e-30f, 0.3f, 0.999f}) {
        CAPTURE(x);
        const Followed f(x);
#define CHECK_FUNCTION(name)                                                                     \
    CHECK(number<float>::bits(detmath::name(f).value) == number<float>::bits(detmath::name(x))); \
    CHECK(detmath::name(f).exact == host::name(double(x)))
        CHECK_FUNCTION(exp);
        CHECK_FUNCTION(exp2);
        CHECK_FUNCTION(log);
        CHECK_FUNCTION(log2);
        CHECK_FUNCTION(sin);
        CHECK_FUNCTION(cos);
        CHECK_FUNCTION(acos);
#undef CHECK_FUNCTION
        CHECK(detmath::pow(f, Followed(2.5f)).value == detmath::pow(x, 2.5f));
        CHECK(detmath::pow(f, Followed(2.5f)).exact == host::pow(double(x), 2.5));
    }
    CHECK(tape.size() == 0);
}
