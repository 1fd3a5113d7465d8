// plumb experiment screen: runs the curves. Times are those of a curve's own stages, and of what they alone need, not of the frame.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>

#include "core/camera.h"
#include "gi/frame/kept.h"
#include "gi/frame/mirrors.h"
#include "gi/frame/truth.h"
#include "tools/experiments/screen.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"
#include "tools/shared/truth.h"

namespace plumb::cli {

namespace {

std::vector<ScreenCurve::Point> along(const std::string& key, std::initializer_list<double> values) {
    std::vector<ScreenCurve::Point> points;
    for (const double v : values) points.push_back({v, {fmt::format("{}={}", key, v)}});
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
        words_.file = file, words_.size = request.size, words_.preset = request.preset, words_.sets = request.sets;
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
        double ms = 0, low = 0, high = 0;  // of the stages of that name: median and quartiles

        void take(const std::vector<double>& times) { ms = quantile(times, 0.5), low = quantile(times, 0.25), high = quantile(times, 0.75); }
    };
    // Draws, and then runs the stages of gi/screen again, with what a frame without them has not: of reflections the layers, the lights'
    // maps drawn once more and the light on what was met.
    Drawn draw(const frame::Settings& settings) const {
        const auto is_own = [](const graph::NodePlan& plan) {
            return plan.name.starts_with("screen.") || plan.form == "map" || plan.label.find("mirrored") != std::string::npos;
        };
        std::uint64_t run = 0;
        frame::KeptStages kept([&](const graph::Node& node, graph::Key key) { return is_own(node.plan) ? graph::Key(++run) : key; });
        const frame::Plan plan = frame::plan(scene_, settings);
        std::vector<double> times;
        Drawn drawn;
        for (int i = 0; i <= request_.repeats; ++i) {
            const frame::Frame& f = frame::execute(scene_, settings, plan, options_, kept);
            if (i > 0) times.push_back(ms_of(plan, f, is_own));
            if (i == request_.repeats) drawn.frame = f;
        }
        drawn.take(times);
        return drawn;
    }
    // So many frames up to the scene's own, the camera `moves` to the right a frame (shares of the distance of what it looks at), each
    // with samples of its own; the time is that of a gather and of what joins it with the last.
    Drawn draw_frames(const frame::Settings& settings, double moves) const {
        std::uint64_t run = 0;
        frame::KeptStages kept([&](const graph::Node& node, graph::Key key) { return is_gathering(node.plan) ? graph::Key(++run) : key; });
        std::vector<double> times;
        Drawn drawn;
        for (int i = 0; i < request_.frames; ++i) {
            const Scene scene = moved(moves * (i + 1 - request_.frames));
            const frame::Plan plan = frame::plan(scene, settings);
            const frame::Frame& f = frame::execute(scene, settings, plan, options_, kept);
            if (i > 0) times.push_back(ms_of(plan, f, is_gathering));
            if (i + 1 == request_.frames) drawn.frame = f;
        }
        drawn.take(times);
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

    // The same with lobes in place of mirrors: of their reflectance, and this exponent.
    void turn_mirrors_rough(float exponent) {
        for (Material& m : scene_.materials) {
            if (m.mirror == glm::vec3(0)) continue;
            m.specular = m.mirror, m.exponent = exponent, m.mirror = glm::vec3(0);
        }
    }

  private:
    Scene moved(double by) const {
        Scene scene = scene_;
        const glm::dvec3 offset = axes(scene.camera).right * (by * glm::length(scene.camera.look_at - scene.camera.position));
        scene.camera.position += offset, scene.camera.look_at += offset;
        return scene;
    }
    static bool is_gathering(const graph::NodePlan& plan) { return plan.name.starts_with("rsm.") || plan.name == "screen.reuse"; }
    template <class Counts>
    static double ms_of(const frame::Plan& plan, const frame::Frame& f, Counts counts) {
        double ms = 0;
        for (std::size_t i = 0; i < plan.stages.size(); ++i)
            if (counts(plan.stages[i]) && f.stages[i].needed && !f.stages[i].kept) ms += f.stages[i].ms;
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

void add_point(page::Chart& chart, const std::string& curve, double ms, double error, const std::string& setting) {
    if (chart.lines.empty() || chart.lines.back().name != curve) chart.lines.push_back({curve, {}});
    chart.lines.back().points.push_back({ms, error, {{"setting", setting}}});
}

std::string text_of(const std::vector<std::string>& sets) {
    std::string text;
    for (const std::string& s : sets) text += (text.empty() ? "" : " ") + s;
    return text;
}

// What a point has: its time, then the figures of its table, and the one that the chart shows.
struct Judged {
    Subject::Drawn drawn;
    std::vector<double> values;
    double error;
};

const std::vector<IprHead> time_heads = {{"at", 4}, {"ms", 2}, {"ms, first quartile", 2}, {"ms, third quartile", 2}};

// Draws each point of each curve as `judge` says; tells what it found.
template <class Judge>
void each_point(const Subject& subject, const std::vector<ScreenCurve>& curves, const std::string& method, const ScreenTell& tell, IprSheet& sheet, Judge judge) {
    page::Chart& chart = sheet.charts.front();
    for (const ScreenCurve& curve : curves)
        for (const ScreenCurve::Point& point : curve.points) {
            const std::string setting = text_of(point.sets);
            const Judged j = judge(curve, subject.settings(method, curve.sets, point.sets));
            IprSheetRow row{curve.name, setting, {point.at, j.drawn.ms, j.drawn.low, j.drawn.high}, {}};
            row.values.insert(row.values.end(), j.values.begin(), j.values.end());
            tell(fmt::format("{}, {}: {:.2f} ms, {:.4g} {}", curve.name, setting, j.drawn.ms, j.error, chart.y_name));
            sheet.rows.push_back(std::move(row));
            add_point(chart, curve.name, j.drawn.ms, j.error, setting);
        }
}

IprSheet begin_sheet(const std::string& id, const std::string& title, const std::string& notes, const std::vector<IprHead>& heads, const std::string& error) {
    IprSheet sheet{id, title, notes, time_heads, {}, {}, {}};
    sheet.heads.insert(sheet.heads.end(), heads.begin(), heads.end());
    sheet.charts.push_back({id, "ms", error, true, true, {}});
    return sheet;
}

// The first row's G-buffer is that of all. Each radius has its own truth.
IprSheet occlusion(const Subject& subject, const ScreenTell& tell) {
    IprSheet sheet = begin_sheet("ambient occlusion", "ambient occlusion against rays of the same radius", fmt::format("{} rays a pixel; the open share, 0 to 1, over covered pixels", subject.request().paths),
                                 {{"mean error", 4}, {"bias", 4}, {"rms", 4}, {"truth's noise", 4}}, "mean error of the open share");
    std::map<float, frame::Traced> truths;
    each_point(subject, occlusion_curves(), "direct", tell, sheet, [&](const ScreenCurve&, const frame::Settings& settings) {
        Subject::Drawn drawn = subject.draw(settings);
        auto truth = truths.find(settings.ao.radius);
        if (truth == truths.end()) truth = truths.emplace(settings.ao.radius, subject.trace(settings, "truth.ao", drawn.frame)).first;
        const frame::Traced& of = truth->second;
        const ScreenErrors e = errors_over(drawn.frame.ao.open, of.estimate.mean, &of.estimate.error, [&](std::size_t i) { return drawn.frame.gbuffer.normal.texels[i].w != 0; });
        return Judged{std::move(drawn), {e.mean, e.bias, e.rms, e.noise}, e.mean};
    });
    return sheet;
}

IprSheet reflections(const Subject& subject, const ScreenTell& tell) {
    using C = frame::MirrorClass;
    const std::vector<C> shown = {C::right, C::wrong, C::missed, C::right_in_layer, C::wrong_in_layer, C::missed_in_layer, C::right_in_map, C::wrong_in_map, C::missed_in_map, C::unseen, C::open};
    std::vector<IprHead> heads;
    for (const C c : shown) {
        std::string name = frame::name_of(c);
        std::replace(name.begin(), name.end(), '_', ' ');
        heads.push_back({name, 2});
    }
    heads.insert(heads.end(), {{"mean error", 2}, {"bias", 2}, {"truth's noise", 2}});
    IprSheet sheet = begin_sheet("reflections", "mirrored rays against rays that meet the scene", fmt::format("shares in % of the mirrors' pixels; error of the picture in % of the truth's mean, {} paths a pixel", subject.request().paths),
                                 heads, "not right of what can be met, %");
    std::optional<frame::Traced> truth;
    const screen::ReflectParams own = subject.settings("", {}, {}).reflect;
    each_point(subject, reflection_curves(double(own.step) * own.steps), "rsm", tell, sheet, [&](const ScreenCurve&, const frame::Settings& settings) {
        Subject::Drawn drawn = subject.draw(settings);
        const frame::Frame& f = drawn.frame;
        if (!truth) truth = subject.trace(settings, "truth.reflection", f);
        const frame::MirrorClasses classes = frame::classify_mirrors(subject.scene(), settings, f, subject.options());
        const auto share = [&](C of) { return 100.0 * double(classes.count[std::size_t(of)]) / double(std::max<std::int64_t>(1, classes.mirrors())); };
        const ScreenErrors e = errors_over(f.reflect.reflection, truth->estimate.mean, &truth->estimate.error, [&](std::size_t i) { return f.reflect.mirror.texels[i].w != 0; });
        const double of = 100 / std::max(e.of, 1e-30);
        std::vector<double> values;
        for (const C c : shown) values.push_back(share(c));
        values.insert(values.end(), {e.mean * of, e.bias * of, e.noise * of});
        const double met = share(C::right) + share(C::right_in_layer) + share(C::right_in_map);
        return Judged{std::move(drawn), values, 100 - 100 * met / std::max(1e-9, 100 - share(C::open))};
    });
    return sheet;
}

constexpr float rough_exponent = 40;

IprSheet rough_reflections(Subject subject, const ScreenTell& tell) {
    subject.turn_mirrors_rough(rough_exponent);
    IprSheet sheet = begin_sheet("rough reflections", "Phong's lobes against paths", fmt::format("every mirror's reflectance as a lobe of exponent {}; in % of the truth's mean, {} paths a pixel", rough_exponent, subject.request().paths),
                                 {{"mean error", 2}, {"bias", 2}, {"rms", 2}, {"truth's noise", 2}}, "rms, % of the mean");
    std::optional<frame::Traced> truth;
    each_point(subject, lobe_curves(), "rsm", tell, sheet, [&](const ScreenCurve&, const frame::Settings& settings) {
        Subject::Drawn drawn = subject.draw(settings);
        const frame::Frame& f = drawn.frame;
        if (!truth) truth = subject.trace(settings, "truth.reflection", f);
        const ScreenErrors e = errors_over(f.reflect.reflection, truth->estimate.mean, &truth->estimate.error, [&](std::size_t i) { return glm::vec3(f.reflect.lobe.texels[i]) != glm::vec3(0); });
        const double of = 100 / std::max(e.of, 1e-30);
        return Judged{std::move(drawn), {e.mean * of, e.bias * of, e.rms * of, e.noise * of}, e.rms * of};
    });
    return sheet;
}

constexpr int true_samples = 16384;  // of a disc
constexpr double moves = 0.005;      // of the distance to what the camera looks at, a frame

IprSheet reuse(const Subject& subject, const ScreenTell& tell) {
    const int frames = subject.request().frames;
    IprSheet sheet = begin_sheet("gathered light of frames before", "gathered light against many samples of the same disc",
                                 fmt::format("after {} frames, against {} samples in one; irradiance in % of their mean; ms: of one frame's gathers and their mean; moving: the camera, sideways, by {:.3g} of the distance to what it looks at in each frame", frames, true_samples, moves),
                                 {{"mean error", 3}, {"bias", 3}, {"rms", 3}}, "rms, % of the mean");
    tell("the truth");
    const frame::Settings whole = subject.settings("rsm", {"rsm.gather=disc", fmt::format("rsm.samples={}", true_samples), "indirect.resolution=full", "indirect.blur=none"}, {});
    const Image4 truth = frame::execute(subject.scene(), whole, frame::plan(subject.scene(), whole), subject.options()).indirect;
    each_point(subject, reuse_curves(), "rsm", tell, sheet, [&](const ScreenCurve& curve, const frame::Settings& settings) {
        Subject::Drawn drawn = subject.draw_frames(settings, curve.moving ? moves : 0);
        const ScreenErrors e = errors_over(drawn.frame.indirect, truth, nullptr, [&](std::size_t i) { return drawn.frame.gbuffer.normal.texels[i].w != 0; });
        const double of = 100 / std::max(e.of, 1e-30);
        return Judged{std::move(drawn), {e.mean * of, e.bias * of, e.rms * of}, e.rms * of};
    });
    return sheet;
}

}  // namespace

std::vector<ScreenCurve> occlusion_curves() {
    const auto ssao = along("ao.samples", {4, 8, 16, 32, 64, 128}), few = along("ao.samples", {16, 64}), steps = along("ao.steps", {2, 4, 8, 16}), radius = along("ao.radius", {0.125, 0.25, 1, 2}), bias = along("ao.bias", {0.001, 0.003, 0.01, 0.03, 0.1});
    const std::string balls = "ao.method=ssao", horizons = "ao.method=horizon", lights = "ao.views=lights", sharp = "ao.blur=none", edges = "ao.blur=edge_aware";
    return {{"ssao, camera", {balls}, ssao},
            {"ssao, camera and lights", {balls, lights}, ssao},
            {"ssao, camera and lights: weight of distances", {balls, lights}, along("ao.weight_bias", {0, 0.25, 0.5, 1})},
            {"ssao, camera, no blur", {balls, sharp}, few},
            {"ssao, camera, blur that stops at edges", {balls, edges}, few},
            {"ssao as printed, camera", {balls, "ao.variant=published"}, few},
            {"ssao, camera: bias", {balls, sharp}, bias},
            {"ssao, camera: radius", {balls, sharp}, radius},
            {"horizons, 2 slices", {horizons, "ao.slices=2"}, steps},
            {"horizons, 4 slices", {horizons, "ao.slices=4"}, steps},
            {"horizons, 4 slices, no blur", {horizons, "ao.slices=4", sharp}, steps},
            {"horizons, 4 slices, blur that stops at edges", {horizons, "ao.slices=4", edges}, steps},
            {"horizons, 4 slices of 8: bias", {horizons, sharp}, bias},
            {"horizons, 4 slices of 8: radius", {horizons, sharp}, radius}};
}

std::vector<ScreenCurve> reflection_curves(double length) {
    const auto cells = along("reflect.cells", {64, 128, 256, 512}), layers = along("reflect.layers", {1, 2, 3}), thickness = along("reflect.thickness", {0.1, 0.3, 0.6, 1.2, 2.4}), bias = along("reflect.bias", {0.001, 0.003, 0.01, 0.03});
    const std::string steps = "reflect.march=steps", blocks = "reflect.march=hierarchical", camera = "reflect.views=camera", lights = "reflect.views=lights";
    // A block of texels has no step: its thickness is that of 64.
    const std::string step = fmt::format("reflect.step={}", float(length / 64)), count = "reflect.steps=64", thin = "reflect.thickness=0.2", low = "reflect.bias=0.001";
    return {{"steps, camera", {steps, camera}, steps_of(length, {16, 32, 64, 128, 256})},
            {"steps, camera, thickness of 2 % of the length", {steps, camera}, steps_of(length, {16, 32, 64, 128, 256}, 0.02 * length)},
            {"steps, camera and lights", {steps, lights}, steps_of(length, {16, 32, 64, 128, 256})},
            {"steps as printed, camera", {steps, camera, "reflect.variant=published"}, steps_of(length, {64, 256})},
            {"64 steps, halvings", {steps, camera, step, count}, along("reflect.bisections", {0, 2, 4, 8, 16})},
            {"64 steps, thickness", {steps, camera, step, count}, thickness},
            {"64 steps, bias", {steps, camera, step, count}, bias},
            {"64 steps, layers", {steps, camera, step, count}, layers},
            {"64 steps and lights, layers", {steps, lights, step, count}, layers},
            {"64 steps, fade, for the eye", {steps, camera, step, count}, along("reflect.fade", {0.05, 0.2})},
            {"64 steps, attenuation, for the eye", {steps, camera, step, count}, along("reflect.attenuation", {1, 4, 16})},
            {"texel to texel, camera", {blocks, camera, step, count}, cells},
            {"texel to texel, camera, thin: 0.2 steps, bias 1 mm", {blocks, camera, step, count, thin, low}, cells},
            {"texel to texel, camera: thickness", {blocks, camera, step, count, low}, thickness},
            {"texel to texel, camera: bias", {blocks, camera, step, count, thin}, bias},
            {"texel to texel, camera, thin, layers", {blocks, camera, step, count, thin, low}, layers},
            {"texel to texel, camera and lights", {blocks, lights, step, count}, cells},
            {"texel to texel, camera and lights, thin", {blocks, lights, step, count, thin, low}, cells}};
}

std::vector<ScreenCurve> lobe_curves() {
    const auto rays = along("reflect.rays", {1, 4, 16});
    const std::string lobe = "reflect.lobe=phong", steps = "reflect.march=steps", camera = "reflect.views=camera", lights = "reflect.views=lights";
    return {{"steps, camera", {lobe, steps, camera}, rays},
            {"steps, camera and lights", {lobe, steps, lights}, rays},
            {"texel to texel, camera", {lobe, "reflect.march=hierarchical", camera}, rays}};
}

std::vector<ScreenCurve> reuse_curves() {
    const auto frames = along("reuse.frames", {1, 4, 16, 64}), more = along("reuse.frames", {4, 16, 64});
    const std::string few = "rsm.samples=25", box = "reuse.clamp=box", sixteen = "reuse.frames=16";
    std::vector<ScreenCurve> curves = {{"one frame", {"reuse.frames=0"}, along("rsm.samples", {25, 50, 100, 200, 400})},
                                       {"25 samples a frame", {few}, frames},
                                       {"100 samples a frame", {"rsm.samples=100"}, frames},
                                       {"25 samples a frame, held in a box", {few, box}, more},
                                       {"25 samples a frame, moving", {few}, more, true},
                                       {"25 samples a frame, moving, held in a box", {few, box}, more, true},
                                       {"25 samples of 16 frames, moving: sigma of depths", {few, sixteen}, along("reuse.sigma_depth", {0.001, 0.005, 0.02, 0.1}), true},
                                       {"25 samples of 16 frames, moving: sigma of normals", {few, sixteen}, along("reuse.sigma_normal", {0.01, 0.1, 0.3, 1}), true}};
    // The light that is gathered, and no filter of it.
    for (ScreenCurve& curve : curves) curve.sets.insert(curve.sets.end(), {"rsm.gather=disc", "indirect.resolution=full", "indirect.blur=none"});
    return curves;
}

std::vector<IprSheet> measure_screen(const std::string& scene, const ScreenRequest& request, const RunOptions& options, const ScreenTell& tell) {
    const Subject subject(scene, request, options);
    std::vector<IprSheet> sheets = {occlusion(subject, tell)};
    if (frame::any_mirror(subject.scene())) sheets.push_back(reflections(subject, tell)), sheets.push_back(rough_reflections(subject, tell));
    const auto& lights = subject.scene().lights;
    if (std::any_of(lights.begin(), lights.end(), [](const Light& l) { return l.on; })) sheets.push_back(reuse(subject, tell));
    return sheets;
}

}  // namespace plumb::cli
