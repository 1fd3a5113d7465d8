#include "gi/screen/reuse_params.h"

namespace plumb::screen {

std::vector<Field> fields(ReuseParams& p) {
    using Role = SweepRange::Role;
    return {
        {"frames", &p.frames, "",
         "of which gathered light is a mean, where a surface was seen before (LRA 4.3.3, conclusion); each turns its samples; 0: off",
         0, 4096, {}, false, {Role::along, {1, 4, 16, 64}, "", ""}},
        {"clamp", as_int(p.clamp), "",
         "what the last frame had may be anything, or is held within what 3 x 3 pixels have now, against ghosts (ours)", 0, 1,
         {"none", "box"}, false},
        {"sigma_depth", &p.sigma_depth, "depths",
         "how far off the pixel's plane a pixel of the last frame may lie, as a share of the depth; ours", 1e-6, 1e6, {}, true},
        {"sigma_normal", &p.sigma_normal, "", "how far its normal may be turned: 1 - cosine; ours", 1e-4, 1, {}, true},
    };
}

void validate(const ReuseParams& params) {
    ReuseParams copy = params;
    validate_fields("reuse", fields(copy));
}

std::vector<ParamInfo> reuse_params_of(const std::vector<std::string>& names) {
    ReuseParams defaults;
    return describe(fields(defaults), names);
}

}  // namespace plumb::screen
