// Planar charts: what a surface is, how it is cut, and the figure of a chart.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "gi/probes/chart_shape.h"
#include "gi/probes/planar_charts.h"
#include "tests/gi/chart_meshes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

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
