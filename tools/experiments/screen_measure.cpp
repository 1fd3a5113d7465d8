// plumb experiment screen: runs the curves. Times are those of a curve's own stages, not of the frame.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "gi/frame/kept.h"
#include "gi/frame/mirrors.h"
#include "gi/frame/truth.h"
#include "tools/experiments/screen.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"
#include "tools/shared/truth.h"

namespace plumb::cli {

namespace {

std::vector<ScreenCurve::Point> along(const std::string& key, std::initializer_list<int> values) {
    std::vector<ScreenCurve::Point> points;
    for (const int v : values) points.push_back({double(v), {fmt::format("{}={}", key, v)}});
    return points;
}

// Steps of a ray of one length; `thickness` in metres, or 0: of so many steps as the table has.
std::vector<ScreenCurve::Point> steps_of(double length, std::initializer_list<int> counts, double thickness = 0) {
    std::vector<ScreenCurve::Point> points;
    for (const int n : counts) {
        points.push_back({double(n), {fmt::format("reflect.steps={}", n), fmt::format("reflect.step={}", float(length / n))}});
        if (thickness > 0) points.back().sets.push_back(fmt::format("reflect.thickness={}", float(thickness * n / length)));
    }
    return points;
}

// ---- Frames ----------------------------------------------------------------------------------------------------------------

// A scene drawn with other settings again and again.
class Subject {
  public:
    Subject(const std::string& file, const ScreenRequest& request, const RunOptions& options) : request_(request), options_(options) {
        words_.file = file, words_.size = request.size, words_.sets = request.sets;
        scene_ = load(words_);
    }
    const Scene& scene() const { return scene_; }

    frame::Settings settings(const std::string& method, const std::vector<std::string>& curve, const std::vector<std::string>& point) const {
        SceneOptions words = words_;
        words.method = method;
        for (const auto* sets : {&curve, &point}) words.sets.insert(words.sets.end(), sets->begin(), sets->end());
        return settings_of(scene_, words);
    }
    struct Drawn {
        frame::Frame frame;
        double ms = 0;  // of the stages of that name, median
    };
    // Draws, and then runs the stages whose name starts so again.
    Drawn draw(const frame::Settings& settings, const std::string& stages) const {
        std::uint64_t run = 0;
        frame::KeptStages kept([&](const graph::Node& node, graph::Key key) { return node.plan.name.starts_with(stages) ? graph::Key(++run) : key; });
        const frame::Plan plan = frame::plan(scene_, settings);
        std::vector<double> times;
        Drawn drawn;
        for (int i = 0; i <= request_.repeats; ++i) {
            const frame::Frame& f = frame::execute(scene_, settings, plan, options_, kept);
            if (i > 0) times.push_back(ms_of(plan, f, stages));
            if (i == request_.repeats) drawn.frame = f;
        }
        drawn.ms = quantile(std::move(times), 0.5);
        return drawn;
    }
    // So many frames at rest, each with samples of its own; the time is that of a gather and of what joins it with the last.
    Drawn draw_frames(const frame::Settings& settings) const {
        std::uint64_t run = 0;
        frame::KeptStages kept([&](const graph::Node& node, graph::Key key) { return is_gathering(node.plan.name) ? graph::Key(++run) : key; });
        const frame::Plan plan = frame::plan(scene_, settings);
        std::vector<double> times;
        Drawn drawn;
        for (int i = 0; i < request_.frames; ++i) {
            const frame::Frame& f = frame::execute(scene_, settings, plan, options_, kept);
            if (i > 0) times.push_back(ms_of(plan, f, "rsm.") + ms_of(plan, f, "screen.reuse"));
            if (i + 1 == request_.frames) drawn.frame = f;
        }
        drawn.ms = quantile(std::move(times), 0.5);
        return drawn;
    }
    frame::Traced trace(const frame::Settings& settings, const std::string& layer, const frame::Frame& f) const {
        frame::Settings with = settings;
        with.reference.samples = request_.paths;
        const Geometry geometry = flatten(scene_);
        return frame::Tracer(scene_, with, geometry, nullptr).trace(layer, f.gbuffer, options_);
    }
    const ScreenRequest& request() const { return request_; }
    const RunOptions& options() const { return options_; }

  private:
    static bool is_gathering(const std::string& stage) { return stage.starts_with("rsm.") || stage == "screen.reuse"; }
    static double ms_of(const frame::Plan& plan, const frame::Frame& f, const std::string& stages) {
        double ms = 0;
        for (std::size_t i = 0; i < plan.stages.size(); ++i)
            if (plan.stages[i].name.starts_with(stages) && f.stages[i].needed && !f.stages[i].kept) ms += f.stages[i].ms;
        return ms;
    }

    ScreenRequest request_;
    RunOptions options_;
    SceneOptions words_;
    Scene scene_;
};

// ---- Errors ----------------------------------------------------------------------------------------------------------------

// Over pixels with a weight above 0 and three channels; `of`: the mean of the truth.
struct ScreenErrors {
    double mean = 0, bias = 0, rms = 0, noise = 0, of = 0;
    std::size_t pixels = 0;
};

template <class Counts>
ScreenErrors errors_over(const Image4& own, const Image4& truth, const Image4* error, Counts counts) {
    ScreenErrors e;
    for (std::size_t i = 0; i < own.size(); ++i) {
        if (!counts(i)) continue;
        ++e.pixels;
        for (int c = 0; c < 3; ++c) {
            const double t = truth.texels[i][c], d = own.texels[i][c] - t, s = error ? error->texels[i][c] : 0;
            e.mean += std::abs(d), e.bias += d, e.rms += d * d, e.noise += s * s, e.of += t;
        }
    }
    const double n = std::max<double>(1, 3.0 * double(e.pixels));
    e.mean /= n, e.bias /= n, e.rms = std::sqrt(e.rms / n), e.noise = std::sqrt(e.noise / n), e.of /= n;
    return e;
}

IprSheet begin_sheet(const std::string& id, const std::string& title, const std::string& notes) { return {id, title, notes, {}, {}, {}, {}}; }

void add_point(page::Chart& chart, const std::string& curve, double ms, double error, const std::string& setting) {
    if (chart.lines.empty() || chart.lines.back().name != curve) chart.lines.push_back({curve, {}});
    chart.lines.back().points.push_back({ms, error, {{"setting", setting}}});
}

std::string text_of(const std::vector<std::string>& sets) {
    std::string text;
    for (const std::string& s : sets) text += (text.empty() ? "" : " ") + s;
    return text;
}

// Draws each point of each curve and lets `row` judge it.
template <class Row>
void each_point(const Subject& subject, const std::vector<ScreenCurve>& curves, const std::string& method, const ScreenTell& tell, Row row) {
    for (const ScreenCurve& curve : curves)
        for (const ScreenCurve::Point& point : curve.points) {
            tell(fmt::format("{}: {}", curve.name, text_of(point.sets)));
            row(curve, point, subject.settings(method, curve.sets, point.sets));
        }
}

// The first row's G-buffer is that of all.
IprSheet occlusion(const Subject& subject, const ScreenTell& tell) {
    IprSheet sheet = begin_sheet("ambient occlusion", "ambient occlusion against rays of the same radius", fmt::format("{} rays a pixel; the open share, 0 to 1, over covered pixels", subject.request().paths));
    sheet.heads = {{"at"}, {"ms", 2}, {"mean error", 4}, {"bias", 4}, {"rms", 4}, {"truth's noise", 4}};
    page::Chart chart{"ambient occlusion", "ms", "mean error of the open share", true, true, {}};
    std::optional<frame::Traced> truth;
    each_point(subject, occlusion_curves(), "direct", tell, [&](const ScreenCurve& curve, const ScreenCurve::Point& point, const frame::Settings& settings) {
        const Subject::Drawn drawn = subject.draw(settings, "screen.");
        if (!truth) truth = subject.trace(settings, "truth.ao", drawn.frame);
        const ScreenErrors e = errors_over(drawn.frame.ao.open, truth->estimate.mean, &truth->estimate.error, [&](std::size_t i) { return drawn.frame.gbuffer.normal.texels[i].w != 0; });
        sheet.rows.push_back({curve.name, text_of(point.sets), {point.at, drawn.ms, e.mean, e.bias, e.rms, e.noise}, {}});
        add_point(chart, curve.name, drawn.ms, e.mean, text_of(point.sets));
    });
    sheet.charts.push_back(std::move(chart));
    return sheet;
}

IprSheet reflections(const Subject& subject, const ScreenTell& tell) {
    IprSheet sheet = begin_sheet("reflections", "mirrored rays against rays that meet the scene", fmt::format("shares in % of the mirrors' pixels; error of the picture in % of the truth's mean, {} paths a pixel", subject.request().paths));
    sheet.heads = {{"at"}, {"ms", 2}, {"right", 2}, {"wrong", 2}, {"missed", 2}, {"right in map", 2}, {"wrong in map", 2}, {"missed in map", 2}, {"unseen", 2}, {"open", 2}, {"mean error", 2}, {"bias", 2}, {"truth's noise", 2}};
    page::Chart chart{"reflections", "ms", "not right of what can be met, %", true, true, {}};
    std::optional<frame::Traced> truth;
    const screen::ReflectParams own = subject.settings("", {}, {}).reflect;
    each_point(subject, reflection_curves(double(own.step) * own.steps), "rsm", tell, [&](const ScreenCurve& curve, const ScreenCurve::Point& point, const frame::Settings& settings) {
        const Subject::Drawn drawn = subject.draw(settings, "screen.");
        const frame::Frame& f = drawn.frame;
        if (!truth) truth = subject.trace(settings, "truth.reflection", f);
        const frame::MirrorClasses classes = frame::classify_mirrors(subject.scene(), settings, f, subject.options());
        const auto share = [&](frame::MirrorClass of) { return 100.0 * double(classes.count[std::size_t(of)]) / double(std::max<std::int64_t>(1, classes.mirrors())); };
        using C = frame::MirrorClass;
        const ScreenErrors e = errors_over(f.reflect.reflection, truth->estimate.mean, &truth->estimate.error, [&](std::size_t i) { return f.reflect.mirror.texels[i].w != 0; });
        const double of = 100 / std::max(e.of, 1e-30);
        IprSheetRow row{curve.name, text_of(point.sets), {point.at, drawn.ms}, {}};
        for (const C c : {C::right, C::wrong, C::missed, C::right_in_map, C::wrong_in_map, C::missed_in_map, C::unseen, C::open}) row.values.push_back(share(c));
        for (const double v : {e.mean * of, e.bias * of, e.noise * of}) row.values.push_back(v);
        sheet.rows.push_back(std::move(row));
        const double met = share(C::right) + share(C::right_in_map), open = share(C::open);
        add_point(chart, curve.name, drawn.ms, 100 - 100 * met / std::max(1e-9, 100 - open), text_of(point.sets));
    });
    sheet.charts.push_back(std::move(chart));
    return sheet;
}

constexpr int true_samples = 16384;  // of a disc

IprSheet reuse(const Subject& subject, const ScreenTell& tell) {
    const int frames = subject.request().frames;
    IprSheet sheet = begin_sheet("gathered light of frames before", "gathered light against many samples of the same disc", fmt::format("after {} frames at rest, against {} samples in one; irradiance in % of their mean; ms: of one frame's gathers and their mean", frames, true_samples));
    sheet.heads = {{"at"}, {"ms", 2}, {"mean error", 3}, {"bias", 3}, {"rms", 3}};
    page::Chart chart{"gathered light of frames before", "ms", "rms, % of the mean", true, true, {}};
    tell("the truth");
    const frame::Settings whole = subject.settings("rsm", {"rsm.gather=disc", fmt::format("rsm.samples={}", true_samples), "indirect.resolution=full", "indirect.blur=none"}, {});
    const Image4 truth = frame::execute(subject.scene(), whole, frame::plan(subject.scene(), whole), subject.options()).indirect;
    each_point(subject, reuse_curves(), "rsm", tell, [&](const ScreenCurve& curve, const ScreenCurve::Point& point, const frame::Settings& settings) {
        const Subject::Drawn drawn = subject.draw_frames(settings);
        const ScreenErrors e = errors_over(drawn.frame.indirect, truth, nullptr, [&](std::size_t i) { return drawn.frame.gbuffer.normal.texels[i].w != 0; });
        const double of = 100 / std::max(e.of, 1e-30);
        sheet.rows.push_back({curve.name, text_of(point.sets), {point.at, drawn.ms, e.mean * of, e.bias * of, e.rms * of}, {}});
        add_point(chart, curve.name, drawn.ms, e.rms * of, text_of(point.sets));
    });
    sheet.charts.push_back(std::move(chart));
    return sheet;
}

}  // namespace

std::vector<ScreenCurve> occlusion_curves() {
    const auto ssao = along("ao.samples", {4, 8, 16, 32, 64, 128}), few = along("ao.samples", {16, 64}), steps = along("ao.steps", {2, 4, 8, 16});
    return {{"ssao, camera", {"ao.method=ssao"}, ssao},
            {"ssao, camera and lights", {"ao.method=ssao", "ao.views=lights"}, ssao},
            {"ssao, camera, no blur", {"ao.method=ssao", "ao.blur=none"}, few},
            {"ssao, camera, blur that stops at edges", {"ao.method=ssao", "ao.blur=edge_aware"}, few},
            {"ssao as printed, camera", {"ao.method=ssao", "ao.variant=published"}, few},
            {"horizons, 2 slices", {"ao.method=horizon", "ao.slices=2"}, steps},
            {"horizons, 4 slices", {"ao.method=horizon", "ao.slices=4"}, steps}};
}

std::vector<ScreenCurve> reflection_curves(double length) {
    const auto cells = along("reflect.cells", {64, 128, 256, 512});
    const std::string steps = "reflect.march=steps", blocks = "reflect.march=hierarchical", camera = "reflect.views=camera", lights = "reflect.views=lights";
    // A block of texels has no step: its thickness is that of 64.
    const std::string step = fmt::format("reflect.step={}", float(length / 64)), count = "reflect.steps=64";
    return {{"steps, camera", {steps, camera}, steps_of(length, {16, 32, 64, 128, 256})},
            {"steps, camera, thickness of 2 % of the length", {steps, camera}, steps_of(length, {16, 32, 64, 128, 256}, 0.02 * length)},
            {"steps, camera and lights", {steps, lights}, steps_of(length, {16, 32, 64, 128, 256})},
            {"64 steps, halvings", {steps, camera, step, count}, along("reflect.bisections", {0, 2, 4, 8, 16})},
            {"texel to texel, camera", {blocks, camera, step, count}, cells},
            {"texel to texel, camera, thin: 0.2 steps, bias 1 mm", {blocks, camera, step, count, "reflect.thickness=0.2", "reflect.bias=0.001"}, cells},
            {"texel to texel, camera and lights", {blocks, lights, step, count}, cells}};
}

std::vector<ScreenCurve> reuse_curves() {
    std::vector<ScreenCurve> curves = {{"one frame", {"reuse.frames=0"}, along("rsm.samples", {25, 50, 100, 200, 400})},
                                       {"25 samples a frame", {"rsm.samples=25"}, along("reuse.frames", {1, 4, 16, 64})},
                                       {"100 samples a frame", {"rsm.samples=100"}, along("reuse.frames", {1, 4, 16, 64})},
                                       {"25 samples a frame, held in a box", {"rsm.samples=25", "reuse.clamp=box"}, along("reuse.frames", {4, 16, 64})}};
    // The light that is gathered, and no filter of it.
    for (ScreenCurve& curve : curves) curve.sets.insert(curve.sets.end(), {"rsm.gather=disc", "indirect.resolution=full", "indirect.blur=none"});
    return curves;
}

std::vector<IprSheet> measure_screen(const std::string& scene, const ScreenRequest& request, const RunOptions& options, const ScreenTell& tell) {
    const Subject subject(scene, request, options);
    std::vector<IprSheet> sheets = {occlusion(subject, tell)};
    if (frame::any_mirror(subject.scene())) sheets.push_back(reflections(subject, tell));
    const auto& lights = subject.scene().lights;
    if (std::any_of(lights.begin(), lights.end(), [](const Light& l) { return l.on; })) sheets.push_back(reuse(subject, tell));
    return sheets;
}

}  // namespace plumb::cli
