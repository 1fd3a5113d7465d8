// Depth peeling on a device: the stage of layers against its twin, layer after layer.
#include <catch2/catch.hpp>
#include <cstring>

#include "core/camera.h"
#include "devices.h"
#include "io/scene_file.h"
#include "raster/bindings.h"
#include "raster/gbuffer.h"
#include "tools/vulkan/profile.h"
#include "tools/vulkan/runner.h"

using namespace plumb;

namespace {

constexpr glm::ivec2 size(250, 141);

Image1 depth_of(const Bundle& outputs) {
    Image1 depth(size.x, size.y);
    std::memcpy(depth.data(), at(outputs, "depth").bytes.data(), 4 * depth.size());
    return depth;
}

std::size_t different(const Bundle& ours, const Bundle& theirs) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < ours.arrays.size(); ++i) {
        const auto &a = ours.arrays[i].bytes, &b = theirs.arrays[i].bytes;
        REQUIRE(a.size() == b.size());
        for (std::size_t k = 0; k < a.size(); k += 4) n += std::memcmp(a.data() + k, b.data() + k, 4) != 0;
    }
    return n;
}

}  // namespace

// Expected: with the profile of the driver no bit of any layer differs. Behind the device's own depths no pixel shows what
// does not lie farther: gl_FragCoord.z is the depth that the test compares. Behind ours it does, where the device's depths
// differ in their last bits, and the kernel says which pixels these are.
TEST_CASE("twins: layers behind layers give the kernel's bits", "[twins][vulkan][peel]") {
    const vulkan::Device* device = test::first_of({"llvmpipe", "SwiftShader"}, "neither lavapipe nor SwiftShader here");
    if (!device) return;
    const DeviceProfile& profile = vulkan::profile_of(*device);
    for (const char* name : {"cornell", "atrium"})
        for (bool reversed : {false, true}) {
            Scene scene = io::load_scene(std::string(PLUMB_SOURCE_DIR "/data/scenes/") + name + "/" + name + ".toml",
                                         {"rsm", "shadow", "direct", "tonemap", "path"});
            scene.camera.reversed_z = reversed;
            const Geometry g = flatten(scene);
            const raster::Surfaces surfaces = raster::prepare(scene, g);
            const View view = make_view(scene.camera, double(size.x) / size.y);
            raster::GBuffer ours;
            raster::draw_gbuffer(g, surfaces, view, size, raster::Layout::fp32, {}, ours);
            const StageData first = raster::gbuffer_data(g, surfaces, view, size);
            Image1 behind = depth_of(vulkan::run_twin(*device, raster::gbuffer_binding(), first).outputs);
            for (int layer = 2; layer <= 5; ++layer) {
                CAPTURE(name, reversed, layer);
                if (layer == 5) behind = ours.depth;
                const StageData data = raster::gbuffer_layer_data(g, surfaces, view, size, behind);
                Bundle kernel;
                raster::gbuffer_layer_binding().bind(data)->run({}, profile, kernel);
                const vulkan::TwinResult twin = vulkan::run_twin(*device, raster::gbuffer_layer_binding(), data);
                CHECK(different(kernel, twin.outputs) == 0);
                const Image1 depth = depth_of(twin.outputs);
                std::size_t seen = 0, nearer = 0;
                for (std::size_t i = 0; i < depth.size(); ++i) {
                    if (depth.texels[i] == (reversed ? 0.0f : 1.0f)) continue;
                    ++seen;
                    nearer += !(reversed ? depth.texels[i] < behind.texels[i] : depth.texels[i] > behind.texels[i]);
                }
                CHECK(seen > 100);
                CHECK(nearer == 0);
                behind = depth;
            }
        }
    for (const std::string& complaint : device->complaints()) UNSCOPED_INFO(complaint);
    CHECK(device->complaints().empty());
}
