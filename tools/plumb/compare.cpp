// plumb compare: how two pictures differ, and whether that is within bounds.
#include "core/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/compare_pictures.h"
#include "core/error.h"
#include "core/signed_error.h"
#include "io/file.h"
#include "io/image_file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/compare_layers.h"
#include "tools/shared/outputs.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct CompareOptions {
    Common common;
    std::string a, b, difference, signed_error, layer;
    bool negative = false;
    std::optional<double> max_error, max_differing;
    std::optional<std::uint32_t> max_ulp;
};

// Integer formats hold values encoded for a display.
bool encoded(const std::string& path) {
    const std::string extension = io::extension_of(path);
    for (const char* e : {"png", "jpg", "jpeg", "bmp", "tga", "gif"})
        if (extension == e) return true;
    return false;
}

bool has_layer(const compare::Picture& picture, const std::string& layer) {
    const std::vector<std::string> names = io::layer_names(picture);
    return std::find(names.begin(), names.end(), layer) != names.end();
}

// "color" is also the name of the channels that have no layer.
compare::Picture select(const compare::Picture& picture, const std::string& layer, const std::string& path) {
    const bool unnamed = layer == "color" && !has_layer(picture, "color") && has_layer(picture, "");
    return io::select_layer(picture, unnamed ? "" : layer, path);
}

// Of which layer the figures are, and one row a layer, where there are several.
std::string layers_text(const LayeredReport& all) {
    if (all.layers.empty()) return "";
    std::vector<std::vector<std::string>> rows;
    auto text = [](std::optional<double> v) { return v ? fmt::format("{:.4g}", *v) : std::string("undefined"); };
    for (const auto& [name, r] : all.layers)
        rows.push_back({shown_layer(name, all.layers), text(r.mean_error), text(r.rmse),
                        r.max_ulp == compare::saturated_ulp ? "undefined" : fmt::format("{}", r.max_ulp),
                        fmt::format("{:.4g} %", 100 * r.differing),
                        r.worst ? fmt::format("{},{} {}", r.worst->x, r.worst->y, r.worst->channel) : ""});
    return fmt::format("These are of the layer {}. Each layer by itself:\n\n", shown_layer(all.headline, all.layers)) +
           format_table({{"layer"},
                         {"mean error", Align::right},
                         {"RMSE", Align::right},
                         {"max ULP", Align::right},
                         {"differing", Align::right},
                         {"worst"}},
                        rows);
}

// The contract's keys are the headline's; what each layer has beside it.
Json layered_json(const LayeredReport& all) {
    Json json = compare_json(all.report);
    if (all.layers.empty()) return json;
    json["layer"] = shown_layer(all.headline, all.layers);
    json["layers"] = Json::array();
    for (const LayerReport& l : all.layers) {
        Json one = {{"layer", shown_layer(l.layer, all.layers)}};
        one.update(compare_json(l.report));
        json["layers"].push_back(std::move(one));
    }
    return json;
}

std::string verdict_text(const LayeredReport& all, bool bounded) {
    const compare::Report& report = all.report;
    if (!report.agree) return "disagree: " + report.reason;
    if (report.equal) return "equal, to the bit";
    std::string others;
    for (const LayerReport& l : all.layers)
        if (l.layer != all.headline && !l.report.equal)
            others += (others.empty() ? "" : ", ") + shown_layer(l.layer, all.layers);
    if (!others.empty()) others = fmt::format("; beside {} differ: {}", shown_layer(all.headline, all.layers), others);
    return (bounded ? "agree: within the bounds" : "they differ; no bound was given") + others;
}

// All layers, the one without a name first.
void write_layers(const std::string& file, const compare::Picture& picture) {
    std::vector<std::string> names = io::layer_names(picture);
    std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name.empty(); });
    std::vector<compare::Picture> parts;
    for (const std::string& name : names) parts.push_back(io::select_layer(picture, name, file));
    std::vector<io::Layer> layers;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        layers.push_back({names[i].empty() ? "color" : names[i], parts[i].channels, parts[i].data.data(),
                          int(parts[i].channels.size())});
    }
    io::write_exr(file, picture.width, picture.height, layers);
}

// R, G and B, clamped to 0..1.
std::vector<std::uint8_t> bytes_of(const compare::Picture& picture, const std::string& path) {
    const bool layered = io::layer_names(picture).size() > 1;
    const auto rgb = compare::linear_rgb(layered ? io::select_layer(picture, headline_of(picture), path) : picture,
                                         compare::Encoding::hdr);
    if (!rgb) throw InputError(path, "", "a PNG shows R, G and B, which the pictures do not have; use .exr");
    std::vector<std::uint8_t> bytes;
    for (const glm::dvec3& v : rgb->texels)
        for (int c = 0; c < 3; ++c) bytes.push_back(std::uint8_t(v[c] > 0 ? std::min(v[c], 1.0) * 255 + 0.5 : 0));
    return bytes;
}

// |a - b|: as it is in an EXR, a byte for 1/255 in a PNG.
void write_difference(const compare::Picture& a, const compare::Picture& b, bool negative, const std::string& path) {
    const compare::Picture difference =
        compare::difference(a, b, negative ? compare::Difference::negative : compare::Difference::absolute);
    const std::filesystem::path where(path);
    Outputs outputs(where.parent_path().string());
    outputs.write(where.filename().string(), [&](const std::string& file) {
        if (io::extension_of(path) == "exr")
            write_layers(file, difference);
        else
            io::write_png(file, difference.width, difference.height, bytes_of(difference, path).data());
    });
    outputs.commit();
}

// (A - B) / B of luminance, B with a floor of 5 % of its mean; full colour at half of B.
void write_signed_error(const compare::Picture& a, const compare::Picture& b, const compare::Options& options,
                        const std::string& path) {
    auto luminance = [&](const compare::Picture& picture) {
        const bool layered = io::layer_names(picture).size() > 1;
        const auto rgb = compare::linear_rgb(layered ? io::select_layer(picture, headline_of(picture), path) : picture,
                                             options.encoding);
        if (!rgb) throw InputError(path, "", "a signed error shows R, G and B, which the pictures do not have");
        compare::Plane plane(rgb->width, rgb->height);
        for (std::size_t i = 0; i < plane.size(); ++i) plane.texels[i] = compare::luminance(rgb->texels[i]);
        return plane;
    };
    const compare::Plane truth = luminance(b);
    double sum = 0, finite = 0;
    for (const double v : truth.texels)
        if (std::isfinite(v)) sum += std::abs(v), ++finite;
    const compare::Plane errors = compare::relative_errors(luminance(a), truth, finite > 0 ? 0.05 * sum / finite : 0);
    std::vector<std::uint8_t> bytes;
    for (const double e : errors.texels) {
        const glm::vec3 color = compare::signed_color(e, 0.5);
        for (int c = 0; c < 3; ++c) bytes.push_back(std::uint8_t(color[c] * 255 + 0.5f));
    }
    const std::filesystem::path where(path);
    Outputs outputs(where.parent_path().string());
    outputs.write(where.filename().string(),
                  [&](const std::string& file) { io::write_png(file, errors.width, errors.height, bytes.data()); });
    outputs.commit();
}

int run_compare(const CompareOptions& given) {
    compare::Options options;
    options.threads = given.common.run_options().threads;
    options.max_error = given.max_error;
    options.max_ulp = given.max_ulp;
    options.max_differing = given.max_differing;
    const std::string extension = io::extension_of(given.difference);
    if (!given.difference.empty() && extension != "exr" && extension != "png")
        throw InputError("-o " + given.difference + ": expected a name that ends in .exr or .png");
    if (given.negative && given.difference.empty())
        throw InputError("--negative: expected -o, the file whose picture it changes");
    if (!given.signed_error.empty() && io::extension_of(given.signed_error) != "png")
        throw InputError("--signed-error " + given.signed_error + ": expected a name that ends in .png");
    compare::Picture a = io::read_picture(given.a), b = io::read_picture(given.b);
    if (encoded(given.a) != encoded(given.b))
        throw InputError(fmt::format("{} is encoded for a display and {} is linear: they cannot be compared",
                                     encoded(given.a) ? given.a : given.b, encoded(given.a) ? given.b : given.a));
    options.encoding = encoded(given.a) ? compare::Encoding::ldr_srgb : compare::Encoding::hdr;
    if (!given.layer.empty()) {
        a = select(a, given.layer, given.a);
        b = select(b, given.layer, given.b);
    }

    // Compare; what cannot be compared has no difference picture.
    const LayeredReport all = compare_layers(a, b, options, given.common.json);
    const compare::Report& report = all.report;
    const bool comparable = compare::mismatch(a, b).empty();
    if (!given.signed_error.empty() && comparable) write_signed_error(a, b, options, given.signed_error);
    if (!given.difference.empty() && comparable) write_difference(a, b, given.negative, given.difference);
    if (given.common.json) {
        std::fputs(json_text(layered_json(all)).c_str(), stdout);
        return report.agree ? success : disagreement;
    }
    const bool bounded = given.max_error || given.max_ulp || given.max_differing;
    std::string text = fmt::format("A  {}\nB  {}\n\n", given.a, given.b);
    if (comparable) text += compare_text(report) + (all.layers.empty() ? "" : "\n") + layers_text(all) + "\n";
    if (!given.difference.empty() && comparable) text += "wrote " + given.difference + "\n";
    if (!given.signed_error.empty() && comparable) text += "wrote " + given.signed_error + "\n";
    text += verdict_text(all, bounded);
    std::fputs((text + "\n").c_str(), stdout);
    return report.agree ? success : disagreement;
}

}  // namespace

void add_compare(CLI::App& program, Action& action) {
    auto given = std::make_shared<CompareOptions>();
    CLI::App* command = program.add_subcommand("compare", "say how two pictures differ, and whether within bounds");
    command->add_option("a", given->a, "the picture under test")->required()->type_name("A");
    command->add_option("b", given->b, "the reference")->required()->type_name("B");
    command->add_option("--max-error", given->max_error, "bound on the mean error, at least 0")->type_name("E");
    command->add_option("--max-ulp", given->max_ulp, "bound on the distance in floats between two values")
        ->type_name("N");
    command->add_option("--max-differing", given->max_differing, "bound on the share of differing pixels, 0 to 1")
        ->type_name("S");
    command->add_option("-o,--output", given->difference, "write |A - B| as .exr, or clamped to 0..1 as .png")
        ->type_name("DIFF");
    command->add_flag("--negative", given->negative, "of -o write 1 - |A - B|: white where the pictures are equal (ISR 5.2.5)");
    command->add_option("--signed-error", given->signed_error,
                        "write as .png where A is darker (blue) or brighter (red) than B; full colour: by 50 %")
        ->check(some_word())
        ->type_name("PNG");
    command->add_option("--layer", given->layer, "compare this layer of the files only")->type_name("L");
    add_common(*command, given->common);
    command->footer(
        "A NaN, an infinity, other sizes or other channels are a disagreement, exit code 1. Where files have several\n"
        "layers, the figures are those of color, or of the first one with R, G and B, and each layer has a row of its\n"
        "own. --max-ulp, --max-differing and a --max-error of 0 hold of each layer, another --max-error of color. In\n"
        "JSON: layer, whose figures they are, and layers; equal and nonfinite are of all. null is what is undefined,\n"
        "the PSNR of equal pictures, and SSIM and FLIP of layers without R, G and B.");
    command->callback([given, &action] { action = [=] { return run_compare(*given); }; });
}

}  // namespace plumb::cli
