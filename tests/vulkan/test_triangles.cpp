// The rasterizer's rules against a Vulkan driver that states the same ones: 8 bits of subpixel, top-left rule.
#include <algorithm>
#include <catch2/catch.hpp>
#include <iostream>

#include "core/hash.h"
#include "raster/visibility.h"
#include "tools/vulkan/graphics.h"

namespace {

using namespace plumb;

constexpr int side = 256;

// Corners at multiples of 1/256 pixel, so that no arithmetic between here and the edge functions rounds: both sides
// must agree in every pixel. One depth a triangle.
std::vector<glm::vec4> corners(int triangles) {
    std::vector<glm::vec4> out;
    for (int i = 0; i < 3 * triangles; ++i) {
        const auto h = pixel_hash<std::int32_t>(i, 0, 0, 7);
        auto coordinate = [](std::int32_t bits) { return float(bits & 0xffff) / 32768 - 1; };
        out.push_back(
            {coordinate(h.x), coordinate(h.y), float(1 + (i / 3 * 37) % triangles) / float(triangles + 2), 1});
    }
    return out;
}

Image1 draw_on_device(const vulkan::Device& device, const std::vector<glm::vec4>& clip) {
    const vulkan::Targets targets = vulkan::make_targets(device, {side, side}, {VK_FORMAT_R32_SFLOAT});
    vulkan::GraphicsOptions options;
    options.vertex_shader = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.vulkan.triangles.vert.spv");
    options.fragment_shader = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.vulkan.triangles.frag.spv");
    options.name = "tests/vulkan/triangles";
    options.stride = sizeof(glm::vec4);
    options.attributes = {{VK_FORMAT_R32G32B32A32_SFLOAT, 0}};
    const vulkan::GraphicsPipeline pipeline = vulkan::make_graphics_pipeline(device, targets, options);
    const vulkan::Buffer vertices =
        vulkan::device_buffer(device, clip.data(), clip.size() * sizeof(glm::vec4), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    device.run([&](VkCommandBuffer commands) {
        targets.begin(commands);
        pipeline.bind(commands);
        const VkBuffer buffer = vertices.get();
        const VkDeviceSize offset = 0;
        vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
        vkCmdDraw(commands, std::uint32_t(clip.size()), 1, 0, 0);
        targets.end(commands);
    });
    Image1 out(side, side);
    vulkan::read_image(device, targets.colours[0], out.data(), out.size() * sizeof(float));
    return out;
}

raster::VisibilityBuffer draw_here(const std::vector<glm::vec4>& clip) {
    Geometry geometry;
    for (const glm::vec4& c : clip) geometry.vertices.push_back({glm::vec3(c), 0, glm::vec3(0, 0, 1), 0});
    for (unsigned i = 0; i < clip.size(); i += 3) geometry.triangles.push_back({i, i + 1, i + 2});
    geometry.material.assign(geometry.triangles.size(), 0);
    geometry.object.assign(geometry.triangles.size(), 0);
    return raster::draw_visibility(geometry, View{}, {side, side}, {});
}

TEST_CASE("vulkan: a device that is not there is an error that names those that are", "[vulkan]") {
    const std::vector<std::string> names = vulkan::device_names();
    if (names.empty()) return;
    try {
        vulkan::Device device({.name = "no such device"});
        FAIL("it was found");
    } catch (const vulkan::Error& error) {
        CHECK(std::string(error.what()).find("no such device") != std::string::npos);
        CHECK(std::string(error.what()).find(names[0]) != std::string::npos);
    }
}

// Expected: lavapipe snaps to 1/256 pixel and follows the top-left rule, as raster/visibility.h does.
TEST_CASE("vulkan: lavapipe sees the same triangle in every pixel", "[vulkan][raster]") {
    const std::vector<std::string> names = vulkan::device_names();
    if (std::none_of(names.begin(), names.end(),
                     [](const std::string& n) { return n.find("llvmpipe") != std::string::npos; })) {
        std::cout << "SKIPPED: no lavapipe here (mesa-vulkan-drivers)\n";
        return;
    }
    const vulkan::Device device({.name = "llvmpipe", .validate = true});
    for (int triangles : {1, 40}) {
        const std::vector<glm::vec4> clip = corners(triangles);
        const Image1 theirs = draw_on_device(device, clip);
        const raster::VisibilityBuffer ours = draw_here(clip);
        int covered = 0, different = 0;
        for (std::size_t i = 0; i < theirs.size(); ++i) {
            covered += theirs.texels[i] > 0;
            different += !(theirs.texels[i] == float(ours.triangle.texels[i] + 1));
        }
        INFO(triangles << " triangles, " << covered << " pixels covered");
        CHECK(covered > side);
        CHECK(covered < side * side);
        CHECK(different == 0);
    }
    for (const std::string& complaint : device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(device.complaints().empty());
}

}  // namespace
