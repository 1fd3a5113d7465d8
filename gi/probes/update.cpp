#include "gi/probes/update.h"

#include <algorithm>

#include "gi/lend.h"

namespace plumb::probes {

namespace {

constexpr int fold = 1024;  // places in a row: a list of any length, and a device's 65535 groups a side

glm::ivec4 cluster_of(const std::int32_t* clusters, int c) {
    const std::int32_t* p = clusters + 4 * std::ptrdiff_t(c);
    return {p[0], p[1], p[2], p[3]};
}

// The largest that `end` says of a cluster: first number or probe that lies behind it.
template <class End>
std::size_t end_of(const BasisView& v, const char* what, End end) {
    std::int64_t most = 0;
    for (int c = 0; c < v.u.height; ++c) {
        const glm::ivec4 of = cluster_of(v.clusters, c);
        if (of.x < 0 || of.y < 0 || of.z < 0 || of.z > v.u.probes || of.w < 0 || of.w > v.u.width)
            throw InputError(fmt::format("probes.basis: cluster {}: {}, {}, {}, {}: expected two places, at most {} probes and a rank of at most {}",
                                         c, of.x, of.y, of.z, of.w, v.u.probes, v.u.width));
        most = std::max(most, end(of));
    }
    if (most > 0x7fffffff) throw InputError(fmt::format("probes.basis: {} {}: more than an index of 31 bits reaches", most, what));
    return std::size_t(most);
}

const ClusterData& bound_clusters(const char* stage, const ClusterData* clusters) {
    if (!clusters || clusters->clusters.empty()) throw InputError(fmt::format("{}: no clusters", stage));
    return *clusters;
}

void lend_clusters(StageData& d, const ClusterData& clusters, const std::int32_t* levels) {
    const auto count = std::int64_t(clusters.clusters.size());
    lend(d.inputs, "clusters", {count, 4}, &clusters.clusters[0].x);
    lend(d.inputs, "cluster_level", {count}, levels);
}

// At least one element, for lists that nothing is read of: every device binds some memory.
template <class T>
void lend_list(StageData& d, const char* name, const T* list, std::size_t count) {
    static const T nothing{};
    lend(d.inputs, name, {std::int64_t(std::max<std::size_t>(count, 1))}, count ? list : &nothing);
}

}  // namespace

glm::ivec2 irradiance_size(int places) { return {std::min(places, fold), (places + fold - 1) / fold}; }

std::size_t numbers_of_matrices(const BasisView& v) {
    return end_of(v, "numbers of matrices", [&](const glm::ivec4& of) {
        return of.x + std::int64_t(of.z) * v.u.coefficients * of.w;
    });
}

std::size_t probes_of_clusters(const BasisView& v) {
    return end_of(v, "probes of clusters", [](const glm::ivec4& of) { return std::int64_t(of.y) + of.z; });
}

void check_basis(BasisView& v, Buffer<float>&) {
    for (int c = 0; c < v.u.height; ++c) {
        const glm::ivec4 of = cluster_of(v.clusters, c);
        for (int k = 0; k < of.z; ++k)
            if (const std::int32_t probe = v.cluster_probes[of.y + k]; probe < 0 || probe >= v.u.probes)
                throw InputError(fmt::format("probes.basis: cluster {}: probe {} of {}", c, probe, v.u.probes));
    }
}

void check_irradiance(IrradianceView& v, Buffer<float>&) {
    for (int c = 0; c < v.u.clusters; ++c)
        if (const std::int32_t rank = cluster_of(v.clusters, c).w; rank < 0 || rank > v.u.singular_values)
            throw InputError(fmt::format("probes.irradiance: cluster {}: rank {}: expected 0 to {}", c, rank, v.u.singular_values));
}

StageData data_of(const BasisInputs& in) {
    const ClusterData& c = bound_clusters("probes.basis", in.clusters);
    const auto used = [&](int k) { return std::min(in.coefficients[k], c.coefficients); };
    const BasisUniforms u{c.singular_values, int(c.clusters.size()), c.coefficients, in.probes, used(0), used(1), used(2), used(3)};
    StageData d = begin_data<BasisKernel>({u.width, u.height}, u);
    lend_clusters(d, c, in.cluster_level);
    lend_list(d, "cluster_probes", c.cluster_probes.data(), c.cluster_probes.size());
    lend_list(d, "matrix", c.matrix.data(), c.matrix.size());
    lend(d.inputs, "lambda", {std::int64_t(in.probes) * c.coefficients, 4}, &in.lambda->x);
    return d;
}

StageData data_of(const IrradianceInputs& in) {
    const ClusterData& c = bound_clusters("probes.irradiance", in.clusters);
    const std::int64_t count = c.count(), clusters = std::int64_t(c.clusters.size());
    const glm::ivec2 size = irradiance_size(c.count());
    StageData d = begin_data<IrradianceKernel>(size, IrradianceUniforms{size.x, size.y, c.count(), int(clusters), c.singular_values, {}});
    lend_clusters(d, c, in.cluster_level);
    lend(d.inputs, "cluster", {count}, c.cluster.data());
    lend(d.inputs, "receiver_level", {count}, in.receiver_level);
    lend(d.inputs, "transport", {c.singular_values, count}, c.u.data());
    lend(d.inputs, "basis", {clusters * c.singular_values, 4}, &in.basis->x);
    return d;
}

StageData data_of(const LightmapInputs& in) {
    if (!in.cover || in.cover->empty()) throw InputError("probes.lightmap: no cover");
    const glm::ivec2 size(in.cover->width, in.cover->height);
    StageData d = begin_data<LightmapKernel>(size, LightmapUniforms{size.x, size.y, in.places, 0});
    lend(d.inputs, "cover", {std::int64_t(in.cover->size())}, in.cover->data());
    lend(d.inputs, "irradiance", {in.places, 4}, &in.irradiance->x);
    return d;
}

void run(const BasisInputs& in, const RunOptions& options, Buffer<glm::vec4>& basis) {
    const StageData data = data_of(in);
    basis.resize(std::size_t(data.size.x) * std::size_t(data.size.y));
    run(stage<BasisKernel>(), data, options, &basis[0].x);
}

void run(const IrradianceInputs& in, const RunOptions& options, Buffer<glm::vec4>& irradiance) {
    const StageData data = data_of(in);
    irradiance.resize(std::size_t(data.size.x) * std::size_t(data.size.y));
    run(stage<IrradianceKernel>(), data, options, &irradiance[0].x);
    irradiance.resize(std::size_t(in.clusters->count()));
}

void run(const LightmapInputs& in, const RunOptions& options, Image4& lightmap) {
    run(stage<LightmapKernel>(), data_of(in), options, lightmap);
}

}  // namespace plumb::probes
