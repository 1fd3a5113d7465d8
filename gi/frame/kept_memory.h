// What execute() holds from one frame to the next. Private to gi/frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "gi/frame/frame.h"
#include "gi/frame/keys.h"
#include "gi/rsm/kept_patterns.h"
#include "raster/workspace.h"

namespace plumb::frame {

// The scene as stages read it, each part made anew where its key changes.
struct World {
    Geometry geometry;
    glm::vec3 low{0}, high{0};       // bounds
    raster::Surfaces surfaces;
    raster::Surfaces plain;          // the same without normal maps; empty where nobody asks
    Geometry fixed;                  // of what stands still, for maps of static lamps; empty where there is none
    glm::vec3 fixed_low{0}, fixed_high{0};
    std::unique_ptr<RayQuery> rays;  // built for the first stage that traces
    PathScenes paths;
    std::optional<std::uint64_t> geometry_key, surfaces_key, paths_key, fixed_key;
    Rays kind = Rays::exact, paths_kind = Rays::exact;  // of `rays` and `paths`

    // keys: null where nothing is to be reused. After an exception nothing is.
    void update(const Scene& scene, const Settings& settings, const SceneKeys* keys);
};

// probes::bake_key() of the bake that was asked last. A bake that settings share does not change.
class BakeKey {
  public:
    // Of none: 0.
    std::uint64_t of(const std::shared_ptr<const probes::Bake>& bake);

  private:
    std::weak_ptr<const probes::Bake> bake_;
    std::uint64_t key_ = 0;
};

// What one light's map adds to ambient occlusion, apart from what views before it have summed, and a key of all that it is made from.
struct AoShare {
    graph::Key key = 0;
    Image4 sum;
};

struct KeptMemory {
    World world;
    BakeKey bake_key;
    raster::Workspace workspace;
    rsm::KeptPatterns patterns;
    Frame frame;
    graph::Kept made;                                  // empty: `frame` holds nothing to rely on
    std::vector<AoShare> ao_shares;                    // [AoBuffers::views]; empty where nothing is kept
    std::vector<Image4> irradiance, irradiance_error;  // [lights]: what each gather adds to the frame's
};

}  // namespace plumb::frame
