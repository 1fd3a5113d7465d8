// The rays that are measured: those of a path tracer, in its order.
#pragma once

#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <vector>

#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::bench {

struct World {
    std::string name;
    Scene scene;
    Geometry geometry;
    raster::Surfaces surfaces;
};

// A generated scene, "cornell" from its file under `root`, or "atrium+masks". Only the last has alpha masks: calls to
// bare Embree know none.
World load_world(const std::string& name, const std::string& root);

struct BenchRay {
    glm::vec3 origin, direction;
    float t_near = 0, t_far = std::numeric_limits<float>::infinity();
};

// primary: from the camera, blocks of 4 x 4 pixels after each other. bounce: from the points those hit,
// cosine-weighted. shadow: from the same points to a random point of the scene's bounds.
struct RaySet {
    std::vector<BenchRay> primary, bounce, shadow;
};
RaySet make_rays(const World& world, glm::ivec2 size);

}  // namespace plumb::bench
