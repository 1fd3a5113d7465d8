// Tangent frames against dP/du of surfaces known in closed form, and how flatten() moves them.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/tangents.h"

using namespace plumb;

namespace {

constexpr double pi = 3.14159265358979323846;

bool near(const glm::vec4& t, const glm::vec3& expected, float w, double tolerance) {
    const glm::dvec3 d = glm::dvec3(t) - glm::dvec3(expected);
    return t.w == w && std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) <= tolerance;
}

// n x n squares over [-1, 1]^2 in the plane z = 0, facing +z, with uv = place(x, y).
template <class Place>
Mesh plane(int n, const Place& place) {
    Mesh m;
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) {
            const glm::vec3 p(2.0f * float(x) / float(n) - 1, 2.0f * float(y) / float(n) - 1, 0);
            const glm::vec2 uv = place(p.x, p.y);
            m.vertices.push_back({p, uv.x, {0, 0, 1}, uv.y});
        }
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const std::uint32_t a = std::uint32_t(y * (n + 1) + x), b = a + 1, c = a + std::uint32_t(n) + 1, d = c + 1;
            m.triangles.push_back({a, b, d}), m.triangles.push_back({a, d, c});
        }
    m.material.assign(m.triangles.size(), 0);
    return m;
}

// Longitude along u, from the pole at +y down along v; the seam has vertices for u = 0 and for u = 1.
Mesh sphere(int columns, int rows) {
    Mesh m;
    for (int r = 0; r <= rows; ++r)
        for (int c = 0; c <= columns; ++c) {
            const double a = 2 * pi * c / columns, b = pi * r / rows;
            const glm::vec3 p(std::sin(b) * std::sin(a), std::cos(b), std::sin(b) * std::cos(a));
            m.vertices.push_back({p, float(c) / float(columns), p, float(r) / float(rows)});
        }
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const std::uint32_t a = std::uint32_t(r * (columns + 1) + c), b = a + std::uint32_t(columns) + 1;
            if (r > 0) m.triangles.push_back({a, b, a + 1});
            if (r < rows - 1) m.triangles.push_back({a + 1, b, b + 1});
        }
    m.material.assign(m.triangles.size(), 0);
    return m;
}

double sphere_error(int columns, int rows) {
    Mesh m = sphere(columns, rows);
    const std::size_t vertices = m.vertices.size();
    generate_tangents(m);
    REQUIRE(m.vertices.size() == vertices);
    double worst = 0;
    for (const glm::uvec3& triangle : m.triangles)
        for (int k = 0; k < 3; ++k) {
            const Vertex& v = m.vertices[triangle[k]];
            const glm::dvec3 t(m.tangents[triangle[k]]), n(v.normal);
            REQUIRE(std::abs(glm::dot(t, t) - 1) < 1e-6);
            REQUIRE(std::abs(glm::dot(t, n)) < 1e-6);
            REQUIRE(m.tangents[triangle[k]].w == 1);
            const double a = 2 * pi * v.u;
            if (v.v > 0 && v.v < 1) worst = std::max(worst, glm::length(t - glm::dvec3(std::cos(a), 0, -std::sin(a))));
        }
    return worst;
}

}  // namespace

// B = w cross(N, T) points up in the image, which is against v.
TEST_CASE("tangents: a plane's are dP/du, on the side that is up in the image", "[tangents]") {
    struct Row { glm::vec2 u, v; glm::vec3 tangent; float w; };  // u = dot(row.u, xy), v = dot(row.v, xy)
    const float r = std::sqrt(0.5f);
    const Row rows[] = {
        {{1, 0}, {0, -1}, {1, 0, 0}, 1},   {{-1, 0}, {0, -1}, {-1, 0, 0}, -1}, {{1, 0}, {0, 1}, {1, 0, 0}, -1},
        {{3, 0}, {0, -0.1f}, {1, 0, 0}, 1}, {{0, 1}, {1, 0}, {0, 1, 0}, 1},     {{1, 1}, {1, -1}, {r, r, 0}, 1},
        {{1, 0}, {1, -1}, {r, r, 0}, 1},  // sheared: along dP/du, where v stays, not along the gradient of u
    };
    for (const Row& row : rows) {
        Mesh m = plane(3, [&](float x, float y) {
            return glm::vec2(row.u.x * x + row.u.y * y, row.v.x * x + row.v.y * y);
        });
        generate_tangents(m);
        REQUIRE(m.tangents.size() == 16);
        for (const glm::vec4& t : m.tangents) CHECK(near(t, row.tangent, row.w, 1e-6));
    }
}

TEST_CASE("tangents: where an image is mirrored, vertices split", "[tangents]") {
    Mesh m = plane(4, [](float x, float y) { return glm::vec2(std::abs(x), -y); });
    const Mesh before = m;
    generate_tangents(m);
    REQUIRE(m.vertices.size() == 25 + 5);  // those at x = 0
    REQUIRE(m.tangents.size() == 30);
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const Vertex &a = m.vertices[m.triangles[t][k]], &b = before.vertices[before.triangles[t][k]];
            REQUIRE(a.position == b.position);
            REQUIRE(a.u == b.u);
            const bool left = t % 8 < 4;
            CHECK(near(m.tangents[m.triangles[t][k]], {left ? -1 : 1, 0, 0}, left ? -1.0f : 1.0f, 1e-6));
        }
}

TEST_CASE("tangents: a cube's faces have the axes they are painted along", "[tangents]") {
    Mesh m;
    std::vector<glm::vec3> expected;
    for (int axis = 0; axis < 3; ++axis)
        for (float side : {1.0f, -1.0f}) {
            glm::vec3 n(0), right(0);
            n[axis] = side, right[(axis + 1) % 3] = 1;
            const glm::vec3 up = glm::cross(n, right);
            const std::uint32_t first = std::uint32_t(m.vertices.size());
            for (glm::vec2 c : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
                m.vertices.push_back({n + right * c.x + up * c.y, c.x / 2, n, -c.y / 2});
                expected.push_back(right);
            }
            m.triangles.push_back({first, first + 1, first + 2}), m.triangles.push_back({first, first + 2, first + 3});
        }
    generate_tangents(m);
    REQUIRE(m.tangents.size() == 24);
    for (std::size_t v = 0; v < 24; ++v) CHECK(near(m.tangents[v], expected[v], 1, 1e-6));
}

// A vertex's triangles lie off centre by half a step, along the seam and where diagonals run one way.
TEST_CASE("tangents: a sphere's point east, to half a step of its longitude", "[tangents]") {
    for (int columns : {16, 32, 64}) {
        CAPTURE(columns);
        CHECK(sphere_error(columns, columns / 2) <= 0.5 * 2 * pi / columns);
    }
}

// Triangle A spans 90 degrees with tangent (1, 0), B 45 degrees with (1, -1) / sqrt 2.
TEST_CASE("tangents: triangles around a vertex count by their angle", "[tangents]") {
    Mesh m;
    const glm::vec3 n(0, 0, 1);
    m.vertices = {{{0, 0, 0}, 0, n, 0}, {{5, 0, 0}, 5, n, 0}, {{0, 1, 0}, 0, n, -1}, {{-1, 1, 0}, -1, n, 0}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    generate_tangents(m);
    REQUIRE(m.vertices.size() == 4);
    const glm::dvec2 sum = pi / 2 * glm::dvec2(1, 0) + pi / 4 * std::sqrt(0.5) * glm::dvec2(1, -1);
    CHECK(near(m.tangents[0], glm::vec3(glm::normalize(sum), 0), 1, 1e-6));
    CHECK(near(m.tangents[1], {1, 0, 0}, 1, 1e-6));
}

TEST_CASE("tangents: how corners are indexed does not matter", "[tangents]") {
    Mesh shared = plane(5, [](float x, float y) { return glm::vec2(x + 0.3f * y * y, -y + 0.2f * x * x); }), soup;
    for (Vertex& v : shared.vertices) v.normal = glm::normalize(glm::vec3(0.2f * v.position.x, -0.1f, 1));
    for (const glm::uvec3& t : shared.triangles) {
        const std::uint32_t first = std::uint32_t(soup.vertices.size());
        for (int k = 0; k < 3; ++k) soup.vertices.push_back(shared.vertices[t[k]]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    generate_tangents(shared), generate_tangents(soup);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            REQUIRE(shared.tangents[shared.triangles[t][k]] == soup.tangents[soup.triangles[t][k]]);
}

TEST_CASE("tangents: coordinates without an area", "[tangents]") {
    Mesh flat = plane(2, [](float, float) { return glm::vec2(0.5f); });
    generate_tangents(flat);
    for (const glm::vec4& t : flat.tangents) CHECK(t == glm::vec4(1, 0, 0, 1));

    // One triangle without an area, beside mirrored ones, adds nothing, takes their side and splits nothing.
    Mesh m = plane(2, [](float x, float y) { return glm::vec2(-x, -y); });
    const Vertex v = m.vertices[0];
    m.vertices.push_back({{-1, -2, 0}, v.u, v.normal, v.v});
    m.triangles.push_back({1, 0, 9});
    generate_tangents(m);
    REQUIRE(m.vertices.size() == 10);
    for (std::size_t k = 0; k < 9; ++k) CHECK(near(m.tangents[k], {-1, 0, 0}, -1, 1e-6));
    CHECK(m.tangents[9] == glm::vec4(1, 0, 0, 1));

    // Numbers that are none, and nothing at all, stay harmless.
    Mesh wild = plane(1, [](float x, float) { return glm::vec2(x > 0 ? std::nanf("") : 1e38f, INFINITY); });
    generate_tangents(wild);
    for (const glm::vec4& t : wild.tangents) CHECK(t == glm::vec4(1, 0, 0, 1));
    Mesh nothing;
    generate_tangents(nothing);
    CHECK(nothing.tangents.empty());
}

TEST_CASE("flatten: tangents move with the surface; a mirror turns their side", "[tangents]") {
    Scene scene;
    scene.materials.push_back({"m"});
    scene.materials[0].normal_texture = 0;
    scene.meshes.push_back(plane(1, [](float x, float y) { return glm::vec2(x + y, x - y); }));
    generate_tangents(scene.meshes[0]);
    scene.meshes.push_back(plane(1, [](float x, float y) { return glm::vec2(x, y); }));  // has none
    scene.meshes[0].transform[0][0] = 3;                                                 // stretched along x
    Geometry g = flatten(scene);
    REQUIRE(g.tangents.size() == 8);
    CHECK(near(g.tangents[0], glm::normalize(glm::vec3(3, 1, 0)), 1, 1e-6));
    CHECK(g.tangents[4] == glm::vec4(0));

    scene.meshes[0].transform[0][0] = -3;
    CHECK(near(flatten(scene).tangents[0], glm::normalize(glm::vec3(-3, 1, 0)), -1, 1e-6));

    scene.materials[0].normal_texture = -1;
    CHECK(flatten(scene).tangents.empty());
}

TEST_CASE("flatten: blocks of a large mesh fill their own parts", "[tangents]") {
    Scene scene;
    scene.materials.push_back({"m"});
    scene.meshes.push_back(plane(2, [](float x, float y) { return glm::vec2(x, y); }));
    scene.meshes.push_back(plane(200, [](float x, float y) { return glm::vec2(x, y); }));
    scene.meshes.push_back(scene.meshes[1]);
    scene.meshes[2].transform[3] = {10, 20, 30, 1}, scene.meshes[2].transform[0][0] = -2;
    scene.meshes[2].share = 0.75;
    const Geometry g = flatten(scene);
    const Mesh &a = scene.meshes[1], &b = scene.meshes[2];
    REQUIRE(g.vertices.size() == 9 + 2 * a.vertices.size());
    REQUIRE(g.triangles.size() == 8 + a.triangles.size() + a.triangles.size() * 3 / 4);
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
        REQUIRE(g.vertices[9 + i].position == a.vertices[i].position);
        const glm::vec3 p = a.vertices[i].position;
        REQUIRE(g.vertices[9 + a.vertices.size() + i].position == glm::vec3(-2 * p.x + 10, p.y + 20, p.z + 30));
        REQUIRE(g.vertices[9 + a.vertices.size() + i].v == b.vertices[i].v);
    }
    for (std::size_t t = 8; t < g.triangles.size(); ++t) {
        const bool second = t >= 8 + a.triangles.size();
        const glm::uvec3 local = a.triangles[t - 8 - (second ? a.triangles.size() : 0)];
        const glm::uvec3 base(second ? std::uint32_t(9 + a.vertices.size()) : 9u);
        REQUIRE(g.triangles[t] == base + (second ? glm::uvec3(local.x, local.z, local.y) : local));
        REQUIRE(g.object[t] == (second ? 2 : 1));
    }
}
