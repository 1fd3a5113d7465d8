#include "tools/plumb/compare_layers.h"

#include <algorithm>

#include "io/image_file.h"

namespace plumb::cli {

namespace {

bool is_rgb(const compare::Picture& picture, const std::string& layer) {
    const std::string start = layer.empty() ? "" : layer + ".";
    return std::all_of(std::begin("RGB"), std::end("RGB") - 1, [&](char c) {
        return std::find(picture.channels.begin(), picture.channels.end(), start + c) != picture.channels.end();
    });
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::string headline_of(const compare::Picture& picture) {
    const std::vector<std::string> names = io::layer_names(picture);
    if (contains(names, "color")) return "color";
    if (is_rgb(picture, "")) return "";
    const auto rgb = std::find_if(names.begin(), names.end(), [&](const std::string& n) { return is_rgb(picture, n); });
    return rgb != names.end() ? *rgb : names.empty() ? "" : names.front();
}

std::string shown_layer(const std::string& layer, const std::vector<LayerReport>& all) {
    const bool taken = std::any_of(all.begin(), all.end(), [](const LayerReport& l) { return l.layer == "color"; });
    return !layer.empty() ? layer : taken ? "(no layer)" : "color";
}

LayeredReport compare_layers(const compare::Picture& a, const compare::Picture& b, const compare::Options& options,
                             bool all_perceptual) {
    if (io::layer_names(a).size() <= 1 || !compare::mismatch(a, b).empty())
        return {compare::compare(a, b, options), headline_of(a), {}};

    // All channels as one picture: is anything different, or no number?
    compare::Options unbounded = options;
    unbounded.max_error = unbounded.max_differing = std::nullopt, unbounded.max_ulp = std::nullopt;
    unbounded.perceptual = false;
    const compare::Report whole = compare::compare(a, b, unbounded);

    LayeredReport all;
    all.headline = headline_of(a);
    for (const std::string& name : io::layer_names(a)) {
        const bool is_headline = name == all.headline;
        compare::Options of_layer = options;
        of_layer.perceptual = is_headline || (all_perceptual && is_rgb(a, name));
        if (!is_headline && options.max_error && *options.max_error > 0) of_layer.max_error = std::nullopt;
        all.layers.push_back({name, compare::compare(io::select_layer(a, name, "A"), io::select_layer(b, name, "B"), of_layer)});
        if (is_headline) all.report = all.layers.back().report;
    }

    // The headline's own reason comes first; a NaN anywhere before it.
    compare::Report& report = all.report;
    report.equal = whole.equal, report.nonfinite = whole.nonfinite;
    if (whole.nonfinite > 0) report.agree = false, report.reason = whole.reason;
    if (!report.agree) return all;
    for (const LayerReport& l : all.layers) {
        if (l.report.agree) continue;
        report.agree = false, report.reason = "layer " + shown_layer(l.layer, all.layers) + ": " + l.report.reason;
        break;
    }
    return all;
}

}  // namespace plumb::cli
