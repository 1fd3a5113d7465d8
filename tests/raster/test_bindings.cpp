// The raster stages bound to named data: they draw what the passes draw, refuse what nobody can draw, and call legal
// what a device may draw and nothing else.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/camera.h"
#include "core/error.h"
#include "drawing.h"
#include "io/scene_file.h"
#include "raster/bindings.h"
#include "raster/gbuffer.h"
#include "raster/light_view.h"
#include "raster/rsm.h"
#include "raster/texture_bounded.h"

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
// cloud of triangles: some are narrower than the snapping grid, some have no normals.
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
        const glm::vec3 n = i % 3 == 0 ? glm::vec3(0) : random.vector(-1, 1);
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

TEST_CASE("bindings: a stage's row names what its twin binds, and what a frame keeps", "[bindings][stage]") {
    using Names = std::vector<std::string>;
    auto names = [](const auto& list) {
        Names all;
        for (const auto& one : list) all.push_back(one.name);
        return all;
    };
    for (const StageBinding* b : {&gbuffer_binding(), &gbuffer_layer_binding(), &rsm_binding()}) {
        INFO(b->info.name);
        CHECK(names(b->info.inputs) == names(b->inputs));
        CHECK(b->outputs.back().kind == SlotKind::depth);
        CHECK(b->info.twin == b->twin + ".frag");
    }
    CHECK(names(gbuffer_binding().info.outputs) == names(gbuffer_binding().outputs));
    CHECK(names(rsm_binding().info.outputs) == Names{"position", "normal", "flux", "records"});
    CHECK(names(surface_ports()) == Names{"vertices", "triangles", "triangle_material", "materials", "tangents",
                                          "textures", "texels", "decode"});
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

// Each number is set to the last that is there, and to one more.
TEST_CASE("bindings: the last vertex, material, texture and texel may be named, none behind them", "[bindings]") {
    const Fixture f(fair(), {32, 20});
    const StageData data = f.gbuffer();
    auto rows = [&](const char* input, int width) { return int(at(data.inputs, input).bytes.size()) / 4 / width; };
    auto message = [&](const std::string& input, std::size_t element, int value) -> std::string {
        StageData changed = data;
        for (Array& a : changed.inputs.arrays) {
            if (a.name != input) continue;
            if (a.dtype == DType::i32)
                elements_of<std::int32_t>(a)[element] = value;
            else
                elements_of<float>(a)[element] = float(value);
        }
        try {
            bound(changed);
            return "";
        } catch (const InputError& error) {
            return error.what();
        }
    };
    auto last = [&](const std::string& input, std::size_t element, int count, const std::string& refused) {
        INFO(input << ", element " << element);
        CHECK(message(input, element, count - 1) == "");
        CHECK_THAT(message(input, element, count), Catch::Contains(refused));
    };
    const int textures = rows("textures", 4), texels = rows("texels", 1);
    for (std::size_t corner = 0; corner < 3; ++corner)
        last("triangles", 3 + corner, rows("vertices", 8), "triangle 1 names vertex");
    last("triangle_material", 5, rows("materials", 16), "triangle 5 names material");
    last("materials", 8, textures, "material 0 names base texture");
    last("materials", 9, textures, "material 0 names emission texture");
    last("materials", 10, textures, "material 0 names normal texture");

    // Row 1 has 16 x 16 texels: it may start at the 256th before the end.
    last("textures", 4, texels - 256 + 1, "row 1 takes texels");
    for (std::size_t side : {std::size_t(5), std::size_t(6)}) {
        CHECK(message("textures", side, 1) == "");
        CHECK_THAT(message("textures", side, 0), Catch::Contains("expected 1 to 4194304 a side"));
        CHECK_THAT(message("textures", side, 1 << 22), Catch::Contains("row 1 takes texels"));
        CHECK_THAT(message("textures", side, (1 << 22) + 1), Catch::Contains("expected 1 to 4194304 a side"));
    }

    // Its smaller levels are the rows behind it.
    CHECK(message("textures", 7, (textures - 2) << levels_shift) == "");
    CHECK_THAT(message("textures", 7, (textures - 1) << levels_shift), Catch::Contains("row 1 has"));
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

namespace {

// Each vertex goes up to half a step of the snapping grid away, and is snapped from there by up to another half: within
// the one step that the profile grants. What lies at one place goes to one place. What has to be clipped stays: a
// device places what is left after clipping.
StageData with_moved_vertices(const Fixture& f, StageData data) {
    for (Array& a : data.inputs.arrays) {
        if (a.name != "clip_positions") continue;
        const std::span<glm::vec4> clip = elements_of<glm::vec4>(a);
        std::vector<bool> stays(clip.size());
        for (const glm::uvec3& t : f.geometry.triangles) {
            auto inside = [&](unsigned v) { return clip[v].z >= 0 && clip[v].z <= clip[v].w && clip[v].w > 0; };
            if (!inside(t.x) || !inside(t.y) || !inside(t.z)) stays[t.x] = stays[t.y] = stays[t.z] = true;
        }
        for (std::size_t i = 0; i < clip.size(); ++i) {
            Random random(content_hash(&clip[i], sizeof clip[i]));
            for (int k = 0; k < 2 && !stays[i]; ++k)
                clip[i][k] = float(clip[i][k] + random.between(-1, 1) / 512 * 2 / data.size[k] * double(clip[i].w));
        }
    }
    return data;
}

// How far a pixel's centre is from the nearest edge of a triangle, pixels.
double distance_to_edge(const Fixture& f, int triangle, glm::ivec2 pixel) {
    const glm::uvec3 t = f.geometry.triangles[std::size_t(triangle)];
    glm::dvec2 corner[3];
    for (int i = 0; i < 3; ++i) {
        const glm::dvec4 c = f.view.world_to_clip() * glm::dvec4(f.geometry.vertices[t[i]].position, 1);
        corner[i] = (glm::dvec2(c.x, c.y) / c.w + 1.0) * 0.5 * glm::dvec2(f.size) - (glm::dvec2(pixel) + 0.5);
    }
    double least = 1e9;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec2 a = corner[i], b = corner[(i + 1) % 3], d = b - a;
        const double along = std::clamp(-(a.x * d.x + a.y * d.y) / (d.x * d.x + d.y * d.y), 0.0, 1.0);
        const glm::dvec2 nearest = a + along * d;
        least = std::min(least, std::sqrt(nearest.x * nearest.x + nearest.y * nearest.y));
    }
    return least;
}

}  // namespace

// A doubted pixel shows another triangle than ours, and one of the two has an edge within the step, along x and y, that
// vertices may move, or holes; all but a few, where triangles cut through each other.
TEST_CASE("legal pixels: with vertices elsewhere on the snapping grid, nothing is wrong", "[bindings][legal]") {
    int doubted = 0;
    for (const char* name : {"cornell/cornell.toml", "atrium/atrium.toml", "fair", "fair, reversed z"}) {
        Scene scene = std::string(name).starts_with("fair") ? fair() : load(name);
        scene.camera.reversed_z = std::string(name).ends_with("reversed z");
        const Fixture f(scene, {256, 200});
        const StageData data = f.gbuffer(), moved = with_moved_vertices(f, data);
        const auto stage = bound(data);
        const Bundle ours = run(*stage), drawn = run(*bound(moved));
        const Counts counts = judge_all(*stage, drawn, f.size);
        CAPTURE(name, counts.equal, counts.pixels, counts.ambiguous);
        CHECK(counts.wrong == 0);
        CHECK(counts.equal < counts.pixels * 9 / 10);
        CHECK(counts.ambiguous <= counts.pixels / 200);
        int inner = 0;
        for (glm::ivec2 pixel : counts.doubted) {
            double least = 1e9;
            for (const Bundle* b : {&ours, &drawn}) {
                const int triangle = int(pixel_of(*b, f.size, pixel)[17]);
                if (triangle < 0) continue;
                const bool masked = f.surfaces.masked[std::size_t(f.geometry.material[std::size_t(triangle)])];
                least = std::min(least, masked ? 0 : distance_to_edge(f, triangle, pixel));
            }
            inner += !(least <= 1.1 * std::sqrt(2) / 256);
        }
        CHECK(inner <= int(counts.doubted.size()) / 20);
        doubted += counts.ambiguous;
    }
    CHECK(doubted > 50);
}

TEST_CASE("legal pixels: a map with vertices elsewhere is not wrong either", "[bindings][legal]") {
    const Fixture f(fair(), {16, 16});
    glm::vec3 low, high;
    REQUIRE(bounds(f.geometry, low, high));
    Light light;
    light.position = {0.3f, 4, 0.4f}, light.direction = {0.1f, -0.7f, -0.7f};
    light.rsm_size = 180;
    for (LightType type : {LightType::spot, LightType::directional}) {
        light.type = type;
        const StageData data = rsm_data(f.geometry, f.surfaces, light, light_view(light, low, high));
        const auto stage = bound(data);
        const StageData moved = with_moved_vertices(f, data);
        const Counts counts = judge_all(*stage, run(*bound(moved)), data.size);
        CHECK(counts.wrong == 0);
        CHECK(counts.equal < counts.pixels);
        CHECK(counts.ambiguous <= counts.pixels / 200);
    }
}

// With exact rasterisation for a reference, what a driver of planes in floats draws differs in nearly every pixel; and
// by its own profile in none.
TEST_CASE("legal pixels: a device that interpolates by planes is legal", "[bindings][legal]") {
    const DeviceProfile& planes = find_profile("lavapipe-22.3-fma", "");
    for (const Scene& scene : {load("cornell/cornell.toml"), load("atrium/atrium.toml"), fair()}) {
        const Fixture f(scene, {1000, 562});
        const StageData data = f.gbuffer();
        const auto stage = bound(data);
        const Bundle drawn = run(*stage, planes);
        const Counts counts = judge_all(*stage, drawn, f.size, 7), own = judge_all(*stage, drawn, f.size, 7, planes);
        CAPTURE(scene.name, counts.pixels);
        CHECK(counts.wrong == 0);
        CHECK(counts.equal < counts.pixels * 3 / 4);
        CHECK(counts.ambiguous <= counts.pixels / 200);
        CHECK(own.equal == own.pixels);
        CHECK(own.wrong == 0);
    }
}

TEST_CASE("legal pixels: on a shared edge both triangles are legal, away from it one", "[bindings][legal]") {
    // Two halves of the frame's square: the diagonal runs through the centres of the pixels (i, i).
    Fixture f(Scene(), {32, 32});
    f.scene.materials.resize(1);
    f.view = clip_space_view();
    const Vertex a = at({-1, -1, 0.5f}), b = at({1, -1, 0.5f}), c = at({1, 1, 0.5f}), d = at({-1, 1, 0.5f});
    add_triangle(f.geometry, a, b, c);
    add_triangle(f.geometry, a, c, d);
    f.surfaces = prepare(f.scene, f.geometry);
    const StageData data = f.gbuffer();
    const auto stage = bound(data);
    const std::vector<float> unknown(19, std::nanf(""));
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            std::vector<Outcome> outcomes;
            stage->outcomes({x, y}, ideal, unknown, {}, outcomes);
            REQUIRE(outcomes.size() == (x == y ? 2 : 1));
            CHECK_FALSE(outcomes[0].ambiguous);
            CHECK(outcomes[0].values[17].shadow == (x == y ? outcomes[0].values[17].shadow : x > y ? 0 : 1));
            if (x == y) CHECK(outcomes[1].ambiguous);
            if (x == y) CHECK(outcomes[1].values[17].shadow + outcomes[0].values[17].shadow == 1);
        }
}

TEST_CASE("legal pixels: an error is in no outcome", "[bindings][legal]") {
    const Fixture f(load("cornell/cornell.toml"), {128, 128});
    const StageData data = f.gbuffer();
    const auto stage = bound(data);
    const Bundle drawn = run(*stage);
    int inner = 0;
    for (int y = 1; y < 127; ++y)
        for (int x = 1; x < 127; ++x) {
            const std::vector<float> ours = pixel_of(drawn, f.size, {x, y});
            REQUIRE(judge(*stage, {x, y}, ours) == Legal::yes);
            bool same_all_round = ours[17] >= 0;
            for (glm::ivec2 d : {glm::ivec2(1, 0), glm::ivec2(0, 1), glm::ivec2(-1, 0), glm::ivec2(0, -1)})
                same_all_round = same_all_round && pixel_of(drawn, f.size, glm::ivec2(x, y) + d)[17] == ours[17];
            if (!same_all_round) continue;
            ++inner;
            auto changed = [&](std::size_t component, double by) {
                std::vector<float> got = ours;
                got[component] = float(got[component] + by);
                return judge(*stage, {x, y}, got);
            };
            CHECK(changed(17, 1) == Legal::no);
            CHECK(changed(16, 1) == Legal::no);
            CHECK(changed(18, 1e-4) == Legal::no);
            for (std::size_t c = 4; c < 7; ++c) CHECK(changed(c, 1e-3) == Legal::no);
            for (std::size_t c = 8; c < 11; ++c) CHECK(changed(c, 1e-5) == Legal::no);

            // A position as far away as the next pixel's quarter.
            const std::vector<float> next = pixel_of(drawn, f.size, {x + 1, y});
            std::vector<float> got = ours;
            for (std::size_t c = 0; c < 4; ++c) got[c] += (next[c] - got[c]) / 4;
            CHECK(judge(*stage, {x, y}, got) == Legal::no);
        }
    CHECK(inner > 10000);
}

// The hull of a lookup holds what every place within the bound gives, and little more: neighbours along a fine grid are
// what it may exceed them by.
TEST_CASE("texture over Bounded: the hull of all places within the bound", "[bindings][textures]") {
    Random random(23);
    const Buffer<float> decode = decode_table();
    int looked_up = 0;
    for (int trial = 0; trial < 400; ++trial) {
        const int width = 1 + random.below(6), height = 1 + random.below(6);
        std::vector<std::int32_t> texels(std::size_t(width * height));
        for (std::int32_t& t : texels) t = std::int32_t(random.next());
        const bool nearest = trial % 2;
        const std::int32_t row[4] = {0, width, height,
                                     (nearest ? flag_nearest : 0) | flag_srgb | random.below(3) << wrap_u_shift |
                                         random.below(3) << wrap_v_shift};
        const TextureArgs in{row, texels.data(), decode.data(), false};
        const double u = random.between(-3, 3), v = random.between(-3, 3), radius = 0.3 / (1 + random.below(200));
        NoTap tap;
        const vec3<Bounded> hull = TextureFilter<Bounded>::rgb(
            in, 0, {Bounded::within(float(u), u, radius), Bounded::within(float(v), v, radius)}, false, tap);
        constexpr int steps = 40;
        double low = 1, high = 0, most_step = 0;
        std::vector<double> above(steps + 1);
        for (int j = 0; j <= steps; ++j)
            for (int i = 0; i <= steps; ++i) {
                auto along = [&](double middle, int k) { return float(middle + radius * (2.0 * k / steps - 1)); };
                const vec2<float> uv{along(u, i), along(v, j)};
                const vec3<float> c = TextureFilter<float>::rgb(in, 0, uv, false, tap);
                REQUIRE(std::abs(c.x - hull.x.shadow) <= hull.x.bound);
                REQUIRE(std::abs(c.y - hull.y.shadow) <= hull.y.bound);
                REQUIRE(std::abs(c.z - hull.z.shadow) <= hull.z.bound);
                low = std::min(low, double(c.x)), high = std::max(high, double(c.x));
                const auto column = std::size_t(i);
                if (i > 0) most_step = std::max(most_step, std::abs(c.x - above[column - 1]));
                if (j > 0) most_step = std::max(most_step, std::abs(c.x - above[column]));
                above[column] = c.x, ++looked_up;
            }
        if (!nearest) CHECK(hull.x.bound <= (high - low) / 2 + 4 * most_step + 1e-4);
    }
    CHECK(looked_up > 100000);
}
