// Item buffers of hemicubes: the fast loop against the kernel that asks every triangle, and both against rays.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/parallel.h"
#include "gi/lend.h"
#include "gi/radiosity/items.h"
#include "raster/hemicube.h"
#include "tests/raster/drawing.h"

using namespace plumb;
using raster::test::Random;

namespace {

struct Soup {
    Buffer<glm::vec4> vertices;
    Buffer<glm::ivec4> triangles;

    void add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
        const int first = int(vertices.size());
        for (const glm::vec3& p : {a, b, c}) vertices.push_back(glm::vec4(p, 0));
        triangles.push_back({first, first + 1, first + 2, 0});
    }
};

// Triangles of all sizes around the origin, some through it, some of no area, one with corners that are not there.
Soup soup(int n, std::uint32_t seed) {
    Random random(seed);
    Soup s;
    for (int i = 0; i < n; ++i) {
        const double size = i % 5 == 0 ? 3 : i % 5 == 1 ? 1e-3 : 0.3;
        const glm::vec3 a(random.vector(-2, 2));
        s.add(a, a + glm::vec3(random.vector(-size, size)), a + glm::vec3(random.vector(-size, size)));
    }
    s.add(glm::vec3(1), glm::vec3(1), glm::vec3(2));
    s.triangles.push_back({0, 1, int(s.vertices.size()), 0});
    s.triangles.push_back({0, -1, 2, 0});
    return s;
}

struct Items {
    std::vector<std::int32_t> triangle;
    Image4 seen;
};

Items items_of(const Soup& s, const Buffer<glm::vec4>& eyes, int size, Isa isa, int threads = 0) {
    const int cubes = int(eyes.size() / 4);
    const StageData d = radiosity::data_of({&s.vertices, &s.triangles, &eyes, size}, 0, cubes);
    Items items{std::vector<std::int32_t>(std::size_t(d.size.x * d.size.y), -7), Image4(d.size.x, d.size.y)};
    RunOptions options;
    options.isa = isa, options.threads = threads;
    Bundle outputs;
    lend(outputs, "triangle", {std::int64_t(items.triangle.size()), 1}, items.triangle.data());
    lend(outputs, "seen", {std::int64_t(items.triangle.size()), 4}, &items.seen.texels[0].x);
    stage<radiosity::ItemsKernel>().bind(d)->run(options, {}, outputs);
    return items;
}

// As the kernel has it, triangle by triangle of every texel.
Items slow_items(const Soup& s, const Buffer<glm::vec4>& eyes, int size) {
    const int cubes = int(eyes.size() / 4), rows = radiosity::rows_of_hemicube(size) * cubes;
    Items items{std::vector<std::int32_t>(std::size_t(size * rows)), Image4(size, rows)};
    const float texel = 2.0f / float(size);
    radiosity::ItemsView v{{size, rows, int(s.vertices.size()), int(s.triangles.size()), texel, texel / 64, {}}, &eyes[0].x, &s.vertices[0].x,
                           &s.triangles[0].x, nullptr, nullptr};
    NoTap tap;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < size; ++x) {
            const radiosity::Item<float> item = radiosity::item<float>(v, x, y, tap);
            items.triangle[std::size_t(y * size + x)] = item.triangle, items.seen(x, y) = item.seen;
        }
    return items;
}

Buffer<glm::vec4> scattered_eyes(int n, std::uint32_t seed) {
    Random random(seed);
    Buffer<glm::vec4> position, normal;
    for (int i = 0; i < n; ++i) position.push_back(glm::vec4(random.vector(-1, 1), 0)), normal.push_back(glm::vec4(random.vector(-1, 1), 0));
    return radiosity::eyes_of(position, normal);
}

bool same_bits(const Items& a, const Items& b) {
    return a.triangle == b.triangle && std::memcmp(a.seen.data(), b.seen.data(), a.seen.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace

TEST_CASE("hemicube items: drawn triangle by triangle, the same bits as asked of every texel", "[radiosity][HEM 5.6][bits]") {
    const Soup s = soup(120, 5);
    const Buffer<glm::vec4> eyes = scattered_eyes(3, 6);
    for (const int size : {2, 6, 16, 38}) {
        const Items slow = slow_items(s, eyes, size);
        int some = 0, backs = 0, none = 0;
        for (const glm::vec4& t : slow.seen.texels) (t.w > 0 ? some : t.w < 0 ? backs : none) += 1;
        CAPTURE(size, some, backs, none);
        CHECK(some > size * size / 4);
        CHECK(backs > size * size / 4);
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 2}) {
                CAPTURE(isa_name(isa), threads);
                CHECK(same_bits(items_of(s, eyes, size, isa, threads), slow));
            }
    }
}

TEST_CASE("hemicube items: no texel falls between triangles that share an edge", "[radiosity][HEM 4.5.3]") {
    // A fan around points on a sphere: closed, with vertices in directions of texels' centres and elsewhere.
    Random random(9);
    for (const int size : {8, 64}) {
        Soup s;
        const int around = 48, up = 24;
        const auto at = [&](int i, int j) {
            const double phi = 2 * M_PI * double(i % around) / around, theta = M_PI * double(j) / up;
            return glm::vec3(3 * std::sin(theta) * std::cos(phi), 3 * std::sin(theta) * std::sin(phi), 3 * std::cos(theta));
        };
        for (int j = 0; j < up; ++j)
            for (int i = 0; i < around; ++i) {
                s.add(at(i, j), at(i, j + 1), at(i + 1, j + 1));
                s.add(at(i, j), at(i + 1, j + 1), at(i + 1, j));
            }
        for (const Items& items : {items_of(s, scattered_eyes(4, 3), size, best_isa())}) {
            std::size_t inside = 0;
            for (const glm::vec4& t : items.seen.texels) inside += t.w < 0 ? 1 : 0;  // wound to be seen from outside
            CHECK(inside == items.seen.size());
        }
    }
}

TEST_CASE("hemicube items: what a ray through the texel's centre hits, and where", "[radiosity][HEM 5.6][analytic]") {
    const Soup s = soup(60, 15);
    const Buffer<glm::vec4> eyes = scattered_eyes(4, 16);
    const int size = 32;
    const Items items = items_of(s, eyes, size, best_isa());
    std::size_t at = 0, compared = 0, other = 0;
    double worst = 0;
    for (std::size_t cube = 0; cube < 4; ++cube) {
        const glm::dvec3 eye(eyes[4 * cube]), u(eyes[4 * cube + 1]), t(eyes[4 * cube + 2]), n(eyes[4 * cube + 3]);
        const glm::dvec3 forward[5] = {n, u, -u, t, -t};
        for (int row = 0; row < 3 * size; ++row)
            for (int x = 0; x < size; ++x, ++at) {
                const int face = row < size ? 0 : 1 + (row - size) / (size / 2), own = face == 0 ? row : (row - size) % (size / 2);
                const glm::dvec3 up = face == 0 ? u : n, right = glm::cross(forward[face], up);
                const glm::dvec3 d = forward[face] + ((x + 0.5) * 2 / size - 1) * right + (1 - (own + 0.5) * 2 / size) * up;
                int hit = -1;
                double nearest = 1e30, beta = 0, gamma = 0;
                bool edge = false;
                for (std::size_t k = 0; k + 3 < s.triangles.size(); ++k) {
                    const glm::dvec3 a(s.vertices[std::size_t(s.triangles[k].x)]), e1 = glm::dvec3(s.vertices[std::size_t(s.triangles[k].y)]) - a,
                                     e2 = glm::dvec3(s.vertices[std::size_t(s.triangles[k].z)]) - a, o = eye - a;
                    const glm::dvec3 p = glm::cross(d, e2), q = glm::cross(o, e1);
                    const double det = glm::dot(e1, p), b = glm::dot(o, p) / det, c = glm::dot(d, q) / det, z = glm::dot(e2, q) / det;
                    if (!(z > 0)) continue;
                    edge = edge || std::min({std::fabs(b), std::fabs(c), std::fabs(1 - b - c)}) < 1e-3;
                    if (b < 0 || c < 0 || b + c > 1 || z >= nearest) continue;
                    hit = int(k), nearest = z, beta = b, gamma = c;
                }
                if (edge) continue;
                ++compared;
                if (items.triangle[at] != hit) {
                    ++other;
                    continue;
                }
                if (hit < 0) continue;
                worst = std::max({worst, std::fabs(items.seen.texels[at].x - beta), std::fabs(items.seen.texels[at].y - gamma),
                                  std::fabs(items.seen.texels[at].z * nearest - 1)});
            }
    }
    CAPTURE(compared, other, worst);
    CHECK(compared > 6000);
    CHECK(other == 0);
    CHECK(worst < 1e-3);  // slivers: a hundred roundings over the sine of their smallest angle
}

TEST_CASE("hemicube items: eyes of nothing, and what is refused", "[radiosity][bad input]") {
    const Soup s = soup(5, 1);
    const Buffer<glm::vec4> none = radiosity::eyes_of({glm::vec4(0)}, {glm::vec4(0)});
    const Items blind = items_of(s, none, 4, best_isa());
    for (const std::int32_t t : blind.triangle) CHECK(t == -1);
    const Buffer<glm::vec4> eyes = scattered_eyes(1, 1);
    CHECK_THROWS_WITH(radiosity::data_of({&s.vertices, &s.triangles, &eyes, 7}, 0, 1), Catch::Contains("size = 7"));
    CHECK_THROWS_WITH(radiosity::data_of({&s.vertices, &s.triangles, &eyes, 8}, 0, 2), Catch::Contains("hemicubes 0 to 2 of 1"));
    CHECK_THROWS_WITH(radiosity::data_of({nullptr, &s.triangles, &eyes, 8}, 0, 1), Catch::Contains("must be bound"));
}
