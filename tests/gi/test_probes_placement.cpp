// Where probes stand: voxels, sides of surfaces, what is inside, and how many.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/hash.h"
#include "gi/probes/candidates.h"
#include "gi/probes/placement.h"
#include "tests/gi/probe_scenes.h"

using namespace plumb;
using namespace plumb::probes;
using test::QuadScene;
using test::Traced;

namespace {

constexpr float room_side = 10;

QuadScene room() { return QuadScene().box({0, 0, 0}, glm::vec3(room_side), true); }

float noise(int i, int seed) { return float(pcg(std::uint32_t(i + 7919 * seed)) & 0xffff) / 65536.0f; }

// The part of a triangle within a box, by cutting it side by side.
std::vector<glm::dvec3> within(std::vector<glm::dvec3> polygon, const glm::dvec3& low, const glm::dvec3& high) {
    for (int side = 0; side < 6; ++side) {
        const int c = side / 2;
        const auto depth = [&](const glm::dvec3& p) { return side % 2 ? high[c] - p[c] : p[c] - low[c]; };
        std::vector<glm::dvec3> kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
            if (depth(a) >= 0) kept.push_back(a);
            if ((depth(a) < 0) != (depth(b) < 0)) kept.push_back(a + (b - a) * (depth(a) / (depth(a) - depth(b))));
        }
        polygon = kept;
    }
    return polygon;
}

bool same(const Placement& a, const Placement& b) {
    return a.probes.size() == b.probes.size() && a.candidates.size() == b.candidates.size() &&
           std::memcmp(a.probes.data(), b.probes.data(), a.probes.size() * sizeof(glm::vec4)) == 0 &&
           std::memcmp(a.candidates.data(), b.candidates.data(), a.candidates.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

// Expected: by the formula with rho_p = density^(-1/3): 10^3 x 0.02 = 20; a flat axis counts one cell, 100^2 x 0.02^(2/3)
// = 736.8.
TEST_CASE("probes: the number wanted is that of cubes of edge rho_p over the bounds", "[probes][IPR 3.2.2.1]") {
    PlacementParams p;
    CHECK(wanted_probes(glm::dvec3(10), p) == 20);
    CHECK(wanted_probes({100, 0, 100}, p) == 737);
    CHECK(wanted_probes({100, 3, 100}, p) == 737);  // thinner than rho_p = 3.68 m
    CHECK(wanted_probes(glm::dvec3(0.55), p) == 8);
    p.least = 3;
    CHECK(wanted_probes(glm::dvec3(0.55), p) == 3);
    // Erratum: x y z / rho_p depends on the unit of length; x y z / rho_p^3 does not.
    for (const double unit : {1e-3, 1e3}) {
        PlacementParams scaled;
        scaled.probes_per_m3 = float(0.02 / (unit * unit * unit));
        CHECK(wanted_probes(glm::dvec3(10 * unit), scaled) == 20);
    }
    p.count = 5;
    CHECK(wanted_probes(glm::dvec3(10), p) == 5);
}

TEST_CASE("probes: numbers that mean nothing are refused", "[probes]") {
    PlacementParams p;
    CHECK_THROWS_WITH(wanted_probes(glm::dvec3(1000), p),
                      "probes: probes_per_m3 = 0.02 asks for 2e+07 probes in 1000 x 1000 x 1000 m: expected at most 262144");
    for (int count : {-1, most_wanted + 1}) {
        p = {}, p.count = count;
        CHECK_THROWS_WITH(wanted_probes(glm::dvec3(1), p), Catch::StartsWith("probes: count = "));
    }
    p = {}, p.least = 0;
    CHECK_THROWS_WITH(wanted_probes(glm::dvec3(1), p), Catch::StartsWith("probes: least = 0"));
    p = {}, p.probes_per_m3 = 0;
    CHECK_THROWS_AS(wanted_probes(glm::dvec3(1), p), InputError);

    const Traced traced(room().scene);
    CHECK_THROWS_WITH(place_probes(Geometry{}, *traced.rays, {}, {}), "probes: the scene has no surfaces");
    Geometry broken = traced.geometry;
    broken.vertices[0].position.y = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_AS(place_probes(broken, *traced.rays, {}, {}), InputError);
    Geometry point = traced.geometry;
    for (Vertex& v : point.vertices) v.position = glm::vec3(1);
    CHECK_THROWS_WITH(place_probes(point, *traced.rays, {}, {}), "probes: the scene has no size");
    // A sheet with both faces in one plane has no voxel with a normal, however fine they are.
    const QuadScene sheet = QuadScene().quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}).quad({0, 0, 0}, {9, 0, 0}, {0, 0, 9});
    const Traced two_faces(sheet.scene);
    p = {}, p.both_sides = false;
    CHECK_THROWS_WITH(place_probes(two_faces.geometry, *two_faces.rays, p, {}),
                      Catch::StartsWith("probes: no place beside a surface"));
}

// Expected: a cell holds a triangle where cutting the triangle by the cell leaves something, which is another test than
// that of the axes; random triangles have no ties. Areas add up to the triangle's.
TEST_CASE("probes: voxels hold the triangles that meet them", "[probes][voxels]") {
    for (int seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        const float size = seed % 4 == 0 ? 0.3f : seed % 4 == 1 ? 9.0f : 3.0f;
        Geometry g;
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 at(noise(9 * k, seed), noise(9 * k + 1, seed), noise(9 * k + 2, seed));
            g.vertices.push_back({glm::vec3(4 + noise(0, seed + 50)) + size * at, 0, glm::vec3(0), 0});
        }
        if (seed % 5 == 0) g.vertices[1].position.z = g.vertices[2].position.z = g.vertices[0].position.z;  // flat
        g.triangles = {{0, 1, 2}};
        const Voxels v = voxelise(g, glm::dvec3(0), glm::dvec3(14.2), 1, {});
        const std::vector<glm::dvec3> corners = {g.vertices[0].position, g.vertices[1].position, g.vertices[2].position};
        const double whole = 0.5 * glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        double area = 0;
        int wrong = 0, full = 0;
        glm::ivec3 at;
        for (at.z = 0; at.z < v.size.z; ++at.z)
            for (at.y = 0; at.y < v.size.y; ++at.y)
                for (at.x = 0; at.x < v.size.x; ++at.x) {
                    const glm::dvec3 low = v.low + glm::dvec3(at) * v.cell_m;
                    const bool meets = !within(corners, low, low + v.cell_m).empty();
                    const std::int32_t i = v.surface[v.cell(at)];
                    wrong += (i >= 0) != meets;
                    if (i >= 0) area += v.surfaces[std::size_t(i)].area, ++full;
                }
        CHECK(wrong == 0);
        CHECK(full == int(v.surfaces.size()));
        CHECK(area == Approx(whole).margin(full * 0x1p-19));
        if (!v.surfaces.empty()) CHECK(v.surfaces[0].has_normal());
    }
}

TEST_CASE("probes: what only touches a voxel is in it, triangles without area are in none", "[probes][voxels]") {
    Geometry g;
    for (const glm::vec3 p : {glm::vec3(0.5f, 1, 0.5f), glm::vec3(0.75f, 1, 0.5f), glm::vec3(0.5f, 1, 0.75f)})
        g.vertices.push_back({p, 0, glm::vec3(0), 0});
    g.triangles = {{0, 1, 2}};
    // Bounds of three cells' width lie in four: sides of cells at y = -0.5, 0.5, ... so move them by a half.
    const Voxels v = voxelise(g, glm::dvec3(0.5), glm::dvec3(3.5), 1, {});
    REQUIRE(v.low == glm::dvec3(-1));
    CHECK(v.surfaces.size() == 2);  // above and below y = 1
    CHECK(v.surface[v.cell({1, 1, 1})] == 0);
    CHECK(v.surface[v.cell({1, 2, 1})] == 1);
    g.triangles = {{0, 1, 1}, {0, 0, 0}};
    CHECK(voxelise(g, glm::dvec3(0.5), glm::dvec3(3.5), 1, {}).surfaces.empty());
    CHECK_THROWS_AS(voxelise(g, glm::dvec3(0), glm::dvec3(1000), 1e-3, {}), InputError);
}

// Expected: the mean dot product of n walls of a corner with their mean direction is sqrt(n)/n; of a sheet it is 0.
TEST_CASE("probes: a voxel has a normal where what is in it faces one way", "[probes][figure 3.13]") {
    const auto has_normal = [](const QuadScene& s) {
        const Voxels v = voxelise(flatten(s.scene), glm::dvec3(0), glm::dvec3(0.5), 4, {});
        REQUIRE(v.surfaces.size() == 1);
        return v.surfaces[0].has_normal();
    };
    const glm::vec3 x(0.5f, 0, 0), y(0, 0.5f, 0), z(0, 0, 0.5f), o(0);
    CHECK(has_normal(QuadScene().quad(o, z, x)));
    CHECK(has_normal(QuadScene().quad(o, z, x).quad(o, x, y)));
    CHECK(has_normal(QuadScene().quad(o, z, x).quad(o, x, y).quad(o, y, z)));
    CHECK_FALSE(has_normal(QuadScene().quad(o, z, x).quad(0.01f * y, x, z)));
    CHECK_FALSE(has_normal(QuadScene().box(o, {0.5f, 0.01f, 0.5f}, false)));
    CHECK_FALSE(has_normal(QuadScene().box(o, glm::vec3(0.5f), false)));
}

// Expected: the quad lies in the one layer of cells that covers a flat axis; its candidates are the layer in front of it.
TEST_CASE("probes: a single quad has candidates in front of it alone", "[probes][IPR 3.2.2.1]") {
    const Traced t(QuadScene().quad({0, 0, 0}, {0, 0, room_side}, {room_side, 0, 0}).scene);
    for (const bool both_sides : {true, false}) {
        PlacementParams params;
        params.both_sides = both_sides;
        const Placement p = place_probes(t.geometry, *t.rays, params, {});
        REQUIRE(p.probes.size() == 8);  // 10^2 x 0.02^(2/3) = 7.4
        const double along = std::floor(room_side / p.cell_m + 0.5) + 1;
        CHECK(double(p.candidates.size()) == along * along);
        for (const glm::vec4& c : p.candidates) CHECK(c.y == float(p.cell_m));
        CHECK(p.rho_m == Approx(std::sqrt(100.0 / 8)));
        CHECK(p.inside == 0);
        CHECK(p.behind > 0);
    }
}

// Expected: with n cells between the walls, the outermost of them, n^3 - (n - 2)^3; walls lie a quarter to three quarters
// of a cell from their cell's outer side.
TEST_CASE("probes: a room has candidates along its walls and nowhere else", "[probes][IPR 3.2.2.1]") {
    const Traced t(room().scene);
    for (const int count : {0, 3, 100}) {
        PlacementParams params;
        params.count = count;
        const Placement p = place_probes(t.geometry, *t.rays, params, {});
        CAPTURE(count, p.cell_m);
        REQUIRE(p.probes.size() == std::size_t(count ? count : 20));
        const double n = std::floor(room_side / p.cell_m + 0.5) + 1 - 2;
        CHECK(double(p.candidates.size()) == n * n * n - (n - 2) * (n - 2) * (n - 2));
        CHECK(p.inside == 0);
        for (const glm::vec4& c : p.candidates) {
            double wall = room_side;
            for (int k = 0; k < 3; ++k) wall = std::min({wall, double(c[k]), double(room_side - c[k])});
            CHECK(wall >= 0.75 * p.cell_m - 1e-5);
            CHECK(wall <= 1.25 * p.cell_m + 1e-5);
        }
        // The probes are candidates, in their order.
        REQUIRE(p.candidate.size() == p.probes.size());
        CHECK(std::is_sorted(p.candidate.begin(), p.candidate.end()));
        for (std::size_t i = 0; i < p.probes.size(); ++i)
            CHECK(glm::vec3(p.probes[i]) == glm::vec3(p.candidates[std::size_t(p.candidate[i])]));
    }
}

TEST_CASE("probes: beyond the bounds there are candidates where they are asked for, or where there are no others",
          "[probes]") {
    const auto beyond = [](const Placement& p, glm::vec3 low, glm::vec3 high) {
        return std::count_if(p.candidates.begin(), p.candidates.end(), [&](const glm::vec4& c) {
            return glm::any(glm::lessThan(glm::vec3(c), low)) || glm::any(glm::greaterThan(glm::vec3(c), high));
        });
    };
    // A table on a floor: its sides only, unless asked for.
    const Traced open(QuadScene().quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}).box({3, 0.1f, 3}, {6, 5, 6}, false).scene);
    PlacementParams params;
    const Placement within = place_probes(open.geometry, *open.rays, params, {});
    CHECK(within.beyond > 0);
    const glm::vec3 quarter(float(within.cell_m) / 4);  // how far the centre of a cell that covers the bounds may lie outside
    CHECK(beyond(within, -quarter, glm::vec3(9, 5, 9) + quarter) == 0);
    params.beyond_bounds = true;
    const Placement around = place_probes(open.geometry, *open.rays, params, {});
    CHECK(around.beyond == 0);
    CHECK(beyond(around, {0, 0, 0}, {9, 5.1f, 9}) > 0);
    // A solid alone.
    const Traced solid(QuadScene().box({0, 0, 0}, glm::vec3(room_side), false).scene);
    const Placement p = place_probes(solid.geometry, *solid.rays, {}, {});
    CHECK(p.probes.size() == 20);
    CHECK(beyond(p, glm::vec3(0), glm::vec3(room_side)) == std::ptrdiff_t(p.candidates.size()));
}

TEST_CASE("probes: none is inside a solid, however fine the voxels are", "[probes][IPR 3.2.2.1]") {
    const glm::vec3 low(2.5f, 0.1f, 2.5f), high(7.3f, 6.1f, 7.4f);
    const Traced t(room().box(low, high, false).scene);
    for (const int count : {8, 60, 400}) {
        PlacementParams params;
        params.count = count;
        const Placement p = place_probes(t.geometry, *t.rays, params, {});
        REQUIRE(p.probes.size() == std::size_t(count));
        for (const glm::vec4& c : p.candidates) {
            const glm::vec3 x(c);
            CHECK_FALSE((glm::all(glm::greaterThan(x, low)) && glm::all(glm::lessThan(x, high))));
            CHECK((glm::all(glm::greaterThan(x, glm::vec3(0))) && glm::all(glm::lessThan(x, glm::vec3(room_side)))));
        }
    }
}

// Expected: IPR 5.1.4's share of back faces: 1 inside of a solid and outside of a room, 0 in a room and beside a sheet
// with two faces.
TEST_CASE("probes: 64 rays tell what is inside", "[probes][IPR 5.1.4]") {
    const auto left = [](const QuadScene& s, glm::dvec3 at) {
        const Traced t(s.scene);
        Voxels v;
        v.low = at - 0.5, v.cell_m = 1, v.size = glm::ivec3(1);
        Candidates c;
        c.cells = {glm::ivec3(0)};
        remove_inside(c, v, *t.rays, {});
        CHECK(c.inside == 1 - std::int64_t(c.cells.size()));
        return !c.cells.empty();
    };
    const QuadScene solid = QuadScene().box({0, 0, 0}, glm::vec3(4), false);
    const QuadScene sheet = QuadScene().quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0});
    const QuadScene two_faces = QuadScene(sheet).quad({0, -0.01f, 0}, {9, 0, 0}, {0, 0, 9});
    CHECK_FALSE(left(solid, glm::dvec3(2)));
    CHECK(left(solid, {2, 5, 2}));
    CHECK(left(room(), glm::dvec3(5)));
    CHECK(left(room(), glm::dvec3(0.5)));
    CHECK_FALSE(left(room(), {5, 5, -1}));
    CHECK(left(sheet, {4, 1, 4}));
    CHECK_FALSE(left(sheet, {4, -1, 4}));
    CHECK(left(two_faces, {4, 1, 4}));
    CHECK(left(two_faces, {4, -1, 4}));
    CHECK(left(sheet, {4, 1000, 4}));  // sees nothing
    // Below a leaf with one face, over ground: 60 % is not reached.
    CHECK(left(QuadScene().quad({-99, 0, -99}, {0, 0, 198}, {198, 0, 0}).quad({-1, 3, -1}, {0, 0, 2}, {2, 0, 0}), {0, 2, 0}));
}

// Expected: figure 3.13: as printed nothing stands beside a voxel without normal; else both sides do.
TEST_CASE("probes: a thin sheet has candidates on both sides, or as printed none", "[probes][figure 3.13]") {
    const Traced t(room().box({0.01f, 5.05f, 0.01f}, {9.99f, 5.06f, 9.99f}, false).scene);
    PlacementParams params;
    params.count = 100;
    const Placement both = place_probes(t.geometry, *t.rays, params, {});
    const auto beside = [&](const Placement& p, float side) {
        return std::count_if(p.candidates.begin(), p.candidates.end(), [&](const glm::vec4& c) {
            return side * (c.y - 5.055f) > 0 && side * (c.y - 5.055f) < 1.5f * float(p.cell_m);
        });
    };
    const double n = std::floor(room_side / both.cell_m + 0.5) + 1 - 2;
    CHECK(beside(both, 1) == n * n);
    CHECK(beside(both, -1) == n * n);
    CHECK(both.without_normal == 0);
    params.both_sides = false;
    const Placement printed = place_probes(t.geometry, *t.rays, params, {});
    CHECK(beside(printed, 1) == 0);
    CHECK(beside(printed, -1) == 0);
    CHECK(printed.without_normal > 0);
}

// Expected: the grid is made of the bounds, so that a power of two scales every number and another factor every cell.
TEST_CASE("probes: scenes of any size have the same places", "[probes][scale]") {
    const auto scaled = [](float s) {
        Scene scene = room().box({2.5f, 0.1f, 2.5f}, {7.3f, 6.1f, 7.4f}, false).scene;
        for (Vertex& v : scene.meshes[0].vertices) v.position *= s;
        const Traced t(scene);
        PlacementParams params;
        params.count = 50;
        return place_probes(t.geometry, *t.rays, params, {});
    };
    const Placement one = scaled(1);
    for (const float s : {0x1p-13f, 0x1p20f, 1e-4f, 1e5f}) {
        CAPTURE(s);
        const Placement p = scaled(s);
        REQUIRE(p.candidates.size() == one.candidates.size());
        CHECK(p.candidate == one.candidate);
        for (std::size_t i = 0; i < p.candidates.size(); ++i) {
            CHECK(p.candidates[i].w == one.candidates[i].w);
            for (int c = 0; c < 3; ++c) CHECK(p.candidates[i][c] == Approx(s * one.candidates[i][c]).epsilon(1e-6));
        }
    }
}

TEST_CASE("probes: the same bits for every instruction set and thread count", "[probes][bits]") {
    const Traced t(room().box({2.5f, 0.1f, 2.5f}, {7.3f, 6.1f, 7.4f}, false).scene);
    PlacementParams params;
    params.count = 200;
    RunOptions scalar;
    scalar.isa = Isa::scalar, scalar.threads = 1;
    const Placement first = place_probes(t.geometry, *t.rays, params, scalar);
    CHECK(first.candidates.size() >= 1600);
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            CHECK(same(place_probes(t.geometry, *t.rays, params, options), first));
        }
}
