// The raster stages bound to named data: they draw what the passes draw, refuse what nobody can draw, and call legal
// what a device may draw and nothing else.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <regex>
#include <sstream>

#include "core/camera.h"
#include "core/error.h"
#include "drawing.h"
#include "io/scene_file.h"
#include "raster/bindings.h"
#include "raster/gbuffer.h"
#include "raster/light_view.h"
#include "raster/rsm.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

const DeviceProfile ideal;

struct Fixture {
    Scene scene;
    Geometry geometry;
    Surfaces surfaces;
    View view;
    glm::ivec2 size;

    Fixture(Scene s, glm::ivec2 pixels) : scene(std::move(s)), geometry(flatten(scene)), size(pixels) {
        surfaces = prepare(scene, geometry);
        view = make_view(scene.camera, double(size.x) / size.y);
    }
    StageData gbuffer() const { return gbuffer_data(geometry, surfaces, view, size); }
};

Scene load(const std::string& name) {
    return io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/" + name, {"rsm", "shadow", "direct", "tonemap", "path"});
}

std::uint32_t rgba(int r, int g, int b, int a = 255) {
    return std::uint32_t(r) | std::uint32_t(g) << 8 | std::uint32_t(b) << 16 | std::uint32_t(a) << 24;
}

// A floor with a normal map that passes under the viewer, a masked fence, a smooth ball with a texture of levels, and a
// cloud of triangles of which some are narrower than the snapping grid.
Scene fair() {
    Scene s;
    Random random(11);
    for (int t = 0; t < 3; ++t) {
        Image<std::uint32_t> texels(16 << t, 16);
        for (std::uint32_t& x : texels.texels) {
            const int r = random.below(256), g = random.below(256), b = random.below(256);
            x = t == 0 ? rgba(100 + r / 5, 100 + g / 5, 255 - b / 8) : rgba(r, g, b, random.below(256));
        }
        s.textures.push_back({"noise", texels, t == 1, t == 2 ? Filter::nearest : Filter::bilinear});
    }
    s.textures[1].mips = true;
    s.materials.resize(4);
    s.materials[0].normal_texture = 0;
    s.materials[1].texture = 2, s.materials[1].alpha_cutoff = 0.5f;
    s.materials[2].texture = 1, s.materials[2].emission = {1, 2, 3}, s.materials[2].emission_texture = 1;

    Mesh m;
    auto vertex = [&](glm::vec3 p, glm::vec3 n, float u, float v) {
        m.vertices.push_back({p, u, n, v});
        m.tangents.push_back({1, 0, 0, 1});
        return unsigned(m.vertices.size()) - 1;
    };
    auto triangle = [&](unsigned a, unsigned b, unsigned c, int material) {
        m.triangles.push_back({a, b, c});
        m.material.push_back(material);
    };
    auto quad = [&](glm::vec3 a, glm::vec3 u, glm::vec3 v, glm::vec3 n, float tiles, int material) {
        const unsigned i = vertex(a, n, 0, 0), j = vertex(a + u, n, tiles, 0), k = vertex(a + u + v, n, tiles, tiles),
                       l = vertex(a + v, n, 0, tiles);
        triangle(i, j, k, material), triangle(i, k, l, material);
    };
    quad({-20, 0, 20}, {40, 0, 0}, {0, 0, -40}, {0, 1, 0}, 30, 0);
    quad({-2, 0, -3}, {1.5f, 0, 0}, {0, 2, 0}, {0, 0, 1}, 2, 1);
    constexpr int rings = 16;
    const unsigned first = unsigned(m.vertices.size());
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j <= 2 * rings; ++j) {
            const double theta = M_PI * i / rings, phi = M_PI * j / rings;
            const glm::vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
            vertex(glm::vec3(1, 1.2f, -3) + n, n, float(j) / rings, float(i) / rings);
        }
    for (unsigned i = 0; i < rings; ++i)
        for (unsigned j = 0; j < 2 * rings; ++j) {
            const unsigned a = first + i * (2 * rings + 1) + j, b = a + 2 * rings + 1;
            triangle(a, b, b + 1, 2), triangle(a, b + 1, a + 1, 2);
        }
    for (int i = 0; i < 400; ++i) {
        const glm::vec3 c = random.vector(-3, 3) + glm::vec3(0, 3, -4);
        const double r = i % 20 == 0 ? 0.002 : 0.3;
        const glm::vec3 n = random.vector(-1, 1);
        unsigned v[3];
        for (unsigned& k : v) k = vertex(c + random.vector(-r, r), n, float(i % 7), float(i % 5));
        triangle(v[0], v[1], v[2], i % 4);
    }
    s.meshes.push_back(m);
    s.camera.position = {0, 1.5, 2};
    s.camera.look_at = {0, 1.3, -3};
    s.camera.fov_y_deg = 65;
    return s;
}

template <class T>
std::span<T> elements_of(Array& a) {
    return {reinterpret_cast<T*>(a.bytes.data()), a.bytes.size() / sizeof(T)};
}

bool same(const Array& a, const void* data) { return std::memcmp(a.bytes.data(), data, a.bytes.size()) == 0; }

std::unique_ptr<BoundStage> bound(const StageData& data) {
    return (data.stage == "rsm" ? rsm_binding() : gbuffer_binding()).bind(data);
}
Bundle run(const BoundStage& stage, const DeviceProfile& profile = ideal) {
    Bundle outputs;
    stage.run({}, profile, outputs);
    return outputs;
}

// All components of a pixel, in the outputs' order.
std::vector<float> pixel_of(const Bundle& outputs, glm::ivec2 size, glm::ivec2 pixel) {
    std::vector<float> got;
    for (const Array& a : outputs.arrays) {
        const std::size_t n = a.bytes.size() / 4 / std::size_t(size.x) / std::size_t(size.y);
        for (std::size_t c = 0; c < n; ++c) {
            const unsigned char* p = a.bytes.data() + 4 * ((std::size_t(pixel.y) * size.x + pixel.x) * n + c);
            float f;
            std::int32_t i;
            std::memcpy(&f, p, 4), std::memcpy(&i, p, 4);
            got.push_back(a.dtype == DType::i32 ? float(i) : f);
        }
    }
    return got;
}

bool within(const Outcome& outcome, const std::vector<float>& got) {
    bool all = outcome.values.size() == got.size();
    for (std::size_t c = 0; all && c < got.size(); ++c)
        all = std::abs(double(got[c]) - outcome.values[c].shadow) <= outcome.values[c].bound;
    return all;
}

enum class Legal { no, on_another_branch, yes };
Legal judge(const BoundStage& stage, glm::ivec2 pixel, const std::vector<float>& got,
            const DeviceProfile& profile = ideal) {
    std::vector<Outcome> outcomes;
    stage.outcomes(pixel, profile, got, {}, outcomes);
    Legal best = Legal::no;
    for (const Outcome& o : outcomes)
        if (within(o, got)) best = std::max(best, o.ambiguous ? Legal::on_another_branch : Legal::yes);
    return best;
}

struct Counts {
    int pixels = 0, equal = 0, ambiguous = 0, wrong = 0;
    std::vector<glm::ivec2> doubted;  // the ambiguous ones
};
// Judges every `step`th pixel in x and y of what was drawn.
Counts judge_all(const BoundStage& stage, const Bundle& drawn, glm::ivec2 size, int step = 1,
                 const DeviceProfile& profile = ideal) {
    const Bundle ours = run(stage, profile);
    Counts counts;
    for (int y = 0; y < size.y; y += step)
        for (int x = 0; x < size.x; x += step) {
            const std::vector<float> got = pixel_of(drawn, size, {x, y});
            const Legal legal = judge(stage, {x, y}, got, profile);
            ++counts.pixels;
            counts.equal += got == pixel_of(ours, size, {x, y});
            counts.wrong += legal == Legal::no;
            if (legal == Legal::on_another_branch) ++counts.ambiguous, counts.doubted.push_back({x, y});
        }
    return counts;
}

}  // namespace

TEST_CASE("bindings: a bound gbuffer draws the pass's bits", "[bindings]") {
    auto check = [](const Fixture& f) {
        GBuffer expected;
        draw_gbuffer(f.geometry, f.surfaces, f.view, f.size, Layout::fp32, {}, expected);
        const StageData data = f.gbuffer();
        const Bundle outputs = run(*bound(data));
        CHECK(same(at(outputs, "position"), expected.position.data()));
        CHECK(same(at(outputs, "normal"), expected.normal.data()));
        CHECK(same(at(outputs, "albedo"), expected.albedo.data()));
        CHECK(same(at(outputs, "emission"), expected.emission.data()));
        CHECK(same(at(outputs, "id"), expected.id.data()));
        CHECK(same(at(outputs, "depth"), expected.depth.data()));
    };
    for (const char* name : {"cornell/cornell.toml", "box/box.toml", "atrium/atrium.toml"}) {
        CAPTURE(name);
        check(Fixture(load(name), {256, 256}));
    }
    check(Fixture(fair(), {211, 130}));
}

TEST_CASE("bindings: a bound rsm draws the pass's bits", "[bindings]") {
    for (const Scene& scene : {load("cornell/cornell.toml"), load("atrium/atrium.toml"), fair()}) {
        Fixture f(scene, {16, 16});
        Light light;
        light.position = {0.3f, 1.9f, 0.4f}, light.direction = {0.1f, -0.7f, -0.7f};
        light.rsm_size = 150;
        glm::vec3 low, high;
        REQUIRE(bounds(f.geometry, low, high));
        for (LightType type : {LightType::spot, LightType::directional}) {
            light.type = type;
            const View view = light_view(light, low, high);
            Rsm expected;
            draw_rsm(f.geometry, f.surfaces, light, view, Layout::fp32, {}, expected);
            const StageData data = rsm_data(f.geometry, f.surfaces, light, view);
            const Bundle outputs = run(*bound(data));
            CHECK(same(at(outputs, "position"), expected.position.data()));
            CHECK(same(at(outputs, "normal"), expected.normal.data()));
            CHECK(same(at(outputs, "flux"), expected.flux.data()));
        }
    }
}

TEST_CASE("bindings: explain lists what the pass's explain lists, but for its layout", "[bindings]") {
    const Fixture f(fair(), {211, 130});
    const StageData data = f.gbuffer();
    const auto stage = bound(data);
    for (glm::ivec2 pixel : {glm::ivec2(100, 60), glm::ivec2(150, 60), glm::ivec2(100, 120), glm::ivec2(0, 0)}) {
        std::vector<TapValue> expected = explain_gbuffer(f.geometry, f.surfaces, f.view, f.size, pixel);
        std::erase_if(expected, [](const TapValue& t) { return t.name.starts_with("stored_"); });
        const std::vector<TapValue> values = stage->explain(pixel);
        REQUIRE(values.size() == expected.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            CHECK(values[i].name == expected[i].name);
            CHECK(values[i].value == expected[i].value);
        }
    }
}

TEST_CASE("bindings: data that no kernel may follow is refused in one line", "[bindings]") {
    const Fixture f(fair(), {32, 20});
    auto refused = [&](const std::string& input, std::size_t element, double value, const std::string& message) {
        StageData data = f.gbuffer();
        data.label = "gbuffer";
        for (Array& a : data.inputs.arrays)
            if (a.name == input) {
                const float real = float(value);
                const std::int32_t whole = a.dtype == DType::i32 ? std::int32_t(value) : 0;
                std::memcpy(a.bytes.data() + 4 * element, a.dtype == DType::i32 ? (const void*)&whole : &real, 4);
            }
        CHECK_THROWS_WITH(bound(data), Catch::StartsWith("gbuffer: ") && Catch::Contains(message) &&
                                           !Catch::Contains("\n"));
    };
    const double nan = std::nan("");
    refused("clip_positions", 6, nan, "vertex 1 is not finite");
    refused("clip_positions", 4, INFINITY, "vertex 1 is not finite");
    refused("triangles", 7, 100000, "triangle 2 names vertex 100000");
    refused("triangles", 7, -1, "triangle 2 names vertex -1");
    refused("triangle_material", 3, 4, "triangle 3 names material 4: there are 4");
    refused("triangle_material", 3, -1, "triangle 3 names material -1");
    refused("materials", 8, 1e9, "material 0 names base texture 1000000000");
    refused("materials", 16 + 9, -1, "material 1 names emission texture -1");
    refused("materials", 16 + 10, 0.5, "material 1 names normal texture 0.5");
    refused("materials", 8, nan, "material 0 names base texture nan");
    refused("textures", 4, -1, "row 1 takes texels -1");
    refused("textures", 5, 0, "row 1 has 0 x 16 texels");
    refused("textures", 6, 1 << 22, "row 1 takes texels");
    refused("textures", 7, 1 << 20, "row 1 has 16384 smaller levels");
    refused("textures", 7, -1, "row 1");

    auto resized = [&](const std::string& input, const Shape& shape, const std::string& message) {
        StageData data = f.gbuffer();
        for (Array& a : data.inputs.arrays)
            if (a.name == input) {
                a.shape = shape;
                a.bytes.resize(4 * element_count(input, shape));
            }
        CHECK_THROWS_WITH(bound(data), Catch::StartsWith("gbuffer: ") && Catch::Contains(message));
    };
    resized("vertices", {7, 4}, "\"vertices\" has 28 numbers");
    resized("clip_positions", {3, 4}, "\"clip_positions\" has 3 rows");
    resized("triangles", {4}, "\"triangles\" has 4 numbers");
    resized("objects", {5}, "\"objects\" has 5 rows");
    resized("triangle_material", {5}, "\"triangle_material\" has 5 rows");
    resized("decode", {100}, "\"decode\" has 100 rows");
    resized("materials", {5, 4}, "\"materials\" has 20 numbers");
    resized("tangents", {1, 4}, "has a normal map");

    glm::vec3 low, high;
    REQUIRE(bounds(f.geometry, low, high));
    Light light;
    StageData map = rsm_data(f.geometry, f.surfaces, light, light_view(light, low, high));
    map.size = {20, 10};
    CHECK_THROWS_WITH(bound(map), "rsm: size 20 x 10: a map is square");
}

TEST_CASE("bindings: nothing to draw is drawn", "[bindings]") {
    Scene scene;
    const Fixture f(scene, {8, 8});
    const StageData data = f.gbuffer();
    const auto stage = bound(data);
    CHECK(pixel_of(run(*stage), f.size, {3, 3})[17] == -1);
    CHECK(judge(*stage, {3, 3}, pixel_of(run(*stage), f.size, {3, 3})) == Legal::yes);
}

TEST_CASE("legal pixels: our own pictures are legal on our own branch", "[bindings][legal]") {
    for (const Scene& scene : {load("cornell/cornell.toml"), load("atrium/atrium.toml"), fair()}) {
        const Fixture f(scene, {200, 160});
        const StageData data = f.gbuffer();
        const auto stage = bound(data);
        const Counts counts = judge_all(*stage, run(*stage), f.size, 3);
        CAPTURE(scene.name);
        CHECK(counts.wrong == 0);
        // Only of triangles narrower than two steps of the grid nothing can be said.
        CHECK(counts.ambiguous <= counts.pixels / 500);
    }
}

// Each vertex goes up to half a step of the snapping grid away, and is snapped from there by up to another half: within
// the one step that the profile grants.
TEST_CASE("legal pixels: with vertices elsewhere on the snapping grid, nothing is wrong", "[bindings][legal]") {
    struct Case {
        Scene scene;
        double most_ambiguous;
    };
    for (const Case& c : {Case{load("cornell/cornell.toml"), 0.01}, Case{load("atrium/atrium.toml"), 0.05},
                          Case{fair(), 0.05}}) {
        const Fixture f(c.scene, {256, 200});
        const StageData data = f.gbuffer();
        StageData moved = data;
        Random random(3);
        for (Array& a : moved.inputs.arrays)
            if (a.name == "clip_positions")
                for (glm::vec4& p : elements_of<glm::vec4>(a))
                    for (int k = 0; k < 2; ++k)
                        p[k] = float(p[k] + random.between(-1, 1) / 512 * 2 / f.size[k] * double(p.w));
        const auto stage = bound(data);
        const Counts counts = judge_all(*stage, run(*bound(moved)), f.size);
        CAPTURE(c.scene.name, counts.equal, counts.pixels, counts.ambiguous);
        CHECK(counts.wrong == 0);
        CHECK(counts.equal < counts.pixels);
        CHECK(counts.ambiguous > 0);
        CHECK(counts.ambiguous <= c.most_ambiguous * counts.pixels);
    }
}
