#include "gi/probes/fit.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/parallel.h"
#include "core/sh.h"
#include "gi/probes/fit_loops.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/stand_in.h"
#include "gi/probes/svd_loops.h"

namespace plumb::probes {

namespace {

constexpr double nugget = 0x1p-7;  // of the mean of the diagonal: what the prior does not know
constexpr int least_share = 4;     // a probe is asked that sees at least 1 / 4 of what the one sees that sees most

int padded_points(std::size_t n) { return int((n + fit_lanes - 1) / fit_lanes * fit_lanes); }

}  // namespace

// What a probe's rays met that receivers ask for, each place once.
struct Fit::Probe {
    std::vector<FitPoint> points;
    Buffer<float> columns;   // [6][padded]: positions and normals, 0 beyond the points
    Buffer<double> weights;  // [point][coefficients, padded]: W, the sum over the rays that tell of it of w_r Y_j(r)
    Buffer<double> constant; // [coefficients]: W^T 1
    int padded = 0;

    FitPoints view() const {
        const float* c = columns.data();
        return {c, c + padded, c + 2 * padded, c + 3 * padded, c + 4 * padded, c + 5 * padded, padded};
    }
};

namespace {

// Hits of all probes: [probe][ray].
struct ProbeHits {
    std::vector<std::uint8_t> asked;
    std::vector<FitPoint> at;
};

ProbeHits trace_probes(const TransportScene& scene, const Buffer<glm::vec4>& directions, const RunOptions& options) {
    const Buffer<glm::vec4>& probes = *scene.probes;
    ProbeHits hits;
    hits.asked.assign(probes.size() * directions.size(), 0), hits.at.resize(hits.asked.size());
    parallel_bands(int(probes.size()), 1, options, [&](int first, int last) {
        RayTracer<float> tracer(*scene.query);
        for (int p = first; p < last; ++p) {
            if (is_sky(probes[std::size_t(p)])) continue;
            for (std::size_t r = 0; r < directions.size(); ++r) {
                const glm::vec3 direction(directions[r]);
                const RayHit<float> hit = tracer.nearest(glm::vec3(probes[std::size_t(p)]), direction, true);
                if (!hit.found) continue;
                const Met<float> met = met_by<float>(scene.surfaces, hit, direction);
                const std::size_t at = std::size_t(p) * directions.size() + r;
                hits.asked[at] = met.front ? 1 : 0;
                hits.at[at] = {met.point.x, met.point.y, met.point.z, met.normal.x, met.normal.y, met.normal.z, 1};
            }
        }
    });
    return hits;
}

}  // namespace

Fit::Fit(const TransportScene& scene, const TransportParams& params, double range_m, const RunOptions& options)
    : coefficients_(sh::count(params.degree)), scale_(float(1 / range_m)),
      sky_(standing_probes(*scene.probes) < int(scene.probes->size()) ? int(scene.probes->size()) - 1 : -2), probes_(scene.probes->size()) {
    const Buffer<glm::vec4> directions = relight_directions(params.relight_rays);
    const Buffer<float> weights = relight_weights(directions, params.relight_rays), harmonics = harmonics_of(directions, params.degree);
    const ProbeHits hits = trace_probes(scene, directions, options);
    const std::vector<std::int32_t> ray_of = stand_ins(directions, hits.asked, options);
    const std::size_t rays = directions.size(), count = std::size_t(coefficients_), stride = std::size_t(padded(coefficients_));
    parallel_bands(int(probes_.size()), 1, options, [&](int first, int last) {
        for (std::size_t p = std::size_t(first); p < std::size_t(last); ++p) {
            Probe& probe = probes_[p];
            std::vector<std::int32_t> place(rays, -1);
            probe.constant.assign(count, 0);
            for (std::size_t r = 0; r < rays; ++r) {
                const std::size_t of = std::size_t(ray_of[p * rays + r]);
                if (!hits.asked[of]) continue;
                std::int32_t& at = place[of - p * rays];
                if (at < 0) {
                    at = std::int32_t(probe.points.size());
                    probe.points.push_back(hits.at[of]);
                    probe.weights.resize(probe.points.size() * stride, 0);
                }
                for (std::size_t j = 0; j < count; ++j) {
                    const double w = double(weights[r]) * double(harmonics[r * count + j]);
                    probe.weights[std::size_t(at) * stride + j] += w, probe.constant[j] += w;
                }
            }
            probe.padded = padded_points(probe.points.size());
            probe.columns.assign(6 * std::size_t(probe.padded), 0);
            for (std::size_t i = 0; i < probe.points.size(); ++i) {
                const FitPoint& x = probe.points[i];
                const float values[6] = {x.x, x.y, x.z, x.nx, x.ny, x.nz};
                for (std::size_t c = 0; c < 6; ++c) probe.columns[c * std::size_t(probe.padded) + i] = values[c];
            }
        }
    });
}

Fit::~Fit() = default;

// W_a^T C W_b.
Buffer<double> Fit::products(const Probe& a, const Probe& b, Isa isa) const {
    const std::size_t stride = std::size_t(padded(coefficients_)), na = std::size_t(a.padded);
    Buffer<double> covariance(b.points.size() * na), half(na * stride, 0), product(stride * stride, 0);
    Buffer<float> row(na);
    dispatch(isa, [&](auto set) {
        constexpr Isa own = decltype(set)::value;
        for (std::size_t k = 0; k < b.points.size(); ++k) {
            FitLoops<own>::covariances(a.view(), &b.points[k], 1, scale_, row.data());
            for (std::size_t i = 0; i < a.points.size(); ++i) covariance[k * na + i] = double(row[i]);
        }
        MatrixLoops<own>::add_product(covariance.data(), int(na), b.weights.data(), int(stride), int(b.points.size()), nullptr, half.data(), int(stride));
        MatrixLoops<own>::add_product(a.weights.data(), int(stride), half.data(), int(stride), int(a.points.size()), nullptr, product.data(), int(stride));
    });
    return product;
}

// The slots of probes that are asked: of those that stand, whose bits say that they see enough.
std::vector<int> Fit::asked_slots(const TracedBlock& block, int receiver) const {
    std::vector<int> seen(std::size_t(block.slots), 0), slots;
    for (int k = 0; k < block.rays; ++k) {
        const std::size_t at = std::size_t(k) * std::size_t(block.count) + std::size_t(receiver);
        if (block.seen[at].w == 0) continue;
        for (int s = 0; s < block.slots; ++s) seen[std::size_t(s)] += block.visible[at] >> s & 1;
    }
    const int most = *std::max_element(seen.begin(), seen.end());
    for (int s = 0; s < block.slots; ++s)
        if (seen[std::size_t(s)] > 0 && least_share * seen[std::size_t(s)] >= most) slots.push_back(s);
    return slots;
}

// Makes the products of all pairs in these sets of probes, which ascend, and forgets the others: blocks side by side share most.
void Fit::prepare(const std::vector<Group>& groups, const RunOptions& options) {
    std::set<std::pair<int, int>> wanted;
    for (const auto& [set, receivers] : groups)
        for (std::size_t i = 0; i < set.size(); ++i)
            for (std::size_t j = i; j < set.size(); ++j) wanted.insert({set[i], set[j]});
    for (auto at = products_.begin(); at != products_.end();) at = wanted.erase(at->first) ? std::next(at) : products_.erase(at);
    const std::vector<std::pair<int, int>> pairs(wanted.begin(), wanted.end());
    std::vector<Buffer<double>> made(pairs.size());
    parallel_bands(int(pairs.size()), 1, options, [&](int first, int last) {
        for (std::size_t i = std::size_t(first); i < std::size_t(last); ++i)
            made[i] = products(probes_[std::size_t(pairs[i].first)], probes_[std::size_t(pairs[i].second)], options.isa);
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) products_.emplace(pairs[i], std::move(made[i]));
}

// Of one set of probes: the Cholesky factor of its matrix, and what the constraint adds.
struct Fit::Solver {
    int size = 0, stride = 0;
    Buffer<double> lower;             // [size][stride], 0 above the diagonal
    Buffer<double> constant, answer;  // W^T 1, and what solves for it
    double share = 0;                 // constant . answer

    template <Isa isa>
    void factor(const Buffer<double>& matrix) {
        lower.assign(std::size_t(size) * std::size_t(stride), 0);
        for (int i = 0; i < size; ++i) {
            double* row = lower.data() + std::size_t(i) * std::size_t(stride);
            for (int j = 0; j <= i; ++j) {
                const double* of = lower.data() + std::size_t(j) * std::size_t(stride);
                const double rest = matrix[std::size_t(i) * std::size_t(stride) + std::size_t(j)] - MatrixLoops<isa>::dot(row, of, padded(j));
                row[j] = j < i ? rest / of[j] : std::sqrt(rest);
            }
        }
    }
    // Solves in place; x is padded with zeros.
    template <Isa isa>
    void solve(double* x) const {
        Buffer<double> y(std::size_t(stride), 0);
        for (int i = 0; i < size; ++i) {
            const double* row = lower.data() + std::size_t(i) * std::size_t(stride);
            y[std::size_t(i)] = (x[i] - MatrixLoops<isa>::dot(row, y.data(), padded(i))) / row[i];
        }
        for (int i = size - 1; i >= 0; --i) {
            const double* row = lower.data() + std::size_t(i) * std::size_t(stride);
            x[i] = y[std::size_t(i)] / row[i];
            MatrixLoops<isa>::add_scaled(y.data(), -x[i], row, padded(i));
        }
    }
};

// Of probes that ascend; share stays 0 where they have met nothing.
Fit::Solver Fit::solver_of(const std::vector<int>& set, Isa isa) const {
    const std::size_t count = std::size_t(coefficients_), stride = std::size_t(padded(coefficients_));
    Solver solver;
    solver.size = int(set.size() * count), solver.stride = padded(solver.size);
    Buffer<double> matrix(std::size_t(solver.size) * std::size_t(solver.stride), 0);
    solver.constant.assign(std::size_t(solver.stride), 0);
    double trace = 0;
    for (std::size_t a = 0; a < set.size(); ++a)
        for (std::size_t i = 0; i < count; ++i) {
            solver.constant[a * count + i] = probes_[std::size_t(set[a])].constant[i];
            double* row = matrix.data() + (a * count + i) * std::size_t(solver.stride);
            for (std::size_t b = 0; b <= a; ++b) {
                const Buffer<double>& product = products_.at({set[b], set[a]});
                for (std::size_t j = 0; j < count; ++j) row[b * count + j] = product[j * stride + i];
            }
            trace += row[a * count + i];
        }
    if (!(trace > 0)) return solver;
    for (std::size_t i = 0; i < std::size_t(solver.size); ++i) matrix[i * std::size_t(solver.stride) + i] += nugget * trace / solver.size;
    solver.answer = solver.constant;
    dispatch(isa, [&](auto instructions) {
        constexpr Isa own = decltype(instructions)::value;
        solver.template factor<own>(matrix);
        solver.template solve<own>(solver.answer.data());
        solver.share = MatrixLoops<own>::dot(solver.constant.data(), solver.answer.data(), solver.stride);
    });
    return solver;
}

// Of one receiver: what its rays met, and the coefficients of the probes that it asks, one after the other.
Buffer<double> Fit::fitted(const TracedBlock& block, int receiver, const Asked& asked, const Solver& solver, Isa isa) const {
    std::vector<FitPoint> points;
    double told = 0;
    for (std::size_t k = 0; k < std::size_t(block.rays); ++k) {
        const std::size_t at = k * std::size_t(block.count) + std::size_t(receiver);
        if (block.seen[at].w == 0 || block.visible[at] == 0) continue;
        const glm::vec4 x = block.seen[at], n = block.normals[at];
        points.push_back({x.x, x.y, x.z, n.x, n.y, n.z, block.factors[k]});
        told += double(block.factors[k]);
    }
    const std::size_t count = std::size_t(coefficients_), stride = std::size_t(padded(coefficients_));
    Buffer<double> x(std::size_t(solver.stride), 0);
    dispatch(isa, [&](auto instructions) {
        constexpr Isa own = decltype(instructions)::value;
        for (std::size_t a = 0; a < asked.size(); ++a) {
            const Probe& probe = probes_[std::size_t(asked[a].probe)];
            Buffer<float> covariance(std::size_t(probe.padded));
            Buffer<double> sum(stride, 0);
            FitLoops<own>::covariances(probe.view(), points.data(), int(points.size()), scale_, covariance.data());
            for (std::size_t h = 0; h < probe.points.size(); ++h)
                MatrixLoops<own>::add_scaled(sum.data(), double(covariance[h]), probe.weights.data() + h * stride, int(stride));
            std::copy_n(sum.begin(), count, x.begin() + std::ptrdiff_t(a * count));
        }
        solver.template solve<own>(x.data());
        const double lacking = told - MatrixLoops<own>::dot(solver.constant.data(), x.data(), solver.stride);
        MatrixLoops<own>::add_scaled(x.data(), lacking / solver.share, solver.answer.data(), solver.stride);
    });
    return x;
}

void Fit::coefficients(const TracedBlock& block, const Supports& supports, const RunOptions& options, float* alpha) {
    const std::size_t slots = std::size_t(block.slots), count = std::size_t(coefficients_);
    const auto probe_of = [&](int receiver, std::size_t slot) { return supports.probe[std::size_t(block.first + receiver) * slots + slot]; };
    std::vector<Asked> asked(std::size_t(block.count));
    parallel_bands(block.count, 16, options, [&](int first, int last) {
        for (int i = first; i < last; ++i) {
            Asked& own = asked[std::size_t(i)];
            for (const int s : asked_slots(block, i)) own.push_back({probe_of(i, std::size_t(s)), s});
            std::sort(own.begin(), own.end(), [](const AskedProbe& a, const AskedProbe& b) { return a.probe < b.probe; });
        }
    });
    // Receivers that ask the same probes share what is solved.
    std::map<std::vector<int>, std::vector<int>> receivers_of;
    for (std::size_t i = 0; i < asked.size(); ++i) {
        std::vector<int> set;
        for (const AskedProbe& a : asked[i]) set.push_back(a.probe);
        if (!set.empty()) receivers_of[set].push_back(int(i));
    }
    const std::vector<Group> groups(receivers_of.begin(), receivers_of.end());
    prepare(groups, options);
    parallel_bands(int(groups.size()), 1, options, [&](int first, int last) {
        for (int g = first; g < last; ++g) {
            const auto& [set, receivers] = groups[std::size_t(g)];
            const Solver solver = solver_of(set, options.isa);
            if (!(solver.share > 0)) continue;
            for (const int i : receivers) {
                const Asked& own = asked[std::size_t(i)];
                const Buffer<double> x = fitted(block, i, own, solver, options.isa);
                float* row = alpha + std::size_t(i) * slots * count;
                for (std::size_t s = 0; s < slots; ++s)
                    if (probe_of(i, s) != sky_) std::fill_n(row + s * count, count, 0.0f);
                for (std::size_t a = 0; a < own.size(); ++a)
                    for (std::size_t j = 0; j < count; ++j) row[std::size_t(own[a].slot) * count + j] = float(x[a * count + j]);
            }
        }
    });
}

}  // namespace plumb::probes
