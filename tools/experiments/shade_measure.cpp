// plumb experiment indirect-shadow: what is measured.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/signed_error.h"
#include "gi/frame/probe_bake.h"
#include "gi/probes/bake.h"
#include "gi/probes/static_scene.h"
#include "io/file.h"
#include "tools/experiments/ipr_truth.h"
#include "tools/experiments/shade.h"

namespace plumb::cli {

namespace {

constexpr double swing = 0.25;  // of irradiance: full colour of pictures

using compare::Plane;
using probes::IndirectShadow;

struct Truth {
    Plane mean, error;
};

Scene without_moving(Scene scene) {
    std::erase_if(scene.meshes, [](const Mesh& m) { return m.dynamic; });
    return scene;
}
Scene with_black(Scene scene) {
    Material black;
    black.name = "black", black.reflectance = glm::vec3(0);
    scene.materials.push_back(black);
    for (Mesh& mesh : scene.meshes)
        if (mesh.dynamic) mesh.material.assign(mesh.material.size(), std::int32_t(scene.materials.size()) - 1);
    return scene;
}

class Measure {
  public:
    Measure(const Scene& scene, frame::Settings settings, const ShadeRequest& request, const RunOptions& options,
            const std::function<void(const std::string&)>& tell)
        : scene_(scene), settings_(std::move(settings)), request_(request), options_(options), tell_(tell) {
        if (std::none_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); }))
            throw InputError(scene.name + ": no mesh is dynamic: nothing casts an indirect shadow that a bake lacks");
        scene_.frame_size = request.size;
        settings_.method = frame::Method::probes, settings_.lod = {}, settings_.truth = false;
        settings_.probe_run.loop = probes::Loop::converged;
    }

    ShadeResult run() {
        tell_("bake");
        frame::add_bake(scene_, settings_, options_);
        result_.scene = io::stem_of(scene_.name), result_.request = request_;
        // The same bake: what moves is no part of it, but the list of materials is longer.
        black_scene_ = with_black(scene_);
        auto black_bake = std::make_shared<probes::Bake>(*settings_.bake);
        black_bake->scene_hash = probes::scene_hash(black_scene_, probes::flatten_static(black_scene_));
        black_bake_ = black_bake;
        result_.receivers = settings_.bake->receivers.count(), result_.places = settings_.bake->spatial.grid.places();
        const frame::Frame seen = frame_of(scene_, IndirectShadow::off, 0, 0);
        points_ = seen.gbuffer;
        for (std::size_t i = 0; i < points_.normal.size(); ++i) {
            const int object = points_.id.texels[i].x;
            if (object < 0 || scene_.meshes[std::size_t(object)].dynamic) points_.normal.texels[i] = glm::vec4(0);
        }
        const Scene empty = without_moving(scene_);
        own_none_ = own_without(empty);
        tell_("truth without what moves"), none_ = truth_of(empty);
        tell_("truth, black"), black_ = truth_of(black_scene_);
        tell_("truth"), whole_ = truth_of(scene_);
        result_.truth = shown(difference(black_.mean, none_.mean));
        add("off", IndirectShadow::off, 0, 0);
        add("uniform, 16", IndirectShadow::uniform, 16, 0);
        for (const int n : {1, 4, 16, 64}) add(fmt::format("spheres, {}", n), IndirectShadow::spheres, n, 0);
        for (const int n : {4, 16, 64}) add(fmt::format("reflecting, {}", n), IndirectShadow::reflecting, n, 0);
        for (const int n : {16, 64, 256}) add(fmt::format("rays, {}", n), IndirectShadow::rays, 0, n);
        settings_.probe_run.relight_dynamic = true;
        add("relight", IndirectShadow::off, 0, 0);
        add("relight, spheres, 16", IndirectShadow::spheres, 16, 0);
        add("relight, reflecting, 16", IndirectShadow::reflecting, 16, 0);
        add("relight, rays, 64", IndirectShadow::rays, 0, 64);
        return std::move(result_);
    }

  private:
    frame::Frame frame_of(const Scene& scene, IndirectShadow shadow, int spheres, int rays) const {
        frame::Settings s = settings_;
        if (&scene == &black_scene_) s.bake = black_bake_;
        s.probe_run.indirect_shadow = shadow;
        if (spheres > 0) s.probe_run.shadow_spheres = spheres;
        if (rays > 0) s.probe_run.shadow_rays = rays;
        return frame::execute(scene, s, frame::plan(scene, s), options_);
    }
    // What the probes bring to the same points without the meshes: behind them, too, where the frame shows them.
    Plane own_without(const Scene& scene) const { return compare::luminances(frame_of(scene, IndirectShadow::off, 0, 0).indirect); }

    Truth truth_of(const Scene& scene) const {
        Image4 mean, error;
        trace_points(scene, {&points_.position, &points_.normal}, std::max(request_.samples, 32), settings_.probes.rays, options_, mean, error);
        return {compare::luminances(mean), compare::luminance_errors(error)};
    }
    static Plane difference(const Plane& a, const Plane& b) {
        Plane d(a.width, a.height);
        for (std::size_t i = 0; i < d.size(); ++i) d.texels[i] = a.texels[i] - b.texels[i];
        return d;
    }
    bool in_region(const Truth& with, std::size_t i) const {
        const double change = std::fabs(with.mean.texels[i] - none_.mean.texels[i]), a = with.error.texels[i], b = none_.error.texels[i];
        const double noise = std::sqrt(a * a + b * b);
        return points_.normal.texels[i].w != 0 && change > request_.least * none_.mean.texels[i] && change > 2 * noise;
    }

    ShadeErrors judge(const Plane& own, const Truth& with) const {
        ShadeErrors e;
        double change = 0, irradiance = 0, sum = 0, magnitude = 0, squares = 0, variance = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            if (!in_region(with, i)) continue;
            const double true_change = with.mean.texels[i] - none_.mean.texels[i], error = own.texels[i] - own_none_.texels[i] - true_change;
            ++e.pixels, irradiance += none_.mean.texels[i], change += std::fabs(true_change);
            sum += error, magnitude += std::fabs(error), squares += error * error;
            variance += with.error.texels[i] * with.error.texels[i] + none_.error.texels[i] * none_.error.texels[i];
        }
        if (e.pixels == 0 || !(change > 0)) throw InputError(scene_.name + ": the truth changes nowhere by more than its noise: more --samples");
        const double n = e.pixels, unit = change / n;
        e.irradiance = irradiance / n, e.change = change / irradiance, e.bias = sum / n / unit, e.mean = magnitude / n / unit;
        e.rms = std::sqrt(std::max(squares - variance, 0.0) / n) / unit, e.noise = std::sqrt(variance / n) / unit;
        e.uncertain = std::sqrt(variance) / n / unit;
        return e;
    }

    // Where there is a point: signed, relative to irradiance without the meshes.
    Image4 shown(const Plane& error) const {
        Image4 image(error.width, error.height, glm::vec4(0.25f));
        for (std::size_t i = 0; i < error.size(); ++i)
            if (points_.normal.texels[i].w != 0)
                image.texels[i] = glm::vec4(compare::signed_color(error.texels[i] / std::max(none_.mean.texels[i], 1e-12), swing), 1);
        return image;
    }

    void add(const std::string& name, IndirectShadow shadow, int spheres, int rays) {
        tell_(name);
        ShadeRow row;
        row.name = name;
        std::vector<double> times, fits;
        frame::Frame f;
        for (int k = 0; k < request_.repeats; ++k) {
            f = frame_of(scene_, shadow, spheres, rays);
            double ms = 0, fit = 0;
            for (const frame::StageRun& s : f.stages) {
                const bool of_shadows = s.label.find("shadow_") != std::string::npos || s.label.find("indirect_shadow") != std::string::npos;
                if (of_shadows) (s.label.ends_with("(fit)") ? fit : ms) += s.ms;
            }
            times.push_back(ms), fits.push_back(fit);
        }
        std::sort(times.begin(), times.end()), std::sort(fits.begin(), fits.end());
        row.ms = times[times.size() / 2], row.fit_ms = fits[fits.size() / 2];
        for (const auto& fitted : f.probes.fitted) row.spheres += int(fitted.size());
        const Plane own = compare::luminances(f.indirect);
        // Meshes are seen by probes, or send light, in black and as they are.
        const Plane black = compare::luminances(frame_of(black_scene_, shadow, spheres, rays).indirect);
        row.black = judge(black, black_), row.whole = judge(own, whole_);
        row.error = shown(difference(difference(black, own_none_), difference(black_.mean, none_.mean)));
        row.indirect = f.indirect;
        result_.rows.push_back(std::move(row));
    }

    Scene scene_, black_scene_;
    frame::Settings settings_;
    std::shared_ptr<const probes::Bake> black_bake_;
    ShadeRequest request_;
    const RunOptions& options_;
    const std::function<void(const std::string&)>& tell_;
    raster::GBuffer points_;
    Plane own_none_;
    Truth none_, black_, whole_;
    ShadeResult result_;
};

}  // namespace

ShadeResult measure_shade(const Scene& scene, frame::Settings settings, const ShadeRequest& request, const RunOptions& options,
                          const std::function<void(const std::string&)>& tell) {
    return Measure(scene, std::move(settings), request, options, tell).run();
}

}  // namespace plumb::cli
