// The stages of a frame, one function each. Private to gi/frame.
#pragma once

#include <vector>

#include "gi/direct/log_blur.h"
#include "gi/frame/kept_memory.h"

namespace plumb::frame {

// What stages read and write. `frame` may still hold the one before: a stage fills the whole of its place.
struct Context {
    const Scene& scene;
    const Settings& settings;
    const Plan& plan;
    RunOptions options;  // of the stage that runs
    KeptMemory& memory;
    World& world;
    Frame& frame;
    glm::ivec2 size{0};
    std::size_t pixels = 0;
    std::vector<Light> lights;  // shining()
    Tracer tracer;
    bool keeps = false;         // what gathers make is wanted again
    bool sum_is_kept = false;   // `indirect` holds the sum already

    float* visibility(int light) { return frame.visibility.data() + std::size_t(light) * pixels; }
};

// A kind of stage: what runs it, and what fills its place where it is left out.
using Run = void (*)(Context& c, const PlannedStage& stage, StageRun& run);
struct Kind {
    Run run, leave_out;
};
Kind kind_of(const PlannedStage& stage);

// Where a pass of shadow.blur leaves what it makes, [light][map], and what it reads; of a map that was drawn.
std::vector<std::vector<Image4>>& map_blur_result(Frame& frame, const PlannedStage& stage);
direct::LogBlurInputs map_blur_inputs(const Frame& frame, const PlannedStage& stage, std::size_t map);
// What the shadow test of a light reads for the points of a G-buffer.
direct::ShadowInputs shadow_inputs(const Settings& settings, const Frame& frame, int light,
                                   const raster::GBuffer& gbuffer);

// Adds to the frame's indirect light, the sum of all gathers in their order, what one of them made.
void add_gather(Context& c, const Image4& irradiance, const Image4& error);

}  // namespace plumb::frame
