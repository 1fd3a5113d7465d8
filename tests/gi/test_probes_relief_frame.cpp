// Normal maps, highlights and static lamps in frames of the method probes: closed forms, what a layer is made of, and what is left out.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "gi/probes/static_light.h"
#include "gi/reference/ray_query.h"
#include "probe_bakes.h"
#include "raster/surfaces.h"

using namespace plumb;
using namespace plumb::test;
using Catch::Matchers::Contains;

namespace {

// One texel, the same everywhere.
Texture constant_map(std::uint32_t r, std::uint32_t g, std::uint32_t b) {
    Texture t;
    t.name = "constant", t.srgb = false, t.filter = Filter::nearest;
    t.texels = Image<std::uint32_t>(1, 1, 0xff000000u | b << 16 | g << 8 | r);
    return t;
}
double coordinate(std::uint32_t byte) { return 2.0 * byte / 255 - 1; }

// A quad of side 1 around a point, its normal n, its u along `along`.
Mesh quad(const glm::dvec3& middle, const glm::dvec3& n, const glm::dvec3& along, int material, double side = 1) {
    Mesh mesh;
    const glm::dvec3 across(n.y * along.z - n.z * along.y, n.z * along.x - n.x * along.z, n.x * along.y - n.y * along.x);
    for (const auto& [s, t] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
        mesh.vertices.push_back({glm::vec3(middle + side * (s * along + t * across)), float(s + 0.5), glm::vec3(n), float(0.5 - t)});
    mesh.tangents.assign(4, glm::vec4(glm::vec3(along), 1));
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = {material, material};
    return mesh;
}

// A room of 4 m whose walls reflect half, a lamp high in a corner, and a camera that looks down onto the middle.
Scene lit_room() {
    Scene scene = empty_room();
    scene.name = "room";
    scene.materials.resize(3);
    scene.materials[0].reflectance = {0.5f, 0.4f, 0.3f};
    Light lamp;
    lamp.name = "lamp", lamp.type = LightType::point, lamp.rsm_size = 128;
    lamp.position = {0.8f, 1.5f, 0.6f}, lamp.intensity = {6, 5, 4};
    scene.lights = {lamp};
    scene.camera.position = {0, 1.2, 1.2}, scene.camera.look_at = {0, 0, 0};
    scene.camera.fov_y_deg = 60, scene.camera.near = 1e-2;
    scene.frame_size = {35, 35};
    scene.method = "probes";
    return scene;
}
Scene with_quad(Scene scene, Mesh mesh, bool dynamic = true) {
    mesh.name = "quad", mesh.dynamic = dynamic;
    scene.meshes.push_back(std::move(mesh));
    return scene;
}

frame::Settings settings_for(const Scene& scene) {
    frame::Settings settings = frame::settings_of(scene);
    settings.shadow.test = direct::ShadowTest::depth;  // normals that a map bends are not those of the surface's plane
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5, settings.probes.spatial_receivers = 27;
    return settings;
}
frame::Frame frame_of(const Scene& scene, frame::Settings settings, const RunOptions& options = {}) {
    frame::add_bake(scene, settings);
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}
frame::Frame frame_of(const Scene& scene) { return frame_of(scene, settings_for(scene)); }

const frame::StageRun& run_of(const frame::Frame& f, const std::string& label) {
    for (const frame::StageRun& s : f.stages)
        if (s.label == label) return s;
    FAIL("no stage " << label);
    return f.stages[0];
}

constexpr glm::ivec2 middle{17, 17};
bool of_quad(const frame::Frame& f, std::size_t i) { return f.gbuffer.id.texels[i].x == 1; }

// Where something is unlike: sum of |a - b| over the pixels that `counts` tells.
template <class Counts>
double apart(const Image4& a, const Image4& b, Counts counts) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (counts(i)) sum += glm::length(glm::dvec3(a.texels[i]) - glm::dvec3(b.texels[i]));
    return sum;
}

}  // namespace

TEST_CASE("relief: a constant normal map is a tilted plane to the grid of the air", "[probes][relief][frame][IPR 4.1.2][analytic]") {
    // E of a form depends on place and normal alone. The camera looks at the point about which the plane is tilted.
    const std::uint32_t texel[3] = {204, 128, 230};
    glm::dvec3 t(coordinate(texel[0]), coordinate(texel[1]), coordinate(texel[2]));
    t /= std::sqrt(t.x * t.x + t.y * t.y + t.z * t.z);
    // u along x, v down in the image: y of the map is against v, here along -z.
    const glm::dvec3 n(t.x, t.z, -t.y);
    const glm::dvec3 flat_normal(0, 1, 0), x(1, 0, 0);
    const double scale = 1 / std::sqrt(1 - n.x * n.x);
    const glm::dvec3 along = scale * (x - n.x * n);
    Scene mapped = with_quad(lit_room(), quad({0, 0, 0}, flat_normal, x, 1));
    mapped.textures = {constant_map(texel[0], texel[1], texel[2])};
    mapped.materials[1].normal_texture = 0;
    const Scene tilted = with_quad(lit_room(), quad({0, 0, 0}, n, along, 2));
    for (const probes::VolumeForm form : {probes::VolumeForm::linear, probes::VolumeForm::cube}) {
        frame::Settings settings = settings_for(mapped);
        settings.probe_run.volume = form;
        frame::add_bake(mapped, settings);
        const frame::Frame f = frame_of(mapped, settings), plane = frame_of(tilted);
        REQUIRE(f.gbuffer.id(middle.x, middle.y).x == 1);
        REQUIRE(plane.gbuffer.id(middle.x, middle.y).x == 1);
        // The planes shadow the room differently: the tilted one is asked of the grid of the mapped one.
        probes::VolumeInputs in;
        in.grid = settings.bake->spatial.grid, in.form = form, in.irradiance = &f.probes.grid;
        const Image4 no_lightmap(35, 35, glm::vec4(-1));
        in.position = &plane.gbuffer.position, in.normal = &plane.gbuffer.normal, in.lightmap_uv = &no_lightmap;
        probes::VolumeLight wanted;
        probes::run(in, {}, wanted);
        const glm::vec4 e = f.indirect(middle.x, middle.y), of_plane = wanted.irradiance(middle.x, middle.y);
        Image4 up(35, 35, glm::vec4(glm::vec3(flat_normal), 1));
        in.normal = &up;
        probes::run(in, {}, wanted);
        for (int c = 0; c < 3; ++c) {
            CHECK(e[c] == Approx(of_plane[c]).epsilon(1e-4));  // the place is the same to 3e-5 m
            CHECK(std::fabs(e[c] - wanted.irradiance(middle.x, middle.y)[c]) > 0.005f * e[c]);
        }
        // So are its light vector and what arrives along it, and its direct light.
        CHECK(glm::length(glm::vec3(f.gbuffer.normal(middle.x, middle.y) - plane.gbuffer.normal(middle.x, middle.y))) < 1e-5f);
        CHECK(f.direct(middle.x, middle.y).x == Approx(plane.direct(middle.x, middle.y).x).epsilon(1e-4));
    }
}

TEST_CASE("relief: a flat normal map changes no bit, a bent one what static surfaces get", "[probes][relief][frame][IPR 5.2.1.6][analytic]") {
    // normal_scale 0 leaves x and y 0, and z is 1: t.x T + t.y B + t.z N is N. The ratio is that of a number to itself: 1.
    Scene plain = furnished();
    plain.name = "furnished", plain.lights = lit_room().lights, plain.camera = lit_room().camera, plain.frame_size = {33, 29}, plain.method = "probes";
    plain.meshes[0].tangents.assign(plain.meshes[0].vertices.size(), glm::vec4(1, 0, 0, 1));
    Scene flat = plain;
    flat.textures = {constant_map(230, 60, 255)};
    for (Material& m : flat.materials) m.normal_texture = 0, m.normal_scale = 0;
    const frame::Frame a = frame_of(plain), b = frame_of(flat);
    CHECK(run_of(a, "probes.relief").rule == "no-relief");
    CHECK(run_of(b, "probes.relief").needed);
    const auto same = [](const Image4& one, const Image4& other) { return one.texels == other.texels; };
    CHECK(same(a.indirect, b.indirect));
    CHECK(same(a.radiance, b.radiance));
    CHECK(same(a.direct, b.direct));

    // Bent: each static pixel has E r, r as the stages that it reads say.
    Scene bent = flat;
    for (Material& m : bent.materials) m.normal_scale = 0.5f;
    const frame::Frame f = frame_of(bent);
    const frame::ReliefBuffers& r = f.probes.relief;
    int seen = 0, other = 0;
    for (std::size_t i = 0; i < f.indirect.size(); ++i) {
        if (f.gbuffer.normal.texels[i].w == 0) continue;
        const glm::vec4 with = r.fixed.irradiance.texels[i], without = r.fixed_unmapped.irradiance.texels[i];
        REQUIRE(with.w == 1);
        REQUIRE(without.w == 1);
        const double ratio = std::min(4.0, (double(with.x) + with.y + with.z) / (double(without.x) + without.y + without.z));
        CHECK(f.indirect.texels[i].x == Approx(double(f.probes.looked_up.texels[i].x) * ratio).epsilon(1e-5).margin(1e-7));
        ++seen, other += std::fabs(ratio - 1) > 0.01;
    }
    CHECK(seen > 800);
    CHECK(other > 400);
    // Without maps it is the plain scene again, but for the ratio, which nobody asks.
    frame::Settings off = settings_for(bent);
    off.probe_run.relief = probes::ReliefOf::off;
    const frame::Frame none = frame_of(bent, off);
    CHECK(run_of(none, "probes.relief").rule == "relief-off");
    CHECK(same(none.radiance, a.radiance));
    // Of a bake without spatial receivers nothing is known, and nothing changes but direct light.
    frame::Settings no_air = settings_for(bent);
    no_air.probes.spatial_receivers = 0;
    const frame::Frame blind = frame_of(bent, no_air);
    CHECK(run_of(blind, "probes.relief").rule == "relief-unknown");
    CHECK(apart(blind.probes.looked_up, none.probes.looked_up, [](std::size_t) { return true; }) > 0);  // direct light of hits is bent
    CHECK(same(blind.indirect, blind.probes.joined));
}

TEST_CASE("relief: the highlight of a lamp is the path tracer's", "[probes][relief][frame][IPR 5.2.1.3][analytic]") {
    // A black glossy floor in a black room: k_s (e + 2) / (2 pi) (m . w)^e (n . w) I / d^2 of what the lamp sees.
    Scene scene = lit_room();
    scene.materials[0].reflectance = glm::vec3(0), scene.materials[0].specular = {0.5f, 0.25f, 0.125f}, scene.materials[0].exponent = 12;
    frame::Settings settings = settings_for(scene);
    settings.probes.spatial_receivers = 0;
    const frame::Frame f = frame_of(scene, settings);
    const Light& lamp = scene.lights[0];
    double most = 0, sum = 0;
    for (std::size_t i = 0; i < f.radiance.size(); ++i) {
        const glm::dvec3 x(f.gbuffer.position.texels[i]), n(f.gbuffer.normal.texels[i]);
        const glm::dvec3 to = glm::dvec3(lamp.position) - x, back = scene.camera.position - x;
        const glm::dvec3 w = to / glm::length(to), v = back / glm::length(back);
        const double n_w = glm::dot(n, w), mirrored = std::max(0.0, 2 * glm::dot(n, v) * n_w - glm::dot(v, w));
        double power = 1;
        for (int k = 0; k < 12; ++k) power *= mirrored;
        const double lit = double(f.visibility[i]) * std::max(0.0, n_w) * power * 14 / (2 * host::pi) / glm::dot(to, to);
        for (int c = 0; c < 3; ++c) {
            const double expected = double(scene.materials[0].specular[c]) * double(lamp.intensity[c]) * lit;
            CHECK(f.radiance.texels[i][c] == Approx(expected).epsilon(1e-4).margin(1e-6));
        }
        most = std::max(most, double(f.radiance.texels[i].x)), sum += double(f.radiance.texels[i].x);
    }
    CHECK(most > 0.2);
    // The path tracer, which averages over each pixel.
    frame::Settings traced = settings;
    traced.method = frame::Method::reference, traced.reference.samples = 64, traced.reference.mode = reference::Mode::direct;
    const frame::Frame truth = frame::execute(scene, traced, frame::plan(scene, traced), {});
    double true_sum = 0;
    for (const glm::vec4& t : truth.radiance.texels) true_sum += double(t.x);
    CHECK(sum == Approx(true_sum).epsilon(0.01));
    // Without highlights it is black.
    settings.probe_run.relief = probes::ReliefOf::normals;
    const frame::Frame black = frame_of(scene, settings);
    CHECK(std::all_of(black.radiance.texels.begin(), black.radiance.texels.end(), [](const glm::vec4& t) { return t == glm::vec4(0); }));
}

TEST_CASE("relief: what the layers of figure 5.20 are made of", "[probes][relief][frame][IPR 5.2.1.3][layers]") {
    Scene scene = with_quad(lit_room(), quad({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 1));
    scene.textures = {constant_map(204, 128, 230)};
    scene.materials[1].normal_texture = 0, scene.materials[1].specular = glm::vec3(0.3f), scene.materials[1].exponent = 5;
    frame::Settings settings = settings_for(scene);
    const frame::Frame without = frame_of(scene, settings);
    for (const auto& layer : without.probes.relief.layers) CHECK(layer.radiance.empty());
    settings.probe_run.layers = true;
    const frame::Frame f = frame_of(scene, settings);
    CHECK((f.radiance.texels == without.radiance.texels));  // the picture is the same
    frame::Settings off = settings;
    off.probe_run.relief = probes::ReliefOf::off;
    const frame::Frame plain = frame_of(scene, off);
    const auto& [diffuse, normals, specular] = f.probes.relief.layers;
    int glossy = 0, bent = 0;
    for (std::size_t i = 0; i < f.radiance.size(); ++i) {
        const glm::dvec3 e = glm::dvec3(f.direct.texels[i]) + glm::dvec3(f.indirect.texels[i]);
        // Of the plain normal: what a frame without normal maps gets.
        const glm::dvec3 e0 = glm::dvec3(plain.direct.texels[i]) + glm::dvec3(plain.indirect.texels[i]);
        const glm::dvec3 s(f.probes.relief.made.glossy.texels[i]), rho(f.gbuffer.albedo.texels[i]);
        for (int c = 0; c < 3; ++c) {
            CHECK(diffuse.radiance.texels[i][c] == Approx(e0[c] / host::pi).epsilon(1e-5).margin(1e-7));
            CHECK(normals.radiance.texels[i][c] == Approx(e[c] / host::pi).epsilon(1e-5).margin(1e-7));
            CHECK(specular.radiance.texels[i][c] == Approx(e[c] / host::pi + s[c]).epsilon(1e-5).margin(1e-7));
            CHECK(f.radiance.texels[i][c] == Approx(rho[c] * e[c] / host::pi + s[c]).epsilon(1e-5).margin(1e-7));
        }
        glossy += s.x > 1e-3;
        bent += of_quad(f, i) && std::fabs(e.x - e0.x) > 0.01 * e.x;
        if (!of_quad(f, i)) CHECK(s == glm::dvec3(0));
    }
    CHECK(glossy > 20);
    CHECK(bent > 50);
    // What is explained is what was written.
    const frame::Plan plan = frame::plan(scene, [&] { frame::add_bake(scene, settings); return settings; }());
    const frame::Frame again = frame::execute(scene, settings, plan, {});
    for (const frame::Explanation& e : frame::explain(scene, settings, plan, again, "probes.relief", -1, middle))
        for (const TapValue& v : e.values)
            if (v.name == "glossy") CHECK(float(v.value[0]) == again.probes.relief.made.glossy(middle.x, middle.y).x);
}

TEST_CASE("relief: a static lamp in the air", "[probes][relief][IPR 5.2.1.5][analytic]") {
    // Two places; a wall between the second one and the lamp.
    Mesh wall = quad({2, 1, 0}, {0, 1, 0}, {1, 0, 0}, 0);
    const Scene scene = scene_of(wall);
    const Geometry geometry = flatten(scene);
    const raster::Surfaces surfaces = raster::prepare(scene, geometry);
    const auto query = reference::build_ray_query(geometry, surfaces, Rays::exact);
    probes::Spatial s;
    s.grid.count = {2, 1, 1};
    s.receivers.position = {glm::vec4(0, 0, 0, 0), glm::vec4(2, 0, 0, 0)};
    Light lamp;
    lamp.type = LightType::point, lamp.position = {0, 4, 3}, lamp.intensity = {50, 25, 0};
    const auto weigh = [&](probes::SpatialWeight w, const std::vector<Light>& lamps) { return probes::static_light(s, w, lamps, *query, 1e-4f); };
    const Buffer<glm::vec4> of = weigh(probes::SpatialWeight::corrected, {lamp});
    REQUIRE(of.size() == 12);
    // 50 W/sr at 5 m: 2 W/m2 across the rays; cosines 4/5 to +y and 3/5 to +z.
    CHECK(of[2].x == Approx(2 * 0.8));
    CHECK(of[2].y == Approx(0.8));
    CHECK(of[4].x == Approx(2 * 0.6));
    for (const int d : {0, 1, 3, 5}) CHECK(of[std::size_t(d)] == glm::vec4(0));
    // From (2, 0, 0) the ray passes y = 1 at (1.5, 0.75): beside the wall. With the lamp above it does not.
    CHECK(of[6 + 2].x > 0);
    lamp.position = {2, 4, 0};
    CHECK(weigh(probes::SpatialWeight::corrected, {lamp})[6 + 2] == glm::vec4(0));
    // What stands behind the lamp hides nothing of it: 50 W/sr at half a metre.
    lamp.position = {2, 0.5f, 0};
    CHECK(weigh(probes::SpatialWeight::corrected, {lamp})[6 + 2].x == Approx(200));
    // A spot sends nothing beyond its cone: the second place is 22 degrees off its axis.
    lamp.type = LightType::spot, lamp.position = {0, 4, 3}, lamp.direction = {0, -0.8f, -0.6f}, lamp.cone_inner_deg = 5, lamp.cone_outer_deg = 10;
    CHECK(weigh(probes::SpatialWeight::corrected, {lamp})[2].x == Approx(2 * 0.8));
    CHECK(weigh(probes::SpatialWeight::corrected, {lamp})[6 + 2] == glm::vec4(0));
    // As published: 1 - 2 theta / pi, of 45 degrees a half. Lamps add up.
    lamp.type = LightType::directional, lamp.direction = glm::vec3(std::sqrt(0.5f), -std::sqrt(0.5f), 0), lamp.intensity = {3, 3, 3};
    const Buffer<glm::vec4> twice = weigh(probes::SpatialWeight::published, {lamp, lamp});
    CHECK(twice[2].x == Approx(3));
    CHECK(twice[1].x == Approx(3));
    CHECK(twice[0].x == 0);
    CHECK(weigh(probes::SpatialWeight::corrected, {lamp})[2].x == Approx(3 * std::sqrt(0.5)));
    CHECK(weigh(probes::SpatialWeight::corrected, {})[2] == glm::vec4(0));
}

TEST_CASE("relief: what moves shadows lamps, and static lamps reach it by the grid alone", "[probes][relief][frame][IPR 5.2.1.4][IPR 5.2.1.5]") {
    // The lamp stands above the quad, which hides the floor from it; the camera sees both from the side.
    Scene scene = lit_room();
    scene.lights[0].position = {0, 1.5f, 0};
    scene.camera.position = {0, 0.4, 1.9}, scene.camera.look_at = {0, -1, 0}, scene.camera.fov_y_deg = 80;
    const Scene empty = scene;
    scene = with_quad(scene, quad({0, -0.6, 0}, {0, 1, 0}, {1, 0, 0}, 1));
    const frame::Frame alone = frame_of(empty), moving = frame_of(scene);
    frame::Settings settings = settings_for(scene);
    settings.probe_run.static_lamps = " lamp ";
    const frame::Frame fixed = frame_of(scene, settings);
    const auto of_floor = [&](std::size_t i) { return moving.gbuffer.id.texels[i].x == 0; };
    const auto is_quad = [&](std::size_t i) { return of_quad(moving, i); };
    // A moving lamp: the quad's shadow lies on the floor, and is dark.
    int shadowed = 0, lit = 0;
    for (std::size_t i = 0; i < moving.direct.size(); ++i) {
        shadowed += of_floor(i) && moving.direct.texels[i].x == 0 && alone.direct.texels[i].x > 0.1f;
        lit += is_quad(i) && moving.direct.texels[i].x > 0.1f;
    }
    CHECK(shadowed > 20);
    CHECK(lit > 20);
    // A static one: no shadow, no direct light on the quad, and the light of the grid instead, which is about as much.
    CHECK(apart(fixed.direct, alone.direct, of_floor) == 0);
    double direct = 0, indirect = 0, before = 0, expected = 0;
    for (std::size_t i = 0; i < fixed.direct.size(); ++i) {
        if (!is_quad(i)) continue;
        direct += double(fixed.direct.texels[i].x), indirect += double(fixed.indirect.texels[i].x);
        before += double(moving.indirect.texels[i].x), expected += double(moving.direct.texels[i].x + moving.indirect.texels[i].x);
    }
    CHECK(direct == 0);
    // A lamp beside it that is none of the static ones lights the quad as ever.
    Scene two = scene;
    two.lights.push_back(two.lights[0]);
    two.lights[1].name = "other";
    const frame::Frame other = frame_of(two, settings);
    for (std::size_t i = 0; i < other.direct.size(); ++i)
        if (is_quad(i)) CHECK(other.direct.texels[i].x == moving.direct.texels[i].x);
    CHECK(indirect > 1.5 * before);
    CHECK(indirect == Approx(expected).epsilon(0.5));  // 27 places: lamps between them are blurred
    // What moves does not change a map that it is not in.
    frame::add_bake(scene, settings);
    frame::KeptStages kept;
    const auto next = [&]() -> const frame::Frame& { return frame::execute(scene, settings, frame::plan(scene, settings), {}, kept); };
    next();
    scene.meshes[1].transform[3].x += 0.3;
    const frame::Frame& after = next();
    CHECK(run_of(after, "rsm (lamp)").kept);
    CHECK(run_of(after, "probes.static_light").kept);
    CHECK(run_of(after, "probes.rounds").kept);
    CHECK_FALSE(run_of(after, "gbuffer").kept);
    const bool same = frame_of(scene, settings).radiance.texels == after.radiance.texels;
    CHECK(same);
}

TEST_CASE("relief: the same bits for every instruction set, kept or made anew, pruned or not", "[probes][relief][frame][bits][keys][pruning]") {
    Scene scene = with_quad(furnished(), quad({0.3, 0.2, 0.9}, {0, 1, 0}, {1, 0, 0}, 1, 0.8));
    const Scene room = lit_room();
    scene.lights = room.lights, scene.camera = room.camera, scene.frame_size = {30, 25}, scene.method = "probes", scene.name = "all";
    scene.lights.push_back(room.lights[0]);
    scene.lights[1].name = "fixed", scene.lights[1].position = {-1, 1, 1}, scene.lights[1].intensity = {0, 3, 6};
    scene.meshes[0].tangents.assign(scene.meshes[0].vertices.size(), glm::vec4(1, 0, 0, 1));
    scene.textures = {constant_map(190, 110, 225)};
    for (Material& m : scene.materials) m.normal_texture = 0, m.specular = glm::vec3(0.2f), m.exponent = 9;
    frame::Settings settings = settings_for(scene);
    settings.probe_run.layers = true, settings.probe_run.static_lamps = "fixed";
    frame::add_bake(scene, settings);
    const frame::Frame whole = frame_of(scene, settings);
    CHECK(run_of(whole, "probes.volume (static, plain)").needed);
    const auto same_as_whole = [&](const frame::Frame& f) {
        bool same = f.radiance.texels == whole.radiance.texels;
        for (int k = 0; k < 3; ++k)
            same = same && f.probes.relief.layers[std::size_t(k)].display.texels == whole.probes.relief.layers[std::size_t(k)].display.texels;
        return same;
    };
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            CHECK(same_as_whole(frame_of(scene, settings, options)));
        }
    frame::Settings unpruned = settings;
    unpruned.pruning = false;
    CHECK(same_as_whole(frame_of(scene, unpruned)));
    // Whatever changes, what is kept is what is made anew.
    frame::KeptStages kept;
    const auto check_kept = [&] {
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        const frame::Frame fresh = frame_of(scene, settings);
        CHECK((f.radiance.texels == fresh.radiance.texels));
        for (std::size_t k = 0; k < 3; ++k) CHECK((f.probes.relief.layers[k].radiance.texels == fresh.probes.relief.layers[k].radiance.texels));
    };
    check_kept();
    scene.meshes[1].transform[3].y += 0.4;
    check_kept();
    scene.lights[1].intensity *= 2.0f;
    check_kept();
    scene.materials[1].exponent = 30;
    check_kept();
    settings.probe_run.relief = probes::ReliefOf::specular;
    check_kept();
    settings.probe_run.static_lamps = "";
    check_kept();
    settings.probe_run.layers = false;
    check_kept();
    settings.probe_run.relief = probes::ReliefOf::off;
    check_kept();
    settings.probe_run.relief = probes::ReliefOf::all, settings.probe_run.static_lamps = "lamp, fixed";
    check_kept();
}

TEST_CASE("relief: light vectors of static surfaces know nothing of static lamps, whose light reaches them directly", "[probes][relief][frame][analytic][IPR 5.2.1.5]") {
    // Nothing reflects or emits: but for the lamp there is no light, and the air has that of the lamp for what moves alone.
    Scene scene = with_quad(lit_room(), quad({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 1));
    for (Material& m : scene.materials) m.reflectance = glm::vec3(0);
    scene.meshes[0].tangents.assign(scene.meshes[0].vertices.size(), glm::vec4(1, 0, 0, 1));
    scene.textures = {constant_map(190, 110, 225)};
    scene.materials[0].normal_texture = 0;
    frame::Settings settings = settings_for(scene);
    settings.probe_run.static_lamps = "lamp";
    const frame::Frame f = frame_of(scene, settings);
    int fixed = 0, moving = 0, lit = 0;
    for (std::size_t i = 0; i < f.indirect.size(); ++i) {
        const glm::vec4 e = f.probes.relief.fixed.irradiance.texels[i], l = f.probes.relief.fixed.from_light.texels[i];
        if (of_quad(f, i)) {
            CHECK(f.probes.volume.irradiance.texels[i].x > 0.01f);
            ++moving;
        } else if (e.w == 1) {
            ++fixed, lit += glm::vec3(e) != glm::vec3(0) || glm::vec3(l) != glm::vec3(0);
        }
    }
    CHECK((fixed > 400 && moving > 20));
    CHECK(lit == 0);
}

TEST_CASE("relief: static lamps that are not there are refused", "[probes][relief][frame][refused]") {
    Scene scene = with_quad(lit_room(), quad({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, 1));
    frame::Settings settings = settings_for(scene);
    for (const char* names : {"lamb", "lamp,", ",", "lamp,,lamp"}) {
        settings.probe_run.static_lamps = names;
        if (std::string(names) == "lamp,") {  // nothing follows
            CHECK_NOTHROW(frame::plan(scene, settings));
            continue;
        }
        const char* known = std::string(names) == "lamb" ? "; the nearest known one is \"lamp\"" : "; known: lamp";
        CHECK_THROWS_WITH(frame::plan(scene, settings), Contains("room: [probes] static_lamps: no lamp is called") && Contains(known));
    }
    settings.probe_run.static_lamps = "lamp";
    Scene still = scene;
    still.meshes[1].dynamic = false, still.meshes.pop_back();
    frame::Settings without = settings;
    without.probes.spatial_receivers = 0;
    frame::add_bake(still, without);
    CHECK_NOTHROW(frame::plan(still, without));
    CHECK_THROWS_WITH(frame::plan(scene, without), Contains("no spatial receivers"));
}
