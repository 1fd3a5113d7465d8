#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/host_math.h"
#include "io/scenes/generate.h"

namespace plumb::io {
namespace {

Scene make(const char* name, std::int64_t triangles = 0, std::uint32_t seed = 1) {
    return generate_scene(name, {triangles, seed}, "test");
}

glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Six times the volume that front faces enclose: negative where they look inwards.
double volume(const Mesh& mesh) {
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.vertices[t.x].position), b(mesh.vertices[t.y].position), c(mesh.vertices[t.z].position);
        sum += glm::dot(a, cross(b, c));
    }
    return sum / 6;
}

double area(const Mesh& mesh, int material = -1) {
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (material >= 0 && mesh.material[t] != material) continue;
        const glm::uvec3 i = mesh.triangles[t];
        const glm::dvec3 a(mesh.vertices[i.x].position), b(mesh.vertices[i.y].position), c(mesh.vertices[i.z].position);
        const glm::dvec3 n = cross(b - a, c - a);
        sum += 0.5 * std::sqrt(glm::dot(n, n));
    }
    return sum;
}

// Edges, by the positions of their ends, that are not run through once each way. Ends that differ by a rounding
// are one.
int open_edges(const Geometry& g) {
    using Key = std::tuple<long, long, long>;
    auto key = [](const glm::vec3& p) {
        return Key(std::lround(p.x * 1e6), std::lround(p.y * 1e6), std::lround(p.z * 1e6));
    };
    std::map<std::pair<Key, Key>, int> balance;
    for (const glm::uvec3& t : g.triangles)
        for (int k = 0; k < 3; ++k) {
            const Key a = key(g.vertices[t[k]].position), b = key(g.vertices[t[(k + 1) % 3]].position);
            if (a < b)
                ++balance[{a, b}];
            else
                --balance[{b, a}];
        }
    int open = 0;
    for (const auto& [edge, count] : balance) open += count != 0;
    return open;
}

bool same_side(const Mesh& mesh) {
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.vertices[t.x].position), b(mesh.vertices[t.y].position), c(mesh.vertices[t.z].position);
        const glm::dvec3 n = cross(b - a, c - a);
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 m(mesh.vertices[t[k]].normal);
            if (!(glm::dot(n, m) > 0) || !(std::fabs(glm::dot(m, m) - 1) < 1e-6)) return false;
        }
    }
    return true;
}

}  // namespace

TEST_CASE("box: the tessellations of HEM 5.8 have its triangle counts", "[scenes][HEM 5.8]") {
    for (int triangles : {1200, 4800, 19200, 30000}) {
        const Scene scene = make("box", triangles);
        CHECK(flatten(scene).triangles.size() == std::size_t(triangles));
    }
}

TEST_CASE("hemicube_box: HEM 5.8's counts of vertices and triangles", "[scenes][HEM 5.8]") {
    const std::pair<std::int64_t, std::size_t> published[] = {{1200, 774}, {4800, 2734}, {19200, 10254}, {30000, 15814}};
    for (const auto& [triangles, vertices] : published) {
        const Scene scene = make("hemicube_box", triangles);
        const Geometry g = flatten(scene);
        CHECK(g.triangles.size() == std::size_t(triangles));
        CHECK(g.vertices.size() == vertices);
        CHECK(open_edges(g) == 0);
        // Corners of walls and blocks are equal floats: a cube of n x n quads a face has 6 n^2 + 2 (Euler).
        std::set<std::tuple<float, float, float>> positions;
        for (const Vertex& v : g.vertices) positions.insert({v.position.x, v.position.y, v.position.z});
        CHECK(positions.size() == std::size_t(triangles) / 2 + 2);
        double lamp = 0, enclosed = 0;
        for (const Mesh& mesh : scene.meshes) {
            lamp += area(mesh, 3), enclosed += volume(mesh);
            CHECK(same_side(mesh));
        }
        CHECK(lamp == Approx(0.16).epsilon(1e-6));  // a fifth of the ceiling's 2 m, squared
        CHECK(enclosed == Approx(-8).epsilon(1e-6));
    }
}

TEST_CASE("hemicube_shapes: that box with a sphere and a torus in it, lit by its ceiling alone", "[scenes][HEM C.10]") {
    const Scene scene = make("hemicube_shapes");
    const Geometry g = flatten(scene);
    CHECK(g.triangles.size() == 4980);
    CHECK(g.vertices.size() == 774 + 642 + 1326);  // sphere: 10 f^2 + 2, f = 8; torus: 51 x 26 with its seams
    CHECK(open_edges(g) == 0);
    CHECK(scene.lights.empty());
    CHECK(scene.materials[3].emission == glm::vec3(100.4f, 96.8f, 90.0f));
    for (const Mesh& mesh : scene.meshes) CHECK(same_side(mesh));
}

TEST_CASE("box: a closed cube of 2 m with a lamp in its ceiling", "[scenes][HEM C.9]") {
    const Scene scene = make("box");
    const Geometry g = flatten(scene);
    CHECK(open_edges(g) == 0);
    double total = 0, enclosed = 0;
    for (const Mesh& mesh : scene.meshes) {
        CHECK(same_side(mesh));
        total += area(mesh), enclosed += volume(mesh);
    }
    CHECK(total == Approx(24).epsilon(1e-6));
    CHECK(enclosed == Approx(-8).epsilon(1e-6));  // fronts look inwards
    // n = 10: the four middle patches of 0.2 m.
    CHECK(area(scene.meshes[1], 3) == Approx(0.16).epsilon(1e-5));
}

TEST_CASE("shapes: room, sphere and torus are closed and enclose their volumes", "[scenes][HEM C.10]") {
    for (int triangles : {300, 8000, 100000}) {
        const Scene scene = make("shapes", triangles);
        const Geometry g = flatten(scene);
        INFO(triangles << " asked for, " << g.triangles.size() << " made");
        CHECK(open_edges(g) == 0);
        CHECK(double(g.triangles.size()) <= triangles);
        CHECK(double(g.triangles.size()) > 0.5 * triangles);
        for (const Mesh& mesh : scene.meshes) CHECK(same_side(mesh));
    }
    // Torus 2 pi^2 R r^2, sphere 4 pi r^3 / 3; inscribed polyhedra fall short a little.
    const Scene scene = make("shapes", 200000);
    const double torus = 2 * host::pi * host::pi * 0.3 * 0.0081, sphere = 4 * host::pi / 3 * 0.027;
    CHECK(volume(scene.meshes[6]) == Approx(torus).epsilon(2e-3));
    CHECK(volume(scene.meshes[7]) == Approx(sphere).epsilon(2e-3));
}

TEST_CASE("furnace: sphere and cube are closed, look inwards and share their corners", "[scenes]") {
    const Scene sphere = make("furnace"), cube = make("furnace_cube");
    CHECK(flatten(sphere).triangles.size() == 5120);
    CHECK(sphere.meshes[0].vertices.size() == 2562);  // Euler: V = F / 2 + 2
    CHECK(open_edges(flatten(sphere)) == 0);
    CHECK(same_side(sphere.meshes[0]));
    CHECK(volume(sphere.meshes[0]) == Approx(-4 * host::pi / 3).epsilon(5e-3));
    CHECK(flatten(cube).triangles.size() == 1200);
    CHECK(open_edges(flatten(cube)) == 0);
    CHECK(same_side(cube.meshes[0]));
    CHECK(volume(cube.meshes[0]) == Approx(-8).epsilon(1e-6));
}

TEST_CASE("stress: every cell is there, and its extremes", "[scenes]") {
    const Scene scene = make("stress");
    REQUIRE(scene.meshes.size() == 17);
    const Geometry g = flatten(scene);
    CHECK(double(g.triangles.size()) == Approx(20000).epsilon(0.1));
    int degenerate = 0;
    float farthest = 0;
    for (const glm::uvec3& t : g.triangles) {
        const glm::dvec3 a(g.vertices[t.x].position), b(g.vertices[t.y].position), c(g.vertices[t.z].position);
        const glm::dvec3 n = cross(b - a, c - a);
        degenerate += glm::dot(n, n) < 1e-14;
        farthest = std::max(farthest, -g.vertices[t.x].position.z);
    }
    CHECK(degenerate > 1000);
    CHECK(farthest == 1e7f);
}

TEST_CASE("scenes: what is generated twice is the same, and as on every machine", "[scenes][golden]") {
    struct Golden {
        const char* name;
        std::int64_t triangles;
        const char* hash;
    };
    // Rewritten by hand when a scene changes on purpose.
    const Golden goldens[] = {
        {"box", 1200, "5e2a23e69f13d947"},          {"shapes", 8000, "c7d61a65bb90b668"},
                              {"furnace", 5120, "5687030e871d3539"},      {"furnace_cube", 1200, "5c194f405e4c2c70"},
                              {"stress", 20000, "e97a760f9a011313"}};
    for (const Golden& golden : goldens) {
        auto hash = [&] {
            const Geometry g = flatten(make(golden.name, golden.triangles));
            std::uint64_t h = content_hash(g.vertices.data(), g.vertices.size() * sizeof(Vertex));
            h = content_hash(g.triangles.data(), g.triangles.size() * sizeof(glm::uvec3), h);
            return hash_text(content_hash(g.material.data(), g.material.size() * sizeof(std::int32_t), h));
        };
        INFO(golden.name);
        CHECK(hash() == hash());
        CHECK(hash() == golden.hash);
    }
}

TEST_CASE("scenes: a wrong name or count is refused and says what is right", "[scenes][bad input]") {
    CHECK_THROWS_WITH(make("furnance"),
                      Catch::Contains("test: unknown scene \"furnance\"") && Catch::Contains("\"furnace\""));
    // Of the command line: no place.
    CHECK_THROWS_WITH(generate_scene("nope", {}, ""), Catch::StartsWith("unknown scene \"nope\"; known: "));
    CHECK_THROWS_WITH(generate_scene("box", {11, 1}, ""), Catch::StartsWith("triangles = 11: "));
    CHECK_THROWS_WITH(make("box", 11), Catch::Contains("triangles = 11") && Catch::Contains("12 to 10000000"));
    CHECK_THROWS_AS(make("box", -5), InputError);
}

}  // namespace plumb::io
