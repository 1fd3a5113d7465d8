// radiosity.items: which triangle each texel of hemicubes sees, and where (HEM 4.5.3, 5.6).
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/radiosity/items_kernel.h"

namespace plumb::radiosity {

inline constexpr int largest_hemicube = 1024;  // texels of a face's side
inline constexpr int rows_a_dispatch = 1 << 19;

struct ItemsInputs {
    using Kernel = ItemsKernel;
    const Buffer<glm::vec4>* vertices = nullptr;    // xyz m
    const Buffer<glm::ivec4>* triangles = nullptr;  // xyz corners
    const Buffer<glm::vec4>* eyes = nullptr;        // of eyes_of(): 4 a hemicube
    int size = 64;                                  // texels of a face's side, even, 2 to largest_hemicube
};

// A hemicube each: where it stands, and its axes u, t, n as raster::hemicube_axes() has them. Where the normal has no length, or
// is not finite, it sees nothing: its axes are 0.
Buffer<glm::vec4> eyes_of(const Buffer<glm::vec4>& position, const Buffer<glm::vec4>& normal);

inline StageDescription<ItemsView> describe(ItemsKernel) {
    using View = ItemsView;
    return {
        .name = "radiosity.items",
        .source = "HEM 4.5.3, 5.6: five faces; Olano and Greer 1997: edges without projection",
        .domain = "texel of hemicubes",
        .inputs = {{.name = "eyes", .at = &View::eyes, .unit = "m", .meaning = "of each hemicube where it stands, u, t, n; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.height / rows_of_hemicube(v.u.width)) * 4; },
                    .why = "4 for each 3 width rows"},
                   {.name = "vertices", .at = &View::vertices, .unit = "m", .meaning = "xyz; w unused", .fixed = 8,
                    .count = [](const View& v) { return std::size_t(v.u.vertices); }, .why = "as vertices says"},
                   {.name = "triangles", .at = &View::triangles, .meaning = "xyz corners; one beyond vertices: no triangle",
                    .count = [](const View& v) { return std::size_t(v.u.triangles); }, .why = "as triangles says"}},
        .outputs = {{.name = "triangle", .at = &View::triangle, .meaning = "that the texel sees; -1: none"},
                    {.name = "seen", .at = &View::seen, .meaning = "barycentrics of corners 1 and 2; 1/depth along the face's axis, 1/m; 1: its "
                                                                   "front, -1: its back, 0: nothing", .fixed = 8}},
        .uniforms = {{"vertices", 1, 1 << 26}, {"triangles", 1, 1 << 26}, {"texel", 1.9 / largest_hemicube, 1.1}, {"slack", 0, 1}},
        .refuses =
            [](const View&, glm::ivec2 size) {
                return std::string(size.x % 2 != 0 || size.x < 2 || size.x > largest_hemicube ? "width: an even number of 2 to 1024"
                                   : size.y % rows_of_hemicube(size.x) != 0                  ? "height: 3 width rows a hemicube"
                                   : size.y / rows_of_hemicube(size.x) < 1                   ? "no hemicube"
                                                                                             : "");
            },
        .budget = {128, "an edge is known to eps of its corners' distance, in all three axes of the hemicube: of a triangle of 1,000 km, 300 m away, "
                        "barycentrics beside an edge are (README.md)"},
        .cost = {1, "texels x triangles"},
    };
}

// One dispatch: hemicubes [first, first + count).
StageData data_of(const ItemsInputs& in, int first, int count);

}  // namespace plumb::radiosity
