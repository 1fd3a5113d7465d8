// What evaluate() says of formulas whose condition and error are known, and of the stages that there are.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "gi/frame/frame.h"
#include "gi/parity/stages.h"
#include "gi/stability/cases_parts.h"
#include "gi/stability/moved_inputs.h"
#include "gi/stability/stability.h"
#include "tests/gi/formulas.h"
#include "tests/parity/twin_data.h"

using namespace plumb;
using namespace plumb::test;
using stability::Cell;

namespace {

template <class Formula>
Cell cell_of(const StageData& data, stability::Effort effort = {}) {
    return stability::evaluate(formula_binding<Formula>(), data, effort);
}

// n numbers about `middle`, half a unit to either side.
std::vector<float> noise_about(float middle, int n) {
    std::vector<float> v;
    for (int i = 0; i < n; ++i) v.push_back(middle + noise(i, 0, 0, 3) - 0.5f);
    return v;
}

const std::vector<float> one{1.0f};

}  // namespace

TEST_CASE("stability: condition numbers that are known", "[stability]") {
    // An ULP above 1 is eps: moves are relative moves by eps.
    const float near = 1 + 0x1p-12f;
    CHECK(cell_of<Difference>(formula_data({near}, one)).condition ==
          Approx((near + 1) / (near - 1)).epsilon(1e-3));                                      // (|x| + |y|)/|x - y|
    CHECK(cell_of<EighthPower>(formula_data(one, one)).condition == Approx(8).epsilon(1e-5));  // k of x^k
    CHECK(cell_of<NaiveSum>(formula_data(std::vector<float>(64, 1), one)).condition == Approx(1));  // positive terms
    CHECK(cell_of<Uniform>(formula_data(one, one, 1)).condition == Approx(2).epsilon(1e-5));        // c and a, one each

    // 33 ones and 31 of the other sign, all moved up: towards 0 an ULP of 1 is half as large.
    std::vector<float> mixed(64, 1);
    for (std::size_t i = 0; i < 31; ++i) mixed[i] = -1;
    CHECK(cell_of<NaiveSum>(formula_data(mixed, one)).condition == Approx((33 + 31 / 2.0) / 2).epsilon(1e-5));
}

TEST_CASE("stability: what an exact formula uses of its budget is nothing, of one rounding half a unit",
          "[stability]") {
    const Cell exact = cell_of<Difference>(formula_data({1 + 0x1p-12f}, one));
    CHECK(exact.used == 0);
    CHECK(exact.rel_error == 0);
    CHECK(exact.digits_lost == 0);
    CHECK(exact.most_lost.empty());
    CHECK(exact.pixels == 1);
    CHECK(exact.ok);
    const Cell rounded = cell_of<Quotient>(formula_data(one, {3}));
    CHECK(rounded.rel_error == Approx(std::abs(double(1 / 3.0f) * 3 - 1)));
    CHECK(rounded.digits_lost == 0);  // the nearest float
    CHECK(rounded.used > 0);
    CHECK(rounded.used <= 0.5);
    CHECK(rounded.ok);
}

TEST_CASE("stability: bad formulas are found, and the good ones for the same pass", "[stability]") {
    const StageData angle = formula_data({1.1e-3f}, one);
    const Cell cancels = cell_of<OneMinusCos>(angle);
    CHECK_FALSE(cancels.ok);
    CHECK(cancels.used > 1000);
    CHECK(cancels.digits_lost > 4);
    CHECK_THAT(cancels.most_lost, Catch::Matchers::Contains("at condition"));
    CHECK(cancels.nonfinite == 0);
    CHECK(cell_of<TwoSinSquared>(angle).ok);
    // x f'/f = 2, and an ULP of x = 1.1264 2^-10 is eps / 1.1264 of it.
    CHECK(cell_of<TwoSinSquared>(angle).condition == Approx(2 / 1.1264).epsilon(1e-3));

    const StageData far = formula_data(noise_about(1000, 64), one);
    CHECK_FALSE(cell_of<NaiveVariance>(far).ok);
    CHECK(cell_of<TwoPassVariance>(far).ok);

    // A tenth, a million times: every addition errs to the same side.
    const StageData tenths = formula_data(std::vector<float>(1000000, 0.1f), one);
    CHECK_FALSE(cell_of<NaiveSum>(tenths).ok);
    CHECK(cell_of<NaiveSum>(tenths).rel_error > 5e-3);
    CHECK(cell_of<CompensatedSum>(tenths).ok);
    CHECK(cell_of<CompensatedSum>(tenths).pixels == 1);
}

TEST_CASE("stability: what is not finite is never within a budget", "[stability]") {
    const StageData large = formula_data({3e25f}, {4e25f});
    const Cell overflows = cell_of<NaiveHypot>(large);
    CHECK_FALSE(overflows.ok);
    CHECK(overflows.nonfinite == 1);
    CHECK(cell_of<ScaledHypot>(large).ok);
    CHECK(cell_of<ScaledHypot>(large).nonfinite == 0);

    for (const StageData& data : {formula_data({0}, {0}), formula_data(one, {0}), formula_data({NAN}, one)}) {
        const Cell cell = cell_of<Quotient>(data);  // NaN and infinity in double, too
        CHECK(cell.nonfinite == 1);
        CHECK_FALSE(cell.ok);
    }
    // A finite double beyond the largest float.
    CHECK_FALSE(cell_of<Product>(formula_data({1e30f}, {1e30f}, 1)).ok);

    Cell cell = cell_of<Difference>(formula_data({3}, one));
    REQUIRE(cell.ok);
    Cell broken = cell;
    broken.used = NAN;
    stability::merge(cell, broken);
    CHECK_FALSE(cell.ok);
    CHECK(std::isnan(cell.used));
}

TEST_CASE("stability: a result may be off by what a device flushes to 0, and no more", "[stability]") {
    const Cell denormal = cell_of<Product>(formula_data({1.3e-20f}, {1.7e-20f}, 1));  // 2.2e-40
    CHECK(denormal.ok);
    CHECK(denormal.used < 1e-5);  // half of 2^-149 of the 2^-126 that stand for all of C
    CHECK(denormal.rel_error > 0);
    // The product vanishes, and is brought back to just below 2^-126, or to half as much again.
    const float back = float(0x1p-126 / (double(1e-25f) * double(1e-25f)));
    const Cell below = cell_of<Product>(formula_data({1e-25f}, {1e-25f}, 0.9f * back));
    CHECK(below.used == Approx(0.9 * 16).epsilon(1e-5));
    CHECK(below.ok);
    const Cell above = cell_of<Product>(formula_data({1e-25f}, {1e-25f}, 1.5f * back));
    CHECK(above.used == Approx(1.5 * 16).epsilon(1e-5));
    CHECK_FALSE(above.ok);
    // The product vanishes in float, and 1e30 brings it back in double.
    const Cell vanished = cell_of<Product>(formula_data({1e-25f}, {1e-25f}, 1e30f));
    CHECK(vanished.nonfinite == 0);
    CHECK(vanished.used > 16);
    CHECK_FALSE(vanished.ok);
    // 0 in double has to be 0 in float.
    CHECK(cell_of<Product>(formula_data({0}, one, 1)).used == 0);
}

TEST_CASE("stability: decisions that double would take otherwise are counted and not held against a stage",
          "[stability]") {
    const Cell flips = cell_of<Grows>(formula_data(one, {1e-9f}));
    CHECK(flips.flips == 1);
    CHECK(flips.used == 0);
    CHECK(flips.ok);
    CHECK(cell_of<Grows>(formula_data(one, {1e-3f})).flips == 0);
}

TEST_CASE("stability: what cannot be bound is refused, and where nothing was looked at nothing is said",
          "[stability]") {
    StageData data = formula_data(one, one);
    data.uniforms.pop_back();
    const Cell refused = cell_of<Difference>(data);
    CHECK(refused.refused);
    CHECK(refused.ok);
    CHECK(refused.pixels == 0);
    CHECK(refused.reason.find("formula: ") == 0);

    stability::Effort nothing;
    nothing.pixels = 0;
    const Cell unseen = cell_of<Difference>(formula_data({3}, one), nothing);
    CHECK(unseen.pixels == 0);
    CHECK_FALSE(unseen.refused);
    CHECK_FALSE(unseen.ok);
    Cell cell = unseen;
    stability::merge(cell, unseen);
    CHECK_FALSE(cell.ok);

    // Pixels that the stage does not write are no pixels: of 2 x 2 the column x = 1 is left alone.
    StageData wide = formula_data({3}, one);
    wide.size = {2, 2};
    CHECK(cell_of<Difference>(wide).pixels == 2);
}

TEST_CASE("stability: of cells that are merged the worst counts", "[stability]") {
    Cell cell;
    const Cell good = cell_of<Quotient>(formula_data(one, {3}));
    const Cell bad = cell_of<OneMinusCos>(formula_data({1.1e-3f}, one));
    const Cell flips = cell_of<Grows>(formula_data(one, {1e-9f}));
    for (const Cell& other : {flips, bad, good}) stability::merge(cell, other);
    CHECK(cell.stage == "formula");
    CHECK(cell.used == bad.used);
    CHECK(cell.condition == bad.condition);
    CHECK(cell.rel_error == bad.rel_error);
    CHECK(cell.digits_lost == bad.digits_lost);
    CHECK(cell.reason == bad.reason);
    CHECK(cell.most_lost == bad.most_lost);
    CHECK(cell.flips == 1);
    CHECK(cell.pixels == 3);
    CHECK_FALSE(cell.ok);

    // What is not finite stays counted, whichever comes first.
    Cell infinite = good;
    infinite.nonfinite = 2, infinite.reason = "infinite";
    for (Cell first : {good, infinite}) {
        stability::merge(first, first.nonfinite > 0 ? good : infinite);
        CHECK(first.nonfinite == 2);
        CHECK(first.reason == "infinite");
        CHECK_FALSE(first.ok);
    }

    // A refusal excuses nothing that was computed.
    StageData data = formula_data(one, one);
    data.uniforms.pop_back();
    stability::merge(cell, cell_of<Difference>(data));
    CHECK(cell.refused);
    CHECK_FALSE(cell.ok);
}

TEST_CASE("stability: moves are one ULP, of everything that a rounding may have made", "[stability]") {
    const float least = std::numeric_limits<float>::denorm_min(), most = std::numeric_limits<float>::max();
    CHECK(stability::moved(1, true) == 1 + 0x1p-23f);
    CHECK(stability::moved(1, false) == 1 - 0x1p-24f);
    CHECK(stability::moved(-1, true) == -1 + 0x1p-24f);
    CHECK(stability::moved(least, true) == 2 * least);
    CHECK(stability::moved(most, true) == std::nextafter(most, 0.0f));
    CHECK(stability::moved(-most, false) == std::nextafter(-most, 0.0f));
    CHECK(number<float>::bits(stability::moved(-0.0f, true)) == number<float>::bits(-0.0f));
    CHECK(stability::moved(INFINITY, false) == INFINITY);

    // Flags, counts and integers stay.
    for (StageData& d : compute_cases({12, 10})) {
        const StageBinding& binding = parity::find_binding(d.stage, "test");
        std::vector<std::string> names;
        for (const stability::Input& input : stability::inputs_of(binding, d)) {
            names.push_back(input.name);
            const Bundle inputs = d.inputs;
            const std::vector<unsigned char> uniforms = d.uniforms;
            std::vector<float> before;
            for (int way = 0; way < stability::ways_to_move(input, 4); ++way) {
                stability::move(input, way, before);
                stability::put_back(input, before);
            }
            CHECK(d.uniforms == uniforms);
            CHECK(content_hash(d.inputs) == content_hash(inputs));
        }
        auto has = [&](const char* name) { return std::count(names.begin(), names.end(), name) > 0; };
        const bool reads_normal = std::any_of(binding.inputs.begin(), binding.inputs.end(),
                                              [](const Slot& s) { return s.name == "normal"; });
        CHECK(has("normal.0") == reads_normal);
        if (d.stage == "compose") CHECK_FALSE(has("normal.3"));
        if (d.stage == "shadow") {
            CHECK(has("bias.0"));
            CHECK_FALSE(has("perspective.0"));
            CHECK_FALSE(has("samples.0"));
        }
        CHECK_FALSE(has("offsets.0"));
        CHECK_FALSE(has("width.0"));
    }
}

TEST_CASE("stability: every compute stage keeps its budget on a hand-made room", "[stability][stages]") {
    stability::Effort effort;
    effort.pixels = 24;
    for (const StageData& d : compute_cases({24, 12})) {
        CAPTURE(d.label);
        const Cell cell = stability::evaluate(parity::find_binding(d.stage, "test"), d, effort);
        CAPTURE(cell.reason, cell.used);
        CHECK(cell.pixels == std::min(24, d.size.x * d.size.y));
        // That data of compose holds infinities and NaN.
        CHECK((cell.nonfinite > 0) == (d.stage == "compose"));
        CHECK(cell.used <= cell.budget);
    }
}

TEST_CASE("stability: every stage of a frame, followed: the float is what was drawn, the double takes part",
          "[stability][stages]") {
    // Textures with levels of detail, a normal map, something that emits; a spot, a point light and a sun.
    const Scene scene = stability::room();
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.gather = rsm::Gather::disc;
    settings.shadow.mode = direct::ShadowMode::hard;  // a count
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame frame = frame::execute(scene, settings, plan, {});
    stability::Effort effort;
    effort.pixels = 12;
    std::map<std::string, int> inexact;
    for (const StageData& d : parity::frame_data(scene, settings, plan, frame)) {
        CAPTURE(d.label);
        const StageBinding& binding = parity::find_binding(d.stage, "test");
        const auto stage = binding.bind(d);
        Bundle outputs;
        stage->run({}, {}, outputs);
        int wrong = 0;
        std::vector<Followed> out;
        for (int i = 0; i < d.size.x * d.size.y; ++i) {
            const glm::ivec2 pixel(i % d.size.x, i / d.size.x);
            if (!stage->writes(pixel)) continue;
            DecisionTape tape;
            stage->follow(pixel, tape, out);
            std::size_t c = 0;
            for (const Slot& slot : binding.outputs) {
                if (slot.dtype != DType::f32 || slot.kind == SlotKind::depth) continue;
                const auto* drawn = reinterpret_cast<const float*>(at(outputs, slot.name).bytes.data());
                for (int k = 0; k < slot.channels; ++k, ++c) {
                    wrong += number<float>::bits(out.at(c).value) != number<float>::bits(drawn[i * slot.channels + k]);
                    inexact[d.stage] += out[c].exact != double(out[c].value);
                }
            }
            wrong += c != out.size();
        }
        CHECK(wrong == 0);
        if (!binding.raster) continue;
        const Cell cell = stability::evaluate(binding, d, effort);
        CAPTURE(cell.reason);
        CHECK(cell.pixels == 12);
        CHECK(cell.ok);
    }
    // A hard shadow is a count: exact, once it is decided.
    for (const char* stage : {"gbuffer", "rsm", "rsm.disc", "direct", "compose", "tonemap"}) {
        CAPTURE(stage);
        CHECK(inexact[stage] > 0);
    }
    CHECK(inexact["shadow"] == 0);
}

TEST_CASE("stability: what is said does not depend on threads or instructions", "[stability][bits]") {
    const StageData d = gather_case({16, 8}, rsm::Gather::disc, LightType::spot, 0, "disc");
    stability::Effort effort;
    effort.pixels = 12;
    auto text = [&](int threads, Isa isa) {
        effort.run.threads = threads, effort.run.isa = isa;
        const Cell c = stability::evaluate(parity::find_binding(d.stage, "test"), d, effort);
        char line[200];
        std::snprintf(line, sizeof line, "%a %a %a %a %d ", c.rel_error, c.condition, c.digits_lost, c.used,
                      int(c.flips));
        return line + c.reason;
    };
    const std::string expected = text(1, Isa::scalar);
    CHECK(text(3, Isa::scalar) == expected);
    CHECK(text(2, best_isa()) == expected);
}

TEST_CASE("stability: the double that follows is the double kernel where no decision flips", "[stability][rsm]") {
    const Light light = make_light(LightType::spot, 64);
    const raster::Rsm map = make_map(light, 0, 3);
    rsm::GatherParams params;
    params.gather = rsm::Gather::disc;
    params.samples = 60;
    const rsm::Pattern pattern = rsm::disc_pattern(params, map.size, 7);
    const test::Points p = room({16, 8}, 5);
    const rsm::GatherInputs in{&p.position, &p.normal, &map, &pattern, 7};
    Image<glm::dvec4> expected;
    const StageData d = rsm::data_of(params, in);
    run_double(rsm::stage_of(params), d, {}, expected);

    // As a device is bound to it: without the records that the frame lends.
    const StageData of_images = owned(rsm::stage_of(params), d);
    const auto stage = rsm::stage_of(params).bind(of_images);
    int same = 0;
    std::vector<Followed> out;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) {
            DecisionTape tape;
            stage->follow({x, y}, tape, out);
            if (tape.flips() > 0) continue;
            REQUIRE(out.size() == 4);
            for (int c = 0; c < 3; ++c) CHECK(out[std::size_t(c)].exact == expected(x, y)[c]);
            ++same;
        }
    CHECK(same > 100);
}
