// Rays against triangles: by hand, against all triangles one by one, between packet widths and instruction sets, and
// against Embree's own triangles.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

#include "gi/reference/ray_device.h"
#include "gi/reference/triangle_test.h"
#include "io/scenes/generate.h"
#include "tests/raster/drawing.h"

namespace plumb::reference {
namespace {

using raster::test::Random;
constexpr float infinity = std::numeric_limits<float>::infinity();

raster::Surfaces surfaces_of(const Geometry& g) {
    Scene scene;
    scene.materials.resize(1);
    return raster::prepare(scene, g);
}

struct World {
    Geometry geometry;
    raster::Surfaces surfaces;
    explicit World(Geometry g) : geometry(std::move(g)), surfaces(surfaces_of(geometry)) {}
    World(const Scene& scene) : geometry(flatten(scene)), surfaces(raster::prepare(scene, geometry)) {}
    std::unique_ptr<RayQuery> query(Rays rays, const std::string& config = "") const {
        return build_ray_query(geometry, surfaces, rays, config);
    }
};

struct TestRay {
    glm::vec3 origin, direction;
    float t_near = 0, t_far = infinity;
};
struct Hit {
    float t = 0, u = 0, v = 0;
    glm::vec3 normal{0};
    std::uint32_t triangle = no_hit;
    bool operator==(const Hit& o) const = default;
};

template <int W>
void set(RayPacket<W>& p, int i, const TestRay& r) {
    p.origin_x[i] = r.origin.x, p.origin_y[i] = r.origin.y, p.origin_z[i] = r.origin.z;
    p.direction_x[i] = r.direction.x, p.direction_y[i] = r.direction.y, p.direction_z[i] = r.direction.z;
    p.t_near[i] = r.t_near, p.t_far[i] = r.t_far, p.time[i] = 0;
}
template <int W>
Hit get(const RayPacket<W>& p, int i) {
    if (p.triangle[i] == no_hit) return {p.t_far[i]};
    return {p.t_far[i], p.u[i], p.v[i], {p.normal_x[i], p.normal_y[i], p.normal_z[i]}, p.triangle[i]};
}

// Every ray, W at a time.
template <int W>
std::vector<Hit> nearest(const RayQuery& query, const std::vector<TestRay>& rays) {
    std::vector<Hit> hits(rays.size());
    for (std::size_t first = 0; first < rays.size(); first += W) {
        RayPacket<W> packet;
        alignas(64) std::int32_t active[W];
        for (int i = 0; i < W; ++i) {
            active[i] = first + i < rays.size() ? -1 : 0;
            if (active[i]) set(packet, i, rays[first + i]);
        }
        query.nearest(active, packet);
        for (int i = 0; i < W; ++i)
            if (active[i]) hits[first + i] = get(packet, i);
    }
    return hits;
}
template <int W>
std::vector<bool> occluded(const RayQuery& query, const std::vector<TestRay>& rays) {
    std::vector<bool> blocked(rays.size());
    for (std::size_t first = 0; first < rays.size(); first += W) {
        RayPacket<W> packet;
        alignas(64) std::int32_t active[W];
        for (int i = 0; i < W; ++i) {
            active[i] = first + i < rays.size() ? -1 : 0;
            if (active[i]) set(packet, i, rays[first + i]);
        }
        query.occluded(active, packet);
        for (int i = 0; i < W; ++i)
            if (active[i]) blocked[first + i] = packet.t_far[i] == -infinity;
    }
    return blocked;
}
Hit one(const RayQuery& query, const TestRay& ray) { return nearest<1>(query, {ray})[0]; }

// By definition: all triangles in turn.
Hit by_hand(const Geometry& g, const TestRay& r) {
    const ShearedRay ray = shear(r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z);
    Hit best{r.t_far};
    for (std::size_t k = 0; k < g.triangles.size(); ++k) {
        Corners c{};
        float* corner[3] = {c.a, c.b, c.c};
        for (int j = 0; j < 3; ++j)
            for (int axis = 0; axis < 3; ++axis) corner[j][axis] = g.vertices[g.triangles[k][j]].position[axis];
        const FaceNormal n = face_normal(c);
        TriangleHit hit;
        if ((n.x == 0 && n.y == 0 && n.z == 0) || !meets(ray, c, hit) || !(hit.t > r.t_near)) continue;
        if (hit.t < best.t || (hit.t == best.t && std::uint32_t(k) < best.triangle))
            best = {hit.t, hit.u, hit.v, {n.x, n.y, n.z}, std::uint32_t(k)};
    }
    return best;
}

Geometry one_triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    Geometry g;
    raster::test::add_triangle(g, raster::test::at(a), raster::test::at(b), raster::test::at(c));
    return g;
}

}  // namespace

// The triangle (0,0,0), (4,0,0), (0,2,0) is met at (1, 0.5, 0): u = 1/4, v = 1/4. Its normal is (4,0,0) x (0,2,0) =
// (0,0,8). A direction of length 2 from 6 m away: t = 3.
TEST_CASE("rays: a triangle is hit from both sides", "[reference][rays]") {
    const World world(one_triangle({0, 0, 0}, {4, 0, 0}, {0, 2, 0}));
    for (const Rays kind : {Rays::exact, Rays::native}) {
        const auto query = world.query(kind);
        for (const float side : {1.0f, -1.0f}) {
            const Hit hit = one(*query, {{1, 0.5f, 6 * side}, {0, 0, -2 * side}});
            CHECK(hit == Hit{3, 0.25f, 0.25f, {0, 0, 8}, 0});
            CHECK(one(*query, {{3, 1.5f, 6 * side}, {0, 0, -2 * side}}).triangle == no_hit);
            CHECK(one(*query, {{1, 0.5f, 6 * side}, {0, 0, 2 * side}}).triangle == no_hit);
        }
    }
}

}  // namespace plumb::reference
