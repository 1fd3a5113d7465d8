#include "gi/rsm/bindings.h"

#include <cstddef>

#include "gi/bind_stage.h"
#include "gi/rsm/gather_rows.h"
#include "gi/rsm/paths.h"
#include "gi/rsm/paths_rows.h"

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

// What all gathers bind. View is GatherInputsView or PathsInputsView.
template <class View>
struct GatherOf {
    static constexpr int components = 4;
    Buffer<float> records;
    View view{};

    explicit GatherOf(const StageData& d) {
        const auto& u = view.u = uniforms_of_frame<decltype(view.u)>(d);
        for (const char* name : {"rsm_position", "rsm_normal", "rsm_flux"}) check_map(d, name, u.map.size);
        records = records_of(d, u.map.size);
        view.position = floats(d, "position"), view.normal = floats(d, "normal");
        view.records = records.data();
    }
    bool writes(glm::ivec2) const { return true; }

    // Tables of samples and weights: what the kernel indexes has to be there.
    void bind_pattern(const StageData& d, bool continuous, int samples, bool weights_turn) {
        const auto& u = view.u;
        if (samples < 0 || u.rotations < 1 || (u.rotations & (u.rotations - 1)) != 0)
            throw InputError(fmt::format("{}: samples = {}, rotations = {}: expected 0 or more, and a power of two",
                                         d.label, samples, u.rotations));
        const std::string table = continuous ? "positions" : "offsets";
        const std::size_t offsets = at(d.inputs, table).bytes.size() / (continuous ? 8 : 4);
        const std::size_t weights = at(d.inputs, "weights").bytes.size() / 4;
        const std::size_t all = std::size_t(samples) * std::size_t(u.rotations);
        const std::size_t weighed = weights_turn ? all : std::size_t(samples);
        if (offsets < all || weights < weighed)
            throw InputError(fmt::format("{}: {} {} and {} weights: expected {} x {} and {}", d.label, offsets, table,
                                         weights, samples, u.rotations, weighed));
        const int most_reach = continuous ? 32769 : 32768;
        if (u.reach < 0 || u.reach > most_reach)
            throw InputError(fmt::format("{}: reach = {}: expected 0 to {}", d.label, u.reach, most_reach));
        view.weights = floats(d, "weights");
        if (continuous)
            view.positions = floats(d, "positions");
        else
            view.offsets = ints(d, "offsets");
    }
};

template <bool continuous>
struct DiscOf : GatherOf<GatherInputsView<float>> {
    explicit DiscOf(const StageData& d) : GatherOf(d) { bind_pattern(d, continuous, view.u.samples, false); }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec3<F> e = gather_disc<F, continuous>(view, x, y, tap);
        return {e.x, e.y, e.z, F(0.0f)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        GatherInputsView<float> v = view;
        v.irradiance = out;
        GatherRows<isa, float>::disc(v, first, last);
    }
};

template <bool continuous>
struct PathsOf : GatherOf<PathsInputsView<float>> {
    explicit PathsOf(const StageData& d) : GatherOf(d) {
        const PathsUniforms& u = view.u;
        if (u.directions < 0 || u.steps < 0 || std::int64_t(u.directions) * u.steps > most_samples)
            throw InputError(fmt::format("{}: directions = {}, steps = {}: expected 0 or more, and at most {} samples",
                                         d.label, u.directions, u.steps, most_samples));
        bind_pattern(d, continuous, u.directions * u.steps, true);
        const std::size_t edges = at(d.inputs, "edges").bytes.size() / 4;
        if (u.slots < 0 || u.slots == 1 || u.slots > 32 || edges + 1 < std::size_t(u.slots))
            throw InputError(fmt::format("{}: slots = {} with {} edges: expected 0, or 2 to 32 and one edge less",
                                         d.label, u.slots, edges));
        if (u.propagates != 0 && u.propagates != -1)
            throw InputError(fmt::format("{}: propagates = {}: expected 0 or -1", d.label, u.propagates));
        if (u.tiled != 0 && u.tiled != 1)
            throw InputError(fmt::format("{}: tiled = {}: expected 0 or 1", d.label, u.tiled));
        view.edges = floats(d, "edges");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec3<F> e = gather_paths<F, continuous>(view, x, y, tap);
        return {e.x, e.y, e.z, F(0.0f)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        PathsInputsView<float> v = view;
        v.irradiance = out;
        PathsRows<isa, float>::paths(v, first, last);
    }
};

struct AllOf : GatherOf<GatherInputsView<float>> {
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

// What all gathers share.
StageBinding gather_binding(const StageInfo& info) {
    StageBinding b;
    b.info = info;
    b.twin = info.twin;
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

// Those of gather_form.glsl.
StageBinding sum_binding(const StageInfo& info) {
    using U = GatherUniforms;
    StageBinding b = gather_binding(info);
    b.uniforms = members_after_map(offsetof(U, map), {{"least_distance2", "float", offsetof(U, least_distance2)},
                                                      {"scale", "float", offsetof(U, scale)},
                                                      {"samples", "int", offsetof(U, samples)},
                                                      {"rotations", "int", offsetof(U, rotations)},
                                                      {"width", "int", offsetof(U, width)},
                                                      {"height", "int", offsetof(U, height)},
                                                      {"seed", "uint", offsetof(U, seed)},
                                                      {"reach", "int", offsetof(U, reach)}});
    b.uniform_bytes = sizeof(U);
    return b;
}

Slot table(const char* name, int binding, DType type, const char* unit, const char* meaning) {
    return {.name = name, .kind = SlotKind::buffer, .binding = binding, .dtype = type, .channels = 1, .frame = false,
            .unit = unit, .meaning = meaning};
}

// Where the samples are.
Slot samples_table(Texels texels) {
    if (texels == Texels::whole)
        return table("offsets", 6, DType::i32, "texels",
                     "a row a sample, a column a rotation: dx in the lower 16 bits, dy in the upper 16");
    Slot slot = table("positions", 6, DType::f32, "texels", "a row a sample, a column a rotation: dx, dy");
    slot.channels = 2;
    return slot;
}

StageBinding make_disc(Texels texels) {
    StageBinding b = sum_binding(info_disc(texels));
    b.inputs.push_back(samples_table(texels));
    b.inputs.push_back(table("weights", 7, DType::f32, "texels", "[samples]: texels that a sample stands for"));
    b.outputs[0].binding = 8;
    b.bind = texels == Texels::whole ? bind_kernel<DiscOf<false>, disc_binding>
                                     : bind_kernel<DiscOf<true>, disc_continuous_binding>;
    return b;
}

StageBinding make_paths(Texels texels) {
    using U = PathsUniforms;
    StageBinding b = gather_binding(info_paths(texels));
    b.uniforms = members_after_map(offsetof(U, map), {{"axis", "vec4", offsetof(U, axis)},
                                                      {"least_distance2", "float", offsetof(U, least_distance2)},
                                                      {"scale", "float", offsetof(U, scale)},
                                                      {"directions", "int", offsetof(U, directions)},
                                                      {"steps", "int", offsetof(U, steps)},
                                                      {"rotations", "int", offsetof(U, rotations)},
                                                      {"tiled", "int", offsetof(U, tiled)},
                                                      {"width", "int", offsetof(U, width)},
                                                      {"height", "int", offsetof(U, height)},
                                                      {"seed", "uint", offsetof(U, seed)},
                                                      {"reach", "int", offsetof(U, reach)},
                                                      {"slots", "int", offsetof(U, slots)},
                                                      {"propagates", "int", offsetof(U, propagates)}});
    b.uniform_bytes = sizeof(U);
    b.inputs.push_back(samples_table(texels));
    b.inputs.push_back(table("weights", 7, DType::f32, "texels",
                             "[directions][steps][rotations]: texels that a sample stands for"));
    b.inputs.push_back(table("edges", 8, DType::f32, "", "[slots - 1]: s |s|, s the sine of the elevation, ascending"));
    b.outputs[0].binding = 9;
    b.bind = texels == Texels::whole ? bind_kernel<PathsOf<false>, paths_binding>
                                     : bind_kernel<PathsOf<true>, paths_continuous_binding>;
    return b;
}

StageBinding make_all() {
    StageBinding b = sum_binding(info_all());
    b.bind = bind_kernel<AllOf, all_binding>;
    return b;
}

}  // namespace

const StageBinding& disc_binding() {
    static const StageBinding binding = make_disc(Texels::whole);
    return binding;
}
const StageBinding& disc_continuous_binding() {
    static const StageBinding binding = make_disc(Texels::continuous);
    return binding;
}
const StageBinding& paths_binding() {
    static const StageBinding binding = make_paths(Texels::whole);
    return binding;
}
const StageBinding& paths_continuous_binding() {
    static const StageBinding binding = make_paths(Texels::continuous);
    return binding;
}
const StageBinding& all_binding() {
    static const StageBinding binding = make_all();
    return binding;
}

StageData gather_data(const GatherParams& params, const GatherInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = stage_name(params);
    d.size = {in.position->width, in.position->height};
    const bool paths = params.gather == Gather::paths;
    d.uniforms = paths ? uniform_block(paths_uniforms(params, in)) : uniform_block(gather_uniforms(params, in));
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "rsm_position", in.rsm->position);
    add(d.inputs, "rsm_normal", in.rsm->normal);
    add(d.inputs, "rsm_flux", in.rsm->flux);
    if (params.gather == Gather::all) return d;
    const int samples = in.pattern->samples, rotations = in.pattern->rotations;
    if (params.texels == Texels::whole)
        add(d.inputs, "offsets", {samples, rotations}, in.pattern->offsets.data());
    else
        add(d.inputs, "positions", {samples, rotations, 2}, in.pattern->positions.data());
    if (!paths) {
        add(d.inputs, "weights", {samples}, in.pattern->weights.data());
        return d;
    }
    add(d.inputs, "weights", {samples, rotations}, in.pattern->weights.data());
    const Buffer<float> edges = slot_edges(params);
    add(d.inputs, "edges", {std::int64_t(edges.size())}, edges.data());
    return d;
}

}  // namespace plumb::rsm
