// The loop over pairs of surface points in which fitted transport (fit.h) spends its time, compiled once an instruction set. Lanes run
// across the points of a probe, and each value is one sum in ascending order: the bits are the same at any width.
#pragma once

#include <vector>

#include "core/isa_name.h"

namespace plumb::probes {

// A point that light leaves, and what it counts for.
struct FitPoint {
    float x, y, z;           // m
    float nx, ny, nz;        // unit, on the side that is seen
    float weight;
};

inline constexpr int fit_lanes = 16;  // points of a probe are padded to a multiple

// What a probe sees, each component by itself: positions m, unit normals.
struct FitPoints {
    const float *x, *y, *z, *nx, *ny, *nz;
    int padded;
};

template <Isa isa>
struct FitLoops {
    // sums[i] = sum over k of weight_k C(point i, k), for i < points.padded. scale: 1 / range, 1/m.
    static void covariances(const FitPoints& points, const FitPoint* others, int count, float scale, float* sums);
};

}  // namespace plumb::probes
