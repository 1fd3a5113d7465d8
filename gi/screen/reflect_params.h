// The parameters of reflections: the table [reflect] of a scene file. See gi/screen/README.md.
#pragma once

#include <vector>

#include "core/fields.h"
#include "core/stage.h"

namespace plumb::screen {

enum class March : int { off, steps, hierarchical };
enum class ReflectVariant : int { corrected, published };
enum class ReflectViews : int { camera, lights };
enum class Lobe : int { off, phong };

inline constexpr int most_march_steps = 4096, most_bisections = 24, most_cells = 65536, most_reflect_layers = 7,
                     most_lobe_rays = 64;

// fields() says what each means.
struct ReflectParams {
    March march = March::off;
    ReflectVariant variant = ReflectVariant::corrected;
    ReflectViews views = ReflectViews::camera;
    int layers = 0;
    Lobe lobe = Lobe::off;
    int rays = 8;
    float step = 0.1f;
    int steps = 64;
    int bisections = 8;
    int cells = 512;
    float thickness = 1.2f;
    float bias = 0.01f;
    float fade = 0;
    float attenuation = 0;
};
std::vector<Field> fields(ReflectParams& params);
std::vector<ParamInfo> reflect_params_of(const std::vector<std::string>& names);

// Throws InputError that names the parameter: what no range of one says.
void validate(const ReflectParams& params);

}  // namespace plumb::screen
