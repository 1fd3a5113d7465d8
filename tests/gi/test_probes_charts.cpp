// What the lightmap atlas is built from: overlap of triangles, planar charts, a mesh's own coordinates, packing.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "gi/probes/chart_shape.h"
#include "gi/probes/own_uv.h"
#include "gi/probes/pack.h"
#include "gi/probes/planar_charts.h"
#include "gi/probes/plane_cover.h"
#include "tests/gi/random_scene.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

// Area that two triangles share, by cutting one with the sides of the other (Sutherland and Hodgman 1974): apart from
// overlap(), which looks for a side that separates them.
double shared_area(PlaneTriangle a, const PlaneTriangle& b) {
    if (twice_area(a) < 0) std::swap(a[1], a[2]);
    std::vector<glm::dvec2> piece(b.begin(), b.end());
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 from = a[i], side = a[(i + 1) % 3] - from;
        auto depth = [&](const glm::dvec2& p) { return side.x * (p.y - from.y) - side.y * (p.x - from.x); };
        std::vector<glm::dvec2> cut;
        for (std::size_t k = 0; k < piece.size(); ++k) {
            const glm::dvec2 p = piece[k], q = piece[(k + 1) % piece.size()];
            if (depth(p) >= 0) cut.push_back(p);
            if ((depth(p) >= 0) != (depth(q) >= 0)) cut.push_back(p + (q - p) * (depth(p) / (depth(p) - depth(q))));
        }
        piece = cut;
    }
    double twice = 0;
    for (std::size_t k = 0; k < piece.size(); ++k) {
        const glm::dvec2 p = piece[k], q = piece[(k + 1) % piece.size()];
        twice += p.x * q.y - p.y * q.x;
    }
    return std::fabs(twice) / 2;
}

PlaneTriangle random_triangle(test::Dice& dice, float size) {
    const glm::vec3 at = dice.in_box({0, 0, 0}, {1, 1, 0});
    PlaneTriangle t;
    for (glm::dvec2& p : t) {
        const glm::vec3 q = at + dice.in_box(glm::vec3(-size, -size, 0), glm::vec3(size, size, 0));
        p = {q.x, q.y};
    }
    return t;
}

Geometry geometry_of(const Mesh& mesh) {
    Scene scene;
    scene.meshes.push_back(mesh);
    return flatten(scene);
}
// Keeps the geometry that it reads.
struct Surface {
    Geometry geometry;
    SurfaceMesh mesh;
    explicit Surface(const Mesh& m)
        : geometry(geometry_of(m)), mesh(surface_mesh(geometry, 0, 0, geometry.triangles.size())) {}
};

// A grid of quads over [0, 1]^2 with shared vertices; `at` places it.
template <class At>
Mesh sheet(int columns, int rows, const At& at) {
    Mesh mesh;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float u = float(i) / float(columns), v = float(j) / float(rows);
            mesh.vertices.push_back({at(double(u), double(v)), u, {0, 1, 0}, v});
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const unsigned a = unsigned(j * (columns + 1) + i), b = a + unsigned(columns) + 1;
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({a + 1, b, b + 1});
            mesh.material.insert(mesh.material.end(), 2, 0);
        }
    return mesh;
}

void add_triangle(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const unsigned first = unsigned(mesh.vertices.size());
    for (const glm::vec3& p : {a, b, c}) mesh.vertices.push_back({p, 0, {0, 1, 0}, 0});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.material.push_back(0);
}

void set_uv(Mesh& mesh, std::size_t vertex, float u, float v) {
    mesh.vertices[vertex].u = u, mesh.vertices[vertex].v = v;
}

// No two triangles of a chart share area on its plane, and all face it within the angle.
void check_charts(const SurfaceMesh& mesh, const PlanarCharts& charts, double angle_deg) {
    std::map<int, std::vector<PlaneTriangle>> planes;
    double shared = 0;
    for (std::uint32_t t = 0; t < mesh.count; ++t) {
        REQUIRE((charts.of[t] >= 0) == (mesh.area[t] > 0));
        if (charts.of[t] < 0) continue;
        const glm::dvec3 n = charts.normal[std::size_t(charts.of[t])];
        CHECK(glm::dot(n, mesh.normal[t]) >= host::cos(angle_deg * host::pi / 180) - 1e-12);
        glm::dvec3 x, y;
        plane_axes(n, x, y);
        PlaneTriangle p;
        for (int k = 0; k < 3; ++k)
            p[std::size_t(k)] = {glm::dot(mesh.position(t, k), x), glm::dot(mesh.position(t, k), y)};
        for (const PlaneTriangle& other : planes[charts.of[t]]) shared = std::max(shared, shared_area(p, other));
        planes[charts.of[t]].push_back(p);
    }
    CHECK(shared < 1e-9);
}

}  // namespace

TEST_CASE("overlap: agrees with the area that triangles share", "[probes][overlap]") {
    test::Dice dice(1);
    int overlapping = 0, apart = 0;
    for (int i = 0; i < 20000; ++i) {
        const PlaneTriangle a = random_triangle(dice, 0.3f), b = random_triangle(dice, 0.3f);
        if (std::fabs(twice_area(a)) < 1e-3 || std::fabs(twice_area(b)) < 1e-3) continue;
        const double area = shared_area(a, b);
        if (area > 0 && area < 1e-9) continue;  // a touch, but for rounding
        CHECK(overlap(a, b, 1e-12) == (area > 0));
        CHECK(overlap(b, a, 1e-12) == (area > 0));
        ++(area > 0 ? overlapping : apart);
    }
    CHECK(overlapping > 1000);
    CHECK(apart > 1000);
}

TEST_CASE("overlap: a shared side or corner is none, half a tolerance neither, twice the tolerance is one",
          "[probes][overlap]") {
    const PlaneTriangle a{glm::dvec2(0, 0), {1, 0}, {0, 1}}, beside{glm::dvec2(1, 0), {1, 1}, {0, 1}};
    CHECK_FALSE(overlap(a, beside, 0));
    CHECK_FALSE(overlap(a, {glm::dvec2(0, 0), {-1, 0}, {0, -1}}, 0));
    CHECK(overlap(a, a, 0));
    CHECK(overlap(a, {a[0], a[2], a[1]}, 0));
    const double tolerance = 1e-3;
    for (double deep : {0.5, 2.0}) {
        PlaneTriangle moved = beside;
        for (glm::dvec2& p : moved) p -= deep * tolerance * glm::dvec2(std::sqrt(0.5));
        CHECK(overlap(a, moved, tolerance) == (deep > 1));
    }
    // One inside the other: no sides cross.
    CHECK(overlap(a, {glm::dvec2(0.2, 0.2), {0.3, 0.2}, {0.2, 0.3}}, 0));
}

TEST_CASE("overlap: any_overlap finds one pair among many, and none in a grid", "[probes][overlap]") {
    std::vector<PlaneTriangle> grid;
    const int n = 60;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const glm::dvec2 a(x / 7.0, y / 3.0), b((x + 1) / 7.0, y / 3.0), c((x + 1) / 7.0, (y + 1) / 3.0),
                d(x / 7.0, (y + 1) / 3.0);
            grid.push_back({a, b, c}), grid.push_back({a, c, d});
        }
    CHECK_FALSE(any_overlap(grid, 1e-9));
    test::Dice dice(2);
    for (int i = 0; i < 50; ++i) {
        // A small triangle in the middle of one that is there: too little area to be told by its sum.
        auto more = grid;
        more.erase(more.begin() + dice.below(int(more.size())));
        const PlaneTriangle host = more[std::size_t(dice.below(int(more.size())))];
        const glm::dvec2 middle = (host[0] + host[1] + host[2]) / 3.0;
        more.push_back({middle, middle + glm::dvec2(1e-4, 0), middle + glm::dvec2(0, 1e-4)});
        CHECK(any_overlap(more, 1e-9));
    }
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        test::Dice few(seed);
        std::vector<PlaneTriangle> some;
        for (int i = 0; i < 30; ++i) some.push_back(random_triangle(few, 0.06f));
        bool truth = false;
        for (std::size_t i = 0; i < some.size(); ++i)
            for (std::size_t k = 0; k < i; ++k) truth = truth || overlap(some[i], some[k], 1e-9);
        CHECK(any_overlap(some, 1e-9) == truth);
    }
}

TEST_CASE("overlap: a fan of many needles is decided in no time, and one needle too many is found",
          "[probes][overlap]") {
    // The hub lies where boxes are cut, and where they are not.
    const int n = 20000;
    for (const glm::dvec2& hub : {glm::dvec2(0, 0), glm::dvec2(0.3, 0.17)}) {
        auto rim = [&](double i) {
            return hub + glm::dvec2(host::cos(2 * host::pi * i / n), host::sin(2 * host::pi * i / n));
        };
        std::vector<PlaneTriangle> fan;
        std::vector<glm::dvec2> corners;
        for (int i = 0; i < n; ++i) corners.push_back(rim(i));
        for (int i = 0; i < n; ++i) fan.push_back({hub, corners[std::size_t(i)], corners[std::size_t((i + 1) % n)]});
        CHECK_FALSE(any_overlap(fan, 1e-12));
        // The sum of the areas tells nothing: the rim's square is larger by 4/pi.
        for (const double at : {0.5, n / 2 - 0.4, 0.77 * n}) {
            auto more = fan;
            more.push_back({hub, rim(at), rim(at + 1)});
            CHECK(any_overlap(more, 1e-12));
            more.back() = {hub, rim(at), rim(at + 100)};
            CHECK(any_overlap(more, 1e-12));
            more.back() = {rim(at), rim(at + 1), 0.5 * (hub + rim(at + 3))};
            CHECK(any_overlap(more, 1e-12));
        }
    }
}

TEST_CASE("overlap: in a fan, triangles below the tolerance hide none behind them", "[probes][overlap]") {
    // Needles of the upper half; below it sectors of a tenth of a turn, from and to in tenths, and their length.
    std::vector<PlaneTriangle> needles;
    auto rim = [](double tenths) {
        return glm::dvec2(host::cos(host::pi * tenths / 5), host::sin(host::pi * tenths / 5));
    };
    for (int i = 0; i < 500; ++i) needles.push_back({glm::dvec2(0), rim(i / 100.0), rim((i + 1) / 100.0)});
    auto with = [&](const std::vector<glm::dvec3>& sectors) {
        auto all = needles;
        for (const glm::dvec3& s : sectors) all.push_back({glm::dvec2(0), rim(s.x) * s.z, rim(s.y) * s.z});
        return any_overlap(all, 1e-6);
    };
    CHECK_FALSE(with({{5.5, 6, 1}, {6, 7, 1}, {7, 9, 1}}));
    CHECK(with({{5.1, 5.4, 1},
                {5.5, 8.5, 1},
                {6, 7, 1e-8},
                {7.5, 9, 1}}));  // the last overlaps the one before the one before it
    CHECK(with(
        {{5.5, 9.5, 1e-8}, {6, 8, 1}, {7, 9, 1}}));  // and here the one before it, not the one that reaches farthest
    CHECK_FALSE(with({{5.5, 9.5, 1e-8}, {6, 7, 1}, {7, 9, 1}}));
}

TEST_CASE("overlap: a cover takes what overlaps nothing, whole groups or none", "[probes][overlap]") {
    int taken = 0, refused = 0;
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        test::Dice dice(seed);
        PlaneCover cover({0, 0}, {1, 1}, 40, 1e-9);
        std::vector<PlaneTriangle> inside;
        for (int i = 0; i < 20; ++i) {
            std::vector<PlaneTriangle> group;
            for (int k = 0; k < 1 + dice.below(3); ++k) group.push_back(random_triangle(dice, 0.1f));
            auto all = inside;
            all.insert(all.end(), group.begin(), group.end());
            bool free = true;
            for (std::size_t k = inside.size(); k < all.size(); ++k)
                for (std::size_t j = 0; j < k; ++j) free = free && !overlap(all[k], all[j], 1e-9);
            REQUIRE(cover.add(group) == free);
            ++(free ? taken : refused);
            if (free) inside = all;
        }
    }
    CHECK(taken > 100);
    CHECK(refused > 100);
}

TEST_CASE("charts: a box has 6, with shared vertices or without, seen from inside or outside",
          "[probes][IPR 3.2.1.1]") {
    for (bool room : {false, true}) {
        Mesh mesh;
        test::add_box(mesh, {-1, 2, 3}, {1, 2.5f, 7}, 0, room);
        const Surface s(mesh);
        CHECK(cut_into_charts(s.mesh, 60).normal.size() == 6);
        Mesh shared;
        std::map<std::array<float, 3>, unsigned> known;
        for (const glm::uvec3& t : mesh.triangles) {
            glm::uvec3 corners;
            for (int k = 0; k < 3; ++k) {
                const Vertex& v = mesh.vertices[t[k]];
                const auto at =
                    known.insert({{v.position.x, v.position.y, v.position.z}, unsigned(shared.vertices.size())});
                if (at.second) shared.vertices.push_back(v);
                corners[k] = at.first->second;
            }
            shared.triangles.push_back(corners), shared.material.push_back(0);
        }
        REQUIRE(shared.vertices.size() == 8);
        const Surface t(shared);
        CHECK(cut_into_charts(t.mesh, 60).of == cut_into_charts(s.mesh, 60).of);
    }
}

TEST_CASE("charts: a flat sheet is one, whatever its triangles", "[probes][IPR 3.2.1.1]") {
    const Surface s(sheet(23, 17, [](double u, double v) { return glm::vec3(4 * u * u, 0, -3 * v); }));
    CHECK(cut_into_charts(s.mesh, 1).normal.size() == 1);
}

TEST_CASE("charts: a cylinder is cut into as many as its turn holds the angle", "[probes][IPR 3.2.1.1]") {
    // 48 faces of 7.5 degrees. The first growth reaches 5/6 of 60 degrees = 50 to both sides of the seed's normal: 13
    // faces. Four of 13 do not fit into 48, so a fifth is needed at most.
    const Surface s(sheet(48, 1, [](double u, double v) {
        return glm::vec3(host::cos(2 * host::pi * std::fmod(u, 1.0)), 2 * v,
                         -host::sin(2 * host::pi * std::fmod(u, 1.0)));
    }));
    const PlanarCharts charts = cut_into_charts(s.mesh, 60);
    check_charts(s.mesh, charts, 60);
    CHECK(charts.normal.size() >= 3);  // 360 / (2 60)
    CHECK(charts.normal.size() <= 5);
}

TEST_CASE("charts: a bend is one chart up to where the angle ends", "[probes][IPR 3.2.1.1]") {
    // Faces of 2 degrees; the first is the widest, so the chart begins at one end and has to turn to the middle. Four
    // rounds reach 50 + 25 + 12.5 + 6.25 + 3.1 = 97 of a bend, about a normal near 47. What is left joins up to 60 from
    // there.
    auto charts_of = [](double turn_deg, double angle_deg) {
        const int faces = int(turn_deg / 2) + 1;
        const Surface s(sheet(1, faces, [&](double u, double v) {
            const double face = v * faces, at = (face < 0.5 ? -0.05 : 0) + face;
            const double turn = 2 * at * host::pi / 180;
            return glm::vec3(2 * u, host::cos(turn), host::sin(turn));
        }));
        const PlanarCharts charts = cut_into_charts(s.mesh, angle_deg);
        check_charts(s.mesh, charts, angle_deg);
        return charts.normal.size();
    };
    CHECK(charts_of(90, 60) == 1);
    CHECK(charts_of(104, 60) == 1);
    CHECK(charts_of(112, 60) == 2);
    CHECK(charts_of(90, 40) == 2);
}

TEST_CASE("charts: what would cover a chart does not join it", "[probes][IPR 3.2.1.1]") {
    // 1.1 turns of a ramp: the tenth is small, faces the same way, and lies above the beginning.
    const Surface s(sheet(110, 2, [](double u, double v) {
        const double turn = 1.1 * 2 * host::pi * u, r = 2 - v;
        return glm::vec3(r * host::cos(turn), 0.3 * u, -r * host::sin(turn));
    }));
    const PlanarCharts charts = cut_into_charts(s.mesh, 60);
    check_charts(s.mesh, charts, 60);
    CHECK(charts.normal.size() == 2);
}

TEST_CASE("charts: a ball's face their planes and cover nothing twice", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {1, 2, 3}, 0.7f, 12, 0);
    const Surface s(mesh);
    for (double angle : {20.0, 45.0, 60.0, 80.0}) {
        const PlanarCharts charts = cut_into_charts(s.mesh, angle);
        check_charts(s.mesh, charts, angle);
        // A cap within the angle holds (1 - cos angle) / 2 of the ball; the faces' normals differ from the ball's by
        // less than 360 / 24 degrees.
        const double cap = (1 - host::cos((angle + 15) * host::pi / 180)) / 2;
        CHECK(double(charts.normal.size()) >= 1 / cap);
    }
    CHECK(cut_into_charts(s.mesh, 60).normal.size() <= 12);
}

TEST_CASE("charts: a ramp that winds around itself is split where it would cover itself", "[probes][IPR 3.2.1.1]") {
    // Two and a half turns of a helicoid, radii 1 to 2: steep nowhere, so one chart but for the overlap.
    const Surface s(sheet(100, 3, [](double u, double v) {
        const double turn = 2.5 * 2 * host::pi * u, r = 2 - v;
        return glm::vec3(r * host::cos(turn), 0.3 * u, -r * host::sin(turn));
    }));
    const PlanarCharts charts = cut_into_charts(s.mesh, 60);
    CHECK(charts.split > 0);
    CHECK(charts.normal.size() >= 3);
    CHECK(charts.normal.size() <= 5);
    check_charts(s.mesh, charts, 60);
}

TEST_CASE("charts: duplicates, sheets back to back and edges of many triangles never share a chart",
          "[probes][IPR 3.2.1.1]") {
    Mesh duplicate;
    test::add_quad(duplicate, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
    test::add_quad(duplicate, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
    const Surface twice(duplicate);
    check_charts(twice.mesh, cut_into_charts(twice.mesh, 60), 60);
    CHECK(cut_into_charts(twice.mesh, 60).normal.size() == 2);

    Mesh thin;
    test::add_quad(thin, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
    test::add_quad(thin, {0, 0, 0}, {0, 0, -1}, {1, 0, 0}, 0);
    const Surface both(thin);
    CHECK(cut_into_charts(both.mesh, 60).normal.size() == 2);

    // Sheets that meet in one edge like the pages of a book, a few degrees apart.
    Mesh book;
    for (int i = 0; i < 7; ++i) {
        const double turn = i * 5 * host::pi / 180;
        test::add_quad(book, {0, 0, 0}, {float(host::cos(turn)), float(host::sin(turn)), 0}, {0, 0, -1}, 0);
    }
    const Surface pages(book);
    check_charts(pages.mesh, cut_into_charts(pages.mesh, 60), 60);
    CHECK(cut_into_charts(pages.mesh, 60).normal.size() == 7);
}

TEST_CASE("surface: triangles lower than four roundings of their coordinates have no area", "[probes][degenerate]") {
    Mesh mesh;
    add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {0.5f, 0, -0x1p-21f});  // height 2^-21 at coordinates of 1
    add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {0.5f, 0, -0x1p-23f});
    add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {1, 0, 0});
    add_triangle(mesh, {2, 2, 2}, {2, 2, 2}, {2, 2, 2});
    add_triangle(mesh, {0, 0, 0}, {0x1p-60f, 0, 0}, {0, 0, -0x1p-60f});  // small, but not flat
    const Surface s(mesh);
    CHECK(s.mesh.area[0] == 0x1p-22);
    for (int t = 1; t < 4; ++t) CHECK(s.mesh.area[std::size_t(t)] == 0);
    CHECK(s.mesh.area[4] == 0x1p-121);
    CHECK(cut_into_charts(s.mesh, 60).of == std::vector<std::int32_t>{0, -1, -1, -1, 1});
}

TEST_CASE("surface: zeros of either sign are one place", "[probes][degenerate]") {
    Mesh mesh;
    add_triangle(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1});
    add_triangle(mesh, {1, -0.0f, -0.0f}, {1, 0, -1}, {-0.0f, 0, -1});
    const Surface s(mesh);
    CHECK(s.mesh.edge_begin.size() == 5 + 1);
    CHECK(cut_into_charts(s.mesh, 60).normal.size() == 1);
}

TEST_CASE("shape: the inner circle lies inside, and is about the largest", "[probes][analytic]") {
    auto shape_of = [](const Surface& s) {
        std::vector<std::uint32_t> all;
        for (std::uint32_t t = 0; t < s.mesh.count; ++t) all.push_back(t);
        return planar_shape(s.mesh, {0, 1, 0}, all);
    };
    // A sheet of 1 m x 2 m in 800 triangles: a circle of 1/2; its grid has cells of 1/32 across.
    const ChartShape sheet_shape =
        shape_of(Surface(sheet(20, 20, [](double u, double v) { return glm::vec3(2 * u, 0, v); })));
    CHECK(sheet_shape.inner_radius <= 0.5);
    CHECK(sheet_shape.inner_radius >= 0.5 - 1.5 / 32);
    for (int c = 0; c < 2; ++c) {
        CHECK(sheet_shape.inner_centre[c] >= sheet_shape.low[c] + sheet_shape.inner_radius);
        CHECK(sheet_shape.inner_centre[c] <= sheet_shape.high[c] - sheet_shape.inner_radius);
    }
    // A ring of radii 1 and 2: a circle of 1/2 about a point 1.5 from the middle.
    const ChartShape ring = shape_of(Surface(sheet(200, 4, [](double u, double v) {
        const double turn = 2 * host::pi * std::fmod(u, 1.0), r = 2 - v;
        return glm::vec3(r * host::cos(turn), 0, -r * host::sin(turn));
    })));
    CHECK(ring.inner_radius <= 0.5);
    CHECK(ring.inner_radius >= 0.3);
    const double from_middle = glm::length(ring.inner_centre - 0.5 * (ring.low + ring.high));
    CHECK(from_middle - ring.inner_radius >= 1 - 1e-3);
    CHECK(from_middle + ring.inner_radius <= 2);
    // Two triangles of 3 x 4 m: the inner circle of one, radius 1.
    const ChartShape two =
        shape_of(Surface(sheet(1, 1, [](double u, double v) { return glm::vec3(4 * u, 0, 3 * v); })));
    CHECK(two.inner_radius == Approx(1).epsilon(1e-6));
}

TEST_CASE("own coordinates: kept where they do not overlap, scaled by the mean edge ratio", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_quad(mesh, {0, 0, 0}, {2, 0, 0}, {0, 0, -1}, 0);  // 2 m x 1 m
    const float uv[4][2] = {{0.25f, 0.75f}, {0.75f, 0.75f}, {0.75f, 0.25f}, {0.25f, 0.25f}};
    for (std::size_t k = 0; k < 4; ++k) set_uv(mesh, k, uv[k][0], uv[k][1]);
    const UvIslands islands = judge_own_uv(Surface(mesh).mesh);
    REQUIRE(islands.verdict == OwnUv::kept);
    // Two edges of 2 m, two of 1 m and a diagonal of sqrt 5, all over edges of 1/2 and a diagonal of sqrt(1/2).
    CHECK(islands.metres == Approx((2 * 4 + 2 * 2 + std::sqrt(10.0)) / 5).epsilon(1e-12));
    CHECK(islands.count == 1);
    CHECK(islands.mirrored == 0);
    for (std::size_t k = 0; k < 4; ++k) set_uv(mesh, k, -uv[k][0], uv[k][1]);
    CHECK(judge_own_uv(Surface(mesh).mesh).mirrored == 1);
}

TEST_CASE("own coordinates: a ball's map of longitude and latitude is kept", "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_ball(mesh, {0, 0, 0}, 1, 16, 0);
    const UvIslands islands = judge_own_uv(Surface(mesh).mesh);
    CHECK(islands.verdict == OwnUv::kept);
    CHECK(islands.count == 1);
    // A radian of latitude is 1/pi of the map; of longitude, 1/(2 pi) at most: the mean of edges lies between.
    CHECK(islands.metres > host::pi / 2);
    CHECK(islands.metres < 2 * host::pi);
}

TEST_CASE("own coordinates: refused where absent, degenerate, not finite, stretched or overlapping",
          "[probes][IPR 3.2.1.1]") {
    Mesh mesh;
    test::add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0);
    test::add_quad(mesh, {1, 0, 0}, {2, 0, 0}, {1, 0, -1}, 0);
    auto verdict = [](const Mesh& m) { return judge_own_uv(Surface(m).mesh).verdict; };
    CHECK(verdict(mesh) == OwnUv::overlapping);  // both have the whole square

    Mesh mirrored = mesh;  // the second is the first one's mirror image, about the edge between them
    for (std::size_t k = 4; k < 8; ++k) mirrored.vertices[k].u = 1 - mirrored.vertices[k].u;
    CHECK(verdict(mirrored) == OwnUv::overlapping);

    Mesh beside = mesh;
    for (std::size_t k = 4; k < 8; ++k) beside.vertices[k].u += 1;
    CHECK(verdict(beside) == OwnUv::kept);
    for (std::size_t k = 4; k < 8; ++k) beside.vertices[k].u -= 0x1p-24f;  // a rounding of the largest coordinate
    CHECK(verdict(beside) == OwnUv::kept);
    for (std::size_t k = 4; k < 8; ++k) beside.vertices[k].u -= 0x1p-16f;
    CHECK(verdict(beside) == OwnUv::overlapping);

    Mesh none = mesh;
    for (Vertex& v : none.vertices) v.u = v.v = 0;
    CHECK(verdict(none) == OwnUv::degenerate);
    Mesh line = mesh;
    for (Vertex& v : line.vertices) v.v = v.u;
    CHECK(verdict(line) == OwnUv::degenerate);
    for (float bad : {std::nanf(""), HUGE_VALF}) {
        Mesh broken = beside;
        broken.vertices[2].v = bad;
        CHECK(verdict(broken) == OwnUv::degenerate);
    }
    // A square, and small ones beside it, each with metres and coordinates of its own.
    auto two_squares = [](float large, float large_uv, float small, float small_uv, int smalls) {
        Mesh m;
        test::add_quad(m, {0, 0, 0}, {large, 0, 0}, {0, 0, -large}, 0);
        for (int i = 0; i < smalls; ++i) {
            const glm::vec3 at(float(i), 5, 0);
            test::add_quad(m, at, at + glm::vec3(small, 0, 0), at - glm::vec3(0, 0, small), 0);
        }
        for (std::size_t k = 0; k < m.vertices.size(); ++k) {
            Vertex& v = m.vertices[k];
            const float size = k < 4 ? large_uv : small_uv;
            v.u = v.u * size + (k < 4 ? 0 : large_uv + float(k / 4) * 2 * small_uv), v.v *= size;
        }
        return m;
    };
    // 1 and 10 in a mesh of ten small ones: the mean is 9.2, so the large one takes 9.2^2 = 84 times its area.
    CHECK(verdict(two_squares(10, 10, 0.1f, 0.01f, 10)) == OwnUv::stretched);
    // 10 and 1 with ten small ones: the mean is 1.8, and a texel of the large one covers 10.
    CHECK(verdict(two_squares(0.1f, 0.01f, 0.1f, 0.1f, 10)) == OwnUv::stretched);
    CHECK(verdict(two_squares(0.1f, 0.1f, 0.1f, 0.1f, 10)) == OwnUv::kept);
}

TEST_CASE("packing: the rules of figures 3.7 and 3.8", "[probes][IPR 3.2.1.1]") {
    auto squares = [](int n, int side) {
        return std::vector<RectangleToPack>(std::size_t(n), RectangleToPack{{side, side}, {}});
    };
    const int gap = 3, s = 10, step = s + gap;
    CHECK(pack_rectangles(squares(1, s), gap, 0, 1000).side == s);
    // The second goes to the bottom right corner, the third and fourth to the free space, the fifth to the corner
    // again.
    const Packing five = pack_rectangles(squares(5, s), gap, 0, 1000);
    REQUIRE(five.placed.size() == 5);
    CHECK(five.side == 3 * s + 2 * gap);
    CHECK(five.placed[0].origin == glm::ivec2(0));
    CHECK(five.placed[1].origin == glm::ivec2(step));
    std::set<std::pair<int, int>> others;
    for (int i : {2, 3}) others.insert({five.placed[std::size_t(i)].origin.x, five.placed[std::size_t(i)].origin.y});
    CHECK(others == std::set<std::pair<int, int>>{{0, step}, {step, 0}});
    CHECK(five.placed[4].origin == glm::ivec2(2 * step));
    CHECK(pack_rectangles(squares(9, s), gap, 0, 1000).side == 3 * s + 2 * gap);

    CHECK(pack_rectangles(squares(9, s), gap, 3 * s + 2 * gap, 1000).placed.size() == 9);
    CHECK(pack_rectangles(squares(9, s), gap, 3 * s + 2 * gap - 1, 1000).placed.empty());
    CHECK(pack_rectangles(squares(5, s), gap, 0, 3 * s + 2 * gap - 1).placed.empty());
    // The canvas grows to where it stays nearest to a square.
    CHECK(pack_rectangles({{{40, 2}, {}}, {{40, 2}, {}}}, 1, 0, 1000).side == 43);
    // A long one is turned to stay inside.
    CHECK(pack_rectangles({{{50, 1}, {}}, {{1, 50}, {}}, {{47, 50}, {}}}, 1, 51, 51).placed.size() == 3);
}

TEST_CASE("packing: nothing is nearer than the gap, and little is left", "[probes][IPR 3.2.1.1]") {
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        test::Dice dice(seed);
        const int gap = dice.below(5), n = 1 + dice.below(300), largest = 1 + dice.below(40);
        std::vector<RectangleToPack> rectangles;
        double area = 0;
        for (int i = 0; i < n; ++i) {
            const int w = 1 + dice.below(largest), h = 1 + dice.below(largest);
            rectangles.push_back({{w, h}, {}});
            if (w > 12 && h > 12) rectangles.back().holes = {{{2, 3}, {w - 7, h - 8}}};
            area += double(w + gap) * (h + gap);
        }
        const Packing rules = pack_rectangles(rectangles, gap, 0, 16384), packing = pack_closer(rectangles, gap, rules);
        REQUIRE(packing.placed.size() == rectangles.size());
        CHECK(packing.side <= rules.side);
        // Texels that a rectangle takes: all but its hole.
        Image<int> taken(packing.side, packing.side, -1);
        int outside = 0, twice = 0, near = 0;
        for (int i = 0; i < n; ++i) {
            const RectangleToPack& r = rectangles[std::size_t(i)];
            const PackedRectangle& p = packing.placed[std::size_t(i)];
            for (int y = 0; y < r.size.y; ++y)
                for (int x = 0; x < r.size.x; ++x) {
                    bool hole = false;
                    for (const TexelHole& h :
                         r.holes)  // widened by the gap: where others are at least that far from this
                        hole = hole || (x >= h.origin.x - gap && x < h.origin.x + h.size.x + gap &&
                                        y >= h.origin.y - gap && y < h.origin.y + h.size.y + gap);
                    if (hole) continue;
                    const glm::ivec2 at = p.origin + (p.turned ? glm::ivec2(r.size.y - 1 - y, x) : glm::ivec2(x, y));
                    const bool inside = at.x >= 0 && at.y >= 0 && at.x < packing.side && at.y < packing.side;
                    outside += !inside;
                    if (!inside) continue;
                    twice += taken(at.x, at.y) >= 0;
                    taken(at.x, at.y) = i;
                }
        }
        for (int y = 0; y < packing.side; ++y)
            for (int x = 0; x < packing.side; ++x)
                for (int dy = 0; dy <= gap && y + dy < packing.side && taken(x, y) >= 0; ++dy)
                    for (int dx = -gap; dx <= gap; ++dx) {
                        if (x + dx < 0 || x + dx >= packing.side || taken(x + dx, y + dy) < 0) continue;
                        near += taken(x + dx, y + dy) != taken(x, y);
                    }
        CHECK(outside == 0);
        CHECK(twice == 0);
        CHECK(near == 0);
        if (n >= 100) CHECK(area / double(packing.side + gap) / (packing.side + gap) > 0.85);
    }
}
