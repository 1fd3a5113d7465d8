// radiosity.lookup: irradiance of pixels from that of elements (HEM 5.5).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/radiosity/elements.h"
#include "gi/radiosity/lookup_kernel.h"

namespace plumb::radiosity {

// The scene's triangles as the stage reads them.
struct TriangleElements {
    Buffer<glm::vec4> corners;  // [triangle][3]: xyz m
    Buffer<glm::ivec4> of;      // [triangle]: element at each corner
};
TriangleElements triangle_elements(const Elements& elements);

struct LookupInputs {
    using Kernel = LookupKernel;
    const Image4* position = nullptr;               // xyz m
    const Image<glm::ivec2>* id = nullptr;          // object, triangle; -1, -1: nothing
    const TriangleElements* triangles = nullptr;
    const Buffer<glm::vec4>* irradiance = nullptr;  // of elements, W/m2
};

inline StageDescription<LookupView> describe(LookupKernel) {
    using View = LookupView;
    return {
        .name = "radiosity.lookup",
        .source = "HEM 5.5",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "id", .at = &View::id, .meaning = "object, triangle; -1, -1 where nothing is",
                    .count = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.height); }, .why = "one a pixel"},
                   {.name = "corners", .at = &View::corners, .unit = "m", .meaning = "[triangle][3] xyz; w unused", .fixed = 8,
                    .count = [](const View& v) { return 3 * std::size_t(v.u.triangles); }, .why = "three a triangle"},
                   {.name = "of", .at = &View::of, .meaning = "[triangle] xyz element at each corner",
                    .count = [](const View& v) { return std::size_t(v.u.triangles); }, .why = "one a triangle"},
                   {.name = "own", .at = &View::own, .unit = "W/m2", .meaning = "irradiance of each element; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.elements); }, .why = "as elements says"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "indirect irradiance; 0 where nothing is seen"}},
        .uniforms = {{"triangles", 1, 1 << 26}, {"elements", 1, 1 << 26}},
        .cost = {4, "pixels"},
    };
}

StageData data_of(const LookupInputs& in);

}  // namespace plumb::radiosity
