// Compares files of several layers: each layer by itself, and as the headline the one that is a picture.
#pragma once

#include <string>
#include <vector>

#include "core/compare.h"

namespace plumb::cli {

struct LayerReport {
    std::string layer;  // "" for channels without one
    compare::Report report;
};

struct LayeredReport {
    // The figures of `headline`. equal, nonfinite, agree and reason are of all layers.
    compare::Report report;
    std::string headline;             // the layer of the figures
    std::vector<LayerReport> layers;  // in the file's order; empty where a file has one layer, or they cannot be compared
};

// "color"; without it the channels that have no layer, where they are red, green and blue; then the first layer that is;
// then the first one.
std::string headline_of(const compare::Picture& picture);

// What people read: channels without a layer are the picture.
std::string shown_layer(const std::string& layer, const std::vector<LayerReport>& all);

// max_ulp and max_differing hold of each layer, max_error of the headline: a metre is no radiance. A max_error of 0 has
// no unit and holds of each. SSIM and FLIP are of layers of red, green and blue; `all_perceptual`: not only of the
// headline.
LayeredReport compare_layers(const compare::Picture& a, const compare::Picture& b, const compare::Options& options,
                             bool all_perceptual);

}  // namespace plumb::cli
