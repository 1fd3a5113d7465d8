// Verdicts where little or nothing can be judged: black that is expected, and pixels that were never written.
#include <array>
#include <catch2/catch.hpp>
#include <limits>

#include "core/outcomes.h"
#include "gi/parity/verdict.h"

using namespace plumb;
using parity::Verdict;

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr int side = 20;

std::int64_t count(const parity::StageVerdict& v, Verdict verdict) { return v.count[std::size_t(verdict)]; }

// Writes 0 in the columns below `black`, 1 in the others, legally +- 0.01, and ambiguous in the last row; the w of four
// components is `w`.
struct HalfBlack {
    int black = side, channels = 1;
    float w = 1;
    std::vector<Slot> reads;
    StageData data;

    HalfBlack() { data.stage = data.label = "half black", data.size = {side, side}; }

    std::vector<float> values() const {
        std::vector<float> v;
        for (int i = 0; i < side * side; ++i)
            for (int c = 0; c < channels; ++c) v.push_back(c == 3 ? w : i % side < black ? 0.0f : 1.0f);
        return v;
    }
    parity::StageVerdict judge(const std::vector<float>& dumped, const parity::JudgeOptions& options = {},
                               std::vector<std::uint8_t> unwritten = {}) const;
};

const HalfBlack* bound_half_black = nullptr;

// Judged alone: nothing of it is followed or explained.
struct HalfBlackStage final : BoundStage {
    void follow(glm::ivec2, DecisionTape&, std::vector<Followed>&) const override { FAIL("nobody follows it"); }
    std::vector<TapValue> explain(glm::ivec2, const DeviceProfile&) const override { return {}; }
    void run(const RunOptions&, const DeviceProfile&, Bundle& outputs) const override {
        const std::vector<float> v = bound_half_black->values();
        add(outputs, "value", {side, side, bound_half_black->channels}, v.data());
    }
    void outcomes(glm::ivec2 pixel, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t>,
                  std::vector<Outcome>& out) const override {
        const double x = pixel.x < bound_half_black->black ? 0 : 1;
        std::vector<BoundedValue> values(std::size_t(bound_half_black->channels), {x, 0.01});
        if (values.size() == 4) values[3] = {bound_half_black->w, 0};
        out.push_back({values, pixel.y == side - 1});
    }
};

parity::StageVerdict HalfBlack::judge(const std::vector<float>& dumped, const parity::JudgeOptions& options,
                                      std::vector<std::uint8_t> unwritten) const {
    StageBinding b;
    b.info.name = "half black";
    b.inputs = reads;
    b.outputs = {{.name = "value", .kind = SlotKind::storage_image, .channels = channels}};
    b.bind = [](const StageData&) -> std::unique_ptr<BoundStage> { return std::make_unique<HalfBlackStage>(); };
    bound_half_black = this;
    Bundle bundle;
    add(bundle, "value", {side, side, channels}, dumped.data());
    parity::Dumped one{"value", bundle.arrays[0], Format::rgba32f, 15};
    one.unwritten = std::move(unwritten);
    return parity::judge(b, data, {one}, options);
}

}  // namespace

TEST_CASE("verdict: where all that is expected is 0 there is nothing to judge", "[verdict][absence]") {
    HalfBlack h;
    SECTION("one component") {}
    SECTION("three, and a w that is 1 everywhere") { h.channels = 4; }
    SECTION("three, and a w of 0") { h.channels = 4, h.w = 0; }
    std::vector<float> dumped = h.values();
    const parity::StageVerdict v = h.judge(dumped);
    CHECK_FALSE(v.decided);
    CHECK(v.passed);
    CHECK(v.pixels == side * side);
    CHECK(v.nonzero == 0);
    CHECK(v.reason.find("all that is expected is 0, at each of its 400 pixels: nothing to judge") == 0);
    // Another zero, legal as it is, decides no more; a value that is not legal does.
    dumped[0] = -0.0f;
    CHECK_FALSE(h.judge(dumped).decided);
    dumped[0] = 1;
    CHECK(h.judge(dumped).decided);
    CHECK_FALSE(h.judge(dumped).passed);
}

TEST_CASE("verdict: a w that is no flag is judged", "[verdict][absence]") {
    HalfBlack h;
    h.channels = 4, h.w = 0.5f;
    const parity::StageVerdict v = h.judge(h.values());
    CHECK(v.decided);
    CHECK(v.nonzero == side * side);
}

// 60 % of the pixels are black and equal; 2 of the 400 are ambiguous: 0.5 % of all, which passes, and 1.25 % of the 160
// that are not black.
TEST_CASE("verdict: black pixels do not make a share of ambiguous ones smaller", "[verdict][absence]") {
    HalfBlack h;
    h.black = 12;
    std::vector<float> dumped = h.values();
    for (int x : {12, 15}) dumped[std::size_t((side - 1) * side + x)] = 1.001f;
    const parity::StageVerdict v = h.judge(dumped);
    CHECK(v.nonzero == side * 8);
    CHECK(count(v, Verdict::ambiguous) == 2);
    CHECK(v.nonzero_count[int(Verdict::ambiguous)] == 2);
    CHECK(v.nonzero_count[int(Verdict::equal)] == side * 8 - 2);
    CHECK_FALSE(v.passed);
    CHECK(v.reason.find("1.25 % of the pixels that are not 0 are ambiguous, more than 0.5 %") == 0);
    parity::JudgeOptions more;
    more.max_ambiguous = 0.0125;
    CHECK(h.judge(dumped, more).passed);
    // Ambiguous where 0 is expected: of all pixels, and of none of the others.
    dumped = h.values();
    for (int x : {0, 1}) dumped[std::size_t((side - 1) * side + x)] = 0.001f;
    CHECK(h.judge(dumped).passed);
    CHECK(h.judge(dumped).nonzero_count[int(Verdict::ambiguous)] == 0);
}

TEST_CASE("verdict: what was never written is wrong, whatever stands there", "[verdict][absence]") {
    HalfBlack h;
    h.black = 0;
    const std::size_t first = 3 * side + 5, last = 4 * side + 1;
    std::vector<float> dumped = h.values();
    std::vector<std::uint8_t> marks(dumped.size(), 0);
    for (std::size_t i = first; i <= last; ++i) marks[i] = 1, dumped[i] = not_a_number;
    const parity::StageVerdict v = h.judge(dumped, {}, marks);
    CHECK(v.unwritten == std::int64_t(last - first + 1));
    CHECK(v.unwritten_rows == std::array<int, 2>{3, 4});
    CHECK(v.reason == "17 of 400 pixels were never written, in rows 3 to 4");
    CHECK_FALSE(v.passed);
    // A filling that happens to be the answer was written; behind the end of a file nothing was.
    dumped = h.values();
    CHECK(h.judge(dumped, {}, marks).passed);
    for (std::size_t i = first; i <= last; ++i) marks[i] = 2;
    CHECK(h.judge(dumped, {}, marks).unwritten == std::int64_t(last - first + 1));
    CHECK(h.judge(dumped, {}, std::vector<std::uint8_t>(dumped.size(), 2)).reason == "nothing was written");
    CHECK_THROWS_WITH(h.judge(dumped, {}, {1}), Catch::Contains("another size"));
}

TEST_CASE("verdict: a dump of one value is named", "[verdict][absence]") {
    HalfBlack h;
    h.black = 12;
    CHECK(h.judge(std::vector<float>(side * side, 0.0f)).reason == "160 of 400 pixels are wrong; all that was written is 0");
    CHECK(h.judge(std::vector<float>(side * side, not_a_number)).reason ==
          "400 of 400 pixels are wrong; all that was written is NaN");
    std::vector<float> dumped(side * side, 0.0f);
    dumped[399] = 1;
    CHECK(h.judge(dumped).reason == "159 of 400 pixels are wrong");
}

TEST_CASE("verdict: where nothing is seen pixels are left out, and no pass", "[verdict][absence]") {
    HalfBlack h;
    h.black = 0;
    std::vector<float> dumped = h.values();
    parity::JudgeOptions options;
    options.covered.assign(std::size_t(side * side), true);
    // What stands there is not looked at: not even NaN, or a filling.
    for (int x = 0; x < side; ++x) options.covered[std::size_t(x)] = false, dumped[std::size_t(x)] = not_a_number;
    std::vector<std::uint8_t> marks(dumped.size(), 0);
    marks[3] = 1;
    const parity::StageVerdict v = h.judge(dumped, options, marks);
    CHECK(v.passed);
    CHECK(v.decided);
    CHECK(v.left_out == side);
    CHECK(v.pixels == side * side - side);
    CHECK(v.unwritten == 0);
    CHECK(v.map(3, 0) == 255);
    // One beside is.
    dumped[std::size_t(side)] = 2;
    CHECK(count(h.judge(dumped, options), Verdict::wrong) == 1);
    options.covered.assign(std::size_t(side * side), false);
    const parity::StageVerdict none = h.judge(dumped, options);
    CHECK_FALSE(none.decided);
    CHECK(none.pixels == 0);
    CHECK(none.left_out == side * side);
    CHECK(none.reason.find("nothing is seen at any of its 400 pixels, and all are left out: nothing to judge") == 0);
    options.covered.resize(5);
    CHECK_THROWS_WITH(h.judge(dumped, options), "half black: where something is seen has another size");
}

TEST_CASE("verdict: what a stage makes of nothing is no evidence", "[verdict][absence]") {
    HalfBlack h;
    h.black = 0;
    h.reads = {{.name = "position"}};
    std::vector<float> texels(4 * std::size_t(side) * side, 0.0f);
    const auto judged = [&] {
        h.data.inputs = {};
        add(h.data.inputs, "position", {side, side, 4}, texels.data());
        return h.judge(h.values());
    };
    const parity::StageVerdict nothing = judged();
    CHECK_FALSE(nothing.decided);
    CHECK(nothing.passed);
    CHECK(nothing.nonzero == 0);
    CHECK(nothing.reason.find("all that is read is 0, at each of its 400 pixels: nothing to judge") == 0);
    // Of one component that is not 0, a NaN too, there is.
    texels[4 * 7 + 3] = -1;
    CHECK(judged().nonzero == 1);
    CHECK(judged().decided);
    texels[4 * 9] = not_a_number;
    CHECK(judged().nonzero == 2);
}

TEST_CASE("verdict: a first view that reads no image of views before does not read nothing", "[verdict][absence]") {
    // As screen.reflect: what it needs need not be as large as what it writes.
    HalfBlack h;
    h.black = 7;
    h.reads = {{.name = "before", .optional = true}, {.name = "position", .frame = false}};
    const std::vector<float> none(4 * std::size_t(side) * side, 0.0f), some(4 * std::size_t(side) * side, 1.0f);
    add(h.data.inputs, "before", {side, side, 4}, none.data());
    add(h.data.inputs, "position", {side, side, 4}, some.data());
    const parity::StageVerdict v = h.judge(h.values());
    CHECK(v.decided);
    CHECK(v.reason.empty());
    CHECK(v.nonzero == side * (side - 7));
}
