// probes.lightmap_uv: where on the lightmap the surface of each pixel lies.
#pragma once

#include "core/binding.h"
#include "core/scene.h"
#include "core/stage_description.h"
#include "gi/probes/lightmap_uv_kernel.h"

namespace plumb::probes {

struct Atlas;

// Which triangles of a frame have a place on a lightmap, and where.
struct ChartedTriangles {
    std::vector<std::int32_t> charted_of;  // [triangles of the frame]: of the lightmap, or -1: of a dynamic mesh
    Buffer<glm::vec4> corners;             // [charted][4]: A, B, C with their u in w; their v
};
// geometry: flatten(scene). Throws InputError where the static meshes are not those of the atlas: another number of triangles.
ChartedTriangles charted_triangles(const Scene& scene, const Geometry& geometry, const Atlas& atlas);

struct LightmapUvInputs {
    using Kernel = LightmapUvKernel;
    const Image4* position = nullptr;        // xyz m
    const Image<glm::ivec2>* id = nullptr;   // object, triangle; -1, -1: nothing
    const ChartedTriangles* charted = nullptr;
};

inline StageDescription<LightmapUvView> describe(LightmapUvKernel) {
    using View = LightmapUvView;
    return {
        .name = "probes.lightmap_uv",
        .source = "IPR 3.3.1.4: every vertex has coordinates on the lightmap",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "id", .at = &View::id, .meaning = "object, triangle; -1, -1 where nothing is",
                    .count = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.height); }, .why = "one a pixel"},
                   {.name = "charted_of", .at = &View::charted_of, .meaning = "[triangle] index into corners; -1: none",
                    .count = [](const View& v) { return std::size_t(v.u.triangles); }, .why = "one a triangle"},
                   {.name = "corners", .at = &View::corners, .unit = "m",
                    .meaning = "[charted triangle][4] xyz of its corners, u in w; their v",
                    .count = [](const View& v) { return 4 * std::size_t(v.u.charted); }, .why = "four a charted triangle"}},
        .outputs = {{.name = "uv", .at = &View::uv, .meaning = "coordinates on the lightmap, w 1; -1, -1, 0, 0: it has none", .fixed = 8}},
        .uniforms = {{"triangles", 1, 0x7fffffff}, {"charted", 1, 1 << 29}},
        .cost = {3, "pixels"},
    };
}

StageData data_of(const LightmapUvInputs& in);

}  // namespace plumb::probes
