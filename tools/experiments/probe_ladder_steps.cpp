// plumb experiment probe-ladder: the transport in double, and the steps between truth and what the run time shows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "gi/probes/fit.h"
#include "gi/probes/sky_probe.h"
#include "tools/experiments/probe_ladder.h"

namespace plumb::cli {

namespace {

constexpr std::size_t all_harmonics = sh::max_count;

struct ReceiverSums {
    const CheckedReceivers& checked;
    const probes::TracedBlock& block;
    const Buffer<float>& factors;
    LadderTransport& out;

    // Sums over all rays of receiver i of the block.
    void operator()(int i) const {
        const std::size_t at = std::size_t(block.first + i), slots = std::size_t(block.slots), count = std::size_t(block.count);
        double* alpha = out.alpha.data() + at * slots * all_harmonics;
        for (std::size_t k = 0; k < std::size_t(block.rays); ++k) {
            const std::size_t pair = k * count + std::size_t(i);
            const double radiance = double(checked.radiance[at * std::size_t(checked.rays) + k]);
            out.rays[at] += double(factors[k]) * radiance;
            const std::int32_t visible = block.visible[pair];
            for (std::size_t s = 0; s < slots; ++s) {
                if (!(visible >> s & 1)) continue;
                const glm::dvec4 probe(block.supporting[s * count + std::size_t(i)]), seen(block.seen[pair]);
                const double weight = double(block.shares[pair]) * probe.w;
                const glm::dvec3 d = glm::dvec3(seen) - seen.w * glm::dvec3(probe);
                const sh::Values y = sh::basis(d / std::max(std::sqrt(glm::dot(d, d)), 1e-18));
                for (std::size_t j = 0; j < all_harmonics; ++j) alpha[s * all_harmonics + j] += weight * y[j];
                out.unseen[at] += weight * radiance;
            }
        }
    }
};

void put_fit(probes::Fit& fit, const probes::TracedBlock& block, const probes::TransportParams& params, const RunOptions& options,
             LadderTransport& out) {
    const std::size_t coefficients = std::size_t(sh::count(params.degree)), slots = std::size_t(block.slots);
    std::vector<float> alpha(std::size_t(block.count) * slots * coefficients);
    probes::block_coefficients(block, params, options, alpha.data());
    fit.coefficients(block, out.supports, options, alpha.data());
    for (std::size_t row = 0; row < std::size_t(block.count) * slots; ++row)
        for (std::size_t j = 0; j < all_harmonics; ++j)
            out.alpha[(std::size_t(block.first) * slots + row) * all_harmonics + j] = j < coefficients ? double(alpha[row * coefficients + j]) : 0;
}

}  // namespace

LadderTransport transport_in_double(const LadderWorld& world, const CheckedReceivers& checked, const Buffer<glm::vec4>& probes,
                                    double radius_m, int overlaps, const probes::TransportParams& params,
                                    const RunOptions& options) {
    if (params.rays > checked.rays) throw std::logic_error("probe_ladder: more rays than have a radiance");
    LadderTransport t;
    probes::SupportsInputs in;
    in.receivers = &checked.receivers.position, in.probes = &probes;
    in.radius = float(radius_m), in.overlaps = overlaps;
    t.supports = probes::run(in, options);
    probes::add_sky(t.supports, probes);
    const std::size_t n = std::size_t(checked.count());
    t.rays.assign(n, 0), t.unseen.assign(n, 0);
    t.alpha.assign(n * std::size_t(t.supports.overlaps) * all_harmonics, 0);

    probes::TransportScene scene;
    scene.surfaces = world.args(), scene.query = world.query.get(), scene.offset = world.offset, scene.probes = &probes;
    scene.directions = probes::receiver_directions(params.rays, params.distribution);
    scene.factors = probes::ray_factors(scene.directions, params.distribution);
    // A fit is of floats, as the bake has it, and of its degree alone.
    std::unique_ptr<probes::Fit> fit;
    if (params.fitted) fit = std::make_unique<probes::Fit>(scene, params, radius_m, options);
    constexpr int block_size = 256;
    for (int first = 0; first < checked.count(); first += block_size) {
        const int count = std::min(block_size, checked.count() - first);
        const probes::TracedBlock block =
            probes::trace_block(scene, params, checked.receivers, t.supports, first, count, options);
        const ReceiverSums sums{checked, block, scene.factors, t};
        parallel_bands(count, 4, options, [&](int from, int to) {
            for (int i = from; i < to; ++i) sums(i);
        });
        if (fit) put_fit(*fit, block, params, options, t);
    }
    return t;
}

// ---- Coefficients of probes -------------------------------------------------------------------------------------------

Buffer<float> equal_weights(int n) { return Buffer<float>(std::size_t(n), float(4 * host::pi / n)); }

std::vector<double> lambda_in_double(const ProbeLight& light, const Buffer<float>& weights, const RunOptions& options) {
    std::vector<double> lambda(std::size_t(light.probes) * all_harmonics, 0);
    parallel_bands(light.probes, 1, options, [&](int first, int last) {
        for (std::size_t p = std::size_t(first); p < std::size_t(last); ++p)
            for (std::size_t r = 0; r < weights.size(); ++r) {
                const double f = double(weights[r]) * double(light.radiance[p * std::size_t(light.rays()) + r]);
                for (std::size_t j = 0; j < all_harmonics; ++j)
                    lambda[p * all_harmonics + j] += f * light.harmonics[r * all_harmonics + j];
            }
    });
    return lambda;
}

std::vector<float> lambda_in_float(const ProbeLight& light, const Buffer<float>& weights, int degree,
                                   const RunOptions& options) {
    const std::size_t count = std::size_t(sh::count(degree));
    std::vector<float> lambda(std::size_t(light.probes) * count, 0);
    parallel_bands(light.probes, 1, options, [&](int first, int last) {
        for (std::size_t p = std::size_t(first); p < std::size_t(last); ++p)
            for (std::size_t r = 0; r < weights.size(); ++r) {
                const float f = weights[r] * light.radiance[p * std::size_t(light.rays()) + r];
                for (std::size_t j = 0; j < count; ++j)
                    lambda[p * count + j] += f * float(light.harmonics[r * all_harmonics + j]);
            }
    });
    return lambda;
}

// ---- Through clusters -------------------------------------------------------------------------------------------------

namespace {

// I = U (Sigma V^T lambda), IPR 3.3.1.2 and 3.3.1.3, in numbers of type T; `stride`: coefficients of a probe in lambda.
template <class T>
std::vector<T> clustered(const probes::Bake& bake, const std::vector<T>& lambda, std::size_t stride, int kept) {
    std::vector<T> irradiance(std::size_t(bake.receivers.count()), T(0));
    const std::size_t count = std::size_t(bake.coefficients()), values = std::size_t(bake.clusters.singular_values);
    for (const probes::Cluster& c : bake.clusters.clusters) {
        std::vector<T> basis(std::size_t(std::min(c.rank, kept)), T(0));
        for (std::size_t k = 0; k < basis.size(); ++k)
            for (std::size_t p = 0; p < c.probes.size(); ++p)
                for (std::size_t j = 0; j < count; ++j)
                    basis[k] +=
                        T(c.sigma_vt[(k * c.probes.size() + p) * count + j]) * lambda[std::size_t(c.probes[p]) * stride + j];
        for (const std::int32_t i : c.receivers) {
            T sum(0);
            for (std::size_t k = 0; k < basis.size(); ++k) sum += T(bake.clusters.u[std::size_t(i) * values + k]) * basis[k];
            irradiance[std::size_t(i)] = sum;
        }
    }
    return irradiance;
}

}  // namespace

std::vector<double> clustered_in_double(const probes::Bake& bake, const std::vector<double>& lambda, int kept) {
    return clustered<double>(bake, lambda, all_harmonics, kept);
}

std::vector<float> clustered_in_float(const probes::Bake& bake, const std::vector<float>& lambda) {
    return clustered<float>(bake, lambda, std::size_t(bake.coefficients()), std::numeric_limits<int>::max());
}

// ---- Steps ------------------------------------------------------------------------------------------------------------

namespace {

// Sum over slots and coefficients of alpha lambda, alpha [slot][stride].
template <class T>
double gathered(const std::int32_t* support, std::size_t slots, const T* alpha, std::size_t stride,
                const std::vector<double>& lambda, std::size_t count) {
    double sum = 0;
    for (std::size_t s = 0; s < slots; ++s) {
        if (support[s] < 0) continue;
        for (std::size_t j = 0; j < count; ++j)
            sum += double(alpha[s * stride + j]) * lambda[std::size_t(support[s]) * all_harmonics + j];
    }
    return sum;
}

}  // namespace

LadderSteps steps_of(const CheckedReceivers& checked, const LadderTransport& transport, const probes::Bake& bake,
                     const std::vector<double>& many, const std::vector<double>& lambda, const std::vector<float>& rounded) {
    const std::size_t n = std::size_t(checked.count()), count = std::size_t(bake.coefficients());
    const std::size_t slots = std::size_t(transport.supports.overlaps);
    const std::vector<double> truncated = clustered_in_double(bake, lambda, std::numeric_limits<int>::max());
    const std::vector<float> shown = clustered_in_float(bake, rounded);
    LadderSteps steps;
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t at = std::size_t(checked.index[i]);
        const std::int32_t* support = transport.supports.probe.data() + i * slots;
        const double* alpha = transport.alpha.data() + i * slots * all_harmonics;
        const double degree = gathered(support, slots, alpha, all_harmonics, many, count);
        const double relight = gathered(support, slots, alpha, all_harmonics, lambda, count);
        const double stored = gathered(support, slots, bake.alpha.data() + at * slots * count, count, lambda, count);
        steps.value.push_back(double(shown[at]));
        steps.added[step_rays].push_back(transport.rays[i] - checked.truth[i]);
        steps.added[step_unseen].push_back(transport.unseen[i] - transport.rays[i]);
        steps.added[step_degree].push_back(degree - transport.unseen[i]);
        steps.added[step_relight].push_back(relight - degree);
        steps.added[step_truncation].push_back(truncated[at] - stored);
        steps.added[step_rounding].push_back(stored - relight + double(shown[at]) - truncated[at]);
    }
    return steps;
}

// ---- Errors -----------------------------------------------------------------------------------------------------------

double CheckedReceivers::mean() const {
    double sum = 0;
    for (const double e : truth) sum += e;
    return sum / double(truth.size());
}

double relative_rms(const CheckedReceivers& checked, const std::vector<double>& difference) {
    double sum = 0;
    for (const double d : difference) sum += d * d;
    return std::sqrt(sum / double(difference.size())) / checked.mean();
}

double local_rms(const CheckedReceivers& checked, const std::vector<double>& difference) {
    const double mean = checked.mean();
    double sum = 0;
    for (std::size_t i = 0; i < difference.size(); ++i) {
        const double d = difference[i] / (checked.truth[i] + mean);
        sum += d * d;
    }
    return std::sqrt(sum / double(difference.size()));
}

double CheckedReceivers::relative_uncertainty() const { return local_rms(*this, uncertainty); }

LadderErrors errors_of(const CheckedReceivers& checked, const LadderSteps& steps) {
    const double mean = checked.mean(), n = double(checked.count());
    if (!(mean > 0))
        throw InputError("probe-ladder: no light reaches any receiver: the scene has no lamp, no sky, nothing that emits");
    LadderErrors e;
    std::vector<double> difference, magnitude;
    double lit = 0, black = 0;
    for (std::size_t i = 0; i < checked.truth.size(); ++i) {
        const double truth = checked.truth[i];
        if (!std::isfinite(steps.value[i]) || !std::isfinite(truth))
            throw InputError("probe-ladder: an irradiance is not finite");
        difference.push_back(steps.value[i] - truth);
        magnitude.push_back(std::fabs(difference.back()) / mean);
        e.bias += difference.back() / mean / n;
        if (!(truth > 0.01 * mean)) continue;
        ++lit;
        black += steps.value[i] < 0.01 * truth ? 1 : 0;
    }
    e.rms = relative_rms(checked, difference), e.local = local_rms(checked, difference);
    e.black = lit > 0 ? black / lit : 0;
    std::sort(magnitude.begin(), magnitude.end());
    e.p95 = magnitude[std::min(magnitude.size() - 1, magnitude.size() * 95 / 100)];
    for (std::size_t s = 0; s < ladder_steps; ++s) {
        e.step_rms[s] = relative_rms(checked, steps.added[s]), e.step_local[s] = local_rms(checked, steps.added[s]);
        for (const double d : steps.added[s]) e.step_bias[s] += d / mean / n;
    }
    return e;
}

// ---- Lightmaps of other sizes -----------------------------------------------------------------------------------------

namespace {

// Barycentrics of the second and third corner; the point lies in the triangle's plane, but for rounding.
glm::dvec2 barycentrics_of(const Geometry& geometry, int triangle, const glm::dvec3& point) {
    const glm::uvec3 corner = geometry.triangles[std::size_t(triangle)];
    const glm::dvec3 a(geometry.vertices[corner.x].position), u = glm::dvec3(geometry.vertices[corner.y].position) - a,
                                                              v = glm::dvec3(geometry.vertices[corner.z].position) - a,
                                                              p = point - a;
    const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), pu = glm::dot(p, u), pv = glm::dot(p, v);
    const double area2 = uu * vv - uv * uv;
    if (!(area2 > 0)) return glm::dvec2(0);
    return {(vv * pu - uv * pv) / area2, (uu * pv - uv * pu) / area2};
}

double bilinear(const Image4& lightmap, const glm::dvec2& uv) {
    const double x = uv.x * lightmap.width - 0.5, y = uv.y * lightmap.height - 0.5;
    const int left = int(std::floor(x)), top = int(std::floor(y));
    double sum = 0;
    for (int dy = 0; dy <= 1; ++dy)
        for (int dx = 0; dx <= 1; ++dx) {
            const int tx = std::clamp(left + dx, 0, lightmap.width - 1), ty = std::clamp(top + dy, 0, lightmap.height - 1);
            sum += (dx ? x - left : left + 1 - x) * (dy ? y - top : top + 1 - y) * double(lightmap(tx, ty).x);
        }
    return sum;
}

}  // namespace

std::vector<double> looked_up(const LadderWorld& world, const probes::Bake& bake, const std::vector<float>& irradiance,
                              const probes::Receivers& at) {
    Buffer<glm::vec4> values;
    for (const float e : irradiance) values.push_back(glm::vec4(e, 0, 0, 1));
    const Image4 lightmap = probes::extend_borders(bake.receivers, probes::scatter(bake.receivers, values));
    std::vector<double> found;
    for (std::size_t i = 0; i < std::size_t(at.count()); ++i) {
        const int triangle = at.triangle[i];
        // Where the receiver lies on the surface, not where it was moved to.
        const glm::dvec3 point = glm::dvec3(at.position[i]) - glm::dvec3(at.shift[i]);
        const glm::dvec2 l = barycentrics_of(world.geometry, triangle, point);
        const glm::uvec3 corner = bake.atlas.geometry.triangles[std::size_t(triangle)];
        const glm::dvec2 a(bake.atlas.uv[corner.x]), b(bake.atlas.uv[corner.y]), c(bake.atlas.uv[corner.z]);
        found.push_back(bilinear(lightmap, a + l.x * (b - a) + l.y * (c - a)));
    }
    return found;
}

}  // namespace plumb::cli
