// Depth peeling: layers behind layers (ISR ch. 6; Everitt 2001). What a pixel's layers must be is known without it: every
// triangle drawn alone gives its depth there, and the layers are these depths in order.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>

#include "core/camera.h"
#include "core/error.h"
#include "drawing.h"
#include "raster/bindings.h"
#include "raster/device_raster.h"
#include "raster/gbuffer.h"
#include "raster/visibility_reference.h"
#include "raster/workspace.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

template <class T>
bool same(const Image<T>& a, const Image<T>& b) {
    return a.width == b.width && a.height == b.height &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

RunOptions with(Isa isa, int threads) {
    RunOptions options;
    options.isa = isa;
    options.threads = threads;
    return options;
}

// A quad across the whole of clip space, two triangles.
void add_quad(Geometry& g, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d, int object) {
    const glm::vec3 n(0, 0, -1);
    add_triangle(g, at(a, n), at(b, n), at(c, n), 0, object);
    add_triangle(g, at(a, n), at(c, n), at(d, n), 0, object);
}
void add_sheet(Geometry& g, float z, int object) {
    add_quad(g, {-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}, object);
}

Scene plain_scene() {
    Scene scene;
    scene.materials.push_back({"grey", glm::vec3(0.5f), glm::vec3(0), -1});
    return scene;
}

// Layers 1 to `count`, each behind the one before.
std::vector<GBuffer> layers_of(const Scene& scene, const Geometry& g, const View& view, glm::ivec2 size, int count,
                               const Layout& layout = Layout::fp32) {
    std::vector<GBuffer> layers;
    layers.resize(std::size_t(count));
    const Surfaces surfaces = prepare(scene, g);
    for (int k = 0; k < count; ++k)
        draw_gbuffer(g, surfaces, view, size, layout, {}, layers[std::size_t(k)], {}, nullptr,
                     k ? &peeled_depth(layers[std::size_t(k - 1)]) : nullptr);
    return layers;
}

// Triangles of clip space, all of them at once and each alone.
struct Soup {
    Geometry geometry;
    Buffer<glm::vec4> clip;

    void add(const glm::vec4& a, const glm::vec4& b, const glm::vec4& c, int material = 0) {
        add_triangle(geometry, at(glm::vec3(a), {0, 0, 1}), at(glm::vec3(b), {0, 0, 1}, 2),
                     at(glm::vec3(c), {0, 0, 1}, 0, 3), material);
        clip.insert(clip.end(), {a, b, c});
    }
    Soup alone(std::size_t triangle) const {
        Soup one;
        one.geometry.vertices = geometry.vertices;
        one.geometry.triangles = {geometry.triangles[triangle]};
        one.geometry.material = {geometry.material[triangle]};
        one.geometry.object = {0};
        one.clip = clip;
        return one;
    }
};

Soup random_soup(int n, Random& random) {
    Soup soup;
    auto point = [&](double extent) {
        const double w = random.below(2) ? 1 : random.between(0.1, 9), z = random.between(-0.1, 1.1);
        return glm::vec4(float(random.between(-extent, extent) * w), float(random.between(-extent, extent) * w),
                         float(z * w), float(w));
    };
    for (int i = 0; i < n; ++i) {
        const double extent = i % 4 == 0 ? 3 : 1.1;
        const glm::vec4 a = point(extent), b = point(extent), c = point(extent);
        soup.add(a, b, c, i % 3);
        // The same surface again: equal depths, or depths that differ in their last bits.
        if (i % 5 == 0) soup.add(a, b, c, (i + 1) % 3);
        if (i % 7 == 0) soup.add(b, c, a, i % 3);
    }
    return soup;
}

// What a pixel's layers are: distinct depths in order, and of each the first triangle that has it.
struct Hit {
    float depth;
    std::int32_t triangle;
};
Image<std::vector<Hit>> brute_force(const Soup& soup, const Surfaces* surfaces, bool reversed, glm::ivec2 size) {
    Image<std::vector<Hit>> hits(size.x, size.y);
    for (std::size_t t = 0; t < soup.geometry.triangles.size(); ++t) {
        const Soup one = soup.alone(t);
        const VisibilityBuffer seen =
            reference_visibility(one.geometry, surfaces, one.clip, reversed, size, 0, size.y, with({}, 1));
        for (std::size_t i = 0; i < hits.size(); ++i)
            if (seen.triangle.texels[i] == 0) hits.texels[i].push_back({seen.depth.texels[i], std::int32_t(t)});
    }
    for (std::vector<Hit>& of_pixel : hits.texels) {
        std::stable_sort(of_pixel.begin(), of_pixel.end(), [&](const Hit& a, const Hit& b) {
            return reversed ? a.depth > b.depth : a.depth < b.depth;
        });
        const auto end = std::unique(of_pixel.begin(), of_pixel.end(),
                                     [](const Hit& a, const Hit& b) { return a.depth == b.depth; });
        of_pixel.erase(end, of_pixel.end());
    }
    return hits;
}

// Peels until nothing is left and counts what was seen. Every instruction set, with 1 and 3 threads, and the reference
// must give the same bits.
std::size_t check_layers(const Soup& soup, const Surfaces* surfaces, bool reversed, glm::ivec2 size) {
    const Image<std::vector<Hit>> expected = brute_force(soup, surfaces, reversed, size);
    std::size_t most = 0, total = 0, seen = 0;
    for (const std::vector<Hit>& hits : expected.texels) most = std::max(most, hits.size()), total += hits.size();
    const float clear = reversed ? 0.0f : 1.0f;
    Image1 behind;
    Workspace workspace;
    VisibilityBuffer out;
    for (std::size_t layer = 0; layer <= most; ++layer) {
        const Image1* peeled = layer ? &behind : nullptr;
        const VisibilityBuffer truth = reference_visibility(soup.geometry, surfaces, soup.clip, reversed, size, 0,
                                                            size.y, with({}, 1), peeled);
        CAPTURE(layer, reversed);
        for (Isa isa : supported_isas())
            for (int threads : {1, 3}) {
                draw_visibility(soup.geometry, surfaces, soup.clip, reversed, size, with(isa, threads), out, &workspace,
                                peeled);
                CAPTURE(isa_name(isa), threads);
                REQUIRE(same(out.triangle, truth.triangle));
                REQUIRE(same(out.depth, truth.depth));
                REQUIRE(same(out.barycentrics, truth.barycentrics));
            }
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            const std::vector<Hit>& hits = expected.texels[i];
            const Hit hit = layer < hits.size() ? hits[layer] : Hit{clear, -1};
            wrong += truth.triangle.texels[i] != hit.triangle || truth.depth.texels[i] != hit.depth;
            seen += truth.triangle.texels[i] >= 0;
        }
        REQUIRE(wrong == 0);
        behind = truth.depth;
    }
    CHECK(seen == total);
    CHECK(most >= 4);  // the test would say little otherwise
    return seen;
}

}  // namespace

TEST_CASE("peel: parallel quads come one a layer, in order, then nothing", "[raster][peel][analytic]") {
    // Five sheets in another order than their depths. Expected: layer k is the k-th nearest, whole, and there is no sixth.
    const float z[5] = {0.5f, 0.1f, 0.9f, 0.3f + 0x1p-25f, 0.3f};  // the last two are one float apart
    REQUIRE(z[3] != z[4]);
    Geometry g;
    for (int i = 0; i < 5; ++i) add_sheet(g, z[i], i);
    for (bool reversed : {false, true}) {
        View view = clip_space_view();
        view.reversed_z = reversed;
        const glm::ivec2 size{70, 67};
        const std::vector<GBuffer> layers = layers_of(plain_scene(), g, view, size, 7);
        std::vector<int> order = {1, 4, 3, 0, 2};
        if (reversed) std::reverse(order.begin(), order.end());
        for (int k = 0; k < 7; ++k)
            for (std::size_t i = 0; i < layers[0].id.size(); ++i) {
                const int expected = k < 5 ? order[std::size_t(k)] : -1;
                REQUIRE(layers[std::size_t(k)].id.texels[i].x == expected);
                REQUIRE(layers[std::size_t(k)].normal.texels[i].w == (k < 5 ? 1.0f : 0.0f));
            }
    }
}

TEST_CASE("peel: of a cube the second layer is its back, and there is no third", "[raster][peel][analytic]") {
    // Objects 0 to 5: -x +x -y +y -z +z. The viewer at (2, 3, 4) sees the three positive faces.
    Geometry g;
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            glm::vec3 o(-0.5f), u(0), v(0);
            o[axis] = side ? 0.5f : -0.5f, u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1;
            add_quad(g, o, o + u, o + u + v, o + v, 2 * axis + side);
        }
    Camera camera;
    camera.position = {2, 3, 4}, camera.look_at = {0, 0, 0}, camera.fov_y_deg = 30;
    const glm::ivec2 size{160, 120};
    for (bool reversed : {false, true}) {
        camera.reversed_z = reversed;
        const std::vector<GBuffer> layers =
            layers_of(plain_scene(), g, make_view(camera, double(size.x) / size.y), size, 3);
        std::size_t covered = 0;
        for (std::size_t i = 0; i < layers[0].id.size(); ++i) {
            const int first = layers[0].id.texels[i].x, second = layers[1].id.texels[i].x;
            CHECK((first < 0 || first % 2 == 1));
            CHECK((second < 0 || second % 2 == 0));
            REQUIRE((first < 0) == (second < 0));
            REQUIRE(layers[2].id.texels[i].x == -1);
            covered += first >= 0;
        }
        CHECK(covered > 2000);
    }
}

TEST_CASE("peel: the layers of random soups are all there is, in order of depth", "[raster][peel][bits]") {
    for (int seed = 0; seed < 4; ++seed) {
        Random random(std::uint64_t(100 + seed));
        const glm::ivec2 size = seed % 2 ? glm::ivec2(66, 13) : glm::ivec2(37, 29);
        const Soup soup = random_soup(24, random);
        CAPTURE(seed);
        for (bool reversed : {false, true}) CHECK(check_layers(soup, nullptr, reversed, size) > 2000);
    }
}

TEST_CASE("peel: masks let layers through, and what they let through is seen once", "[raster][peel][alpha]") {
    Scene scene;
    Random random(5);
    Texture leaves;
    leaves.texels = Image<std::uint32_t>(8, 8);
    for (std::uint32_t& texel : leaves.texels.texels) texel = random.next();
    scene.textures = {leaves};
    scene.materials.resize(3);
    for (Material& m : scene.materials) m.texture = 0;
    scene.materials[1].alpha_cutoff = 0.5f, scene.materials[2].alpha_cutoff = 1.5f;  // the last is never there
    const Soup soup = random_soup(20, random);
    const Surfaces surfaces = prepare(scene, soup.geometry);
    for (bool reversed : {false, true}) check_layers(soup, &surfaces, reversed, {41, 31});
}

TEST_CASE("peel: no layer is nearer than the one before, many chunks or few", "[raster][peel]") {
    // Eight sheets of 4096 triangles that slope through one another: a chunk each, in the order farthest first.
    Soup soup;
    for (int k = 7; k >= 0; --k)
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 64; ++x) {
                auto corner = [&](int i, int j) {
                    const float u = float(x + i) / 64, v = float(y + j) / 32, slope = k % 2 ? 1 - u : u;
                    return glm::vec4(2 * u - 1, 2 * v - 1, 0.1f + 0.05f * float(k) + 0.08f * slope, 1);
                };
                soup.add(corner(0, 0), corner(1, 0), corner(0, 1));
                soup.add(corner(1, 0), corner(1, 1), corner(0, 1));
            }
    const glm::ivec2 size{130, 70};
    for (bool reversed : {false, true}) {
        std::vector<VisibilityBuffer> layers(9);
        std::size_t seen = 0;
        for (std::size_t k = 0; k < layers.size(); ++k) {
            const Image1* behind = k ? &layers[k - 1].depth : nullptr;
            draw_visibility(soup.geometry, nullptr, soup.clip, reversed, size, {}, layers[k], nullptr, behind);
            const VisibilityBuffer truth = reference_visibility(soup.geometry, nullptr, soup.clip, reversed, size, 0,
                                                                size.y, {}, behind);
            REQUIRE(same(layers[k].triangle, truth.triangle));
            for (std::size_t i = 0; i < truth.triangle.size(); ++i) {
                if (truth.triangle.texels[i] < 0) continue;
                ++seen;
                if (k == 0) continue;
                const float before = layers[k - 1].depth.texels[i], now = truth.depth.texels[i];
                REQUIRE((reversed ? now < before : now > before));
            }
        }
        // Every sheet is seen at every pixel, but where two have the same depth: along columns where they cross.
        const std::size_t all = 8 * std::size_t(size.x) * std::size_t(size.y);
        CHECK(seen <= all);
        CHECK(seen > all - 8 * 8 * std::size_t(size.y));
    }
}

TEST_CASE("peel: surfaces of one depth vanish together", "[raster][peel][analytic]") {
    Geometry g;
    add_sheet(g, 0.25f, 0), add_sheet(g, 0.25f, 1), add_sheet(g, 0.75f, 2);
    const std::vector<GBuffer> layers = layers_of(plain_scene(), g, clip_space_view(), {9, 9}, 3);
    CHECK(layers[0].id(4, 4).x == 0);
    CHECK(layers[1].id(4, 4).x == 2);
    CHECK(layers[2].id(4, 4).x == -1);
}

TEST_CASE("peel: a layout that rounds depth peels the same layers", "[raster][peel][layout]") {
    // A slope, and the like 2^-23 behind it: 24 bits cannot tell what float can, and half of all pixels round towards
    // the viewer, so that rounded depths would show the first sheet again.
    Geometry g;
    const float z = 0.2f, far = 0.3f, gap = 0x1p-23f;
    add_quad(g, {-1, -1, z}, {1, -1, far}, {1, 1, far}, {-1, 1, z}, 0);
    add_quad(g, {-1, -1, z + gap}, {1, -1, far + gap}, {1, 1, far + gap}, {-1, 1, z + gap}, 1);
    Layout rounded = Layout::fp32;
    rounded.name = "custom", rounded.depth_buffer = Format::d24s8;
    const glm::ivec2 size{64, 40};
    const View view = clip_space_view();
    const std::vector<GBuffer> exact = layers_of(plain_scene(), g, view, size, 3);
    const std::vector<GBuffer> layers = layers_of(plain_scene(), g, view, size, 3, rounded);
    for (int k = 0; k < 3; ++k) {
        CHECK(same(layers[std::size_t(k)].id, exact[std::size_t(k)].id));
        CHECK(same(layers[std::size_t(k)].exact_depth, exact[std::size_t(k)].depth));
        CHECK(exact[std::size_t(k)].exact_depth.empty());
    }
    CHECK_FALSE(same(layers[0].depth, exact[0].depth));
    CHECK(layers[1].id(30, 20).x == 1);
    GBuffer wrong;
    draw_gbuffer(g, prepare(plain_scene(), g), view, size, rounded, {}, wrong, {}, nullptr, &layers[0].depth);
    CHECK(std::any_of(wrong.id.texels.begin(), wrong.id.texels.end(), [](glm::ivec2 id) { return id.x == 0; }));
}

TEST_CASE("peel: NaN lets nothing pass; another size is refused", "[raster][peel]") {
    Geometry g;
    add_sheet(g, 0.5f, 0);
    const Image1 nan(8, 6, std::nanf(""));
    GBuffer out;
    const Surfaces surfaces = prepare(plain_scene(), g);
    for (bool reversed : {false, true}) {
        View view = clip_space_view();
        view.reversed_z = reversed;
        for (Isa isa : supported_isas()) {
            draw_gbuffer(g, surfaces, view, {8, 6}, Layout::fp32, with(isa, 1), out, {}, nullptr, &nan);
            for (const glm::ivec2& id : out.id.texels) CHECK(id.x == -1);
        }
        CHECK(explain_gbuffer(g, surfaces, view, {8, 6}, {3, 3}, Layout::fp32, &nan).at(0).name == "triangle");
        CHECK(explain_gbuffer(g, surfaces, view, {8, 6}, {3, 3}).at(0).name == "object");
        CHECK_THROWS_WITH(
            draw_gbuffer(g, surfaces, view, {8, 7}, Layout::fp32, {}, out, {}, nullptr, &nan),
            "raster: behind = 8 x 6: expected 8 x 7 pixels, the frame's");
        CHECK_THROWS_AS(gbuffer_layer_data(g, surfaces, view, {6, 8}, nan), InputError);
    }
}

TEST_CASE("peel: the bound stage draws the layer, and calls legal what a device may make of it", "[raster][peel][bindings]") {
    Scene scene = plain_scene();
    Geometry g;
    Random random(8);
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 c = random.vector(-1.5, 1.5) - glm::vec3(0, 0, 4);
        add_triangle(g, at(c + random.vector(-1, 1)), at(c + random.vector(-1, 1)), at(c + random.vector(-1, 1)), 0, i);
    }
    Camera camera;
    camera.position = {0, 0, 1}, camera.look_at = {0, 0, -3};
    const glm::ivec2 size{48, 37};
    for (bool reversed : {false, true}) {
        camera.reversed_z = reversed;
        const View view = make_view(camera, double(size.x) / size.y);
        const std::vector<GBuffer> layers = layers_of(scene, g, view, size, 2);
        const Surfaces surfaces = prepare(scene, g);
        StageData data = gbuffer_layer_data(g, surfaces, view, size, layers[0].depth);
        const auto stage = gbuffer_layer_binding().bind(data);
        Bundle outputs;
        stage->run({}, {}, outputs);
        const GBuffer& layer = layers[1];
        CHECK(std::memcmp(at(outputs, "position").bytes.data(), layer.position.data(), 16 * layer.position.size()) == 0);
        CHECK(std::memcmp(at(outputs, "id").bytes.data(), layer.id.data(), 8 * layer.id.size()) == 0);
        CHECK(std::memcmp(at(outputs, "depth").bytes.data(), layer.depth.data(), 4 * layer.depth.size()) == 0);

        // A device whose depths differ in their last bit may see a first layer again, or lose it; nothing else.
        std::vector<Outcome> legal;
        std::size_t again = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const std::vector<float> nothing_told(19, std::nanf(""));
                stage->outcomes({x, y}, {}, nothing_told, {}, legal);
                std::set<int> triangles;
                for (const Outcome& o : legal) triangles.insert(int(o.values.at(17).shadow));
                REQUIRE(legal.at(0).values.at(17).shadow == layer.id(x, y).y);
                REQUIRE(triangles.contains(layers[0].id(x, y).y));
                again += layers[0].id(x, y).y >= 0;
                REQUIRE(triangles.size() <= 8);
            }
        CHECK(again > 500);

        // What lies well behind the first layer is not uncertain: half-way to the second both are judged as they are.
        StageData between = data;
        for (Array& a : between.inputs.arrays)
            if (a.name == "behind")
                for (std::size_t i = 0; i < layer.depth.size(); ++i) {
                    const float half = (layers[0].depth.texels[i] + layer.depth.texels[i]) / 2;
                    std::memcpy(a.bytes.data() + 4 * i, &half, 4);
                }
        const auto apart = gbuffer_layer_binding().bind(between);
        std::size_t sure = 0, pixels = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                if (layer.id(x, y).y < 0) continue;
                apart->outcomes({x, y}, {}, std::vector<float>(19, std::nanf("")), {}, legal);
                REQUIRE(legal.at(0).values.at(17).shadow == layer.id(x, y).y);
                sure += legal.size() == 1, ++pixels;
            }
        CHECK(pixels > 300);
        CHECK(sure > pixels / 2);

        // As a device with planes of its own draws it, nothing lies before the layer.
        DeviceProfile planes;
        planes.interpolation = Interpolation::plane_equation;
        Bundle of_device;
        stage->run({}, planes, of_device);
        for (std::size_t i = 0; i < layer.depth.size(); ++i) {
            float z;
            std::memcpy(&z, at(of_device, "depth").bytes.data() + 4 * i, 4);
            const float before = layers[0].depth.texels[i], clear = reversed ? 0.0f : 1.0f;
            REQUIRE((z == clear || (reversed ? z < before : z > before)));
        }

        data.reversed_z = !reversed;
        CHECK_THROWS_WITH(gbuffer_layer_binding().bind(data),
                          Catch::StartsWith("gbuffer.layer: uniform farther = ") && Catch::Contains("expected "));
    }
}
