// Image-space radiosity in a frame (gi/isr): which of its stages run, what each reads, and where it leaves what it makes.
//
// Light comes from sources: what the frame itself sees, or a wider view in its place (guard band), and what is added to
// it (depth layers, additional cameras). Every source but the frame has a G-buffer, shadows and direct light of its own
// (Frame::views). Receivers are the frame's coarse pixels alone.
#pragma once

#include <string>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::frame {

enum class ViewKind : int { own, guard, layer, camera };

struct IsrView {
    ViewKind kind = ViewKind::own;
    std::string name;      // "guard", "layer 2", "camera 1"
    Camera camera;
    glm::ivec2 size{0};    // pixels
    int margin = 0;        // coarse pixels on each side of the frame
    int behind = 0;        // of a layer: the view that it lies behind
};
// [0] is the frame itself; the others as Frame::views.
std::vector<IsrView> isr_views(const Scene& scene, const Settings& settings);

bool draws_view(const std::string& stage);    // "gbuffer", "gbuffer.layer"
// What a layer has to lie behind; null for a view that is none.
const Image1* peeled_depth(const Scene& scene, const Settings& settings, const Frame& frame, int view);

bool is_isr(const std::string& stage);        // "isr.gather" and its like
bool is_isr_gather(const std::string& stage); // isr.gather, isr.gather_camera
std::string isr_work(const PlannedStage& stage);  // as rules name it: "isr", "isr.ssao" or "isr.lit"; isr.compose: "compose"
bool gathers_isr(const Settings& settings);   // method isr in a mode that shows indirect light
bool casts_shadows(const Settings& settings); // not in ISR's modes F3 and F5

// Stages by name, form, view and pass, in the order in which they run; isr.compose is not one of them.
struct IsrStage {
    std::string name, form;
    int view = 0;
    int pass = 0;   // of gathers, isr.bounce and isr.unseen: index into Frame::isr's images
    int other = 0;  // of isr.unseen: the view that may see the same
};
std::vector<IsrStage> isr_stages(const Scene& scene, const Settings& settings);

// Coarse pixels of what a stage writes; isr.upsample's are the frame's own.
glm::ivec2 isr_size(const Scene& scene, const Settings& settings, const PlannedStage& stage);

// Where a stage leaves what it makes, and a name of that place.
Image4& isr_result(Frame& frame, const PlannedStage& stage);
const Image4& isr_result(const Frame& frame, const PlannedStage& stage);
std::string isr_place(const PlannedStage& stage);

// What a stage reads of a frame. `pattern` is gather_pattern() or ssao_pattern() of gi/isr.
isr::Coarse coarse_of(const std::string& form);
isr::DownsampleInputs downsample_inputs(const Scene& scene, const Frame& frame, const PlannedStage& stage);
isr::GatherInputs gather_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                const PlannedStage& stage, const isr::Pattern& pattern);
isr::UnseenInputs unseen_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                const PlannedStage& stage);
isr::CameraGatherInputs camera_gather_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                             const PlannedStage& stage, const isr::Pattern& pattern);
isr::SsaoInputs ssao_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                            const isr::Pattern& pattern);
isr::BounceInputs bounce_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                const PlannedStage& stage);
isr::BlurInputs isr_blur_inputs(const Settings& settings, const Frame& frame, const PlannedStage& stage);
isr::UpsampleInputs upsample_inputs(const Scene& scene, const Settings& settings, const Frame& frame);
isr::ComposeInputs compose_inputs(const Scene& scene, const Frame& frame);

// What a stage makes of a frame that holds what it reads. tiles: as its run() takes them; null: all.
void make_isr(const Scene& scene, const Settings& settings, const Frame& frame, const PlannedStage& stage,
              const RunOptions& options, Image4& result, const raster::Covered* tiles = nullptr);

// Makes room for the views, so that stages can write into them.
void begin_views(const Scene& scene, const Settings& settings, Frame& frame);

// What no setting of [isr] alone says: throws InputError.
void check_isr(const Scene& scene, const Settings& settings);

}  // namespace plumb::frame
