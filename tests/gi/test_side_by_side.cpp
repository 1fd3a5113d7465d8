// One pixel's values on both sides. Values are made by hand; what twins write is tests/program/test_explain_device.cpp.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "gi/parity/side_by_side.h"

using namespace plumb;
using parity::SideBySide;
using parity::side_by_side;

namespace {

using Names = std::vector<std::string>;

const std::vector<std::string> all = {"x", "texel", "sum", "e"};

// A loop of n samples: texel and sum of each, and what follows it.
std::vector<TapValue> loop(int n) {
    std::vector<TapValue> values = {{"x", -1, {1, 2, 3}, "position"}};
    for (int k = 0; k < n; ++k) {
        values.push_back({"texel", k, {double(10 * k), 7}, "q"});
        values.push_back({"sum", k, {0.5 * k}, "(3.2)"});
    }
    values.push_back({"e", -1, {0.25}, "(3.2)"});
    return values;
}

Names names_of(const SideBySide& s) {
    Names names;
    for (const parity::TwoValues& l : s.lines)
        names.push_back(l.name + (l.sample >= 0 ? std::to_string(l.sample) : ""));
    return names;
}

}  // namespace

TEST_CASE("side by side: equal values part nowhere", "[parity][explain]") {
    const SideBySide s = side_by_side(loop(3), loop(3), all);
    CHECK(!s.parts_at);
    CHECK(s.compared == 8);
    CHECK(s.lines[1].equation == "q");
    for (const parity::TwoValues& l : s.lines) CHECK((l.same && l.ulp == 0 && l.ours == l.theirs));
}

TEST_CASE("side by side: the first line that differs is where they part", "[parity][explain]") {
    auto theirs = loop(3);
    theirs[4].value[0] = double(std::nextafter(0.5f, 1.0f));  // sum of sample 1
    theirs[6].value[0] = 2;                                   // 1 -> 2: 2^23 floats
    const SideBySide s = side_by_side(loop(3), theirs, all);
    REQUIRE(s.parts_at == std::size_t(4));
    CHECK(s.lines[4].ulp == 1);
    CHECK(s.lines[6].ulp == 1u << 23);
    CHECK(s.lines[7].same);
}

TEST_CASE("side by side: bits are compared, and one component is enough", "[parity][explain]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    auto parts = [](double a, double b) {
        const std::vector<TapValue> ours = {{"x", -1, {1, a}, ""}}, theirs = {{"x", -1, {1, b}, ""}};
        return side_by_side(ours, theirs, {"x"}).parts_at.has_value();
    };
    CHECK(!parts(nan, -nan));
    CHECK(parts(nan, 1));
    CHECK(parts(1, nan));
    CHECK(!parts(0.0, -0.0));
    CHECK(parts(0.0, -1e-45f));
    CHECK(parts(1, INFINITY));
    CHECK(parts(-1, 1));
    CHECK(!parts(16777217, 16777216));  // an integer, as the float that the device wrote
    CHECK(side_by_side({{"x", -1, {1}, ""}}, {{"x", -1, {1, 1}, ""}}, {"x"}).parts_at == std::size_t(0));
    // The sign of a zero is told apart all the same; beside another difference it does not count.
    const SideBySide zeros = side_by_side({{"x", -1, {0, 1}, ""}}, {{"x", -1, {-0.0, 1}, ""}}, {"x"});
    CHECK((zeros.signs == 1 && zeros.lines[0].ulp == 1 && zeros.lines[0].same));
    CHECK(side_by_side({{"x", -1, {0, 1}, ""}}, {{"x", -1, {-0.0, 2}, ""}}, {"x"}).signs == 0);
}

TEST_CASE("side by side: a loop that ended early is aligned by sample", "[parity][explain]") {
    // The device made one sample less: its sample 2 is missing, and what follows goes together.
    const SideBySide fewer = side_by_side(loop(3), loop(2), all);
    CHECK(names_of(fewer) == Names{"x", "texel0", "sum0", "texel1", "sum1", "texel2", "sum2", "e"});
    CHECK(fewer.parts_at == std::size_t(5));
    CHECK(!fewer.lines[5].theirs);
    CHECK(fewer.lines[7].same);
    // One more: it stands before the end, where it came about.
    const SideBySide more = side_by_side(loop(2), loop(3), all);
    CHECK(names_of(more) == names_of(fewer));
    CHECK(more.parts_at == std::size_t(5));
    CHECK(!more.lines[5].ours);
    CHECK(more.lines[7].same);
    // None at all.
    CHECK(side_by_side(loop(1), {}, all).parts_at == std::size_t(0));
    CHECK(side_by_side({}, loop(1), all).lines.size() == 4);
}

TEST_CASE("side by side: what the twin does not name is shown and not compared", "[parity][explain]") {
    auto ours = loop(1);
    ours.insert(ours.begin(), {"object", -1, {4}, "index"});
    const SideBySide s = side_by_side(ours, loop(1), all);
    CHECK(!s.parts_at);
    CHECK(s.compared == 4);
    CHECK(!s.lines[0].compared);
    // A name that occurs twice goes by its turn.
    const std::vector<TapValue> two = {{"n", -1, {1}, ""}, {"n", -1, {2}, ""}}, one = {{"n", -1, {1}, ""}};
    CHECK(side_by_side(two, one, {"n"}).parts_at == std::size_t(1));
}
