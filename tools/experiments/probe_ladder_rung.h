// plumb experiment probe-ladder: bakes and measures one setting. What settings have in common is computed once.
#pragma once

#include <map>
#include <memory>

#include "tools/experiments/probe_ladder.h"

namespace plumb::cli {

struct LadderBaked {
    probes::Bake bake;
    double seconds = 0, cluster_seconds = 0;  // wall; the clusters' are among the others
};

// Of one placement of probes.
struct LadderPlaced {
    ProbeLight light;
    std::vector<double> many;  // lambda by all of its rays
};

class LadderMeasure {
  public:
    // Bakes the default and traces the truth. The arguments must outlive it.
    LadderMeasure(const Scene& scene, const probes::BakeParams& params, const LadderRequest& request, const RunOptions& options,
                  const std::function<void(const std::string&)>& progress);

    const LadderWorld& world() const { return world_; }
    const Radiance& radiance() const { return radiance_; }
    const CheckedReceivers& checked() const { return checked_; }
    const LadderBaked& base() const { return base_; }
    const Buffer<glm::vec4>& directions() const { return directions_; }  // of relight rays

    LadderBaked bake(const probes::BakeParams& params) const;
    // The same transport in other clusters.
    LadderBaked cut_again(const LadderBaked& baked, const probes::BakeParams& params) const;

    // Of the first n relight directions, as relight_weights().
    const Buffer<float>& weights(int n);
    const LadderPlaced& placed_of(const probes::Bake& bake);
    const LadderTransport& transport_of(const probes::Bake& bake);
    // Irradiance of all receivers as the run time shows it.
    std::vector<float> shown(const probes::Bake& bake);

    void add_costs(const LadderBaked& baked, LadderRung& rung) const;
    // Of a bake with the default's receivers. quadrature: relight rays have relight_weights(), else 4 pi / N.
    LadderRung rung_of(const LadderBaked& baked, const std::string& axis, const std::string& line, double value,
                       const std::string& settings, bool quadrature = true);
    // Of probes anywhere, with the default's receivers, before clusters.
    LadderRung uncut_rung(const Buffer<glm::vec4>& probes, const probes::PlacementParams& placement, const std::string& line);

    // Of the default's probes, before clusters: coefficients of degree l times window[l]; as many degrees as it is long.
    LadderRung windowed_rung(const std::vector<double>& window, const std::string& line);

  private:
    const Scene& scene_;
    const probes::BakeParams& params_;
    const RunOptions& options_;
    const LadderWorld world_;
    const Radiance radiance_;
    const Buffer<glm::vec4> directions_;
    LadderBaked base_;
    CheckedReceivers checked_;
    std::map<int, Buffer<float>> weights_;
    std::map<std::uint64_t, std::unique_ptr<LadderPlaced>> placed_;
    std::map<std::uint64_t, std::unique_ptr<LadderTransport>> transports_;
};

// Irradiance of the checked receivers by these coefficients, the transport not cut.
std::vector<double> uncut(const LadderTransport& transport, const std::vector<double>& lambda, int degree);
std::vector<double> minus(std::vector<double> a, const std::vector<double>& b);

}  // namespace plumb::cli
