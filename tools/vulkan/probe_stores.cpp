// How a device rounds what it stores to images and colour targets, and how it filters them.
#include <algorithm>
#include <cstring>
#include <set>

#include <fmt/format.h>

#include "core/formats.h"
#include "core/hash.h"
#include "tools/vulkan/compute.h"
#include "tools/vulkan/graphics.h"
#include "tools/vulkan/probe.h"
#include "tools/vulkan/twins.h"

namespace plumb::vulkan {
namespace {

constexpr int columns = 256, rows = 256, count = columns * rows;
constexpr VkExtent2D whole{columns, rows};

Spirv embedded(const char* name) {
    const Twin twin = find_twin(name);
    return {twin.spirv.begin(), twin.spirv.end()};
}

bool supports(const Device& device, VkFormat format, VkFormatFeatureFlags wanted) {
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(device.physical(), format, &properties);
    return (properties.optimalTilingFeatures & wanted) == wanted;
}

std::int32_t word(int i, int component, int seed) { return pixel_hash<std::int32_t>(i, component, 0, seed).x; }
float between(std::int32_t w, float low, float high) { return low + (high - low) * unit_float<float>(w); }

// ---- Stores ---------------------------------------------------------------------------------------------------------

// By turns: any float that a half can hold or nearly so; a tie between two halves; what 8 and 10 bits hold and a little
// more; a tie between two of their codes. The first texel has what overflows.
float stored_value(int i, int component) {
    constexpr float overflow[] = {65519.0f, 65520.0f, 131072.0f, 1e6f};
    if (i == 0) return overflow[component];  // not counted with the others
    const std::int32_t w = word(i, component, 2);
    const std::uint32_t u = std::uint32_t(w);
    const std::int32_t exponent = 127 - 26 + std::int32_t((u >> 8) % 42);
    switch (i % 4) {
        case 0:
            return number<float>::from_bits(std::int32_t(u & 0x807fffffu) | exponent << 23);
        case 1:
            return number<float>::from_bits(std::int32_t(u & 0x807fe000u) | 0x1000 | exponent << 23);
        case 2:
            return between(w, -0.2f, 1.2f);
        default:
            return (float(u >> 8 & 0x3ff) + 0.5f) / (i % 8 == 3 ? 255.0f : 1023.0f);
    }
}

std::vector<glm::vec4> stored_values() {
    std::vector<glm::vec4> out(count);
    for (int i = 0; i < count; ++i)
        for (int c = 0; c < 4; ++c) out[std::size_t(i)][c] = stored_value(i, c);
    return out;
}

// The bits of each component in a packed texel, red lowest.
glm::ivec4 widths(Format format) {
    if (format == Format::rgba16f) return glm::ivec4(16);
    if (format == Format::rgba8) return glm::ivec4(8);
    return format == Format::r11g11b10f ? glm::ivec4(11, 11, 10, 0) : glm::ivec4(10, 10, 10, 2);
}

// Codes of a value's components: nearest; towards zero, where the nearest is farther from it; the first 10 bits of the
// nearest of 16.
struct Codes {
    std::uint32_t nearest[4], truncated[4], cut[4];
};
std::uint64_t packed_texel(const void* texel, Format format) {
    std::uint64_t packed = 0;
    std::memcpy(&packed, texel, std::size_t(info(format).bytes));
    return packed;
}
void take_apart(std::uint64_t packed, Format format, std::uint32_t out[4]) {
    const glm::ivec4 w = widths(format);
    for (int c = 0; c < 4; packed >>= w[c++]) out[c] = std::uint32_t(packed & ((std::uint64_t(1) << w[c]) - 1));
}
Codes codes_of(Format format, const glm::vec4& value) {
    Codes out;
    unsigned char texel[8];
    encode(format, value, texel);
    take_apart(packed_texel(texel, format), format, out.nearest);
    const glm::vec4 nearest = decode(format, texel);
    for (int c = 0; c < 4; ++c) {
        out.cut[c] = widths(format)[c] == 10 ? std::uint32_t(encode_unorm(value[c], 16)) >> 6 : out.nearest[c];
        out.truncated[c] = out.nearest[c] - (std::abs(nearest[c]) > std::abs(value[c]) && nearest[c] * value[c] > 0);
    }
    return out;
}

StoreFigures compare_texels(const std::string& name, Format format, const std::vector<glm::vec4>& values,
                            const std::vector<unsigned char>& texels) {
    StoreFigures out{name, 0};
    const std::size_t bytes = std::size_t(info(format).bytes);
    for (int i = 1; i < count; ++i) {
        const glm::vec4& value = values[std::size_t(i)];
        const Codes codes = codes_of(format, value);
        const unsigned char* texel = texels.data() + std::size_t(i) * bytes;
        std::uint32_t stored[4];
        take_apart(packed_texel(texel, format), format, stored);
        for (int c = 0; c < info(format).channels; ++c) {
            const bool nearest = stored[c] == codes.nearest[c], truncated = stored[c] == codes.truncated[c];
            ++out.values;
            out.not_nearest += !nearest;
            out.not_truncated += !truncated;
            out.not_cut += stored[c] != codes.cut[c];
            out.neither += !nearest && !truncated;
            if (!nearest && out.example.empty())
                out.example = fmt::format("{:.9g} as {:.9g}", value[c], decode(format, texel)[c]);
        }
    }
    return out;
}

std::vector<unsigned char> store(const Device& device, const Buffer& values, VkFormat format, Format as,
                                 const char* shader) {
    const Image image = make_storage_image(device, format, whole, {});
    const std::vector<Resource> resources{
        {.binding = 0, .buffer = &values},
        {.binding = 1, .type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, .image = &image}};
    const DescriptorSet set = make_descriptor_set(device, resources);
    const ComputePipeline pipeline =
        make_compute_pipeline(device, make_shader(device, embedded(shader), shader), set.layout.get());
    device.run([&](VkCommandBuffer commands) { pipeline.dispatch(commands, set.set, whole); });
    std::vector<unsigned char> texels(std::size_t(count) * std::size_t(info(as).bytes));
    read_image(device, image, texels.data(), texels.size(), VK_IMAGE_LAYOUT_GENERAL);
    return texels;
}

std::vector<unsigned char> draw(const Device& device, const Buffer& values, VkFormat format, Format as) {
    const Targets targets = make_targets(device, whole, {format});
    const std::vector<Resource> resources{
        {.binding = 0, .stages = VK_SHADER_STAGE_FRAGMENT_BIT, .buffer = &values}};
    const DescriptorSet set = make_descriptor_set(device, resources);
    GraphicsOptions options;
    options.vertex_shader = embedded("tools/probe/triangles.vert");
    options.fragment_shader = embedded("tools/probe/attachment.frag");
    options.name = "tools/probe/attachment";
    options.stride = sizeof(glm::vec4);
    options.attributes = {{VK_FORMAT_R32G32B32A32_SFLOAT, 0}};
    options.set = set.layout.get();
    const GraphicsPipeline pipeline = make_graphics_pipeline(device, targets, options);
    const glm::vec4 corners[3] = {{-1, -1, 0, 1}, {3, -1, 0, 1}, {-1, 3, 0, 1}};
    const Buffer vertices = device_buffer(device, corners, sizeof corners, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    device.run([&](VkCommandBuffer commands) {
        targets.begin(commands);
        pipeline.bind(commands);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.layout.get(), 0, 1, &set.set, 0,
                                nullptr);
        const VkBuffer buffer = vertices.get();
        const VkDeviceSize offset = 0;
        vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
        vkCmdDraw(commands, 3, 1, 0, 0);
        targets.end(commands);
    });
    std::vector<unsigned char> texels(std::size_t(count) * std::size_t(info(as).bytes));
    read_image(device, targets.colours[0], texels.data(), texels.size());
    return texels;
}

// ---- Filters --------------------------------------------------------------------------------------------------------

struct Filtered {
    const char* name;
    VkFormat format;
    Format as;
};
constexpr Filtered filtered_formats[] = {{"rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT, Format::rgba32f},
                                         {"rgba16f", VK_FORMAT_R16G16B16A16_SFLOAT, Format::rgba16f},
                                         {"rgba8", VK_FORMAT_R8G8B8A8_UNORM, Format::rgba8}};

// The texture at `count` places; its texels are rounded to the format first.
std::vector<glm::vec4> sample(const Device& device, const Filtered& f, glm::ivec2 size, std::vector<glm::vec4>& texels,
                              const std::vector<glm::vec2>& places) {
    std::vector<unsigned char> stored(texels.size() * std::size_t(info(f.as).bytes));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        encode(f.as, texels[i], stored.data() + i * std::size_t(info(f.as).bytes));
        quantise(f.as, texels[i]);
    }
    const Image texture = make_texture(device, f.format, {std::uint32_t(size.x), std::uint32_t(size.y)}, stored.data(),
                                       stored.size());
    const Sampler sampler = make_sampler(device, VK_FILTER_LINEAR, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
    const auto usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const Buffer in = device_buffer(device, places.data(), places.size() * sizeof places[0], usage);
    const Buffer out = host_buffer(device, places.size() * sizeof(glm::vec4), usage);
    const std::vector<Resource> resources{{.binding = 0,
                                           .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                           .image = &texture,
                                           .sampler = sampler.get()},
                                          {.binding = 1, .buffer = &in},
                                          {.binding = 2, .buffer = &out}};
    const DescriptorSet set = make_descriptor_set(device, resources);
    const ComputePipeline pipeline = make_compute_pipeline(
        device, make_shader(device, embedded("tools/probe/filter.comp"), "filter.comp"), set.layout.get());
    device.run([&](VkCommandBuffer commands) { pipeline.dispatch(commands, set.set, whole); });
    const auto* results = static_cast<const glm::vec4*>(out.mapped);
    return {results, results + count};
}

// From black to white in 65,536 steps. A float's weights here are all different but for some near a half; an eighth of
// them would still be 13 bits.
void count_weights(const Device& device, const Filtered& f, FilterFigures& figures) {
    std::vector<glm::vec4> texels{glm::vec4(0), glm::vec4(1)};
    std::vector<glm::vec2> places(count);
    for (int i = 0; i < count; ++i) places[std::size_t(i)] = {0.25f + 0.5f * float(i) / count, 0.5f};
    std::set<float> weights;
    for (const glm::vec4& v : sample(device, f, {2, 1}, texels, places)) weights.insert(v.x);
    figures.weights = int(weights.size());
    for (int bits = 1; bits < 13 && figures.bits == 0; ++bits)
        if (figures.weights <= (1 << bits) + 1) figures.bits = bits;
}

double exact_mean(const std::vector<glm::vec4>& texels, int side, glm::vec2 place) {
    const double x = double(place.x) * side - 0.5, y = double(place.y) * side - 0.5;
    const int column = int(x < 0 ? x - 1 : x), row = int(y < 0 ? y - 1 : y);
    auto texel = [&](int i, int k) {
        return double(texels[std::size_t(std::clamp(k, 0, side - 1) * side + std::clamp(i, 0, side - 1))].x);
    };
    auto mix = [](double a, double b, double c) { return a + (b - a) * c; };
    return mix(mix(texel(column, row), texel(column + 1, row), x - column),
               mix(texel(column, row + 1), texel(column + 1, row + 1), x - column), y - row);
}

void measure_deviation(const Device& device, const Filtered& f, FilterFigures& figures) {
    constexpr int side = 8;
    std::vector<glm::vec4> texels(side * side);
    for (int i = 0; i < side * side; ++i) texels[std::size_t(i)] = glm::vec4(between(word(i, 0, 3), 0, 1));
    std::vector<glm::vec2> places(count);
    for (int i = 0; i < count; ++i)
        places[std::size_t(i)] = {between(word(i, 0, 4), 0, 1), between(word(i, 1, 4), 0, 1)};
    const std::vector<glm::vec4> results = sample(device, f, {side, side}, texels, places);
    for (int i = 0; i < count; ++i)
        figures.worst = std::max(figures.worst, std::abs(double(results[std::size_t(i)].x) -
                                                         exact_mean(texels, side, places[std::size_t(i)])));
}

}  // namespace

void probe_stores(const Device& device, Probe& probe) {
    const std::vector<glm::vec4> values = stored_values();
    const Buffer buffer = device_buffer(device, values.data(), values.size() * sizeof values[0],
                                        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    // Images that every device stores to.
    const auto halves =
        store(device, buffer, VK_FORMAT_R16G16B16A16_SFLOAT, Format::rgba16f, "tools/probe/store_half.comp");
    probe.stores.push_back(compare_texels("rgba16f storage image", Format::rgba16f, values, halves));
    Half overflow[4];
    std::memcpy(overflow, halves.data(), sizeof overflow);
    auto text = [&](int c) {
        const float x = half_to_float(overflow[c]);
        return x == x ? fmt::format("{:g}", x) : std::string("NaN");
    };
    probe.half_overflow = fmt::format("65519: {}, 65520: {}, 131072: {}, 1e6: {}", text(0), text(1), text(2), text(3));
    probe.stores.push_back(compare_texels(
        "rgba8 storage image", Format::rgba8, values,
        store(device, buffer, VK_FORMAT_R8G8B8A8_UNORM, Format::rgba8, "tools/probe/store_unorm.comp")));

    // Colour targets, as far as there are.
    const std::tuple<const char*, VkFormat, Format> targets[] = {
        {"rgba16f colour target", VK_FORMAT_R16G16B16A16_SFLOAT, Format::rgba16f},
        {"rgba8 colour target", VK_FORMAT_R8G8B8A8_UNORM, Format::rgba8},
        {"r11g11b10f colour target", VK_FORMAT_B10G11R11_UFLOAT_PACK32, Format::r11g11b10f},
        {"r10g10b10a2 colour target", VK_FORMAT_A2B10G10R10_UNORM_PACK32, Format::r10g10b10a2}};
    for (const auto& [name, format, as] : targets) {
        if (supports(device, format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT))
            probe.stores.push_back(compare_texels(name, as, values, draw(device, buffer, format, as)));
        else
            probe.stores.push_back({name, 0});
    }
}

void probe_filters(const Device& device, Probe& probe) {
    for (const Filtered& f : filtered_formats) {
        FilterFigures figures;
        figures.format = f.name;
        figures.supported = supports(device, f.format, VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT);
        if (figures.supported) {
            count_weights(device, f, figures);
            measure_deviation(device, f, figures);
        }
        probe.filters.push_back(figures);
    }
}

}  // namespace plumb::vulkan
