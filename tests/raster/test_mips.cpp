// Levels of detail: how they are made, and which is read, against values worked out by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/camera.h"
#include "drawing.h"
#include "raster/gbuffer.h"
#include "raster/mips.h"
#include "raster/surfaces.h"
#include "surface_probe.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

using Texels = Image<std::uint32_t>;

std::uint32_t grey(int v, int a = 255) {
    return std::uint32_t(v) | std::uint32_t(v) << 8 | std::uint32_t(v) << 16 | std::uint32_t(a) << 24;
}
int red(std::uint32_t texel) { return int(texel & 255); }

Texture linear(const Texels& texels) { return {"linear", texels, false, Filter::bilinear, {}, {}, true}; }
Texture srgb(const Texels& texels) { return {"srgb", texels, true, Filter::bilinear, {}, {}, true}; }

Texels noise(int width, int height, unsigned seed) {
    Random random(seed);
    Texels out(width, height);
    for (std::uint32_t& t : out.texels) t = random.next();
    return out;
}
Texels checkerboard(int side) {
    Texels out(side, side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) out(x, y) = grey((x + y) % 2 ? 255 : 0);
    return out;
}

// A plane of one material through (0, 0, -distance), of 2 size x 2 size metres, u and v from 0 to `repeats` along its
// sides, turned about the y axis so that cos is the cosine between its normal and +z.
void add_wall(Geometry& g, double distance, double cos, float size, float repeats) {
    const double sin = std::sqrt(1 - cos * cos);
    auto corner = [&](float x, float y) {
        const glm::vec3 p(float(x * size * cos), y * size, float(-distance + x * size * sin));
        return at(p, glm::vec3(float(-sin), 0, float(cos)), (x + 1) / 2 * repeats, (1 - y) / 2 * repeats);
    };
    const Vertex a = corner(-1, -1), b = corner(1, -1), c = corner(1, 1), d = corner(-1, 1);
    add_triangle(g, a, b, c, 0), add_triangle(g, a, c, d, 0);
}

struct Wall {
    Scene scene;
    Geometry geometry;
    Surfaces surfaces;

    Wall(const Texture& texture, double distance, double cos, float size, float repeats) {
        scene.textures.push_back(texture);
        scene.materials.push_back({"m", glm::vec3(1), glm::vec3(0), 0});
        add_wall(geometry, distance, cos, size, repeats);
        surfaces = prepare(scene, geometry);
    }
};

// f = 90 degrees: a pixel of a frame of 64 x 64 is 2/64 wide at depth 1.
View square_view() {
    Camera camera;
    camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1}, camera.fov_y_deg = 90;
    return make_view(camera, 1);
}

// level + blend at the wall's centre, in the middle between corners 0 and 2 of triangle 0.
double level_at_centre(const Wall& wall, const View& view, glm::ivec2 size) {
    Recorder taps;
    surface<float>(surface_args(wall.geometry, wall.surfaces, view, size), 0, vec2<float>(0.0f, 0.5f), taps);
    double level = std::nan("");
    for (const TapValue& t : taps.values) {
        if (t.name == "level") level = t.value[0];
        if (t.name == "level_blend") level += t.value[0];
    }
    return level;
}

}  // namespace

TEST_CASE("mips: a plain image is plain at every level, of any size", "[mips]") {
    const Buffer<float> decode = decode_table();
    for (glm::ivec2 size : {glm::ivec2(64, 64), {63, 63}, {5, 1}, {1, 7}, {1023, 3}, {2, 1}, {100, 30}})
        for (int code : {0, 1, 2, 100, 187, 254, 255}) {
            const std::uint32_t texel = grey(code, 255 - code);
            const Texels plain(size.x, size.y, texel);
            for (const Texture& texture : {linear(plain), srgb(plain)}) {
                glm::ivec2 expected = size;
                for (const Texels& level : smaller_levels(texture, decode)) {
                    expected = glm::max(expected / 2, glm::ivec2(1));
                    REQUIRE(glm::ivec2(level.width, level.height) == expected);
                    for (std::uint32_t t : level.texels) REQUIRE(t == texel);
                }
                CHECK(expected == glm::ivec2(1));
            }
        }
    CHECK(smaller_levels(linear(Texels(1, 1, 7)), decode).empty());
}

// Weights by area. 2: (1 1) / 2. 3: (1 1 1) / 3. 5: (2 2 1) / 5 and (1 2 2) / 5.
TEST_CASE("mips: a texel is the mean of its part of the level before", "[mips]") {
    const Buffer<float> decode = decode_table();
    auto row = [&](std::initializer_list<int> codes) {
        Texels t(int(codes.size()), 1);
        int x = 0;
        for (int c : codes) t(x++, 0) = grey(c);
        return t;
    };
    CHECK(red(smaller_levels(linear(row({10, 20})), decode)[0](0, 0)) == 15);
    CHECK(red(smaller_levels(linear(row({10, 20, 60})), decode)[0](0, 0)) == 30);
    const Texels five = smaller_levels(linear(row({0, 10, 100, 20, 30})), decode)[0];
    REQUIRE(five.width == 2);
    CHECK(red(five(0, 0)) == 24);  // (0 + 20 + 100) / 5
    CHECK(red(five(1, 0)) == 40);  // (100 + 40 + 60) / 5
    // Half of white is the sRGB code 188: 0.50289 is nearer to 0.5 than 0.49693 of code 187 (IEC 61966-2-1).
    CHECK(smaller_levels(srgb(row({0, 255})), decode)[0](0, 0) == grey(188));
    // Alpha has no curve.
    Texels alpha(2, 1);
    alpha(0, 0) = grey(0, 0), alpha(1, 0) = grey(0, 100);
    CHECK(smaller_levels(srgb(alpha), decode)[0](0, 0) == grey(0, 50));
}

// Each level is rounded once: half a code, and not half a code for each level above it.
TEST_CASE("mips: the last level is the mean of the image", "[mips]") {
    const Buffer<float> decode = decode_table();
    for (glm::ivec2 size : {glm::ivec2(64, 64), {65, 31}, {1, 255}, {37, 64}}) {
        const Texels image = noise(size.x, size.y, 9);
        double mean = 0;
        for (std::uint32_t t : image.texels) mean += red(t);
        mean /= double(image.size());
        const std::uint32_t last = smaller_levels(linear(image), decode).back()(0, 0);
        CAPTURE(size.x, size.y);
        CHECK(std::abs(red(last) - mean) <= 0.5 + 1e-4);
    }
}

// A pixel is p d wide on a wall that faces the viewer at d, p = 2/64, and holds p d T texels a side, with T texels a
// metre; a wall turned by cos holds 1 / cos times the area. The level is r's power of two and r / 2^level - 1.
TEST_CASE("mips: the level of a plane at a distance", "[mips]") {
    const Texture texture = linear(noise(64, 64, 3));
    struct Row { double distance, cos; float repeats; double ratio; };
    const Row rows[] = {
        {4, 1, 2, 0.5}, {8, 1, 2, 1}, {16, 1, 2, 2}, {24, 1, 2, 3}, {30, 1, 2, 3.75}, {32, 1, 2, 4}, {48, 1, 2, 6},
        {16, 1, 16, 16},
        {16, 0.25, 2, 4},            // a quarter of the cosine: four times the area, twice the ratio
        {16, 0.5, 2, 2.8284271247},  // 2 sqrt(2)
    };
    for (const Row& r : rows) {
        // The wall is 32 m wide: T = 64 repeats / 32.
        const Wall wall(texture, r.distance, r.cos, 16, r.repeats);
        const double ratio = 2.0 / 64 * r.distance * (64 * r.repeats / 32) / std::sqrt(r.cos);
        CAPTURE(r.distance, r.cos, r.repeats);
        REQUIRE(ratio == Approx(r.ratio));
        const double power = std::floor(std::log2(std::max(ratio, 1.0) + 1e-9));
        const double expected = std::max(0.0, power + ratio / std::exp2(power) - 1);
        CHECK(level_at_centre(wall, square_view(), {64, 64}) == Approx(expected).margin(1e-5));
        CHECK(std::log2(std::max(ratio, 1.0)) - expected <= 0.0861);
    }
    // The last level, beyond which there is no other: 64 x 64 has six.
    CHECK(level_at_centre(Wall(texture, 1000, 1, 16, 1000), square_view(), {64, 64}) == 6);
    // A frame without a size, and edge-on.
    CHECK(std::isnan(level_at_centre(Wall(texture, 64, 1, 16, 2), square_view(), {0, 0})));
    const Wall edge(texture, 0, 1, 16, 2);
    const double level = level_at_centre(edge, square_view(), {64, 64});
    CHECK((level == 0 || level == 6));
}

// Against finite differences of where the rays of a pixel's corners meet the plane.
TEST_CASE("mips: the pixel's area off the axis is that between the rays of its corners", "[mips]") {
    const View view = square_view();
    const glm::ivec2 size(64, 64);
    const Wall wall(linear(noise(64, 64, 3)), 10, 0.7, 20, 20);
    const SurfaceArgs in = surface_args(wall.geometry, wall.surfaces, view, size);
    const glm::dvec3 normal(-std::sqrt(1 - 0.49), 0, 0.7), on(0, 0, -10);
    auto hit = [&](double px, double py) {
        const glm::dvec3 ray(px / 32 - 1, 1 - py / 32, -1);
        return ray * (glm::dot(on, normal) / glm::dot(ray, normal));
    };
    for (glm::dvec2 pixel : {glm::dvec2(32, 32), {5.5, 60.5}, {50.5, 3.5}, {20.5, 40.5}}) {
        const glm::dvec3 x = hit(pixel.x, pixel.y);
        const double h = 1e-3;
        const glm::dvec3 dx = (hit(pixel.x + h, pixel.y) - hit(pixel.x - h, pixel.y)) / (2 * h);
        const glm::dvec3 dy = (hit(pixel.x, pixel.y + h) - hit(pixel.x, pixel.y - h)) / (2 * h);
        // 20 repeats over 40 m: half a unit of u a metre.
        const double expected = 0.25 * glm::length(glm::cross(dx, dy));
        const glm::vec3 a = wall.geometry.vertices[0].position, b = wall.geometry.vertices[1].position,
                        c = wall.geometry.vertices[2].position;
        const glm::vec3 e1 = b - a, e2 = c - a;
        const float area = pixel_uv_area<float>(in, {20, 0}, {20, -20}, e1, e2, -a, glm::vec3(x));
        CAPTURE(pixel.x, pixel.y);
        CHECK(area == Approx(expected).epsilon(1e-4));
    }
}

// One image that all three textures of a material are: emission and albedo have its colour c, and the map bends the
// wall's frame x, y, z to normalize(2 c - 1). Where albedo reads is checked above.
TEST_CASE("mips: emission and normal maps read the level that the base colour does", "[mips]") {
    Wall wall(linear(noise(64, 64, 12)), 24, 1, 16, 5.3f);
    Material& m = wall.scene.materials[0];
    m.emission = glm::vec3(1), m.texture = m.emission_texture = m.normal_texture = 0;
    wall.geometry.tangents.assign(wall.geometry.vertices.size(), glm::vec4(1, 0, 0, 1));
    wall.surfaces = prepare(wall.scene, wall.geometry);
    REQUIRE(level_at_centre(wall, square_view(), {64, 64}) > 2.5);
    Random random(5);
    NoTap tap;
    double furthest = 0;
    for (int i = 0; i < 100; ++i) {
        const vec2<float> l(float(random.between(0, 0.5)), float(random.between(0, 0.5)));
        const auto s = surface<float>(surface_args(wall.geometry, wall.surfaces, square_view(), {64, 64}), 0, l, tap);
        const auto level0 = surface<float>(surface_args(wall.geometry, wall.surfaces, square_view()), 0, l, tap);
        REQUIRE((s.emission.x == s.albedo.x && s.emission.y == s.albedo.y && s.emission.z == s.albedo.z));
        const glm::dvec3 bent = 2.0 * glm::dvec3(s.albedo.x, s.albedo.y, s.albedo.z) - 1.0;
        const double length = std::sqrt(dot(bent, bent));
        REQUIRE(s.normal.x == Approx(bent.x / length).margin(1e-5));
        REQUIRE(s.normal.y == Approx(bent.y / length).margin(1e-5));
        REQUIRE(s.normal.z == Approx(bent.z / length).margin(1e-5));
        furthest = std::max(furthest, double(std::abs(level0.albedo.x - s.albedo.x)));
    }
    CHECK(furthest > 0.2);
}

TEST_CASE("mips: a parallel projection chooses a level by the slant alone", "[mips]") {
    View view;
    view.orthographic = true;
    view.view_to_clip = orthographic_matrix({.half_width = 16, .half_height = 16, .near = 0, .far = 100});
    const Texture texture = linear(noise(64, 64, 3));
    for (double distance : {1.0, 50.0}) {
        // 4 texels a metre, half a metre a pixel.
        CHECK(level_at_centre(Wall(texture, distance, 1, 16, 2), view, {64, 64}) == Approx(1));
        CHECK(level_at_centre(Wall(texture, distance, 0.25, 16, 2), view, {64, 64}) == Approx(2));
    }
}

TEST_CASE("mips: a checkerboard far away has its linear mean; without mips it has black and white", "[mips]") {
    Texture texture = srgb(checkerboard(64));
    for (bool mips : {true, false}) {
        texture.mips = mips;
        const Wall wall(texture, 40, 1, 80, 97.3f);
        GBuffer out;
        draw_gbuffer(wall.geometry, wall.surfaces, square_view(), {64, 64}, Layout::fp32, {}, out);
        float least = 1, most = 0;
        for (const glm::vec4& a : out.albedo.texels) least = std::min(least, a.x), most = std::max(most, a.x);
        const float mean = wall.surfaces.decode[256 + 188];
        CAPTURE(mips, least, most);
        if (mips) CHECK((least == mean && most == mean));
        if (!mips) CHECK((least < 0.3f && most > 0.7f));
    }
}

TEST_CASE("mips: textures that ask for none read level 0, beside others that do", "[mips]") {
    Texture plain = linear(noise(16, 16, 4)), fine = linear(noise(16, 16, 5));
    plain.mips = false;
    Scene scene;
    scene.textures = {fine, plain};
    scene.materials = {{"fine", glm::vec3(1), glm::vec3(0), 0}, {"plain", glm::vec3(1), glm::vec3(0), 1}};
    Geometry g;
    add_wall(g, 500, 1, 16, 8);
    g.material = {1, 1};
    const Surfaces s = prepare(scene, g);
    CHECK(s.materials[8] == 1);
    CHECK(s.materials[16 + 8] == 6);  // fine has levels of 16, 8, 4, 2, 1
    NoTap tap;
    const vec2<float> l(0.3f, 0.4f);
    const auto with = surface<float>(surface_args(g, s, square_view(), {64, 64}), 0, l, tap).albedo;
    const auto without = surface<float>(surface_args(g, s, square_view()), 0, l, tap).albedo;
    CHECK((with.x == without.x && with.y == without.y && with.z == without.z));
}

TEST_CASE("mips: levels are copied where the textures are equal, and made anew where anything of them is not", "[mips]") {
    Scene scene;
    scene.textures = {srgb(noise(9, 6, 1)), linear(noise(5, 5, 2))};
    scene.materials = {{"a", glm::vec3(1), glm::vec3(0), 0}, {"b", glm::vec3(1), glm::vec3(0), 1}};
    Geometry g;
    add_wall(g, 500, 1, 16, 8);
    // A mark on the last texel of the last level shows what was copied.
    Surfaces before = prepare(scene, g);
    before.texels.back() ^= 0x010101;
    const auto marked = before.texels;
    scene.materials[1].emission = glm::vec3(2), scene.materials[0].texture = 1;
    const Surfaces repainted = prepare(scene, g, &before), fresh = prepare(scene, g);
    CHECK(repainted.texels == marked);
    CHECK(repainted.texels != fresh.texels);
    CHECK(repainted.textures == fresh.textures);
    CHECK(repainted.materials == fresh.materials);
    CHECK(repainted.any_levels == fresh.any_levels);

    using Change = void (*)(std::vector<Texture>&);
    const Change changes[] = {[](auto& t) { t[1].texels(4, 4) ^= 1; },        [](auto& t) { t[0].srgb = false; },
                              [](auto& t) { t[0].filter = Filter::nearest; }, [](auto& t) { t[1].wrap_u = Wrap::clamp_to_edge; },
                              [](auto& t) { t[1].wrap_v = Wrap::clamp_to_edge; },     [](auto& t) { t[0].mips = false; },
                              [](auto& t) { std::swap(t[0], t[1]); },         [](auto& t) { t.push_back(t[0]); }};
    for (const Change& change : changes) {
        CAPTURE(&change - changes);
        Scene other = scene;
        change(other.textures);
        const Surfaces now = prepare(other, g, &before), made = prepare(other, g);
        CHECK(now.texels == made.texels);
        CHECK(now.textures == made.textures);
        CHECK(now.materials == made.materials);
        CHECK(now.any_levels == made.any_levels);
    }
}

TEST_CASE("mips: every instruction set finds the same bits", "[mips]") {
    Scene scene;
    Geometry g;
    Random random(77);
    for (int i = 0; i < 6; ++i) {
        scene.textures.push_back(srgb(noise(1 + random.below(40), 1 + random.below(40), unsigned(i))));
        scene.textures.back().srgb = i % 2 == 0, scene.textures.back().mips = i != 3;
        scene.textures.back().filter = i == 4 ? Filter::nearest : Filter::bilinear;
    }
    for (int i = 0; i < 12; ++i) {
        Material m{"m", random.vector(0, 1), random.vector(0, 9)};
        m.texture = random.below(7) - 1, m.emission_texture = random.below(7) - 1;
        m.normal_texture = random.below(7) - 1;
        scene.materials.push_back(m);
    }
    for (int i = 0; i < 300; ++i) {
        const float spread = std::exp2(float(random.between(-6, 6)));
        auto corner = [&] {
            return at(random.vector(-1, 1) + glm::vec3(0, 0, -2), random.vector(-1, 1),
                      float(random.between(-1, 1)) * spread, float(random.between(-1, 1)) * spread);
        };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(g, a, b, i % 50 ? c : b, i % 12);
        for (int k = 0; k < 3; ++k) g.tangents.push_back(glm::vec4(random.vector(-1, 1), 1));
    }
    const Surfaces surfaces = prepare(scene, g);
    SurfaceProbe probe{surface_args(g, surfaces, square_view(), {64, 64}), 4096, nullptr, nullptr, nullptr};
    std::vector<std::int32_t> triangle;
    std::vector<float> l;
    for (int i = 0; i < probe.count; ++i) {
        triangle.push_back(i % 64 < 32 ? random.below(300) : (i / 64) % 300);
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
    for (float x : first) REQUIRE(std::isfinite(x));
}
