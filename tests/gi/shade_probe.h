// Warps, surface scattering and the environment over a list of points, compiled for every instruction set.
#pragma once

#include "core/hash.h"
#include "core/isa.h"
#include "gi/reference/bsdf_kernel.h"
#include "gi/reference/environment_kernel.h"

namespace plumb::reference {

// Rows of floats: u_lobe, u1, u2, exponent; n, w_o, w_i; diffuse, specular, mirror; padding.
inline constexpr int shade_inputs = 24, shade_outputs = 48;

struct ShadeProbe {
    EnvironmentArgs environment;
    int count;        // a multiple of 16
    const float* in;  // [count][shade_inputs]
    float* out;       // [count][shade_outputs]
};

template <Isa isa>
void probe_shading(const ShadeProbe& in);

// Number `dimension` of point i, in [0, 1).
inline float hashed(int i, int dimension, int seed = 1) {
    return unit_float<float>(pixel_hash<std::int32_t>(i, dimension, 0, seed).x);
}
inline glm::dvec3 hashed_direction(int i, int dimension, int seed = 1) {
    const double z = 2.0 * hashed(i, dimension, seed) - 1, s = __builtin_sqrt(1 - z * z);
    const double angle = 2 * host::pi * hashed(i, dimension + 1, seed);
    return {s * host::cos(angle), s * host::sin(angle), z};
}

}  // namespace plumb::reference
