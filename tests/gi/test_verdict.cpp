// Verdicts without a device: a stage made for the test, whose legal outcomes are known, and the stages of a real frame,
// whose own results are judged as they are and with faults planted in them.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "core/outcomes.h"
#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "gi/frame/frame.h"
#include "gi/parity/stages.h"
#include "gi/parity/stored.h"
#include "gi/parity/verdict.h"
#include "raster/light_view.h"
#include "raster/rsm.h"
#include "tests/gi/verdict_scene.h"

using namespace plumb;
using parity::Verdict;

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr int side = 20;

// A stage that is judged alone: nothing of it is followed or explained.
struct JudgedStage : BoundStage {
    void follow(glm::ivec2, DecisionTape&, std::vector<Followed>&) const override { FAIL("nobody follows it"); }
    std::vector<TapValue> explain(glm::ivec2, const DeviceProfile&) const override { return {}; }
};

// Writes 1 everywhere, legally 1 +- 0.01; in column 1 also 2 +- 0.01, and in column 2 also 3 +- 0.01, which is
// ambiguous; in column 3 nothing is known; column 4 is not written; column 5 follows a choice.
class KnownStage final : public JudgedStage {
  public:
    void run(const RunOptions&, const DeviceProfile&, Bundle& outputs) const override {
        const std::vector<float> ones(side * side, 1.0f);
        add(outputs, "value", {side, side}, ones.data());
    }
    bool writes(glm::ivec2 pixel) const override { return pixel.x != 4; }
    void outcomes(glm::ivec2 pixel, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t> choices,
                  std::vector<Outcome>& out) const override {
        if (pixel.x == 5 && !choices.empty()) {
            if (choices[0] == 7) out.push_back({{{7, 0.01}}, false});
            return;
        }
        out.push_back({{{1, pixel.x == 3 ? HUGE_VAL : 0.01}}, false});
        if (pixel.x == 1) out.push_back({{{2, 0.01}}, false});
        if (pixel.x == 2) out.push_back({{{3, 0.01}}, true});
    }
};

StageBinding known_binding() {
    StageBinding b;
    b.info.name = "known";
    b.outputs = {{.name = "value", .kind = SlotKind::storage_image, .channels = 1}};
    b.bind = [](const StageData&) -> std::unique_ptr<BoundStage> { return std::make_unique<KnownStage>(); };
    return b;
}

struct KnownCase {
    StageBinding binding = known_binding();
    StageData data;
    std::vector<float> values = std::vector<float>(side * side, 1.0f);
    parity::JudgeOptions options;

    KnownCase() { data.stage = data.label = "known", data.size = {side, side}; }
    float& at(int x, int y) { return values[std::size_t(y * side + x)]; }
    parity::StageVerdict judge(Format stored = Format::r32f) const {
        Bundle bundle;
        add(bundle, "value", {side, side}, values.data());
        return parity::judge(binding, data, {{"value", bundle.arrays[0], stored, 1}}, options);
    }
};

std::int64_t count(const parity::StageVerdict& v, Verdict verdict) { return v.count[std::size_t(verdict)]; }

}  // namespace

TEST_CASE("verdict: equal bits everywhere, and pixels that are not written are not judged", "[verdict]") {
    KnownCase k;
    k.at(4, 3) = 99;
    const parity::StageVerdict v = k.judge();
    CHECK(v.passed);
    CHECK(v.verdict == Verdict::equal);
    CHECK(v.pixels == side * (side - 1));
    CHECK(count(v, Verdict::equal) == v.pixels);
    CHECK(v.map(4, 3) == 255);
    CHECK(v.worst.empty());
}

TEST_CASE("verdict: within the bound of our branch, of another, of an ambiguous one, of none", "[verdict]") {
    KnownCase k;
    k.at(0, 0) = 1.0099f;   // ours
    k.at(1, 0) = 2.0099f;   // another legal branch
    k.at(2, 0) = 2.9901f;   // legal, but nothing more can be decided
    k.at(3, 0) = 1e30f;     // no bound
    k.at(0, 1) = 1.0101f;   // beyond
    k.at(6, 1) = 2.0f;      // the other branch is legal in column 1 alone
    const parity::StageVerdict v = k.judge();
    CHECK(count(v, Verdict::within_bound) == 2);
    CHECK(count(v, Verdict::ambiguous) == 2);
    CHECK(count(v, Verdict::wrong) == 2);
    CHECK_FALSE(v.passed);
    CHECK(Verdict(v.map(1, 0)) == Verdict::within_bound);
    CHECK(Verdict(v.map(3, 0)) == Verdict::ambiguous);

    // The worst comes first: 2 is farther from 1 +- 0.01 than 1.0101.
    REQUIRE(v.worst.size() == 6);
    CHECK(v.worst[0].pixel == glm::ivec2(6, 1));
    CHECK(v.worst[0].expected == 1);
    CHECK(v.worst[0].got == 2);
    CHECK(v.worst[0].bound == Approx(0.01));
    CHECK(v.worst[1].pixel == glm::ivec2(0, 1));
    CHECK(v.worst[1].excess == Approx(1.01).epsilon(1e-3));
}

TEST_CASE("verdict: NaN and infinity are wrong, wherever they stand", "[verdict]") {
    for (const float planted : {not_a_number, -not_a_number, infinite, -infinite}) {
        KnownCase k;
        k.at(7, 9) = planted;
        const parity::StageVerdict v = k.judge();
        CHECK(count(v, Verdict::wrong) == 1);
        CHECK(v.worst.at(0).pixel == glm::ivec2(7, 9));
        CHECK_FALSE(v.passed);
    }
    // Not even where nothing bounds the value.
    KnownCase k;
    k.at(3, 0) = not_a_number;
    CHECK(count(k.judge(), Verdict::wrong) == 1);
}

TEST_CASE("verdict: a sign of zero is a differing bit within the bound", "[verdict]") {
    StageBinding b = known_binding();
    b.bind = [](const StageData&) -> std::unique_ptr<BoundStage> {
        struct Zero final : JudgedStage {
            void run(const RunOptions&, const DeviceProfile&, Bundle& outputs) const override {
                add(outputs, "value", DType::f32, {1, 1});
            }
            void outcomes(glm::ivec2, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t>,
                          std::vector<Outcome>& out) const override {
                out.push_back({{{0, 0}}, false});
            }
        };
        return std::make_unique<Zero>();
    };
    StageData data;
    data.size = {1, 1};
    const float minus = -0.0f;
    Bundle bundle;
    add(bundle, "value", {1, 1}, &minus);
    const parity::StageVerdict v = parity::judge(b, data, {{"value", bundle.arrays[0], Format::r32f, 1}}, {});
    CHECK(count(v, Verdict::within_bound) == 1);
}

TEST_CASE("verdict: what differs is named where no difference is allowed", "[verdict]") {
    StageBinding b = known_binding();
    b.bind = [](const StageData&) -> std::unique_ptr<BoundStage> {
        struct Exact final : JudgedStage {
            void run(const RunOptions&, const DeviceProfile&, Bundle& outputs) const override {
                const float one = 1;
                add(outputs, "value", {1, 1}, &one);
            }
            void outcomes(glm::ivec2, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t>,
                          std::vector<Outcome>& out) const override {
                out.push_back({{{1, 0}}, false});
            }
        };
        return std::make_unique<Exact>();
    };
    StageData data;
    data.size = {1, 1};
    const float two = 2;
    Bundle bundle;
    add(bundle, "value", {1, 1}, &two);
    const parity::StageVerdict v = parity::judge(b, data, {{"value", bundle.arrays[0], Format::r32f, 1}}, {});
    CHECK(count(v, Verdict::wrong) == 1);
    CHECK(v.worst.at(0).output == "value");
    CHECK(v.worst.at(0).expected == 1);
    CHECK(v.worst.at(0).got == 2);
}

TEST_CASE("verdict: too many ambiguous pixels decide nothing", "[verdict]") {
    KnownCase k;
    k.options.max_ambiguous = 0.005;
    k.at(2, 0) = 3;
    // One of 380 is 0.26 %, two are 0.53 %.
    CHECK(k.judge().passed);
    k.at(2, 1) = 3;
    const parity::StageVerdict v = k.judge();
    CHECK_FALSE(v.passed);
    CHECK(v.verdict == Verdict::ambiguous);
    CHECK(v.reason.find("ambiguous") != std::string::npos);
}

// A face of a point light may serve no point that is seen. `plumb validate` fails where no stage judged anything.
TEST_CASE("verdict: a dispatch that writes nothing is said to decide nothing", "[verdict]") {
    StageBinding b = known_binding();
    b.bind = [](const StageData&) -> std::unique_ptr<BoundStage> {
        struct Silent final : JudgedStage {
            void run(const RunOptions&, const DeviceProfile&, Bundle& outputs) const override {
                add(outputs, "value", DType::f32, {1, 1});
            }
            bool writes(glm::ivec2) const override { return false; }
            void outcomes(glm::ivec2, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t>,
                          std::vector<Outcome>&) const override {}
        };
        return std::make_unique<Silent>();
    };
    StageData data;
    data.size = {1, 1};
    Bundle bundle;
    add(bundle, "value", DType::f32, {1, 1});
    const parity::StageVerdict v = parity::judge(b, data, {{"value", bundle.arrays[0], Format::r32f, 1}}, {});
    CHECK(v.pixels == 0);
    CHECK(v.passed);
    CHECK(v.reason == "this dispatch writes no pixel: nothing to judge");
}

TEST_CASE("verdict: the device's own choice is followed where it is legal", "[verdict]") {
    KnownCase k;
    k.options.choices.assign(side * side, 0);
    k.options.choices_a_pixel = 1;
    k.at(5, 2) = 7, k.options.choices[2 * side + 5] = 7;  // legal
    k.at(5, 3) = 7, k.options.choices[3 * side + 5] = 8;  // not a choice that the bound allows
    const parity::StageVerdict v = k.judge();
    CHECK(Verdict(v.map(5, 2)) == Verdict::within_bound);
    CHECK(Verdict(v.map(5, 3)) == Verdict::wrong);
}

TEST_CASE("verdict: a store of 8 bits moves a value by at most one step", "[verdict][formats]") {
    // Ours, 1, is stored as 1; a device may have rounded 1 - 0.01 down: 252/255 = 0.98824, not 251/255.
    KnownCase k;
    k.at(0, 0) = 252 / 255.0f;
    k.at(0, 1) = 250 / 255.0f;
    const parity::StageVerdict v = k.judge(Format::rgba8);
    CHECK(Verdict(v.map(0, 0)) == Verdict::within_bound);
    CHECK(Verdict(v.map(0, 1)) == Verdict::wrong);
    CHECK(count(v, Verdict::equal) == v.pixels - 2);
}

namespace {

// Writes (0.3, 0.6, 0.1, 0.7) everywhere, legally +- 1e-6.
constexpr float written[4] = {0.3f, 0.6f, 0.1f, 0.7f};
struct ColourStage final : JudgedStage {
    void run(const RunOptions&, const DeviceProfile&, Bundle& outputs) const override {
        add(outputs, "colour", {1, 1, 4}, written);
    }
    void outcomes(glm::ivec2, const DeviceProfile&, std::span<const float>, std::span<const std::int32_t>,
                  std::vector<Outcome>& out) const override {
        Outcome o;
        for (const float x : written) o.values.push_back({x, 1e-6});
        out.push_back(o);
    }
};

Verdict judge_colour(const glm::vec4& got, Format stored, const DeviceProfile& profile = {}) {
    StageBinding b;
    b.outputs = {{.name = "colour", .kind = SlotKind::storage_image, .channels = 4}};
    b.bind = [](const StageData&) -> std::unique_ptr<BoundStage> { return std::make_unique<ColourStage>(); };
    StageData data;
    data.size = {1, 1};
    Bundle bundle;
    add(bundle, "colour", {1, 1, 4}, &got.x);
    parity::JudgeOptions options;
    options.profile = profile;
    return parity::judge(b, data, {{"colour", bundle.arrays[0], stored, 15}}, options).verdict;
}

}  // namespace

TEST_CASE("verdict: ours is rounded as the target rounds before it is compared", "[verdict][formats]") {
    for (const Format f : {Format::rgba8, Format::rgba16f, Format::r10g10b10a2}) {
        for (const char* profile : {"ideal", "lavapipe-22.3-fma"}) {
            INFO(info(f).name << " on " << profile);
            const DeviceProfile& device = find_profile(profile, "test");
            glm::vec4 texel(written[0], written[1], written[2], written[3]);
            quantise(f, texel, device.half_store);
            CHECK(judge_colour(texel, f, device) == Verdict::equal);
        }
    }
    // lavapipe cuts 0.1 to 0.09998 (0x2e66); 0.1001 (0x2e67) is as legal elsewhere and wrong there, or the reverse.
    glm::vec4 other(written[0], written[1], written[2], written[3]);
    quantise(Format::rgba16f, other, HalfStore::truncate);
    glm::vec4 nearest(written[0], written[1], written[2], written[3]);
    quantise(Format::rgba16f, nearest, HalfStore::nearest);
    REQUIRE(nearest != other);
    CHECK(judge_colour(other, Format::rgba16f) == Verdict::within_bound);
    CHECK(judge_colour(nearest, Format::rgba16f, find_profile("lavapipe-22.3-fma", "test")) == Verdict::wrong);
}

TEST_CASE("verdict: every component is judged", "[verdict]") {
    for (int c = 0; c < 4; ++c) {
        CAPTURE(c);
        glm::vec4 got(written[0], written[1], written[2], written[3]);
        got[c] = written[c] + 5e-7f;
        CHECK(judge_colour(got, Format::rgba32f) == Verdict::within_bound);
        got[c] = written[c] + 2e-6f;
        CHECK(judge_colour(got, Format::rgba32f) == Verdict::wrong);
    }
}

TEST_CASE("verdict: a dump that says how it was rounded is judged by that", "[verdict]") {
    // Ours is 1, legally 1 +- 0.01; the target held at most 0.95 and rounded by up to 0.02.
    KnownCase k;
    Bundle bundle;
    std::fill(k.values.begin(), k.values.end(), 0.96f);
    k.at(0, 1) = 0.98f;
    k.at(0, 2) = 0.92f;
    add(bundle, "value", {side, side}, k.values.data());
    const std::vector<float> rounding(side * side, 0.02f);
    add(bundle, "rounding", {side, side}, rounding.data());
    parity::Dumped dumped{"value", bundle.arrays[0], Format::rgba32f, 1, bundle.arrays[1], -1, 0.95};
    parity::StageVerdict v = parity::judge(k.binding, k.data, {dumped}, k.options);
    CHECK(count(v, Verdict::within_bound) == v.pixels - 2);
    CHECK(Verdict(v.map(0, 1)) == Verdict::wrong);
    CHECK(Verdict(v.map(0, 2)) == Verdict::wrong);

    // Not clamped: 0.96 is too far from 1 - 0.01, and 0.98 is not.
    dumped.highest = HUGE_VAL;
    v = parity::judge(k.binding, k.data, {dumped}, k.options);
    CHECK(Verdict(v.map(0, 1)) == Verdict::within_bound);
    CHECK(Verdict(v.map(0, 2)) == Verdict::wrong);
    CHECK(Verdict(v.map(0, 3)) == Verdict::wrong);
    dumped.rounding.shape = {side, side + 1};
    CHECK_THROWS_AS(parity::judge(k.binding, k.data, {dumped}, k.options), InputError);
}

TEST_CASE("verdict: dumps that do not fit are refused by one line", "[verdict]") {
    KnownCase k;
    auto message = [&](const std::string& name, const Shape& shape, DType dtype, unsigned channels) {
        Bundle bundle;
        add(bundle, "x", dtype, shape);
        std::vector<parity::Dumped> dumped;
        if (!name.empty()) dumped.push_back({name, bundle.arrays[0], Format::r32f, channels});
        try {
            parity::judge(k.binding, k.data, dumped, {});
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("accepted");
    };
    CHECK(message("", {1}, DType::f32, 1).find("no output was dumped") != std::string::npos);
    CHECK(message("valeu", {side, side}, DType::f32, 1).find("\"value\"") != std::string::npos);
    CHECK(message("value", {side, side + 1}, DType::f32, 1).find("20 x 20") != std::string::npos);
    CHECK(message("value", {side * side}, DType::f32, 1).find("20 x 20") != std::string::npos);
    CHECK(message("value", {side, side}, DType::u8, 1).find("u8") != std::string::npos);
    CHECK(message("value", {side, side}, DType::f32, 2).find("none of its components") != std::string::npos);
}

// Expected: what a target makes of any value of the interval lies in the range, whichever way it rounds.
TEST_CASE("stored_range: holds what every format makes of a value", "[verdict][formats]") {
    DeviceProfile profile, nearest, truncating;
    nearest.half_store_either = truncating.half_store_either = false;
    truncating.half_store = HalfStore::truncate;
    for (const FormatInfo& f : formats()) {
        int outside = 0, wide_ranges = 0, trials = 0;
        for (int i = 0; i < 40000; ++i) {
            const auto h = pixel_hash<std::int32_t>(i, int(f.format), 1, 5);
            auto uniform = [](std::int32_t bits) { return float(std::uint32_t(bits) >> 8) * 0x1p-24f; };
            glm::vec4 v(uniform(h.x), uniform(h.y), uniform(h.z), uniform(h.x ^ h.y));
            if (f.format == Format::d24s8) v.y *= 255;
            const bool direction = f.format == Format::octahedral16 || f.format == Format::octahedral8 ||
                                   f.format == Format::normal8;
            const bool wide = f.format == Format::r16f || f.format == Format::rgba16f ||
                              f.format == Format::r11g11b10f || f.format == Format::rgbe;
            if (direction) {
                const glm::vec3 d = glm::vec3(v) * 2.0f - 1.0f;
                const float length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
                if (length < 1e-3f) continue;
                v = glm::vec4(d / length, 0);
            } else if (wide) {
                v = glm::vec4(std::ldexp(v.x, int(h.y & 31) - 16), std::ldexp(v.y, int(h.z & 31) - 16),
                              std::ldexp(v.z, int(h.x & 31) - 16), v.w);
            }
            double largest = 0;
            for (int c = 0; c < 3; ++c) largest = std::max(largest, double(std::abs(v[c])));
            for (const HalfStore store : {HalfStore::nearest, HalfStore::truncate}) {
                glm::vec4 stored = v;
                quantise(f.format, stored, store);
                const DeviceProfile& known = store == HalfStore::nearest ? nearest : truncating;
                for (int c = 0; c < 4; ++c) {
                    if (f.format == Format::r32f && c > 0) continue;  // of one component
                    for (const DeviceProfile& device : {profile, known}) {
                        const parity::StoredRange r = parity::stored_range(f.format, c, v[c], v[c], largest, device);
                        outside += !(stored[c] >= r.low && stored[c] <= r.high);
                        ++trials;
                        // And is no wider than a few steps: halves and floats of 10 bits to 5, fixed point of 8 and
                        // more, an alpha of 2, a stencil.
                        const double step = f.format == Format::d24s8 && c == 1          ? 1
                                            : f.format == Format::r10g10b10a2 && c == 3 ? 0.334
                                                                                        : 0.15;
                        wide_ranges += !(r.high - r.low <= step * std::max(1.0, largest));
                    }
                }
            }
        }
        INFO(f.name << ": " << outside << " of " << trials);
        CHECK(trials > 10000);
        CHECK(outside == 0);
        CHECK(wide_ranges == 0);
    }
}

TEST_CASE("stored_range: what a format holds stays, and all else goes to one of two neighbours", "[verdict][formats]") {
    auto range = [](Format f, int c, double x, const char* profile = "ideal") {
        const parity::StoredRange r = parity::stored_range(f, c, x, x, x, find_profile(profile, "test"));
        return std::pair<double, double>(r.low, r.high);
    };
    using Ends = std::pair<double, double>;
    // A float of that format is a fixed point; its neighbours on either side hold what lies between.
    for (const Format f : {Format::r16f, Format::rgba16f, Format::r11g11b10f}) {
        for (int c = 0; c < std::min(info(f).channels, 4); ++c) {
            const int bits = f != Format::r11g11b10f ? 10 : c == 2 ? 5 : 6;
            const double unit = std::ldexp(1.0, -bits);
            INFO(info(f).name << " " << c);
            for (const double x : {0.0, 1.0, 1 + unit, 2 - unit, 0.5, 1024.0, unit * 0x1p-14, 0x1p-14})
                CHECK(range(f, c, x) == Ends(x, x));
            CHECK(range(f, c, 1 + 0.4 * unit) == Ends(1, 1 + unit));
            CHECK(range(f, c, 1 - 0.1 * unit) == Ends(1 - unit / 2, 1));
            CHECK(range(f, c, 0.3 * unit * 0x1p-14) == Ends(0, unit * 0x1p-14));
            const double largest = (2 - unit) * 0x1p15;
            CHECK(range(f, c, largest) == Ends(largest, largest));
            CHECK(range(f, c, largest + 1) == Ends(largest, HUGE_VAL));
            if (f == Format::r11g11b10f) CHECK(range(f, c, -1) == Ends(0, 0));
            if (f != Format::r11g11b10f) CHECK(range(f, c, -1 - 0.4 * unit) == Ends(-1 - unit, -1));
            if (f != Format::r11g11b10f) CHECK(range(f, c, -largest - 1) == Ends(-HUGE_VAL, -largest));
        }
    }
    // 1.0004 lies between 1 and 1.00098; lavapipe cuts it, and takes 65520 for 65504.
    CHECK(range(Format::rgba16f, 0, 1.0004, "lavapipe-22.3-fma") == Ends(1, 1));
    CHECK(range(Format::rgba16f, 3, -1.0009, "lavapipe-22.3-fma") == Ends(-1, -1));
    CHECK(range(Format::rgba16f, 3, 65520, "lavapipe-22.3-fma") == Ends(65504, 65504));
    const parity::StoredRange wide = parity::stored_range(Format::rgba16f, 0, 1.0004, 1.0015, 1.0015,
                                                          find_profile("lavapipe-22.3-fma", "test"));
    CHECK(Ends(wide.low, wide.high) == Ends(1, 1 + 0x1p-10));

    // Fixed point, in codes; what is not in [0, 1] is clamped.
    const struct {
        Format format;
        int c;
        double codes;
    } fixed[] = {{Format::rgba8, 0, 255}, {Format::rgba8, 3, 255}, {Format::r10g10b10a2, 1, 1023},
                 {Format::r10g10b10a2, 3, 3}};
    for (const auto& f : fixed) {
        INFO(info(f.format).name << " " << f.c);
        auto codes = [&](double x) {
            const Ends r = range(f.format, f.c, x);
            // A decoded code is a float: up to two roundings of its own.
            CHECK(std::abs(r.first * f.codes - std::rint(r.first * f.codes)) <= 0x1p-21 * r.first * f.codes);
            CHECK(std::abs(r.second * f.codes - std::rint(r.second * f.codes)) <= 0x1p-21 * r.second * f.codes);
            return Ends(std::rint(r.first * f.codes), std::rint(r.second * f.codes));
        };
        CHECK(codes(0) == Ends(0, 0));
        CHECK(codes(1) == Ends(f.codes, f.codes));
        CHECK(codes(-0.3) == Ends(0, 0));
        CHECK(codes(7) == Ends(f.codes, f.codes));
        CHECK(codes(1.5 / f.codes) == Ends(1, 2));
        CHECK(codes(0.01 / f.codes) == Ends(0, 1));
    }
    CHECK(range(Format::d24s8, 0, 0) == Ends(0, 0));
    CHECK(range(Format::d24s8, 0, 0.3).first == Approx(0.3).epsilon(2.5e-7));
    CHECK(range(Format::d24s8, 0, 0.3).second == Approx(0.3).epsilon(2.5e-7));
    CHECK(range(Format::d24s8, 1, 7) == Ends(7, 7));
    CHECK(range(Format::d24s8, 1, 7.5) == Ends(7, 8));
    CHECK(range(Format::d32f, 0, 0.3) == Ends(0.3, 0.3));
    CHECK(range(Format::d32f, 0, 1.3) == Ends(1, 1));
    // What is not stored reads as (0, 0, 0, 1), and as 0 after what a shader decodes.
    CHECK(range(Format::r11g11b10f, 3, 0.2) == Ends(1, 1));
    CHECK(range(Format::r16f, 1, 0.2) == Ends(0, 0));
    CHECK(range(Format::d32f, 3, 0.2) == Ends(1, 1));
    CHECK(range(Format::octahedral16, 3, 0.2) == Ends(0, 0));
}

namespace {

std::vector<StageData> small_frame(rsm::Gather gather) {
    const Scene scene = test::small_scene();
    frame::Settings settings;
    settings.rsm.gather = gather;
    settings.rsm.samples = 40;
    const frame::Plan plan = frame::plan(scene, settings);
    return parity::frame_data(scene, settings, plan, frame::execute(scene, settings, plan, {}));
}

parity::StageVerdict judge_outputs(const StageData& data, const Bundle& outputs) {
    std::vector<parity::Dumped> dumped;
    for (const Array& a : outputs.arrays) dumped.push_back({a.name, a, Format::rgba32f, 15});
    return parity::judge(parity::find_binding(data.stage, "test"), data, dumped, {});
}

}  // namespace

TEST_CASE("frame_data: every dispatch of a frame, six a point light, each with a name of its own", "[verdict][frame]") {
    std::vector<std::string> ids;
    for (const StageData& d : small_frame(rsm::Gather::disc)) ids.push_back(d.id);
    for (const char* id : {"gbuffer", "rsm.key_light", "rsm.bulb.px", "shadow.key_light", "shadow.bulb.nz", "direct",
                           "rsm.disc.key_light", "rsm.disc.bulb.ny", "compose", "tonemap"}) {
        INFO(id);
        CHECK(std::count(ids.begin(), ids.end(), id) == 1);
    }
    CHECK(std::count_if(ids.begin(), ids.end(), [](const std::string& s) { return s.starts_with("rsm.bulb."); }) <= 6);
}

// The frame ran the same kernels: what a dispatch makes of the frame's buffers is what the frame holds.
TEST_CASE("frame_data: a dispatch gives what the frame has", "[verdict][frame]") {
    const Scene scene = test::small_scene();
    frame::Settings settings;
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 40;
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame frame = frame::execute(scene, settings, plan, {});
    auto same = [](const Array& a, const void* b) { return std::memcmp(a.bytes.data(), b, a.bytes.size()) == 0; };
    int compared = 0;
    for (const StageData& d : parity::frame_data(scene, settings, plan, frame)) {
        Bundle out;
        parity::find_binding(d.stage, "test").bind(d)->run({}, DeviceProfile{}, out);
        INFO(d.id);
        if (d.id == "gbuffer") CHECK((same(at(out, "position"), frame.gbuffer.position.data()) && ++compared));
        if (d.id == "gbuffer") CHECK((same(at(out, "id"), frame.gbuffer.id.data()) && ++compared));
        if (d.id == "rsm.key_light") CHECK((same(at(out, "flux"), frame.rsms[0][0].flux.data()) && ++compared));
        if (d.id == "shadow.key_light") CHECK((same(at(out, "visibility"), frame.visibility.data()) && ++compared));
        if (d.id == "direct") CHECK((same(at(out, "irradiance"), frame.direct.data()) && ++compared));
        if (d.id == "compose") CHECK((same(at(out, "radiance"), frame.radiance.data()) && ++compared));
        if (d.id == "tonemap") CHECK((same(at(out, "display"), frame.display.data()) && ++compared));
    }
    CHECK(compared == 7);
}

// Expected: our own bits are equal; the exact value, rounded up everywhere or down everywhere, is within the bound; a
// thousandth more is beyond any rounding of these stages.
TEST_CASE("verdict: a frame's own results, rounded otherwise, and moved by a thousandth", "[verdict][frame]") {
    for (const rsm::Gather gather : {rsm::Gather::disc, rsm::Gather::all})
        for (const StageData& d : small_frame(gather)) {
            const StageBinding& binding = parity::find_binding(d.stage, "test");
            const std::unique_ptr<BoundStage> stage = binding.bind(d);
            Bundle own;
            stage->run({}, DeviceProfile{}, own);
            INFO(d.id);
            CHECK(judge_outputs(d, own).verdict == Verdict::equal);
            if (d.stage == "shadow" || binding.raster) continue;

            // Each pixel's value in double, rounded towards that side.
            auto rounded = [&](float towards) {
                Bundle b = own;
                float* p = reinterpret_cast<float*>(b.arrays[0].bytes.data());
                const int n = int(b.arrays[0].bytes.size() / 4) / (d.size.x * d.size.y);
                std::vector<Outcome> outcomes;
                const std::vector<float> got(std::size_t(n), not_a_number);
                for (int i = 0; i < d.size.x * d.size.y; ++i) {
                    stage->outcomes({i % d.size.x, i / d.size.x}, {}, got, {}, outcomes);
                    for (int c = 0; c < n; ++c) {
                        const double exact = outcomes.at(0).values.at(std::size_t(c)).shadow;
                        const float nearest = float(exact);
                        const bool beyond = towards > 0 ? nearest >= exact : nearest <= exact;
                        p[i * n + c] = beyond ? nearest : std::nextafter(nearest, towards);
                    }
                }
                return judge_outputs(d, b);
            };
            for (const float towards : {-infinite, infinite}) {
                const parity::StageVerdict near = rounded(towards);
                CHECK(count(near, Verdict::wrong) == 0);
                CHECK(count(near, Verdict::ambiguous) <= 0.02 * double(near.pixels));
            }

            Bundle far = own;
            float* p = reinterpret_cast<float*>(far.arrays[0].bytes.data());
            bool dark = true;
            for (std::size_t i = 0; i < far.arrays[0].bytes.size() / 4; ++i) {
                dark &= i % 4 == 3 || p[i] == 0;
                p[i] *= 1.001f;
            }
            CHECK((dark || count(judge_outputs(d, far), Verdict::wrong) > 0));
        }
}

TEST_CASE("verdict: a shadow is lit or not", "[verdict][frame]") {
    int judged = 0;
    for (const StageData& d : small_frame(rsm::Gather::disc)) {
        if (d.stage != "shadow") continue;
        Bundle own;
        parity::find_binding(d.stage, "test").bind(d)->run({}, DeviceProfile{}, own);
        float* p = reinterpret_cast<float*>(own.arrays[0].bytes.data());
        for (std::size_t i = 0; i < own.arrays[0].bytes.size() / 4; ++i) p[i] = 1 - p[i];
        const parity::StageVerdict v = judge_outputs(d, own);
        INFO(d.id << ": " << v.pixels);
        judged += v.pixels > 0;
        if (v.pixels > 0) CHECK(count(v, Verdict::wrong) >= 0.9 * double(v.pixels));
    }
    CHECK(judged >= 2);
}

// The texel of a projection is the first choice of these kernels: one that the bound does not allow leaves no outcome.
TEST_CASE("verdict: a stage's outcomes follow the choices that were dumped", "[verdict][frame]") {
    int followed = 0;
    for (const StageData& d : small_frame(rsm::Gather::disc)) {
        if (d.stage != "rsm.disc" && d.stage != "shadow") continue;
        const std::unique_ptr<BoundStage> stage = parity::find_binding(d.stage, "test").bind(d);
        const std::vector<float> got(4, not_a_number);
        const std::vector<std::int32_t> choices(4, -77777);
        std::vector<Outcome> free, bound;
        for (int x = 0; x < d.size.x; ++x) {
            const glm::ivec2 pixel(x, d.size.y / 2);
            if (!stage->writes(pixel)) continue;
            stage->outcomes(pixel, {}, got, {}, free);
            stage->outcomes(pixel, {}, got, choices, bound);
            CHECK_FALSE(free.empty());
            followed += bound.empty();
        }
    }
    CHECK(followed >= 40);
}

// x - eye is 1.05 or one unit less, as it is rounded, and z - eye is 1.05: the face is +x or +z.
TEST_CASE("verdict: a pixel whose face of a point light is undecided may be another face's", "[verdict][frame]") {
    Light bulb;
    bulb.name = "bulb", bulb.type = LightType::point, bulb.position = {0.15f, 0.2f, 0}, bulb.rsm_size = 8;
    const auto views = raster::light_views(bulb, {-2, -2, -2}, {2, 2, 2});
    std::vector<raster::Rsm> maps;
    for (const auto& view : views) maps.push_back(raster::unseen_rsm(bulb, view));
    Image4 position(2, 1), normal(2, 1);
    const float x = 1.2f;
    REQUIRE(double(x - 0.15f) > double(x) - 0.15f);  // rounded up; down, it is less than z - eye
    position.texels[0] = {x, 0.2f, x - 0.15f, 1};    // the float kernel has them equal, and takes +x
    position.texels[1] = {x, 0.2f, 0.5f, 1};
    normal.texels[0] = normal.texels[1] = {-1, 0, 0, 0};
    const StageData d = direct::data_of(direct::ShadowParams{.test = direct::ShadowTest::depth}, direct::ShadowInputs{&position, &normal, maps}, 0);
    Bundle own;
    const auto stage = parity::find_binding("shadow", "test").bind(d);
    REQUIRE(stage->writes({0, 0}));
    REQUIRE(stage->writes({1, 0}));
    stage->run({}, {}, own);
    float* visibility = reinterpret_cast<float*>(own.arrays[0].bytes.data());
    CHECK(judge_outputs(d, own).verdict == Verdict::equal);
    for (int i = 0; i < 2; ++i) visibility[i] = 1 - visibility[i];
    const parity::StageVerdict v = judge_outputs(d, own);
    CHECK(Verdict(v.map(0, 0)) == Verdict::ambiguous);
    CHECK(Verdict(v.map(1, 0)) == Verdict::wrong);
    visibility[0] = not_a_number;
    CHECK(Verdict(judge_outputs(d, own).map(0, 0)) == Verdict::wrong);
}

TEST_CASE("binding: data that does not fit is refused by one line", "[verdict][binding]") {
    auto refused = [](const StageData& good, auto spoil) {
        StageData d = good;
        spoil(d);
        try {
            parity::find_binding(d.stage, "test").bind(d);
        } catch (const InputError& e) {
            CHECK(std::string(e.what()).find('\n') == std::string::npos);
            return std::string(e.what());
        }
        return std::string("accepted");
    };
    for (const StageData& d : small_frame(rsm::Gather::disc)) {
        INFO(d.id);
        for (const Array& a : d.inputs.arrays) {
            if (a.name == "map_normal") continue;  // a shadow test by depths does not read it
            CHECK(refused(d, [&](StageData& s) {
                      std::erase_if(s.inputs.arrays, [&](const Array& b) { return b.name == a.name; });
                  }).find(a.name) != std::string::npos);
            CHECK(refused(d, [&](StageData& s) {
                      for (Array& b : s.inputs.arrays)
                          if (b.name == a.name) b.dtype = DType::f64;
                  }).find(a.name) != std::string::npos);
        }
        CHECK(refused(d, [](StageData& s) { s.uniforms.pop_back(); }).find("uniform block") != std::string::npos);
        CHECK(refused(d, [](StageData& s) { s.size = {0, 5}; }) != "accepted");
        CHECK(refused(d, [](StageData& s) { s.size = {40000, 5}; }) != "accepted");
        if (d.stage == "rsm.disc") {
            const StageBinding& b = parity::find_binding(d.stage, "test");
            auto with = [&](const char* member, double value) {
                return refused(d, [&](StageData& s) { set_uniform(b, s, member, std::array<double, 1>{value}, "test"); });
            };
            CHECK(with("map.size", 25).find("map.size") != std::string::npos);
            CHECK(with("samples", 41).find("offsets") != std::string::npos);
            CHECK(with("rotations", 3).find("power of two") != std::string::npos);
            CHECK(with("reach", -1).find("reach") != std::string::npos);
        }
    }
}

TEST_CASE("binding: uniforms by name", "[verdict][binding]") {
    StageData d = small_frame(rsm::Gather::disc).back();
    const StageBinding& b = parity::find_binding("tonemap", "test");
    REQUIRE(d.stage == "tonemap");
    set_uniform(b, d, "exposure", std::array<double, 1>{2.5}, "test");
    CHECK(uniform_value(b, d, "exposure") == std::vector<double>{2.5});
    CHECK_THROWS_WITH(set_uniform(b, d, "exposur", std::array<double, 1>{2.5}, "m.toml"),
                      Catch::Contains("m.toml") && Catch::Contains("\"exposure\""));
    CHECK_THROWS_AS(set_uniform(b, d, "op", std::array<double, 1>{0.5}, "m.toml"), InputError);
    CHECK_THROWS_AS(set_uniform(b, d, "op", std::array<double, 2>{1, 2}, "m.toml"), InputError);
    CHECK_THROWS_AS(set_uniform(b, d, "exposure", std::array<double, 1>{HUGE_VAL}, "m.toml"), InputError);
    CHECK_THROWS_WITH(parity::find_binding("tonemapp", "m.toml"), Catch::Contains("\"tonemap\""));
}
