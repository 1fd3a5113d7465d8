// The views beside the frame: those that image-space radiosity draws, what probes' rays meet, a ray a pixel, the layers that
// mirrored rays are followed in, and what they meet there and in the lights' maps.
//
// Light comes from sources: what the frame itself sees, or a wider view in its place (guard band), and what is added to
// it (depth layers, additional cameras). Every source but the frame has a G-buffer, shadows and direct light of its own
// (Frame::views). Receivers are the frame's coarse pixels alone.
#pragma once

#include <string>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::frame {

enum class ViewKind : int { own, guard, layer, camera, probe_rays, mirror_layer, mirrored };

struct IsrView {
    ViewKind kind = ViewKind::own;
    std::string name;      // "guard", "layer 2", "camera 1", "mirrored layer 2"
    Camera camera;
    glm::ivec2 size{0};    // pixels
    int margin = 0;        // coarse pixels on each side of the frame
    int behind = 0;        // of a layer: the view that it lies behind
};
// [0] is the frame itself; the others as Frame::views. Without a bake the size of the probes' view is a guess.
std::vector<IsrView> isr_views(const Scene& scene, const Settings& settings);
// How many of them come before those of reflections, which are the last and send no indirect light.
int views_before_mirrors(const std::vector<IsrView>& views);

bool gathers_isr(const Settings& settings);    // method isr in a mode that shows indirect light
bool lights_probes(const Settings& settings);  // method probes
bool solves_radiosity(const Settings& settings);  // method radiosity
bool casts_shadows(const Settings& settings);  // not in ISR's modes F3 and F5
bool filters_shadows(const Settings& settings);  // shadow.filter runs
bool reflects_maps(const Settings& settings);  // mirrored rays are followed in the lights' maps

// What no setting of [isr] alone says: throws InputError.
void check_isr(const Scene& scene, const Settings& settings);

}  // namespace plumb::frame
