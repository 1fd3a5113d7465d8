// The tapped fragment stages on a device: they write what the plain ones write, name every value that the kernels name,
// and of all fragments at a pixel the one that is seen is listed. Compute stages: test_twins_run.cpp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "gi/parity/stages.h"
#include "tests/parity/devices.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/twins.h"

namespace {

using namespace plumb;

void add_quad(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 d, int material) {
    const glm::vec3 u = b - a, v = d - a;
    const glm::vec3 n = normalize3<float>(glm::cross(u, v)), t = normalize3<float>(u);
    const unsigned first = unsigned(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{a, 0, n, 1}, {b, 1, n, 1}, {b + v, 1, n, 0}, {d, 0, n, 0}});
    mesh.tangents.insert(mesh.tangents.end(), 4, glm::vec4(t, 1));
    mesh.triangles.push_back(glm::uvec3(first, first + 1, first + 2));
    mesh.triangles.push_back(glm::uvec3(first, first + 2, first + 3));
    mesh.material.insert(mesh.material.end(), 2, material);
}

// A floor with a texture, its levels and a normal map; a wall that glows; before them a lattice, of which an alpha mask
// leaves half.
Scene lattice_scene() {
    Scene s;
    s.name = "lattice";
    Texture checks;
    checks.name = "checks", checks.mips = true;
    checks.texels = Image<std::uint32_t>(16, 16);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
            checks.texels(x, y) = (x / 2 + y / 2) % 2 ? 0xff80a0c0u : 0x00f0e0b0u + unsigned(7 * x + 3 * y);
    s.textures = {checks};
    s.materials.resize(3);
    s.materials[0].texture = s.materials[0].normal_texture = 0;
    s.materials[1].emission = {0.2f, 0.1f, 0};
    s.materials[2].texture = 0, s.materials[2].alpha_cutoff = 0.5f;
    Mesh room;
    add_quad(room, {-1, 0, -1}, {1, 0, -1}, {-1, 2, -1}, 1);
    add_quad(room, {-1, 0, 1}, {1, 0, 1}, {-1, 0, -1}, 0);
    add_quad(room, {-0.8f, 0.1f, 0.5f}, {0.8f, 0.1f, 0.5f}, {-0.8f, 1.7f, 0.5f}, 2);
    s.meshes.push_back(room);
    Light spot;
    spot.name = "key";
    spot.position = {0, 1.9f, 0.9f};
    spot.direction = normalize3<float>(glm::vec3(0, -1, -0.4f));
    spot.intensity = glm::vec3(10);
    spot.rsm_size = 32;
    s.lights = {spot};
    s.camera.position = {0, 1, 3.4};
    s.camera.look_at = {0, 0.8, 0};
    s.frame_size = {48, 36};
    return s;
}

vulkan::TwinResult run_tapped(const vulkan::Device& device, const StageBinding& binding, const StageData& data,
                              glm::ivec2 pixel) {
    vulkan::RunTwin options;
    options.tap = pixel;
    return vulkan::run_twin(device, binding, data, options);
}

bool same_bits(const Bundle& a, const Bundle& b) {
    if (a.arrays.size() != b.arrays.size()) return false;
    for (std::size_t i = 0; i < a.arrays.size(); ++i)
        if (a.arrays[i].bytes.size() != b.arrays[i].bytes.size() ||
            std::memcmp(a.arrays[i].bytes.data(), b.arrays[i].bytes.data(), a.arrays[i].bytes.size()) != 0)
            return false;
    return true;
}

// "name", or "name[sample]" within a loop.
std::vector<std::string> names_of(const std::vector<TapValue>& taps) {
    std::vector<std::string> names;
    for (const TapValue& t : taps)
        names.push_back(t.sample < 0 ? t.name : t.name + "[" + std::to_string(t.sample) + "]");
    return names;
}

// What the kernel names, of that what the twin can: rsm.frag has no objects.
std::vector<TapValue> expected_taps(const StageBinding& binding, const StageData& data, glm::ivec2 pixel) {
    const vulkan::Twin twin = vulkan::find_twin(binding.raster ? binding.twin + ".frag" : binding.twin);
    std::vector<TapValue> taps = binding.bind(data)->explain(pixel);
    std::erase_if(taps, [&](const TapValue& t) {
        return std::find(twin.taps.begin(), twin.taps.end(), t.name) == twin.taps.end();
    });
    return taps;
}

// The last tap of that name, against what the stage wrote at the pixel.
void check_output(const vulkan::TwinResult& result, const std::string& tap, const std::string& output, int first,
                  glm::ivec2 pixel) {
    const auto t = std::find_if(result.taps.rbegin(), result.taps.rend(),
                                [&](const TapValue& v) { return v.name == tap; });
    REQUIRE(t != result.taps.rend());
    const Array& array = at(result.outputs, output);
    const auto* values = reinterpret_cast<const float*>(array.bytes.data());
    const std::int64_t channels = array.shape.size() > 2 ? array.shape[2] : 1;
    for (std::size_t c = 0; c < t->value.size(); ++c) {
        INFO(tap << " component " << c);
        const std::int64_t texel = pixel.y * array.shape[1] + pixel.x;
        CHECK(t->value[c] == double(values[texel * channels + first + std::int64_t(c)]));
    }
}

// The middle row's first pixel that sees one of the lattice's triangles, and the first after it that sees through.
std::vector<glm::ivec2> on_and_through(const Array& id) {
    const int width = int(id.shape[1]), y = int(id.shape[0]) / 2;
    const auto* ids = reinterpret_cast<const std::int32_t*>(id.bytes.data());
    auto lattice = [&](int x) { return ids[2 * (y * width + x) + 1] >= 4; };
    int on = 0;
    while (on < width && !lattice(on)) ++on;
    int through = on;
    while (through < width && lattice(through)) ++through;
    REQUIRE(through < width);
    return {{on, y}, {through, y}};
}

struct Run {
    Scene scene = lattice_scene();
    std::vector<StageData> stages;

    Run() {
        frame::Settings settings = frame::settings_of(scene);
        settings.rsm.samples = 8;
        const frame::Plan plan = frame::plan(scene, settings);
        stages = parity::frame_data(scene, settings, plan, frame::execute(scene, settings, plan, {}));
    }
};
const Run& run() {
    static const Run one;
    return one;
}

}  // namespace

// Expected: barycentrics are the device's own, so values are held against what the device wrote; names and their order
// are the kernels'. Of the lattice some fragments are discarded, and behind it lies a wall.
TEST_CASE("taps: raster stages list the fragment that is seen", "[vulkan][tap]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (const StageData& data : run().stages) {
        const StageBinding& binding = parity::find_binding(data.stage, "test");
        if (!binding.raster) continue;
        INFO(data.id);
        const vulkan::TwinResult plain = vulkan::run_twin(*device, binding, data);
        const std::vector<glm::ivec2> pixels = data.stage == "gbuffer"
                                                   ? on_and_through(at(plain.outputs, "id"))
                                                   : std::vector<glm::ivec2>{data.size / 2, data.size * 2 / 3};
        for (const glm::ivec2 pixel : pixels) {
            INFO("pixel " << pixel.x << "," << pixel.y);
            const vulkan::TwinResult tapped = run_tapped(*device, binding, data, pixel);
            CHECK(same_bits(plain.outputs, tapped.outputs));
            const std::vector<TapValue> expected = expected_taps(binding, data, pixel);
            if (expected.size() <= 1) {  // nothing is seen
                CHECK(tapped.taps.empty());
                continue;
            }
            REQUIRE(names_of(tapped.taps) == names_of(expected));
            for (std::size_t i = 0; i < expected.size(); ++i)
                if (expected[i].name == "triangle") CHECK(tapped.taps[i].value == expected[i].value);
            check_output(tapped, "position", "position", 0, pixel);
            check_output(tapped, "depth", "position", 3, pixel);
            check_output(tapped, "normal", "normal", 0, pixel);
            check_output(tapped, "z", "depth", 0, pixel);
            if (data.stage == "rsm") check_output(tapped, "flux", "flux", 0, pixel);
            if (data.stage == "gbuffer") check_output(tapped, "albedo", "albedo", 0, pixel);
        }
    }
    for (const std::string& complaint : device->complaints()) UNSCOPED_INFO(complaint);
    CHECK(device->complaints().empty());
}
