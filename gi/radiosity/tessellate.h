// Smaller triangles: evenly small, or where radiosity changes (HEM 4.5.4, step 1).
//
// Meshes come back in world space, with material, object, texture coordinates, normals and tangents carried over. Edges that
// triangles share, of one mesh or of two, are split alike: no T-junction is added. contacts.h counts those that were there.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"
#include "gi/radiosity/elements.h"

namespace plumb::radiosity {

struct TessellateParams {
    double longest_edge = 0.1;                // m, above 0
    std::int64_t most_triangles = 4'000'000;  // more are refused before memory is taken for them
};

// Halves every edge that is longer, till none is. Throws InputError for parameters out of range, a scene without triangles and
// too many of them. Edges that floats cannot halve stay.
Scene tessellate(const Scene& scene, const TessellateParams& params);

// How much what leaves a triangle differs on it: over its three corners (triangles: it and its neighbours of one object and
// material), the largest less the smallest, relative to their mean; of luminance (Rec. 709), or the root mean square over the three
// channels, whichever is larger. Means below `dark` of the scene's own (by area) count as so much: in the dark nobody sees it.
// Throws InputError where radiosity is not one value an element, or not finite.
std::vector<double> differences(const Elements& elements, const Buffer<glm::vec4>& radiosity, double dark);

struct RefineParams {
    double tolerance = 0.1;   // of differences()
    double least_edge = 0.02; // m: no edge shorter than twice this is halved
    double dark = 0.05;
    bool contacts = true;     // where another object's edge lies on a triangle both are split, too: light leaks there
    std::int64_t most_triangles = 4'000'000;
};

struct Refined {
    Scene scene;
    std::vector<std::uint32_t> origin;  // [triangle]: of which triangle of the elements' geometry it is a part
    std::int64_t different = 0;         // triangles split because they differ
    std::int64_t at_contacts = 0;       // because of a contact alone
    std::int64_t beside = 0;            // because an edge of theirs was split
    std::int64_t at_least_edge = 0;     // that differ and are as small as they may get
};

// One round: splits triangles that differ by more than the tolerance at all edges that may be split, and their neighbours so
// that longest edges are split first: angles stay above half of the least that there was (Rivara 1984). elements_of(scene) and
// the radiosity of its elements go in; the next round begins with elements_of(refined.scene).
//
// The edge of a shadow is found where it runs between a triangle's corners. One that enters through an edge of it alone is found
// a round later: the neighbour was split, and the edge's middle is a corner of both. What lies within one triangle is not found:
// tessellate() has to make triangles smaller than the shadows that count.
Refined refine(const Scene& scene, const Elements& elements, const Buffer<glm::vec4>& radiosity, const RefineParams& params);

}  // namespace plumb::radiosity
