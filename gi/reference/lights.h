// Everything that emits, in one table, and how likely a path chooses each.
#pragma once

#include "core/image.h"
#include "core/scene.h"
#include "gi/reference/environment.h"
#include "raster/surfaces.h"

namespace plumb::reference {

struct LightTable {
    // A light a row: the scene's lamps that shine, then emitting triangles, then the environment.
    Buffer<float> rows;            // [light][16]: light_kernel.h
    Buffer<float> cdf;             // [lights + 1]: from 0 to 1
    Buffer<float> triangle_pdf;    // [triangle]: probability of the triangle over its area, 1/m2; 0: does not emit
    int count = 0, lamps = 0;      // lamps: of these rows the first
    bool any_triangle = false, any_radius = false;
    float environment_probability = 0;
};

// Half of the choices are in proportion to what a light sends into the scene's bounding sphere (W, summed over the
// channels), half are even over the sources: lamps, objects that emit, the environment.
LightTable light_table(const Scene& scene, const Geometry& geometry, const raster::Surfaces& surfaces,
                       const EnvironmentTable& environment);

}  // namespace plumb::reference
