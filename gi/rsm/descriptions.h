// What the stages rsm.disc, rsm.paths and rsm.all say of themselves. Only stages.cpp includes it.
#pragma once

#include <fmt/format.h>

#include <cstring>
#include <type_traits>

#include "core/stage_description.h"
#include "gi/rsm/gather.h"
#include "gi/rsm/paths_kernel.h"

namespace plumb::rsm {

template <class View>
std::vector<Reads<View>> points_and_map() {
    const auto side = [](const View& v) { return glm::ivec2(v.u.map.size); };
    const std::string why = "map.size a side", records = "rsm_records";
    return {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position of the shading points"},
            {.name = "normal", .at = &View::normal, .meaning = "unit normal of the shading points"},
            {.name = "rsm_position", .at = &View::rsm_position, .unit = "m", .meaning = "of the map: world-space position",
             .size = side, .why = why, .instead = records},
            {.name = "rsm_normal", .at = &View::rsm_normal, .meaning = "of the map: unit normal", .size = side, .why = why,
             .instead = records},
            {.name = "rsm_flux", .at = &View::rsm_flux, .unit = "W", .meaning = "of the map: reflected flux of the texel",
             .size = side, .why = why, .instead = records}};
}

template <class View, class Component>
Lends<View> lent_records(const Component* View::*records) {
    return {"rsm_records", records, dtype_of<Component>,
            [](const View& v) { return std::size_t(v.u.map.size) * std::size_t(v.u.map.size) * record_stride; },
            "a record a texel"};
}

// Records of the map's images, where nobody lends them.
template <class View>
void make_records(View& v, Buffer<float>& own) {
    if (v.records) return;
    const std::size_t texels = std::size_t(v.u.map.size) * std::size_t(v.u.map.size);
    own.resize(texels * record_stride);
    const float* parts[] = {v.rsm_position, v.rsm_normal, v.rsm_flux};
    for (std::size_t i = 0; i < texels; ++i)
        for (std::size_t p = 0; p < 3; ++p) std::memcpy(&own[i * record_stride + 4 * p], parts[p] + 4 * i, 16);
    v.records = own.data();
}

// What every gather says.
template <class View>
StageDescription<View> describe_gather(const char* name, const char* source, Gather gather, Texels texels) {
    GatherParams defaults;
    defaults.gather = gather, defaults.texels = texels;
    return {
        .name = name,
        .source = source,
        .domain = "pixel",
        .inputs = points_and_map<View>(),
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2",
                     .meaning = "indirect irradiance, one bounce"}},
        .params = describe(fields(defaults)),
        .uniforms = {{"map.size", 1, most_side}},
    };
}

// What those of a pattern say. `entries`: of its table of samples, whose shape is `shape`.
template <bool continuous, class View>
StageDescription<View> describe_pattern(const char* name, const char* source, Gather gather,
                                        std::size_t (*entries)(const View& v), const std::string& shape) {
    using Component = std::remove_cvref_t<decltype(*View::records)>;
    auto d = describe_gather<View>(name, source, gather, continuous ? Texels::continuous : Texels::whole);
    const std::string why = "one for each sample and rotation";
    if (continuous)
        d.inputs.push_back({.name = "positions", .at = &View::positions, .unit = "texels",
                            .meaning = shape + ": dx, dy from the projection", .count = entries, .why = why});
    else
        d.inputs.push_back({.name = "offsets", .at = &View::offsets, .unit = "texels",
                            .meaning = shape + ": whole texels, dx in the lower 16 bits, dy in the upper 16",
                            .count = entries, .why = why});
    d.lends = {lent_records<View>(&View::records)};
    if constexpr (std::is_same_v<Component, float>) d.prepare = make_records<View>;
    d.uniforms.push_back({"reach", 0, continuous ? 32769 : 32768});
    return d;
}

// What a block says of the size of samples.
template <class Uniforms>
std::string refuse_area(const Uniforms& u) {
    const float* a = u.texel_area;
    const bool none = a[0] == 0 && a[1] == 0 && a[2] == 0 && a[3] == 0;
    return u.sample_area > 0 && none ? "texel_area = 0: expected that of the map's view where sample_area is above 0" : "";
}

inline bool is_power_of_two(int n) { return n >= 1 && (n & (n - 1)) == 0; }

// Tiles, and what both gathers of samples have beside them.
template <class Uniforms>
std::string refuse_pattern(const Uniforms& u) {
    if (u.tile != 0 && (u.tile < 1 || tile_of(u.rotations) != u.tile))
        return fmt::format("tile = {}, rotations = {}: expected 0, or a tile of which they are the square", u.tile, u.rotations);
    return refuse_area(u);
}

template <bool continuous, class Component>
auto describe(DiscKernel<continuous, Component>) {
    using View = GatherInputsView<Component>;
    const auto entries = [](const View& v) { return std::size_t(v.u.samples) * std::size_t(v.u.rotations); };
    auto d = describe_pattern<continuous, View>(continuous ? "rsm.disc_continuous" : "rsm.disc",
                                                "Dachsbacher and Stamminger 2005; LRA 4.3.3; VRSM (3.2)", Gather::disc,
                                                entries, "[samples][rotations]");
    d.inputs.push_back({.name = "weights", .at = &View::weights, .unit = "texels",
                        .meaning = "[samples]: texels that a sample stands for",
                        .count = [](const View& v) { return std::size_t(v.u.samples); }, .why = "one for each sample"});
    d.refuses = [](const View& v, glm::ivec2) {
        if (v.u.samples >= 0 && is_power_of_two(v.u.rotations)) return refuse_pattern(v.u);
        return fmt::format("samples = {}, rotations = {}: expected 0 or more, and a power of two", v.u.samples,
                           v.u.rotations);
    };
    d.cost = {4.2, "samples"};
    return d;
}

template <class View>
std::string refuse_paths(const View& v, glm::ivec2) {
    const PathsUniforms& u = v.u;
    if (u.directions < 0 || u.steps < 0 || std::int64_t(u.directions) * u.steps > most_samples)
        return fmt::format("directions = {}, steps = {}: expected 0 or more, and at most {} samples", u.directions, u.steps,
                           most_samples);
    if (!is_power_of_two(u.rotations))
        return fmt::format("directions = {}, rotations = {}: expected 0 or more, and a power of two", u.directions,
                           u.rotations);
    if (u.slots == 1) return "slots = 1: expected 0, or 2 to 32";
    return refuse_pattern(u);
}

template <bool continuous, class Component>
auto describe(PathsKernel<continuous, Component>) {
    using View = PathsInputsView<Component>;
    const auto entries = [](const View& v) {
        return std::size_t(v.u.directions) * std::size_t(v.u.steps) * std::size_t(v.u.rotations);
    };
    const std::string shape = "[directions][steps][rotations]";
    auto d = describe_pattern<continuous, View>(continuous ? "rsm.paths_continuous" : "rsm.paths",
                                                "VRSM 3.2, 3.3, Algorithms 2, 3, 5 and 6", Gather::paths, entries, shape);
    d.inputs.push_back({.name = "weights", .at = &View::weights, .unit = "texels",
                        .meaning = shape + ": texels that a sample stands for", .count = entries,
                        .why = "one for each sample and rotation"});
    d.inputs.push_back({.name = "edges", .at = &View::edges,
                        .meaning = "[slots - 1]: where slots meet: s |s|, s the sine of the elevation, ascending",
                        .count = [](const View& v) { return std::size_t(v.u.slots > 0 ? v.u.slots - 1 : 0); },
                        .why = "one less than slots"});
    for (const Within& range : {Within{"slots", 0, 32}, {"propagates", -1, 0}}) d.uniforms.push_back(range);
    d.refuses = refuse_paths<View>;
    d.cost = {4.8, "samples"};
    return d;
}

inline StageDescription<AllInputsView> describe(AllKernel) {
    using View = AllInputsView;
    auto d = describe_gather<View>("rsm.all", "VRSM (3.2), summed over every texel", Gather::all, Texels::whole);
    d.lends = {lent_records<View>(&View::records), lent_records<View>(&View::half_records)};
    d.prepare = [](View& v, Buffer<float>& own) {
        if (!v.half_records) return make_records(v, own);
        own.resize(std::size_t(v.u.map.size) * std::size_t(v.u.map.size) * record_stride);
        for (std::size_t i = 0; i < own.size(); ++i) own[i] = half_to_float(v.half_records[i]);
        v.records = own.data();
    };
    d.cost = {0.55, "texel pairs"};
    return d;
}

}  // namespace plumb::rsm
