#include "tools/experiments/probe_ladder_rung.h"

#include <fmt/format.h>

#include <chrono>

#include "core/content_hash.h"
#include "core/sh.h"
#include "gi/probes/sky_probe.h"
#include "tools/shared/bake_file.h"

namespace plumb::cli {

namespace {

constexpr int many_rays = 8192;       // of a probe, for the step `degree`
constexpr int most_bake_rays = 4096;  // of a receiver: the last rung of that axis

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::uint64_t hash_of(const probes::Bake& b, std::uint64_t more) {
    return content_hash(b.placement.probes.data(), b.placement.probes.size() * sizeof(glm::vec4), more);
}

}  // namespace

std::vector<double> uncut(const LadderTransport& t, const std::vector<double>& lambda, int degree) {
    const std::size_t slots = std::size_t(t.supports.overlaps), n = t.rays.size(), count = std::size_t(sh::count(degree));
    std::vector<double> e(n, 0);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t s = 0; s < slots; ++s)
            if (const std::int32_t p = t.supports.probe[i * slots + s]; p >= 0)
                for (std::size_t j = 0; j < count; ++j)
                    e[i] += t.alpha[(i * slots + s) * sh::max_count + j] * lambda[std::size_t(p) * sh::max_count + j];
    return e;
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
    return a;
}

LadderMeasure::LadderMeasure(const Scene& scene, const probes::BakeParams& params, const LadderRequest& request,
                             const RunOptions& options, const std::function<void(const std::string&)>& progress)
    : scene_(scene),
      params_(params),
      options_(options),
      world_(scene, params.rays),
      radiance_(direct_light(world_)),
      directions_(probes::relight_directions(std::max(many_rays, params.relight_rays))) {
    progress("the default");
    base_ = bake(params);
    progress("truth");
    checked_ = check_receivers(world_, radiance_, base_.bake.receivers, request.check,
                               std::max(most_bake_rays, params.receiver_rays), params.distribution, options);
}

LadderBaked LadderMeasure::bake(const probes::BakeParams& params) const {
    const auto start = std::chrono::steady_clock::now();
    probes::BakeGraph graph(scene_, params);
    graph::RunWith with;
    with.options = options_;
    const std::vector<graph::NodeRun> runs = graph::run(graph.nodes(), with);
    LadderBaked made;
    made.seconds = seconds_since(start), made.cluster_seconds = runs.back().ms / 1000;
    made.bake = graph.bake();
    return made;
}

LadderBaked LadderMeasure::cut_again(const LadderBaked& baked, const probes::BakeParams& params) const {
    LadderBaked made = baked;
    probes::Bake& b = made.bake;
    b.params = params;
    const auto start = std::chrono::steady_clock::now();
    probes::TransportRows rows;
    rows.receivers = b.receivers.count(), rows.overlaps = b.supports.overlaps, rows.coefficients = b.coefficients();
    rows.position = b.receivers.position.data(), rows.support = b.supports.probe.data(), rows.alpha = b.alpha.data();
    b.clusters = probes::make_clusters(rows, probes::cluster_params(params), options_);
    b.flat = probes::flat(b.clusters);
    made.cluster_seconds = seconds_since(start);
    made.seconds += made.cluster_seconds - baked.cluster_seconds;
    return made;
}

const Buffer<float>& LadderMeasure::weights(int n) {
    Buffer<float>& w = weights_[n];
    if (w.empty()) w = probes::relight_weights(directions_, n);
    return w;
}

const LadderPlaced& LadderMeasure::placed_of(const probes::Bake& b) {
    std::unique_ptr<LadderPlaced>& placed = placed_[hash_of(b, 0)];
    if (!placed) {
        placed = std::make_unique<LadderPlaced>();
        placed->light = probe_light(world_, radiance_, b.placement.probes, directions_, b.transport.escape, options_);
        placed->many = lambda_in_double(placed->light, weights(placed->light.rays()), options_);
    }
    return *placed;
}

const LadderTransport& LadderMeasure::transport_of(const probes::Bake& b) {
    std::uint64_t key = content_hash(&b.radius.radius_m, sizeof b.radius.radius_m, std::uint64_t(b.params.receiver_rays));
    key = hash_of(b, content_hash(&b.params.placement.overlaps, sizeof(int), key));
    if (b.transport.fitted) {
        const int of_fit[] = {b.params.degree, b.params.relight_rays};
        key = content_hash(of_fit, sizeof of_fit, key);
    }
    std::unique_ptr<LadderTransport>& t = transports_[key];
    if (!t)
        t = std::make_unique<LadderTransport>(transport_in_double(world_, checked_, b.placement.probes, b.radius.radius_m,
                                                                  b.params.placement.overlaps, b.transport, options_));
    return *t;
}

std::vector<float> LadderMeasure::shown(const probes::Bake& b) {
    return clustered_in_float(b,
                              lambda_in_float(placed_of(b).light, weights(b.params.relight_rays), b.params.degree, options_));
}

void LadderMeasure::add_costs(const LadderBaked& baked, LadderRung& r) const {
    const probes::Bake& b = baked.bake;
    r.probes = probes::standing_probes(b.placement.probes), r.receivers = b.receivers.count(), r.clusters = int(b.clusters.clusters.size());
    r.seconds = baked.seconds, r.rays = b.counts().traced;
    for (const Array& a : bake_file(b, scene_.name, false).arrays.arrays) r.bytes += a.bytes.size();
    const double coefficients = b.coefficients();
    r.products = double(r.probes) * b.params.relight_rays * coefficients;
    for (const probes::Cluster& c : b.clusters.clusters)
        r.products += double(c.rank) * (double(c.probes.size()) * coefficients + double(c.receivers.size()));
    r.tail = probes::truncation_error(b.clusters, b.params.singular_values).frobenius;
}

LadderRung LadderMeasure::rung_of(const LadderBaked& baked, const std::string& axis, const std::string& line, double value,
                                  const std::string& settings, bool quadrature) {
    const probes::Bake& b = baked.bake;
    LadderRung r;
    r.axis = axis, r.line = line, r.value = value, r.settings = settings;
    add_costs(baked, r);
    const LadderPlaced& placed = placed_of(b);
    const int n = b.params.relight_rays;
    const Buffer<float> w = quadrature ? weights(n) : equal_weights(n);
    r.errors =
        errors_of(checked_, steps_of(checked_, transport_of(b), b, placed.many, lambda_in_double(placed.light, w, options_),
                                     lambda_in_float(placed.light, w, b.params.degree, options_)));
    return r;
}

namespace {

// Of irradiances by many relight rays and by the bake's, the transport not cut.
LadderErrors uncut_errors(const CheckedReceivers& checked, const LadderTransport& t, const std::vector<double>& degree,
                          const std::vector<double>& relight) {
    const std::vector<double> none(t.rays.size(), 0);
    LadderSteps steps;
    steps.value = relight;
    steps.added = {minus(t.rays, checked.truth), minus(t.unseen, t.rays), minus(degree, t.unseen), minus(relight, degree), none, none};
    return errors_of(checked, steps);
}

}  // namespace

LadderRung LadderMeasure::uncut_rung(const Buffer<glm::vec4>& probes, const probes::PlacementParams& placement,
                                     const std::string& line) {
    const double radius = probes::probe_radius(probes, base_.bake.receivers.position, placement, options_).radius_m;
    Buffer<glm::vec4> all = probes;
    if (base_.bake.transport.escape == probes::Escape::sky) all.push_back(probes::sky_probe);
    const LadderTransport t =
        transport_in_double(world_, checked_, all, radius, placement.overlaps, base_.bake.transport, options_);
    const ProbeLight light = probe_light(world_, radiance_, all, directions_, base_.bake.transport.escape, options_);
    const std::vector<double> degree = uncut(t, lambda_in_double(light, weights(light.rays()), options_), params_.degree);
    LadderRung r;
    r.axis = "placement", r.line = line, r.value = double(probes.size());
    r.settings = fmt::format("{} probes, {}", probes.size(), line);
    r.probes = int(probes.size()), r.receivers = base_.bake.receivers.count();
    r.errors = uncut_errors(checked_, t, degree,
                            uncut(t, lambda_in_double(light, weights(params_.relight_rays), options_), params_.degree));
    return r;
}

LadderRung LadderMeasure::windowed_rung(const std::vector<double>& window, const std::string& line) {
    const int degree = int(window.size()) - 1;
    const auto windowed = [&](std::vector<double> lambda) {
        for (std::size_t k = 0; k < lambda.size(); ++k)
            for (int l = 0; l <= degree; ++l)
                if (const int j = int(k % sh::max_count); j >= l * l && j < (l + 1) * (l + 1)) lambda[k] *= window[std::size_t(l)];
        return lambda;
    };
    const LadderPlaced& placed = placed_of(base_.bake);
    const LadderTransport& t = transport_of(base_.bake);
    LadderRung r;
    r.axis = "window", r.line = line, r.value = degree, r.settings = fmt::format("degree {}, window {}", degree, line);
    r.probes = placed.light.probes, r.receivers = base_.bake.receivers.count();
    const std::vector<double> lambda = lambda_in_double(placed.light, weights(params_.relight_rays), options_);
    r.errors = uncut_errors(checked_, t, uncut(t, windowed(placed.many), degree), uncut(t, windowed(lambda), degree));
    return r;
}

}  // namespace plumb::cli
