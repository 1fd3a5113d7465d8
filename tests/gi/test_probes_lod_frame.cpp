// Level of detail in frames: what a walk leaves out of the lightmap changes no bit.
#include <catch2/catch.hpp>
#include <cstring>

#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;
using namespace plumb::probes;

namespace {

bool same_bits(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

TEST_CASE("lod tiles: frames of a walk have the bits of frames that write everything, and of fresh ones", "[probes][frame][lod][tiles][pruning]") {
    for (const Loop loop : {Loop::converged, Loop::pipelined}) {
        Scene scene = furnished();
        for (Material& m : scene.materials) m.reflectance = glm::vec3(0.7f), m.emission = glm::vec3(0.5f);
        scene.camera.look_at = {1, -0.1, 0.2}, scene.camera.fov_y_deg = 80, scene.camera.near = 1e-3;
        scene.frame_size = {33, 27}, scene.method = "probes";
        frame::Settings settings = frame::settings_of(scene);
        settings.probes = small(), settings.probes.receivers_per_m2 = 40, settings.probes.gap = 12, settings.probes.cluster_receivers = 32;
        settings.lod.levels = 3, settings.lod.distance_1 = 0.4f, settings.lod.distance_2 = 1.2f;
        settings.probe_run.loop = loop;
        frame::add_bake(scene, settings);
        frame::KeptStages kept, whole;
        std::int64_t left_out = 0;
        for (int n = 0; n < 5; ++n) {
            scene.camera.position = {-1.5 + 0.7 * n, 0.1, 0.1}, scene.camera.look_at.x = scene.camera.position.x + 1;
            settings.pruning = true;
            const frame::Plan plan = frame::plan(scene, settings);
            const frame::Frame& f = frame::execute(scene, settings, plan, {}, kept);
            const Buffer<std::uint8_t>& wanted = f.probes.tiles.wanted.any;
            left_out += std::count(wanted.begin(), wanted.end(), 0);
            if (loop == Loop::converged) {
                const frame::Frame fresh = frame::execute(scene, settings, plan, {});
                CHECK(same_bits(fresh.probes.lightmap, f.probes.lightmap));
                CHECK(same_bits(fresh.radiance, f.radiance));
            }
            settings.pruning = false;
            const frame::Frame& w = frame::execute(scene, settings, frame::plan(scene, settings), {}, whole);
            CHECK(std::count(w.probes.tiles.wanted.any.begin(), w.probes.tiles.wanted.any.end(), 0) == 0);
            CHECK(same_bits(w.radiance, f.radiance));
            CHECK(same_bits(w.indirect, f.indirect));
            if (loop == Loop::pipelined) CHECK(same_bits(w.probes.lightmap, f.probes.lightmap));
        }
        CHECK(left_out > 0);
    }
}
