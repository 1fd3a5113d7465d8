#include "tools/shared/truth.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

compare::Picture rgb_of(const Image4& image) {
    compare::Picture picture{{"R", "G", "B"}, image.width, image.height, {}};
    picture.data.reserve(3 * image.size());
    for (const glm::vec4& v : image.texels) picture.data.insert(picture.data.end(), {v.x, v.y, v.z});
    return picture;
}

// JSON has neither NaN nor infinity.
Json number_json(std::optional<double> value) { return value && std::isfinite(*value) ? Json(*value) : Json(nullptr); }

std::string mode_name(const reference::PathParams& given) {
    reference::PathParams params = given;
    std::vector<Field> fields = reference::fields(params);
    return find_field(fields, "mode", "reference").choices.at(std::size_t(params.mode));
}
const char* kind_name(const reference::PathParams& params) { return params.rays == Rays::exact ? "exact" : "native"; }

double rays_per_second(const frame::Traced& t) { return t.ms > 0 ? double(t.estimate.rays) / (t.ms * 1e-3) : 0; }

Json estimate_json(const frame::Traced& t) {
    const reference::Estimate& e = t.estimate;
    Json json = {{"mode", mode_name(t.params)},
                 {"kind", kind_name(t.params)},
                 {"samples", e.samples},
                 {"rounds", e.rounds},
                 {"rays", e.rays},
                 {"relative_error", number_json(e.relative_error)},
                 {"nonfinite", e.nonfinite},
                 {"ms", t.ms},
                 {"rays_per_second", rays_per_second(t)},
                 {"cached", t.cached}};
    if (!t.without.empty()) json["without"] = t.without;
    return json;
}

void add_comparison(const TruthComparison& c, Json& json) {
    json["mean_error"] = number_json(c.report.mean_error);
    json["rmse"] = number_json(c.report.rmse);
    json["rel_mse"] = number_json(c.report.rel_mse);
    json["psnr"] = number_json(c.report.psnr);
    json["noise"] = number_json(c.noise);
    json["bias"] = number_json(c.bias);
    json["share_above_noise"] = c.share_above_noise;
    json["below_noise"] = c.below_noise;
}

std::string seconds_text(double ms) { return fmt::format("{:.3g} s", ms * 1e-3); }

std::string traced_text(const frame::Traced& t) {
    const reference::Estimate& e = t.estimate;
    if (e.samples == 0) return t.layer + ": 0: no light is in it, nothing was traced\n";
    std::string text = fmt::format("{}: {}, {} samples in {} rounds, {} rays, standard error {} of the mean; ", t.layer,
                                   mode_name(t.params), e.samples, e.rounds, kind_name(t.params),
                                   std::isfinite(e.relative_error) ? fmt::format("{:.3g} %", 100 * e.relative_error)
                                                                   : "undefined");
    text += t.cached ? fmt::format("kept from before, when it took {}", seconds_text(t.ms))
                     : fmt::format("{:.3g} million rays in {}, {:.3g} million a second", double(e.rays) * 1e-6,
                                   seconds_text(t.ms), rays_per_second(t) * 1e-6);
    if (!t.without.empty()) text += fmt::format("; without {}", fmt::join(t.without, ", "));
    return text + "\n";
}

std::vector<std::string> comparison_row(const TruthRow& row) {
    const TruthComparison& c = row.comparison;
    auto number = [](std::optional<double> v) {
        return v && std::isfinite(*v) ? fmt::format("{:.4g}", *v) : std::string("undefined");
    };
    return {row.name,
            number(c.report.mean_error),
            number(c.report.rmse),
            number(c.noise),
            number(c.bias),
            fmt::format("{:.4g} %", 100 * c.share_above_noise),
            c.below_noise ? "the difference is below the noise" : ""};
}

}  // namespace

TruthComparison compare_with_truth(const Image4& layer, const Image4& own_error, const reference::Estimate& truth,
                                   int threads) {
    TruthComparison c;
    compare::Options options;
    options.perceptual = false;
    options.threads = threads;
    c.report = compare::compare(rgb_of(layer), rgb_of(truth.mean), options);

    double squares = 0, differences = 0;
    std::size_t above = 0;
    for (std::size_t i = 0; i < truth.mean.size(); ++i) {
        bool within = true;
        for (int k = 0; k < 3; ++k) {
            const double t = truth.mean.texels[i][k], d = layer.texels[i][k] - t;
            const double drawn = truth.error.texels[i][k], own = own_error.empty() ? 0 : own_error.texels[i][k];
            const double variance = drawn * drawn + own * own;
            squares += variance;
            differences += d;
            within = within && std::abs(d) <= 3 * std::sqrt(variance) + 1e-5 * std::abs(t);
        }
        if (!within) ++above;
    }
    const double values = 3 * double(truth.mean.size());
    c.noise = std::sqrt(squares / values);
    c.bias = differences / values;
    c.share_above_noise = double(above) / double(truth.mean.size());
    c.below_noise = c.report.rmse && *c.report.rmse <= c.noise;
    return c;
}

Image4 color_error(const frame::Frame& frame) {
    Image4 error = frame.indirect_error;
    for (std::size_t i = 0; i < error.size(); ++i)
        error.texels[i] *= frame.gbuffer.albedo.texels[i] / std::numbers::pi_v<float>;
    return error;
}

std::vector<TruthRow> compare_layers(const frame::Frame& frame, int threads) {
    std::vector<TruthRow> rows;
    auto compare = [&](const char* name, const char* truth, const Image4& layer, const Image4& own_error) {
        const frame::Traced* traced = frame::find_traced(frame, truth);
        if (traced) rows.push_back({name, traced, compare_with_truth(layer, own_error, traced->estimate, threads)});
    };
    compare("color", "truth", frame.radiance, color_error(frame));
    compare("direct", "truth.direct", frame.direct, {});
    compare("indirect", "truth.indirect", frame.indirect, frame.indirect_error);
    compare("ao", "truth.ao", frame.ao.open, {});
    compare("reflection", "truth.reflection", frame.reflect.reflection, {});
    return rows;
}

Json truth_json(const frame::Frame& frame, const std::vector<TruthRow>& rows, const std::vector<std::string>& notes) {
    const frame::Traced* picture = frame::find_traced(frame, "color");
    if (!picture) picture = frame::find_traced(frame, "truth");
    Json json = estimate_json(*picture), own = Json::object();
    for (const TruthRow& row : rows) {
        if (row.traced != picture) own[row.name] = estimate_json(*row.traced);
        add_comparison(row.comparison, row.traced == picture ? json : own[row.name]);
    }
    if (!own.empty()) json["own_transport"] = own;
    json["notes"] = notes;
    return json;
}

std::optional<frame::MirrorClasses> mirror_classes(const Scene& scene, const frame::Settings& settings, const frame::Frame& frame,
                                                   const RunOptions& options) {
    if (!frame::find_traced(frame, "truth.reflection")) return std::nullopt;
    return frame::classify_mirrors(scene, settings, frame, options);
}

Json mirror_json(const frame::MirrorClasses& classes) {
    Json json = {{"mirror_pixels", classes.mirrors()}};
    for (int i = 1; i < frame::mirror_classes; ++i) json[frame::name_of(frame::MirrorClass(i))] = classes.count[std::size_t(i)];
    return json;
}

std::string mirror_text(const frame::MirrorClasses& classes) {
    if (classes.mirrors() == 0) return "\nno pixel shows a mirror\n";
    std::string text = fmt::format("\nmirrored rays of {} pixels, against rays that meet the scene:\n", classes.mirrors());
    for (int i = 1; i < frame::mirror_classes; ++i) {
        const std::int64_t n = classes.count[std::size_t(i)];
        if (n > 0) text += fmt::format("  {:<14}{:6.2f} %\n", frame::name_of(frame::MirrorClass(i)), 100.0 * double(n) / double(classes.mirrors()));
    }
    return text;
}

std::string truth_text(const frame::Frame& frame, const std::vector<TruthRow>& rows,
                       const std::vector<std::string>& notes) {
    std::string text;
    for (const frame::Traced& t : frame.traced) text += traced_text(t);
    std::vector<std::vector<std::string>> cells;
    for (const TruthRow& row : rows) cells.push_back(comparison_row(row));
    if (!rows.empty()) {
        text += "\n" + format_table({{"against its truth"},
                                     {"mean error", Align::right},
                                     {"RMSE", Align::right},
                                     {"noise", Align::right},
                                     {"bias", Align::right},
                                     {"above 3 noise", Align::right},
                                     {""}},
                                    cells);
    }
    for (const std::string& note : notes) text += "note: " + note + "\n";
    return text;
}

std::vector<std::string> truth_warnings(const frame::Frame& frame) {
    std::vector<std::string> lines;
    for (const frame::Traced& t : frame.traced) {
        if (t.estimate.nonfinite == 0) continue;
        lines.push_back(fmt::format("warning: {}: {} values that are not finite; none was left out or clamped", t.layer,
                                    t.estimate.nonfinite));
    }
    return lines;
}

}  // namespace plumb::cli
