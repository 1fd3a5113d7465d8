#include "gi/rsm/bindings.h"

#include <cstddef>

#include "gi/bind_stage.h"
#include "gi/rsm/gather_rows.h"

namespace plumb::rsm {

namespace {

// A device binds the map as three images; our kernel reads them as records of one cache line.
Buffer<float> records_of(const StageData& d, int size) {
    const std::size_t texels = std::size_t(size) * std::size_t(size);
    Buffer<float> records(texels * record_stride);
    const float* parts[] = {floats(d, "rsm_position"), floats(d, "rsm_normal"), floats(d, "rsm_flux")};
    for (std::size_t i = 0; i < texels; ++i)
        for (std::size_t p = 0; p < 3; ++p) std::memcpy(&records[i * record_stride + 4 * p], parts[p] + 4 * i, 16);
    return records;
}

// What both gathers bind.
struct GatherOf {
    static constexpr int components = 4;
    Buffer<float> records;
    GatherInputsView<float> view{};

    explicit GatherOf(const StageData& d) {
        const GatherUniforms& u = view.u = uniforms_of_frame<GatherUniforms>(d);
        for (const char* name : {"rsm_position", "rsm_normal", "rsm_flux"}) check_map(d, name, u.map.size);
        records = records_of(d, u.map.size);
        view.position = floats(d, "position"), view.normal = floats(d, "normal");
        view.records = records.data();
    }
    bool writes(glm::ivec2) const { return true; }
};

struct DiscOf : GatherOf {
    explicit DiscOf(const StageData& d) : GatherOf(d) {
        const GatherUniforms& u = view.u;
        if (u.samples < 0 || u.rotations < 1 || (u.rotations & (u.rotations - 1)) != 0)
            throw InputError(fmt::format("{}: samples = {}, rotations = {}: expected 0 or more, and a power of two",
                                         d.label, u.samples, u.rotations));
        const std::size_t offsets = at(d.inputs, "offsets").bytes.size() / 4;
        const std::size_t weights = at(d.inputs, "weights").bytes.size() / 4;
        if (offsets < std::size_t(u.samples) * std::size_t(u.rotations) || weights < std::size_t(u.samples))
            throw InputError(fmt::format("{}: {} offsets and {} weights: expected {} x {} and {}", d.label, offsets,
                                         weights, u.samples, u.rotations, u.samples));
        if (u.reach < 0 || u.reach > 32768)
            throw InputError(fmt::format("{}: reach = {}: expected 0 to 32768", d.label, u.reach));
        view.offsets = ints(d, "offsets"), view.weights = floats(d, "weights");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec3<F> e = gather_disc<F>(view, x, y, tap);
        return {e.x, e.y, e.z, F(0.0f)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        GatherInputsView<float> v = view;
        v.irradiance = out;
        GatherRows<isa, float>::disc(v, first, last);
    }
};

struct AllOf : GatherOf {
    using GatherOf::GatherOf;
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec3<F> e = gather_all<F>(view, x, y, tap);
        return {e.x, e.y, e.z, F(0.0f)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        GatherInputsView<float> v = view;
        v.irradiance = out;
        GatherRows<isa, float>::all(v, first, last);
    }
};

// What both gathers share.
StageBinding gather_binding(const StageInfo& info) {
    using U = GatherUniforms;
    StageBinding b;
    b.info = info;
    b.twin = info.twin;
    b.uniforms = members_after_map(offsetof(U, map), {{"least_distance2", "float", offsetof(U, least_distance2)},
                                                      {"scale", "float", offsetof(U, scale)},
                                                      {"samples", "int", offsetof(U, samples)},
                                                      {"rotations", "int", offsetof(U, rotations)},
                                                      {"width", "int", offsetof(U, width)},
                                                      {"height", "int", offsetof(U, height)},
                                                      {"seed", "uint", offsetof(U, seed)},
                                                      {"reach", "int", offsetof(U, reach)}});
    b.uniform_bytes = sizeof(U);
    b.inputs = {
        {.name = "position", .binding = 1, .unit = "m", .meaning = "world-space position of the shading points"},
        {.name = "normal", .binding = 2, .meaning = "unit normal of the shading points"},
        {.name = "rsm_position", .binding = 3, .frame = false, .unit = "m", .meaning = "world-space position"},
        {.name = "rsm_normal", .binding = 4, .frame = false, .meaning = "unit normal"},
        {.name = "rsm_flux", .binding = 5, .frame = false, .unit = "W", .meaning = "reflected flux of the texel"},
    };
    b.outputs = {{.name = "irradiance", .kind = SlotKind::storage_image, .binding = 6, .unit = "W/m2",
                  .meaning = "indirect irradiance, one bounce"}};
    return b;
}

StageBinding make_disc() {
    StageBinding b = gather_binding(info_disc());
    b.inputs.push_back({.name = "offsets", .kind = SlotKind::buffer, .binding = 6, .dtype = DType::i32, .channels = 1,
                        .frame = false, .unit = "texels",
                        .meaning = "[samples][rotations]: dx in the lower 16 bits, dy in the upper 16"});
    b.inputs.push_back({.name = "weights", .kind = SlotKind::buffer, .binding = 7, .channels = 1, .frame = false,
                        .unit = "texels", .meaning = "[samples]: texels that a sample stands for"});
    b.outputs[0].binding = 8;
    b.bind = bind_kernel<DiscOf, disc_binding>;
    return b;
}

StageBinding make_all() {
    StageBinding b = gather_binding(info_all());
    b.bind = bind_kernel<AllOf, all_binding>;
    return b;
}

}  // namespace

const StageBinding& disc_binding() {
    static const StageBinding binding = make_disc();
    return binding;
}
const StageBinding& all_binding() {
    static const StageBinding binding = make_all();
    return binding;
}

StageData gather_data(const GatherParams& params, const GatherInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = stage_name(params.gather);
    d.size = {in.position->width, in.position->height};
    d.uniforms = uniform_block(gather_uniforms(params, in));
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "rsm_position", in.rsm->position);
    add(d.inputs, "rsm_normal", in.rsm->normal);
    add(d.inputs, "rsm_flux", in.rsm->flux);
    if (params.gather != Gather::disc) return d;
    add(d.inputs, "offsets", {in.pattern->samples, in.pattern->rotations}, in.pattern->offsets.data());
    add(d.inputs, "weights", {in.pattern->samples}, in.pattern->weights.data());
    return d;
}

}  // namespace plumb::rsm
