// The discrete choices that a twin stores: core/tap.glsl, compiled with PLUMB_CHOICES.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <iostream>

#include "core/hash.h"
#include "core/tap.h"
#include "raster/project_kernel.h"
#include "tools/vulkan/compute.h"

namespace {

using namespace plumb;

constexpr int width = 21, height = 10, per_pixel = 3;  // project() makes two choices: the third stays as it was

struct Choices {
    std::int32_t width = ::width, per_pixel = ::per_pixel;
    std::int32_t index[height][::width][::per_pixel];
};

// A perspective map of 64 texels, 1 m below the points' middle.
raster::Projection map_of_64() {
    return {{40, 3, 32, 5}, {-2, 41, 32, 4}, {0.01f, 0.02f, 1, 0.5f}, 1e-3f, -1e6f, 1e6f, 64};
}

std::vector<glm::vec4> points() {
    std::vector<glm::vec4> out;
    for (int i = 0; i < width * height; ++i) {
        const auto h = pixel_hash<std::int32_t>(i, 0, 0, 3);
        auto coordinate = [](std::int32_t bits) { return float(bits & 0xffff) / 32768 - 1; };
        out.push_back({coordinate(h.x), coordinate(h.y), coordinate(h.z), 1});
    }
    return out;
}

}  // namespace

TEST_CASE("choices: a twin stores the texels that it chose, a pixel's own together", "[vulkan][choices]") {
    const std::vector<std::string> names = vulkan::device_names();
    if (std::none_of(names.begin(), names.end(),
                     [](const std::string& n) { return n.find("llvmpipe") != std::string::npos; })) {
        std::cout << "SKIPPED: no lavapipe here (mesa-vulkan-drivers)\n";
        return;
    }
    const vulkan::Device device({.name = "llvmpipe", .validate = true});
    const raster::Projection map = map_of_64();
    const std::vector<glm::vec4> x = points();
    const auto usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const vulkan::Buffer map_buffer = vulkan::device_buffer(device, &map, sizeof map, usage);
    const vulkan::Buffer point_buffer = vulkan::device_buffer(device, x.data(), x.size() * sizeof x[0], usage);
    const vulkan::Buffer texels = vulkan::host_buffer(device, x.size() * sizeof(glm::ivec2), usage);
    const vulkan::Buffer chosen = vulkan::host_buffer(device, sizeof(Choices), usage);
    Choices empty;
    std::fill_n(&empty.index[0][0][0], width * height * per_pixel, -77);
    std::memcpy(chosen.mapped, &empty, sizeof empty);

    const std::vector<vulkan::Resource> resources{{.binding = 0, .buffer = &map_buffer},
                                                  {.binding = 1, .buffer = &point_buffer},
                                                  {.binding = 2, .buffer = &texels},
                                                  {.binding = 30, .buffer = &chosen}};
    const vulkan::DescriptorSet set = vulkan::make_descriptor_set(device, resources);
    const vulkan::Spirv spirv = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.parity.choices.comp.spv");
    const vulkan::ComputePipeline pipeline =
        vulkan::make_compute_pipeline(device, vulkan::make_shader(device, spirv, "choices"), set.layout.get());
    device.run([&](VkCommandBuffer commands) {
        pipeline.dispatch(commands, set.set, {width, height});
        vulkan::full_barrier(commands);
    });

    const auto* stored = static_cast<const Choices*>(chosen.mapped);
    int different = 0;
    for (int i = 0; i < width * height; ++i) {
        NoTap tap;
        const glm::vec4& p = x[std::size_t(i)];
        const ivec2<std::int32_t> expected = raster::project<float>(map, vec3<float>(p.x, p.y, p.z), tap);
        const std::int32_t* c = stored->index[i / width][i % width];
        different += !(c[0] == expected.x && c[1] == expected.y && c[2] == -77);
    }
    CHECK(different == 0);
    CHECK(stored->index[0][0][0] != stored->index[1][0][0]);  // the points differ
    for (const std::string& complaint : device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(device.complaints().empty());
}
