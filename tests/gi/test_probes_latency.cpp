// When a pipeline shows what changes, of static surfaces and of what moves (IPR figure 3.30), and what a run says of itself.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;
using Catch::Matchers::Contains;

namespace {

// A room, a lamp, and a camera that looks at what moves in its middle.
Scene room_with_box(float emission) {
    Scene scene = empty_room();
    scene.materials[0].reflectance = glm::vec3(0.5f), scene.materials[0].emission = glm::vec3(emission);
    scene.materials[1].reflectance = glm::vec3(0.5f);
    Mesh box;
    add_box(box, glm::vec3(-0.2f), glm::vec3(0.2f), 1);
    box.name = "box", box.dynamic = true, box.material.assign(box.triangles.size(), 1);
    scene.meshes.push_back(std::move(box));
    Light lamp;
    lamp.name = "lamp", lamp.type = LightType::point, lamp.rsm_size = 32;
    lamp.position = {0.3f, 1.5f, 0.2f}, lamp.intensity = glm::vec3(1);
    scene.lights = {lamp};
    scene.camera.position = {0.2, 0.3, 1.6}, scene.camera.look_at = {0, 0, 0};
    scene.camera.fov_y_deg = 60, scene.camera.near = 1e-2;
    scene.frame_size = {24, 24}, scene.method = "probes";
    return scene;
}

frame::Settings settings_for(const Scene& scene, probes::Loop loop, probes::Start start = probes::Start::converged) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5, settings.probes.spatial_receivers = 27;
    settings.probe_run.loop = loop, settings.probe_run.start = start;
    frame::add_bake(scene, settings);
    return settings;
}

// Mean indirect irradiance of the pixels of an object, -1 where it has none.
double mean_of(const frame::Frame& f, int object) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < f.indirect.size(); ++i)
        if (f.gbuffer.id.texels[i].x == object) sum += double(f.indirect.texels[i].x), ++count;
    return count > 0 ? sum / count : -1;
}

// The first frame in which an object's indirect light differs from that of the frame where `change` was made, which is frame 3.
struct Shown {
    int room = -1, box = -1;
};
template <class Change>
Shown first_shown(Scene scene, const frame::Settings& settings, Change change) {
    frame::KeptStages kept;
    Shown shown;
    double room = 0, box = 0;
    for (int n = 0; n < 10; ++n) {
        if (n == 3) change(scene);
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        const double r = mean_of(f, 0), b = mean_of(f, 1);
        REQUIRE(r >= 0);
        REQUIRE(b >= 0);
        if (n <= 3) room = r, box = b;
        // Frame 0 has converged to the tolerance: further rounds add less than that.
        const double off = 4 * double(settings.probe_run.tolerance);
        if (n > 3 && shown.room < 0 && std::fabs(r - room) > off * room) shown.room = n;
        if (n > 3 && shown.box < 0 && std::fabs(b - box) > off * box) shown.box = n;
    }
    return shown;
}

}  // namespace

TEST_CASE("probes: in a pipeline what moves is lit four frames after a lamp changes, as all else", "[probes][frame][pipelined][dynamic][IPR figure 3.30]") {
    const Scene scene = room_with_box(0.1f);
    const Shown shown = first_shown(scene, settings_for(scene, probes::Loop::pipelined), [](Scene& s) { s.lights[0].intensity *= 8.0f; });
    CHECK(shown.room == 7);
    CHECK(shown.box == 7);
}

TEST_CASE("probes: in a pipeline what begins to glow is seen a frame earlier than a lamp: probes need no shadow map", "[probes][frame][pipelined][dynamic][IPR figure 3.30]") {
    const Scene scene = room_with_box(0.1f);
    const Shown shown = first_shown(scene, settings_for(scene, probes::Loop::pipelined), [](Scene& s) { s.materials[0].emission *= 8.0f; });
    CHECK(shown.room == 6);
    CHECK(shown.box == 6);
}

TEST_CASE("probes: a pipeline that begins in black is black until frame 4", "[probes][frame][pipelined][dynamic]") {
    const Scene scene = room_with_box(0);
    const frame::Settings settings = settings_for(scene, probes::Loop::pipelined, probes::Start::black);
    frame::KeptStages kept;
    for (int n = 0; n < 6; ++n) {
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        CAPTURE(n);
        for (const int object : {0, 1}) CHECK((mean_of(f, object) > 0) == (n >= 4));
    }
}

TEST_CASE("probes: one round says nothing of what further ones add", "[probes][frame]") {
    // Of a room that reflects half as much again comes with every round: after k of them 0.5^k of all is missing.
    Scene scene = room_with_box(1);
    scene.meshes.pop_back(), scene.lights.clear();
    frame::Settings settings = settings_for(scene, probes::Loop::converged);
    const auto after = [&](int rounds) {
        settings.probe_run.rounds = rounds;
        return frame::execute(scene, settings, frame::plan(scene, settings), {}).probes.converged;
    };
    CHECK(after(1).rounds == 1);
    CHECK(after(1).left > 0.5);
    // Of what there is: 0.5^k / (1 - 0.5^k).
    CHECK(after(2).left == Approx(1.0 / 3).epsilon(0.05));
    CHECK(after(4).left == Approx(1.0 / 15).epsilon(0.05));
}

TEST_CASE("probes: levels that mix charts, and what moves without spatial receivers, are told", "[probes][frame][lod][dynamic]") {
    const Scene scene = room_with_box(1);
    const auto reason = [&](frame::Settings settings) {
        for (const frame::StageRun& s : frame::execute(scene, settings, frame::plan(scene, settings), {}).stages)
            if (s.label == "probes.data") return s.reason;
        return std::string();
    };
    frame::Settings settings = settings_for(scene, probes::Loop::converged);
    CHECK_THAT(reason(settings), Contains("receivers") && !Contains("mixes") && !Contains("no spatial receivers"));
    settings.lod.levels = 3, settings.lod.degree_1 = 7;
    CHECK_THAT(reason(settings), Contains("level 2 mixes charts that lie less than 12 texels apart") && Contains("degree_1 = 7"));
    // A file that was baked without any: `plumb bake` has them where `spatial_receivers` asks for them.
    frame::Settings without = settings_for(scene, probes::Loop::converged);
    auto bake = std::make_shared<probes::Bake>(*without.bake);
    bake->spatial = {};
    without.bake = bake;
    CHECK_THAT(reason(without), Contains("no spatial receivers: what moves gets no indirect light"));
}
