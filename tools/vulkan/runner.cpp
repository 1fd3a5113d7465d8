#include "tools/vulkan/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/formats.h"
#include "tools/vulkan/batches.h"
#include "tools/vulkan/choices.h"
#include "tools/vulkan/compute.h"
#include "tools/vulkan/graphics.h"
#include "tools/vulkan/taps.h"

namespace plumb::vulkan {
namespace {

constexpr std::uint32_t uniform_binding = 0;
constexpr VkShaderStageFlags compute_stage = VK_SHADER_STAGE_COMPUTE_BIT;
constexpr VkShaderStageFlags raster_stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

VkExtent2D extent(glm::ivec2 size) { return {std::uint32_t(size.x), std::uint32_t(size.y)}; }

VkFormat format_of(const Slot& slot) {
    const int i = slot.channels == 4 ? 2 : slot.channels - 1;
    constexpr VkFormat floats[] = {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT};
    constexpr VkFormat ints[] = {VK_FORMAT_R32_SINT, VK_FORMAT_R32G32_SINT, VK_FORMAT_R32G32B32A32_SINT};
    constexpr VkFormat uints[] = {VK_FORMAT_R32_UINT, VK_FORMAT_R32G32_UINT, VK_FORMAT_R32G32B32A32_UINT};
    if (slot.channels < 1 || slot.channels == 3 || slot.channels > 4)
        throw Error(fmt::format("{}: no image has {} components", slot.name, slot.channels));
    switch (slot.dtype) {
        case DType::f32:
            return floats[i];
        case DType::i32:
            return ints[i];
        case DType::u32:
            return uints[i];
        default:
            throw Error(fmt::format("{}: no image holds {}", slot.name, dtype_name(slot.dtype)));
    }
}

// Whether RunTwin::colour says how this output is stored.
bool follows_colour(const Slot& slot) { return slot.dtype == DType::f32 && slot.channels == 4; }

VkFormat output_format(const Slot& slot, Format colour) {
    if (colour != Format::rgba32f && colour != Format::rgba16f)
        throw Error(fmt::format("twins write rgba32f or rgba16f, not {}", info(colour).name));
    return colour == Format::rgba16f && follows_colour(slot) ? VK_FORMAT_R16G16B16A16_SFLOAT : format_of(slot);
}

// Whether RunTwin::maps says how this input is stored.
bool follows_maps(const Slot& slot) {
    return slot.kind != SlotKind::buffer && !slot.frame && slot.dtype == DType::f32 && slot.channels == 4;
}

// Floats as the halves that they are.
std::vector<Half> exact_halves(const StageData& data, const Array& array) {
    const float* from = reinterpret_cast<const float*>(array.bytes.data());
    std::vector<Half> halves(array.bytes.size() / sizeof(float));
    for (std::size_t i = 0; i < halves.size(); ++i) {
        halves[i] = float_to_half(from[i]);
        const float back = half_to_float(halves[i]);
        if (std::memcmp(&back, &from[i], sizeof back) != 0)
            throw Error(
                fmt::format("{}: input {} holds {}, which no 16-bit float is", data.label, array.name, from[i]));
    }
    return halves;
}

// What outputs hold where nothing is written: 0, and -1 in outputs of indices.
VkClearColorValue empty_value(const Slot& slot) {
    VkClearColorValue value{};
    if (slot.dtype == DType::i32) std::fill(std::begin(value.int32), std::end(value.int32), -1);
    return value;
}

// An input is uploaded as it lies in memory, so its shape must be the slot's.
void check_input(const StageData& data, const Slot& slot, const Array& array) {
    const std::size_t lead = slot.kind == SlotKind::image_array ? 3 : 2;
    const std::size_t rank = array.shape.size();
    const bool channels = rank == lead ? slot.channels == 1 : rank == lead + 1 && array.shape.back() == slot.channels;
    const bool fits = slot.kind == SlotKind::buffer || (channels && !array.bytes.empty());
    if (array.dtype != slot.dtype || !fits)
        throw Error(fmt::format("{}: input {} does not fit the twin: {} {}", data.label, slot.name,
                                dtype_name(array.dtype), shape_text(array.shape)));
}

// Whether a raster stage's buffer may have a row a vertex.
bool is_of_vertices(const Slot& slot) {
    return slot.name == "vertices" || slot.name == "tangents" || slot.name == "clip_positions";
}

// A column and a row of one projection or, where samples have positions, of each.
int most_choices_of(const StageData& data) {
    const Array* positions = find(data.inputs, "positions");
    return 8 + (positions ? 2 * int(positions->shape.at(0)) : 0);
}

}  // namespace

// Everything on the device. Lists are reserved before they grow: `resources` points into them.
struct PreparedTwin::Parts {
    const Device& device;
    const StageBinding& binding;
    const std::string label;
    RunTwin options;
    const VkExtent2D size;
    const bool reversed_z;
    const int most_choices;     // of a pixel
    Bundle outputs;             // as they are before anything is written
    Batches batches;            // of a raster stage
    std::int64_t vertices = 0;  // of all of them

    Twin twin;    // of the compute or the fragment stage
    Spirv spirv, vertex_spirv;  // what runs of it
    Sampler sampler;
    std::vector<Buffer> buffers;
    std::vector<Image> textures, stored;  // stored: outputs of a compute stage
    std::vector<Buffer> lists;            // the same that are buffers, mapped
    TapBuffer taps;
    ChoiceBuffer choices;
    std::vector<Resource> resources;              // that every batch sees
    std::vector<std::vector<Resource>> of_batch;  // and its own
    std::vector<DescriptorSet> sets;              // one a batch, one of a compute stage
    std::shared_ptr<const ComputePipeline> compute;
    Targets targets;
    std::shared_ptr<const GraphicsPipeline> graphics;
    bool clears = false;  // outputs, before each run
    std::vector<glm::ivec2> some;  // pixels whose groups run; empty: all
    std::uint32_t z = 0;           // of all invocations
    VkCommandBuffer commands = VK_NULL_HANDLE;

    Parts(const Device& d, const StageBinding& b, const StageData& data, const RunTwin& o);
    ~Parts() {
        if (commands) device.free(commands);
    }

    VkShaderStageFlags stages() const { return binding.raster ? raster_stages : compute_stage; }
    void choose_spirv();
    bool stores_choices() const { return options.choices && !binding.raster; }
    void upload(const StageData& data);
    void split(const StageData& data);
    void add_buffer(std::vector<Resource>& to, std::uint32_t at, VkDescriptorType type, const void* bytes,
                    std::size_t n);
    void add_input_buffer(const Slot& slot, const Array& array);
    void add_outputs();
    void bind_all();
    void make_pipelines();
    void clear_stored(VkCommandBuffer to) const;
    void empty_lists();
    void record();
    void read(const Image& image, VkImageLayout layout, Array& out) const;
};

PreparedTwin::Parts::Parts(const Device& d, const StageBinding& b, const StageData& data, const RunTwin& o)
    : device(d),
      binding(b),
      label(data.label.empty() ? data.stage : data.label),
      options(o),
      size(extent(data.size)),
      reversed_z(data.reversed_z),
      most_choices(most_choices_of(data)),
      outputs(make_outputs(b, data)) {
    if (o.tap && (o.tap->x < 0 || o.tap->y < 0 || o.tap->x >= data.size.x || o.tap->y >= data.size.y))
        throw Error(fmt::format("{}: pixel {},{} lies outside of {} x {}", label, o.tap->x, o.tap->y, data.size.x,
                                data.size.y));
    if (o.tap && o.choices) throw Error(label + ": a twin tells its taps or its choices, not both at once");
    choose_spirv();
    split(data);
    upload(data);
    add_outputs();
    bind_all();
    make_pipelines();
    record();
}

void PreparedTwin::Parts::choose_spirv() {
    const bool own = !options.spirv.empty();
    if (!own || options.tap) twin = find_twin(binding.raster ? binding.twin + ".frag" : binding.twin);
    const std::span<const std::uint32_t> code = own                ? options.spirv
                                                : options.tap      ? twin.tapped
                                                : stores_choices() ? twin.choosing
                                                                   : twin.spirv;
    spirv.assign(code.begin(), code.end());
    if (binding.raster) {
        const auto vertex = options.vertex_spirv.empty() ? find_twin(binding.twin + ".vert").spirv : options.vertex_spirv;
        vertex_spirv.assign(vertex.begin(), vertex.end());
    }
    if (options.colour == Format::rgba16f && !binding.raster) spirv = with_half_images(spirv);
    if (options.tap && binding.raster && !device.features().fragmentStoresAndAtomics)
        throw Error(
            fmt::format("Vulkan: {} has no fragmentStoresAndAtomics, which taps of {} need", device.name(), label));
}

void PreparedTwin::Parts::split(const StageData& data) {
    batches.list = {Batch{}};
    if (binding.raster) {
        const Array& triangles = at(data.inputs, "triangles");
        std::size_t row = 1;  // bytes of a vertex in the largest of its buffers
        for (const Slot& slot : binding.inputs) {
            const Array& array = at(data.inputs, slot.name);
            if (!is_of_vertices(slot) || array.bytes.empty()) continue;
            vertices = std::max(vertices, array.shape[0]);
            row = std::max(row, array.bytes.size() / std::size_t(array.shape[0]));
        }
        const std::size_t most =
            options.largest_buffer > 0 ? options.largest_buffer : std::size_t(device.limits().maxStorageBufferRange);
        batches =
            split_draw({reinterpret_cast<const std::int32_t*>(triangles.bytes.data()), triangles.bytes.size() / 4},
                       std::size_t(vertices), most / row);
    }
    of_batch.resize(batches.list.size());
}

void PreparedTwin::Parts::add_buffer(std::vector<Resource>& to, std::uint32_t at, VkDescriptorType type,
                                     const void* bytes, std::size_t n) {
    const bool uniform = type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    buffers.push_back(device_buffer(device, bytes, n,
                                    uniform ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
    to.push_back({.binding = at, .type = type, .stages = stages(), .buffer = &buffers.back()});
}

void PreparedTwin::Parts::add_input_buffer(const Slot& slot, const Array& array) {
    constexpr VkDescriptorType storage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    const std::uint32_t at = std::uint32_t(slot.binding);
    const bool whole = batches.triangles.empty();
    if (!whole && slot.name == "triangles")
        return add_buffer(resources, at, storage, batches.triangles.data(), 4 * batches.triangles.size());
    // Tangents have one row where no map reads them.
    if (whole || !is_of_vertices(slot) || array.shape[0] < vertices)
        return add_buffer(resources, at, storage, array.bytes.data(), array.bytes.size());
    for (std::size_t i = 0; i < batches.list.size(); ++i) {
        const auto rows = gather_rows(array, batches.list[i].vertices);
        add_buffer(of_batch[i], at, storage, rows.data(), rows.size());
    }
}

namespace {

Array lent(const Array& a) { return {a.name, a.dtype, a.shape, Bytes::lent(a.bytes.data(), a.bytes.size())}; }

// What stands for an optional input that is missing: 0 everywhere. Of a buffer as much as any stage reads.
Array nothing_of(const Slot& slot, glm::ivec2 size) {
    constexpr std::int64_t most_elements = 65536;
    Bundle bundle;
    if (slot.kind == SlotKind::buffer)
        return std::move(add(bundle, slot.name, slot.dtype,
                             slot.channels > 1 ? Shape{most_elements, slot.channels} : Shape{most_elements}));
    return std::move(add(bundle, slot.name, slot.dtype, {size.y, size.x, slot.channels}));
}

}  // namespace

void PreparedTwin::Parts::upload(const StageData& data) {
    buffers.reserve(1 + binding.inputs.size() * batches.list.size());
    textures.reserve(binding.inputs.size());
    sampler = make_sampler(device, VK_FILTER_NEAREST, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                           VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
    if (!data.uniforms.empty())
        add_buffer(resources, uniform_binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, data.uniforms.data(),
                   data.uniforms.size());
    for (const Slot& slot : binding.inputs) {
        const bool missing = slot.optional && !find(data.inputs, slot.name);
        const Array array = missing ? nothing_of(slot, data.size) : lent(at(data.inputs, slot.name));
        check_input(data, slot, array);
        if (slot.kind == SlotKind::buffer) {
            add_input_buffer(slot, array);
            continue;
        }
        const bool layered = slot.kind == SlotKind::image_array;
        const std::int64_t* shape = array.shape.data() + (layered ? 1 : 0);
        const VkExtent2D texels = extent({shape[1], shape[0]});
        const std::uint32_t layers = layered ? std::uint32_t(array.shape[0]) : 0;
        if (options.maps == Format::rgba16f && follows_maps(slot)) {
            const std::vector<Half> halves = exact_halves(data, array);
            textures.push_back(make_texture(device, VK_FORMAT_R16G16B16A16_SFLOAT, texels, halves.data(),
                                            halves.size() * sizeof(Half), layers));
        } else {
            textures.push_back(
                make_texture(device, format_of(slot), texels, array.bytes.data(), array.bytes.size(), layers));
        }
        resources.push_back({.binding = std::uint32_t(slot.binding),
                             .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                             .stages = stages(),
                             .image = &textures.back(),
                             .sampler = sampler.get()});
    }
}

void PreparedTwin::Parts::add_outputs() {
    stored.reserve(binding.outputs.size()), lists.reserve(binding.outputs.size());
    std::vector<VkFormat> colours;
    std::vector<VkClearValue> clear;
    for (const Slot& slot : binding.outputs) {
        if (slot.kind == SlotKind::depth) continue;
        if (slot.kind == SlotKind::storage_buffer) {
            const std::size_t bytes = at(outputs, slot.name).bytes.size();
            lists.push_back(host_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
            resources.push_back({.binding = std::uint32_t(slot.binding),
                                 .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                 .stages = stages(),
                                 .buffer = &lists.back()});
            continue;
        }
        const VkFormat format = output_format(slot, options.colour);
        if (slot.kind == SlotKind::target) {
            // Attachments are numbered by location.
            if (slot.binding != int(colours.size()))
                throw Error(fmt::format("{}: target {} has location {}; expected {}", label, slot.name, slot.binding,
                                        colours.size()));
            colours.push_back(format);
            clear.push_back({.color = empty_value(slot)});
            continue;
        }
        stored.push_back(make_storage_image(device, format, size, empty_value(slot)));
        resources.push_back({.binding = std::uint32_t(slot.binding),
                             .type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
                             .stages = stages(),
                             .image = &stored.back()});
    }
    if (!binding.raster) return;
    clear.push_back({.depthStencil = {reversed_z ? 0.0f : 1.0f, 0}});
    targets = make_targets(device, size, colours);
    targets.clear = clear;
}

void PreparedTwin::Parts::bind_all() {
    if (options.tap) {
        taps = TapBuffer(device, *options.tap);
        // The vertex stage has none.
        const VkShaderStageFlags where = binding.raster ? VK_SHADER_STAGE_FRAGMENT_BIT : VK_SHADER_STAGE_COMPUTE_BIT;
        resources.push_back({.binding = tap_binding, .stages = where, .buffer = &taps.buffer()});
    }
    if (stores_choices()) {
        choices = ChoiceBuffer(device, {int(size.width), int(size.height)}, most_choices);
        resources.push_back({.binding = choice_binding, .stages = compute_stage, .buffer = &choices.buffer()});
    }
    for (std::size_t i = 0; i < of_batch.size(); ++i) {
        std::vector<Resource> all = resources;
        all.insert(all.end(), of_batch[i].begin(), of_batch[i].end());
        for (std::uint32_t declared : declared_bindings(spirv))
            if (std::none_of(all.begin(), all.end(), [&](const Resource& r) { return r.binding == declared; }))
                throw Error(
                    fmt::format("{}: the twin reads binding {}, which the stage does not bind", label, declared));
        sets.push_back(make_descriptor_set(device, all));
    }
}

void PreparedTwin::Parts::make_pipelines() {
    if (!binding.raster) {
        compute = std::make_shared<ComputePipeline>(
            make_compute_pipeline(device, make_shader(device, spirv, binding.twin), sets[0].layout.get(), options.selects));
        return;
    }
    GraphicsOptions how;
    how.vertex_shader = vertex_spirv;
    how.fragment_shader = spirv;
    how.name = binding.twin;
    how.set = sets[0].layout.get();
    how.depth_test = reversed_z ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS;
    graphics = std::make_shared<GraphicsPipeline>(make_graphics_pipeline(device, targets, how));
}

void PreparedTwin::Parts::clear_stored(VkCommandBuffer to) const {
    auto image = stored.begin();
    for (const Slot& slot : binding.outputs) {
        if (slot.kind != SlotKind::storage_image) continue;
        const VkClearColorValue value = empty_value(slot);
        const VkImageSubresourceRange all{image->aspect, 0, 1, 0, image->layers};
        vkCmdClearColorImage(to, (image++)->image.get(), VK_IMAGE_LAYOUT_GENERAL, &value, 1, &all);
    }
    full_barrier(to);
}

// What items hold that are not written.
void PreparedTwin::Parts::empty_lists() {
    auto list = lists.begin();
    for (const Slot& slot : binding.outputs)
        if (slot.kind == SlotKind::storage_buffer) {
            const Bytes& empty = std::as_const(at(outputs, slot.name).bytes);
            std::memcpy((list++)->mapped, empty.data(), empty.size());
        }
}

void PreparedTwin::Parts::record() {
    if (commands) device.free(commands);
    commands = VK_NULL_HANDLE;
    commands = device.record([&](VkCommandBuffer to) {
        if (clears) clear_stored(to);
        if (!binding.raster && options.selects) return compute->dispatch_some(to, sets[0].set, size, some, z);
        if (!binding.raster) return compute->dispatch(to, sets[0].set, size);
        targets.begin(to);
        graphics->bind(to);
        for (std::size_t i = 0; i < sets.size(); ++i) {
            const Batch& batch = batches.list[i];
            vkCmdBindDescriptorSets(to, VK_PIPELINE_BIND_POINT_GRAPHICS, graphics->layout.get(), 0, 1, &sets[i].set, 0,
                                    nullptr);
            if (batch.count > 0) vkCmdDraw(to, 3 * batch.count, 1, 3 * batch.first, 0);
        }
        targets.end(to);
        full_barrier(to);
    });
}

void PreparedTwin::Parts::read(const Image& image, VkImageLayout layout, Array& out) const {
    if (image.format != VK_FORMAT_R16G16B16A16_SFLOAT)
        return read_image(device, image, out.bytes.data(), out.bytes.size(), layout);
    std::vector<Half> halves(out.bytes.size() / sizeof(float));
    read_image(device, image, halves.data(), halves.size() * sizeof(Half), layout);
    float* to = reinterpret_cast<float*>(out.bytes.data());
    for (std::size_t i = 0; i < halves.size(); ++i) to[i] = half_to_float(halves[i]);
}

PreparedTwin::PreparedTwin(const Device& device, const StageBinding& binding, const StageData& data,
                           const RunTwin& options)
    : parts_(std::make_unique<Parts>(device, binding, data, options)) {}
PreparedTwin::~PreparedTwin() = default;
PreparedTwin::PreparedTwin(PreparedTwin&&) noexcept = default;

double PreparedTwin::submit() {
    if (parts_->options.tap) parts_->taps.clear();
    parts_->empty_lists();
    return parts_->device.submit(parts_->commands);
}

void PreparedTwin::use(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> vertex_spirv) {
    parts_->options.spirv = spirv, parts_->options.vertex_spirv = vertex_spirv;
    parts_->choose_spirv();
    parts_->options.spirv = parts_->options.vertex_spirv = {};
    parts_->make_pipelines();
    parts_->clears = true;
    parts_->record();
}

void PreparedTwin::use(const PreparedTwin& other) {
    parts_->compute = other.parts_->compute, parts_->graphics = other.parts_->graphics;
    parts_->clears = true;
    parts_->record();
}

void PreparedTwin::select(std::uint32_t z, std::span<const glm::ivec2> pixels) {
    parts_->some.assign(pixels.begin(), pixels.end()), parts_->z = z;
    parts_->clears = true;
    parts_->record();
}

TwinResult PreparedTwin::read() {
    TwinResult result;
    result.outputs = parts_->outputs;
    auto next_stored = parts_->stored.begin();
    auto next_list = parts_->lists.begin();
    for (std::size_t i = 0; i < parts_->binding.outputs.size(); ++i) {
        const Slot& slot = parts_->binding.outputs[i];
        Array& out = result.outputs.arrays[i];
        if (slot.kind == SlotKind::storage_image)
            parts_->read(*next_stored++, VK_IMAGE_LAYOUT_GENERAL, out);
        else if (slot.kind == SlotKind::storage_buffer)
            std::memcpy(out.bytes.data(), (next_list++)->mapped, out.bytes.size());
        else if (slot.kind == SlotKind::depth)
            parts_->read(parts_->targets.depth, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, out);
        else
            parts_->read(parts_->targets.colours[std::size_t(slot.binding)], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, out);
    }
    if (parts_->options.tap) result.taps = parts_->taps.values(parts_->twin, parts_->reversed_z);
    if (parts_->stores_choices()) result.choices = parts_->choices.values(result.choices_a_pixel);
    return result;
}

TwinResult run_twin(const Device& device, const StageBinding& binding, const StageData& data, const RunTwin& options) {
    PreparedTwin twin(device, binding, data, options);
    std::vector<double> ms;
    for (int i = 0; i < std::max(options.repeat, 1); ++i) ms.push_back(twin.submit());
    std::nth_element(ms.begin(), ms.begin() + std::ptrdiff_t(ms.size() / 2), ms.end());
    TwinResult result = twin.read();
    result.ms = ms[ms.size() / 2];
    return result;
}

}  // namespace plumb::vulkan
