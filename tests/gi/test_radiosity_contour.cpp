// Form factors of polygons by contour integrals: against closed forms and against quadratures of their own.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/radiosity/contour.h"
#include "gi/radiosity/edge_integral.h"
#include "gi/reference/form_factors.h"

using namespace plumb;
using namespace plumb::radiosity;
using host::pi;

namespace {

// From `corner` along two sides.
Polygon rectangle(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
    return {corner, corner + u, corner + u + v, corner + v};
}
const Polygon floor_square = rectangle({0, 0, 0}, {0, 0, 1}, {1, 0, 0});    // looks up, +y
const Polygon ceiling_square = rectangle({0, 1, 0}, {1, 0, 0}, {0, 0, 1});  // looks down
const Polygon wall_square = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});     // x = 0, looks along +x

// Numbers in [-1, 1), for shapes.
struct Random {
    std::uint32_t state;
    double operator()() {
        state = state * 747796405u + 2891336453u;
        const std::uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
        return double((word >> 22) ^ word) / 2147483648.0 - 1;
    }
    glm::dvec3 vector() { return {(*this)(), (*this)(), (*this)()}; }
};

Polygon moved(const Polygon& p, const glm::dvec3& by) {
    Polygon q;
    for (const glm::dvec3& c : p) q.push_back(c + by);
    return q;
}
Polygon scaled(const Polygon& p, double by) {
    Polygon q;
    for (const glm::dvec3& c : p) q.push_back(c * by);
    return q;
}
Polygon turned(const Polygon& p) { return Polygon(p.rbegin(), p.rend()); }

// Without any contour: the mean of cos cos / (pi r^2) over n x n points of each triangle-free parallelogram.
double area_quadrature(const Polygon& a, const Polygon& b, int n) {
    const glm::dvec3 na = area_vector(a), nb = area_vector(b);
    double sum = 0;
    for (int i = 0; i < n * n * n * n; ++i) {
        const double s = (i % n + 0.5) / n, t = (i / n % n + 0.5) / n, u = (i / n / n % n + 0.5) / n,
                     v = (i / n / n / n + 0.5) / n;
        const glm::dvec3 x = a[0] + (a[1] - a[0]) * s + (a[3] - a[0]) * t,
                         y = b[0] + (b[1] - b[0]) * u + (b[3] - b[0]) * v;
        const glm::dvec3 r = y - x;
        const double r2 = glm::dot(r, r);
        sum += std::fmax(glm::dot(na, r), 0) * std::fabs(glm::dot(nb, r)) / (pi * r2 * r2);
    }
    return sum / (double(n) * n * n * n) / area(a);
}

}  // namespace

TEST_CASE("contour: unit squares, opposed and at right angles", "[radiosity][analytic]") {
    // verification.md 3: Howell's C-11 and C-14.
    const ContourFactor opposed = polygon_form_factor(floor_square, ceiling_square);
    CHECK(opposed.value == Approx(0.199824895698387).margin(1e-15).epsilon(0));
    CHECK(opposed.error < 1e-14);
    const ContourFactor right = polygon_form_factor(floor_square, wall_square);
    CHECK(right.value == Approx(0.200043776075403).margin(1e-15).epsilon(0));
    CHECK(right.error < 1e-14);
    // The six faces of a cube: from one of them to all others.
    CHECK(opposed.value + 4 * right.value == Approx(1).margin(1e-14).epsilon(0));
}

TEST_CASE("contour: rectangles of any sides against C-11 and C-14", "[radiosity][analytic]") {
    for (const double a : {0.01, 0.5, 1.0, 3.0, 100.0})
        for (const double b : {0.2, 1.0, 7.0})
            for (const double c : {0.05, 1.0, 40.0}) {
                CAPTURE(a, b, c);
                const Polygon low = rectangle({0, 0, 0}, {0, 0, b}, {a, 0, 0}),
                              high = rectangle({0, c, 0}, {a, 0, 0}, {0, 0, b});
                const ContourFactor opposed = polygon_form_factor(low, high);
                const double known = reference::opposed_rectangles(a, b, c);
                CHECK(std::fabs(opposed.value - known) <= opposed.error + 1e-12 * (1 + c * c / (a * b)));
                // Width c along the shared edge.
                const Polygon wide = rectangle({0, 0, 0}, {0, 0, c}, {a, 0, 0}),
                              wall = rectangle({0, 0, 0}, {0, b, 0}, {0, 0, c});
                const ContourFactor right = polygon_form_factor(wide, wall);
                CHECK(std::fabs(right.value - reference::perpendicular_rectangles(c, a, b)) <= right.error + 1e-12);
            }
}

TEST_CASE("contour: from a point, to rectangles and to a polygon for a disc", "[radiosity][analytic]") {
    // verification.md 3.
    const Polygon square = rectangle({-0.5, 1, -0.5}, {1, 0, 0}, {0, 0, 1});
    CHECK(point_form_factor({0, 0, 0}, {0, 3, 0}, square) == Approx(0.239456470460774).margin(1e-15).epsilon(0));
    CHECK(point_form_factor({0.5, 0, 0.5}, {0, 1, 0}, wall_square) ==
          Approx(0.190135882384807).margin(1e-15).epsilon(0));
    CHECK(point_form_factor({0.02, 0, 0.5}, {0, 1, 0}, wall_square) ==
          Approx(0.484323815518066).margin(1e-15).epsilon(0));
    // The wall's lower part lies below the horizon.
    const Polygon sunk = rectangle({0, -2, 0}, {0, 3, 0}, {0, 0, 1});
    CHECK(point_form_factor({0.5, 0, 0.5}, {0, 1, 0}, sunk) == Approx(0.190135882384807).margin(1e-15).epsilon(0));
    // A regular polygon of n corners with the disc's area differs from the disc by O(1 / n^4) from its middle.
    for (const double d : {0.25, 1.0, 4.0}) {
        const int n = 4096;
        Polygon disc;
        const double radius = std::sqrt(2 * pi / n / host::sin(2 * pi / n));
        for (int i = 0; i < n; ++i)
            disc.push_back({radius * host::cos(2 * pi * i / n), d, radius * host::sin(2 * pi * i / n)});
        CHECK(point_form_factor({0, 0, 0}, {0, 1, 0}, disc) == Approx(reference::patch_to_disc(1, d)).epsilon(1e-9));
        for (const double angle : {0.3, 1.0, 1.5, 1.9, 2.3})
            CHECK(point_form_factor({0, 0, 0}, {host::sin(angle), host::cos(angle), 0}, disc) ==
                  Approx(reference::tilted_patch_to_disc(1, d, angle)).epsilon(1e-6).margin(1e-8));
    }
}

TEST_CASE("contour: a point sees nothing of its own plane, of what is below, or of a back where fronts count",
          "[radiosity]") {
    CHECK(point_form_factor({0.5, 0, 0.5}, {0, 1, 0}, floor_square) == 0);
    CHECK(point_form_factor({0.5, 0, 0.5}, {1, 0, 0}, floor_square) == 0);
    CHECK(point_form_factor({3, 0, 0.5}, {-1, 0, 0}, floor_square) == 0);
    CHECK(point_form_factor({0.5, 2, 0.5}, {0, 1, 0}, ceiling_square) == 0);
    CHECK(point_form_factor({0.5, 0.5, 0.5}, {0, 1, 0}, turned(ceiling_square), Sides::front) == 0);
    CHECK(point_form_factor({0.5, 0.5, 0.5}, {0, 1, 0}, ceiling_square, Sides::front) ==
          point_form_factor({0.5, 0.5, 0.5}, {0, 1, 0}, ceiling_square));
}

TEST_CASE("contour: pairs of edges against a quadrature", "[radiosity]") {
    // ln r by the midpoint rule on 2000 x 2000 points: smooth where the edges are apart.
    const struct {
        Edge p, q;
    } pairs[] = {{{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {1, 1.5, 0.3}}},           // skew
                 {{{0, 0, 0}, {1, 0, 0}}, {{0.3, 0.5, 0.2}, {-0.9, 0.5, 0.2}}},  // parallel, the other way round
                 {{{0, 0, 0}, {1, 0, 0}}, {{1.5, 0.25, 0}, {2.5, 0.75, 0}}},     // lines that cross outside of both
                 {{{0, 0, 0}, {1, 0, 0}}, {{1.25, 0, 0}, {2, 0, 0}}}};           // one line
    for (const auto& [p, q] : pairs) {
        const int n = 1000;
        double sum = 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const glm::dvec3 r =
                    p.from + (p.to - p.from) * ((i + 0.5) / n) - q.from - (q.to - q.from) * ((j + 0.5) / n);
                sum += 0.5 * std::log(glm::dot(r, r));
            }
        sum *= glm::dot(p.to - p.from, q.to - q.from) / n / n;
        const EdgeIntegral exact = edge_integral(p, q, 1e-14);
        CHECK(exact.value == Approx(sum).margin(2e-7));
        const EdgeIntegral swapped = edge_integral(q, p, 1e-14);
        CHECK(exact.value == Approx(swapped.value).margin(1e-13));
    }
    // Skew edges that pass each other closely: the integrand bends within the gap, and is halved there until it is
    // smooth.
    for (const double gap : {0.1, 1e-2, 1e-3, 1e-5}) {
        const Edge p{{-1, 0, 0}, {1, 0, 0}}, q{{-0.6, -0.8, gap}, {0.6, 0.8, gap}};
        const EdgeIntegral one = edge_integral(p, q, 1e-14), rough = edge_integral(p, q, 1e-3);
        CHECK(one.error < 1e-12);
        // Without the gap it is closed; the gap adds what is of its own order.
        const double none = edge_integral(p, {{-0.6, -0.8, 0}, {0.6, 0.8, 0}}, 1e-14).value;
        CHECK(std::fabs(one.value - none) < 6 * gap);
        CHECK(std::fabs(one.value - rough.value) <= 2e-3);
    }
    // The same edge twice: L^2 (ln L - 3/2). Two sides of a unit square from one corner: no cosine, nothing. Of an
    // angle of 60 degrees: the limit of skew edges.
    const Edge e{{0, 0, 0}, {2, 0, 0}}, slant{{0, 0, 0}, {0.5, std::sqrt(0.75), 0}};
    CHECK(edge_integral(e, e, 1e-14).value == Approx(4 * (std::log(2.0) - 1.5)).epsilon(1e-14));
    CHECK(edge_integral(e, {{0, 0, 0}, {0, 1, 0}}, 1e-14).value == 0);
    const double limit =
        edge_integral(e, {slant.from + glm::dvec3(0, 0, 1e-9), slant.to + glm::dvec3(0, 0, 1e-9)}, 1e-14).value;
    CHECK(edge_integral(e, slant, 1e-14).value == Approx(limit).margin(1e-8));
}

TEST_CASE("contour: polygons anywhere against a quadrature of points", "[radiosity]") {
    Random random{7};
    int compared = 0;
    for (int k = 0; k < 12; ++k) {
        const Polygon a = rectangle(random.vector(), random.vector(), random.vector());
        const Polygon b = rectangle(random.vector() + glm::dvec3(3, 1, 0), random.vector(), random.vector());
        const ContourFactor f = polygon_form_factor(a, b);
        const double points = area_quadrature(a, b, 16);
        CAPTURE(k, f.value, f.error, points);
        CHECK(f.value == Approx(points).epsilon(0.01).margin(1e-5));
        CHECK(f.error < 1e-11);
        compared += points > 1e-3;
        // Every point's own factor, by Lambert's formula: a contour integral, too, but of one polygon.
        double mean = 0;
        const int n = 64;
        for (int i = 0; i < n * n; ++i)
            mean += point_form_factor(a[0] + (a[1] - a[0]) * ((i % n + 0.5) / n) + (a[3] - a[0]) * ((i / n + 0.5) / n),
                                      area_vector(a), b) /
                    n / n;
        CHECK(f.value == Approx(mean).epsilon(2e-3).margin(1e-7));
    }
    CHECK(compared >= 4);
}

TEST_CASE("contour: reciprocity, additivity, and scale", "[radiosity]") {
    Random random{11};
    for (int k = 0; k < 20; ++k) {
        const Polygon a = rectangle(random.vector(), random.vector(), random.vector());
        Polygon b = rectangle(random.vector() + glm::dvec3(0, 2.5, 0), random.vector(), random.vector());
        // From each side that sees the other: both sides of each count.
        auto both = [](const Polygon& x, const Polygon& y) {
            const ContourFactor front = polygon_form_factor(x, y), back = polygon_form_factor(turned(x), y);
            return ContourFactor{front.value + back.value, front.error + back.error};
        };
        const ContourFactor ab = both(a, b), ba = both(b, a);
        CAPTURE(k, 1e15 * (area(a) * ab.value - area(b) * ba.value), 1e15 * ab.error, 1e15 * ba.error);
        CHECK(std::fabs(area(a) * ab.value - area(b) * ba.value) <= area(a) * ab.error + area(b) * ba.error);
        // To two halves of b.
        const glm::dvec3 m0 = 0.5 * (b[0] + b[1]), m1 = 0.5 * (b[3] + b[2]);
        const double halves =
            polygon_form_factor(a, {b[0], m0, m1, b[3]}).value + polygon_form_factor(a, {m0, b[1], b[2], m1}).value;
        const double whole = polygon_form_factor(a, b).value;
        CHECK(whole == Approx(halves).margin(1e-12));
        for (const double s : {1e-6, 1e6})
            CHECK(polygon_form_factor(scaled(a, s), scaled(b, s)).value == Approx(whole).margin(1e-13));
        CHECK(polygon_form_factor(moved(a, {16, -8, 4}), moved(b, {16, -8, 4})).value == Approx(whole).margin(1e-12));
    }
}

TEST_CASE("contour: polygons that touch, lie in one plane, or cross", "[radiosity][analytic]") {
    // Side by side in one plane, overlapping, or back to back: nothing.
    CHECK(polygon_form_factor(floor_square, moved(floor_square, {1, 0, 0})).value == 0);
    CHECK(polygon_form_factor(floor_square, moved(floor_square, {0.5, 0, 0.2})).value == 0);
    CHECK(polygon_form_factor(floor_square, moved(ceiling_square, {0, -2, 0})).value == 0);
    CHECK(polygon_form_factor(turned(floor_square), ceiling_square).value == 0);
    // One shared corner: floor of 2 x 2 and wall of width 2 make of four such pairs twice the shared edge and twice
    // this.
    const Polygon beside = moved(wall_square, {0, 0, 1});
    const ContourFactor corner = polygon_form_factor(floor_square, beside);
    const double wide = reference::perpendicular_rectangles(2, 1, 1);  // F of the floor 1 x 2 to the wall 1 x 2
    CHECK(corner.value == Approx(wide - 0.200043776075403).margin(1e-14).epsilon(0));
    CHECK(corner.error < 1e-13);
    // A wall that goes through the floor's middle: both its sides are seen, from x < 1/2 and from x > 1/2. What is
    // below the floor is not.
    const Polygon through = rectangle({0.5, -3, 0}, {0, 4, 0}, {0, 0, 1});
    const double half = reference::perpendicular_rectangles(1, 0.5, 1);
    CHECK(polygon_form_factor(floor_square, through).value == Approx(half).margin(1e-14).epsilon(0));
    CHECK(polygon_form_factor(floor_square, through, Sides::front).value ==
          Approx(0.5 * half).margin(1e-14).epsilon(0));
    // Nearly touching: the shared edge is the limit.
    for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12})
        CHECK(polygon_form_factor(floor_square, moved(wall_square, {-gap, 0, 0})).value ==
              Approx(0.200043776075403).margin(30 * gap + 1e-12));
    // Two triangles with a common edge at 60 degrees, against the mean of Lambert's formula over many points.
    const Polygon flat{{0, 0, 0}, {0, 0, 1}, {1, 0, 0.5}}, steep{{0, 0, 0}, {0.5, std::sqrt(0.75), 0.5}, {0, 0, 1}};
    double mean = 0;
    const int n = 400;
    for (int i = 0; i < n * n; ++i) {
        const double x = std::sqrt((i % n + 0.5) / n), y = (i / n + 0.5) / n;
        mean += point_form_factor(flat[0] + (flat[1] - flat[0]) * (x * (1 - y)) + (flat[2] - flat[0]) * (x * y),
                                  area_vector(flat), steep) /
                n / n;
    }
    CHECK(polygon_form_factor(flat, steep).value == Approx(mean).epsilon(1e-3));
}

TEST_CASE("contour: surfaces of many polygons", "[radiosity][analytic]") {
    // A room in 12 triangles: from the floor to all else 1. Its faces look inwards.
    const Polygon faces[6] = {floor_square,
                              ceiling_square,
                              wall_square,
                              moved(turned(wall_square), {1, 0, 0}),
                              rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                              rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0})};
    std::vector<Polygon> others;
    for (int f = 1; f < 6; ++f) {
        others.push_back({faces[f][0], faces[f][1], faces[f][2]});
        others.push_back({faces[f][0], faces[f][2], faces[f][3]});
    }
    const std::vector<Polygon> from{{floor_square[0], floor_square[1], floor_square[2]},
                                    {floor_square[0], floor_square[2], floor_square[3]}};
    for (const Sides sides : {Sides::both, Sides::front}) {
        const ContourFactor f = surface_form_factor(from, others, sides);
        CHECK(f.value == Approx(1).margin(1e-11).epsilon(0));
        CHECK(std::fabs(f.value - 1) <= f.error + 1e-13);
        CHECK(point_form_factor({0.3, 0, 0.6}, {0, 1, 0}, others, sides) == Approx(1).margin(1e-14).epsilon(0));
    }
}

TEST_CASE("contour: polygons that are none are refused in a line", "[radiosity]") {
    auto refused = [](const Polygon& p) {
        try {
            check_polygon("A", p);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK(refused(floor_square).empty());
    CHECK(refused({{0, 0, 0}, {1, 0, 0}}) == "A: 2 corners: a polygon has 3 or more");
    CHECK(refused({}) == "A: 0 corners: a polygon has 3 or more");
    CHECK(refused({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}) == "A: no area");
    CHECK(refused({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}) == "A: no area");
    CHECK(refused({{0, 0, 0}, {1, 0, 0}, {NAN, 0, 1}}).find("expected finite numbers") != std::string::npos);
    CHECK(refused({{0, 0, 0}, {1, 0, 0}, {1, 1e300, 1}}).find("expected finite numbers") != std::string::npos);
    CHECK(refused({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}}).find("expected a flat polygon") != std::string::npos);
    CHECK(refused({{0, 0, 0}, {2, 0, 0}, {0.2, 0.2, 0}, {0, 2, 0}}).find("not convex at corner 2") !=
          std::string::npos);
    CHECK(refused({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}}).find("stands twice") != std::string::npos);
    Polygon star;
    for (int i = 0; i < 5; ++i) star.push_back({std::cos(4 * pi * i / 5), std::sin(4 * pi * i / 5), 0});
    CHECK(refused(star).find("crosses itself") != std::string::npos);
}

TEST_CASE("contour: clipping keeps what is in front", "[radiosity]") {
    const glm::dvec3 x(1, 0, 0);
    CHECK(clip_to_front(floor_square, {2, 0, 0}, x, 1e-13).empty());
    CHECK(clip_to_front(floor_square, {1, 0, 0}, x, 1e-13).empty());  // an edge on it is no area
    CHECK(clip_to_front(floor_square, {0, 0, 0}, x, 1e-13) == floor_square);
    CHECK(area(clip_to_front(floor_square, {0.25, 0, 0}, x, 1e-13)) == Approx(0.75).epsilon(1e-15));
    CHECK(area(clip_to_front(floor_square, {0.25, 0, 0}, -x, 1e-13)) == Approx(0.25).epsilon(1e-15));
}
