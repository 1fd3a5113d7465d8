// plumb experiment isr: what each view's pictures are worth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/compare_pictures.h"
#include "core/content_hasher.h"
#include "core/error.h"
#include "core/host_math.h"
#include "core/signed_error.h"
#include "gi/compose/compose.h"
#include "gi/isr/isr.h"
#include "tools/experiments/isr.h"
#include "tools/shared/options.h"

namespace plumb::cli {

namespace {

constexpr double middle_grey = 0.18;

Json measure_json(const IsrMeasure& m) {
    auto optional = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
    return {m.k_ssao,   m.k_isr, m.mean_error, optional(m.pearson), m.linear_error, optional(m.linear_pearson),
            m.improved, m.worse};
}
IsrMeasure measure_of(const Json& json) {
    auto optional = [](const Json& v) { return v.is_null() ? std::nullopt : std::optional(v.get<double>()); };
    return {json.at(0), json.at(1),           json.at(2), optional(json.at(3)),
            json.at(4), optional(json.at(5)), json.at(6), json.at(7)};
}
Json measures_json(const std::vector<IsrMeasure>& all) {
    Json json = Json::array();
    for (const IsrMeasure& m : all) json.push_back(measure_json(m));
    return json;
}
std::vector<IsrMeasure> measures_of(const Json& json) {
    std::vector<IsrMeasure> all;
    for (const Json& m : json) all.push_back(measure_of(m));
    return all;
}

Json view_json(const IsrViewResult& v) {
    return {{"name", v.name},
            {"group", v.group},
            {"triangles", v.triangles},
            {"exposure", v.exposure},
            {"truth_ms", v.truth_ms},
            {"truth_noise", v.truth_noise},
            {"display_noise", v.display_noise},
            {"direct_ms", v.direct_ms},
            {"isr_ms", v.isr_ms},
            {"direct", measure_json(v.direct)},
            {"corrected", measures_json(v.corrected)},
            {"without_ambient", measures_json(v.without_ambient)},
            {"published", measures_json(v.published)},
            {"own_direct", measure_json(v.own_direct)},
            {"own_isr", measure_json(v.own_isr)},
            {"own_noise", v.own_noise}};
}
IsrViewResult view_of(const Json& j) {
    return {j.at("name"),
            j.at("group"),
            j.at("triangles"),
            j.at("exposure"),
            j.at("truth_ms"),
            j.at("truth_noise"),
            j.at("display_noise"),
            j.at("direct_ms"),
            j.at("isr_ms"),
            measure_of(j.at("direct")),
            measures_of(j.at("corrected")),
            measures_of(j.at("without_ambient")),
            measures_of(j.at("published")),
            measure_of(j.at("own_direct")),
            measure_of(j.at("own_isr")),
            j.at("own_noise")};
}

// Mean standard error over the mean.
double relative_noise(const reference::Estimate& truth) {
    double errors = 0, means = 0;
    for (std::size_t i = 0; i < truth.mean.size(); ++i)
        for (int c = 0; c < 3; ++c) errors += truth.error.texels[i][c], means += truth.mean.texels[i][c];
    return means > 0 ? errors / means : 0;
}

// Mean standard error over the mean, and what it makes of the display: the mean of |display(L + e) - display(L - e)| /
// 2 times sqrt(2 / pi), which a normal error of that deviation has for its mean absolute value.
void add_noise(const reference::Estimate& truth, double exposure, const RunOptions& options, IsrViewResult& result) {
    Image4 up = truth.mean, down = truth.mean;
    for (std::size_t i = 0; i < up.size(); ++i) {
        up.texels[i] += truth.error.texels[i];
        down.texels[i] -= truth.error.texels[i];
    }
    const Image4 a = isr_display(up, exposure, options), b = isr_display(down, exposure, options);
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 3; ++c) sum += std::fabs(double(a.texels[i][c]) - b.texels[i][c]) / 2;
    result.truth_noise = relative_noise(truth);
    result.display_noise = sum / (3 * double(a.size())) * std::sqrt(2 / host::pi);
}

}  // namespace

const std::vector<IsrK>& isr_grid() {
    static const std::vector<IsrK> grid = [] {
        std::vector<IsrK> all;
        for (const double ssao : {0.0, 0.25, 0.5})
            for (int i = 0; i <= 10; ++i) all.push_back({ssao, i / 10.0});
        return all;
    }();
    return grid;
}

std::size_t isr_grid_index(double k_ssao, double k_isr) {
    const std::vector<IsrK>& grid = isr_grid();
    for (std::size_t i = 0; i < grid.size(); ++i)
        if (std::fabs(grid[i].ssao - k_ssao) < 1e-9 && std::fabs(grid[i].isr - k_isr) < 1e-9) return i;
    throw std::logic_error("experiment isr: no such coefficients in the grid");
}

double isr_gain(const IsrViewResult& view, const IsrMeasure& m) {
    return compare::gain(view.direct.mean_error, m.mean_error).value_or(0);
}

std::vector<BatchView> isr_views_of(const BatchScenes& scenes, int of_each_list) {
    std::vector<BatchView> chosen;
    std::vector<std::size_t> sizes;
    for (const BatchView& v : scenes.views()) {
        if (v.list >= sizes.size()) sizes.push_back(0);
        ++sizes[v.list];
    }
    for (const BatchView& v : scenes.views()) {
        const std::size_t n = sizes[v.list], wanted = std::min(n, std::size_t(of_each_list));
        // The first of each of `wanted` parts of the list.
        const bool takes = of_each_list == 0 || (v.index * wanted + n - 1) / n != ((v.index + 1) * wanted + n - 1) / n;
        if (takes) chosen.push_back(v);
    }
    return chosen;
}

frame::Settings isr_settings(const Scene& scene, const std::string& method, const std::vector<std::string>& sets) {
    SceneOptions options;
    options.method = method, options.sets = sets;
    return settings_of(scene, options);
}

frame::Frame isr_frame(const Scene& scene, const frame::Settings& settings, const RunOptions& options) {
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}

double isr_exposure(const Image4& truth) {
    const compare::Plane luminance = compare::luminances(truth);
    double sum = 0, mean = 0;
    for (const double l : luminance.texels) mean += l;
    mean /= double(luminance.size());
    if (!(mean > 0)) return 1;
    // A pixel that no path lit is dark, not infinitely so.
    for (const double l : luminance.texels) sum += host::log(std::max(l, 1e-3 * mean));
    return -host::log(1 - middle_grey) / host::exp(sum / double(luminance.size()));
}

Image4 isr_display(const Image4& radiance, double exposure, const RunOptions& options) {
    compose::TonemapParams params;
    params.exposure = float(exposure);
    Image4 display;
    compose::run(params, compose::TonemapInputs{&radiance}, options, display);
    return display;
}

compare::Picture isr_rgb(const Image4& image) {
    compare::Picture picture{{"R", "G", "B"}, image.width, image.height, {}};
    picture.data.reserve(3 * image.size());
    for (const glm::vec4& v : image.texels) picture.data.insert(picture.data.end(), {v.x, v.y, v.z});
    return picture;
}

Image4 isr_composed(const Scene& scene, const frame::Settings& settings, const frame::Frame& frame, const IsrK& k,
                    const RunOptions& options) {
    isr::IsrParams params = settings.isr;
    params.k_ssao = float(k.ssao), params.k_isr = float(k.isr);
    params.ambient = k.ambient ? isr::Ambient::environment : isr::Ambient::none;
    isr::ComposeInputs inputs;
    inputs.normal = &frame.gbuffer.normal, inputs.albedo = &frame.gbuffer.albedo;
    inputs.emission = &frame.gbuffer.emission, inputs.direct = &frame.direct, inputs.indirect = &frame.indirect;
    inputs.environment = scene.environment.radiance;
    Image4 radiance;
    isr::run(params, inputs, options, radiance);
    return radiance;
}

IsrModel isr_model(const Image4& radiance, double exposure, const RunOptions& options) {
    IsrModel model{radiance, isr_display(radiance, exposure, options), exposure, 0};
    for (const glm::vec4& v : radiance.texels) model.mean += (double(v.x) + v.y + v.z) / 3;
    model.mean /= double(radiance.size());
    return model;
}

IsrMeasure isr_compare(const IsrModel& model, const Image4& direct_display, const Image4& radiance, const IsrK& k,
                       const RunOptions& options) {
    compare::Options how;
    how.perceptual = false, how.threads = options.threads, how.encoding = compare::Encoding::ldr_srgb;
    const compare::Picture truth = isr_rgb(model.display), direct = isr_rgb(direct_display),
                           display = isr_rgb(isr_display(radiance, model.exposure, options));
    const compare::Report shown = compare::compare(display, truth, how);
    how.encoding = compare::Encoding::hdr;
    const compare::Report linear = compare::compare(isr_rgb(radiance), isr_rgb(model.radiance), how);
    if (!shown.mean_error || !linear.mean_error)
        throw InputError("a picture with values that are no numbers: expected finite ones");
    IsrMeasure m{
        k.ssao,        k.isr, *shown.mean_error, shown.pearson, *linear.mean_error / std::max(model.mean, 1e-300),
        linear.pearson};
    m.improved = compare::share_improved(truth, direct, display).value_or(0);
    m.worse = compare::share_improved(truth, display, direct).value_or(0);
    return m;
}

IsrTimedFrame::IsrTimedFrame(const Scene& scene, frame::Settings settings)
    : scene_(scene),
      settings_(std::move(settings)),
      plan_(frame::plan(scene_, settings_)),
      kept_([this](const graph::Node&, graph::Key) { return ++run_; }) {}

const frame::Frame& IsrTimedFrame::run(const RunOptions& options) {
    const frame::Frame& f = frame::execute(scene_, settings_, plan_, options, kept_);
    double all = 0, isr = 0;
    for (std::size_t i = 0; i < plan_.stages.size(); ++i) {
        if (!f.stages[i].needed) continue;
        all += f.stages[i].ms;
        // A source beside the frame is drawn for isr alone.
        if (plan_.stages[i].name.starts_with("isr.") || plan_.stages[i].view > 0) isr += f.stages[i].ms;
    }
    frame_ms.push_back(all), isr_ms.push_back(isr);
    return f;
}

IsrViewResult isr_measure_view(const IsrCommon& common, const BatchView& view) {
    ContentHasher key;
    key.add(program_hash(), common.scenes.content(view, common.request.size), std::int32_t(common.request.samples),
            std::int32_t(common.request.repeats));
    if (const std::optional<Json> found = common.results.find("view_" + view.name, key.hash)) return view_of(*found);

    const RunOptions& options = common.options;
    const reference::KeptEstimate truth = common.truths.of(common.scenes, view, common.request.size, options);
    const Scene& scene = common.scenes.scene(view, common.request.size);
    IsrViewResult result;
    result.name = view.name, result.group = view.group, result.triangles = common.scenes.triangles();
    result.exposure = isr_exposure(truth.estimate.mean), result.truth_ms = truth.ms;
    add_noise(truth.estimate, result.exposure, options, result);
    const IsrModel model = isr_model(truth.estimate.mean, result.exposure, options);

    // Once to warm up, then in turns, every other time backwards; a last run of direct light gives its picture.
    const frame::Settings settings = isr_settings(scene, "isr", {});
    IsrTimedFrame direct(scene, isr_settings(scene, "direct", {})), isr(scene, settings);
    for (int r = -1; r < common.request.repeats; ++r) {
        for (const bool first : {true, false}) (first == (r % 2 == 0) ? direct : isr).run(options);
        if (r < 0) direct.frame_ms.clear(), isr.frame_ms.clear();
    }
    result.direct_ms = median(direct.frame_ms), result.isr_ms = median(isr.frame_ms);
    const Image4 direct_radiance = direct.run(options).radiance;
    const Image4 direct_display = isr_display(direct_radiance, result.exposure, options);
    result.direct = isr_compare(model, direct_display, direct_radiance, {0, 0}, options);

    // As it is by default, against what it means to compute: one bounce of lamps, and what surfaces emit.
    const frame::Frame whole = isr_frame(scene, settings, options);
    const reference::Estimate own = isr_own_picture(scene, whole, settings.isr.bounces, common.request.samples, options);
    const IsrModel own_model = isr_model(own.mean, result.exposure, options);
    result.own_noise = relative_noise(own);
    result.own_direct = isr_compare(own_model, direct_display, direct_radiance, {0, 0}, options);
    result.own_isr = isr_compare(own_model, direct_display, whole.radiance, {0, 1, false}, options);

    for (const char* variant : {"corrected", "published"}) {
        // With both coefficients above 0 no stage is left out.
        const frame::Settings varied =
            isr_settings(scene, "isr", {std::string("isr.variant=") + variant, "isr.k_ssao=0.5", "isr.k_isr=0.5"});
        const frame::Frame f = isr_frame(scene, varied, options);
        auto measure = [&](std::vector<IsrMeasure>& all, bool ambient) {
            for (IsrK k : isr_grid()) {
                k.ambient = ambient;
                all.push_back(
                    isr_compare(model, direct_display, isr_composed(scene, varied, f, k, options), k, options));
            }
        };
        if (variant[0] == 'p')
            measure(result.published, true);
        else
            measure(result.corrected, true), measure(result.without_ambient, false);
    }
    common.results.keep("view_" + view.name, key.hash, view_json(result));
    return result;
}

IsrK isr_best(const std::vector<IsrViewResult>& views) {
    IsrK best;
    double least = std::numeric_limits<double>::infinity();
    for (const bool ambient : {true, false})
        for (std::size_t i = 0; i < isr_grid().size(); ++i) {
            double sum = 0;
            for (const IsrViewResult& v : views) sum += (ambient ? v.corrected : v.without_ambient).at(i).mean_error;
            if (sum < least) least = sum, best = isr_grid()[i], best.ambient = ambient;
        }
    return best;
}

const IsrMeasure& isr_measure_of(const IsrViewResult& view, const IsrK& k) {
    return (k.ambient ? view.corrected : view.without_ambient).at(isr_grid_index(k.ssao, k.isr));
}

std::vector<std::string> isr_sets(const IsrK& k) {
    return {fmt::format("isr.k_ssao={:g}", k.ssao), fmt::format("isr.k_isr={:g}", k.isr),
            std::string("isr.ambient=") + (k.ambient ? "environment" : "none")};
}

}  // namespace plumb::cli
