// plumb cameras: lists of views, drawn at random or recorded from a scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/camera_list.h"

namespace plumb::cli {

// How random views are drawn.
struct RandomViews {
    int count = 10;
    std::uint32_t seed = 1;
    double surface = 0.6;  // share of the pixels that see a surface, at least
    double lit = 0.05;     // share of the pixels that a lamp lights directly, at least
    int attempts = 4000;   // for each view, before it is given up
};

// What rays say about a view.
struct ViewReport {
    double surface = 0, lit = 0;  // shares of the pixels
    double nearest = 0;           // m: to the nearest surface seen
};

// Positions are uniform in the scene's bounding box; one counts that lies outside of solids and not too near a surface
// (view_clearance); the line of sight is uniform in its bearing, and in the sine of its elevation within 30 degrees;
// the field of view is 45..75 degrees. A view counts that sees enough surface and enough light. The same views
// everywhere for a seed. Throws InputError where `attempts` do not find one.
std::vector<io::ListedCamera> random_views(const Scene& scene, const std::string& scene_word, const std::string& prefix,
                                           const RandomViews& wanted);

// m: how far from all surfaces a random position has to be.
double view_clearance(const Scene& scene);

// By rays through a grid of pixels of the scene's camera.
ViewReport report_of_view(const Scene& scene);

}  // namespace plumb::cli
