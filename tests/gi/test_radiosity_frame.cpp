// Method radiosity in frames: energy of closed rooms, what is left out of dark ones, scenes of nothing.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "gi/frame/frame.h"
#include "gi/radiosity/rows.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

Scene room(float rho, float emission) {
    Scene scene = empty_room();
    for (Material& m : scene.materials) m.emission = glm::vec3(emission), m.reflectance = glm::vec3(rho);
    glm::vec3 low, high;
    bounds(flatten(scene), low, high);
    scene.camera.position = glm::dvec3(low + high) * 0.5;
    scene.camera.look_at = scene.camera.position + glm::dvec3(0.3, -0.1, -1);
    scene.camera.near = 1e-3, scene.frame_size = {24, 16}, scene.method = "radiosity";
    scene.environment = {};
    for (Light& light : scene.lights) light.on = false;
    return scene;
}

frame::Frame frame_of(const Scene& scene, const frame::Settings& settings, Isa isa = best_isa(), int threads = 0) {
    RunOptions options;
    options.isa = isa, options.threads = threads;
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

TEST_CASE("radiosity: a closed room that emits M and reflects rho everywhere has M / (1 - rho) at every pixel", "[radiosity][frame][analytic]") {
    for (const float rho : {0.0f, 0.5f, 0.9f}) {
        const Scene scene = room(rho, 2);
        frame::Settings settings = frame::settings_of(scene);
        settings.radiosity.size = 16, settings.radiosity.tolerance = 1e-6f;
        for (const radiosity::Kind kind : {radiosity::Kind::vertices, radiosity::Kind::triangles}) {
            settings.radiosity.kind = kind;
            const frame::Frame f = frame_of(scene, settings);
            double worst = 0;
            for (const glm::vec4& h : f.indirect.texels) worst = std::max(worst, std::fabs(h.x * (1 - rho) / 2 - 1.0));
            CAPTURE(rho, int(kind), worst, f.radiosity.solved.solution.products);
            CHECK(worst < 1e-5);
        }
    }
}

TEST_CASE("radiosity: a room of triangles that look outwards is told from one that looks inwards", "[radiosity][frame]") {
    for (const bool outwards : {false, true}) {
        Scene scene = room(0.5f, 2);
        for (Mesh& mesh : scene.meshes)
            for (glm::uvec3& t : mesh.triangles)
                if (outwards) std::swap(t.y, t.z);
        frame::Settings settings = frame::settings_of(scene);
        settings.radiosity.size = 16, settings.radiosity.refine = 0;
        std::string reason;
        for (const frame::StageRun& run : frame_of(scene, settings).stages)
            if (run.label == "radiosity.rows") reason = run.reason;
        CAPTURE(outwards, reason);
        REQUIRE_FALSE(reason.empty());
        CHECK((reason.find("do normals look outwards?") != std::string::npos) == outwards);
    }
}

TEST_CASE("radiosity: rows add up to one in a closed room, and the sky is seen through what is open", "[radiosity][analytic]") {
    Scene scene = room(0.5f, 0);
    scene.environment.radiance = glm::vec3(1);
    frame::Settings settings = frame::settings_of(scene);
    const frame::Frame closed = frame_of(scene, settings);
    for (const radiosity::RowBlock& block : closed.radiosity.factors.blocks)
        for (int i = 0; i < block.count; ++i) {
            std::vector<float> row(std::size_t(closed.radiosity.factors.count), 0.0f);
            closed.radiosity.factors.add_row(block.first + i, row);
            double sum = 0;
            for (const float f : row) sum += double(f);
            CHECK(sum == Approx(1).margin(1e-5));
            CHECK(block.escaped[std::size_t(i)] == 0);
        }
    for (const glm::vec4& h : closed.indirect.texels) CHECK(h.x == 0);
    // One triangle alone sees nothing but sky from its front: pi L.
    scene.meshes.resize(1);
    scene.meshes[0].triangles.resize(1), scene.meshes[0].material.resize(1);
    settings.pruning = false;  // the camera does not see it
    const frame::Frame open = frame_of(scene, settings);
    REQUIRE(open.radiosity.irradiance.size() == 3);
    for (const glm::vec4& h : open.radiosity.irradiance) CHECK(h.x == Approx(M_PI).epsilon(1e-6));
}

TEST_CASE("radiosity: where nothing sends light nothing runs, and the picture is the same", "[radiosity][frame][pruning]") {
    const Scene dark = room(0.5f, 0), lit = room(0.5f, 1);
    for (const Scene* scene : {&dark, &lit}) {
        frame::Settings settings = frame::settings_of(*scene);
        settings.radiosity.size = 8;
        const frame::Frame pruned = frame_of(*scene, settings);
        int left_out = 0;
        for (const frame::StageRun& s : pruned.stages) left_out += s.rule == "no-radiance" ? 1 : 0;
        CHECK(left_out == (scene == &dark ? 6 : 0));
        settings.pruning = false;
        const frame::Frame whole = frame_of(*scene, settings);
        CHECK(same(pruned.radiance, whole.radiance));
        CHECK((whole.radiance.texels[100].x > 0) == (scene == &lit));
    }
}

TEST_CASE("radiosity: the same bits for every instruction set and number of threads", "[radiosity][frame][bits]") {
    const Scene scene = room(0.7f, 1);
    frame::Settings settings = frame::settings_of(scene);
    settings.radiosity.size = 22;
    const frame::Frame first = frame_of(scene, settings, Isa::scalar, 1);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            CAPTURE(isa_name(isa), threads);
            CHECK(same(frame_of(scene, settings, isa, threads).radiance, first.radiance));
        }
}

TEST_CASE("radiosity: passes that are too few, and rows that need too much memory, are refused with the number", "[radiosity][bad input]") {
    const Scene scene = room(0.9f, 1);
    frame::Settings settings = frame::settings_of(scene);
    settings.radiosity.solver = radiosity::SolverChoice::passes, settings.radiosity.passes = 3;
    CHECK_THROWS_WITH(frame_of(scene, settings), Catch::Contains("not converged after 3 products"));
    const radiosity::Elements e = radiosity::elements_of(scene, {});
    CHECK_THROWS_WITH(radiosity::form_factors(e, {}, {}, 100), Catch::Contains("at most 0.0 are allowed"));
}
