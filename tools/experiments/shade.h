// plumb experiment indirect-shadow: what dynamic meshes change of indirect light, by path tracing with and without them, and how much of it
// each way of `probes.indirect_shadow` tells, beside its time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

struct ShadeRequest {
    glm::ivec2 size{96, 96};
    int samples = 2048;      // paths a pixel of each truth
    int repeats = 5;         // whose median is the time
    double least = 0.01;     // the region: where the truth changes by more than this share of itself
};

// Of luminance in the region, all relative to the mean |change| of the truth there.
struct ShadeErrors {
    int pixels = 0;
    double irradiance = 0;  // mean without the meshes, W/m2
    double change = 0;      // mean |change| of the truth, of that irradiance
    double bias = 0;        // mean of (own change - true change)
    double mean = 0;        // of its absolute value; the truths' noise is in it
    double rms = 0;         // the truths' noise taken out
    double noise = 0;       // of the truths' difference
    double uncertain = 0;   // standard error of `bias`
};
struct ShadeRow {
    std::string name;
    int spheres = 0;                // of all meshes
    double ms = 0, fit_ms = 0;      // of what runs in every frame; of what runs once
    ShadeErrors black, whole;       // against meshes that reflect nothing, and against them as they are
    Image4 indirect, error;         // signed, against black ones
};
struct ShadeResult {
    std::string scene;
    int receivers = 0, places = 0;
    ShadeRequest request;
    std::vector<ShadeRow> rows;
    Image4 truth;                   // signed change by black meshes
};
ShadeResult measure_shade(const Scene& scene, frame::Settings settings, const ShadeRequest& request, const RunOptions& options,
                          const std::function<void(const std::string&)>& tell);

}  // namespace plumb::cli
