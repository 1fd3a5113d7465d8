#include "gi/screen/reflect_params.h"

#include <fmt/format.h>

#include "core/error.h"

namespace plumb::screen {

std::vector<Field> fields(ReflectParams& p) {
    using Role = SweepRange::Role;
    return {
        {"march", as_int(p.march), "",
         "reflections in mirrors: none, by steps of one length (LRA 4.2.4), or from texel to texel over blocks of them",
         0, 2, {"off", "steps", "hierarchical"}, false},
        {"variant", as_int(p.variant), "", "corrected, or LRA's listing 6.2.4 as printed", 0, 1, {"corrected", "published"},
         false},
        {"views", as_int(p.views), "",
         "where rays are followed: in what the camera sees, or then also in the map of every light that shines (LRA 4.3.1)",
         0, 1, {"camera", "lights"}, false, {Role::curves, {0, 1}, "march", "steps"}},
        {"layers", &p.layers, "",
         "depth layers behind what the camera sees in which rays are followed, too (ISR chapter 6: depth peeling); ours", 0,
         most_reflect_layers, {}, false, {Role::along, {0, 1, 2, 3}, "march", "steps"}},
        {"lobe", as_int(p.lobe), "", "rough reflections: none, or rays of each pixel drawn from its material's Phong lobe; ours", 0, 1,
         {"off", "phong"}, false},
        {"rays", &p.rays, "", "of a pixel's lobe, of lobe = phong", 1, most_lobe_rays, {}, false,
         {Role::along, {1, 4, 16, 64}, "lobe", "phong"}},
        {"step", &p.step, "m", "along the ray; with steps how far it is followed, and the unit of thickness, by either march", 1e-6, 1e9, {}, false},
        {"steps", &p.steps, "", "at most; of march = hierarchical steps times step is how far a ray is followed", 1, most_march_steps, {}, false,
         {Role::along, {16, 32, 64, 128, 256}, "march", "steps"}},
        {"bisections", &p.bisections, "", "of the step that met something", 0, most_bisections, {}, false},
        {"cells", &p.cells, "", "texels and blocks of them that a ray passes at most, of march = hierarchical", 1, most_cells,
         {}, false, {Role::along, {64, 128, 256, 512}, "march", "hierarchical"}},
        {"thickness", &p.thickness, "",
         "of what is seen, in steps: what passes farther behind is not met; published: m, against the step's world z", 0, 1e9,
         {}, false},
        {"bias", &p.bias, "m", "by which a surface has to rise above the mirror's plane for a step, or a texel, to meet it; ours", 0, 1e9, {}, false},
        {"fade", &p.fade, "", "share of the picture's smaller side over which what is met fades towards its border", 0, 0.5, {},
         false},
        {"attenuation", &p.attenuation, "m",
         "distance at which half of what is met is left; 0: all of it, as light has it", 0, 1e9, {}, false},
    };
}

void validate(const ReflectParams& params) {
    ReflectParams copy = params;
    validate_fields("reflect", fields(copy));
    if (params.variant != ReflectVariant::published) return;
    if (params.march == March::hierarchical)
        throw InputError("reflect: variant = published with march = hierarchical: expected march = steps, of which LRA has a listing");
    if (params.layers > 0)
        throw InputError(fmt::format("reflect: variant = published with layers = {}: LRA has no such layers: expected 0", params.layers));
    if (params.lobe != Lobe::off) throw InputError("reflect: variant = published with lobe = phong: LRA has mirrors alone: expected off");
    if (params.views == ReflectViews::lights)
        throw InputError("reflect: variant = published with views = lights: LRA's listing 6.3.1 compares world z with depths "
                         "of 0 to 1: expected views = camera");
}

std::vector<ParamInfo> reflect_params_of(const std::vector<std::string>& names) {
    ReflectParams defaults;
    return describe(fields(defaults), names);
}

}  // namespace plumb::screen
