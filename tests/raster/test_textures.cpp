// Textures, normal maps, emission textures and alpha: the point of a triangle against values computed by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/bounded.h"
#include "drawing.h"
#include "raster/surfaces.h"
#include "surface_probe.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float no_number = std::numeric_limits<float>::quiet_NaN();
constexpr Wrap wraps[] = {Wrap::repeat, Wrap::mirrored_repeat, Wrap::clamp_to_edge};

std::uint32_t rgba(int r, int g, int b, int a = 255) {
    return std::uint32_t(r) | std::uint32_t(g) << 8 | std::uint32_t(b) << 16 | std::uint32_t(a) << 24;
}

// width x 1 texels that tell their column: red is its low byte, green its high byte.
Texture columns(int width, Filter filter, Wrap wrap) {
    Texture t{"columns", Image<std::uint32_t>(width, 1), false, filter, wrap, wrap, false};
    for (int x = 0; x < width; ++x) t.texels(x, 0) = rgba(x & 255, x >> 8, 0);
    return t;
}

struct Fixture {
    Scene scene;
    Geometry geometry;
    Surfaces surfaces;
    View view;

    SurfaceArgs args() {
        surfaces = prepare(scene, geometry);
        return surface_args(geometry, surfaces, view);
    }
};

vec3<float> lookup(const SurfaceArgs& in, int texture, float u, float v) {
    NoTap tap;
    const TexelQuad<float> q = fetch_quad<float>(in.textures, texture + 1, {u, v}, tap);
    return filter_rgb<float>(in.textures, q, q.curve);
}

// The column that a nearest lookup finds.
int column(const SurfaceArgs& in, int texture, float u) {
    const vec3<float> c = lookup(in, texture, u, 0.5f);
    return int(std::lround(c.x * 255)) + 256 * int(std::lround(c.y * 255));
}

// A triangle in the plane z = 0, facing +z, with corners (0, 0), (1, 0), (0, 1), uv = (x, y) and tangent +x.
void add_plane(Geometry& g, float w, int material) {
    add_triangle(g, at({0, 0, 0}, {0, 0, 1}, 0, 0), at({1, 0, 0}, {0, 0, 1}, 1, 0), at({0, 1, 0}, {0, 0, 1}, 0, 1),
                 material);
    for (int k = 0; k < 3; ++k) g.tangents.push_back({1, 0, 0, w});
}

Surface<float> point(const SurfaceArgs& in, int triangle, float l1 = 0.25f, float l2 = 0.25f) {
    NoTap tap;
    return surface<float>(in, triangle, {l1, l2}, tap);
}

}  // namespace

// The wrapped index by Vulkan 1.3, 16.6.2, for four texels, worked out by hand from i = floor(4 u).
TEST_CASE("textures: nearest takes the texel that the addressing mode names", "[textures]") {
    Fixture f;
    for (Wrap wrap : wraps) f.scene.textures.push_back(columns(4, Filter::nearest, wrap));
    const SurfaceArgs in = f.args();
    struct Row { float u; int repeat, mirrored, clamped; };
    const Row rows[] = {
        {-1.1f, 3, 3, 0}, {-1.0f, 0, 3, 0}, {-0.3f, 2, 1, 0}, {-0.25f, 3, 0, 0}, {-0.1f, 3, 0, 0}, {-0.0f, 0, 0, 0},
        {0.0f, 0, 0, 0}, {0.24f, 0, 0, 0}, {0.25f, 1, 1, 1}, {0.6f, 2, 2, 2}, {0.99f, 3, 3, 3}, {1.0f, 0, 3, 3},
        {1.3f, 1, 2, 3}, {1.99f, 3, 0, 3}, {2.0f, 0, 0, 3}, {2.3f, 1, 1, 3}, {-2.1f, 3, 0, 0}, {1e30f, 0, 0, 3},
        {-1e30f, 0, 0, 0}, {infinity, 0, 0, 0}, {-infinity, 0, 0, 0}, {no_number, 0, 0, 0},
    };
    for (const Row& r : rows) {
        CAPTURE(r.u);
        CHECK(column(in, 0, r.u) == r.repeat);
        CHECK(column(in, 1, r.u) == r.mirrored);
        CHECK(column(in, 2, r.u) == r.clamped);
    }
}

// Two texels, black and white, with centres at u = 1/4 and 3/4: linear between, and across a border what the mode says.
TEST_CASE("textures: bilinear filtering across borders of two texels", "[textures]") {
    Fixture f;
    for (Wrap wrap : wraps) {
        Texture t{"two", Image<std::uint32_t>(2, 1), false, Filter::bilinear, wrap, wrap, false};
        t.texels(0, 0) = rgba(0, 0, 0), t.texels(1, 0) = rgba(255, 255, 255);
        f.scene.textures.push_back(t);
    }
    const SurfaceArgs in = f.args();
    struct Row { float u, repeat, mirrored, clamped; };
    const Row rows[] = {
        {0.25f, 0, 0, 0}, {0.375f, 0.25f, 0.25f, 0.25f}, {0.5f, 0.5f, 0.5f, 0.5f}, {0.75f, 1, 1, 1},
        {0, 0.5f, 0, 0}, {0.125f, 0.25f, 0, 0}, {0.875f, 0.75f, 1, 1}, {1, 0.5f, 1, 1}, {-0.25f, 1, 0, 0},
        {-0.125f, 0.75f, 0, 0}, {1.25f, 0, 1, 1}, {1.5f, 0.5f, 0.5f, 1}, {-0.5f, 0.5f, 0.5f, 0}, {-0.75f, 0, 1, 0},
        {2, 0.5f, 0, 1}, {1e30f, 0.5f, 0, 1}, {-1e30f, 0.5f, 0, 0}, {infinity, 0, 0, 0}, {no_number, 0, 0, 0},
    };
    for (const Row& r : rows) {
        CAPTURE(r.u);
        CHECK(lookup(in, 0, r.u, 0.5f).x == r.repeat);
        CHECK(lookup(in, 1, r.u, 0.5f).x == r.mirrored);
        CHECK(lookup(in, 2, r.u, 0.5f).x == r.clamped);
        // The same along v, through a texture that is turned.
        Fixture turned;
        turned.scene.textures = f.scene.textures;
        for (Texture& t : turned.scene.textures) std::swap(t.texels.width, t.texels.height);
        const SurfaceArgs across = turned.args();
        CHECK(lookup(across, 1, 0.5f, r.u).x == r.mirrored);
    }
}

TEST_CASE("textures: u and v have modes of their own", "[textures]") {
    Fixture f;
    Texture t{"2 x 2", Image<std::uint32_t>(2, 2), false, Filter::nearest, Wrap::mirrored_repeat, Wrap::clamp_to_edge,
              false};
    t.texels.texels = {rgba(10, 0, 0), rgba(20, 0, 0), rgba(30, 0, 0), rgba(40, 0, 0)};
    f.scene.textures.push_back(t);
    const SurfaceArgs in = f.args();
    CHECK(lookup(in, 0, 1.25f, 1.25f).x * 255 == Approx(40));   // u mirrors into column 1, v stays in row 1
    CHECK(lookup(in, 0, -0.75f, -3.0f).x * 255 == Approx(20));  // u mirrors into column 1, v stays in row 0
    CHECK(lookup(in, 0, 1.75f, 7.0f).x * 255 == Approx(30));
}

TEST_CASE("textures: 65535 texels are found at their centres and at the ends", "[textures]") {
    Fixture f;
    for (Wrap wrap : wraps) f.scene.textures.push_back(columns(65535, Filter::nearest, wrap));
    const SurfaceArgs in = f.args();
    for (int x : {0, 1, 255, 32767, 65533, 65534})
        for (int texture : {0, 1, 2}) CHECK(column(in, texture, (float(x) + 0.5f) / 65535.0f) == x);
    CHECK(column(in, 0, -0x1p-20f) == 65534);
    CHECK(column(in, 1, -0x1p-20f) == 0);
    CHECK(column(in, 2, -0x1p-20f) == 0);
    CHECK(column(in, 2, 1e30f) == 65534);
}

// Neighbours in memory are other textures, of another colour: a read outside would show.
TEST_CASE("textures: no coordinate reads outside the image, and a plain image has one colour", "[textures]") {
    Fixture f;
    Random random(5);
    const glm::ivec2 sizes[] = {{1, 1}, {2, 1}, {1, 7}, {5, 3}, {64, 64}, {65535, 1}};
    for (glm::ivec2 size : sizes)
        for (Filter filter : {Filter::bilinear, Filter::nearest})
            for (Wrap wrap_u : wraps)
                for (Wrap wrap_v : wraps) {
                    const int grey = 1 + int(f.scene.textures.size());
                    f.scene.textures.push_back({"plain", Image<std::uint32_t>(size.x, size.y, rgba(grey, grey, grey)),
                                                false, filter, wrap_u, wrap_v, false});
                }
    const SurfaceArgs in = f.args();
    auto coordinate = [&] {
        const std::uint32_t bits = random.next();
        float u;
        std::memcpy(&u, &bits, 4);
        return random.below(2) ? u : float(random.between(-3, 3));
    };
    for (int i = 0; i < 200000; ++i) {
        const int texture = random.below(int(f.scene.textures.size()));
        const float u = coordinate(), v = coordinate();
        CAPTURE(texture, u, v);
        const vec3<float> c = lookup(in, texture, u, v);
        REQUIRE(c.x == f.surfaces.decode[std::size_t(texture + 1)]);
    }
}

// Coordinates that overflow between the corners gave an albedo of NaN.
TEST_CASE("textures: a surface whose coordinates overflow has the colour of texel 0", "[textures]") {
    Fixture f;
    f.scene.textures.push_back(columns(4, Filter::bilinear, Wrap::repeat));
    f.scene.textures[0].texels(0, 0) = rgba(51, 0, 0);
    f.scene.materials.push_back({"m", glm::vec3(0.5f), glm::vec3(0), 0});
    add_triangle(f.geometry, at({0, 0, 0}, {0, 0, 1}, -3e38f, 0), at({1, 0, 0}, {0, 0, 1}, 3e38f, 0),
                 at({0, 1, 0}, {0, 0, 1}, 0, 0));
    const Surface<float> s = point(f.args(), 0);
    CHECK(s.albedo.x == 0.5f * (51 / 255.0f));
    CHECK(s.albedo.y == 0);
}

TEST_CASE("textures: emission is multiplied by its texture, linearly or by the sRGB curve", "[textures]") {
    Fixture f;
    f.scene.textures.push_back({"grey", Image<std::uint32_t>(1, 1, rgba(51, 102, 255)), false, Filter::bilinear});
    f.scene.textures.push_back({"srgb", Image<std::uint32_t>(1, 1, rgba(51, 102, 255)), true, Filter::bilinear});
    for (int texture : {0, 1}) {
        Material m{"lamp", glm::vec3(0.5f), glm::vec3(10, 20, 30)};
        m.emission_texture = texture;
        f.scene.materials.push_back(m);
        add_plane(f.geometry, 1, texture);
    }
    const SurfaceArgs in = f.args();
    const Surface<float> linear = point(in, 0), curved = point(in, 1);
    CHECK(linear.emission.x == Approx(10 * 51 / 255.0));
    CHECK(linear.emission.y == Approx(20 * 102 / 255.0));
    CHECK(linear.emission.z == 30);
    CHECK(curved.emission.x == Approx(10 * std::pow((51 / 255.0 + 0.055) / 1.055, 2.4)));
    CHECK(curved.albedo.x == 0.5f);
}

TEST_CASE("textures: alpha is the material's times the texture's, and linear", "[textures]") {
    Fixture f;
    for (int alpha : {127, 128})
        f.scene.textures.push_back({"a", Image<std::uint32_t>(1, 1, rgba(0, 0, 0, alpha)), true, Filter::bilinear});
    auto material = [&](int texture, float alpha, float cutoff) {
        Material m{"m", glm::vec3(1), glm::vec3(0), texture};
        m.alpha = alpha, m.alpha_cutoff = cutoff;
        f.scene.materials.push_back(m);
        add_plane(f.geometry, 1, int(f.scene.materials.size()) - 1);
    };
    material(0, 1, 0.5f), material(1, 1, 0.5f);                 // 127/255 < 0.5 <= 128/255
    material(1, 0.5f, 0.5f), material(-1, 0.5f, 0.5f);          // 0.25 < 0.5 <= 0.5
    material(0, 0, 0), material(-1, no_number, 0.5f);           // no cutoff; alpha is no number
    const SurfaceArgs in = f.args();
    const bool expected[] = {false, true, false, true, true, false};
    for (int t = 0; t < 6; ++t) {
        CAPTURE(t);
        CHECK(passes_alpha<float>(in, t, {0.25f, 0.25f}) == expected[t]);
        CHECK(f.surfaces.masked[std::size_t(t)] == (t != 4));
    }
    CHECK(f.surfaces.any_masked);
}

// t = 2 c - 1 with c = byte / 255, T = +x, N = +z, B = w y: n = normalize(s t.x, s w t.y, t.z).
TEST_CASE("normal maps: a texel bends the normal in the tangent frame", "[textures]") {
    Fixture f;
    f.scene.textures.push_back({"n", Image<std::uint32_t>(1, 1, rgba(204, 178, 230)), false, Filter::bilinear});
    f.scene.textures.push_back({"n", Image<std::uint32_t>(1, 1, rgba(204, 178, 230)), true, Filter::bilinear});
    const double tx = 2 * 204 / 255.0 - 1, ty = 2 * 178 / 255.0 - 1, tz = 2 * 230 / 255.0 - 1;
    for (float scale : {1.0f, 0.5f, 0.0f})
        for (int texture : {0, 1}) {
            Material m{"m", glm::vec3(1)};
            m.normal_texture = texture, m.normal_scale = scale;
            f.scene.materials.push_back(m);
        }
    for (double w : {1.0, -1.0})
        for (int material = 0; material < 6; ++material)
            for (double eye : {1.0, -1.0}) {  // seen from the front and from the back
                f.geometry = {};
                f.view.eye = {0.2, 0.2, eye};
                add_plane(f.geometry, float(w), material);
                const Surface<float> s = point(f.args(), 0);
                const double scale = f.scene.materials[std::size_t(material)].normal_scale;
                const double x = scale * tx, y = scale * w * ty, length = std::sqrt(x * x + y * y + tz * tz);
                CAPTURE(w, material, eye);
                CHECK(s.normal.x == Approx(eye * x / length).margin(1e-7));
                CHECK(s.normal.y == Approx(eye * y / length).margin(1e-7));
                CHECK(s.normal.z == Approx(eye * tz / length));
            }
}

TEST_CASE("normal maps: no tangents, no bending; no vertex normals, the face's frame", "[textures]") {
    Fixture f;
    f.scene.textures.push_back({"n", Image<std::uint32_t>(1, 1, rgba(204, 178, 230)), false, Filter::bilinear});
    Material m{"m", glm::vec3(1)};
    m.normal_texture = 0;
    f.scene.materials.push_back(m);
    f.view.eye = {0.2, 0.2, 1};
    add_plane(f.geometry, 1, 0);
    const vec3<float> bent = point(f.args(), 0).normal;
    REQUIRE(bent.x > 0.1f);

    SECTION("the geometry has none") { f.geometry.tangents.clear(); }
    SECTION("this mesh has none") { f.geometry.tangents.assign(3, glm::vec4(0)); }
    if (f.geometry.tangents.empty() || f.geometry.tangents[0].x == 0) {
        const vec3<float> n = point(f.args(), 0).normal;
        CHECK((n.x == 0 && n.y == 0 && n.z == 1));
    }
    SECTION("vertices without normals") {
        // The edges' product, scaled by the longer edge, has length 1 for the first and 1/4 for the second.
        const auto corners = f.geometry.vertices;
        for (const glm::vec3 stretch : {glm::vec3(100, 100, 1), glm::vec3(100, 25, 1)}) {
            for (std::size_t i = 0; i < corners.size(); ++i)
                f.geometry.vertices[i] = at(corners[i].position * stretch, {0, 0, 0}, corners[i].u, corners[i].v);
            const vec3<float> n = point(f.args(), 0).normal;
            CAPTURE(stretch.y);
            CHECK(n.x == Approx(bent.x));
            CHECK(n.y == Approx(bent.y));
            CHECK(n.z == Approx(bent.z));
        }
    }
}

TEST_CASE("surfaces: a material that names a texture out of range is refused", "[textures]") {
    Fixture f;
    f.scene.materials.push_back({"brick"});
    f.scene.materials[0].emission_texture = 3;
    CHECK_THROWS_WITH(f.args(), Catch::Contains("\"brick\": emission_texture = 3"));
    f.scene.materials[0].emission_texture = -1, f.scene.materials[0].normal_texture = -2;
    CHECK_THROWS_WITH(f.args(), Catch::Contains("\"brick\": normal_texture = -2"));
}

TEST_CASE("surfaces: every instruction set finds the same bits", "[textures]") {
    Fixture f;
    Random random(31);
    for (int i = 0; i < 12; ++i) {
        Image<std::uint32_t> texels(1 + random.below(9), 1 + random.below(9));
        for (std::uint32_t& x : texels.texels) x = random.next();
        f.scene.textures.push_back({"noise", texels, i % 2 == 0, i % 3 ? Filter::bilinear : Filter::nearest,
                                    wraps[random.below(3)], wraps[random.below(3)], false});
    }
    for (int i = 0; i < 20; ++i) {
        Material m{"m", random.vector(0, 1), random.vector(0, 9)};
        m.texture = random.below(13) - 1, m.emission_texture = random.below(13) - 1;
        m.normal_texture = random.below(13) - 1, m.normal_scale = float(random.between(0, 2));
        m.alpha = float(random.uniform()), m.alpha_cutoff = float(random.below(2) * 0.3);
        f.scene.materials.push_back(m);
    }
    for (int i = 0; i < 400; ++i) {
        auto corner = [&] {
            const float far = random.below(40) == 0 ? 3e38f : 3.0f;
            return at(random.vector(-1, 1), random.below(5) ? random.vector(-1, 1) : glm::vec3(0),
                      float(random.between(-1, 1)) * far, float(random.between(-2, 2)));
        };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(f.geometry, a, b, c, i % 3 ? random.below(20) : 7);
        for (int k = 0; k < 3; ++k)
            f.geometry.tangents.push_back(glm::vec4(random.vector(-1, 1), random.below(2) ? 1 : -1));
    }
    f.view.eye = {0, 0, 3};
    SurfaceProbe probe{f.args(), 4096, nullptr, nullptr, nullptr};
    std::vector<std::int32_t> triangle;
    std::vector<float> l;
    for (int i = 0; i < probe.count; ++i) {
        triangle.push_back(i % 64 < 32 ? random.below(400) : (i / 64) % 400);  // mixed packets, and packets of one
        l.push_back(float(random.uniform() * 0.5)), l.push_back(float(random.uniform() * 0.5));
    }
    probe.triangle = triangle.data(), probe.barycentrics = l.data();
    std::vector<float> first;
    for (Isa isa : supported_isas()) {
        std::vector<float> out(std::size_t(probe.count) * 16);
        probe.out = out.data();
        dispatch(isa, [&](auto set) { probe_surfaces<set()>(probe); });
        if (first.empty()) first = out;
        CAPTURE(isa_name(isa));
        REQUIRE(std::memcmp(out.data(), first.data(), 4 * out.size()) == 0);
    }
    int drawn = 0;
    for (int i = 0; i < probe.count; ++i) drawn += first[std::size_t(16 * i + 15)] == 1;
    CHECK((drawn > probe.count / 3 && drawn < probe.count));
    for (float x : first) REQUIRE(std::isfinite(x));
}
