// Windows over the degrees of harmonics, against ringing (Sloan 2008, "Stupid Spherical Harmonics (SH) Tricks", Windowing), and what
// rings: receivers whose irradiance is negative.
//
//     lambda_lm becomes sigma_l lambda_lm            w = degree + 1, so that the highest degree is not lost
//
//     none       sigma_l = 1
//     Hann       sigma_l = (1 + cos(pi l / w)) / 2
//     Lanczos    sigma_l = sin(pi l / w) / (pi l / w)
//
// sigma_0 is 1: the mean over all directions stays, and so does a constant radiance.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "core/image.h"

namespace plumb::probes {

enum class Window : int { none, hann, lanczos };

// sigma_0 .. sigma_degree. Throws InputError for a degree outside of 0..7.
std::vector<double> window_factors(Window window, int degree);

// harmonics_of() times the window: [rays][(degree + 1)^2], as probes.lambda reads it. `none` is the same numbers. Throws InputError
// for a table that is not whole rows.
Buffer<float> windowed(const Buffer<float>& harmonics, int degree, Window window);

struct NegativeIrradiance {
    int computed = 0;  // receivers
    int negative = 0;  // of these, with a negative channel
    float least = 0;   // of all channels, W/m2; at most 0
};
// Of irradiances with w 1 where they were computed. Throws InputError for one of these that is not finite.
NegativeIrradiance negative_irradiance(const Buffer<glm::vec4>& irradiance);

}  // namespace plumb::probes
