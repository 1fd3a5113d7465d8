// The layers of a frame that are path traced: the picture of the method reference, and the truth beside a method's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gi/frame/settings.h"
#include "gi/reference/cache.h"
#include "raster/gbuffer.h"

namespace plumb::frame {

// Whether that layer is traced by the method's own transport: "truth.direct" and "truth.indirect".
bool own_transport(const std::string& layer);
// The scene as that transport sees it: diffuse surfaces, and lamps alone.
Scene lamps_only(Scene scene);

struct Traced {
    std::string layer;                 // "color", or "truth", "truth.direct", "truth.indirect", "truth.ao", "truth.reflection"
    reference::PathParams params;
    reference::Estimate estimate;
    std::vector<std::string> without;  // what the scene has and this layer leaves out, as the method does, or paths do not find
    double ms = 0;                     // that tracing took; of a kept estimate: when it was traced
    bool cached = false;
};

// The scene as rays see it: all of it, and lamps_only() of it where that is less. Made where something has to be traced.
struct PathScenes {
    std::unique_ptr<reference::PathScene> whole, own;
};

// Traces layer by layer.
class Tracer {
  public:
    // The arguments must outlive the tracer; store and paths may be null. `paths`: empty, or what a tracer of the same
    // scene and kind of rays left there.
    Tracer(const Scene& scene, const Settings& settings, const Geometry& geometry, reference::Store* store,
           PathScenes* paths = nullptr);

    // "color" and "truth": outgoing radiance by [reference]. "truth.direct" and "truth.indirect": irradiance at the
    // G-buffer's points of lamps_only(scene), without a bounce and by exactly one: emission, the environment, specular
    // and mirror parts send no light there, as they send none in the method. "truth.ao": the share of the cosine-weighted
    // hemisphere over those points in which rays of [ao] radius meet nothing. "truth.reflection": what their mirrors send to
    // the camera, of the whole scene; of the G-buffer's triangles, whose materials say how much.
    Traced trace(const std::string& layer, const raster::GBuffer& gbuffer, const RunOptions& options);
    // The layer where the plan knows that no light is in it: 0, without a sample and without an error.
    Traced dark(const std::string& layer) const;

  private:
    struct View {
        const Scene* scene;
        std::unique_ptr<reference::PathScene>& paths;
    };
    Traced begin(const std::string& layer) const;
    const reference::PathScene& paths(View& view) const;

    const Scene& scene_;
    const Settings& settings_;
    const Geometry& geometry_;
    reference::Store* store_;
    Scene lamps_;                       // lamps_only(scene); empty where the scene has nothing else
    std::vector<std::string> without_;  // what else it has
    PathScenes mine_;                   // where nobody gave any
    View whole_, own_;
};

}  // namespace plumb::frame
