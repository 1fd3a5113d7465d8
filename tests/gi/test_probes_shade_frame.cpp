// Indirect shadows of dynamic meshes in frames of the method probes: closed forms through the whole chain, what runs again, what is left out.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

// A closed room, +-2 m, that glows: everywhere E = M / (1 - rho) = 2 of M = 1, rho = 0.5. A small box may move in it.
Scene glowing_room(bool moves) {
    Scene scene = empty_room();
    for (Material& m : scene.materials) m.emission = glm::vec3(1), m.reflectance = glm::vec3(0.5f);
    if (moves) {
        Mesh box;
        box.name = "box", box.dynamic = true;
        add_box(box, glm::vec3(-0.2f), glm::vec3(0.2f), 0);
        scene.materials.push_back({});
        scene.materials.back().reflectance = glm::vec3(0);
        box.material.assign(box.triangles.size(), std::int32_t(scene.materials.size()) - 1);
        box.transform[3] = {0, -1.5, 0, 1};
        scene.meshes.push_back(box);
    }
    scene.camera.position = {0, 0.6, 1.8}, scene.camera.look_at = {0, -1.6, 0}, scene.camera.fov_y_deg = 80, scene.camera.near = 1e-3;
    scene.frame_size = {40, 32}, scene.method = "probes";
    return scene;
}
frame::Settings settings_with(const Scene& scene, probes::IndirectShadow shadow) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5, settings.probes.spatial_receivers = 27;
    settings.probes.threshold = 1e-6f, settings.probes.singular_values = 64;
    settings.probe_run.indirect_shadow = shadow;
    return settings;
}
frame::Frame frame_of(const Scene& scene, frame::Settings settings, const RunOptions& options = {}) {
    frame::add_bake(scene, settings);
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}
bool ran(const frame::Frame& f, const std::string& label) {
    return std::any_of(f.stages.begin(), f.stages.end(), [&](const frame::StageRun& s) { return s.label == label && s.needed && !s.kept; });
}
const frame::StageRun& row(const frame::Frame& f, const std::string& label) {
    for (const frame::StageRun& s : f.stages)
        if (s.label == label) return s;
    FAIL("no stage " << label);
    throw;
}

}  // namespace

TEST_CASE("probes: a black box in a room that glows everywhere hides what spheres in its place hide", "[probes][shade][frame][analytic]") {
    const Scene scene = glowing_room(true);
    const frame::Frame off = frame_of(scene, settings_with(scene, probes::IndirectShadow::off));
    for (const auto shadow : {probes::IndirectShadow::uniform, probes::IndirectShadow::spheres, probes::IndirectShadow::reflecting,
                              probes::IndirectShadow::rays}) {
        frame::Settings settings = settings_with(scene, shadow);
        settings.probe_run.shadow_spheres = 1, settings.probe_run.shadow_rays = 256;
        const frame::Frame f = frame_of(scene, settings);
        CAPTURE(int(shadow));
        double most = 0;
        int shaded = 0;
        for (std::size_t i = 0; i < f.indirect.size(); ++i) {
            const glm::vec4 n = f.gbuffer.normal.texels[i];
            if (n.w == 0 || f.gbuffer.id.texels[i].x == 1) continue;
            const double left = double(f.indirect.texels[i].x) / double(off.indirect.texels[i].x);
            const glm::vec3 to = glm::vec3(0, -1.5f, 0) - glm::vec3(f.gbuffer.position.texels[i]);
            const double d2 = double(glm::dot(to, to)), cosine = double(glm::dot(glm::vec3(n), to)) / std::sqrt(d2);
            // Cauchy: the box' mean area is 6 x 0.16 / 4; the fit has it to 2 %. Spheres: (r/d)^2 cos, where the horizon does not cut.
            const double r2 = 0.24 / host::pi;
            if (r2 / d2 < cosine * cosine && cosine > 0) {
                const double expected = 1 - r2 / d2 * cosine;
                CHECK(left == Approx(expected).margin(shadow == probes::IndirectShadow::rays ? 0.25 * (1 - expected) + 0.01 : 0.02 * (1 - expected) + 0.004));
                most = std::max(most, 1 - left), ++shaded;
            }
            CHECK(left > -1e-6);
            CHECK(left < 1.004);
        }
        CHECK(shaded > 100);
        CHECK(most > 0.2);
    }
}

TEST_CASE("probes: where nothing moves shadows are left out, and change no bit", "[probes][shade][frame][pruning]") {
    const Scene scene = glowing_room(false);
    const frame::Frame off = frame_of(scene, settings_with(scene, probes::IndirectShadow::off));
    for (const auto shadow : {probes::IndirectShadow::uniform, probes::IndirectShadow::spheres, probes::IndirectShadow::rays}) {
        frame::Settings settings = settings_with(scene, shadow);
        const std::string stage = shadow == probes::IndirectShadow::rays ? "probes.shadow_rays" : "probes.indirect_shadow";
        const frame::Frame pruned = frame_of(scene, settings);
        CHECK(row(pruned, stage).rule == "nothing-moves");
        settings.pruning = false;
        const frame::Frame whole = frame_of(scene, settings);
        CHECK(row(whole, stage).needed);
        CHECK(pruned.indirect.texels == off.indirect.texels);
        CHECK(whole.indirect.texels == off.indirect.texels);
        CHECK(pruned.radiance.texels == off.radiance.texels);
    }
    // With something that moves the rule holds back: else the picture would be that without shadows.
    const Scene moving = glowing_room(true);
    const frame::Frame shaded = frame_of(moving, settings_with(moving, probes::IndirectShadow::spheres));
    CHECK(row(shaded, "probes.indirect_shadow").rule.empty());
    CHECK(shaded.indirect.texels != frame_of(moving, settings_with(moving, probes::IndirectShadow::off)).indirect.texels);
    // Of a bake without spatial receivers light comes from everywhere alike.
    frame::Settings bare = settings_with(moving, probes::IndirectShadow::spheres);
    frame::add_bake(moving, bare);
    auto without = std::make_shared<probes::Bake>(*bare.bake);
    without->spatial = {};
    bare.bake = without;
    frame::Settings uniform = bare;
    uniform.probe_run.indirect_shadow = probes::IndirectShadow::uniform;
    const frame::Frame alike = frame::execute(moving, bare, frame::plan(moving, bare), {});
    CHECK(alike.indirect.texels == frame::execute(moving, uniform, frame::plan(moving, uniform), {}).indirect.texels);
    CHECK(row(alike, "probes.indirect_shadow").needed);
}

TEST_CASE("probes: a mesh is fitted once, its spheres move, and what is explained is what is seen", "[probes][shade][frame][keys]") {
    Scene scene = glowing_room(true);
    frame::Settings settings = settings_with(scene, probes::IndirectShadow::spheres);
    frame::add_bake(scene, settings);
    frame::KeptStages kept;
    const auto next = [&]() -> const frame::Frame& { return frame::execute(scene, settings, frame::plan(scene, settings), {}, kept); };
    next();
    CHECK_FALSE(ran(next(), "probes.indirect_shadow"));
    scene.meshes[1].transform[3].x += 0.3;
    const frame::Frame& f = next();
    CHECK(ran(f, "probes.shadow_spheres (light)"));
    CHECK(ran(f, "probes.indirect_shadow"));
    CHECK_FALSE(ran(f, "probes.shadow_spheres (fit)"));
    CHECK_FALSE(ran(f, "probes.lightmap"));
    CHECK(frame_of(scene, settings).indirect.texels == f.indirect.texels);
    for (const glm::ivec2 at : {glm::ivec2(20, 20), glm::ivec2(3, 30)}) {
        glm::vec3 value(-1);
        for (const frame::Explanation& e : frame::explain(scene, settings, frame::plan(scene, settings), f, "probes.indirect_shadow", -1, at))
            for (const TapValue& v : e.values)
                if (v.name == "shaded") value = glm::vec3(v.value[0], v.value[1], v.value[2]);
        CHECK(value == glm::vec3(f.indirect(at.x, at.y)));
    }
    settings.probe_run.shadow_spheres = 4;
    CHECK(ran(next(), "probes.shadow_spheres (fit)"));
    settings.probe_run.indirect_shadow = probes::IndirectShadow::off;
    const frame::Frame& bare = next();
    CHECK(bare.probes.shadow_spheres.owner.empty());
    CHECK(frame_of(scene, settings).indirect.texels == bare.indirect.texels);
}

TEST_CASE("probes: shadows' bits do not depend on threads or instruction sets", "[probes][shade][frame][bits]") {
    const Scene scene = glowing_room(true);
    for (const auto shadow : {probes::IndirectShadow::reflecting, probes::IndirectShadow::rays}) {
        const frame::Settings settings = settings_with(scene, shadow);
        RunOptions options;
        options.isa = Isa::scalar, options.threads = 1;
        const frame::Frame first = frame_of(scene, settings, options);
        for (const Isa isa : supported_isas()) {
            options.isa = isa, options.threads = 3;
            CHECK(frame_of(scene, settings, options).radiance.texels == first.radiance.texels);
        }
    }
}
