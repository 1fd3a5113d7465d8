// Elements of radiosity: where they are, which triangles they stand for, and what they see from there.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/radiosity/elements.h"
#include "gi/radiosity/rows.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/ray_query.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;
using namespace plumb::test;

namespace {

Elements vertices_of(const Scene& s, double crease_deg = 30) {
    ElementParams p;
    p.crease_deg = crease_deg;
    return elements_of(s, p);
}

double total_area(const Elements& e) {
    double sum = 0;
    for (double a : e.area) sum += a;
    return sum;
}

// Elements whose position is p.
std::vector<int> at(const Elements& e, const glm::vec3& p) {
    std::vector<int> out;
    for (int i = 0; i < e.count(); ++i)
        if (glm::vec3(e.position[std::size_t(i)]) == p) out.push_back(i);
    return out;
}

// What an element sees: of cosine-distributed rays from its eye, those that meet triangles below `split`, others, and none.
struct Seen {
    double first = 0, second = 0, nothing = 0;
};
Seen look(const Scene& scene, const Elements& e, int i, std::uint32_t split) {
    const raster::Surfaces surfaces = raster::prepare(scene, e.geometry);
    const auto query = reference::build_ray_query(e.geometry, surfaces, Rays::exact);
    const glm::dvec3 n(e.normal[std::size_t(i)]), eye(e.eye[std::size_t(i)]);
    const glm::dvec3 side = std::fabs(n.x) > 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(side, n)), v = glm::cross(n, u);
    const int rays = 20000;
    Seen seen;
    for (int k = 0; k < rays; ++k) {
        const glm::dvec2 x = r2(std::uint64_t(k));
        const double r = std::sqrt(x.x), phi = 2 * host::pi * x.y;
        const glm::dvec3 d = r * host::cos(phi) * u + r * host::sin(phi) * v + std::sqrt(1 - x.x) * n;
        RayPacket<1> ray{};
        const std::int32_t active[1] = {-1};
        for (float* o : {ray.origin_x}) *o = float(eye.x);
        ray.origin_y[0] = float(eye.y), ray.origin_z[0] = float(eye.z);
        ray.direction_x[0] = float(d.x), ray.direction_y[0] = float(d.y), ray.direction_z[0] = float(d.z);
        ray.t_far[0] = std::numeric_limits<float>::infinity();
        query->nearest(active, ray);
        (ray.triangle[0] == no_hit ? seen.nothing : ray.triangle[0] < split ? seen.first : seen.second) += 1.0 / rays;
    }
    return seen;
}

Mesh triangles(const std::vector<glm::vec3>& corners, int material) {
    Mesh m;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        m.vertices.push_back({corners[i], 0, {0, 0, 0}, 0});
        if (i % 3 == 2) m.triangles.push_back(glm::uvec3(i - 2, i - 1, i)), m.material.push_back(material);
    }
    return m;
}

bool same_bits(const Buffer<glm::vec4>& a, const Buffer<glm::vec4>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

constexpr CubeFaces grey_faces{{0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, {0, 0, 0, 0, 0, 1}};

}  // namespace

TEST_CASE("elements: a cube's faces have (n + 1)^2 each, published n^2 6 + 2 in all", "[radiosity][HEM 4.5.4]") {
    for (const bool one : {false, true}) {
        const Scene s = cube(5, grey_faces, 2, one);
        const Elements e = vertices_of(s);
        CHECK(e.count() == 6 * 36);
        CHECK(total_area(e) == Approx(24).epsilon(1e-6));
        CHECK(e.inset == 6 * 20);  // each face's border
        CHECK(e.nearer == 0);
        CHECK(e.without_normal == 0);
        CHECK(e.offset_m == Approx(1e-4 * std::sqrt(12.0)));
        for (int i = 0; i < e.count(); ++i) {
            // Every eye keeps the offset from all six walls.
            for (int c = 0; c < 3; ++c) {
                const double x = e.eye[std::size_t(i)][c];
                CHECK((x > 0.999 * e.offset_m && x < 2 - 0.999 * e.offset_m));
            }
            const glm::dvec3 n(e.normal[std::size_t(i)]);
            CHECK(std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)}) == 1);
        }
        ElementParams published;
        published.split = false;
        CHECK(elements_of(s, published).count() == 6 * 25 + 2);  // Euler: V = 2 + E - F
        CHECK(total_area(elements_of(s, published)) == Approx(24).epsilon(1e-6));
    }
}

TEST_CASE("elements: materials come from the faces", "[radiosity]") {
    const Scene s = cube(3, grey_faces);
    const Elements e = vertices_of(s);
    double reflected = 0, emitted = 0;
    for (int i = 0; i < e.count(); ++i) {
        reflected += e.area[std::size_t(i)] * e.reflectance[std::size_t(i)].x;
        emitted += e.area[std::size_t(i)] * e.exitance[std::size_t(i)].y;
    }
    CHECK(reflected == Approx(2.1).epsilon(1e-6));
    CHECK(emitted == Approx(1).epsilon(1e-6));
    // Three faces' corner, published: one element with the mean of the three.
    ElementParams published;
    published.split = false;
    const Elements p = elements_of(s, published);
    const std::vector<int> corner = at(p, {0, 0, 0});
    REQUIRE(corner.size() == 1);
    for (int c = 0; c < 3; ++c) CHECK(p.normal[std::size_t(corner[0])][c] == Approx(std::sqrt(1 / 3.0)).epsilon(1e-6));
    CHECK(at(e, {0, 0, 0}).size() == 3);
}

TEST_CASE("elements: at a wall's foot the wall fills half of the view", "[radiosity][HEM 5.6][analytic]") {
    // 20,000 points of a low-discrepancy sequence: 2e-3 is four times what they miss by. Walls are 1 m high and 2 m long: seen
    // from d = 2.5e-4 m they leave less than 1e-3 of a half free (Howell B-4).
    for (const bool one : {false, true}) {
        const Scene s = floor_and_wall(1, 4, one);
        const auto floor = std::uint32_t(2 * 8 * 4);
        const auto foot = [&](const Elements& e, bool upwards) {
            for (int i : at(e, {0, 0, 0}))
                if ((e.normal[std::size_t(i)].y > 0.9f) == upwards) return i;
            FAIL("no element");
            return -1;
        };
        const Elements e = vertices_of(s);
        REQUIRE(at(e, {0, 0, 0}).size() == 2);
        const double d = e.offset_m, exact = 2 * reference::to_perpendicular_rectangle(1, 1, d);
        CHECK(exact == Approx(0.5).margin(1e-3));
        const Seen from_floor = look(s, e, foot(e, true), floor), from_wall = look(s, e, foot(e, false), floor);
        CHECK(from_floor.second == Approx(exact).margin(2e-3));
        CHECK(from_floor.first == 0);
        CHECK(from_wall.first == Approx(exact).margin(2e-3));
        CHECK(from_wall.second == 0);

        // HEM 5.6: along the normal alone. The floor's eye is in the wall's plane, and rounding decides what it sees of it:
        // less than half of what is there.
        ElementParams along_normal;
        along_normal.inset = false;
        const Elements a = elements_of(s, along_normal);
        CHECK(look(s, a, foot(a, true), floor).second < 0.25);

        // Published: one element, its normal between the two: (1 - cos 45) / 2 of each, cos 45 of what is open.
        ElementParams published;
        published.split = false;
        const Elements p = elements_of(s, published);
        const std::vector<int> both = at(p, {0, 0, 0});
        REQUIRE(both.size() == 1);
        const Seen seen = look(s, p, both[0], floor);
        CHECK(seen.first == Approx((1 - std::sqrt(0.5)) / 2).margin(2e-3));   // 0.1464
        CHECK(seen.second == Approx((1 - std::sqrt(0.5)) / 2).margin(2e-3));
        CHECK(seen.nothing == Approx(std::sqrt(0.5)).margin(2e-3));           // 0.7071
    }
}

TEST_CASE("elements: in a room's corner three walls are seen, and nothing beyond", "[radiosity][analytic]") {
    const Scene s = cube(4, grey_faces);
    for (const bool one : {false, true}) {
        const Elements e = vertices_of(cube(4, grey_faces, 1, one));
        for (int i : at(e, {0, 0, 0})) CHECK(look(s, e, i, 1u << 30).nothing == 0);
    }
}

TEST_CASE("elements: surfaces are split where they bend by more than the crease's angle", "[radiosity]") {
    // Two quads that meet at 25 degrees, as a roof and as a valley: six positions.
    for (const double up : {1.0, -1.0}) {
        const double x = host::cos(25 * host::pi / 180), y = -up * host::sin(25 * host::pi / 180);
        Scene s;
        const int white = add_material(s, 0.5);
        s.meshes.push_back(grid({-1, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));
        append(s.meshes[0], grid({0, 0, 0}, {0, 0, 1}, {x, y, 0}, 1, 1, white));
        CHECK(vertices_of(s, 30).count() == 6);
        CHECK(vertices_of(s, 24).count() == 8);
        CHECK(vertices_of(s, 25).count() == 6);  // at most
        const Elements e = vertices_of(s, 30);
        const std::vector<int> ridge = at(e, {0, 0, 0});
        REQUIRE(ridge.size() == 1);
        // Half way, as both have the same angle there in all: 90 degrees.
        const glm::vec3 n(e.normal[std::size_t(ridge[0])]);
        CHECK(double(n.x) == Approx(up * host::sin(12.5 * host::pi / 180)).epsilon(1e-5));
        CHECK(double(n.y) == Approx(host::cos(12.5 * host::pi / 180)).epsilon(1e-5));
        // A material of its own splits where nothing bends.
        Scene two = s;
        two.meshes[0].material = {0, 0, 1, 1};
        add_material(two, 0.25);
        CHECK(vertices_of(two, 180).count() == 8);
    }
}

TEST_CASE("elements: a closed round surface has an element a position, nothing moved in", "[radiosity]") {
    const int n = 10;
    const Scene s = concentric_spheres(0.5, 1, n, 0.5, 0.5, 1, 0);
    const Elements e = vertices_of(s);
    CHECK(e.count() == 2 * (4 * n * n + 2));
    CHECK(e.inset == 0);
    CHECK(e.nearer == 0);
    CHECK(total_area(e) == Approx(reference::area(s.meshes[0]) + reference::area(s.meshes[1])).epsilon(1e-6));
    for (int i = 0; i < e.count(); ++i) {
        const glm::dvec3 p(e.position[std::size_t(i)]), n_i(e.normal[std::size_t(i)]);
        const bool inner = e.exitance[std::size_t(i)].x > 0;
        CHECK(glm::dot(glm::normalize(p), n_i) * (inner ? 1 : -1) > 0.998);
    }
}

TEST_CASE("elements: of one triangle, however small or thin, eyes stay over it", "[radiosity]") {
    for (const float size : {1.0f, 1e-5f}) {
        for (const float width : {1.0f, 0.01f}) {
            Scene s;
            const int white = add_material(s, 0.5);
            s.meshes.push_back(grid({-1, -1, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));  // gives the scene its size
            s.meshes.push_back(triangles({{0, 0, 0}, {0, 0, size}, {size * width, 0, 0}}, white));
            const Elements e = vertices_of(s);
            REQUIRE(e.count() == 7);
            for (int i = 4; i < 7; ++i) {
                const glm::vec3 eye(e.eye[std::size_t(i)]);
                INFO(size << " " << width << ": " << eye.x << " " << eye.z);
                CHECK(eye.y == Approx(e.offset_m));
                CHECK((eye.x > 0 && eye.z > 0 && eye.x / (size * width) + eye.z / size < 1));
                CHECK(e.area[std::size_t(i)] == Approx(size * size * width / 6).epsilon(1e-5));
            }
        }
    }
}

TEST_CASE("elements: triangles without area lend from others, or see nothing", "[radiosity][extreme]") {
    Scene s;
    const int white = add_material(s, 0.5), red = add_material(s, 0.25);
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));
    const int before = vertices_of(s).count();
    append(s.meshes[0], triangles({{0, 0, 0}, {0, 0, 0.5f}, {0, 0, 1}, {1, 0, 1}, {1, 0, 1}, {1, 0, 1}}, white));
    const Elements e = vertices_of(s);
    CHECK(e.count() == before + 1);  // (0, 0, 0.5) is no other's corner
    CHECK(e.without_normal == 1);
    CHECK(e.of[2].x == e.of[0].x);
    CHECK(e.of[2].z == e.of[0].y);
    CHECK((e.of[3].x == e.of[3].y && e.of[3].y == e.of[3].z));
    CHECK(total_area(e) == Approx(1).epsilon(1e-6));

    Scene nothing;
    add_material(nothing, 0.5);
    nothing.meshes.push_back(triangles({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, 0));
    for (const Kind kind : {Kind::vertices, Kind::triangles}) {
        ElementParams p;
        p.kind = kind;
        const Elements n = elements_of(nothing, p);
        CHECK(n.without_normal == n.count());
        CHECK(n.count() == (kind == Kind::vertices ? 3 : 1));
        for (int i = 0; i < n.count(); ++i) {
            CHECK(n.normal[std::size_t(i)] == glm::vec4(0));
            CHECK(n.eye[std::size_t(i)] == n.position[std::size_t(i)]);
            CHECK(n.reflectance[std::size_t(i)].x == 0.5f);
        }
    }
    CHECK(red == 1);
}

TEST_CASE("elements: the two sides of a sheet are two surfaces", "[radiosity]") {
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 2, 2, white));
    append(s.meshes[0], grid({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 2, 2, white));
    for (const double crease : {30.0, 180.0}) {
        const Elements e = vertices_of(s, crease);
        CHECK(e.count() == 18);
        for (int i = 0; i < e.count(); ++i) {
            const std::size_t k = std::size_t(i);
            CHECK(std::fabs(e.normal[k].y) == 1);
            CHECK(double(e.eye[k].y) == Approx(e.offset_m * e.normal[k].y));
        }
    }
}

TEST_CASE("elements: a wall on the middle of a floor divides it, if it stands on its edges", "[radiosity]") {
    const auto room = [](bool with_wall) {
        Scene s;
        const int white = add_material(s, 0.5);
        s.meshes.push_back(grid({-1, 0, 0}, {0, 0, 1}, {2, 0, 0}, 2, 2, white));
        if (with_wall) s.meshes.push_back(grid({0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, 2, white));
        return s;
    };
    CHECK(vertices_of(room(false)).count() == 9);
    const Elements e = vertices_of(room(true));
    CHECK(e.count() == 12 + 6);
    int left = 0, right = 0;
    for (int i : at(e, {0, 0, 0.5f}))
        if (e.normal[std::size_t(i)].y == 1) (e.eye[std::size_t(i)].x < 0 ? left : right) += 1;
    CHECK((left == 1 && right == 1));
    // Below the floor it divides nothing.
    Scene below = room(true);
    for (Vertex& v : below.meshes[1].vertices) v.position.y = -v.position.y;
    CHECK(vertices_of(below).count() == 9 + 6);
}

TEST_CASE("elements: the offset is never less than what positions resolve", "[radiosity][extreme]") {
    Scene s = cube(2, grey_faces);
    ElementParams p;
    p.offset = 0;
    CHECK(elements_of(s, p).offset_m == Approx(1 * 0x1p-18));
    s = cube(2, grey_faces, 64);
    for (Mesh& m : s.meshes) m.transform[3] = glm::dvec4(1e6, 0, -3e6, 1);
    const Elements e = elements_of(s, ElementParams{});
    CHECK(e.offset_m == Approx(3e6 * 0x1p-18).epsilon(1e-3));  // 11 m
    for (int i = 0; i < e.count(); ++i) {
        const glm::dvec3 off = glm::dvec3(e.eye[std::size_t(i)]) - glm::dvec3(e.position[std::size_t(i)]);
        CHECK(glm::dot(off, glm::dvec3(e.normal[std::size_t(i)])) == Approx(e.offset_m).epsilon(0.05));
    }
}

TEST_CASE("elements: eyes stay on this side of what is near, and are counted", "[radiosity][extreme]") {
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 2, 2, white));
    const double offset = vertices_of(s).offset_m;
    for (const double gap : {0.5, 1.5, 2.5}) {
        Scene with = s;
        with.meshes.push_back(grid({-1, gap * offset, -1}, {3, 0, 0}, {0, 0, 3}, 1, 1, white));  // its front looks down
        const double size = 1e-4 * std::sqrt(18.0), wanted = gap * offset;
        ElementParams p;
        p.offset = 1e-4 * offset / size;  // the same length of a larger scene
        const Elements e = elements_of(with, p);
        REQUIRE(e.offset_m == Approx(offset).epsilon(1e-4));
        CHECK(e.nearer == (gap < 2 ? 9 : 0));
        for (std::size_t i = 0; i < 9; ++i) {
            CHECK(double(e.eye[i].y) == Approx(gap < 2 ? wanted / 2 : offset).epsilon(1e-3));
            CHECK(e.eye[i].w == e.eye[i].y);
        }
    }
}

TEST_CASE("elements: of triangles, one in the middle of each", "[radiosity]") {
    ElementParams p;
    p.kind = Kind::triangles;
    const Scene s = cube(3, grey_faces);
    const Elements e = elements_of(s, p);
    REQUIRE(e.count() == 108);
    CHECK(total_area(e) == Approx(6).epsilon(1e-6));
    for (std::size_t t = 0; t < e.of.size(); ++t) {
        CHECK(e.of[t] == glm::uvec3(std::uint32_t(t)));
        glm::dvec3 mean(0);
        for (int k = 0; k < 3; ++k) mean += glm::dvec3(e.geometry.vertices[e.geometry.triangles[t][k]].position) / 3.0;
        CHECK(glm::distance(mean, glm::dvec3(e.position[t])) < 1e-7);
        CHECK(glm::distance(mean + glm::dvec3(e.normal[t]) * e.offset_m, glm::dvec3(e.eye[t])) < 2e-7);
        CHECK(e.area[t] == Approx(1 / 18.0).epsilon(1e-6));
        CHECK(e.reflectance[t].x == Approx(0.1 * (1 + double(t / 18))));
    }
}

TEST_CASE("elements: textures are met in the mean, and their sum is what the surface reflects", "[radiosity]") {
    Scene s;
    const int white = add_material(s, 0.8, 10);
    Texture stripes;
    stripes.texels = Image<std::uint32_t>(8, 1, 0xff000000u);
    for (int x = 0; x < 2; ++x) stripes.texels(x, 0) = 0xffffffffu;  // a quarter of it, on the left
    stripes.filter = Filter::nearest;
    s.textures.push_back(stripes);
    s.materials[0].texture = s.materials[0].emission_texture = 0;
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));
    for (const Kind kind : {Kind::vertices, Kind::triangles}) {
        ElementParams p;
        p.kind = kind;
        const Elements e = elements_of(s, p);
        double reflected = 0, emitted = 0;
        for (std::size_t i = 0; i < e.area.size(); ++i)
            reflected += e.area[i] * e.reflectance[i].x, emitted += e.area[i] * e.exitance[i].z;
        CHECK(reflected == Approx(0.2).epsilon(1e-6));
        CHECK(emitted == Approx(2.5).epsilon(1e-6));
        // u = z. Where u is 0 more of it is white than where u is 1: of the interpolant 1 - u, integral over u < 1/4, 7/16.
        if (kind == Kind::vertices) {
            const int left = at(e, {0, 0, 0})[0], right = at(e, {0, 0, 1})[0];
            CHECK(e.reflectance[std::size_t(left)].x > 2 * e.reflectance[std::size_t(right)].x);
        }
    }
    // A mask that leaves the white quarter alone.
    for (std::uint32_t& texel : s.textures[0].texels.texels) texel = texel == 0xffffffffu ? texel : 0;
    s.materials[0].alpha_cutoff = 0.5f;
    for (const Kind kind : {Kind::vertices, Kind::triangles}) {
        ElementParams p;
        p.kind = kind;
        const Elements masked = elements_of(s, p);
        CHECK(total_area(masked) == Approx(0.25).epsilon(1e-6));
        for (std::size_t i = 0; i < masked.area.size(); ++i)
            if (masked.area[i] > 0) CHECK(masked.reflectance[i].x == Approx(0.8));
        if (kind == Kind::vertices) continue;
        // The triangle below the diagonal has a triangle of legs 1/4 of it, the other one the rest.
        CHECK(masked.area[0] == Approx(1 / 32.0).epsilon(1e-6));
        CHECK(masked.area[1] == Approx(7 / 32.0).epsilon(1e-6));
    }
}

TEST_CASE("elements: hemicubes see nothing of what an alpha mask leaves nothing of", "[radiosity][analytic]") {
    // A floor below a sheet: of the texture that both have a mask leaves all, or nothing.
    for (const bool open : {false, true}) {
        Scene s;
        const int floor = add_material(s, 0.5), sheet = add_material(s, 0.5);
        Texture t;
        t.name = "leaf", t.texels = Image<std::uint32_t>(2, 2);
        for (std::uint32_t& texel : t.texels.texels) texel = open ? 0x00ffffffu : 0xffffffffu;
        s.textures.push_back(t);
        s.materials[std::size_t(sheet)].texture = 0, s.materials[std::size_t(sheet)].alpha_cutoff = 0.5f;
        s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, floor));
        s.meshes.push_back(grid({-50, 0.25, -50}, {100, 0, 0}, {0, 0, 100}, 1, 1, sheet));
        const Elements e = elements_of(s, {Kind::triangles});
        const FormFactors f = form_factors(e, {16, Weights::exact}, {});
        CAPTURE(open);
        REQUIRE(e.count() == 4);
        for (std::size_t i = 0; i < 2; ++i) {
            CHECK(f.escaped[i] == Approx(open ? 1 : 0).margin(open ? 1e-6 : 0.01));
            CHECK(e.area[2 + i] == Approx(open ? 0 : 5000));
        }
    }
}

TEST_CASE("elements: the same bits for any number of threads", "[radiosity][bits]") {
    const Scene s = concentric_spheres(0.5, 1, 24, 0.5, 0.5, 1, 0);  // 9,216 triangles: several bands
    RunOptions one, three;
    one.threads = 1, three.threads = 3;
    const Elements a = elements_of(s, {}, one), b = elements_of(s, {}, three);
    CHECK(same_bits(a.position, b.position));
    CHECK(same_bits(a.normal, b.normal));
    CHECK(same_bits(a.eye, b.eye));
    CHECK(same_bits(a.reflectance, b.reflectance));
    CHECK(a.area == b.area);
    CHECK(a.of == b.of);
    CHECK(a.nearer == b.nearer);
}

TEST_CASE("elements: of the file's vertices, with the file's normals", "[radiosity][HEM 5.5]") {
    ElementParams p;
    p.of_file = true, p.inset = false;
    // Quads of a mesh with vertices of their own: no element is shared, whatever the angle.
    Scene quads = cube(3, grey_faces, 1, true);
    CHECK(elements_of(quads, p).count() == 6 * 16);
    append(quads.meshes[0], grid({2, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, 0));
    append(quads.meshes[0], grid({3, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, 0));
    CHECK(elements_of(quads, p).count() == 6 * 16 + 8);
    CHECK(vertices_of(quads).count() == 6 * 16 + 6);
    // Smooth normals that no triangle has.
    Scene s;
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, add_material(s, 0.5)));
    s.meshes[0].vertices[0].normal = {0.6f, 0.8f, 0};
    CHECK(elements_of(s, p).normal[0].x == 0.6f);
    CHECK(elements_of(s, {}).normal[0].x == 0);
}

TEST_CASE("elements: bad input is refused in a line", "[radiosity][bad input]") {
    Scene s = cube(1, grey_faces);
    const auto with = [&](auto change) {
        ElementParams p;
        change(p);
        elements_of(s, p);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (double bad : {-1.0, 181.0, nan})
        CHECK_THROWS_WITH(with([&](ElementParams& p) { p.crease_deg = bad; }), Catch::Contains("crease_deg") && Catch::Contains("0 to 180"));
    for (double bad : {-1e-9, 0.2, nan})
        CHECK_THROWS_WITH(with([&](ElementParams& p) { p.offset = bad; }), Catch::Contains("offset") && Catch::Contains("0 to 0.1"));
    s.meshes[2].vertices[3].position.y = float(nan);
    CHECK_THROWS_WITH(elements_of(s, {}), Catch::Contains("triangle 4: a position is not finite"));
    Scene empty;
    CHECK_THROWS_AS(elements_of(empty, {}), InputError);
}
