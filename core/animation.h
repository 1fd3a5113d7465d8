// Motion by keyframes, curves and rates: a scene with an animation is a scene at every frame.
#pragma once

#include "core/scene.h"

namespace plumb {

// The value of a track at `frame`: linear in double between two keys, held before the first and after the last. The
// track is not empty.
glm::dvec3 value_at(const Track& track, double frame);
// The same without a way between keys: the value of the last key at or before `frame`.
glm::dvec3 step_at(const Track& track, double frame);

// The Bezier curve of 1 or more control points at t, 0..1, by de Casteljau's algorithm in double. The curve begins at
// the first point and ends at the last, to the bit.
glm::dvec3 bezier_at(const std::vector<glm::dvec3>& points, double t);
// Where the motion is along its curve at `frame`, 0..1.
double path_parameter(const Motion& motion, double frame);

// The scene in its pose at `frame`: what no track moves stays as it is. Poses replace each other:
// scene_at(scene_at(s, a), b) is scene_at(s, b). Throws InputError that names the frame where camera or light have no
// direction there, or a mesh no size.
Scene scene_at(Scene scene, double frame);

// Whether anything moves.
bool is_animated(const Scene& scene);

}  // namespace plumb
