// The parameters of light reused from the last frame: the table [reuse] of a scene file. See gi/screen/README.md.
#pragma once

#include <vector>

#include "core/fields.h"
#include "core/stage.h"

namespace plumb::screen {

enum class ReuseClamp : int { none, box };

// fields() says what each means.
struct ReuseParams {
    int frames = 0;
    ReuseClamp clamp = ReuseClamp::none;
    float sigma_depth = 0.02f;
    float sigma_normal = 0.3f;
};
std::vector<Field> fields(ReuseParams& params);
std::vector<ParamInfo> reuse_params_of(const std::vector<std::string>& names);

// Throws InputError that names the parameter.
void validate(const ReuseParams& params);

}  // namespace plumb::screen
