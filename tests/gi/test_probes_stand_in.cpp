// Directions of a probe that nobody asks: which ray stands for them, and that light stays what it is beside an opening.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/sky_probe.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

// A room without its wall at the largest z, whose surfaces emit 2 W/m2 and reflect rho.
Scene open_room(float rho) {
    Scene scene = empty_room();
    for (Material& m : scene.materials) m.emission = glm::vec3(2), m.reflectance = glm::vec3(rho);
    glm::vec3 low, high;
    bounds(flatten(scene), low, high);
    std::size_t removed = 0;
    for (Mesh& mesh : scene.meshes)
        for (std::size_t t = mesh.triangles.size(); t-- > 0;) {
            const glm::uvec3 c = mesh.triangles[t];
            const auto at_end = [&](std::uint32_t v) { return mesh.vertices[v].position.z == high.z; };
            if (at_end(c.x) && at_end(c.y) && at_end(c.z)) {
                mesh.triangles.erase(mesh.triangles.begin() + std::ptrdiff_t(t)), ++removed;
                mesh.material.erase(mesh.material.begin() + std::ptrdiff_t(t));
            }
        }
    REQUIRE(removed == 2);
    scene.camera.position = glm::dvec3(low + high) * 0.5;
    scene.camera.look_at = scene.camera.position + glm::dvec3(0.3, -0.1, -1);
    scene.camera.near = 1e-3, scene.frame_size = {16, 12}, scene.method = "probes";
    return scene;
}

frame::Frame frame_of(const Scene& scene, probes::Unasked unasked) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5, settings.probes.threshold = 1e-7f, settings.probes.singular_values = 64;
    settings.probe_run.unasked = unasked, settings.probe_run.tolerance = 1e-6f;
    frame::add_bake(scene, settings);
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

// Irradiance of receivers over what it is under the radiance 2 / pi from every front that they see: by told_share(). Mean and
// largest deviation.
std::pair<double, double> ratio_of(const Scene& scene, probes::Unasked unasked, probes::Gather gather = probes::Gather::interpolated) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.gather = gather;
    settings.probes.receivers_per_m2 = 5, settings.probes.threshold = 1e-7f, settings.probes.singular_values = 64;
    settings.probe_run.unasked = unasked;
    frame::add_bake(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), {});
    const probes::Bake& b = *settings.bake;
    std::size_t open = 0;
    for (const std::int32_t m : b.relight.material) open += m == probes::met_nothing ? 1 : 0;
    REQUIRE(open > b.relight.material.size() / 20);
    double sum = 0, most = 0;
    int seen = 0;
    for (int i = 0; i < b.receivers.count(); ++i) {
        const double expected = 2 * double(probes::told_share(b, i));
        if (!(expected > 0.1)) continue;
        const double ratio = double(f.probes.irradiance.texels[std::size_t(f.probes.data.place_of[std::size_t(i)])].x) / expected;
        sum += ratio, most = std::max(most, std::isnan(ratio) ? INFINITY : std::fabs(ratio - 1)), ++seen;
    }
    REQUIRE(seen > b.receivers.count() / 2);
    return {sum / seen, most};
}

Buffer<glm::vec4> four_directions() { return {{1, 0, 0, 0}, {0.8f, 0.6f, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}; }

}  // namespace

TEST_CASE("stand-ins: the nearest ray that is asked, the first of equals", "[probes][unasked]") {
    using V = std::vector<std::int32_t>;
    CHECK(probes::stand_ins(four_directions(), {1, 1, 1, 1}, {}) == V{0, 1, 2, 3});
    CHECK(probes::stand_ins(four_directions(), {0, 1, 1, 1}, {}) == V{1, 1, 2, 3});      // 0.8 against 0
    CHECK(probes::stand_ins(four_directions(), {1, 0, 1, 1}, {}) == V{0, 0, 2, 3});      // 0.8 against 0.6
    CHECK(probes::stand_ins(four_directions(), {1, 0, 0, 0}, {}) == V{0, 0, 0, 0});
    CHECK(probes::stand_ins(four_directions(), {1, 1, 1, 0}, {}) == V{0, 1, 2, 0});      // all have the cosine 0
    CHECK(probes::stand_ins(four_directions(), {0, 0, 0, 0}, {}) == V{0, 1, 2, 3});      // a probe that finds nothing
    CHECK(probes::stand_ins(four_directions(), {1, 1, 1, 1, 0, 1, 1, 1}, {}) == V{0, 1, 2, 3, 5, 5, 6, 7});
    CHECK(probes::stand_ins({}, {}, {}).empty());
    CHECK_THROWS_AS(probes::stand_ins(four_directions(), {1, 1, 1}, {}), InputError);
}

TEST_CASE("stand-ins: of many rays what a search through all finds, however far", "[probes][unasked]") {
    const Buffer<glm::vec4> directions = probes::relight_directions(512);
    for (const float edge : {0.9f, 0.0f, -0.95f}) {  // asked: below it; the last leaves some ten rays, beyond every list of neighbours
        std::vector<std::uint8_t> asked;
        for (const glm::vec4& d : directions) asked.push_back(d.z < edge ? 1 : 0);
        const std::vector<std::int32_t> of = probes::stand_ins(directions, asked, {});
        int wrong = 0;
        for (std::size_t r = 0; r < directions.size(); ++r) {
            const auto cosine = [&](std::size_t q) { return glm::dot(glm::dvec3(directions[r]), glm::dvec3(directions[q])); };
            std::size_t best = r;
            for (std::size_t q = 0; q < directions.size(); ++q)
                if (!asked[r] && asked[q] && (best == r || cosine(q) > cosine(best))) best = q;
            wrong += of[r] == std::int32_t(best) ? 0 : 1;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("stand-ins: beside an opening constant radiance stays constant", "[probes][unasked][analytic]") {
    // All that receivers see is 2 / pi, and so all that probes are asked. Their harmonics of a constant are exact (relight weights).
    const auto [mean, most] = ratio_of(open_room(0), probes::Unasked::nearest);
    CHECK(mean == Approx(1).epsilon(1e-5));
    CHECK(most < 1e-4);
    // Published: the opening is black, and its edge is 25 degrees wide.
    const auto [black_mean, black_most] = ratio_of(open_room(0), probes::Unasked::black);
    CHECK(black_mean < 0.99);
    CHECK(black_mean > 0.9);
    CHECK(black_most > 0.05);
}

TEST_CASE("stand-ins: under a sky that sends light the opening is asked, and shines itself", "[probes][unasked][analytic]") {
    Scene scene = open_room(0);
    scene.environment.radiance = glm::vec3(float(2 / host::pi));
    const frame::Frame f = frame_of(scene, probes::Unasked::nearest);
    double least = 1e300, most = 0;
    for (const glm::vec4& e : f.probes.irradiance.texels)
        if (e.w == 1 && e.x > 0.1f) least = std::min(least, double(e.x)), most = std::max(most, double(e.x));
    CHECK(least > 2 * (1 - 1e-2));  // rays that meet a probe's back side of a wall bring nothing
    CHECK(most < 2 * (1 + 1e-4));
    // Another sky. Of the published solution the void has its radiance; else the sky itself has it, and walls go on beyond the opening.
    scene.environment.radiance = glm::vec3(50);
    for (const probes::Escapes escapes : {probes::Escapes::same_direction, probes::Escapes::automatic}) {
        frame::Settings settings = frame::settings_of(scene);
        settings.probes = small(), settings.probes.escapes = escapes;
        frame::add_bake(scene, settings);
        const probes::Bake& b = *settings.bake;
        const bool own = escapes == probes::Escapes::automatic;
        const std::size_t rays = std::size_t(b.relight.rays), standing = std::size_t(probes::standing_probes(b.placement.probes));
        REQUIRE(b.placement.probes.size() == standing + (own ? 1 : 0));
        const probes::HitSurfaces hits = probes::hit_surfaces(scene, b, {}, probes::Unasked::nearest);
        int wrong = 0, sky = 0;
        for (std::size_t i = 0; i < b.relight.material.size(); ++i) {
            if (b.relight.material[i] != probes::met_nothing) continue;
            const bool shines = hits.emitted.texels[i].x == 50 && hits.surface.texels[i].w == 0;
            ++sky, wrong += shines == (!own || i / rays == standing) ? 0 : 1;
        }
        CHECK(sky > 0);
        CHECK(wrong == 0);
    }
}

TEST_CASE("stand-ins: through an opening receivers see the sky in its own directions", "[probes][unasked][analytic]") {
    // A room that sends nothing: irradiance is that of the sky through the opening, which rays of receivers have found, and no
    // probe's harmonics blur.
    Scene scene = open_room(0);
    for (Material& m : scene.materials) m.emission = glm::vec3(0);
    scene.environment.radiance = glm::vec3(3);
    for (const probes::Escapes escapes : {probes::Escapes::automatic, probes::Escapes::same_direction}) {
        frame::Settings settings = frame::settings_of(scene);
        settings.probes = small(), settings.probes.escapes = escapes;
        settings.probes.receivers_per_m2 = 5, settings.probes.threshold = 1e-7f, settings.probes.singular_values = 64;
        frame::add_bake(scene, settings);
        const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), {});
        const probes::Bake& b = *settings.bake;
        probes::BakeGraph graph(scene, settings.probes);
        graph::run(graph.nodes(), {});
        double worst = 0;
        for (int first = 0; first < b.receivers.count(); first += probes::block_receivers) {
            const probes::TracedBlock traced = graph.traced(first, {});
            for (int i = 0; i < traced.count; ++i) {
                int open = 0;
                for (int k = 0; k < traced.rays; ++k) open += traced.seen[std::size_t(k * traced.count + i)].w == 0 ? 1 : 0;
                const double e = f.probes.irradiance.texels[std::size_t(f.probes.data.place_of[std::size_t(first + i)])].x;
                worst = std::max(worst, std::fabs(e - 3 * host::pi * open / traced.rays));
            }
        }
        CAPTURE(int(escapes));
        if (escapes == probes::Escapes::automatic)
            CHECK(worst < 1e-3 * 3 * host::pi);
        else
            CHECK(worst > 0.05 * 3 * host::pi);
    }
}

TEST_CASE("stand-ins: with what moves in the way, rays that nobody asks continue what is met now", "[probes][unasked][relight]") {
    Scene scene = open_room(0.5f);
    scene.environment.radiance = glm::vec3(3);
    Mesh box;
    add_box(box, glm::vec3(-0.5f), glm::vec3(0.45f), 0);
    box.dynamic = true;
    scene.meshes.push_back(box);
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small(), settings.probe_run.relight_dynamic = true;
    frame::add_bake(scene, settings);
    const probes::Bake& b = *settings.bake;
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), {});
    const std::vector<std::int32_t> ray_of = probes::stand_ins(b, probes::Unasked::nearest, {});
    const std::size_t rays = std::size_t(b.relight.rays), standing = std::size_t(probes::standing_probes(b.placement.probes));
    int on_box = 0, beyond = 0, taken_over = 0, wrong = 0, of_sky = 0;
    for (std::size_t i = 0; i < ray_of.size(); ++i) {
        const glm::vec4 at = f.views[1].gbuffer.position.texels[i], surface = f.probes.surface.texels[i];
        if (i / rays >= standing) {
            wrong += f.probes.emitted.texels[i].x == 3 && surface.w == 0 ? 0 : 1, ++of_sky;
            continue;
        }
        const std::size_t from = std::size_t(ray_of[i]);
        const glm::dvec3 low(-0.5), high(0.45f), p(at);
        const bool there = surface.w == 1 && std::fabs(std::max({low.x - p.x, p.x - high.x, low.y - p.y, p.y - high.y, low.z - p.z, p.z - high.z})) < 1e-5;
        if (from != i) {
            wrong += at == f.views[1].gbuffer.position.texels[from] ? 0 : 1, taken_over += there ? 1 : 0;
            continue;
        }
        // The slabs of the box, from the probe to where the ray ended without it.
        const glm::dvec3 origin(b.placement.probes[i / rays]), to = glm::dvec3(b.relight.position[i]) - origin;
        double enter = 0, leave = 1;
        for (int c = 0; c < 3; ++c) {
            const double a = (low[c] - origin[c]) / to[c], d = (high[c] - origin[c]) / to[c];
            enter = std::max(enter, std::min(a, d)), leave = std::min(leave, std::max(a, d));
        }
        if (std::fabs(leave - enter) < 1e-4) continue;  // along an edge
        (enter < leave ? on_box : beyond) += 1;
        wrong += there == (enter < leave) ? 0 : 1;
    }
    CAPTURE(on_box, beyond, taken_over, of_sky);
    CHECK(on_box > 20);
    CHECK(beyond > 100);
    CHECK(taken_over > 0);
    CHECK(of_sky == int(rays));
    CHECK(wrong == 0);
}

TEST_CASE("stand-ins: a fitted transport counts on them, and black is refused before anything is made", "[probes][unasked][fit][analytic][refused]") {
    const Scene scene = open_room(0);
    const auto [mean, most] = ratio_of(scene, probes::Unasked::nearest, probes::Gather::fitted);
    CHECK(mean == Approx(1).epsilon(1e-5));
    CHECK(most < 1e-4);
    const auto refused = Catch::Matchers::Contains("[probes] unasked = black: the bake's gather = fitted takes from probes what stands for");
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small(), settings.probes.gather = probes::Gather::fitted, settings.probe_run.unasked = probes::Unasked::black;
    CHECK_THROWS_WITH(frame::plan(scene, settings), refused);
    // Where the parameters leave no fit (transport_params) there is nothing to refuse.
    settings.probes.weighting = probes::Weighting::published;
    CHECK_NOTHROW(frame::plan(scene, settings));
    settings.probes.weighting = probes::Weighting::none;
    // Of a bake that is there its own way counts, not the settings'.
    frame::Settings baked = settings;
    frame::add_bake(scene, baked);
    baked.probes.gather = probes::Gather::interpolated;
    CHECK_THROWS_WITH(frame::plan(scene, baked), refused);
    baked.probe_run.unasked = probes::Unasked::nearest;
    CHECK_NOTHROW(frame::plan(scene, baked));
}

TEST_CASE("stand-ins: with levels of detail, too, a ray that nobody asks finds what the one that stands for it does, to the bit", "[probes][unasked][lod][frame]") {
    // It looks the lightmap up where that one ends: in that place's level, not in its probe's.
    Scene scene = open_room(0.5f);
    for (Material& m : scene.materials) m.emission = glm::vec3(0);
    Light lamp;
    lamp.type = LightType::point, lamp.position = glm::vec3(0.5f, 1, -0.5f), lamp.intensity = glm::vec3(5), lamp.rsm_size = 32;
    scene.lights = {lamp};
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small(), settings.probes.receivers_per_m2 = 30, settings.probes.gap = 24, settings.probes.cluster_receivers = 32;
    settings.lod.levels = 4, settings.lod.distance_1 = 1.7f, settings.lod.distance_2 = 2.2f, settings.lod.distance_3 = 2.6f;
    frame::add_bake(scene, settings);
    const probes::Bake& b = *settings.bake;
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), {});
    const std::vector<std::int32_t> of = probes::stand_ins(b, probes::Unasked::nearest, {});
    const View v = make_view(scene.camera, double(scene.frame_size.x) / scene.frame_size.y, scene.convention, scene.frame_size);
    const std::vector<std::int32_t> own = probes::levels_at(f.probes.lod, b, probes::lod_boxes(b, probes::Unasked::black), glm::vec3(v.eye), glm::vec3(v.forward), {}).hit;
    int standing = 0, differing = 0, elsewhere = 0;
    for (std::size_t k = 0; k < of.size(); ++k) {
        if (of[k] == std::int32_t(k)) continue;
        const std::size_t as = std::size_t(of[k]);
        ++standing, differing += f.probes.radiance.texels[k] != f.probes.radiance.texels[as];
        elsewhere += float(own[k]) != f.probes.placed.texels[as].z;
    }
    CHECK(standing > 100);
    CHECK(elsewhere > 20);  // else the levels would say nothing
    CHECK(differing == 0);
}
