// The fast visibility pass against the slow one (raster/visibility_reference.h): the same bits, whatever the instruction
// set, the number of threads and the size of the frame.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "drawing.h"
#include "raster/surfaces.h"
#include "raster/visibility_reference.h"
#include "raster/workspace.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

template <class T>
std::size_t different(const Image<T>& a, const Image<T>& b) {
    if (a.width != b.width || a.height != b.height) return SIZE_MAX;
    std::size_t n = 0;
    for (std::size_t i = 0; i < a.size(); ++i) n += std::memcmp(&a.texels[i], &b.texels[i], sizeof(T)) != 0;
    return n;
}

RunOptions with(Isa isa, int threads) {
    RunOptions options;
    options.isa = isa;
    options.threads = threads;
    return options;
}

// Every instruction set with 1, 2 and 3 threads, into memory that holds what was drawn before.
void check_all(const Geometry& g, const Surfaces* surfaces, const Buffer<glm::vec4>& clip, bool reversed,
               glm::ivec2 size, VisibilityBuffer& out, Workspace& workspace) {
    const VisibilityBuffer truth = reference_visibility(g, surfaces, clip, reversed, size, 0, size.y, with({}, 1));
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            draw_visibility(g, surfaces, clip, reversed, size, with(isa, threads), out, &workspace);
            CAPTURE(isa_name(isa), threads, reversed, size.x, size.y);
            REQUIRE(different(out.triangle, truth.triangle) == 0);
            REQUIRE(different(out.depth, truth.depth) == 0);
            REQUIRE(different(out.barycentrics, truth.barycentrics) == 0);
        }
}

// Clip positions of random triangles of every kind that has a path of its own.
struct Soup {
    Geometry geometry;
    Buffer<glm::vec4> clip;

    void add(const glm::vec4& a, const glm::vec4& b, const glm::vec4& c, int material = 0) {
        add_triangle(geometry, at(glm::vec3(a)), at(glm::vec3(b)), at(glm::vec3(c)), material);
        clip.insert(clip.end(), {a, b, c});
    }
};

glm::vec4 random_point(Random& random, double extent, double w) {
    const double z = random.below(8) == 0 ? random.below(5) / 4.0 : random.uniform();
    return glm::vec4(random.vector(-extent, extent), 1) * float(w) * glm::vec4(1, 1, 0, 1) +
           glm::vec4(0, 0, float(z * w), 0);
}

Soup random_soup(int n, glm::ivec2 size, Random& random) {
    Soup soup;
    const double pixel = 2.0 / std::max(size.x, size.y);
    for (int i = 0; i < n; ++i) {
        const double w = random.below(3) ? 1 : random.between(0.01, 40);
        glm::vec4 a = random_point(random, 1.1, w), b = random_point(random, 1.1, w), c = random_point(random, 1.1, w);
        auto near = [&](double distance) {
            b = a + float(distance * w) * glm::vec4(random.vector(-1, 1), 0) * glm::vec4(1, 1, 0, 0);
            c = a + float(distance * w) * glm::vec4(random.vector(-1, 1), 0) * glm::vec4(1, 1, 0, 0);
        };
        // Corners on centres and half-way between them: ties.
        const glm::ivec2 corner{random.below(size.x), random.below(size.y)};
        auto tie = [&](int extent) {
            const double x = corner.x + random.below(2 * extent + 1) / 2.0;
            const double y = corner.y + random.below(2 * extent + 1) / 2.0;
            return glm::vec4(float(2 * x / size.x - 1), float(2 * y / size.y - 1), float(random.uniform()), 1);
        };
        switch (random.below(15)) {
            case 0: case 1: case 2: near(pixel * random.between(0.2, 2)); break;   // between centres and around them
            case 3: case 4: near(pixel * random.between(2, 60)); break;
            case 5: near(pixel * random.between(60, 300)); break;
            case 6: c = a + (b - a) * float(random.uniform()) + glm::vec4(random.vector(-1, 1) * float(pixel / 100), 0);
                c.z = std::clamp(c.z, 0.0f, c.w); break;                           // a sliver
            case 7: c = random.below(2) ? a : a + (b - a) * 0.5f; break;          // no area
            case 8: b = random_point(random, random.between(2, 1000), w); break;   // beyond the guard band
            case 9: b.w = -b.w, c.w = random.below(2) ? 0.0f : c.w; break;         // at and behind the viewer
            case 10: b.z = -b.z, c.z *= float(random.between(1, 3)); break;        // cut by the near and far planes
            case 11: case 12: a = tie(2), b = tie(2), c = tie(2); break;
            case 13: a = tie(30), b = tie(30), c = tie(30); break;
            case 14: a.z = b.z = c.z = -0.0f; break;                               // as large, on the near plane
            default: break;                                                        // as large as the frame
        }
        soup.add(a, b, c);
        // The same surface again, in another order of corners: equal depths, or nearly.
        if (random.below(6) == 0) soup.add(b, c, a);
    }
    return soup;
}

}  // namespace

TEST_CASE("visibility: the fast pass equals the reference on random soups", "[raster][bits]") {
    const struct {
        glm::ivec2 size;
        int seeds, triangles;
    } cases[] = {{{1, 1}, 10, 60},     {{2, 3}, 6, 100},      {{16, 16}, 6, 200},   {{17, 63}, 6, 300},
                 {{64, 64}, 6, 500},   {{65, 129}, 4, 800},   {{333, 1}, 6, 200},   {{1, 4097}, 2, 100},
                 {{16384, 1}, 2, 100}, {{257, 255}, 2, 1500}, {{1000, 562}, 1, 1500}, {{32767, 3}, 1, 60}};
    VisibilityBuffer out;
    Workspace workspace;
    for (const auto& c : cases)
        for (int seed = 0; seed < c.seeds; ++seed) {
            Random random(std::uint64_t(seed * 77 + c.size.x));
            const Soup soup = random_soup(c.triangles, c.size, random);
            CAPTURE(seed);
            for (bool reversed : {false, true})
                check_all(soup.geometry, nullptr, soup.clip, reversed, c.size, out, workspace);
        }
}

TEST_CASE("visibility: a fine mesh of shared vertices and many chunks equals the reference", "[raster][bits]") {
    // A bumpy grid of 180 x 180 x 2 triangles, seen at an angle, drawn twice: the second, equal in depth, is not seen.
    Geometry g;
    const int n = 180;
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) {
            const float u = 4.0f * x / n - 2, v = 4.0f * y / n - 2;
            g.vertices.push_back(at({u, 0.1f * float((x * 7 + y * 13) % 5), v}));
        }
    for (int copy = 0; copy < 2; ++copy)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const std::uint32_t a = std::uint32_t(y * (n + 1) + x), b = a + n + 1;
                g.triangles.push_back({a, a + 1, b});
                g.triangles.push_back({a + 1, b + 1, b});
            }
    g.material.resize(g.triangles.size());
    g.object.resize(g.triangles.size());
    Camera camera;
    camera.position = {0.3, 1.2, 1.7}, camera.look_at = {0, 0, 0};
    camera.near = 0.4, camera.far = 30;
    VisibilityBuffer out;
    Workspace workspace;
    for (bool reversed : {false, true})
        for (glm::ivec2 size : {glm::ivec2(300, 211), glm::ivec2(96, 97)}) {
            camera.reversed_z = reversed;
            const View view = make_view(camera, double(size.x) / size.y);
            check_all(g, nullptr, clip_positions(g, view, 1), reversed, size, out, workspace);
            // From a view, the kernel transforms the vertices itself.
            const VisibilityBuffer truth = reference_visibility(g, nullptr, view, size, 0, size.y, with({}, 1));
            for (Isa isa : supported_isas()) {
                draw_visibility(g, nullptr, view, size, with(isa, 2), out, &workspace);
                CAPTURE(isa_name(isa), reversed);
                REQUIRE(different(out.triangle, truth.triangle) == 0);
                REQUIRE(different(out.depth, truth.depth) == 0);
                REQUIRE(different(out.barycentrics, truth.barycentrics) == 0);
            }
            REQUIRE(*std::max_element(out.triangle.texels.begin(), out.triangle.texels.end()) < 2 * n * n);
            REQUIRE(*std::max_element(out.triangle.texels.begin(), out.triangle.texels.end()) > n * n);
        }
}

TEST_CASE("visibility: layers of a chunk each that cut through one another equal the reference", "[raster][bits]") {
    // Six sheets of 4096 triangles, one tile; sheet k slopes from 0.3 + 0.005 k by 0.008, every other one the other way,
    // and the farthest is drawn first: neighbours cut, and those further apart hide one another.
    Soup soup;
    for (int k = 5; k >= 0; --k) {
        auto corner = [&](int x, int y) {
            const float u = float(x) / 64, v = float(y) / 32, slope = k % 2 ? 1 - u : u;
            return glm::vec4(2.2f * u - 1.1f, 2.2f * v - 1.1f, 0.3f + 0.005f * float(k) + 0.008f * slope, 1);
        };
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 64; ++x) {
                soup.add(corner(x, y), corner(x + 1, y), corner(x, y + 1));
                soup.add(corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
            }
    }
    VisibilityBuffer out;
    Workspace workspace;
    for (bool reversed : {false, true}) {
        check_all(soup.geometry, nullptr, soup.clip, reversed, {64, 64}, out, workspace);
        bool seen[6] = {};
        for (std::int32_t t : out.triangle.texels) seen[t / 4096] = true;
        for (int i = 0; i < 6; ++i) CHECK(seen[i] == (reversed ? i <= 1 : i >= 4));
    }
}

TEST_CASE("visibility: frames whose tiles are larger than 64 pixels equal the reference", "[raster][bits]") {
    // 4096 x 4100 pixels are 64 x 65 tiles of 64, more than the 4096 that there may be.
    const glm::ivec2 size{4096, 4100};
    Random random(5);
    const Soup soup = random_soup(400, size, random);
    const VisibilityBuffer truth = reference_visibility(soup.geometry, nullptr, soup.clip, false, size, 0, size.y, {});
    VisibilityBuffer out;
    draw_visibility(soup.geometry, nullptr, soup.clip, false, size, {}, out);
    CHECK(different(out.triangle, truth.triangle) == 0);
    CHECK(different(out.depth, truth.depth) == 0);
    CHECK(different(out.barycentrics, truth.barycentrics) == 0);
}

TEST_CASE("visibility: masked triangles equal the reference", "[raster][bits][alpha]") {
    // A texture of 8 x 8 random alphas; of three materials one is masked, one is masked wholly, one is not.
    Scene scene;
    Random random(11);
    Texture leaves;
    leaves.texels = Image<std::uint32_t>(8, 8);
    for (std::uint32_t& texel : leaves.texels.texels) texel = random.next();
    scene.textures = {leaves};
    scene.materials.resize(3);
    scene.materials[0].texture = scene.materials[1].texture = scene.materials[2].texture = 0;
    scene.materials[1].alpha_cutoff = 0.5f;
    scene.materials[2].alpha_cutoff = 1.5f;
    VisibilityBuffer out;
    Workspace workspace;
    for (int seed = 0; seed < 6; ++seed) {
        const glm::ivec2 size{150, 83};
        Soup soup = random_soup(500, size, random);
        for (Vertex& v : soup.geometry.vertices)
            v.u = float(random.uniform() * 3), v.v = float(random.uniform() * 3), v.normal = {0, 0, 1};
        for (std::int32_t& m : soup.geometry.material) m = random.below(3);
        const Surfaces surfaces = prepare(scene, soup.geometry);
        for (bool reversed : {false, true}) {
            check_all(soup.geometry, &surfaces, soup.clip, reversed, size, out, workspace);
            int of_material[3] = {0, 0, 0};
            for (std::int32_t t : out.triangle.texels)
                if (t >= 0) ++of_material[soup.geometry.material[std::size_t(t)]];
            CHECK(of_material[0] > 100);
            CHECK(of_material[1] > 100);
            CHECK(of_material[2] == 0);
        }
    }
}

TEST_CASE("visibility: the first vertex that is not finite is named, whatever the set", "[raster]") {
    Random random(2);
    Soup soup = random_soup(3000, {64, 64}, random);
    soup.clip[8000].w = INFINITY, soup.clip[5003].x = NAN, soup.clip[5004].y = NAN;
    VisibilityBuffer out;
    for (Isa isa : supported_isas())
        for (int threads : {1, 3})
            CHECK_THROWS_WITH(
                draw_visibility(soup.geometry, nullptr, soup.clip, false, {64, 64}, with(isa, threads), out),
                Catch::Contains("vertex 5003:"));
}
