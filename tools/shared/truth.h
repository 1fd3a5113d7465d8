// How far the layers of a picture are from their path traced truth, and whether that can be told from its noise.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/compare.h"
#include "gi/frame/frame.h"
#include "gi/frame/reflect_classes.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// The standard error of a difference is that of the truth and the layer's own, the root of the sum of their squares:
// they were drawn independently.
struct TruthComparison {
    compare::Report report;        // of the layer against the truth; without the metrics of perception
    double noise = 0;              // root of the mean of the squared standard errors: the RMSE of an unbiased layer
    double bias = 0;               // mean of layer - truth over pixels and channels
    double share_above_noise = 0;  // of the pixels with a channel more than 3 standard errors (and 1e-5, for the
                                   // rounding of float) away from the truth; what is not finite is
    bool below_noise = false;      // RMSE <= noise: more samples are needed to see a difference
};
// own_error: of the layer, by channel; empty where it has none.
TruthComparison compare_with_truth(const Image4& layer, const Image4& own_error, const reference::Estimate& truth,
                                   int threads);

// The standard error of color: of rsm.all_rays with a subset of the texels, times albedo / pi; else empty.
Image4 color_error(const frame::Frame& frame);

// A layer beside the traced one that it approximates.
struct TruthRow {
    std::string name;  // "color", "direct", "indirect", "ao", "reflection"
    const frame::Traced* traced;
    TruthComparison comparison;
};
std::vector<TruthRow> compare_layers(const frame::Frame& frame, int threads);

// For run.json: "truth", of a frame with traced layers. On top what was traced for the picture and, where it stands
// beside the method's, how far color is from it; in own_transport the same for the layers direct and indirect.
Json truth_json(const frame::Frame& frame, const std::vector<TruthRow>& rows, const std::vector<std::string>& notes);

// The same for people; empty where nothing was traced.
std::string truth_text(const frame::Frame& frame, const std::vector<TruthRow>& rows,
                       const std::vector<std::string>& notes);

// What became of mirrored rays; nothing where their truth was not traced. For run.json: pixels of each class, in
// truth.mirrors; and for people.
std::optional<frame::MirrorClasses> mirror_classes(const Scene& scene, const frame::Settings& settings, const frame::Frame& frame,
                                                   const RunOptions& options);
Json mirror_json(const frame::MirrorClasses& classes);
std::string mirror_text(const frame::MirrorClasses& classes);

// One line for each layer with values that are not finite.
std::vector<std::string> truth_warnings(const frame::Frame& frame);

}  // namespace plumb::cli
