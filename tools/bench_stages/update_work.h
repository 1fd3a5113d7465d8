// What an update of probes reads, of the sizes of IPR's scenes: 512 rays a probe, which end anywhere on the lightmap, receivers in
// clusters of 1024, 32 singular values and 64 coefficients.
#pragma once

#include <cmath>
#include <numeric>
#include <vector>

#include "core/hash.h"
#include "gi/lend.h"
#include "gi/probes/directions.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/update.h"

namespace plumb::bench {

struct UpdateSize {
    int receivers, probes, probes_of_a_cluster;
};
// Table 5.1's first. The second: few probes, many receivers.
inline constexpr UpdateSize update_sizes[] = {{65011, 78, 30}, {282403, 7, 7}};

class UpdateWork {
  public:
    explicit UpdateWork(const UpdateSize& size) : size_(size) {
        constexpr int most = 1024, rank = 32;
        const int clusters = (size.receivers + most - 1) / most;
        probes::FlatClusters f;
        f.singular_values = rank;
        for (int c = 0; c < clusters; ++c) {
            for (int k = 0; k < size.probes_of_a_cluster; ++k) f.probes.push_back((c + k) % size.probes);
            for (int i = most * c; i < std::min(size.receivers, most * (c + 1)); ++i) f.receivers.push_back(i), f.cluster_of.push_back(c);
            f.first_receiver.push_back(int(f.receivers.size())), f.first_probe.push_back(int(f.probes.size()));
            f.rank.push_back(rank);
        }
        f.sigma_vt = numbers(f.probes.size() * coefficients * rank, 1), f.u = numbers(f.cluster_of.size() * rank, 2);
        data_ = probes::cluster_data(f, size.receivers, coefficients);
        level_.resize(std::size_t(clusters)), receiver_level_.resize(std::size_t(size.receivers));
        lambda_ = lights(std::size_t(size.probes) * coefficients), basis_ = lights(std::size_t(clusters) * rank);
        irradiance_ = lights(std::size_t(size.receivers));
        cover_ = cover();
        last_ = Image4(cover_.width, cover_.height, glm::vec4(2, 2, 2, 1));
        const std::size_t hits = std::size_t(size.probes) * rays;
        surface_.assign(hits, glm::vec4(0.5f, 0.5f, 0.5f, 1)), emitted_.assign(hits, glm::vec4(0.1f)), direct_.assign(hits, glm::vec4(1));
        const Buffer<float> u = numbers(2 * hits, 3);
        for (std::size_t i = 0; i < hits; ++i) place_.emplace_back(u[2 * i] + 0.5f, u[2 * i + 1] + 0.5f, 0, 0);
        const Buffer<glm::vec4> directions = probes::relight_directions(rays);
        harmonics_ = probes::harmonics_of(directions, 7), weights_ = probes::level_weights(directions, {rays});
        radiance_ = lights(hits), probe_level_.assign(std::size_t(size.probes), 0);
    }

    StageData radiance() const {
        probes::RadianceInputs in;
        in.probes = size_.probes, in.rays = rays, in.side = cover_.width;
        in.surface = &surface_, in.emitted = &emitted_, in.direct = &direct_, in.place = &place_, in.lightmap = &last_;
        return probes::data_of(in);
    }
    StageData lambda() const {
        probes::LambdaInputs in;
        in.probes = size_.probes, in.rays = rays, in.coefficients = coefficients;
        in.level_rays = {rays}, in.level_coefficients = {coefficients};
        in.radiance = &radiance_, in.harmonics = &harmonics_, in.weights = &weights_, in.probe_level = &probe_level_;
        return probes::data_of(in);
    }
    StageData basis() const {
        probes::BasisInputs in;
        in.clusters = &data_, in.cluster_level = level_.data(), in.lambda = lambda_.data(), in.probes = size_.probes;
        return probes::data_of(in);
    }
    StageData irradiance() const {
        return probes::data_of(probes::IrradianceInputs{&data_, level_.data(), receiver_level_.data(), basis_.data()});
    }
    StageData lightmap() const { return probes::data_of(probes::LightmapInputs{&cover_, irradiance_.data(), size_.receivers}); }
    // In the order of a frame.
    std::vector<StageData> all() const { return {radiance(), lambda(), basis(), irradiance(), lightmap()}; }

  private:
    static Buffer<float> numbers(std::size_t n, int seed) {
        Buffer<float> x(n);
        for (std::size_t i = 0; i < n; ++i) x[i] = unit_float<float>(pixel_hash<std::int32_t>(int(i), seed, 0, 7).x) - 0.5f;
        return x;
    }
    static Buffer<glm::vec4> lights(std::size_t n) { return Buffer<glm::vec4>(n, glm::vec4(1, 2, 3, 0)); }

    // Charts of 32 x 32 texels with 3 between them, in a square.
    Image<std::int32_t> cover() const {
        constexpr int side = 32, step = side + 3;
        const int charts = (size_.receivers + side * side - 1) / (side * side), across = int(std::ceil(std::sqrt(double(charts))));
        std::vector<glm::ivec2> texels;
        for (int i = 0; i < size_.receivers; ++i) {
            const int chart = i / (side * side), within = i % (side * side);
            texels.push_back({3 + step * (chart % across) + within % side, 3 + step * (chart / across) + within / side});
        }
        return probes::lightmap_cover(texels, data_.place_of, 3 + step * across, 1);
    }

    static constexpr int rays = 512, coefficients = 64;

    UpdateSize size_;
    probes::ClusterData data_;
    std::vector<std::int32_t> level_, receiver_level_, probe_level_;
    Buffer<glm::vec4> surface_, emitted_, direct_, place_, radiance_, lambda_, basis_, irradiance_;
    Buffer<float> harmonics_, weights_;
    Image4 last_;  // lightmap
    Image<std::int32_t> cover_;
};

}  // namespace plumb::bench
