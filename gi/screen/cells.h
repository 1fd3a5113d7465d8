// screen.cells: where mirrored rays meet what a view sees, from texel to texel and over blocks of them.
#pragma once

#include "gi/screen/cells_kernel.h"
#include "gi/screen/nearest.h"
#include "gi/screen/reflect.h"

namespace plumb::screen {

struct CellsInputs {
    using Kernel = CellsKernel;
    ReflectInputs ray;                // as screen.reflect reads them
    const Image4* nearest = nullptr;  // as screen.nearest makes them of ray.seen
    const raster::Covered* tiles = nullptr;
};

inline StageDescription<CellsInputsView> describe(CellsKernel) {
    using View = CellsInputsView;
    const auto of_view = [](const View& v) { return glm::ivec2(v.u.view.width, v.u.view.height); };
    const auto picture = [](const View& v) {
        return v.u.rows > 0 ? glm::ivec2(v.u.columns, v.u.rows) : glm::ivec2(v.u.width, v.u.height);
    };
    const std::string of_picture = "as columns and rows say";
    return {
        .name = "screen.cells",
        .source = "McGuire and Mara 2014, Efficient GPU Screen-Space Ray Tracing; Uludag 2014, Hi-Z Screen-Space Cone-Traced "
                  "Reflections",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position", .size = picture,
                    .why = of_picture},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; all 0 where nothing is", .size = picture,
                    .why = of_picture},
                   {.name = "mirror", .at = &View::mirror, .meaning = "reflectance of the mirror; w 0: none", .fixed = 8,
                    .size = picture, .why = of_picture},
                   {.name = "map_position", .at = &View::map_position, .unit = "m",
                    .meaning = "of the view: xyz world-space position, w linear depth; 0 where nothing is", .size = of_view,
                    .why = "as view.width and view.height say"},
                   {.name = "map_normal", .at = &View::map_normal, .meaning = "of the view: unit normal, towards it",
                    .size = of_view, .why = "as view.width and view.height say"},
                   {.name = "nearest", .at = &View::nearest, .unit = "m", .meaning = "of the view: x least depth of a block",
                    .size = [](const View& v) { return blocks_of({v.u.view.width, v.u.view.height}); }, .why = "as screen.nearest makes them"},
                   {.name = "before", .at = &View::before, .meaning = "what earlier views found", .fixed = 11, .optional = true},
                   {.name = "rays", .at = &View::rays, .meaning = "as screen.lobe writes them, where rows > 0", .optional = true}},
        .outputs = {{.name = "hit", .at = &View::hit,
                     .meaning = "xy texel; z distance along the ray, m; w in which view: 1 the camera's, 0 none", .fixed = 11}},
        .params = reflect_params_of({"march", "views", "layers", "step", "steps", "cells", "thickness", "bias"}),
        .uniforms = {{"cells", 1, most_cells}, {"view.width", 1, 32767}, {"view.height", 1, 32767}, {"number", 1, 1 << 20}, {"columns", 0, 32767}, {"rows", 0, 32767},
                     {"levels", 1, most_levels}},
        .fixed_uniforms = {{"view.perspective", 1}},
        .refuses = [](const View& v, glm::ivec2) -> std::string {
            const glm::ivec2 view(v.u.view.width, v.u.view.height);
            if (v.u.levels != levels_of(view) || v.u.padded != padded_height(view))
                return "the blocks are not those of the view";
            if (v.u.rows > 0 && v.u.columns == 0) return "rows without columns";
            return std::int64_t(view.x) * view.y < (std::int64_t(1) << 29) ? "" : "the view has 2^29 texels or more: expected fewer";
        },
        .cost = {8, "cells"},
    };
}

StageData data_of(const ReflectParams& params, const CellsInputs& in);

}  // namespace plumb::screen
