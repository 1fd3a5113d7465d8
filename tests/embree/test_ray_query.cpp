// Rays against triangles: by hand, against all triangles one by one, between packet widths and instruction sets, and
// against Embree's own triangles.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>

#include "core/content_hash.h"
#include "core/isa.h"
#include "core/parallel.h"
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
std::vector<Hit> by_hand(const Geometry& g, const std::vector<TestRay>& rays) {
    std::vector<Corners> corners(g.triangles.size());
    for (std::size_t k = 0; k < corners.size(); ++k) {
        float* corner[3] = {corners[k].a, corners[k].b, corners[k].c};
        for (int j = 0; j < 3; ++j)
            for (int axis = 0; axis < 3; ++axis) corner[j][axis] = g.vertices[g.triangles[k][j]].position[axis];
    }
    std::vector<Hit> hits;
    for (const TestRay& r : rays) {
        const ShearedRay ray = shear(r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z);
        Hit best{r.t_far};
        for (std::size_t k = 0; k < corners.size(); ++k) {
            TriangleHit hit;
            if (!meets(ray, corners[k], hit) || !(hit.t > r.t_near)) continue;
            const FaceNormal n = face_normal(corners[k]);
            if (n.x == 0 && n.y == 0 && n.z == 0) continue;
            if (hit.t < best.t || (hit.t == best.t && std::uint32_t(k) < best.triangle))
                best = {hit.t, hit.u, hit.v, {n.x, n.y, n.z}, std::uint32_t(k)};
        }
        hits.push_back(best);
    }
    return hits;
}

int differences(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    int count = a.size() != b.size();
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += !(a[i] == b[i]);
    return count;
}
int hit_count(const std::vector<Hit>& hits) {
    int count = 0;
    for (const Hit& h : hits) count += h.triangle != no_hit;
    return count;
}
// Occlusion by the nearest hit: something is hit or not.
int differences(const std::vector<Hit>& a, const std::vector<bool>& b) {
    int count = a.size() != b.size();
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += (a[i].triangle != no_hit) != b[i];
    return count;
}

Geometry one_triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    Geometry g;
    raster::test::add_triangle(g, raster::test::at(a), raster::test::at(b), raster::test::at(c));
    return g;
}

// Triangles in a cube of +-extent: some whole, some slivers, some of one plane along an axis that lie over each other,
// some twice, some without an area.
Geometry soup(int triangles, float extent, std::uint64_t seed) {
    Geometry g;
    Random random(seed);
    for (int i = 0; i < triangles; ++i) {
        const glm::vec3 c = random.vector(-1, 1);
        const float size = random.below(4) ? 0.15f : 1;
        glm::vec3 p[3] = {c + random.vector(-size, size), c + random.vector(-size, size),
                          c + random.vector(-size, size)};
        switch (random.below(8)) {
            case 0:
                p[2] = p[0] + (p[1] - p[0]) * 0.5f + random.vector(-1e-5, 1e-5);
                break;
            case 1:
            case 2: {
                const int axis = random.below(3);
                const float plane = 0.1f * float(random.below(5));
                for (glm::vec3& q : p) q[axis] = plane;
                break;
            }
            case 3:
                p[2] = p[random.below(2)];
                break;
            default:
                break;
        }
        const auto corner = [&](int k) { return raster::test::at(p[k] * extent); };
        raster::test::add_triangle(g, corner(0), corner(1), corner(2));
        if (random.below(6) == 0) raster::test::add_triangle(g, corner(1), corner(2), corner(0));
    }
    return g;
}

// Rays from within and from `distance` extents away, to random points and to corners and midpoints of edges.
std::vector<TestRay> rays_at(const Geometry& g, float extent, float distance, int count, std::uint64_t seed) {
    std::vector<TestRay> rays;
    Random random(seed);
    for (int i = 0; i < count; ++i) {
        TestRay r;
        r.origin = random.vector(-1, 1) * extent * distance;
        glm::vec3 target = random.vector(-1, 1) * extent;
        const glm::uvec3 t = g.triangles[std::size_t(random.below(int(g.triangles.size())))];
        const int kind = random.below(6);
        if (kind == 0) target = g.vertices[t.x].position;
        if (kind == 1) target = (g.vertices[t.x].position + g.vertices[t.y].position) * 0.5f;
        r.direction = target - r.origin;
        // Along an axis, from a place that shares coordinates with a corner.
        if (kind == 2) {
            const int axis = random.below(3);
            const float from = r.origin[axis];
            r.origin = target = g.vertices[t.x].position;
            r.origin[axis] = from, r.direction = {0, 0, 0}, r.direction[axis] = from > 0 ? -1.0f : 1.0f;
        }
        if (kind == 3) r.t_near = 0.3f, r.t_far = 0.9f;
        rays.push_back(r);
    }
    return rays;
}

// Exact rays to the bit; native ones divide as the processor likes: within four roundings.
bool agrees(const Hit& hit, const Hit& expected, Rays kind) {
    if (kind == Rays::exact) return hit == expected;
    const auto near = [](float a, float b) { return std::fabs(a - b) <= 4 * 0x1p-24f * std::fabs(b); };
    return near(hit.t, expected.t) && near(hit.u, expected.u) && near(hit.v, expected.v) && hit.normal == expected.normal &&
           hit.triangle == expected.triangle;
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
            CHECK(agrees(hit, {3, 0.25f, 0.25f, {0, 0, 8}, 0}, kind));
            CHECK(one(*query, {{3, 1.5f, 6 * side}, {0, 0, -2 * side}}).triangle == no_hit);
            CHECK(one(*query, {{1, 0.5f, 6 * side}, {0, 0, 2 * side}}).triangle == no_hit);
        }
    }
}

TEST_CASE("rays: t_near does not count and t_far does", "[reference][rays]") {
    const World world(one_triangle({0, 0, 0}, {4, 0, 0}, {0, 2, 0}));
    const auto query = world.query(Rays::exact);
    const auto ray = [](float t_near, float t_far) { return TestRay{{1, 0.5f, 3}, {0, 0, -1}, t_near, t_far}; };
    CHECK(one(*query, ray(0, 3)).triangle == 0);
    CHECK(one(*query, ray(0, std::nextafter(3.0f, 0.0f))) == Hit{std::nextafter(3.0f, 0.0f)});
    CHECK(one(*query, ray(std::nextafter(3.0f, 0.0f), 4)).triangle == 0);
    CHECK(one(*query, ray(3, 4)) == Hit{4});
    CHECK(occluded<1>(*query, {ray(0, 3), ray(0, std::nextafter(3.0f, 0.0f)), ray(3, 4)}) ==
          std::vector<bool>{true, false, false});
}

TEST_CASE("rays: hits are the first of all triangles, one by one", "[reference][rays]") {
    for (const float extent : {1e-4f, 1.0f, 37.0f, 1e6f})
        for (const float distance : {1.0f, 2.5f, 1e3f, 1e6f}) {
            INFO("extent " << extent << ", origins within " << distance);
            const World world(soup(500, extent, 3));
            const auto query = world.query(Rays::exact);
            const std::vector<TestRay> rays = rays_at(world.geometry, extent, distance, 8000, 5);
            const std::vector<Hit> expected = by_hand(world.geometry, rays);
            CHECK(hit_count(expected) > 1000);
            CHECK(differences(nearest<1>(*query, rays), expected) == 0);
            CHECK(differences(nearest<16>(*query, rays), expected) == 0);
            CHECK(differences(expected, occluded<1>(*query, rays)) == 0);
            CHECK(differences(expected, occluded<16>(*query, rays)) == 0);
        }
}

TEST_CASE("rays: every width and instruction set gives the same bits", "[reference][rays]") {
    const World world(soup(3000, 5, 7));
    const std::vector<TestRay> rays = rays_at(world.geometry, 5, 1.5f, 12000, 9);
    const std::vector<Hit> expected = nearest<1>(*world.query(Rays::exact), rays);
    CHECK(hit_count(expected) > 6000);
    // The bits themselves, on which GCC 12 and Clang 14 agree.
    CHECK(content_hash(expected.data(), expected.size() * sizeof(Hit)) == 0x80bef8e4ae521d2f);
    const struct {
        const char* isa;
        Isa needs;
    } sets[] = {{"isa=sse2", Isa::scalar}, {"isa=sse4.2", Isa::sse}, {"isa=avx", Isa::avx2}, {"isa=avx2", Isa::avx2}, {"isa=avx512", Isa::avx512}};
    const std::vector<Isa> there = supported_isas();
    for (const auto& [isa, needs] : sets) {
        if (std::find(there.begin(), there.end(), needs) == there.end()) continue;  // Embree makes no device for it
        INFO(isa);
        const auto query = world.query(Rays::exact, isa);
        CHECK(differences(nearest<1>(*query, rays), expected) == 0);
        CHECK(differences(nearest<4>(*query, rays), expected) == 0);
        CHECK(differences(nearest<8>(*query, rays), expected) == 0);
        CHECK(differences(nearest<16>(*query, rays), expected) == 0);
        CHECK(differences(expected, occluded<1>(*query, rays)) == 0);
        CHECK(differences(expected, occluded<4>(*query, rays)) == 0);
        CHECK(differences(expected, occluded<8>(*query, rays)) == 0);
        CHECK(differences(expected, occluded<16>(*query, rays)) == 0);
    }
}

TEST_CASE("rays: many threads share a query", "[reference][rays]") {
    const World world(soup(1000, 2, 11));
    const std::vector<TestRay> rays = rays_at(world.geometry, 2, 3, 8000, 13);
    for (const Rays kind : {Rays::exact, Rays::native}) {
        const auto query = world.query(kind);
        const std::vector<Hit> expected = nearest<8>(*query, rays);
        std::vector<int> different(16, 0);
        parallel_bands(16, 1, 8, [&](int first, int) {
            different[std::size_t(first)] = differences(nearest<8>(*query, rays), expected);
        });
        CHECK(different == std::vector<int>(16, 0));
    }
}

namespace {

// Fills a packet with known bytes, traces some of its lanes, and counts the lanes that changed though inactive.
template <int W>
int touched(const RayQuery& query, Random& random) {
    const std::vector<TestRay> aim(1, {{1, 0.5f, 6}, {0, 0, -1}});
    int count = 0;
    for (int round = 0; round < 50; ++round) {
        RayPacket<W> before, after;
        std::memset(&before, 0x35, sizeof before);  // floats of 6.7e-7
        std::int32_t active[W];
        for (int i = 0; i < W; ++i) {
            set(before, i, aim[0]);
            active[i] = -random.below(2);
        }
        const bool shadow = round % 2;
        std::memcpy(&after, &before, sizeof after);
        shadow ? query.occluded(active, after) : query.nearest(active, after);
        const auto* a = reinterpret_cast<const std::uint32_t*>(&before);
        const auto* b = reinterpret_cast<const std::uint32_t*>(&after);
        for (int i = 0; i < W; ++i) {
            for (int row = 0; row < 20 && !active[i]; ++row) count += a[row * W + i] != b[row * W + i];
            if (active[i]) count += !(shadow ? after.t_far[i] == -infinity : after.triangle[i] == 0);
            for (int row = 12; row < 20 && shadow; ++row) count += a[row * W + i] != b[row * W + i];
        }
    }
    return count;
}

}  // namespace

TEST_CASE("rays: inactive lanes are not touched, nor hits by occlusion", "[reference][rays]") {
    const World world(one_triangle({0, 0, 0}, {4, 0, 0}, {0, 2, 0}));
    Random random(1);
    for (const Rays kind : {Rays::exact, Rays::native})
        for (const char* isa : {"", "isa=sse4.2", "isa=avx2"}) {
            const auto query = world.query(kind, isa);
            INFO((kind == Rays::exact ? "exact " : "native ") << isa);
            CHECK(touched<1>(*query, random) == 0);
            CHECK(touched<4>(*query, random) == 0);
            CHECK(touched<8>(*query, random) == 0);
            CHECK(touched<16>(*query, random) == 0);
        }
}

TEST_CASE("rays: an empty scene, triangles without area and numbers that are none do no harm", "[reference][rays]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const TestRay ray{{0.25f, 0.25f, 1}, {0, 0, -1}};
    for (const Rays kind : {Rays::exact, Rays::native}) {
        CHECK(one(*World(Geometry{}).query(kind), ray) == Hit{infinity});
        CHECK_FALSE(occluded<16>(*World(Geometry{}).query(kind), {ray})[0]);

        Geometry g;
        const auto add = [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
            raster::test::add_triangle(g, raster::test::at(a), raster::test::at(b), raster::test::at(c));
        };
        add({nan, 0, 0.5f}, {1, 0, 0.5f}, {0, 1, 0.5f});
        add({0, 0, 0.5f}, {infinity, 0, 0.5f}, {0, 1, 0.5f});
        add({0, 0, 0.5f}, {0.5f, 0.5f, 0.5f}, {1, 1, 0.5f});
        add({0.25f, 0.25f, 0.5f}, {0.25f, 0.25f, 0.5f}, {0.25f, 0.25f, 0.5f});
        add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        const World world(g);
        const auto query = world.query(kind);
        const Hit hit = one(*query, ray);
        CHECK(agrees(hit, {1, 0.25f, 0.25f, {0, 0, 1}, 4}, kind));
        for (const TestRay& bad : {TestRay{{nan, 0, 1}, {0, 0, -1}}, TestRay{{0.25f, 0.25f, 1}, {0, nan, -1}},
                                   TestRay{{0.25f, 0.25f, 1}, {0, 0, 0}}, TestRay{{infinity, 0, 0}, {1, 0, 0}}}) {
            CHECK(one(*query, bad).triangle == no_hit);
            CHECK_FALSE(occluded<8>(*query, {bad})[0]);
        }
    }
}

namespace {

// Corners of an icosahedron's faces, divided into n x n each, on the unit sphere: closed, with shared corners.
Geometry geodesic_sphere(int n, const glm::vec3& centre) {
    const float golden = 1.6180340f;
    std::vector<glm::vec3> base;
    for (const float a : {-1.0f, 1.0f})
        for (const float b : {-golden, golden}) base.insert(base.end(), {{0, a, b}, {a, b, 0}, {b, 0, a}});
    Geometry g;
    std::map<std::array<std::int64_t, 3>, std::uint32_t> known;
    const auto corner = [&](const glm::dvec3& p) {
        const glm::dvec3 unit = p / std::sqrt(glm::dot(p, p));
        const std::array<std::int64_t, 3> key{std::llround(unit.x * 1e9), std::llround(unit.y * 1e9),
                                              std::llround(unit.z * 1e9)};
        const auto [place, fresh] = known.try_emplace(key, std::uint32_t(g.vertices.size()));
        if (fresh) g.vertices.push_back(raster::test::at(glm::vec3(unit) + centre));
        return place->second;
    };
    for (int i = 0; i < 12; ++i)
        for (int j = i + 1; j < 12; ++j)
            for (int k = j + 1; k < 12; ++k) {
                const glm::dvec3 a = base[std::size_t(i)], b = base[std::size_t(j)], c = base[std::size_t(k)];
                const auto is_edge = [](const glm::dvec3& e) { return glm::dot(e, e) < 4.1; };  // edges have length 2
                if (!is_edge(a - b) || !is_edge(b - c) || !is_edge(c - a)) continue;
                const auto at = [&](int u, int v) {
                    return corner(a + (b - a) * (double(u) / n) + (c - a) * (double(v) / n));
                };
                for (int u = 0; u < n; ++u)
                    for (int v = 0; u + v < n; ++v) {
                        g.triangles.push_back({at(u, v), at(u + 1, v), at(u, v + 1)});
                        if (u + v < n - 1) g.triangles.push_back({at(u, v + 1), at(u + 1, v), at(u + 1, v + 1)});
                    }
            }
    g.material.assign(g.triangles.size(), 0);
    g.object.assign(g.triangles.size(), 0);
    return g;
}

// Rays that leave a closed mesh without a hit: from its inside, at its corners, at points of its edges, anywhere.
template <int W>
int escapes(const RayQuery& query, const Geometry& g, const glm::vec3& centre, float inside, int count) {
    Random random(17);
    std::vector<TestRay> rays;
    for (int i = 0; i < count; ++i) {
        const glm::uvec3 t = g.triangles[std::size_t(random.below(int(g.triangles.size())))];
        const glm::vec3 a = g.vertices[t.x].position, b = g.vertices[t.y].position;
        const glm::vec3 from = i % 4 ? centre + random.vector(-inside, inside) : centre;
        const int kind = random.below(4);
        const float along = kind == 1 ? 0.5f : float(random.uniform());
        rays.push_back({from, (kind == 0   ? a
                               : kind == 3 ? centre + random.vector(-1, 1)
                                           : a + (b - a) * along) -
                                  from});
        if (rays.back().direction == glm::vec3(0)) rays.pop_back();
    }
    return int(rays.size()) - hit_count(nearest<W>(query, rays));
}

}  // namespace

TEST_CASE("rays: none of 1.8 million escapes from a closed mesh", "[reference][rays]") {
    for (const glm::vec3& centre : {glm::vec3(0), glm::vec3(0.3f, -0.7f, 11.1f)})
        for (const int n : {1, 5, 40}) {
            const World world(geodesic_sphere(n, centre));
            REQUIRE(world.geometry.triangles.size() == std::size_t(20 * n * n));
            REQUIRE(world.geometry.vertices.size() == std::size_t(10 * n * n + 2));
            const auto query = world.query(Rays::exact);
            CHECK(escapes<1>(*query, world.geometry, centre, 0.4f, 200000) == 0);
            CHECK(escapes<8>(*query, world.geometry, centre, 0.4f, 100000) == 0);
        }
}

namespace {

// A square about the z axis, over x and y of -half..half. A masked one has a texture of two texels, the left one
// transparent: rays pass at x < 0.
struct Wall {
    float z, half = 0.5f;
    bool masked = false;
};

// Wall k is the triangles 2k, where y < x, and 2k + 1.
struct Walls {
    std::vector<Wall> walls;
    Scene scene;
    Geometry geometry;
    raster::Surfaces surfaces;

    explicit Walls(std::vector<Wall> list) : walls(std::move(list)) {
        scene.materials.resize(2);
        scene.materials[1].alpha_cutoff = 0.5f;
        scene.materials[1].texture = 0;
        Texture texture;
        texture.texels = Image<std::uint32_t>(2, 1);
        texture.texels(0, 0) = 0x00ffffff, texture.texels(1, 0) = 0xffffffff;
        texture.filter = Filter::nearest;
        scene.textures.push_back(texture);
        for (const Wall& w : walls) {
            const auto corner = [&](float u, float v) {
                return raster::test::at({(2 * u - 1) * w.half, (2 * v - 1) * w.half, w.z}, {0, 0, 1}, u, v);
            };
            raster::test::add_triangle(geometry, corner(0, 0), corner(1, 0), corner(1, 1), w.masked);
            raster::test::add_triangle(geometry, corner(0, 0), corner(1, 1), corner(0, 1), w.masked);
        }
        surfaces = raster::prepare(scene, geometry);
    }

    // By definition: of the walls that are there where the ray meets their plane the nearest, of those the first.
    std::vector<Hit> expected(const std::vector<TestRay>& rays) const {
        std::vector<Hit> hits;
        for (const TestRay& r : rays) {
            Hit best{r.t_far};
            for (std::size_t k = 0; k < walls.size(); ++k) {
                const float t = (walls[k].z - r.origin.z) / r.direction.z;
                const glm::vec3 p = r.origin + t * r.direction;
                if (std::max(std::abs(p.x), std::abs(p.y)) > walls[k].half || (walls[k].masked && p.x < 0)) continue;
                if (!(t > r.t_near && t <= r.t_far) || (best.triangle != no_hit && !(t < best.t))) continue;
                best.t = t, best.triangle = std::uint32_t(2 * k) + !(p.y < p.x);
            }
            hits.push_back(best);
        }
        return hits;
    }
};

// Rays that hit another triangle, or the same at another t.
int other_hits(const std::vector<Hit>& a, const std::vector<Hit>& b, float tolerance = 0) {
    int count = a.size() != b.size();
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        count +=
            a[i].triangle != b[i].triangle || (a[i].triangle != no_hit && !(std::abs(a[i].t - b[i].t) <= tolerance));
    return count;
}

struct Interval {
    float t_near, t_far;
};

// From one eye, as a packet's lanes: to 32 x 32 points of the plane z = 0, at t = 1, over the intervals in turn. For
// walls at z = 0, -1 and -4 points and t are exact in floats, and none lies on an edge, a diagonal or a mask's x = 0.
std::vector<TestRay> rays_from_one_eye(float z, const std::vector<Interval>& intervals) {
    const glm::vec3 eye(-0.25f, 0.25f, z);
    std::vector<TestRay> rays;
    for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i) {
            const glm::vec3 to((float(i) + 0.5f) / 32 - 0.5f, (float(j) + 0.25f) / 32 - 0.5f, 0);
            const Interval& range = intervals[rays.size() % intervals.size()];
            rays.push_back({eye, to - eye, range.t_near, range.t_far});
        }
    return rays;
}

template <int W>
void check_from_one_eye(const Walls& world, const RayQuery& query, const std::vector<TestRay>& rays, float tolerance) {
    INFO("packets of " << W << " from z = " << rays[0].origin.z);
    const std::vector<Hit> expected = world.expected(rays);
    CHECK(hit_count(expected) > 50);
    CHECK(other_hits(nearest<W>(query, rays), expected, tolerance) == 0);
    CHECK(differences(expected, occluded<W>(query, rays)) == 0);
}
// Behind the walls is one so large that the eye is not far from the scene: far rays are traced one by one.
void check_from_one_eye(std::vector<Wall> walls, Rays kind, const std::vector<Interval>& intervals,
                        float tolerance = 0) {
    walls.push_back({-4, 4});
    const Walls world(walls);
    for (const char* isa : {"", "isa=sse4.2", "isa=avx2"}) {
        INFO((kind == Rays::exact ? "exact " : "native ") << isa);
        const auto query = build_ray_query(world.geometry, world.surfaces, kind, isa);
        for (const float z : {2.0f, -2.0f}) {
            const std::vector<TestRay> rays = rays_from_one_eye(z, intervals);
            check_from_one_eye<1>(world, *query, rays, tolerance);
            check_from_one_eye<4>(world, *query, rays, tolerance);
            check_from_one_eye<8>(world, *query, rays, tolerance);
            check_from_one_eye<16>(world, *query, rays, tolerance);
        }
    }
}

// All of the ray; up to or from a place between the walls; up to or from t = 1, where t_far counts and t_near does not.
const std::vector<Interval> between_walls{{0, infinity}, {0, 1.25f}, {0.75f, infinity}};
std::vector<Interval> to_the_bit() {
    const float below = std::nextafter(1.0f, 0.0f);
    std::vector<Interval> intervals = between_walls;
    intervals.insert(intervals.end(), {{0, 1}, {0, below}, {below, infinity}, {1, infinity}});
    return intervals;
}

}  // namespace

TEST_CASE("rays: rays pass where an alpha mask says that there is no surface", "[reference][rays]") {
    const Walls world({{0, 0.5f, true}, {-1}});
    REQUIRE(world.surfaces.any_masked);
    for (const Rays kind : {Rays::exact, Rays::native}) {
        const auto query = build_ray_query(world.geometry, world.surfaces, kind);
        std::vector<TestRay> rays;
        Random random(3);
        for (int i = 0; i < 4000; ++i) {
            const float x = float(random.between(-0.49, 0.49)), y = float(random.between(-0.49, 0.49));
            rays.push_back({{x, y, 2}, {0, 0, -1}, 0, 2.5f + float(i % 2)});
        }
        const std::vector<Hit> expected = world.expected(rays);
        CHECK(other_hits(nearest<1>(*query, rays), expected, 1e-6f) == 0);
        CHECK(other_hits(nearest<8>(*query, rays), expected, 1e-6f) == 0);
        CHECK(differences(expected, occluded<1>(*query, rays)) == 0);
        CHECK(differences(expected, occluded<16>(*query, rays)) == 0);
    }
}

// The wall with the mask is the first from z = 2, and the last from z = -2.
TEST_CASE("rays: packets of one origin pass where an alpha mask says so", "[reference][rays]") {
    const Wall masked{0, 0.5f, true}, opaque{-1, 4};
    for (const std::vector<Wall>& walls : {std::vector{masked, opaque}, {opaque, masked}, {masked}}) {
        check_from_one_eye(walls, Rays::exact, to_the_bit());
        check_from_one_eye(walls, Rays::native, between_walls, 1e-6f);
    }
}

// Walls that lie in each other, from small to large, from large to small, and of one size: Embree comes to them in one
// order or another.
TEST_CASE("rays: of equal hits by packets of one origin the lowest index counts", "[reference][rays]") {
    std::vector<Wall> growing, equal(16, {0});
    for (int k = 1; k <= 16; ++k) growing.push_back({0, float(k) / 32});
    const std::vector<Wall> shrinking(growing.rbegin(), growing.rend());
    for (std::vector<Wall> walls : {growing, shrinking, equal})
        for (const bool masks : {false, true}) {
            INFO("of " << walls[0].half << " to " << walls[15].half << (masks ? ", three of four masked" : ""));
            for (std::size_t k = 0; k < walls.size(); ++k) walls[k].masked = masks && k % 4 != 3;
            check_from_one_eye(walls, Rays::exact, to_the_bit());
        }
}

TEST_CASE("rays: packets of one origin hit the first of all triangles, one by one", "[reference][rays]") {
    for (const float extent : {1e-4f, 1.0f, 37.0f}) {
        INFO("extent " << extent);
        const World world(soup(500, extent, 3));
        const auto query = world.query(Rays::exact);
        Random random(29);
        for (int eye = 0; eye < 8; ++eye) {
            std::vector<TestRay> rays = rays_at(world.geometry, extent, 1, 1024, std::uint64_t(eye));
            const glm::vec3 origin = random.vector(-1, 1) * extent;
            for (TestRay& r : rays) r = {origin, r.origin + r.direction - origin, r.t_near, r.t_far};
            const std::vector<Hit> expected = by_hand(world.geometry, rays);
            CHECK(hit_count(expected) > 200);
            CHECK(differences(nearest<4>(*query, rays), expected) == 0);
            CHECK(differences(nearest<8>(*query, rays), expected) == 0);
            CHECK(differences(nearest<16>(*query, rays), expected) == 0);
            CHECK(differences(expected, occluded<4>(*query, rays)) == 0);
            CHECK(differences(expected, occluded<8>(*query, rays)) == 0);
            CHECK(differences(expected, occluded<16>(*query, rays)) == 0);
        }
    }
}

TEST_CASE("rays: exact and native differ only at edges, ties and by rounding", "[reference][rays]") {
    for (const char* name : {"box", "atrium"}) {
        INFO(name);
        const World world(io::generate_scene(name, {}, "test"));
        glm::vec3 low, high;
        REQUIRE(bounds(world.geometry, low, high));
        Random random(23);
        std::vector<TestRay> rays;
        for (int i = 0; i < 100000; ++i) {
            const glm::vec3 origin = low + (high - low) * random.vector(0, 1);
            rays.push_back({origin, random.vector(-1, 1)});
        }
        const std::vector<Hit> exact = nearest<8>(*world.query(Rays::exact), rays);
        const std::vector<Hit> native = nearest<8>(*world.query(Rays::native), rays);
        int other = 0, at_edge = 0, at_tie = 0, wrong = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit &e = exact[i], &n = native[i];
            if (e.triangle == n.triangle) {
                const bool close = e.triangle == no_hit || std::fabs(e.t - n.t) <= 1e-4f * (0.1f + e.t);
                wrong += !close;
                continue;
            }
            ++other;
            const auto edge = [](const Hit& h) {
                return h.triangle != no_hit && std::min({h.u, h.v, 1 - h.u - h.v}) < 1e-3f;
            };
            if (std::fabs(e.t - n.t) <= 1e-5f * (0.1f + e.t))
                ++at_tie;
            else if (edge(e) || edge(n))
                ++at_edge;
            else
                ++wrong;
        }
        WARN(name << ": of " << rays.size() << " rays " << other << " hit another triangle: at equal t " << at_tie
                  << ", at an edge " << at_edge << "; wrong " << wrong);
        CHECK(wrong == 0);
        CHECK(other < int(rays.size()) / 200);
    }
}

}  // namespace plumb::reference
