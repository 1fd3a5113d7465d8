// The GLSL twins on a device against the kernels, bit by bit, from the same data. PLUMB_FULL=1 runs whole frames of the
// scenes that the project promises; VK_ICD_FILENAMES names SwiftShader's driver.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "core/error.h"
#include "core/formats.h"
#include "gi/parity/stages.h"
#include "io/scene_file.h"
#include "io/scenes/generate.h"
#include "tests/parity/devices.h"
#include "tests/parity/twin_data.h"
#include "tools/vulkan/batches.h"
#include "tools/vulkan/profile.h"
#include "tools/vulkan/runner.h"
#include "tools/vulkan/shader.h"
#include "tools/vulkan/twins.h"

namespace {

using namespace plumb;

bool full() { return std::getenv("PLUMB_FULL") != nullptr; }

// Devices whose operations round as IEEE's: each was probed.
const vulkan::Device* exact_device() {
    return test::first_of({"llvmpipe", "SwiftShader"}, "neither lavapipe (mesa-vulkan-drivers) nor SwiftShader here");
}

void check_silence(const vulkan::Device& device) {
    for (const std::string& complaint : device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(device.complaints().empty());
}

// Components whose bits differ. NaNs are one value: which of them an operation returns is nobody's promise.
std::size_t different(const Array& ours, const Array& theirs) {
    REQUIRE(ours.name == theirs.name);
    REQUIRE(ours.dtype == theirs.dtype);
    REQUIRE(ours.shape == theirs.shape);
    const auto* a = reinterpret_cast<const std::uint32_t*>(ours.bytes.data());
    const auto* b = reinterpret_cast<const std::uint32_t*>(theirs.bytes.data());
    std::size_t n = 0;
    for (std::size_t i = 0; i < ours.bytes.size() / 4; ++i) {
        const bool nan = ours.dtype == DType::f32 && std::isnan(std::bit_cast<float>(a[i])) &&
                         std::isnan(std::bit_cast<float>(b[i]));
        n += a[i] != b[i] && !nan;
    }
    return n;
}

Bundle run_here(const StageBinding& binding, const StageData& data) {
    Bundle outputs;
    binding.bind(data)->run({}, {}, outputs);
    return outputs;
}

const StageBinding& binding_of(const StageData& data) { return parity::find_binding(data.stage, "test"); }

// A picture that is all 0 would prove nothing.
double share_not_zero(const Array& array) {
    const auto* p = reinterpret_cast<const float*>(array.bytes.data());
    const std::size_t n = array.bytes.size() / 4;
    return double(std::count_if(p, p + n, [](float v) { return v != 0; })) / double(n);
}

// Expected: every compute twin has the kernel's operations in the kernel's order, and the device rounds them as IEEE
// does, so no bit differs. 37 x 23 leaves groups of 8 x 8 partly empty.
TEST_CASE("twins: every compute stage gives the kernel's bits", "[twins][vulkan]") {
    const vulkan::Device* device = exact_device();
    if (!device) return;
    for (glm::ivec2 size : {glm::ivec2(37, 23), glm::ivec2(64, 40)})
        for (const StageData& data : test::compute_cases(size)) {
            INFO(data.id << ", " << size.x << " x " << size.y);
            const StageBinding& binding = binding_of(data);
            const Bundle ours = run_here(binding, data);
            const vulkan::TwinResult theirs = vulkan::run_twin(*device, binding, data);
            REQUIRE(ours.arrays.size() == theirs.outputs.arrays.size());
            for (std::size_t i = 0; i < ours.arrays.size(); ++i) {
                CHECK(share_not_zero(ours.arrays[i]) > 0.05);
                CHECK(different(ours.arrays[i], theirs.outputs.arrays[i]) == 0);
            }
        }
    check_silence(*device);
}

// What would be missed if outputs were not read back, or inputs not sent.
TEST_CASE("twins: one point that is off by a millimetre is seen", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    StageData data = test::direct_case({37, 23}, "direct");
    const Bundle ours = run_here(binding_of(data), data);
    Array& position = data.inputs.arrays[0];
    REQUIRE(position.name == "position");
    reinterpret_cast<float*>(position.bytes.data())[4 * 45] += 0.001f;
    const vulkan::TwinResult theirs = vulkan::run_twin(*device, binding_of(data), data);
    const std::size_t components = different(ours.arrays[0], theirs.outputs.arrays[0]);
    CHECK(components > 0);
    CHECK(components <= 3);  // of that one pixel
}

// Expected: lavapipe of Mesa 22.3 stores 16-bit floats towards zero (HalfStore::truncate).
TEST_CASE("twins: what is stored as rgba16f is the kernel's value, rounded by the device", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const StageData data = test::direct_case({37, 23}, "direct");
    Bundle ours = run_here(binding_of(data), data);
    auto* p = reinterpret_cast<float*>(ours.arrays[0].bytes.data());
    for (std::size_t i = 0; i < ours.arrays[0].bytes.size() / 4; ++i)
        p[i] = half_to_float(float_to_half(p[i], HalfStore::truncate));
    const vulkan::TwinResult theirs = vulkan::run_twin(*device, binding_of(data), data, {.colour = Format::rgba16f});
    CHECK(different(ours.arrays[0], theirs.outputs.arrays[0]) == 0);
    check_silence(*device);
}

TEST_CASE("twins: a twin that is kept on the device gives the same bits again", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const StageData data = test::gather_case({37, 23}, rsm::Gather::disc, LightType::spot, 0, "rsm.disc");
    const Bundle ours = run_here(binding_of(data), data);
    vulkan::PreparedTwin twin(*device, binding_of(data), data);
    for (int i = 0; i < 3; ++i) {
        CHECK(twin.submit() > 0);
        CHECK(different(ours.arrays[0], twin.read().outputs.arrays[0]) == 0);
    }
    check_silence(*device);
}

// Expected: a face writes only what it serves, so that the dispatches of six faces fill one image.
TEST_CASE("twins: what a twin does not write is 0", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const StageData data = test::shadow_case({37, 23}, LightType::point, 3, direct::ShadowMode::hard,
                                             direct::ShadowVariant::corrected, "shadow.ny");
    const auto bound = binding_of(data).bind(data);
    const vulkan::TwinResult theirs = vulkan::run_twin(*device, binding_of(data), data);
    const auto* p = reinterpret_cast<const float*>(theirs.outputs.arrays[0].bytes.data());
    int left = 0;
    for (int y = 0; y < data.size.y; ++y)
        for (int x = 0; x < data.size.x; ++x) {
            if (bound->writes({x, y})) continue;
            ++left;
            CHECK(p[y * data.size.x + x] == 0);
        }
    CHECK(left > 0);
}

// Expected: explain() names the same values in the same order, since the twins' taps stand where the kernels' do.
TEST_CASE("twins: the taps of a pixel are the kernel's values", "[twins][vulkan][tap]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (const StageData& data : test::compute_cases({37, 23})) {
        INFO(data.id);
        const glm::ivec2 pixel = glm::min(glm::ivec2(14, 9), data.size - 1);
        const auto bound = binding_of(data).bind(data);
        if (!bound->writes(pixel)) continue;
        const std::vector<TapValue> ours = bound->explain(pixel);
        const vulkan::TwinResult theirs = vulkan::run_twin(*device, binding_of(data), data, {.tap = pixel});
        REQUIRE(ours.size() > 0);
        REQUIRE(theirs.taps.size() == ours.size());
        for (std::size_t i = 0; i < ours.size(); ++i) {
            INFO(i << " " << ours[i].name);
            CHECK(theirs.taps[i].name == ours[i].name);
            CHECK(theirs.taps[i].sample == ours[i].sample);
            CHECK(theirs.taps[i].value == ours[i].value);
        }
        // Taps change no bit of the result.
        CHECK(different(run_here(binding_of(data), data).arrays[0], theirs.outputs.arrays[0]) == 0);
    }
    check_silence(*device);
}

struct Case {
    const char* scene;
    glm::ivec2 size;
};

Scene scene_of(const std::string& name) {
    if (name == "cornell")
        return io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/cornell/cornell.toml", frame::method_tables());
    return io::generate_scene(name, {}, "test");
}

// A frame as the program renders it, and its dispatches. Maps and patterns are small where the frame is.
std::vector<StageData> frame_of(const Case& c) {
    Scene scene = scene_of(c.scene);
    scene.frame_size = c.size;
    frame::Settings settings = frame::settings_of(scene);
    if (c.size.x < 500) {
        for (Light& light : scene.lights) light.rsm_size = 128;
        settings.rsm.samples = 40;
    }
    const frame::Plan plan = frame::plan(scene, settings);
    return parity::frame_data(scene, settings, plan, frame::execute(scene, settings, plan, {}));
}

// Expected: with the profile of the driver no bit of any output differs, rasterisation too (raster/README.md).
TEST_CASE("twins: every stage of a frame gives the kernel's bits", "[twins][vulkan][frame]") {
    const vulkan::Device* device = exact_device();
    if (!device) return;
    const DeviceProfile& profile = vulkan::profile_of(*device);
    INFO(profile.name);
    REQUIRE((profile.name.starts_with("lavapipe-22.3") || profile.name.starts_with("swiftshader")));
    std::vector<Case> cases = {{"cornell", {128, 128}}, {"shapes", {250, 141}}, {"atrium", {160, 120}}};
    if (full()) cases.clear();
    for (const char* name : {"cornell", "box", "atrium", "city"})
        for (glm::ivec2 size : {glm::ivec2(1024, 1024), glm::ivec2(1000, 562)})
            if (full()) cases.push_back({name, size});
    std::size_t components = 0;
    for (const Case& c : cases)
        for (const StageData& data : frame_of(c)) {
            INFO(c.scene << ", " << c.size.x << " x " << c.size.y << ": " << data.id);
            const StageBinding& binding = binding_of(data);
            Bundle ours;
            binding.bind(data)->run({}, profile, ours);
            const vulkan::TwinResult theirs = vulkan::run_twin(*device, binding, data);
            REQUIRE(ours.arrays.size() == theirs.outputs.arrays.size());
            for (std::size_t i = 0; i < ours.arrays.size(); ++i) {
                INFO(ours.arrays[i].name);
                CHECK(different(ours.arrays[i], theirs.outputs.arrays[i]) == 0);
                components += ours.arrays[i].bytes.size() / 4;
            }
        }
    WARN(profile.name << ": " << components << " components of " << cases.size() << " frames");
    check_silence(*device);
}

// Expected: every batch has the same vertices as the whole, and the numbers of its triangles.
TEST_CASE("twins: a draw in batches gives the bits of one draw", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const std::vector<StageData> frame = frame_of({"shapes", {120, 90}});
    for (const StageData& data : frame) {
        const StageBinding& binding = binding_of(data);
        if (!binding.raster) continue;
        INFO(data.id);
        const std::int64_t vertices = at(data.inputs, "vertices").shape[0];
        const vulkan::TwinResult whole = vulkan::run_twin(*device, binding, data);
        for (std::int64_t batches : {2, 7}) {
            const std::size_t bytes = std::size_t(vertices / batches) * 8 * sizeof(float);
            const vulkan::TwinResult parts = vulkan::run_twin(*device, binding, data, {.largest_buffer = bytes});
            for (std::size_t i = 0; i < whole.outputs.arrays.size(); ++i)
                CHECK(different(whole.outputs.arrays[i], parts.outputs.arrays[i]) == 0);
        }
    }
    check_silence(*device);
}

TEST_CASE("twins: batches cover every triangle once, each with its own vertices", "[twins]") {
    // A fan around vertex 0: every batch has it.
    std::vector<std::int32_t> triangles;
    for (std::int32_t t = 0; t < 10; ++t) triangles.insert(triangles.end(), {0, t + 1, t + 2});
    const vulkan::Batches whole = vulkan::split_draw(triangles, 12, 12);
    REQUIRE(whole.list.size() == 1);
    CHECK(whole.list[0].count == 10);
    CHECK(whole.triangles.empty());

    const vulkan::Batches split = vulkan::split_draw(triangles, 12, 6);
    CHECK(split.list.size() > 1);
    std::uint32_t next = 0;
    for (const vulkan::Batch& batch : split.list) {
        CHECK(batch.first == next);
        CHECK(batch.vertices.size() <= 6);
        for (std::size_t i = 3 * batch.first; i < 3 * (batch.first + batch.count); ++i)
            CHECK(batch.vertices.at(std::size_t(split.triangles[i])) == triangles[i]);
        next += batch.count;
    }
    CHECK(next == 10);
    CHECK_THROWS_AS(vulkan::split_draw(triangles, 11, 6), InputError);  // vertex 11 is out of range
}

std::string refusal(const vulkan::Device& device, const StageBinding& binding, const StageData& data,
                    const vulkan::RunTwin& options = {}) {
    try {
        vulkan::run_twin(device, binding, data, options);
        return "";
    } catch (const vulkan::Error& error) {
        return error.what();
    }
}

TEST_CASE("twins: what cannot run is refused in one line", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const StageData data = test::direct_case({37, 23}, "direct");
    const StageBinding& binding = binding_of(data);
    const std::uint32_t words[] = {1, 2, 3};
    CHECK(refusal(*device, binding, data, {.spirv = words}) == "gi/direct/direct.comp: no SPIR-V");
    CHECK(refusal(*device, binding, data, {.tap = glm::ivec2(37, 0)}) == "direct: pixel 37,0 lies outside of 37 x 23");
    CHECK(refusal(*device, binding, data, {.colour = Format::rgba8}) == "twins write rgba32f or rgba16f, not rgba8");
    // The gather has buffers at 6 and 7, direct has none.
    const vulkan::Twin other = vulkan::find_twin("gi/rsm/gather.comp");
    CHECK(refusal(*device, binding, data, {.spirv = other.spirv}) ==
          "direct: the twin reads binding 6, which the stage does not bind");
    StageBinding missing = binding;
    missing.twin = "gi/direct/no.comp";
    CHECK(refusal(*device, missing, data) == "no twin \"gi/direct/no.comp\"");
    // Five words of header, OpCapability of two, and a part of OpExtInstImport.
    const vulkan::Spirv cut(other.spirv.begin(), other.spirv.begin() + 9);
    CHECK(refusal(*device, binding, data, {.spirv = cut}) == "SPIR-V: an instruction is cut off");
    check_silence(*device);
}

TEST_CASE("twins: what a device is too small for is refused before it is asked", "[twins][vulkan]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const std::uint32_t most = device->limits().maxImageDimension2D;
    try {
        vulkan::make_texture(*device, VK_FORMAT_R32_SFLOAT, {most + 1, 1}, nullptr, 0);
        FAIL("an image beyond the limit was made");
    } catch (const vulkan::Error& error) {
        CHECK(std::string(error.what()).find("expected " + std::to_string(most + 1) + " x 1") != std::string::npos);
    }
    check_silence(*device);
}

}  // namespace
