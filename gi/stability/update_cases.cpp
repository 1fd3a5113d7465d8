// Data of the run time's update of probes that no scene has; and what one has of a bake's first receivers.
#include <functional>
#include <limits>
#include <numeric>

#include "core/hash.h"
#include "gi/lend.h"
#include "gi/probes/bake.h"
#include "gi/probes/update.h"
#include "gi/stability/bake.h"

namespace plumb::stability {

namespace {

using Lights = Buffer<glm::vec4>;

float noise(int i, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(i, channel, 6, 7).x); }

Lights lights(int n, int seed) {
    Lights l;
    for (int i = 0; i < n; ++i) l.push_back({noise(i, seed) - 0.4f, noise(i, seed + 1) - 0.4f, noise(i, seed + 2) - 0.4f, 0});
    return l;
}

// One cluster of receivers, and the light of its probes.
struct Cluster {
    probes::ClusterData data;
    Lights lambda, basis;
    std::vector<std::int32_t> level = {0}, receiver_level;

    Cluster(int receivers, int probe_count, int coefficients, int rank) {
        data.coefficients = coefficients, data.singular_values = std::max(rank, 1);
        data.clusters = {{0, 0, probe_count, rank}};
        data.cluster_probes.resize(std::size_t(probe_count));
        std::iota(data.cluster_probes.begin(), data.cluster_probes.end(), 0);
        for (int i = 0; i < probe_count * coefficients * rank; ++i) data.matrix.push_back(2 * noise(i, 20) - 1);
        for (int i = 0; i < receivers * data.singular_values; ++i) data.u.push_back(2 * noise(i, 21) - 1);
        data.receiver.resize(std::size_t(receivers)), data.cluster.assign(std::size_t(receivers), 0);
        std::iota(data.receiver.begin(), data.receiver.end(), 0);
        receiver_level.assign(std::size_t(receivers), 0);
        lambda = lights(std::max(probe_count, 1) * coefficients, 22), basis = lights(data.singular_values, 26);
    }
    StageData of_basis() const {
        probes::BasisInputs in;
        in.clusters = &data, in.cluster_level = level.data(), in.lambda = lambda.data();
        in.probes = int(lambda.size()) / data.coefficients;
        return probes::data_of(in);
    }
    StageData of_irradiance() const { return probes::data_of(probes::IrradianceInputs{&data, level.data(), receiver_level.data(), basis.data()}); }
};

template <class Kernel>
StageData own(const StageData& data, const std::string& name) {
    StageData all = owned(stage<Kernel>(), data);
    all.label = all.stage + " (" + name + ")";
    return all;
}

BakeCase cluster(const std::string& name, const std::string& meaning, const Cluster& given, const std::function<void(Cluster&)>& change = {}) {
    return {name, "probes", meaning, [=] {
                Cluster c = given;
                if (change) change(c);
                return std::vector{own<probes::BasisKernel>(c.of_basis(), name), own<probes::IrradianceKernel>(c.of_irradiance(), name)};
            }};
}

// Receivers of a lightmap of 9 x 9, and values of them.
BakeCase lightmap(const std::string& name, const std::string& meaning, const std::vector<glm::ivec2>& texels,
                  const std::function<glm::vec4(int)>& value) {
    return {name, "probes", meaning, [=] {
                std::vector<std::int32_t> place_of(texels.size());
                std::iota(place_of.begin(), place_of.end(), 0);
                const Image<std::int32_t> cover = probes::lightmap_cover(texels, place_of, 9, 2);
                Lights values;
                for (int i = 0; i < int(texels.size()); ++i) values.push_back(value(i));
                return std::vector{own<probes::LightmapKernel>(
                    probes::data_of(probes::LightmapInputs{&cover, values.data(), int(values.size())}), name)};
            }};
}

void alike(Cluster& c) {
    std::fill(c.data.matrix.begin(), c.data.matrix.end(), 0.7f), std::fill(c.data.u.begin(), c.data.u.end(), 0.7f);
    for (Lights* l : {&c.lambda, &c.basis}) std::fill(l->begin(), l->end(), glm::vec4(0.3f, 0.9f, 0.1f, 0));
}
// Terms are as far apart as 2^24 and end near 0.
void cancelling(Cluster& c) {
    alike(c);
    for (Lights* l : {&c.lambda, &c.basis})
        for (std::size_t i = 0; i < l->size(); ++i) (*l)[i] *= (i % 2 ? -1.0f : 1.0f) * (i % 4 < 2 ? 1.0f : 0x1p-24f);
}
void scaled(Cluster& c, float by) {
    for (float& m : c.data.matrix) m *= by;
    for (float& u : c.data.u) u *= by;
    for (Lights* l : {&c.lambda, &c.basis})
        for (glm::vec4& x : *l) x /= by;
}

const std::vector<glm::ivec2> patch = {{2, 2}, {3, 2}, {4, 2}, {2, 3}, {3, 3}, {4, 3}, {2, 4}, {4, 4}, {8, 8}};

}  // namespace

void add_update_cases(std::vector<BakeCase>& out) {
    out.push_back(cluster("cluster of one receiver", "one probe of degree 0, one singular value", Cluster(1, 1, 1, 1)));
    out.push_back(cluster("cluster of rank 0", "no light reaches its receivers", Cluster(5, 3, 4, 0)));
    out.push_back(cluster("cluster of 64 probes", "of 64 coefficients, all terms alike, 64 singular values", Cluster(4, 64, 64, 64), alike));
    out.push_back(cluster("coefficients that cancel", "terms of both signs, 2^24 apart", Cluster(4, 30, 64, 32), cancelling));
    out.push_back(cluster("matrices of 1e-18", "and light of 1e18 W/m2", Cluster(8, 4, 16, 8), [](Cluster& c) { scaled(c, 1e-18f); }));
    out.push_back(cluster("matrices of 1e18", "and light of 1e-18 W/m2", Cluster(8, 4, 16, 8), [](Cluster& c) { scaled(c, 1e18f); }));
    out.push_back(cluster("black probes", "no light at all", Cluster(8, 4, 16, 8), [](Cluster& c) {
        c.lambda.assign(c.lambda.size(), glm::vec4(0)), c.basis.assign(c.basis.size(), glm::vec4(0));
    }));
    out.push_back(cluster("clusters that are left out", "their level of detail shows no receiver", Cluster(8, 4, 16, 8),
                          [](Cluster& c) { c.level = {4}; }));
    out.push_back(cluster("a probe that is not there", "refused", Cluster(8, 4, 16, 8), [](Cluster& c) {
        c.data.cluster_probes[2] = 4, c.data.clusters[0].w = 9;
    }));
    out.push_back(lightmap("a lone receiver", "its value is in 25 texels", {{4, 4}}, [](int) { return glm::vec4(0.3f, 0.7f, 1.1f, 1); }));
    out.push_back(lightmap("borders of both signs", "means of values that cancel", patch, [](int i) {
        return glm::vec4(i % 2 ? 1.0f : -1.0f, noise(i, 30) - 0.5f, i % 3 ? 1e-3f : 1e3f, 1);
    }));
    out.push_back(lightmap("light of 1e30 W/m2 in borders", "sums of 8", patch, [](int i) { return 1e30f * glm::vec4(noise(i, 31), noise(i, 32), 1, 1); }));
    out.push_back(lightmap("denormal light in borders", "1e-40 W/m2", patch, [](int i) { return 1e-40f * glm::vec4(noise(i, 33), noise(i, 34), 1, 1); }));
}

// The first receivers of a block as clusters, under a light that the coefficients say.
std::vector<StageData> update_data(const probes::Bake& bake, const probes::TracedBlock& block, const RunOptions& options) {
    const int receivers = std::min(block.count, 96), coefficients = bake.coefficients(), slots = block.slots;
    Buffer<float> alpha(std::size_t(block.count) * std::size_t(slots) * std::size_t(coefficients));
    probes::block_coefficients(block, bake.transport, options, alpha.data());
    const probes::TransportRows rows{receivers, slots, coefficients, &bake.receivers.position[std::size_t(block.first)],
                                     &bake.supports.probe[std::size_t(block.first) * std::size_t(slots)], alpha.data()};
    probes::ClusterParams params = probes::cluster_params(bake.params);
    params.most_receivers = 40;
    const probes::ClusterData d = probes::cluster_data(probes::flat(probes::make_clusters(rows, params, options)), receivers, coefficients);
    if (d.clusters.empty()) return {};

    const int probes = int(bake.placement.probes.size());
    const Lights lambda = lights(probes * coefficients, 40);
    const std::vector<std::int32_t> level(d.clusters.size(), 0), receiver_level(std::size_t(receivers), 0);
    const std::vector<glm::ivec2> texels(bake.receivers.texel.begin() + block.first, bake.receivers.texel.begin() + block.first + receivers);
    const Image<std::int32_t> cover = probes::lightmap_cover(texels, d.place_of, bake.receivers.size.x, 2);
    Lights basis, irradiance;
    probes::BasisInputs of_basis;
    of_basis.clusters = &d, of_basis.cluster_level = level.data(), of_basis.lambda = lambda.data(), of_basis.probes = probes;
    probes::run(of_basis, options, basis);
    const probes::IrradianceInputs of_irradiance{&d, level.data(), receiver_level.data(), basis.data()};
    probes::run(of_irradiance, options, irradiance);
    return {owned(stage<probes::BasisKernel>(), probes::data_of(of_basis)),
            owned(stage<probes::IrradianceKernel>(), probes::data_of(of_irradiance)),
            owned(stage<probes::LightmapKernel>(), probes::data_of(probes::LightmapInputs{&cover, irradiance.data(), receivers}))};
}

}  // namespace plumb::stability
