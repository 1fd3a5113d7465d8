// The frame: which stages a scene needs, their order, and their buffers.
//
//     Scene + Settings --plan--> Plan --execute--> Frame
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "core/stage.h"
#include "core/tap.h"
#include "gi/frame/rules.h"
#include "gi/frame/settings.h"
#include "gi/frame/truth.h"
#include "raster/gbuffer.h"
#include "raster/rsm.h"

namespace plumb::frame {

// A part of a stage's work that a rule leaves out (rules.h).
struct LeftOut {
    std::string rule;
    std::string reason;  // "no emission: nothing emits"
    double saved_ms = 0;
};

struct PlannedStage {
    std::string name;      // of the kind of stage: "gbuffer", "rsm", "shadow", "direct", "rsm.disc", ...
    int light = -1;        // index into Scene::lights, for a stage that runs once a light
    std::string label;     // as people read it: "rsm.disc (key)"
    bool needed = true;
    std::string reason;    // why it is needed, or why it is left out
    std::string rule;      // the rule that leaves it out (rules.h), or empty
    std::string form;      // of a stage that runs more than once: "position", "horizontal" (filters.h), "bounce 2" (isr.h)
    int view = 0;          // of method isr: index into Frame::views of what it draws or reads beside the frame; 0: itself
    int pass = 0;          // of method isr's gathers, isr.bounce and isr.unseen: index into Frame::isr's images of them
    std::string layer;     // of a path traced stage: which layer it makes (truth.h)
    int samples = 0;       // of a path traced stage: paths a pixel; 0: as many as it takes
    double work = 0;       // how often its inner loop runs: pixels, triangles, samples
    std::string work_unit;
    double expected_ms = 0;  // on one core with AVX-512, from the benchmark's figures; an order of magnitude
    double saved_ms = 0;     // what leaving it out, or parts of it, is expected to save; the same order of magnitude
    std::vector<LeftOut> parts;  // of a stage that is needed
};

// What is drawn of a light's maps.
struct PlannedMaps {
    raster::RsmWants wants;
    unsigned faces = 0x3f;  // bit m: map m is drawn
};

struct Plan {
    std::vector<PlannedStage> stages;  // in the order in which they run
    raster::GBufferWants gbuffer;      // the buffers that are computed; the others are 0
    std::vector<PlannedMaps> maps;     // [lights]
    std::vector<Rule> at_run;          // those that the run has to ask; none without pruning
};

// A pure function of what it is given. Leaves out what cannot change the picture, by rules() of rules.h. Throws
// InputError for what this version cannot render, and for what no frame can serve (refusals.h).
Plan plan(const Scene& scene, const Settings& settings);

struct StageRun {
    std::string label;
    bool needed = true;
    bool kept = false;      // not run: what it makes was kept from an earlier frame (kept.h)
    std::string reason;
    std::string rule;       // as PlannedStage has it
    double saved_ms = 0;    // of a kept stage: what making it took; of one left out: as PlannedStage has it
    std::vector<LeftOut> parts;  // as PlannedStage has them, and those that only the run could tell
    double ms = 0;
    std::size_t bytes = 0;  // of its output
    Isa isa = Isa::scalar;  // of the kernels that ran
};

// What method isr draws beside the frame (gi/frame/isr.h): a guard band around it, layers behind it, other cameras.
struct SourceView {
    std::string name;          // "guard", "layer 2", "camera 1"
    Camera camera;
    glm::ivec2 size{0};        // pixels
    raster::GBuffer gbuffer;
    Buffer<float> visibility;  // [lights][height][width]
    Image4 direct;             // irradiance, W/m2
    Image4 surface, radiosity; // as isr.downsample makes them
};

// What method isr makes (gi/isr), of a quarter of the pixels; empty where its stages do not run.
struct IsrBuffers {
    Image4 surface, radiosity, reflectance;
    std::vector<Image4> unseen;       // of each pass of isr.unseen, in their order
    std::vector<Image4> gathered;     // of each pass of isr.gather and isr.gather_camera
    std::vector<Image4> radiosities;  // of each pass of isr.bounce
    Image4 lit;                       // ISR_4: xyz irradiance, w accessibility
    Image4 blurred_across, blurred;
};

struct Frame {
    raster::GBuffer gbuffer;
    // [lights][1, or 6 faces of a point light]; size 0 where none was needed, or nothing can be seen.
    std::vector<std::vector<raster::Rsm>> rsms;
    // Of shadow.blur: w linear depth, m; [lights][maps], empty images where nothing was drawn. Across: of its first pass.
    std::vector<std::vector<Image4>> maps_blurred_across, maps_blurred;
    Buffer<float> visibility;  // [lights][height][width]
    Image4 direct, indirect;   // irradiance, W/m2; of method isr indirect's w: accessibility
    // Of filters of the indirect light alone (filters.h); empty where they do not run.
    Image4 half_position, half_normal;
    Image4 gathered;           // the sum of all gathers, W/m2, at their own size; w: linear depth, m (VRSM fig. 4.4)
    Image4 upsampled, blurred_across;  // what further filters read
    IsrBuffers isr;
    std::vector<SourceView> views;  // of method isr; [0] stands for the frame itself and is empty
    Image4 indirect_error;     // standard error of `indirect`, by channel, W/m2; empty where no rsm.all_rays ran
    Image4 radiance;           // outgoing, W/(m2 sr)
    Image4 display;            // sRGB-encoded, 0..1
    std::vector<Traced> traced;  // the path traced layers, in the plan's order
    Image4 truth_display;      // sRGB-encoded, 0..1: the truth under the picture's tone curve
    std::vector<StageRun> stages;
};

// Called before each stage and while it runs: its label and the share that is done.
using Progress = std::function<void(const std::string& label, double done)>;

// The picture does not depend on the options. Path traced layers that `store` keeps are taken from it, the others are
// kept there. kept.h has one that also keeps what every other stage made, for the frame after.
Frame execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
              const Progress& progress = {}, reference::Store* store = nullptr);

// The plan as it ran: what only the run could leave out is not needed, either.
Plan as_it_ran(const Plan& plan, const Frame& frame);

// The traced layer of that name, or null.
const Traced* find_traced(const Frame& frame, const std::string& layer);

// What the gather of a light reads of a frame, but its maps. `pattern` is pattern_of()'s; `rays` is read by rsm.all_rays.
rsm::GatherInputs gather_inputs(const Scene& scene, const Settings& settings, const raster::GBuffer& gbuffer, int light,
                                const Geometry& geometry, const rsm::Pattern& pattern, const RayQuery* rays);
// The same from a frame: where gathers run at half size, from its points.
rsm::GatherInputs gather_inputs(const Scene& scene, const Settings& settings, const Frame& frame, int light,
                                const Geometry& geometry, const rsm::Pattern& pattern, const RayQuery* rays);
bool is_gather(const std::string& stage);  // "rsm.disc" and its like

// One stage's values at one pixel (for stage "rsm": a texel of the light's map; the six maps of a point light lie side
// by side, so that x runs to 6 rsm_size).
struct Explanation {
    std::string stage;  // label
    glm::ivec2 pixel{0};
    std::vector<TapValue> values;
};

// Every named value of `stage` at `pixel`, from a frame that was executed. light: index into Scene::lights, or -1 for
// the first that the plan needs. An empty stage: all stages of the frame at that pixel, in order. Throws InputError for
// an unknown stage (naming the nearest), a stage that the plan leaves out, or a pixel outside the image.
std::vector<Explanation> explain(const Scene& scene, const Settings& settings, const Plan& plan, const Frame& frame,
                                 const std::string& stage, int light, glm::ivec2 pixel);

// Every stage that exists: the rows of `plumb stages`. First those of a frame, in its order, then passes that no frame
// runs by itself.
std::vector<StageInfo> all_stages();
bool in_a_frame(const std::string& stage);

}  // namespace plumb::frame
