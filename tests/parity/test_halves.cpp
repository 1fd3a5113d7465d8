// What planted errors keep in 16 bits is the nearest half, as core/formats.h has it.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/formats.h"
#include "core/hash.h"
#include "tests/parity/devices.h"
#include "tools/vulkan/compute.h"
#include "tools/vulkan/runner.h"

using namespace plumb;

TEST_CASE("planted errors: half_of() is the nearest half of every number", "[vulkan][mutants]") {
    const vulkan::Device* found = test::lavapipe();
    if (!found) return;
    const vulkan::Device& device = *found;
    // Every finite half, the floats next to it and next to the tie above it; random bits.
    std::vector<float> x;
    for (int h = 0; h < 0x7c00; h += 7)
        for (const float sign : {1.0f, -1.0f}) {
            const float low = half_to_float(Half{std::uint16_t(h)}), high = h + 1 < 0x7c00 ? half_to_float(Half{std::uint16_t(h + 1)}) : 65536.0f;
            const float tie = 0.5f * (low + high);
            for (const float middle : {low, tie})
                for (const float to : {-1e9f, middle, 1e9f}) x.push_back(sign * std::nextafter(middle, to));
        }
    for (const float special : {0.0f, -0.0f, 65504.0f, 65519.996f, 65520.0f, -70000.0f, 1e30f, HUGE_VALF, -HUGE_VALF, NAN, 0x1p-25f, 0x1.000002p-25f})
        x.push_back(special);
    for (int i = 0; i < 20000; ++i) x.push_back(number<float>::from_bits(pcg<std::int32_t>(i)));
    const int rows = int(x.size() + 255) / 256;
    x.resize(std::size_t(256) * std::size_t(rows), 1.0f);

    const auto usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const vulkan::Buffer numbers = vulkan::device_buffer(device, x.data(), x.size() * sizeof x[0], usage);
    const vulkan::Buffer halves = vulkan::host_buffer(device, x.size() * sizeof x[0], usage);
    const std::vector<vulkan::Resource> resources{{.binding = 0, .buffer = &numbers}, {.binding = 1, .buffer = &halves}};
    const vulkan::DescriptorSet set = vulkan::make_descriptor_set(device, resources);
    const vulkan::Spirv spirv = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.parity.halves.comp.spv");
    const vulkan::ComputePipeline pipeline =
        vulkan::make_compute_pipeline(device, vulkan::make_shader(device, spirv, "halves"), set.layout.get());
    device.run([&](VkCommandBuffer commands) {
        pipeline.dispatch(commands, set.set, {256, std::uint32_t(rows)});
        vulkan::full_barrier(commands);
    });

    int wrong = 0, kept = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        float got;
        std::memcpy(&got, static_cast<const char*>(halves.mapped) + 4 * i, 4);
        const float expected = half_to_float(float_to_half(x[i], HalfStore::nearest));
        const bool same = std::memcmp(&got, &expected, 4) == 0 || (got != got && expected != expected);
        wrong += !same, kept += got == x[i];
    }
    CHECK(wrong == 0);
    CHECK(kept < int(x.size()) / 2);
    CHECK(device.complaints().empty());
}
