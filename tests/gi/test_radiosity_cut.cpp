// Surfaces cut where others stand on them.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "gi/radiosity/contacts.h"
#include "gi/radiosity/cut_contacts.h"
#include "gi/radiosity/elements.h"
#include "gi/radiosity/tessellate.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;
using namespace plumb::test;

namespace {

// The sides and the top of a box: `side` long, turned about its foot's middle.
Mesh box_on(const glm::dvec2& middle, double side, double height, double turn, int n, int material) {
    const Point3 u(side * std::cos(turn), 0, side * std::sin(turn)), v(-u.z, 0, u.x), up(0, height, 0);
    const Point3 foot = Point3(middle.x, 0, middle.y) - (u + v) * 0.5;
    Mesh m = grid(foot + up, v, u, n, n, material);
    append(m, grid(foot, up, u, n, n, material));
    append(m, grid(foot + u, up, v, n, n, material));
    append(m, grid(foot + u + v, up, -u, n, n, material));
    append(m, grid(foot + v, up, -v, n, n, material));
    return m;
}

Scene floor_with(const Mesh& on_it, int n, bool one_mesh) {
    Scene s;
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, n, n, add_material(s, 0.5)));
    if (one_mesh)
        append(s.meshes[0], on_it);
    else
        s.meshes.push_back(on_it);
    return s;
}

struct Areas {
    double floor = 0, below = 0, all = 0;
};
// below: of the floor's triangles whose middles lie in the turned square.
Areas areas_of(const Geometry& g, const glm::dvec2& middle, double side, double turn) {
    Areas a;
    for (const glm::uvec3& t : g.triangles) {
        const Point3 p(g.vertices[t.x].position), q(g.vertices[t.y].position), r(g.vertices[t.z].position);
        const double area = glm::length(glm::cross(q - p, r - p)) / 2;
        a.all += area;
        if (p.y != 0 || q.y != 0 || r.y != 0) continue;
        a.floor += area;
        const Point3 c = (p + q + r) / 3.0;
        const double x = c.x - middle.x, z = c.z - middle.y, along = x * std::cos(turn) + z * std::sin(turn), across = z * std::cos(turn) - x * std::sin(turn);
        if (std::fabs(along) < side / 2 && std::fabs(across) < side / 2) a.below += area;
    }
    return a;
}

}  // namespace

TEST_CASE("cut: a floor ends where a turned box stands on it, to the square of its foot", "[radiosity][contacts]") {
    const glm::dvec2 middle(0.47, 0.52);
    const double side = 0.3137, turn = 0.41;
    for (const int n : {1, 3})
        for (const int of_floor : {1, 4, 13})
            for (const bool one_mesh : {false, true}) {
                CAPTURE(n, of_floor, one_mesh);
                const Scene before = floor_with(box_on(middle, side, 0.2, turn, n, 0), of_floor, one_mesh);
                const Cut cut = cut_contacts(before);
                const Geometry g = flatten(cut.scene);
                const Areas was = areas_of(flatten(before), middle, side, turn), is = areas_of(g, middle, side, turn);
                CHECK(is.floor == Approx(1).epsilon(1e-6));
                CHECK(is.all == Approx(was.all).epsilon(1e-6));
                CHECK(is.below == Approx(side * side).epsilon(1e-5));
                CHECK(std::fabs(was.below - side * side) > 1e-4);
                const Contacts left = inspect_contacts(g);
                CHECK(left.t_junctions == 0);
                CHECK(left.contacts == 0);
                CHECK(cut.crossings > 0);
                CHECK(cut.inside > 0);
                for (const Vertex& v : g.vertices) {
                    if (v.position.y != 0 || v.normal != glm::vec3(0, 1, 0)) continue;
                    CHECK(v.u == Approx(v.position.z).margin(1e-6));  // as grid() lays them out
                    CHECK(v.v == Approx(v.position.x).margin(1e-6));
                }
                // Nothing is left to cut.
                CHECK(flatten(cut_contacts(cut.scene).scene).triangles.size() == g.triangles.size());
            }
}

TEST_CASE("cut: elements before a box are others than those below it", "[radiosity][contacts]") {
    const glm::dvec2 middle(0.5, 0.5);
    const Scene s = cut_contacts(floor_with(box_on(middle, 0.25, 0.5, 0, 1, 0), 4, true)).scene;
    const Elements e = elements_of(s, {});
    // Of a floor's triangle all corners look from before the box, or all from below it.
    int below = 0, before = 0;
    for (std::size_t t = 0; t < e.of.size(); ++t) {
        int inside = 0;
        bool floor = true;
        for (int k = 0; k < 3; ++k) {
            const glm::vec4 eye = e.eye[e.of[t][k]];
            floor = floor && e.geometry.vertices[e.geometry.triangles[t][k]].position.y == 0;
            inside += std::fabs(eye.x - 0.5f) < 0.125f && std::fabs(eye.z - 0.5f) < 0.125f;
        }
        if (!floor || e.normal[e.of[t].x].y < 0.9f) continue;
        CHECK((inside == 0 || inside == 3));
        (inside == 3 ? below : before) += 1;
    }
    CHECK(below > 0);
    CHECK(before > 0);
}

TEST_CASE("cut: T-junctions are closed, and what touches nothing stays as it is", "[radiosity][contacts]") {
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));
    append(s.meshes[0], grid({1, 0, 0}, {0, 0, 1}, {1, 0, 0}, 4, 1, white));
    REQUIRE(inspect_contacts(flatten(s)).t_junctions == 3);
    const Cut cut = cut_contacts(s);
    CHECK(inspect_contacts(flatten(cut.scene)).t_junctions == 0);
    CHECK(cut.corners == 3);
    CHECK(flatten(cut.scene).triangles.size() == 2 + 8 + 3);
    // A cube, and a sheet on its floor's plane that shares no corner with it: nothing stands there.
    Scene flat = cube(3, {{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, {}});
    const std::size_t count = flatten(flat).triangles.size();
    CHECK(flatten(cut_contacts(flat).scene).triangles.size() == count);
    flat.meshes.push_back(grid({0.4, 0, 0.41}, {0, 0, 0.2}, {0.17, 0, 0}, 1, 1, 0));
    const Cut kept = cut_contacts(flat);
    CHECK(kept.inside + kept.crossings + kept.corners == 0);
    CHECK(flatten(kept.scene).triangles.size() == count + 2);
}

TEST_CASE("cut: what stands on many triangles takes rounds by their logarithm", "[radiosity][contacts]") {
    // A wall of one quad along a strip of n, and one corner after the other within one triangle.
    for (const int n : {16, 256}) {
        CAPTURE(n);
        Scene s;
        s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, n, add_material(s, 0.5)));
        s.meshes.push_back(grid({0, 0, 0.37}, {0, 1, 0}, {1, 0, 0}, 1, 1, 0));
        const Cut cut = cut_contacts(s);
        CHECK(inspect_contacts(flatten(cut.scene)).t_junctions == 0);
        CHECK(cut.crossings + cut.corners >= 2 * n);
        CHECK(cut.rounds <= 3 * std::ilogb(double(n)));
    }
}

TEST_CASE("cut: pieces end at 128 times what meets", "[radiosity][contacts]") {
    // A wall whose foot crosses the floor's diagonal edge at x from its corner, along both of its own edges.
    const double meets = 0x1p-20, near = 60 * meets, far = 200 * meets;
    for (const double x : {near, far}) {
        CAPTURE(x);
        Scene s;
        s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, add_material(s, 0.5)));
        s.meshes.push_back(grid({x, 0, -0.25}, {0, 1, 0}, {0, 0, 1.25}, 1, 1, 0));
        const Cut cut = cut_contacts(s);
        CHECK((cut.crossings > 0) == (x == far));
    }
}

TEST_CASE("cut: triangles lower than 128 times what meets stay whole", "[radiosity][contacts]") {
    const double meets = 0x1p-20;
    for (const bool low : {true, false}) {
        CAPTURE(low);
        Scene s;
        s.meshes.push_back(grid({0, 0, 0}, {0, 0, (low ? 60 : 600) * meets}, {1, 0, 0}, 1, 1, add_material(s, 0.5)));
        s.meshes.push_back(grid({0.37, 0, -0.25}, {0, 1, 0}, {0, 0, 1.25}, 1, 1, 0));
        CHECK((cut_contacts(s).crossings > 0) == !low);
    }
}

TEST_CASE("cut: too many triangles are refused with the number", "[radiosity][bad input]") {
    const Scene s = floor_with(box_on({0.5, 0.5}, 0.3, 0.2, 0.4, 1, 0), 1, true);
    CHECK_THROWS_WITH(cut_contacts(s, 13), Catch::Contains("triangles after splitting: expected at most 13"));
    CHECK_NOTHROW(cut_contacts(s, 100));
    CHECK(flatten(cut_contacts(Scene{}).scene).triangles.empty());
}
