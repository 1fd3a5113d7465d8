// Leaving out changes no bit: over many scenes, and for every rule on its own.
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <optional>
#include <set>

#include "core/error.h"
#include "gi/frame/frame.h"
#include "tests/gi/random_scene.h"

using namespace plumb;

namespace {

// Watched by sanitizers, a scene takes ten times as long: they look at few (tests/gi/tests.cmake), too few to say how often
// a rule fires or whether its breaking shows.
#ifdef PLUMB_FEW_SCENES
constexpr std::uint32_t scenes = 60;
#else
constexpr std::uint32_t scenes = 500;
#endif
constexpr bool all_scenes = scenes == 500;

struct Case {
    Scene scene;
    frame::Settings settings;
};
Case case_of(std::uint32_t seed) { return {test::random_scene(seed), test::random_settings(seed)}; }

frame::Frame run(const Case& c, const frame::Plan& plan) {
    RunOptions options;
    options.threads = 1;
    return frame::execute(c.scene, c.settings, plan, options);
}

frame::Plan whole_plan(Case c) {
    c.settings.pruning = false;
    return frame::plan(c.scene, c.settings);
}
frame::Frame run_whole(Case c) {
    c.settings.pruning = false;
    return run(c, frame::plan(c.scene, c.settings));
}
// The frame of a scene with nothing left out: drawn once for all tests.
const frame::Frame& whole_frame(std::uint32_t seed) {
    static std::vector<std::optional<frame::Frame>> frames(scenes);
    if (!frames[seed]) frames[seed] = run_whole(case_of(seed));
    return *frames[seed];
}

template <class T>
bool same(const Image<T>& a, const Image<T>& b) {
    return a.width == b.width && a.height == b.height &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
// Of what only one of them has there is nothing to compare.
template <class T>
bool same_if_both(const Image<T>& a, const Image<T>& b) {
    return a.empty() || b.empty() || same(a, b);
}

bool ran(const frame::Frame& f, const std::string& label) {
    for (const frame::StageRun& s : f.stages)
        if (s.label == label) return s.needed;
    return false;
}

// The first layer that differs of those that both have; empty where they are the same, bit for bit.
std::string difference(const Scene& scene, const frame::Frame& a, const frame::Frame& b) {
    const raster::GBuffer &g = a.gbuffer, &h = b.gbuffer;
    if (!same(a.radiance, b.radiance)) return "color";
    if (!same(a.display, b.display)) return "display";
    if (!same(g.position, h.position)) return "position";
    if (!same(g.normal, h.normal)) return "normal";
    if (!same(g.albedo, h.albedo)) return "albedo";
    if (!same(g.emission, h.emission)) return "emission";
    if (!same(g.depth, h.depth)) return "depth";
    if (!same(g.id, h.id)) return "id";
    if (!frame::find_traced(a, "color")) {
        if (!same(a.direct, b.direct)) return "direct";
        // Of method isr it holds what the picture may not show: k_isr of nothing, accessibility that nobody asks.
        if (a.isr.surface.empty() && b.isr.surface.empty() && !same(a.indirect, b.indirect)) return "indirect";
        if (!same_if_both(a.indirect_error, b.indirect_error)) return "indirect.error";
    }
    if (!same(a.truth_display, b.truth_display)) return "truth_display";
    if (!same(a.ao.open, b.ao.open)) return "ao";
    if (!same(a.reflect.reflection, b.reflect.reflection)) return "reflection";
    if (!same(a.ao.lit, b.ao.lit) && a.isr.surface.empty() && b.isr.surface.empty()) return "ao.lit";
    if (a.traced.size() != b.traced.size()) return "traced";
    for (std::size_t i = 0; i < a.traced.size(); ++i)
        if (!same(a.traced[i].estimate.mean, b.traced[i].estimate.mean) ||
            !same(a.traced[i].estimate.error, b.traced[i].estimate.error))
            return a.traced[i].layer;
    const std::size_t pixels = a.radiance.size();
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const std::string label = "shadow (" + scene.lights[l].name + ")";
        if (ran(a, label) && ran(b, label) &&
            std::memcmp(&a.visibility[l * pixels], &b.visibility[l * pixels], pixels * sizeof(float)) != 0)
            return label;
        for (std::size_t m = 0; m < a.rsms[l].size(); ++m) {
            const raster::Rsm &r = a.rsms[l][m], &s = b.rsms[l][m];
            if (!same_if_both(r.position, s.position) || !same_if_both(r.normal, s.normal) ||
                !same_if_both(r.flux, s.flux))
                return "rsm of " + scene.lights[l].name;
        }
    }
    return "";
}

// Whether it speaks of nothing but the method probes, whose frames read a bake, and of radiosity, of which few random scenes are
// dark: test_probes_frame.cpp, test_probes_relief_frame.cpp, test_probes_shade_frame.cpp, test_radiosity_frame.cpp.
bool of_a_bake(const frame::Rule& rule) {
    return std::all_of(rule.stages.begin(), rule.stages.end(),
                       [](const std::string& s) { return s == "probes" || s == "relief" || s == "probes shadow" || s == "radiosity"; });
}

// The rules that left anything out of a frame.
std::set<std::string> fired(const frame::Frame& f) {
    std::set<std::string> names;
    for (const frame::StageRun& s : f.stages) {
        if (!s.rule.empty()) names.insert(s.rule);
        for (const frame::LeftOut& part : s.parts) names.insert(part.rule);
    }
    return names;
}

// rules() but for one, whose condition always holds.
[[maybe_unused]] std::vector<frame::Rule> broken(const std::string& name) {
    std::vector<frame::Rule> all = frame::rules();
    for (frame::Rule& rule : all) {
        if (rule.name != name) continue;
        if (rule.holds) rule.holds = [](const frame::PlanFacts&, const frame::Work&) { return true; };
        if (rule.seen) rule.seen = [](const frame::RunFacts&, const frame::Work&) { return true; };
    }
    return all;
}

}  // namespace

TEST_CASE("pruning: 500 scenes are the same bit for bit with and without, and every rule fires in ten",
          "[frame][pruning][property]") {
    std::map<std::string, int> count;
    int differing = 0, left_out_of = 0;
    for (std::uint32_t seed = 0; seed < scenes; ++seed) {
        CAPTURE(seed);
        const Case c = case_of(seed);
        const frame::Plan pruned_plan = frame::plan(c.scene, c.settings), whole = whole_plan(c);
        const frame::Frame pruned = run(c, pruned_plan);
        const frame::Frame& all = whole_frame(seed);
        const std::string layer = difference(c.scene, pruned, all);
        CHECK(layer == "");
        differing += !layer.empty();
        const std::set<std::string> names = fired(pruned);
        for (const std::string& name : names) ++count[name];
        left_out_of += !names.empty();
        CHECK(fired(all).empty());

        // Pruning never adds work, and what is expected and what is saved make up the whole.
        REQUIRE(pruned.stages.size() == all.stages.size());
        for (std::size_t i = 0; i < all.stages.size(); ++i) {
            const frame::PlannedStage &p = pruned_plan.stages[i], &w = whole.stages[i];
            CHECK(all.stages[i].needed);
            CHECK((p.needed || !pruned.stages[i].needed));
            CHECK(p.expected_ms <= w.expected_ms);
            CHECK(p.expected_ms + p.saved_ms == Approx(w.expected_ms).epsilon(1e-12));
            CHECK(pruned.stages[i].saved_ms <= w.expected_ms * (1 + 1e-12));
            CHECK((pruned.stages[i].needed || !pruned.stages[i].rule.empty()));
        }
    }
    CHECK(differing == 0);
    if (!all_scenes) return;
    CHECK(left_out_of >= 300);
    for (const frame::Rule& rule : frame::rules()) {
        CAPTURE(rule.name);
        if (of_a_bake(rule)) continue;
        CHECK(count[rule.name] >= 10);
    }
}

#ifndef PLUMB_FEW_SCENES
TEST_CASE("pruning: whatever rule is broken, some picture changes", "[frame][pruning][property]") {
    for (const frame::Rule& rule : frame::rules()) {
        CAPTURE(rule.name);
        if (of_a_bake(rule)) continue;
        const std::vector<frame::Rule> wrong = broken(rule.name);
        bool noticed = false;
        for (std::uint32_t seed = 0; seed < scenes && !noticed; ++seed) {
            const Case c = case_of(seed);
            const frame::Frame& whole = whole_frame(seed);
            try {
                noticed = !difference(c.scene, run(c, frame::plan(c.scene, c.settings, wrong)), whole).empty();
            } catch (const InputError&) {
                noticed = true;  // a stage refuses to read what was left out
            }
        }
        CHECK(noticed);
    }
}
#endif

TEST_CASE("pruning: a rule's name is its own, and it speaks of stages that a frame has", "[frame][pruning]") {
    std::set<std::string> names;
    for (const frame::Rule& rule : frame::rules()) {
        CAPTURE(rule.name);
        CHECK(names.insert(rule.name).second);
        CHECK_FALSE(rule.reason.empty());
        CHECK_FALSE(rule.stages.empty());
        CHECK((rule.holds == nullptr) != (rule.seen == nullptr));
    }
}

// A point within the cone is a light's; what keeps clear of it by more than a kernel's rounding is not. f is the distance
// from the cone where it is above 0 (and a lower bound of it behind the tip), so that it changes by no more than x moves.
TEST_CASE("pruning: a spot's cone meets a box where it does, and not where it is clear of it", "[frame][pruning]") {
    int met = 0, missed = 0;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        CAPTURE(seed);
        test::Dice dice(seed);
        Light light;
        light.position = dice.in_box(glm::vec3(-3), glm::vec3(3));
        light.direction = dice.direction();
        light.cone_outer_deg = dice.between(1, 85);
        light.rsm_size = 512;
        const glm::vec3 low = dice.in_box(glm::vec3(-3), glm::vec3(2)), size = dice.in_box(glm::vec3(0), glm::vec3(2));
        const frame::Box box{glm::dvec3(low), glm::dvec3(low + size)};
        const double angle = light.cone_outer_deg * (host::pi / 180), cosine = host::cos(angle), sine = host::sin(angle);
        constexpr int n = 24;
        double least = 1e30;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j)
                for (int k = 0; k <= n; ++k) {
                    const glm::dvec3 x = box.low + (box.high - box.low) * (glm::dvec3(i, j, k) / double(n));
                    const glm::dvec3 v = x - glm::dvec3(light.position), a(light.direction);
                    const double along = v.x * a.x + v.y * a.y + v.z * a.z;
                    const glm::dvec3 p = v - a * along;
                    least = std::min(least, std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z) * cosine - along * sine);
                }
        const glm::dvec3 e = box.high - box.low;
        const double step = std::sqrt(e.x * e.x + e.y * e.y + e.z * e.z) / (2 * n);
        const bool may = frame::may_light(light, box);
        if (least <= 0) CHECK(may);
        if (least > step + 0.01) CHECK_FALSE(may);
        met += least <= 0, missed += least > step + 0.01;
    }
    CHECK(met > 50);
    CHECK(missed > 50);
}

TEST_CASE("pruning: a map that is drawn for its depth alone has the depth of the whole map, in every layout",
          "[frame][pruning]") {
    int compared = 0;
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        Case c = case_of(seed);
        c.settings.method = frame::Method::direct;
        c.settings.layout = raster::layouts()[seed % raster::layouts().size()];
        const frame::Frame depth = run(c, frame::plan(c.scene, c.settings)), whole = run_whole(c);
        for (std::size_t l = 0; l < depth.rsms.size(); ++l)
            for (std::size_t m = 0; m < depth.rsms[l].size(); ++m) {
                if (depth.rsms[l][m].size == 0) continue;
                CAPTURE(seed, l, m);
                CHECK(same(depth.rsms[l][m].position, whole.rsms[l][m].position));
                CHECK(depth.rsms[l][m].flux.empty());
                CHECK(depth.rsms[l][m].records.empty());
                CHECK_FALSE(whole.rsms[l][m].flux.empty());
                ++compared;
            }
    }
    CHECK(compared >= 20);
}
