// Triangles split evenly and where radiosity changes; T-junctions and contacts, and the light that leaks at them.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/radiosity/contacts.h"
#include "gi/radiosity/cut_contacts.h"
#include "gi/radiosity/tessellate.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;
using namespace plumb::test;

namespace {

struct Shape {
    double longest = 0, area = 0, least_angle_deg = 180;
    std::size_t triangles = 0;
};
Shape shape_of(const Geometry& g) {
    Shape s;
    s.triangles = g.triangles.size();
    for (const glm::uvec3& t : g.triangles)
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 p(g.vertices[t[k]].position), a = glm::dvec3(g.vertices[t[(k + 1) % 3]].position) - p,
                             b = glm::dvec3(g.vertices[t[(k + 2) % 3]].position) - p;
            const double across = glm::length(glm::cross(a, b));
            s.longest = std::max(s.longest, glm::length(a));
            s.area += across / 6;
            s.least_angle_deg = std::min(s.least_angle_deg, host::atan2(across, glm::dot(a, b)) * 180 / host::pi);
        }
    return s;
}

void check_closed(const Geometry& g) {
    const Contacts c = inspect_contacts(g);
    CHECK(c.t_junctions == 0);
    CHECK(c.nearly_equal == 0);
}

// A floor [0, 1]^2 in x and z.
Scene floor_of(int n) {
    Scene s;
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, n, n, add_material(s, 0.5)));
    return s;
}

using Distribution = std::function<double(double x, double z)>;
Buffer<glm::vec4> values_at(const Elements& e, const Distribution& light) {
    Buffer<glm::vec4> out;
    for (const glm::vec4& p : e.position) out.push_back(glm::vec4(glm::vec3(float(light(p.x, p.z))), 0));
    return out;
}

// Root mean square error of the interpolated light over the floor, at 15 points a triangle.
double error_of(const Elements& e, const Distribution& light) {
    const Buffer<glm::vec4> b = values_at(e, light);
    double squares = 0, area = 0;
    for (std::size_t t = 0; t < e.of.size(); ++t) {
        const glm::uvec3 v = e.geometry.triangles[t];
        const glm::dvec3 p[3] = {glm::dvec3(e.geometry.vertices[v.x].position), glm::dvec3(e.geometry.vertices[v.y].position),
                                 glm::dvec3(e.geometry.vertices[v.z].position)};
        const double size = glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) / 2;
        for (int i = 0; i < 5; ++i)
            for (int j = 0; i + j < 5; ++j) {
                const double l[3] = {(i + 1 / 3.0) / 5, (j + 1 / 3.0) / 5, 1 - (i + j + 2 / 3.0) / 5};
                double x = 0, z = 0, got = 0;
                for (int k = 0; k < 3; ++k) x += l[k] * p[k].x, z += l[k] * p[k].z, got += l[k] * b[e.of[t][k]].x;
                squares += size * (got - light(x, z)) * (got - light(x, z)), area += size;
            }
    }
    return std::sqrt(squares / area);
}

Elements vertices_of(const Scene& s) { return elements_of(s, ElementParams{}); }

// The interpolated value at (x, z) of the floor, which looks up.
double value_at(const Elements& e, const Buffer<glm::vec4>& b, double x, double z) {
    for (std::size_t t = 0; t < e.of.size(); ++t) {
        const glm::uvec3 v = e.geometry.triangles[t];
        glm::dvec2 p[3];
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 q = e.geometry.vertices[v[k]].position;
            if (q.y != 0) p[0] = p[1] = p[2] = {0, 0};
            p[k] = {q.x, q.z};
        }
        const auto cross = [](const glm::dvec2& a, const glm::dvec2& c) { return a.x * c.y - a.y * c.x; };
        const double whole = cross(p[1] - p[0], p[2] - p[0]);
        if (whole == 0 || e.geometry.object[t] != 0) continue;
        const glm::dvec2 q(x, z);
        const double l1 = cross(q - p[0], p[2] - p[0]) / whole, l2 = cross(p[1] - p[0], q - p[0]) / whole;
        if (l1 < 0 || l2 < 0 || l1 + l2 > 1) continue;
        return (1 - l1 - l2) * b[e.of[t].x].x + l1 * b[e.of[t].y].x + l2 * b[e.of[t].z].x;
    }
    FAIL("not on the floor");
    return 0;
}

}  // namespace

TEST_CASE("tessellate: no edge is longer than asked, and the surface stays", "[radiosity][HEM 4.5.4]") {
    Scene s = floor_of(1);
    s.materials.push_back(s.materials[0]);
    s.meshes[0].material = {0, 1};
    for (const double longest : {0.75, 0.3, 0.02}) {
        const Scene fine = tessellate(s, {longest, 1'000'000});
        const Geometry g = flatten(fine);
        const Shape shape = shape_of(g);
        CHECK(shape.longest <= longest);
        CHECK(shape.longest > longest / 3);  // halves of right isosceles triangles: at most sqrt 2 twice
        CHECK(shape.area == Approx(1).epsilon(1e-6));
        CHECK(shape.least_angle_deg == Approx(45).epsilon(1e-3));
        check_closed(g);
        for (const Vertex& v : g.vertices) {
            CHECK(v.normal == glm::vec3(0, 1, 0));
            CHECK(v.u == v.position.z);  // as grid() lays them out; halves are exact
            CHECK(v.v == v.position.x);
        }
        for (std::size_t t = 0; t < g.triangles.size(); ++t) {
            glm::vec3 sum(0);
            for (int k = 0; k < 3; ++k) sum += g.vertices[g.triangles[t][k]].position;
            CHECK(g.material[t] == (sum.x < sum.z ? 0 : 1));
        }
    }
    CHECK(flatten(tessellate(s, {2, 2})).triangles.size() == 2);
}

TEST_CASE("tessellate: edges of different meshes are split at the same floats", "[radiosity]") {
    // A cube of six meshes, each moved away and put back by its transform, and a mirrored one beside it.
    Scene s = cube(3, {{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, {}}, 0.7);
    for (std::size_t m = 0; m < 6; ++m) {
        const glm::dvec3 by = 0.125 * double(m) * glm::dvec3(1, -1, 2);
        for (Vertex& v : s.meshes[m].vertices) v.position = glm::vec3(glm::dvec3(v.position) - by);
        s.meshes[m].transform[3] = glm::dvec4(by, 1);
    }
    const Geometry before = flatten(s);
    REQUIRE(inspect_contacts(before).nearly_equal > 0);  // the rounding of two transforms
    s = tessellate(s, {10, 1000});
    const Contacts was = inspect_contacts(flatten(s));

    Scene exact = cube(3, {{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, {}}, 0.75);
    exact.meshes[2].transform[0][0] = -1;  // mirrors the floor, whose u = 0.75 - x then
    exact.meshes[2].transform[3][0] = 0.75;
    check_closed(flatten(exact));
    const Scene fine = tessellate(exact, {0.1, 100'000});
    const Geometry g = flatten(fine);
    check_closed(g);
    CHECK(shape_of(g).area == Approx(6 * 0.5625).epsilon(1e-6));
    // Euler: of a closed surface of T triangles, T / 2 + 2 positions.
    std::vector<std::array<float, 3>> positions;
    for (const Vertex& v : g.vertices) positions.push_back({v.position.x + 0.0f, v.position.y + 0.0f, v.position.z + 0.0f});
    std::sort(positions.begin(), positions.end());
    positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
    CHECK(positions.size() == g.triangles.size() / 2 + 2);
    CHECK(was.t_junctions == 0);
    // All still look in.
    const Elements e = vertices_of(fine);
    for (int i = 0; i < e.count(); ++i) {
        const glm::vec3 in = glm::vec3(0.375f) - glm::vec3(e.position[std::size_t(i)]);
        CHECK(glm::dot(in, glm::vec3(e.normal[std::size_t(i)])) > 0.3f);
    }
}

TEST_CASE("refine: a shadow's edge is found and followed, and nothing else is split", "[radiosity][HEM 4.5.4]") {
    // Lit where x + 0.3 z > 0.6: the step lies between corners of every triangle that it crosses.
    const Distribution light = [](double x, double z) { return x + 0.3 * z > 0.6 ? 1.0 : 0.25; };
    Scene s = floor_of(4);
    const double least = 0.01;
    RefineParams p;
    p.least_edge = least;
    std::int64_t rounds = 0;
    for (bool changed = true; changed; ++rounds) {
        REQUIRE(rounds < 20);
        const Elements e = vertices_of(s);
        const Refined r = refine(s, e, values_at(e, light), p);
        changed = r.different > 0;
        CHECK(r.at_contacts == 0);
        CHECK(r.origin.size() == flatten(r.scene).triangles.size());
        if (!changed) {
            CHECK(r.origin.size() == e.of.size());
            CHECK(r.at_least_edge > 0);
        }
        s = r.scene;
        check_closed(flatten(s));
    }
    const Elements e = vertices_of(s);
    const Shape shape = shape_of(e.geometry);
    CHECK(shape.area == Approx(1).epsilon(1e-6));
    CHECK(shape.least_angle_deg > 22.4);  // half of 45
    const std::vector<double> difference = differences(e, values_at(e, light), 0);
    for (std::size_t t = 0; t < e.of.size(); ++t) {
        const glm::uvec3 v = e.geometry.triangles[t];
        glm::dvec3 q[3];
        double longest = 0;
        for (int k = 0; k < 3; ++k) q[k] = glm::dvec3(e.geometry.vertices[v[k]].position);
        for (int k = 0; k < 3; ++k) longest = std::max(longest, glm::distance(q[k], q[(k + 1) % 3]));
        // Of a triangle with the step: no edge may be halved again.
        if (difference[t] > 0) CHECK(longest < 2 * least);
        // Far from the step triangles are as they were.
        const glm::dvec3 c = (q[0] + q[1] + q[2]) / 3.0;
        if (std::fabs(c.x + 0.3 * c.z - 0.6) > 0.5) CHECK(longest > 0.2);
    }
}

TEST_CASE("refine: as little error with less than a quarter of the triangles that it takes evenly", "[radiosity][HEM 4.5.4]") {
    // A penumbra 0.05 m wide around a disc.
    const Distribution light = [](double x, double z) {
        const double r = std::sqrt((x - 0.45) * (x - 0.45) + (z - 0.55) * (z - 0.55)), t = (r - 0.3) / 0.05;
        return t < 0 ? 0.2 : t > 1 ? 1.0 : 0.2 + 0.8 * t * t * (3 - 2 * t);
    };
    Scene s = floor_of(4);
    RefineParams p;
    p.least_edge = 0.004;
    for (int round = 0; round < 8; ++round) {
        const Elements e = vertices_of(s);
        s = refine(s, e, values_at(e, light), p).scene;
    }
    const Elements adaptive = vertices_of(s);
    const double error = error_of(adaptive, light);
    double longest = 0.3;
    Elements even = vertices_of(tessellate(floor_of(1), {longest, 4'000'000}));
    while (error_of(even, light) > error) even = vertices_of(tessellate(floor_of(1), {longest /= std::sqrt(2.0), 4'000'000}));
    INFO("rms error " << error << ": " << adaptive.of.size() << " triangles, evenly " << even.of.size());
    CHECK(error < 2e-3);
    CHECK(even.of.size() > 4 * adaptive.of.size());
}

TEST_CASE("refine: differences are relative, by luminance or by all three channels", "[radiosity]") {
    const Scene s = floor_of(1);
    const Elements e = vertices_of(s);
    Buffer<glm::vec4> b(4, glm::vec4(1, 1, 1, 0));
    CHECK(differences(e, b, 0)[0] == 0);
    b[e.of[0].x].z = 4;  // blue: mean 2, luminance 0.0722 * 3 over 1.0722
    CHECK(differences(e, b, 0)[0] == Approx(1.5 / std::sqrt(3.0)).epsilon(1e-6));
    for (glm::vec4& x : b) x = glm::vec4(1, 1, 1, 0);
    b[e.of[0].x] = glm::vec4(4, 4, 4, 0);
    CHECK(differences(e, b, 0)[0] == Approx(1.5).epsilon(1e-6));
    // In the dark: the scene's mean is what counts.
    const Elements room = vertices_of(cube(1, {{}, {}}));
    Buffer<glm::vec4> dark(room.position.size(), glm::vec4(0));
    dark[room.of[11].x] = glm::vec4(1000, 1000, 1000, 0);
    dark[room.of[0].x] = glm::vec4(0.03f, 0.03f, 0.03f, 0);
    CHECK(differences(room, dark, 0)[0] == Approx(3).epsilon(1e-6));
    CHECK(differences(room, dark, 0.05)[0] < 0.1);
    CHECK(differences(room, Buffer<glm::vec4>(room.position.size(), glm::vec4(0)), 0.05)[0] == 0);
}

TEST_CASE("refine: with an element a triangle, neighbours are compared", "[radiosity]") {
    const Scene s = floor_of(4);
    ElementParams p;
    p.kind = Kind::triangles;
    const Elements e = elements_of(s, p);
    const Distribution step = [](double x, double) { return x > 0.5 ? 1.0 : 0.1; };
    const std::vector<double> d = differences(e, values_at(e, step), 0);
    int differ = 0;
    for (std::size_t t = 0; t < d.size(); ++t) {
        differ += d[t] > 0;
        if (d[t] > 0) CHECK(std::fabs(e.position[t].x - 0.5) < 0.25);
    }
    CHECK(differ == 8);  // four quads on each side, one triangle of each at the step
    CHECK(refine(s, e, values_at(e, step), {}).different == 8);
}

TEST_CASE("contacts: T-junctions and corners that nearly meet are counted", "[radiosity]") {
    Scene s = floor_of(1);
    CHECK(inspect_contacts(flatten(s)).t_junctions == 0);
    // Beside it, one mesh, two quads on the edge of one: the middle of the edge is a T-junction.
    append(s.meshes[0], grid({1, 0, 0}, {0, 0, 1}, {1, 0, 0}, 2, 1, 0));
    const Contacts junction = inspect_contacts(flatten(s));
    CHECK(junction.t_junctions == 1);
    CHECK(junction.contacts == 0);
    CHECK(junction.tolerance_m == Approx(2 * 0x1p-20));
    // A corner that misses by two roundings.
    Scene near = floor_of(1);
    append(near.meshes[0], grid({1, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, 0));
    CHECK(inspect_contacts(flatten(near)).nearly_equal == 0);
    near.meshes[0].vertices[4].position.x = 1 + 0x1p-22f;
    CHECK(inspect_contacts(flatten(near)).nearly_equal == 2);
    // What is there stays one, however finely the rest is split.
    CHECK(inspect_contacts(flatten(tessellate(s, {0.1, 100'000}))).nearly_equal == 0);
    Scene nothing;
    CHECK(inspect_contacts(flatten(nothing)).contacts == 0);
}

TEST_CASE("contacts: light leaks under a wall that a floor's triangles do not know", "[radiosity][leak]") {
    // A wall along x = 0.4 on a floor of one quad. Left of it the light is 1, right of it 0: that is what elements see.
    const Distribution truth = [](double x, double) { return x < 0.4 ? 1.0 : 0.0; };
    const auto with_wall = [](Scene s, double x, int rows) {
        s.meshes.push_back(grid({x, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, rows, 0));
        return s;
    };
    const auto leak = [&](const Scene& s, double x, double z) {
        const Elements e = vertices_of(s);
        Buffer<glm::vec4> b;
        for (int i = 0; i < e.count(); ++i) b.push_back(glm::vec4(float(truth(e.eye[std::size_t(i)].x, 0))));
        return value_at(e, b, x, z);
    };
    Scene s = with_wall(floor_of(1), 0.4, 1);
    const Contacts c = inspect_contacts(flatten(s));
    CHECK(c.contacts == 1);
    CHECK(c.triangles == std::vector<std::uint32_t>{0, 1});
    CHECK(leak(s, 0.45, 0.5) == Approx(0.55).epsilon(1e-6));  // 1 - x, behind the wall: truth is 0

    // Triangles at contacts are split down to the least edge, and the leak is as wide as they are.
    RefineParams p;
    p.least_edge = 0.02;
    std::int64_t split = 0;
    for (int round = 0; round < 8; ++round) {
        const Elements e = vertices_of(s);
        const Refined r = refine(s, e, Buffer<glm::vec4>(e.position.size(), glm::vec4(1)), p);
        split += r.at_contacts;
        s = r.scene;
    }
    CHECK(split > 10);
    CHECK(leak(s, 0.45, 0.5) == 0);
    CHECK(leak(s, 0.4001, 0.5) > 0.1);
    // Cut along the wall there is no leak at all, without one small triangle.
    const Cut cut = cut_contacts(with_wall(floor_of(1), 0.4, 3));
    CHECK(flatten(cut.scene).triangles.size() < 40);
    CHECK(inspect_contacts(flatten(cut.scene)).contacts == 0);
    check_closed(flatten(cut.scene));
    for (const double z : {0.01, 0.3, 0.5, 0.9}) {
        CHECK(leak(cut.scene, 0.4001, z) == 0);
        CHECK(leak(cut.scene, 0.3999, z) == 1);
    }

    // Where the floor has edges below the wall there is no leak at all: it is divided there.
    Scene two = floor_of(1);
    two.meshes[0] = grid({0, 0, 0}, {0, 0, 1}, {0.4, 0, 0}, 1, 1, 0);
    append(two.meshes[0], grid({0.4, 0, 0}, {0, 0, 1}, {0.6, 0, 0}, 1, 1, 0));
    two = with_wall(two, 0.4, 1);
    CHECK(inspect_contacts(flatten(two)).contacts == 0);
    CHECK(leak(two, 0.4001, 0.5) == 0);
    CHECK(leak(two, 0.3999, 0.5) == 1);
}

TEST_CASE("tessellate, refine: bad input is refused in a line", "[radiosity][bad input]") {
    const Scene s = floor_of(2);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (double bad : {0.0, -1.0, nan}) CHECK_THROWS_WITH(tessellate(s, {bad, 100}), Catch::Contains("longest_edge"));
    CHECK_THROWS_WITH(tessellate(s, {1e-9, 1000}), Catch::Contains("triangles after splitting: expected at most 1000"));
    CHECK_THROWS_AS(tessellate(Scene{}, {}), InputError);
    const Elements e = vertices_of(s);
    Buffer<glm::vec4> b(e.position.size(), glm::vec4(1));
    CHECK_THROWS_WITH(refine(floor_of(3), e, b, {}), Catch::Contains("another scene's"));
    b[3].y = float(nan);
    CHECK_THROWS_WITH(refine(s, e, b, {}), Catch::Contains("not finite"));
    b.pop_back();
    CHECK_THROWS_WITH(refine(s, e, b, {}), Catch::Contains("8 values for 9 elements"));
    RefineParams p;
    p.least_edge = nan;
    b.assign(9, glm::vec4(1));
    CHECK_THROWS_WITH(refine(s, e, b, p), Catch::Contains("least_edge"));
    p = {};
    p.tolerance = nan;
    CHECK_THROWS_WITH(refine(s, e, b, p), Catch::Contains("tolerance"));
}

TEST_CASE("tessellate: edges that floats cannot halve stay, and triangles without area are split like others",
          "[radiosity][extreme]") {
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({1e6, 0, 0}, {0, 0, 1}, {0.25, 0, 0}, 1, 1, white));  // x: four floats wide
    const Geometry g = flatten(tessellate(s, {0.05, 1'000'000}));
    CHECK(shape_of(g).longest < 0.1);
    CHECK(g.triangles.size() < 1000);
    // A sliver between a floor's edge and its two halves: it closes a T-junction, and is closed after.
    Scene sliver = floor_of(1);
    append(sliver.meshes[0], grid({1, 0, 0}, {0, 0, 1}, {1, 0, 0}, 2, 1, white));
    Mesh flat;
    for (const float z : {0.0f, 1.0f, 0.5f}) flat.vertices.push_back({{1, 0, z}, 0, {0, 1, 0}, 0});
    flat.triangles.push_back({0, 1, 2}), flat.material.push_back(white);
    append(sliver.meshes[0], flat);
    const Geometry fine = flatten(tessellate(sliver, {0.4, 1000}));
    CHECK(shape_of(fine).area == Approx(2).epsilon(1e-6));
    CHECK(shape_of(fine).longest <= 0.4);
    CHECK(inspect_contacts(fine).nearly_equal == 0);
}
