// Frames of the method probes: closed forms through the whole chain, the latency of a pipeline, what runs again, and what is
// refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/error.h"
#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "gi/frame/rules.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;
using Catch::Matchers::Contains;

namespace {

// A room whose every surface emits `emission` W/m2 and reflects `rho`, seen from its middle.
Scene glowing_room(float emission, float rho) {
    Scene scene = empty_room();
    for (Material& m : scene.materials) m.emission = glm::vec3(emission), m.reflectance = glm::vec3(rho);
    return scene;
}

// The camera stands in the middle of what is drawn, the frame is small.
void look_inside(Scene& scene) {
    glm::vec3 low, high;
    bounds(flatten(scene), low, high);
    scene.camera.position = glm::dvec3(low + high) * 0.5;
    scene.camera.look_at = scene.camera.position + glm::dvec3(0.3, -0.1, -1);
    scene.camera.fov_y_deg = 80, scene.camera.near = 1e-3;
    scene.frame_size = {33, 27};
    scene.method = "probes";
}

Light lamp_in(const Scene& scene, float intensity) {
    Light light;
    light.name = "lamp", light.type = LightType::point, light.rsm_size = 32;
    light.position = glm::vec3(scene.camera.position) + glm::vec3(0.1f, 0.2f, 0.05f);
    light.intensity = glm::vec3(intensity);
    return light;
}

frame::Settings probe_settings(const Scene& scene) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5;
    return settings;
}

frame::Frame frame_of(const Scene& scene, frame::Settings settings, const RunOptions& options = {}) {
    frame::add_bake(scene, settings);
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}

// Least and most of a channel where the camera sees a surface.
std::pair<double, double> range_of(const frame::Frame& f) {
    double least = 1e300, most = -1e300;
    for (std::size_t i = 0; i < f.indirect.size(); ++i) {
        if (f.gbuffer.normal.texels[i].w == 0) continue;
        for (int c = 0; c < 3; ++c) {
            const double x = f.indirect.texels[i][c];
            least = std::min(least, std::isnan(x) ? -INFINITY : x), most = std::max(most, std::isnan(x) ? INFINITY : x);
        }
    }
    return {least, most};
}

RunOptions of_isa(Isa isa, int threads) {
    RunOptions options;
    options.isa = isa, options.threads = threads;
    return options;
}

std::vector<std::string> labels_that_ran(const frame::Frame& f) {
    std::vector<std::string> labels;
    for (const frame::StageRun& s : f.stages)
        if (s.needed && !s.kept) labels.push_back(s.label);
    return labels;
}
bool ran(const frame::Frame& f, const std::string& label) {
    const auto labels = labels_that_ran(f);
    return std::find(labels.begin(), labels.end(), label) != labels.end();
}

}  // namespace

TEST_CASE("probes: in a closed room that glows everywhere indirect irradiance is M / (1 - rho)", "[probes][frame][analytic][furnace]") {
    // E = B, and B = M + rho B. What rounding leaves is in test_probes_furnace.cpp: 1e-5 of a bounce, 1 / (1 - rho) bounces; clusters
    // lose their tails, 0.005 of the spectrum as the bake has it: at most 1 % here (measured 0.3 %).
    for (const double rho : {0.0, 0.5, 0.9}) {
        Scene scene = glowing_room(2, float(rho));
        look_inside(scene);
        frame::Settings settings = probe_settings(scene);
        settings.probe_run.tolerance = 1e-6f;
        settings.probes.threshold = 1e-6f, settings.probes.singular_values = 64;
        const frame::Frame f = frame_of(scene, settings);
        const auto [least, most] = range_of(f);
        const double expected = 2 / (1 - rho);
        CAPTURE(rho, least, most, expected, f.probes.converged.rounds, f.probes.converged.gain);
        CHECK(least > expected * (1 - 2e-3));
        CHECK(most < expected * (1 + 2e-3));
        // A round multiplies what is left by rho.
        if (rho > 0) CHECK(f.probes.converged.gain == Approx(rho).epsilon(0.01));
    }
}

TEST_CASE("probes: a window over the degrees leaves a furnace as it is, and a room with a lamp not", "[probes][frame][analytic][window]") {
    // sigma_0 is 1, and a constant radiance has no other degree. Less is asked than above: of what is cut off.
    for (const probes::Window window : {probes::Window::hann, probes::Window::lanczos}) {
        Scene scene = glowing_room(2, 0.5f);
        look_inside(scene);
        frame::Settings settings = probe_settings(scene);
        settings.probe_run.tolerance = 1e-6f, settings.probe_run.window = window;
        settings.probes.threshold = 1e-6f, settings.probes.singular_values = 64;
        const auto [least, most] = range_of(frame_of(scene, settings));
        CAPTURE(least, most);
        CHECK(least > 4 * (1 - 2e-3));
        CHECK(most < 4 * (1 + 2e-3));
    }
    Scene scene = glowing_room(0, 0.5f);
    look_inside(scene);
    Light lamp = lamp_in(scene, 10);
    lamp.type = LightType::spot, lamp.direction = glm::vec3(1, 0, 0);
    scene.lights = {lamp};
    frame::Settings settings = probe_settings(scene);
    frame::add_bake(scene, settings);
    frame::KeptStages kept;
    std::vector<Image4> lit;
    for (const probes::Window window : {probes::Window::none, probes::Window::hann, probes::Window::lanczos}) {
        settings.probe_run.window = window;
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        const probes::NegativeIrradiance& n = f.probes.converged.negative;
        CHECK(n.computed > 0);
        CHECK((n.negative > 0) == (n.least < 0));
        CHECK((n.negative > 0) == (text_of(f.probes.converged).find("below 0 at") != std::string::npos));
        for (const Image4& before : lit) CHECK(before.texels != f.indirect.texels);
        lit.push_back(f.indirect);
    }
}

TEST_CASE("probes: a scene without light has none", "[probes][frame]") {
    Scene scene = glowing_room(0, 0.5f);
    look_inside(scene);
    const frame::Frame f = frame_of(scene, probe_settings(scene));
    const auto [least, most] = range_of(f);
    CHECK(least == 0);
    CHECK(most == 0);
}

TEST_CASE("probes: published feedback grows from 1/pi on, and is refused with its gain", "[probes][frame][published]") {
    Scene scene = glowing_room(1, 0.5f);
    look_inside(scene);
    frame::Settings settings = probe_settings(scene);
    settings.probe_run.feedback = probes::Feedback::constant;
    settings.probe_run.reflection = 0.30f;  // gain pi c = 0.942
    CHECK(frame_of(scene, settings).probes.converged.gain == Approx(0.30 * host::pi).epsilon(0.01));
    settings.probe_run.reflection = 0.33f;  // 1.037
    REQUIRE_THROWS_AS(frame_of(scene, settings), InputError);
    // After the first round, and eight in a row that grow.
    CHECK_THROWS_WITH(frame_of(scene, settings), Contains("after 9 rounds light still grows, 1.03") && Contains("reflection = 0.33"));
    settings.probe_run.feedback = probes::Feedback::material;  // pi rho = 1.57
    CHECK_THROWS_WITH(frame_of(scene, settings), Contains("light still grows, 1.57") && Contains("feedback = material"));
}

TEST_CASE("probes: light whose first bounces grow is not refused where later ones do not", "[probes][frame][analytic]") {
    // A flat room, 4 x 0.8 x 4 m: two thirds of what the ceiling emits reach the floor, which sends back twice what it gets; the rest a 20th.
    // The second round has 4/3 of the first one's light, and every two rounds after it have a fraction.
    Mesh mesh;
    add_box(mesh, glm::vec3(-2, -0.4f, -2), glm::vec3(2, 0.4f, 2), 0, true);
    Scene scene = scene_of(mesh);
    scene.materials.resize(3);
    for (Material& m : scene.materials) m.reflectance = glm::vec3(0.05f);
    scene.materials[1].reflectance = glm::vec3(2), scene.materials[2].emission = glm::vec3(1);
    for (std::size_t t = 4; t < 6; ++t) scene.meshes[0].material[t] = 1, scene.meshes[0].material[t + 2] = 2;  // y low, y high
    look_inside(scene);
    frame::Settings settings = probe_settings(scene);
    frame::add_bake(scene, settings);
    std::vector<double> gains;
    for (int rounds = 2; rounds <= 5; ++rounds) {
        settings.probe_run.rounds = rounds;
        gains.push_back(frame::execute(scene, settings, frame::plan(scene, settings, frame::rules()), {}).probes.converged.gain);
    }
    CAPTURE(gains);
    CHECK(gains[0] > 1.1);
    CHECK(gains[1] < 0.9);
    settings.probe_run.rounds = 100;
    const probes::Convergence c = frame::execute(scene, settings, frame::plan(scene, settings, frame::rules()), {}).probes.converged;
    CHECK(c.rounds < 20);
    CHECK(c.left < 1e-2);
}

TEST_CASE("probes: a pipeline shows a change after exactly four frames", "[probes][frame][pipelined]") {
    // IPR figure 3.30. The lamp changes in frame 3; direct light shows it at once, indirect light in frame 7.
    Scene scene = glowing_room(0.1f, 0.5f);
    look_inside(scene);
    scene.lights = {lamp_in(scene, 1)};
    frame::Settings settings = probe_settings(scene);
    settings.probe_run.loop = probes::Loop::pipelined;
    frame::add_bake(scene, settings);
    frame::KeptStages kept;
    std::vector<Image4> indirect, direct;
    for (int n = 0; n < 10; ++n) {
        scene.lights[0].intensity = glm::vec3(n < 3 ? 1.0f : 4.0f);
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        indirect.push_back(f.indirect), direct.push_back(f.direct);
    }
    for (int n = 1; n < 3; ++n) CHECK(direct[std::size_t(n)].texels == direct[0].texels);
    CHECK(direct[3].texels != direct[2].texels);
    // Frame 0 has converged to the tolerance: further rounds add less than that.
    const auto mean = [](const Image4& image) {
        double sum = 0;
        for (const glm::vec4& t : image.texels) sum += double(t.x);
        return sum / double(image.size());
    };
    for (int n = 1; n < 7; ++n) CHECK(mean(indirect[std::size_t(n)]) == Approx(mean(indirect[0])).epsilon(2 * double(settings.probe_run.tolerance)));
    CHECK(mean(indirect[7]) > 1.5 * mean(indirect[0]));

    // From black: nothing in frames 0 to 3.
    settings.probe_run.start = probes::Start::black;
    frame::KeptStages anew;
    for (int n = 0; n < 6; ++n) {
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, anew);
        CAPTURE(n, mean(f.indirect));
        if (n == 0) CHECK(mean(f.indirect) == 0);
        if (n == 2) CHECK(mean(f.indirect) == 0);
        if (n == 4) CHECK(mean(f.indirect) > 0);
    }
}

TEST_CASE("probes: what is explained of a stage is what it wrote, in a pipeline, too", "[probes][frame][pipelined][tap]") {
    Scene scene = glowing_room(0.1f, 0.5f);
    look_inside(scene);
    scene.lights = {lamp_in(scene, 1)};
    for (const probes::Loop loop : {probes::Loop::converged, probes::Loop::pipelined}) {
        frame::Settings settings = probe_settings(scene);
        settings.probe_run.loop = loop;
        frame::add_bake(scene, settings);
        const frame::Plan plan = frame::plan(scene, settings);
        frame::KeptStages kept;
        for (int n = 0; n < 3; ++n) {
            scene.lights[0].intensity = glm::vec3(1 + float(n));
            const frame::Frame& f = frame::execute(scene, settings, plan, {}, kept);
            const auto last_of = [&](const char* stage, const char* tap, glm::ivec2 at) {
                glm::vec3 value(-1e30f);
                for (const frame::Explanation& e : frame::explain(scene, settings, plan, f, stage, -1, at))
                    for (const TapValue& v : e.values)
                        if (v.name == tap && v.value.size() >= 3) value = glm::vec3(v.value[0], v.value[1], v.value[2]);
                return value;
            };
            const frame::ProbeBuffers& p = f.probes;
            CAPTURE(int(loop), n);
            CHECK(last_of("probes.radiance", "f", {7, 2}) == glm::vec3(p.radiance(7, 2)));
            CHECK(last_of("probes.lambda", "lambda", {3, 1}) == glm::vec3(p.lambda(3, 1)));
            CHECK(last_of("probes.basis", "b", {2, 0}) == glm::vec3(p.basis(2, 0)));
            CHECK(last_of("probes.irradiance", "irradiance", {5, 0}) == glm::vec3(p.irradiance(5, 0)));
            CHECK(last_of("probes.lightmap", "lightmap", {9, 4}) == glm::vec3(p.lightmap(9, 4)));
            CHECK(last_of("probes.lookup", "irradiance", {12, 9}) == glm::vec3(f.indirect(12, 9)));
        }
    }
}

TEST_CASE("probes: only what changed runs again", "[probes][frame][keys]") {
    Scene scene = glowing_room(0.1f, 0.5f);
    look_inside(scene);
    scene.lights = {lamp_in(scene, 1)};
    frame::Settings settings = probe_settings(scene);
    frame::add_bake(scene, settings);
    frame::KeptStages kept;
    const auto next = [&]() -> const frame::Frame& { return frame::execute(scene, settings, frame::plan(scene, settings), {}, kept); };
    next();
    CHECK(labels_that_ran(next()) == std::vector<std::string>());
    scene.camera.position.x += 0.1;
    const frame::Frame* f = &next();
    CHECK(ran(*f, "gbuffer"));
    CHECK(ran(*f, "probes.lookup"));
    for (const char* still : {"probes.data", "probes.surfaces (probe rays)", "direct (probe rays)", "probes.rounds", "probes.radiance", "probes.lightmap"})
        CHECK_FALSE(ran(*f, still));
    scene.lights[0].intensity *= 2.0f;
    f = &next();
    for (const char* again : {"direct (probe rays)", "probes.rounds", "probes.radiance", "probes.lightmap", "probes.lookup"}) CHECK(ran(*f, again));
    for (const char* still : {"gbuffer", "probes.data", "probes.surfaces (probe rays)", "probes.lightmap_uv"}) CHECK_FALSE(ran(*f, still));
    // The emissivity of a material is a parameter of the run time.
    scene.materials[0].emission *= 3.0f;
    f = &next();
    for (const char* again : {"probes.surfaces (probe rays)", "probes.rounds", "probes.lightmap"}) CHECK(ran(*f, again));
    CHECK_FALSE(ran(*f, "probes.data"));
    // What is kept is what is made anew.
    CHECK(frame_of(scene, settings).radiance.texels == f->radiance.texels);
}

TEST_CASE("probes: a camera that moves changes levels of detail, and kept frames are what fresh ones are", "[probes][frame][keys][lod]") {
    Scene scene = furnished();
    for (Material& m : scene.materials) m.reflectance = glm::vec3(0.7f);
    look_inside(scene);
    scene.lights = {lamp_in(scene, 3)};
    frame::Settings settings = probe_settings(scene);
    settings.probes.cluster_receivers = 32;
    settings.lod.levels = 3, settings.lod.distance_1 = 0.8f, settings.lod.distance_2 = 1.6f;
    frame::add_bake(scene, settings);
    frame::KeptStages kept;
    std::set<std::vector<std::int32_t>> levels;
    for (int n = 0; n < 4; ++n) {
        scene.camera.position.x = -1.2 + 0.8 * n, scene.camera.look_at.x = scene.camera.position.x + 0.3;
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        levels.insert(f.probes.cluster_level);
        const bool same = frame_of(scene, settings).radiance.texels == f.radiance.texels;
        CHECK(same);
    }
    CHECK(levels.size() > 1);
}

TEST_CASE("probes: the bits do not depend on threads or instruction sets", "[probes][frame][bits]") {
    Scene scene = furnished();
    look_inside(scene);
    scene.lights = {lamp_in(scene, 3)};
    frame::Settings settings = probe_settings(scene);
    settings.lod.levels = 3, settings.lod.distance_1 = 0.5f, settings.lod.distance_2 = 1.5f;
    frame::add_bake(scene, settings);
    const frame::Frame whole = frame_of(scene, settings, of_isa(Isa::scalar, 1));
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3})
            CHECK(frame_of(scene, settings, of_isa(isa, threads)).radiance.texels == whole.radiance.texels);
}

TEST_CASE("probes: what is left out changes no bit, and in a pipeline nothing is", "[frame][probes][pruning]") {
    const auto fired = [](const frame::Frame& f, const std::string& rule) {
        return std::any_of(f.stages.begin(), f.stages.end(), [&](const frame::StageRun& s) { return s.rule == rule; });
    };
    for (const bool dark : {true, false})
        for (const bool blind : {true, false})
            for (const probes::Loop loop : {probes::Loop::converged, probes::Loop::pipelined}) {
                Scene scene = glowing_room(dark ? 0 : 1, 0.5f);
                look_inside(scene);
                if (blind) scene.camera.position.z -= 100, scene.camera.look_at.z -= 100;
                frame::Settings settings = probe_settings(scene);
                settings.probe_run.loop = loop;
                frame::add_bake(scene, settings);
                const frame::Frame pruned = frame_of(scene, settings);
                settings.pruning = false;
                const frame::Frame whole = frame_of(scene, settings);
                CAPTURE(dark, blind, int(loop));
                CHECK(pruned.radiance.texels == whole.radiance.texels);
                const bool may = loop == probes::Loop::converged;
                CHECK(fired(pruned, "no-radiance") == (may && dark && !blind));
                CHECK(ran(pruned, "probes.rounds") == !(may && (dark || blind)));
            }
    // The sky is light, too: a rule that forgets it would make this room dark.
    Scene open = glowing_room(0, 0.5f);
    look_inside(open);
    open.meshes[0].triangles.resize(open.meshes[0].triangles.size() - 2), open.meshes[0].material.pop_back(), open.meshes[0].material.pop_back();
    open.environment.radiance = glm::vec3(1);
    CHECK(range_of(frame_of(open, probe_settings(open))).second > 0.1);
}

TEST_CASE("probes: what a frame cannot be made of is refused", "[probes][frame][refused]") {
    Scene scene = glowing_room(1, 0.5f);
    look_inside(scene);
    frame::Settings settings = probe_settings(scene);
    CHECK_THROWS_WITH(frame::execute(scene, settings, frame::plan(scene, settings), {}), Contains("bake"));
    frame::add_bake(scene, settings);
    scene.meshes.push_back(scene.meshes[0]);
    CHECK_THROWS_WITH(frame::execute(scene, settings, frame::plan(scene, settings), {}), Contains("the bake is of another scene"));
}
