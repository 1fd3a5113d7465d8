// The stage shadow: which lights a point sees. See gi/direct/README.md.
#pragma once

#include <span>
#include <vector>

#include "core/stage_description.h"
#include "gi/direct/direct_params.h"
#include "gi/direct/shadow_kernel.h"
#include "gi/lend.h"
#include "raster/rsm.h"

namespace plumb::direct {

using plumb::explain;
using plumb::run;

struct ShadowInputs {
    const Image4* position = nullptr;  // xyz world, m
    const Image4* normal = nullptr;    // xyz unit; all 0 where nothing is
    std::span<const raster::Rsm> rsms; // the light's map, or the six of a point light; position.w is the depth map
    const raster::Covered* tiles = nullptr;  // the others, which must see nothing, are not shaded; null: all are
    std::span<const Image4> blurred = {};    // of mode = esm: read instead of the maps' own depths (log_blur.h)
    float rounding = 0x1p-22f;               // of stored positions, relative: rounding_of(layout)
    bool picture = false;                    // pixels beside one another are so in space: their planes are asked, too
};

inline StageDescription<ShadowInputsView> describe(ShadowKernel) {
    using View = ShadowInputsView;
    ShadowParams defaults;
    return {
        .name = "shadow",
        .source = "VRSM Algorithm 4; ISR 4.6, Listing 8",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m",
                    .meaning = "world-space position of the shading points"},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal of the shading points"},
                   {.name = "map_position", .at = &View::map_position, .unit = "m",
                    .meaning = "xyz: world; w: linear light-space depth; 0 where nothing is; of a point light a map a face; "
                               "mode = esm: w blurred, xyz 0",
                    .size = [](const View& v) { return glm::ivec2(v.u.map.size); },
                    .why = "map.size a side"},
                   {.name = "map_normal", .at = &View::map_normal,
                    .meaning = "unit normal of what the light sees there, to the light; test = planes",
                    .size = [](const View& v) { return glm::ivec2(v.u.map.size); },
                    .why = "map.size a side", .read = [](const View& v) { return v.u.test == int(Test::planes); },
                    .optional = true}},
        .outputs = {{.name = "visibility", .at = &View::visibility,
                     .meaning = "1 lit, 0 shadowed; but for the hard test in between"}},
        .params = plumb::describe(fields(defaults)),
        .uniforms = {{"map.size", 1, 32767}, {"kernel", 1, 64}, {"soft", 0, int(Soft::esm)}, {"test", 0, int(Test::planes)}, {"beside", 0, 1}},
        .fixed_uniforms = {{"perspective", 1}, {"samples", 1}},
        .prepare = [](View& v, Buffer<float>&) {
            if (v.u.test == int(Test::planes) && !v.map_normal)
                throw InputError("shadow: test = 2 reads map_normal, which is missing");
        },
        .cost = {8, "pixels"},
    };
}

// Whether the shadow test reads the maps' normals.
bool reads_normals(const ShadowParams& params);
// How far stored positions are rounded, relative to their coordinates; with what interpolation makes of floats.
float rounding_of(const raster::Layout& layout);

// The dispatch that reads rsms[face], which must be drawn.
StageData data_of(const ShadowParams& params, const ShadowInputs& in, int face);

// All faces of a light. visibility: [height][width] floats, 1 lit, 0 shadowed. What a face of size 0 would serve is lit.
// Where nothing is seen, position and normal are 0, and so the visibility is one number all over: that of the world's
// origin.
void run(const ShadowParams& params, const ShadowInputs& in, const RunOptions& options, float* visibility);
// Of the face that serves the point.
std::vector<TapValue> explain(const ShadowParams& params, const ShadowInputs& in, glm::ivec2 pixel);

}  // namespace plumb::direct
