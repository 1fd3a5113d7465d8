// The parameters of irradiance probes at run time: the part of the table [probes] of a scene file that a bake does not depend on.
#pragma once

#include <string>
#include <vector>

#include "core/fields.h"
#include "gi/probes/window.h"

namespace plumb::probes {

// converged: rounds until nothing changes. pipelined: one round a frame, each stage on what the others left in the frame before,
// as a GPU's two branches have it (IPR figure 3.30): what happens in frame n is in the picture of frame n + 4.
enum class Loop : int { converged, pipelined };
// What of the lightmap's irradiance comes back from a surface.
enum class Feedback : int {
    corrected,  // rho / pi
    constant,   // a constant, IPR 3.3.1.5
    material,   // rho, IPR 3.3.1.5 "a material reflection"
};
// What pipelined frames begin with.
enum class Start : int { converged, black };
// What a probe finds in directions in which no receiver asks (stand_in.h).
enum class Unasked : int { nearest, black };
// How six irradiances of spatial receivers make that of a normal (volume_kernel.h).
enum class VolumeForm : int { cube, linear, angles };
// What dynamic meshes hide of indirect light (indirect_shadow_kernel.h).
enum class IndirectShadow : int {
    off,
    uniform,     // spheres; light comes from everywhere alike
    spheres,     // spheres, and the light that spatial receivers know of
    reflecting,  // the same, and what the objects send of it
    rays,        // rays against the meshes themselves, and the light that spatial receivers know of
};
// What of normal maps and of highlights is shown (IPR 5.2.1.3, figure 5.20).
enum class ReliefOf : int {
    off,       // surfaces as if they had neither
    normals,   // normal maps
    specular,  // highlights
    all,
};

struct RunParams {
    std::string file;                        // a bake; empty: one is made, and kept
    Loop loop = Loop::converged;
    float tolerance = 1e-3f;                 // of what later rounds add, of the mean irradiance
    int rounds = 1000;                       // at most
    Feedback feedback = Feedback::corrected;
    float reflection = 0.19f;                // c of the constant feedback (IPR 3.3.1.5)
    Start start = Start::converged;
    Unasked unasked = Unasked::nearest;
    VolumeForm volume = VolumeForm::linear;
    IndirectShadow indirect_shadow = IndirectShadow::off;
    int shadow_spheres = 16;                 // at most, of each dynamic mesh
    int shadow_rays = 64;                    // of a pixel
    bool relight_dynamic = false;            // relight rays end on dynamic meshes, too (shadow_rays.h)
    Window window = Window::none;            // over the degrees of the bake's harmonics
    ReliefOf relief = ReliefOf::all;
    bool layers = false;                     // the layers of figure 5.20 beside the picture
    std::string static_lamps;                // names, "a, b": lamps that reach what moves by spatial receivers alone (IPR 5.2.1.5)
};
inline bool maps_normals(const RunParams& p) { return p.relief == ReliefOf::normals || p.relief == ReliefOf::all; }
inline bool has_highlights(const RunParams& p) { return p.relief == ReliefOf::specular || p.relief == ReliefOf::all; }
std::vector<Field> fields(RunParams& params);

}  // namespace plumb::probes
