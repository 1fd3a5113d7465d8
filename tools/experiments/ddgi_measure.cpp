// plumb experiment ddgi: the truth, volumes of DDGI's probes, bakes of ours, and what each is off by.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/graph/memory_store.h"
#include "gi/probes/converge.h"
#include "gi/reference/reference.h"
#include "tools/experiments/ddgi.h"

namespace plumb::cli {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr int fold = 1024;  // receivers in a row of an image

// The receivers as an image: rows of `fold`, the rest of the last one without normal.
struct Folded {
    Image4 position, normal;
};
Folded folded(const probes::Receivers& r) {
    const int height = (r.count() + fold - 1) / fold;
    Folded f{Image4(fold, height), Image4(fold, height)};
    std::copy(r.position.begin(), r.position.end(), f.position.texels.begin());
    std::copy(r.normal.begin(), r.normal.end(), f.normal.texels.begin());
    return f;
}

struct Truth {
    Image4 mean, error;  // irradiance, W/m2
    int samples = 0;
    std::uint64_t rays = 0;
};

// All light but what lamps send straight to the receivers: what probes' rays can bring. Emitting surfaces and the sky are
// part of it; their own direct light is traced in a scene without lamps, so that no lamp adds noise to it.
Truth truth_of(const Scene& scene, const Folded& receivers, int samples, Rays rays, const RunOptions& options) {
    reference::PathParams params;
    params.mode = reference::Mode::indirect, params.samples = samples, params.rays = rays;
    const reference::PointInputs points{&receivers.position, &receivers.normal};
    const auto lit = reference::prepare(scene, rays);
    reference::Estimate indirect = reference::trace_irradiance(params, *lit, points, 1, options);
    Truth t{std::move(indirect.mean), std::move(indirect.error), indirect.samples, indirect.rays};
    Scene unlit = scene;
    unlit.lights.clear();
    const auto glow = reference::prepare(unlit, rays);
    if (glow->lights.count == 0) return t;
    params.mode = reference::Mode::direct;
    const reference::Estimate direct = reference::trace_irradiance(params, *glow, points, 2, options);
    for (std::size_t i = 0; i < t.mean.size(); ++i) {
        t.mean.texels[i] += direct.mean.texels[i];
        for (int c = 0; c < 3; ++c)
            t.error.texels[i][c] = float(std::sqrt(double(t.error.texels[i][c]) * double(t.error.texels[i][c]) +
                                                   double(direct.error.texels[i][c]) * double(direct.error.texels[i][c])));
    }
    t.rays += direct.rays;
    return t;
}

// Receivers of which at most the share `open` of the cosine-weighted hemisphere meets nothing. Outer walls of a house are open:
// no probe within the bounds stands in front of them.
std::vector<int> judged_receivers(const Scene& scene, const Folded& receivers, int count, double open, Rays rays, const RunOptions& options) {
    std::vector<int> judged;
    Image4 openness(receivers.position.width, receivers.position.height);
    if (open < 1) {
        reference::PathParams params;
        params.mode = reference::Mode::ambient_occlusion, params.samples = 64, params.rays = rays;
        openness = reference::trace_irradiance(params, *reference::prepare(scene, rays), {&receivers.position, &receivers.normal}, 3, options).mean;
    }
    for (int i = 0; i < count; ++i)
        if (double(openness.texels[std::size_t(i)].x) <= open) judged.push_back(i);
    if (judged.empty()) throw InputError("--open: no receiver is left");
    return judged;
}

// What all rows share.
class Judge {
  public:
    Judge(const probes::Receivers& receivers, std::vector<int> judged, const Truth& truth)
        : receivers_(receivers), judged_(std::move(judged)), truth_(luminance(truth.mean)), error_(luminance(truth.error)) {
        for (const double t : truth_.texels) mean_ += t / double(truth_.size());
    }

    void judge(const Image4& irradiance, DdgiRow& row) const {
        const compare::Plane own = luminance(irradiance);
        row.errors = compare::signed_errors(own, truth_, error_);
        std::size_t leaking = 0, black = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            const double t = truth_.texels[i], e = own.texels[i];
            leaking += t < ddgi_dark * mean_ && !(e <= ddgi_bright * mean_) ? 1 : 0;
            black += e < ddgi_dark * mean_ && !(t <= ddgi_bright * mean_) ? 1 : 0;
        }
        row.leaking = double(leaking) / double(own.size()), row.black = double(black) / double(own.size());
        row.lightmap = lightmap(irradiance);
    }
    Image4 lightmap(const Image4& irradiance) const {
        Buffer<glm::vec4> values(irradiance.texels.begin(), irradiance.texels.begin() + receivers_.count());
        for (glm::vec4& v : values) v.w = 1;
        return probes::extend_borders(receivers_, probes::scatter(receivers_, values));
    }
    double mean() const { return mean_; }
    double dark() const {
        std::size_t n = 0;
        for (const double t : truth_.texels) n += t < ddgi_dark * mean_ ? 1 : 0;
        return double(n) / double(truth_.size());
    }
    double noise() const {
        double sum = 0;
        for (const double e : error_.texels) sum += e * e;
        return std::sqrt(sum / double(error_.size())) / mean_;
    }

  private:
    // One row of those that are judged.
    compare::Plane luminance(const Image4& image) const {
        Image4 row(int(judged_.size()), 1);
        for (std::size_t i = 0; i < judged_.size(); ++i) row.texels[i] = image.texels[std::size_t(judged_[i])];
        return compare::luminances(row);
    }

    const probes::Receivers& receivers_;
    std::vector<int> judged_;
    compare::Plane truth_, error_;
    double mean_ = 0;
};

// ---- DDGI ------------------------------------------------------------------------------------------------------------

struct Variant {
    std::string name;
    std::function<void(ddgi::VolumeParams&, double& inset)> set;
};
const std::vector<Variant>& variants() {
    static const std::vector<Variant> all = {
        {"without Chebyshev's bound", [](ddgi::VolumeParams& p, double&) { p.visibility = false; }},
        {"without the side of the surface", [](ddgi::VolumeParams& p, double&) { p.wrapped = false; }},
        {"means of square roots, as published", [](ddgi::VolumeParams& p, double&) { p.root = true; }},
        {"95 % of the energy, as published", [](ddgi::VolumeParams& p, double&) { p.energy = 0.95f; }},
        {"without bias", [](ddgi::VolumeParams& p, double&) { p.bias = 0; }},
        {"twice the bias", [](ddgi::VolumeParams& p, double&) { p.bias *= 2; }},
        {"no weight is crushed", [](ddgi::VolumeParams& p, double&) { p.crush = 1e-9f; }},
        {"distances to backs as they are (2019)", [](ddgi::VolumeParams& p, double&) { p.back_share = 1; }},
        {"stored in 11 and 16 bits", [](ddgi::VolumeParams& p, double&) { p.packed = true; }},
        {"moments of 8 x 8 texels", [](ddgi::VolumeParams& p, double&) { p.depth_side = 8; }},
        {"sharpness 8", [](ddgi::VolumeParams& p, double&) { p.sharpness = 8; }},
        {"probes on the faces of the bounds", [](ddgi::VolumeParams&, double& inset) { inset = 0; }},
        {"64 rays", [](ddgi::VolumeParams& p, double&) { p.rays = 64; }},
        {"64 rays, turned, hysteresis 0.9, 48 rounds",
         [](ddgi::VolumeParams& p, double&) { p.rays = 64, p.turned = true, p.hysteresis = 0.9f, p.rounds = 48; }},
        {"64 rays, turned, hysteresis 0.9, 200 rounds",
         [](ddgi::VolumeParams& p, double&) { p.rays = 64, p.turned = true, p.hysteresis = 0.9f, p.rounds = 200; }},
    };
    return all;
}

class DdgiRuns {
  public:
    DdgiRuns(const Scene& scene, const Folded& receivers, const Judge& judge, Rays rays, const RunOptions& options)
        : receivers_(receivers), judge_(judge), options_(options), lit_(probes::lit_scene(scene, rays)) {
        bounds(lit_->geometry, low_, high_);
    }

    DdgiRow run(int per_axis, const ddgi::VolumeParams& params, double inset = 0.5) const {
        const Clock::time_point start = Clock::now();
        ddgi::Volume volume(*lit_, ddgi::grid_over(low_, high_, glm::ivec3(per_axis), inset), params);
        DdgiRow row;
        row.rounds = volume.converge(options_);
        const Image4 e = volume.sample(receivers_.position, receivers_.normal, receivers_.normal, options_);
        row.seconds = seconds_since(start);
        row.method = "DDGI", row.setting = fmt::format("{0}^3, {1} x {1}", per_axis, params.side);
        row.probes = volume.grid().probes(), row.rays = params.rays;
        row.traced = volume.rays(), row.bytes = volume.bytes();
        judge_.judge(e, row);
        return row;
    }
    const probes::LitScene& lit() const { return *lit_; }

  private:
    const Folded& receivers_;
    const Judge& judge_;
    const RunOptions& options_;
    std::unique_ptr<probes::LitScene> lit_;
    glm::vec3 low_{0}, high_{0};
};

// ---- Clustered transport ----------------------------------------------------------------------------------------------

probes::Relit relit_of(const probes::LitHits& hits) {
    probes::Relit r;
    for (std::size_t i = 0; i < hits.emitted.size(); ++i) {
        r.emitted.emplace_back(glm::vec3(hits.emitted.texels[i]));
        r.reflectance.emplace_back(glm::vec3(hits.albedo.texels[i]));
        r.direct.emplace_back(glm::vec3(hits.direct.texels[i]));
    }
    return r;
}

// What a bake keeps does not depend on its relight rays: the transport of each number of probes is computed once.
// bake_seconds: of the bake that filled the store; 0: this one does.
void add_clusters(const Scene& scene, const DdgiRequest& request, int count, int rays, const probes::LitScene& lit, const Judge& judge,
                  graph::Store& store, double& bake_seconds, const RunOptions& options, std::vector<DdgiRow>& rows) {
    Clock::time_point start = Clock::now();
    probes::BakeParams params = request.bake;
    params.lightmap_size = request.lightmap, params.placement.count = count, params.relight_rays = rays;
    probes::BakeGraph graph(scene, params);
    graph::RunWith with;
    with.options = options, with.store = &store;
    graph::run(graph.nodes(), with);
    const probes::Bake& b = graph.bake();
    if (bake_seconds == 0) bake_seconds = seconds_since(start);
    for (const probes::Transport transport : {probes::Transport::clustered, probes::Transport::whole}) {
        start = Clock::now();
        const probes::LitHits hits = probes::lit_hits(lit, b.placement.probes, b.relight_directions, options);
        probes::RunTime run(b, relit_of(hits), transport);
        DdgiRow row;
        row.rounds = run.converge(request.volume.rounds, double(request.volume.change));
        row.seconds = seconds_since(start), row.bake_seconds = bake_seconds;
        const bool clustered = transport == probes::Transport::clustered;
        row.method = clustered ? "clusters" : "whole transport", row.setting = fmt::format("{} probes", b.placement.probes.size());
        row.probes = int(b.placement.probes.size()), row.rays = rays;
        row.traced = hits.rays, row.baked = b.counts().traced + row.places();
        // Beside the transport what relight rays met, 16 bytes each (IPR 3.2.5.1).
        const std::size_t transport_bytes = clustered ? b.flat.u.size() + b.flat.sigma_vt.size() : b.alpha.size();
        row.bytes = 4 * transport_bytes + 16 * std::size_t(row.places());
        Image4 e(fold, (b.receivers.count() + fold - 1) / fold);
        for (std::size_t i = 0; i < run.irradiance().size(); ++i) e.texels[i] = glm::vec4(glm::vec3(run.irradiance()[i]), 0);
        judge.judge(e, row);
        rows.push_back(std::move(row));
    }
}

// Receivers of the lightmap alone.
probes::Receivers receivers_of(const Scene& scene, const DdgiRequest& request, const RunOptions& options) {
    probes::BakeParams params = request.bake;
    params.lightmap_size = request.lightmap;
    probes::BakeGraph graph(scene, params);
    graph::RunWith with;
    with.options = options;
    graph::run({graph.nodes()[0], graph.nodes()[1]}, with);
    return graph.bake().receivers;
}

}  // namespace

std::string DdgiRow::name() const {
    return method == "DDGI" ? fmt::format("DDGI {}, {} rays", setting, rays) : fmt::format("{}, {}, {} rays", method, setting, rays);
}

DdgiResult measure_ddgi(const Scene& scene, const DdgiRequest& request, const RunOptions& options,
                        const std::function<void(const std::string&)>& tell) {
    DdgiResult result;
    const probes::Receivers receivers = receivers_of(scene, request, options);
    const Folded points = folded(receivers);
    tell(fmt::format("truth of {} receivers", receivers.count()));
    const Truth truth = truth_of(scene, points, request.samples, request.bake.rays, options);
    const std::vector<int> judged = judged_receivers(scene, points, receivers.count(), request.open, request.bake.rays, options);
    const Judge judge(receivers, judged, truth);
    result.receivers = int(judged.size()), result.left_out = receivers.count() - result.receivers, result.lightmap = receivers.size.x, result.truth_samples = truth.samples;
    result.truth_rays = truth.rays;
    result.truth_mean = judge.mean(), result.truth_noise = judge.noise(), result.dark_receivers = judge.dark();
    if (!(judge.mean() > 0)) throw InputError(scene.name + ": no light reaches a receiver but straight from lamps");
    result.truth = judge.lightmap(truth.mean);
    result.receiver_texels = Image<std::uint8_t>(receivers.size.x, receivers.size.y);
    for (const int i : judged) {
        const glm::ivec2 t = receivers.texel[std::size_t(i)];
        result.receiver_texels(t.x, t.y) = 1;
    }

    const DdgiRuns runs(scene, points, judge, request.bake.rays, options);
    for (const int per_axis : request.grids)
        for (const int side : request.sides)
            for (const int rays : request.rays) {
                ddgi::VolumeParams params = request.volume;
                params.side = side, params.depth_side = side == 6 ? 14 : std::min(2 * side, 64), params.rays = rays;
                tell(fmt::format("DDGI {0}^3, {1} x {1}, {2} rays", per_axis, side, rays));
                result.rows.push_back(runs.run(per_axis, params));
            }
    for (const int count : request.probes) {
        graph::MemoryStore store;
        double bake_seconds = 0;
        for (const int rays : request.rays) {
            tell(fmt::format("{} probes with clustered transport, {} rays", count, rays));
            add_clusters(scene, request, count, rays, runs.lit(), judge, store, bake_seconds, options, result.rows);
        }
    }
    if (!request.variants) return result;
    const int per_axis = request.grids[request.grids.size() / 2];
    ddgi::VolumeParams params = request.volume;
    params.rays = request.rays.back();
    for (const Variant& v : variants()) {
        tell("DDGI " + v.name);
        ddgi::VolumeParams changed = params;
        double inset = 0.5;
        v.set(changed, inset);
        DdgiRow row = runs.run(per_axis, changed, inset);
        row.variant = true, row.setting = v.name;
        result.rows.push_back(std::move(row));
    }
    return result;
}

}  // namespace plumb::cli
