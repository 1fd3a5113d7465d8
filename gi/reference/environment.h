// Light from infinity: one radiance from everywhere, or a map, with tables to sample it by its luminance.
#pragma once

#include "core/image.h"
#include "core/scene.h"

namespace plumb::reference {

// [height][width] patches by longitude and latitude (core/scene.h, Environment). One patch where there is no map.
struct EnvironmentTable {
    int width = 0, height = 0;     // 0: black
    Buffer<float> radiance;        // [height][width][4]: W/(m2 sr), padding
    Buffer<float> row_cdf;         // [height + 1]: from 0 to 1, of what a patch sends: the sum of the channels over its
                                   // solid angle, of the interpolated ones where they are
    Buffer<float> column_cdf;      // [height][width + 1]
    Buffer<float> pdf;             // [height][width]: 1/sr, constant within a patch
    double mean_radiance = 0;      // over the sphere, mean of the three channels: what a lamp of it is chosen by
    bool bilinear = false;         // radiance is interpolated
};
EnvironmentTable environment_table(const Environment& environment);

// What every lookup reads (environment_kernel.h); the table has to outlive it.
struct EnvironmentArgs;
EnvironmentArgs environment_args(const EnvironmentTable& table);

}  // namespace plumb::reference
