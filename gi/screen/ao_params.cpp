#include "gi/screen/ao_params.h"

#include <fmt/format.h>

#include "core/error.h"

namespace plumb::screen {

std::vector<Field> fields(AoParams& p) {
    using Role = SweepRange::Role;
    return {
        {"method", as_int(p.method), "",
         "ambient occlusion over indirect and ambient light: none, samples in a ball (LRA 4.2.3), or horizons (GTAO)", 0, 2,
         {"off", "ssao", "horizon"}, false},
        {"variant", as_int(p.variant), "", "corrected, or LRA's listings 6.2.3 and 6.3.2 as printed", 0, 1,
         {"corrected", "published"}, false},
        {"radius", &p.radius, "m", "beyond it nothing occludes; ours", 1e-6, 1e9, {}, false},
        {"bias", &p.bias, "m",
         "by which a surface has to rise above the point's plane to occlude; published: added to z; ours", 0, 1e9, {},
         false},
        {"samples", &p.samples, "", "in the half ball, of method = ssao; 64 is LRA 6.2.3's", 1, most_samples, {}, false,
         {Role::along, {4, 8, 16, 32, 64, 128}, "method", "ssao"}},
        {"views", as_int(p.views), "", "whose surfaces occlude: the camera's, or also those of every light that shines (LRA 4.3.2)",
         0, 1, {"camera", "lights"}, false, {Role::curves, {0, 1}, "method", "ssao"}},
        {"weight_bias", &p.weight_bias, "", "what a view's distances weigh, beside its direction (LRA 6.3.2); 0.25 is ours", 0, 1,
         {}, false},
        {"slices", &p.slices, "", "planes through the view vector, of method = horizon", 1, most_slices, {}, false,
         {Role::curves, {2, 4}, "method", "horizon"}},
        {"steps", &p.steps, "", "to each side of a slice", 1, most_steps, {}, false,
         {Role::along, {2, 4, 8, 16}, "method", "horizon"}},
        {"blur", as_int(p.blur), "",
         "over the 4 x 4 rotations: none, a box (LRA 6.2.3), or one that stops at edges (ours)", 0, 2,
         {"none", "box", "edge_aware"}, false},
        {"ambient", &p.ambient, "W/m2", "irradiance from everywhere that is added to indirect light, by the open share", 0, 1e20,
         {}, true},
    };
}

void validate(const AoParams& params) {
    AoParams copy = params;
    validate_fields("ao", fields(copy));
    if (params.method != AoMethod::horizon) return;
    if (params.views == AoViews::lights)
        throw InputError("ao: views = lights with method = horizon: expected method = ssao, since horizons are the camera's");
    if (params.variant == AoVariant::published)
        throw InputError("ao: variant = published with method = horizon: expected method = ssao, of which LRA has listings");
}

std::vector<ParamInfo> params_of(const std::vector<std::string>& names) {
    AoParams defaults;
    return describe(fields(defaults), names);
}

}  // namespace plumb::screen
