// What moves before probes and pixels, in closed form: relight rays that end at a dynamic mesh, which way hits look, what a group of
// meshes reflects, and rays to what a surface belongs to itself.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/host_math.h"
#include "gi/frame/probe_bake.h"
#include "gi/frame/frame.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/receivers.h"
#include "gi/probes/shadow_rays.h"
#include "gi/probes/shadow_spheres.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/volume.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

// A square of side 2 across z, its front towards +z, or -z.
Mesh square(float z, bool up, int material) {
    Mesh mesh;
    const glm::vec3 n(0, 0, up ? 1.0f : -1.0f);
    for (const auto& [x, y] : {std::pair(-1.0f, -1.0f), {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) mesh.vertices.push_back({{x, y, z}, x, n, y});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (!up) mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    mesh.material.assign(2, material);
    mesh.dynamic = true;
    return mesh;
}

const glm::vec4 untouched(7, 7, 7, 7);

}  // namespace

TEST_CASE("relight rays: what ends at a dynamic mesh has its surface, black where that is a back; all others stay", "[probes][relight][dynamic][analytic]") {
    // From the origin: a front at z = 1, a back at z = -1. Of the mesh M = (3, 2, 1) W/m2.
    Scene scene;
    scene.materials.resize(2);
    scene.materials[1].reflectance = {0.5f, 0.25f, 0.125f}, scene.materials[1].emission = {3, 2, 1};
    scene.meshes = {square(1, false, 1), square(-1, false, 1)};
    const auto world = dynamic_world(scene, flatten(scene));
    enum Ray { behind, before, on_it, through, aside, back, rays };
    Bake bake;
    bake.placement.probes = {glm::vec4(0, 0, 0, 5), sky_probe};
    bake.relight = no_hits(2, rays);
    const auto ends = [&](Ray ray, const glm::vec3& at) {
        bake.relight.material[std::size_t(ray)] = 0, bake.relight.triangle[std::size_t(ray)] = 0, bake.relight.position[std::size_t(ray)] = glm::vec4(at, 1);
    };
    ends(behind, {0.5f, 0.25f, 2}), ends(before, {0.1f, 0, 0.5f}), ends(on_it, {0, 0.25f, 1}), ends(back, {0.25f, 0, -3});
    bake.relight.material[std::size_t(back)] = met_back;  // of a back of what stands still, too
    bake.relight.position[through] = {0, 0, 1, 0}, bake.relight.position[aside] = {1, 0, 0, 0};
    for (int ray = 0; ray < rays; ++ray) bake.relight.position[std::size_t(rays + ray)] = {0, 0, 1, 0};  // the sky's
    HitSurfaces made;
    for (Image4* image : {&made.position, &made.normal, &made.surface, &made.emitted, &made.place}) *image = Image4(rays, 2, untouched);
    CHECK(meet_dynamic(*world, bake, {}, made) == 3);
    const auto same = [](const glm::vec4& a, const glm::dvec4& b) {
        for (int c = 0; c < 4; ++c) CHECK(double(a[c]) == Approx(b[c]).margin(1e-6));
    };
    for (const auto& [ray, at] : {std::pair(behind, glm::dvec4(0.25, 0.125, 1, 0)), {through, glm::dvec4(0, 0, 1, 0)}}) {
        CAPTURE(int(ray));
        same(made.position(ray, 0), at);
        same(made.normal(ray, 0), {0, 0, -1, 1});  // towards the probe
        same(made.surface(ray, 0), {0.5, 0.25, 0.125, 1});
        same(made.emitted(ray, 0), {3 / host::pi, 2 / host::pi, 1 / host::pi, 0});  // radiance: M / pi
    }
    for (const Image4* image : {&made.position, &made.normal, &made.surface, &made.emitted}) CHECK((*image)(back, 0) == glm::vec4(0));
    for (const Image4* image : {&made.position, &made.normal, &made.surface, &made.emitted}) {
        for (const Ray ray : {before, on_it, aside}) CHECK((*image)(ray, 0) == untouched);
        for (int ray = 0; ray < rays; ++ray) CHECK((*image)(ray, 1) == untouched);  // the sky is not hidden from itself
    }
    for (const glm::vec4& place : made.place.texels) CHECK(place == untouched);  // indirect light is that where the ray would have ended
    // Nothing moves: nothing is met.
    for (Mesh& mesh : scene.meshes) mesh.dynamic = false;
    CHECK(meet_dynamic(*dynamic_world(scene, flatten(scene)), bake, {}, made) == 0);
}

TEST_CASE("relight rays: hits of a room look inwards, towards their probe", "[probes][relight][analytic]") {
    Scene scene = empty_room();
    scene.materials[0].emission = {2, 4, 6};
    const BakeParams params = [] { BakeParams p = small(); p.relight_rays = 64; return p; }();
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake bake = graph.release();
    const HitSurfaces hits = hit_surfaces(scene, bake, {}, Unasked::black);
    int met = 0;
    for (int p = 0; p < bake.relight.probes; ++p)
        for (int ray = 0; ray < bake.relight.rays; ++ray) {
            const std::size_t i = std::size_t(p) * std::size_t(bake.relight.rays) + std::size_t(ray);
            if (bake.relight.material[i] < 0 || hits.normal.texels[i].w == 0) continue;
            const glm::dvec3 at(hits.position.texels[i]), to = glm::dvec3(bake.placement.probes[std::size_t(p)]) - at;
            CHECK(glm::dot(glm::dvec3(hits.normal.texels[i]), to) > 0);
            CHECK(double(hits.emitted.texels[i].y) == Approx(4 / host::pi).epsilon(1e-6));
            ++met;
        }
    CHECK(met > 200);
}

TEST_CASE("shadow spheres: what a group reflects is the mean of its materials, by area", "[probes][shade][spheres][analytic]") {
    // 4 m2 of 0.8, 4 m2 of 0.2 and, scaled by nothing, 1 m2 of 0.5: one group.
    Scene scene;
    scene.materials.resize(3);
    scene.materials[0].reflectance = glm::vec3(0.8f, 0, 0), scene.materials[1].reflectance = glm::vec3(0.2f, 0.4f, 0), scene.materials[2].reflectance = glm::vec3(0.5f, 0, 1);
    Mesh small_one = square(2, true, 2);
    for (Vertex& v : small_one.vertices) v.position.x *= 0.5f, v.position.y *= 0.5f;
    scene.meshes = {square(0, true, 0), square(1, true, 1), small_one};
    const std::vector<glm::vec3> mean = mean_reflectance(scene);
    REQUIRE(mean.size() == 3);
    for (const glm::vec3& rho : mean) {
        CHECK(double(rho.x) == Approx((4 * 0.8 + 4 * 0.2 + 0.5) / 9));
        CHECK(double(rho.y) == Approx(4 * 0.4 / 9));
        CHECK(double(rho.z) == Approx(1.0 / 9));
    }
    // A mesh of two materials, and one that stands still.
    scene.meshes = {square(0, true, 0), square(5, true, 2)};
    scene.meshes[0].material[1] = 1, scene.meshes[1].dynamic = false;
    CHECK(double(mean_reflectance(scene)[0].x) == Approx(0.5));
    CHECK(mean_reflectance(scene)[1] == glm::vec3(0));
}

TEST_CASE("shadow rays: a flat mesh does not shadow itself, wherever rounding has put its pixels", "[probes][shade][rays][analytic]") {
    Scene scene;
    scene.materials.resize(1);
    scene.meshes = {square(1, true, 0)};
    const auto world = dynamic_world(scene, flatten(scene));
    // Up to half of the offset below the surface, and above it.
    const float most = 0.5f * world->offset;
    REQUIRE(most > 0);
    Image4 position(9, 1), normal(9, 1, glm::vec4(0, 0, 1, 1)), irradiance(9, 1, glm::vec4(2, 1, 3, 0)), shaded;
    for (int i = 0; i < 9; ++i) position(i, 0) = {0.1f * float(i) - 0.4f, 0.3f, 1 + most * float(i - 4) / 4, 0};
    ShadowRaysInputs in;
    in.world = world.get(), in.position = &position, in.normal = &normal, in.irradiance = &irradiance;
    run(in, {}, shaded);
    CHECK(shaded.texels == irradiance.texels);
}

TEST_CASE("shadow rays: light of degree 0 and 1 is hidden as the rectangle before it has it", "[probes][shade][rays][analytic]") {
    // L = 0.3 + b . w, and a rectangle of 2 x 2 at z = 0.7, beside the middle: pi E of what is hidden by quadrature over the rectangle.
    Scene scene;
    scene.materials.resize(1);
    Mesh mesh = square(0.7f, false, 0);
    for (Vertex& v : mesh.vertices) v.position.x += 0.6f;
    scene.meshes = {mesh};
    const auto world = dynamic_world(scene, flatten(scene));
    const glm::dvec3 b(0.2, -0.05, -0.1);
    Buffer<glm::vec4> six;
    for (int d = 0; d < spatial_directions; ++d)
        six.push_back(glm::vec4(float(host::pi * 0.3 + 2 * host::pi / 3 * glm::dot(b, glm::dvec3(spatial_direction(d))))));
    const SpatialGrid grid{{1, 1, 1}, {0, 0, 0}, {1, 1, 1}};
    double hidden = 0, share = 0;
    const int cells = 400;
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const glm::dvec3 to(-0.4 + 2 * (i + 0.5) / cells, -1 + 2 * (j + 0.5) / cells, 0.7);
            const double d2 = glm::dot(to, to), form = to.z * to.z / (d2 * d2) * 4 / cells / cells;
            hidden += (0.3 + glm::dot(b, to) / std::sqrt(d2)) * form, share += form / host::pi;
        }
    Image4 position(4, 4, glm::vec4(0)), normal(4, 4, glm::vec4(0, 0, 1, 1)), irradiance(4, 4, glm::vec4(2)), shaded;
    ShadowRaysInputs in;
    in.world = world.get(), in.rays = 4096, in.position = &position, in.normal = &normal, in.irradiance = &irradiance;
    in.grid = &grid, in.six = &six;
    run(in, {}, shaded);
    for (const glm::vec4& e : shaded.texels) CHECK(double(e.x) == Approx(2 - hidden).margin(0.003));
    // Without a grid light comes from everywhere alike, which is far off here.
    in.grid = nullptr;
    run(in, {}, shaded);
    for (const glm::vec4& e : shaded.texels) CHECK(double(e.x) == Approx(2 * (1 - share)).margin(0.005));
    CHECK(std::fabs(2 * share - hidden) > 0.1);
}

namespace {

// A room of 4 m whose ceiling alone glows, and reflects nothing; a black box of 0.4 m may hang in it.
Scene ceiling_room(const glm::dvec3* box_at) {
    Scene scene = empty_room();
    scene.materials.resize(3);
    for (Material& m : scene.materials) m.reflectance = glm::vec3(0);
    scene.materials[1].emission = glm::vec3(1);
    Mesh& room = scene.meshes[0];
    for (std::size_t t = 0; t < room.triangles.size(); ++t) {
        bool ceiling = true;
        for (int k = 0; k < 3; ++k) ceiling = ceiling && room.vertices[room.triangles[t][k]].position.y > 1.9f;
        room.material[t] = ceiling ? 1 : 0;
    }
    if (box_at) {
        Mesh box;
        box.dynamic = true;
        add_box(box, glm::vec3(-0.2f), glm::vec3(0.2f), 0);
        box.material.assign(box.triangles.size(), 2);
        box.transform[3] = glm::dvec4(*box_at, 1);
        scene.meshes.push_back(box);
    }
    scene.camera.position = {0, 1.2, 1.5}, scene.camera.look_at = {0, -2, 0}, scene.camera.fov_y_deg = 60, scene.camera.near = 1e-3;
    scene.frame_size = {40, 32}, scene.method = "probes";
    return scene;
}
frame::Settings settings_for(const Scene& scene) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5, settings.probes.spatial_receivers = 64;
    return settings;
}

}  // namespace

TEST_CASE("probes: shadow rays in a frame take the light of where they end: a box in front of a dark wall hides little", "[probes][shade][frame]") {
    const glm::dvec3 low(1.2, -1.7, 0);
    const Scene scene = ceiling_room(&low);
    frame::Settings settings = settings_for(scene);
    settings.probe_run.indirect_shadow = IndirectShadow::rays, settings.probe_run.shadow_rays = 256;
    frame::add_bake(scene, settings);
    const auto run_with = [&](const frame::Settings& s) { return frame::execute(scene, s, frame::plan(scene, s), {}); };
    frame::Settings off = settings, alike = settings;
    off.probe_run.indirect_shadow = IndirectShadow::off;
    auto without_grid = std::make_shared<Bake>(*settings.bake);
    without_grid->spatial = {};
    alike.bake = without_grid;
    const frame::Frame lit = run_with(off), shaded = run_with(settings), uniform = run_with(alike);
    // Floor that sees the box low above its horizon, where the walls are black.
    double by_grid = 0, by_share = 0;
    int counted = 0;
    for (std::size_t i = 0; i < lit.indirect.size(); ++i) {
        const glm::vec4 n = lit.gbuffer.normal.texels[i], x = lit.gbuffer.position.texels[i];
        if (n.w == 0 || n.y < 0.9f || lit.gbuffer.id.texels[i].x == 1) continue;
        const glm::dvec3 to = low - glm::dvec3(x);
        const double distance = glm::length(to);
        if (!(distance > 0.7 && distance < 1.2)) continue;
        by_grid += 1 - double(shaded.indirect.texels[i].x) / double(lit.indirect.texels[i].x);
        by_share += 1 - double(uniform.indirect.texels[i].x) / double(lit.indirect.texels[i].x);
        ++counted;
    }
    CAPTURE(by_grid / counted, by_share / counted);
    CHECK(counted > 10);
    CHECK(by_share / counted > 0.01);
    CHECK(by_grid < 0.85 * by_share);
}

TEST_CASE("relief: highlights alone need the light vectors of static surfaces", "[probes][relief][frame]") {
    // No lamp, no normal map, nothing moves: what shines is the ceiling, along the light vector of the grid.
    Scene scene = ceiling_room(nullptr);
    scene.materials[0].specular = {0.5f, 0.25f, 0.125f}, scene.materials[0].exponent = 5;
    scene.camera.position = {0, 0, 1.9}, scene.camera.look_at = {0, -2, -1};
    frame::Settings settings = settings_for(scene);
    frame::add_bake(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), {});
    VolumeInputs in;
    in.grid = settings.bake->spatial.grid, in.form = settings.probe_run.volume, in.everywhere = true;
    in.position = &f.gbuffer.position, in.normal = &f.gbuffer.normal, in.lightmap_uv = &f.probes.uv, in.irradiance = &f.probes.bounced;
    VolumeLight light;
    run(in, {}, light);
    double most = 0;
    for (std::size_t i = 0; i < f.radiance.size(); ++i) {
        if (f.gbuffer.normal.texels[i].w == 0) continue;
        const glm::dvec3 x(f.gbuffer.position.texels[i]), n(f.gbuffer.normal.texels[i]), v = glm::normalize(scene.camera.position - x);
        const glm::dvec3 l(light.light.texels[i]);
        const double n_l = std::max(0.0, glm::dot(n, l)), mirrored = std::clamp(2 * glm::dot(n, v) * glm::dot(n, l) - glm::dot(v, l), 0.0, 1.0);
        const double lobe = 7 / (2 * host::pi) * mirrored * mirrored * mirrored * mirrored * mirrored * n_l;
        const bool glossy = f.gbuffer.position.texels[i].y < 1.9f;
        for (int c = 0; c < 3; ++c) {
            const double expected = glossy ? double(scene.materials[0].specular[c]) * lobe * double(light.from_light.texels[i][c]) : 0;
            CHECK(double(f.probes.relief.made.glossy.texels[i][c]) == Approx(expected).epsilon(1e-3).margin(1e-6));
        }
        most = std::max(most, double(f.probes.relief.made.glossy.texels[i].x));
    }
    CHECK(most > 0.01);
}
