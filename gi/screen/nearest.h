// screen.nearest: the least depths of blocks of a view's texels, for marches that pass blocks at once.
#pragma once

#include "core/binding.h"
#include "core/stage_description.h"
#include "gi/screen/nearest_kernel.h"
#include "gi/screen/reflect_params.h"

namespace plumb::screen {

struct NearestInputs {
    using Kernel = NearestKernel;
    const Image4* seen = nullptr;  // of the view: its positions, w linear depth
};

// Of a view of `size` texels: levels, its height as a multiple of the largest block's, and the size of the image of all.
int levels_of(glm::ivec2 size);
int padded_height(glm::ivec2 size);
glm::ivec2 blocks_of(glm::ivec2 size);

inline StageDescription<NearestInputsView> describe(NearestKernel) {
    using View = NearestInputsView;
    return {
        .name = "screen.nearest",
        .source = "Uludag 2014, Hi-Z Screen-Space Cone-Traced Reflections: the least depths of blocks",
        .domain = "block of texels",
        .inputs = {{.name = "map_position", .at = &View::map_position, .unit = "m",
                    .meaning = "of the view: w linear depth; 0 where nothing is",
                    .size = [](const View& v) { return glm::ivec2(v.u.view_width, v.u.view_height); },
                    .why = "as view_width and view_height say"}},
        .outputs = {{.name = "nearest", .at = &View::nearest, .unit = "m", .meaning = "x least depth of the block's texels",
                     .fixed = 14}},
        .uniforms = {{"view_width", 1, 32767}, {"view_height", 1, 32767}, {"levels", 1, most_levels}},
        .refuses = [](const View& v, glm::ivec2 size) -> std::string {
            const glm::ivec2 view(v.u.view_width, v.u.view_height);
            if (v.u.levels != levels_of(view) || v.u.padded != padded_height(view) || size != blocks_of(view)) return "the blocks are not those of the view";
            return std::int64_t(view.x) * view.y < (std::int64_t(1) << 29) ? "" : "the view has 2^29 texels or more: expected fewer";
        },
        .cost = {6, "blocks"},
    };
}

StageData data_of(const ReflectParams& params, const NearestInputs& in);

}  // namespace plumb::screen
