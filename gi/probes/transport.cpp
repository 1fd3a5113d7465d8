#include "gi/probes/transport.h"

#include <mutex>

#include "core/parallel.h"
#include "core/sh.h"
#include "gi/lend.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/receiver_rays.h"
#include "gi/probes/share.h"

namespace plumb::probes {

namespace {

// Rays of one band: all receivers of the block along a few directions, so that packets stay together.
constexpr int band = 8;

void lend_supporting(const TransportScene& scene, const Supports& supports, TracedBlock& block) {
    block.supporting.assign(std::size_t(block.slots) * std::size_t(block.count), glm::vec4(0));
    for (int slot = 0; slot < block.slots; ++slot)
        for (int i = 0; i < block.count; ++i) {
            const std::size_t at = std::size_t(block.first + i) * std::size_t(supports.overlaps) + std::size_t(slot);
            const std::int32_t probe = supports.probe[at];
            if (probe < 0) continue;
            block.supporting[std::size_t(slot) * std::size_t(block.count) + std::size_t(i)] =
                glm::vec4(glm::vec3((*scene.probes)[std::size_t(probe)]), supports.weight[at]);
        }
}

void trace(const TransportScene& scene, const TransportParams& params, const Receivers& receivers, const RunOptions& options,
           TracedBlock& block) {
    ReceiverRaysView view{};
    view.surfaces = scene.surfaces;
    view.width = block.count, view.slots = block.slots;
    view.escape = int(params.escape), view.offset = scene.offset;
    view.position = &receivers.position[std::size_t(block.first)].x;
    view.normal = &receivers.normal[std::size_t(block.first)].x;
    view.directions = &scene.directions[0].x;
    view.supporting = &block.supporting[0].x;
    if (!block.normals.empty()) view.normals = &block.normals[0].x;
    view.seen = &block.seen[0].x, view.visible = block.visible.data(), view.lengths = block.lengths.data();
    std::mutex mutex;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(block.rays, band, options, [&](int first, int last) {
            const RayCounts counts = ReceiverRays<isa()>::trace(view, *scene.query, first, last);
            const std::lock_guard lock(mutex);
            block.counts.traced += counts.traced, block.counts.escaped += counts.escaped;
            block.counts.back += counts.back, block.counts.unseen += counts.unseen;
        });
    });
}

}  // namespace

TracedBlock trace_block(const TransportScene& scene, const TransportParams& params, const Receivers& receivers,
                        const Supports& supports, int first, int count, const RunOptions& options) {
    TracedBlock block;
    block.first = first, block.count = count;
    block.rays = int(scene.directions.size()), block.slots = supports.overlaps;
    const std::size_t pairs = std::size_t(block.rays) * std::size_t(count);
    block.factors = scene.factors;
    block.seen.resize(pairs), block.visible.resize(pairs), block.lengths.resize(pairs), block.shares.resize(pairs);
    if (params.fitted) block.normals.resize(pairs);
    lend_supporting(scene, supports, block);
    trace(scene, params, receivers, options, block);
    ShareInputs in;
    in.receivers = count, in.rays = block.rays, in.slots = block.slots, in.published = params.published_weight;
    in.supporting = block.supporting.data(), in.factors = scene.factors.data();
    in.visible = block.visible.data(), in.lengths = block.lengths.data();
    run(stage<ShareKernel>(), data_of(in), options, block.shares.data());
    return block;
}

void block_coefficients(const TracedBlock& block, const TransportParams& params, const RunOptions& options, float* alpha) {
    const std::vector<std::int32_t> rows = coefficient_rows(block.slots, params.degree);
    CoefficientsInputs in;
    in.receivers = block.count, in.rays = block.rays, in.slots = block.slots, in.degree = params.degree;
    in.rows = rows.data(), in.supporting = block.supporting.data(), in.seen = block.seen.data();
    in.visible = block.visible.data(), in.shares = block.shares.data();
    const int all = block.slots * sh::count(params.degree);
    Buffer<float> by_row(std::size_t(all) * std::size_t(block.count));
    run(stage<CoefficientsKernel>(), data_of(in), options, by_row.data());
    for (int i = 0; i < block.count; ++i)
        for (int row = 0; row < all; ++row)
            alpha[std::size_t(i) * std::size_t(all) + std::size_t(row)] =
                by_row[std::size_t(row) * std::size_t(block.count) + std::size_t(i)];
}

std::vector<glm::dvec3> probe_coefficients(const std::vector<glm::dvec3>& radiance, int probes, const Buffer<float>& weights,
                                           const Buffer<float>& harmonics, int degree) {
    const std::size_t count = std::size_t(sh::count(degree)), rays = weights.size();
    std::vector<glm::dvec3> lambda(std::size_t(probes) * count, glm::dvec3(0));
    for (int p = 0; p < probes; ++p)
        for (std::size_t r = 0; r < rays; ++r)
            for (std::size_t j = 0; j < count; ++j)
                lambda[std::size_t(p) * count + j] += double(weights[r]) * double(harmonics[r * count + j]) *
                                                      radiance[std::size_t(p) * rays + r];
    return lambda;
}

std::vector<glm::dvec3> irradiance(const Supports& supports, const Buffer<float>& alpha, int degree,
                                   const std::vector<glm::dvec3>& lambda) {
    const std::size_t count = std::size_t(sh::count(degree)), slots = std::size_t(supports.overlaps);
    std::vector<glm::dvec3> e(supports.probe.size() / slots, glm::dvec3(0));
    for (std::size_t i = 0; i < e.size(); ++i)
        for (std::size_t s = 0; s < slots; ++s) {
            const std::int32_t probe = supports.probe[i * slots + s];
            if (probe < 0) continue;
            for (std::size_t j = 0; j < count; ++j)
                e[i] += double(alpha[(i * slots + s) * count + j]) * lambda[std::size_t(probe) * count + j];
        }
    return e;
}

}  // namespace plumb::probes
