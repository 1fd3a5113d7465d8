#include "gi/probes/run_params.h"

namespace plumb::probes {

std::vector<Field> fields(RunParams& p) {
    return {
        {"file", &p.file, "", "a bake of this scene; empty: one is made, and kept (plumb bake)", -unbounded, unbounded, {}, false},
        {"loop", as_int(p.loop), "", "rounds until nothing changes, or one a frame with the latency of a GPU's pipeline (IPR figure 3.30)",
         -unbounded, unbounded, {"converged", "pipelined"}, false},
        {"tolerance", &p.tolerance, "", "what further rounds may add, of the mean irradiance", 1e-6, 1, {}, false},
        {"rounds", &p.rounds, "", "rounds at most", 1, 1e6, {}, false},
        {"feedback", as_int(p.feedback), "", "what comes back of the lightmap's irradiance: rho / pi; as published a constant, or rho (IPR 3.3.1.5)",
         -unbounded, unbounded, {"corrected", "constant", "material"}, false},
        {"reflection", &p.reflection, "", "the constant of feedback = constant (IPR 3.3.1.5)", 0, 100, {}, false},
        {"start", as_int(p.start), "", "what pipelined frames begin with", -unbounded, unbounded, {"converged", "black"}, false},
        {"unasked", as_int(p.unasked), "", "what probes find where no receiver asks, behind backs and beyond openings: what lies nearest, or black as published", -unbounded,
         unbounded, {"nearest", "black"}, false},
        {"volume", as_int(p.volume), "", "irradiance of dynamic objects by six of spatial receivers: cube, linear, or angles as printed (IPR 4.1.2)", -unbounded, unbounded,
         {"cube", "linear", "angles"}, false},
        {"indirect_shadow", as_int(p.indirect_shadow), "", "what dynamic meshes hide of indirect light: nothing; by spheres, of light from everywhere alike or as spatial receivers have it, and with what the meshes send; by rays",
         -unbounded, unbounded, {"off", "uniform", "spheres", "reflecting", "rays"}, false},
        {"shadow_spheres", &p.shadow_spheres, "", "spheres of each dynamic mesh at most (indirect_shadow)", 1, 1024, {}, false},
        {"shadow_rays", &p.shadow_rays, "", "rays of a pixel against dynamic meshes (indirect_shadow = rays)", 1, 4096, {}, false},
        {"relight_dynamic", &p.relight_dynamic, "", "probes' rays end on dynamic meshes, too: what these hide of all bounces, and what they send", -unbounded, unbounded, {}, false},
        {"window", as_int(p.window), "", "over the degrees of harmonics, against ringing: none, Hann's, Lanczos' (Sloan 2008)", -unbounded, unbounded,
         {"none", "hann", "lanczos"}, false},
        {"relief", as_int(p.relief), "", "what of normal maps and highlights is shown (IPR 5.2.1.3)", -unbounded, unbounded,
         {"off", "normals", "specular", "all"}, false},
        {"layers", &p.layers, "", "whether the layers of IPR figure 5.20 are made beside the picture: diffuse, normals, specular", -unbounded, unbounded,
         {}, false},
        {"static_lamps", &p.static_lamps, "",
         "names of lamps, \"a, b\", that what moves neither shadows nor sees but by spatial receivers (IPR 5.2.1.5)", -unbounded, unbounded, {}, false},
    };
}

}  // namespace plumb::probes
