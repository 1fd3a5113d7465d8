// The layers that are path traced beside a method's: what they leave out, what is planned, and errors that add up.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/content_hash.h"
#include "gi/compose/compose.h"
#include "gi/frame/frame.h"
#include "io/scene_file.h"

using namespace plumb;

namespace {

Scene tiny_cornell() {
    Scene scene = io::load_scene(std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/cornell.toml",
                                 frame::method_tables());
    scene.frame_size = {24, 18};
    scene.lights.at(0).rsm_size = 32;
    return scene;
}

frame::Settings traced_settings(const Scene& scene) {
    frame::Settings settings = frame::settings_of(scene);
    settings.truth = true;
    settings.reference.rays = Rays::exact;
    settings.reference.samples = 8;
    settings.reference.rounds = 2;
    return settings;
}

frame::Frame render(const Scene& scene, const frame::Settings& settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), RunOptions{});
}

const frame::PlannedStage& planned(const frame::Plan& plan, const std::string& layer) {
    for (const frame::PlannedStage& s : plan.stages)
        if (s.layer == layer) return s;
    throw std::runtime_error("no stage for " + layer);
}

}  // namespace

TEST_CASE("traced layers: the lamps' light does not know what else is in the scene", "[tools]") {
    Scene plain = tiny_cornell();
    for (Material& m : plain.materials) m.emission = glm::vec3(0);
    const frame::Frame expected = render(plain, traced_settings(plain));
    const struct {
        const char* name;
        void (*change)(Scene&);
    } changes[] = {
        {"emission", [](Scene& s) { s.materials[1].emission = {3, 2, 1}; }},
        {"specular", [](Scene& s) { s.materials[1].specular = {0.1f, 0.1f, 0.1f}; }},
        {"mirror", [](Scene& s) { s.materials[1].mirror = {0.1f, 0.1f, 0.1f}; }},
        {"microfacets", [](Scene& s) { s.materials[1].microfacet = true; }},
        {"environment", [](Scene& s) { s.environment.radiance = {1, 2, 3}; }},
    };
    for (const auto& [name, change] : changes) {
        CAPTURE(name);
        Scene scene = plain;
        change(scene);
        const frame::Frame f = render(scene, traced_settings(scene));
        for (const char* layer : {"truth.direct", "truth.indirect"}) {
            const frame::Traced &got = *frame::find_traced(f, layer), &without = *frame::find_traced(expected, layer);
            CHECK(got.without == std::vector<std::string>{name});
            CHECK(content_hash(got.estimate.mean) == content_hash(without.estimate.mean));
            CHECK(content_hash(got.estimate.error) == content_hash(without.estimate.error));
        }
        // All light is another picture.
        CHECK(content_hash(frame::find_traced(f, "truth")->estimate.mean) !=
              content_hash(frame::find_traced(expected, "truth")->estimate.mean));
    }
}

TEST_CASE("traced layers: the truth's picture is the truth under the picture's tone curve", "[tools]") {
    const Scene scene = tiny_cornell();
    const frame::Settings settings = traced_settings(scene);
    const frame::Frame f = render(scene, settings);
    Image4 display;
    compose::run(settings.tonemap, compose::TonemapInputs{&frame::find_traced(f, "truth")->estimate.mean}, RunOptions{}, display);
    CHECK(content_hash(f.truth_display) == content_hash(display));
    CHECK(content_hash(f.truth_display) != content_hash(f.display));
}

TEST_CASE("traced layers: a plan says until which error", "[tools]") {
    const Scene scene = tiny_cornell();
    frame::Settings settings = traced_settings(scene);
    CHECK(planned(frame::plan(scene, settings), "truth").reason == "the truth of color");
    CHECK(planned(frame::plan(scene, settings), "truth").samples == 8);
    settings.reference.until_error = 0.25f;
    settings.reference.max_samples = 4096;
    for (const char* layer : {"truth", "truth.direct", "truth.indirect"}) {
        const frame::PlannedStage s = planned(frame::plan(scene, settings), layer);
        CHECK(s.reason.find("; until its error is 0.25 of its mean, at most 4096 samples") != std::string::npos);
        CHECK(s.samples == 0);
    }
}

TEST_CASE("traced layers: without a lamp nothing is traced of its light", "[tools]") {
    const struct {
        const char *name, *direct, *indirect;
        void (*change)(Scene&);
    } cases[] = {
        {"no light", "no light shines on the scene", "no light shines on the scene",
         [](Scene& s) { s.lights.clear(); }},
        {"off", "no light shines on the scene", "no light shines on the scene",
         [](Scene& s) { s.lights[0].on = false; }},
        {"nothing reflects", "", "nothing reflects",
         [](Scene& s) { for (Material& m : s.materials) m.reflectance = glm::vec3(0); }},
    };
    for (const auto& c : cases) {
        CAPTURE(c.name);
        Scene scene = tiny_cornell();
        scene.materials[1].emission = {3, 2, 1};
        c.change(scene);
        frame::Settings settings = traced_settings(scene);
        const frame::Plan plan = frame::plan(scene, settings);
        CHECK(planned(plan, "truth").needed);
        CHECK(planned(plan, "truth.direct").needed == std::string(c.direct).empty());
        if (*c.direct) CHECK(planned(plan, "truth.direct").reason == c.direct);
        CHECK_FALSE(planned(plan, "truth.indirect").needed);
        CHECK(planned(plan, "truth.indirect").reason == c.indirect);

        // Leaving it out changes no bit.
        const frame::Frame pruned = render(scene, settings);
        settings.pruning = false;
        const frame::Frame whole = render(scene, settings);
        CHECK(frame::find_traced(pruned, "truth.indirect")->estimate.samples == 0);
        CHECK(frame::find_traced(whole, "truth.indirect")->estimate.samples == 8);
        for (const char* layer : {"truth", "truth.direct", "truth.indirect"}) {
            CAPTURE(layer);
            const reference::Estimate &a = frame::find_traced(pruned, layer)->estimate,
                                      &b = frame::find_traced(whole, layer)->estimate;
            CHECK(content_hash(a.mean) == content_hash(b.mean));
            CHECK(content_hash(a.error) == content_hash(b.error));
        }
    }
}

// Two lights that chose the same texels would err alike: twice the error of one, and sqrt(2) times that which is stated.
TEST_CASE("traced layers: the errors of two equal lights are independent", "[tools]") {
    Scene scene = tiny_cornell();
    scene.lights.push_back(scene.lights[0]);
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.gather = rsm::Gather::all_rays;
    settings.rsm.max_rays = 1;  // the least subset
    constexpr int runs = 48;
    const std::size_t pixels = std::size_t(scene.frame_size.x) * scene.frame_size.y;
    std::vector<double> sum(3 * pixels), squares(3 * pixels);
    double stated = 0, spread = 0;
    for (int run = 0; run < runs; ++run) {
        settings.seed = std::uint32_t(100 + run);
        const frame::Frame f = render(scene, settings);
        REQUIRE_FALSE(f.indirect_error.empty());
        for (std::size_t i = 0; i < pixels; ++i)
            for (int c = 0; c < 3; ++c) {
                const double v = f.indirect.texels[i][c], e = f.indirect_error.texels[i][c];
                sum[3 * i + c] += v;
                squares[3 * i + c] += v * v;
                stated += e * e / runs;
            }
    }
    for (std::size_t i = 0; i < sum.size(); ++i) spread += (squares[i] - sum[i] * sum[i] / runs) / (runs - 1);
    REQUIRE(stated > 0);
    // 48 runs of 432 pixels: the ratio of the two is known to a few percent.
    CHECK(std::sqrt(spread / stated) == Approx(1).margin(0.1));
}
