// probes.indirect_shadow: what dynamic meshes hide of the indirect light of other surfaces, by spheres that stand for them.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/probes/indirect_shadow_kernel.h"
#include "gi/probes/shadow_spheres.h"

namespace plumb::probes {

inline constexpr int most_shadow_spheres = 65536;

struct IndirectShadowInputs {
    using Kernel = IndirectShadowKernel;
    const Image4* position = nullptr;        // xyz m
    const Image4* normal = nullptr;          // xyz unit; w 1: a point
    const Image4* irradiance = nullptr;      // E, W/m2
    const Image<glm::ivec2>* id = nullptr;   // object, triangle; -1, -1: nothing
    const ShadowSpheres* spheres = nullptr;  // at least one
    bool directional = true;                 // false: light comes from everywhere alike
};

inline StageDescription<IndirectShadowView> describe(IndirectShadowKernel) {
    using View = IndirectShadowView;
    return {
        .name = "probes.indirect_shadow",
        .source = "beyond IPR (its 6.1): a sphere's share of the hemisphere, cut by the horizon (Lambert 1760; Snyder 1996)",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; w 1: a point", .fixed = 8},
                   {.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "E, without shadows of what moves; w is kept", .fixed = 8},
                   {.name = "id", .at = &View::id, .meaning = "object, triangle; -1, -1 where nothing is",
                    .count = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.height); }, .why = "one a pixel"},
                   {.name = "owner", .at = &View::owner, .meaning = "[sphere] first and last of the objects that it stands for: it does not shade these",
                    .count = [](const View& v) { return std::size_t(v.u.spheres); }, .why = "one a sphere"},
                   {.name = "spheres", .at = &View::spheres,
                    .meaning = "[sphere][7] centre and radius, m; b and a of the light that it hides, rgb; of what its object sends, rgb",
                    .count = [](const View& v) { return std::size_t(shadow_rows) * std::size_t(v.u.spheres); }, .why = "seven a sphere"}},
        .outputs = {{.name = "shaded", .at = &View::shaded, .unit = "W/m2", .meaning = "E', what is left; w as of E", .fixed = 8}},
        .uniforms = {{"spheres", 1, most_shadow_spheres}, {"directional", 0, 1}},
        .cost = {6, "pixels x spheres"},
    };
}
// Throws InputError where an input is missing or of another size, or the spheres' lists do not fit each other.
StageData data_of(const IndirectShadowInputs& in);

}  // namespace plumb::probes
