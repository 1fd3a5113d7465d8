// Point lights through the stages that read their six maps.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/hash.h"
#include "core/host_math.h"
#include "gi/direct/direct.h"
#include "gi/frame/frame.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

double uniform(int i, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(i, channel, 0, 11).x); }

void add_triangle(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const unsigned first = unsigned(mesh.vertices.size());
    for (glm::vec3 p : {a, b, c}) mesh.vertices.push_back({p, 0, glm::vec3(0), 0});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.material.push_back(0);
}
void add_quad(Mesh& mesh, glm::vec3 a, glm::vec3 u, glm::vec3 v) {
    add_triangle(mesh, a, a + u, a + u + v);
    add_triangle(mesh, a, a + u + v, a + v);
}

// A closed box, and a lamp in it.
const glm::vec3 low(-1, -2, -3), high(2, 1, 1.5f), lamp(0.3f, -0.6f, 0.2f);
Mesh box() {
    Mesh m;
    const glm::vec3 s = high - low;
    const glm::vec3 x(s.x, 0, 0), y(0, s.y, 0), z(0, 0, s.z);
    add_quad(m, low, x, y), add_quad(m, low, y, z), add_quad(m, low, z, x);
    add_quad(m, high, -x, -y), add_quad(m, high, -y, -z), add_quad(m, high, -z, -x);
    return m;
}

Scene scene_of(Mesh mesh, glm::vec3 position, int size) {
    Scene s;
    s.name = "room";
    s.materials.resize(1);
    s.materials[0].reflectance = glm::vec3(0.5f);
    s.meshes.push_back(std::move(mesh));
    Light light;
    light.name = "lamp";
    light.type = LightType::point;
    light.position = position;
    light.intensity = {3, 2, 1};
    light.rsm_size = size;
    s.lights = {light};
    return s;
}

std::vector<raster::Rsm> maps_of(const Scene& scene) {
    const Geometry g = flatten(scene);
    glm::vec3 from, to;
    bounds(g, from, to);
    const raster::Surfaces surfaces = raster::prepare(scene, g);
    const std::vector<View> views = raster::light_views(scene.lights[0], from, to);
    std::vector<raster::Rsm> maps(views.size());
    for (std::size_t f = 0; f < views.size(); ++f)
        raster::draw_rsm(g, surfaces, scene.lights[0], views[f], raster::Layout::fp32, {}, maps[f]);
    return maps;
}

// One comparison of depths, whatever the default is.
const direct::ShadowParams by_depth{.mode = direct::ShadowMode::hard, .test = direct::ShadowTest::depth};

std::vector<float> visibilities(const Points& points, const std::vector<raster::Rsm>& maps,
                                direct::ShadowParams params = by_depth) {
    std::vector<float> v(points.position.size(), -1.0f);
    direct::run(params, {&points.position, &points.normal, maps}, {}, v.data());
    return v;
}

// n points on the walls of the box, an eighth of them where two faces of the lamp's maps meet, none nearer to an edge
// of the box than `margin`.
Points on_walls(int n, float margin) {
    Points points(n, 1);
    for (int i = 0; i < n; ++i) {
        const int axis = i % 3, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const bool far = i % 2;
        glm::vec3 p, normal(0);
        p[axis] = far ? high[axis] : low[axis];
        normal[axis] = far ? -1.0f : 1.0f;
        for (int c : {u, v}) p[c] = float(low[c] + margin + (high[c] - low[c] - 2 * margin) * uniform(i, c));
        if (i % 8 == 0) {
            // On a seam: as far from the lamp along u as along the wall's axis, where the wall is wide enough.
            const float seam = lamp[u] + std::abs(p[axis] - lamp[axis]) * (i & 16 ? 1.0f : -1.0f);
            if (seam > low[u] + margin && seam < high[u] - margin) p[u] = seam;
        }
        points.position(i, 0) = glm::vec4(p, 0), points.normal(i, 0) = glm::vec4(normal, 1);
    }
    return points;
}

}  // namespace

TEST_CASE("point light: a lamp in a convex box lights every point, across all seams", "[shadow][point]") {
    for (int size : {64, 101, 256}) {
        const std::vector<raster::Rsm> maps = maps_of(scene_of(box(), lamp, size));
        // A texel that looks at the next wall is nearer: an edge of the box has its own staircase. The walls are at most
        // 3.2 m away along an axis.
        const Points points = on_walls(6000, 3.2f * 2 / float(size) * 1.5f);
        const std::vector<float> v = visibilities(points, maps);
        for (std::size_t i = 0; i < v.size(); ++i) {
            const glm::vec4 p = points.position.texels[i];
            CAPTURE(size, i, p.x, p.y, p.z);
            REQUIRE(v[i] == 1);
        }
        // The density near a seam repeats its face's border, and is full too.
        direct::ShadowParams soft = by_depth;
        soft.mode = direct::ShadowMode::density;
        const Points inner = on_walls(2000, 3.2f * 2 / float(size) * 5);
        for (float d : visibilities(inner, maps, soft)) REQUIRE(d == 1);
    }
}

TEST_CASE("point light: a small screen before each face, edge and corner casts its shadow", "[shadow][point]") {
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                // Half way to a point beyond, across the ray to it.
                const glm::vec3 w = normalize3<float>(glm::vec3(x, y, z));
                const glm::vec3 u = normalize3<float>(std::abs(w.x) > 0.8f ? glm::vec3(w.y, -w.x, 0) : glm::vec3(0, w.z, -w.y));
                const glm::vec3 v(w.y * u.z - w.z * u.y, w.z * u.x - w.x * u.z, w.x * u.y - w.y * u.x);
                Mesh mesh = box();
                add_quad(mesh, lamp + 0.4f * w - 0.1f * u - 0.1f * v, 0.2f * u, 0.2f * v);
                const std::vector<raster::Rsm> maps = maps_of(scene_of(mesh, lamp, 65));
                Points points(4, 1);
                const glm::vec3 at[] = {lamp + 0.8f * w, lamp + 0.3f * w, lamp + 0.8f * w + 0.4f * u,
                                        lamp + 0.8f * w + 0.1f * v};
                for (int i = 0; i < 4; ++i)
                    points.position(i, 0) = glm::vec4(at[i], 0), points.normal(i, 0) = glm::vec4(-w, 1);
                CAPTURE(x, y, z);
                CHECK(visibilities(points, maps) == std::vector<float>{0, 1, 1, 0});
            }
}

// An L of two panels, parallel to the faces +x and +z and as far from the lamp, covers the rows from 32 on of both maps.
// The upper edge runs level through the faces' common border, so that the density of a row is the same in every column:
// the share of the kernel's rows c - k/2 .. c - k/2 + k - 1 above row 32. What the kernel finds beyond a face repeats the
// border's texels; it is neither lit nor left out.
TEST_CASE("point light: a penumbra runs through the seam of two faces unbroken", "[shadow][point][VRSM Algorithm 4]") {
    const int size = 64;
    const float near = 0.4f, far = 0.8f;  // depth of the panels, and of the points behind them, m
    Mesh mesh = box();
    add_quad(mesh, lamp + glm::vec3(near, -near, -near), {0, near, 0}, {0, 0, 2 * near});
    add_quad(mesh, lamp + glm::vec3(-near, -near, near), {0, near, 0}, {2 * near, 0, 0});
    const std::vector<raster::Rsm> maps = maps_of(scene_of(mesh, lamp, size));

    // A point behind the centre of each texel of both faces, facing the lamp.
    Points points(size, 2 * size);
    for (int face : {0, 1})
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column) {
                const float up = 1 - float(2 * row + 1) / size, across = 1 - float(2 * column + 1) / size;
                const glm::vec3 ray = face == 0 ? glm::vec3(1, up, across) : glm::vec3(across, up, 1);
                const int y = face * size + row;
                points.position(column, y) = glm::vec4(lamp + far * ray, 0);
                points.normal(column, y) = face == 0 ? glm::vec4(-1, 0, 0, 1) : glm::vec4(0, 0, -1, 1);
            }

    direct::ShadowParams params = by_depth;
    params.mode = direct::ShadowMode::density;
    for (int kernel : {1, 2, 3, 4, 8}) {
        params.kernel = kernel;
        const std::vector<float> v = visibilities(points, maps, params);
        for (int i = 0; i < 2 * size * size; ++i) {
            const int row = i / size % size;
            const int above = std::min(std::max(32 - (row - kernel / 2), 0), kernel);
            CAPTURE(kernel, i / (size * size), row, i % size);
            REQUIRE(v[std::size_t(i)] == float(above) / float(kernel));
        }
    }
}

// Inside a sphere of radius r the geometry of (3.2) is constant: cos cos / d^2 = 1 / (4 r^2) for any two points. All that
// the wall reflects, rho P, is therefore spread evenly: E_1 = rho P / (4 pi r^2), wherever the lamp is.
TEST_CASE("point light: one bounce inside a sphere is rho P / A everywhere, VRSM (3.2)", "[rsm][point][analytic]") {
    const double r = 1.5;
    const int n = 96;
    Mesh sphere;
    auto on = [&](int i, int j) {
        const double theta = host::pi * i / n, phi = host::pi * j / n;
        return glm::vec3(r * host::sin(theta) * host::cos(phi), r * host::cos(theta),
                         r * host::sin(theta) * host::sin(phi));
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * n; ++j) {
            add_triangle(sphere, on(i, j), on(i + 1, j), on(i + 1, j + 1));
            add_triangle(sphere, on(i, j), on(i + 1, j + 1), on(i, j + 1));
        }
    Points points(12, 1);
    for (int i = 0; i < 12; ++i) {
        const glm::vec3 w = normalize3<float>(
            glm::vec3(2 * uniform(i, 0) - 1, 2 * uniform(i, 1) - 1, 2 * uniform(i, 2) - 1));
        points.position(i, 0) = glm::vec4(w * float(r), 0), points.normal(i, 0) = glm::vec4(-w, 1);
    }
    rsm::GatherParams params;
    params.gather = rsm::Gather::all;
    for (const glm::vec3& position : {glm::vec3(0), glm::vec3(0.5f, -0.3f, 0.7f)}) {
        const std::vector<raster::Rsm> maps = maps_of(scene_of(sphere, position, 33));
        Image4 e;
        rsm::run_maps(params, {&points.position, &points.normal}, maps, {}, e);
        for (int i = 0; i < 12; ++i)
            for (int c = 0; c < 3; ++c) {
                const double intensity = 3 - c, area = 4 * host::pi * r * r;
                const double exact = 0.5 * 4 * host::pi * intensity / area;
                CAPTURE(i, c, position.x);
                // 16 / (3 sqrt 3) / (4 pi R^2) = 0.02 % of the power; facets of a degree or two make up the rest.
                CHECK(e(i, 0)[c] == Approx(exact).epsilon(0.005));
            }
    }
}

TEST_CASE("point light: run_maps() is the sum of its faces, in order, whatever gathers", "[rsm][point][bits]") {
    std::vector<raster::Rsm> maps = maps_of(scene_of(box(), lamp, 16));
    maps[2] = {};  // a face that saw nothing
    const Points points = on_walls(50, 0.1f);
    for (auto kind : {rsm::Gather::disc, rsm::Gather::paths, rsm::Gather::all}) {
        rsm::GatherParams params;
        params.gather = kind;
        params.samples = 40;
        const rsm::Pattern pattern = rsm::pattern_of(params, 16, 1);
        Image4 all, sum(50, 1);
        rsm::run_maps(params, {&points.position, &points.normal, nullptr, &pattern, 1}, maps, {}, all);
        for (const raster::Rsm& map : maps) {
            if (map.size == 0) continue;
            const Image4 face = gather(params, points, map, &pattern);
            for (std::size_t i = 0; i < 50; ++i) sum.texels[i] += face.texels[i];
        }
        CHECK(std::memcmp(all.data(), sum.data(), sum.size() * sizeof(glm::vec4)) == 0);
        CHECK(all(7, 0).x > 0);
    }
}

TEST_CASE("point light: behind a face's plane its map sends nothing; clamped, it sends from its border", "[rsm][point]") {
    const std::vector<raster::Rsm> maps = maps_of(scene_of(box(), lamp, 16));
    const Points behind({-0.9f, -0.6f, 0.2f}, {1, 0, 0});
    rsm::GatherParams params{.gather = rsm::Gather::disc};
    params.samples = 100;
    const rsm::Pattern pattern = rsm::disc_pattern(params, 16, 1);
    CHECK(gather(params, behind, maps[0], &pattern)(0, 0).x == 0);
    params.projection = rsm::Projection::clamped;
    CHECK(gather(params, behind, maps[0], &pattern)(0, 0).x > 0);
}

// A sample of weight 0 as far away as an offset can be makes the kernel look at every sample, wherever the map is.
TEST_CASE("point light: leaving out the samples that cannot meet a map moves no bit", "[rsm][point][bits]") {
    const int size = 32, n = 3000;
    const std::vector<raster::Rsm> maps = maps_of(scene_of(box(), lamp, size));
    const Points points = on_walls(n, 0);
    rsm::GatherParams params{.gather = rsm::Gather::disc}, longer = params;
    params.samples = 24, params.rotations = longer.rotations = 4, params.radius = longer.radius = 0.3f;
    longer.samples = 25;
    const rsm::Pattern pattern = rsm::disc_pattern(params, size, 1);
    rsm::Pattern far = pattern;
    far.samples = 25;
    far.offsets.insert(far.offsets.end(), 4, 32767 | 32767 << 16);
    far.weights.push_back(0);
    for (const raster::Rsm& map : maps) {
        const Image4 near = gather(params, points, map, &pattern), all = gather(longer, points, map, &far);
        CHECK(std::memcmp(near.data(), all.data(), n * sizeof(glm::vec4)) == 0);
        int reached = 0;
        for (const glm::vec4& e : near.texels) reached += e.x > 0;
        CHECK((reached > 0 && reached < n));
    }
}

// ---- The whole frame --------------------------------------------------------------------------------------------------

namespace {

// A box with a block in it under a spot, a point light and a sun.
Scene three_lights() {
    Mesh mesh = box();
    add_quad(mesh, {-0.5f, -1.2f, -0.6f}, {0.9f, 0, 0.1f}, {0, 0.2f, 0.9f});
    Scene s = scene_of(mesh, lamp, 31);
    Light spot = s.lights[0];
    spot.name = "key";
    spot.type = LightType::spot;
    spot.position = {0.5f, 0.9f, -0.4f};
    spot.direction = {0, -1, 0};
    Light sun = s.lights[0];
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = normalize3<float>(glm::vec3(0.2f, -1, -0.3f));
    s.lights = {spot, s.lights[0], sun};
    s.camera.position = {1.5, 0.5, 1.2};
    s.camera.look_at = {0, -1, -1};
    s.frame_size = {45, 31};
    return s;
}

frame::Frame render(const Scene& scene, frame::Settings settings, RunOptions options = {}) {
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}

bool equal(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

TEST_CASE("point light: a frame of spot, point and sun has the same bits everywhere, and with --no-pruning",
          "[frame][point][bits]") {
    const Scene scene = three_lights();
    frame::Settings settings;
    settings.rsm.samples = 30, settings.rsm.directions = 6, settings.rsm.steps = 5;
    for (auto mode : {direct::ShadowMode::hard, direct::ShadowMode::density})
        for (auto kind : {rsm::Gather::disc, rsm::Gather::paths, rsm::Gather::all}) {
            settings.shadow.mode = mode;
            settings.rsm.gather = kind;
            RunOptions options;
            options.isa = Isa::scalar, options.threads = 1;
            const frame::Frame truth = render(scene, settings, options);
            for (Isa isa : supported_isas())
                for (int threads : {1, 2, 3}) {
                    options.isa = isa, options.threads = threads;
                    CAPTURE(isa_name(isa), threads);
                    CHECK(equal(render(scene, settings, options).radiance, truth.radiance));
                }
            settings.pruning = false;
            CHECK(equal(render(scene, settings).radiance, truth.radiance));
            settings.pruning = true;
        }
}

TEST_CASE("point light: a lamp outside of the scene leaves out the faces that look away", "[frame][point][pruning]") {
    Scene scene = three_lights();
    scene.lights[1].position = {0, 9, 0};
    frame::Settings settings;
    settings.shadow.mode = direct::ShadowMode::hard;
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 16;
    const frame::Frame f = render(scene, settings);
    REQUIRE(f.rsms.size() == 3);
    REQUIRE(f.rsms[1].size() == 6);
    for (int face = 0; face < 6; ++face) CHECK((f.rsms[1][std::size_t(face)].size > 0) == (face == 3));
    for (float v : f.visibility) CHECK((v == 0 || v == 1));
    const frame::Plan plan = frame::plan(scene, settings);
    int rows = 0;
    for (const frame::PlannedStage& s : plan.stages)
        if (s.label == "rsm (lamp)") {
            CHECK(s.reason == "shadow and gather read it; 6 faces; 5 left out: each sees nothing");
            CHECK(plan.maps.at(1).faces == 1u << 3);
            ++rows;
        }
    CHECK(rows == 1);
}

TEST_CASE("point light: its stages can be explained, and end with what the frame holds", "[frame][point][explain]") {
    Scene scene = three_lights();
    scene.lights = {scene.lights[1]};
    frame::Settings settings;
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 12, settings.indirect.blur = filter::Blur::none;
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    for (glm::ivec2 pixel : {glm::ivec2(3, 4), glm::ivec2(22, 25), glm::ivec2(44, 30)}) {
        const auto shadow = frame::explain(scene, settings, plan, f, "shadow", -1, pixel).at(0).values;
        CHECK(shadow.front().name == "face");
        CHECK(float(shadow.back().value.at(0)) == f.visibility[std::size_t(pixel.y * 45 + pixel.x)]);
        const auto gathered = frame::explain(scene, settings, plan, f, "rsm.disc", -1, pixel).at(0).values;
        for (int c = 0; c < 3; ++c)
            CHECK(float(gathered.back().value.at(std::size_t(c))) == f.indirect(pixel.x, pixel.y)[c]);
    }
    // The six maps lie side by side.
    for (int face = 0; face < 6; ++face) {
        const auto texel = frame::explain(scene, settings, plan, f, "rsm", -1, {31 * face + 7, 20}).at(0).values;
        CHECK(texel.front().value.at(0) == face);
        CHECK(texel.back().name == "stored_flux");
        CHECK(float(texel.back().value.at(0)) == f.rsms[0][std::size_t(face)].flux(7, 20).x);
    }
    CHECK_THROWS_WITH(frame::explain(scene, settings, plan, f, "rsm", -1, {186, 0}),
                      "explain: pixel 186,0 is outside of rsm (lamp), which is 186 x 31");
}
