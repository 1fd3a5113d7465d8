// Solvers that look at single rows: Gauss and Seidel's passes, and LU.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <Eigen/LU>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/radiosity/solve_problem.h"

namespace plumb::radiosity {

// ---- Gauss and Seidel -----------------------------------------------------------------------------------------------

namespace {

// What the light of [first, last) gives, in ascending order.
glm::dvec3 gathered(const std::vector<float>& row, const Channels& b, int first, int last, glm::dvec3 sum) {
    for (int j = first; j < last; ++j) sum += double(row[j]) * b[j];
    return sum;
}

// One row after the other, each with what those before it have just become. Rows of a block are decoded side by side, as
// is what they gather from all other blocks, which does not change meanwhile; only within the block they wait for each
// other. So the result is that of one thread, which would sum in the same order.
class Sweep {
  public:
    explicit Sweep(Problem& p) : problem_(p), outside_(block), inside_(block) {}

    // The change of each element.
    Channels run(Channels& b) {
        Channels step(b.size());
        for (int first = 0; first < problem_.count; first += block)
            run_block(first, std::min(problem_.count, first + block), b, step);
        problem_.products += 1;
        return step;
    }

  private:
    static constexpr int block = 256, band = 8;
    Problem& problem_;
    Channels outside_;
    std::vector<std::vector<float>> inside_;

    void run_block(int first, int last, Channels& b, Channels& step) {
        parallel_bands(last - first, band, problem_.options.threads, [&](int from, int to) {
            std::vector<float> row;
            for (int k = from; k < to; ++k) {
                problem_.row(first + k, row);
                outside_[k] = gathered(row, b, 0, first, glm::dvec3(0));
                outside_[k] = gathered(row, b, last, problem_.count, outside_[k]);
                inside_[k].assign(row.begin() + first, row.begin() + last);
            }
        });
        for (int i = first; i < last; ++i) {
            const std::vector<float>& row = inside_[i - first];
            glm::dvec3 h = outside_[i - first];
            for (int j = first; j < last; ++j)
                if (j != i) h += double(row[j - first]) * b[j];
            // What it sees of itself is solved for.
            const glm::dvec3 kept = 1.0 - problem_.reflectance[i] * double(row[i - first]);
            if (!(std::min(kept.x, std::min(kept.y, kept.z)) > 0))
                throw InputError(fmt::format("radiosity: element {}: returns all light to itself", i));
            const glm::dvec3 now = (problem_.emission[i] + problem_.reflectance[i] * h) / kept;
            step[i] = now - b[i];
            b[i] = now;
        }
    }
};

}  // namespace

Solution solve_gauss_seidel(Problem& problem, const SolveParams& params) {
    Solution s;
    s.radius = power_iteration(problem, std::min(64, params.most_products));
    s.radiosity.assign(problem.emission.size(), glm::dvec3(0));
    Sweep sweep(problem);
    const auto look = [&] {
        s.residual = relative(problem.norm(problem.residual_of_rows(s.radiosity)), problem.norm(s.radiosity));
        s.error = estimated_error(s.residual, s.radius);
    };
    double hoped = params.tolerance, last = 0;
    bool looked = false;
    std::string why = "all products done";
    while (problem.products < params.most_products) {
        const glm::dvec3 step = problem.norm(sweep.run(s.radiosity)), norm = problem.norm(s.radiosity);
        const double change = relative(step, norm);
        // The residual is what the changes since each row's turn give: less than the changes.
        s.residual = s.radius.value * change;
        s.error = estimated_error(s.residual, s.radius);
        looked = false;
        if (change == 0 || (params.tolerance > 0 && s.error <= hoped)) {
            look(), looked = true;
            hoped *= 0.25;
        }
        s.curve.push_back({problem.products, s.residual, change, s.error, problem.power(s.radiosity)});
        problem.report(s.error, params.tolerance);
        if (looked && s.error <= params.tolerance) break;
        if (change == 0 || (looked && s.error == last)) {
            why = "no pass changes anything";
            break;
        }
        last = looked ? s.error : last;
    }
    if (!looked) look();
    finish(problem, params, why, s);
    s.row_residual = relative(problem.norm(problem.residual(s.radiosity)), problem.norm(s.radiosity));
    return s;
}

// ---- LU -------------------------------------------------------------------------------------------------------------

std::int64_t direct_bytes(int count) { return std::int64_t(count) * count * 8; }

namespace {

using Matrix = Eigen::MatrixXd;

// I - diag(rho) F of a channel.
void fill(const Problem& problem, int channel, Matrix& a) {
    parallel_bands(problem.count, 16, problem.options.threads, [&](int first, int last) {
        std::vector<float> row;
        for (int i = first; i < last; ++i) {
            problem.row(i, row);
            const double rho = problem.reflectance[i][channel];
            for (int j = 0; j < problem.count; ++j) a(i, j) = (i == j ? 1.0 : 0.0) - rho * row[j];
        }
    });
}

bool same_reflectance(const Problem& problem, int a, int b) {
    for (const glm::dvec3& rho : problem.reflectance)
        if (rho[a] != rho[b]) return false;
    return true;
}

}  // namespace

Solution solve_direct(Problem& problem, const SolveParams& params) {
    const std::int64_t needed = direct_bytes(problem.count);
    if (needed > params.most_bytes)
        throw InputError(fmt::format("radiosity: direct: {} elements need {:.4g} GB for their matrix, {:.4g} GB allowed ({} "
                                     "elements): expected another solver, or more memory",
                                     problem.count, 1e-9 * needed, 1e-9 * params.most_bytes,
                                     std::int64_t(std::sqrt(params.most_bytes / 8.0))));
    // Eigen sums in blocks that it fits to the caches of the processor it meets, and its bits with them. These are those
    // of none in particular.
    Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 2 << 20);
    const int n = problem.count;
    Solution s;
    s.radius = power_iteration(problem, std::min(64, params.most_products));
    s.radiosity.assign(std::size_t(n), glm::dvec3(0));
    Matrix a(n, n);
    for (int c = 0; c < 3; ++c) {
        std::vector<int> alike;  // channels of this matrix
        for (int d = c; d < 3; ++d)
            if (same_reflectance(problem, c, d)) alike.push_back(d);
        for (int d = 0; d < c; ++d)
            if (same_reflectance(problem, c, d)) alike.clear();  // done
        if (alike.empty()) continue;
        fill(problem, c, a);
        problem.products += 1;
        const Eigen::PartialPivLU<Eigen::Ref<Matrix>> lu(a);
        Matrix x(n, Eigen::Index(alike.size()));
        for (std::size_t k = 0; k < alike.size(); ++k)
            for (int i = 0; i < n; ++i) x(i, k) = problem.emission[i][alike[k]];
        x = lu.solve(x).eval();
        for (std::size_t k = 0; k < alike.size(); ++k)
            for (int i = 0; i < n; ++i) s.radiosity[i][alike[k]] = x(i, k);
    }
    s.residual = relative(problem.norm(problem.residual_of_rows(s.radiosity)), problem.norm(s.radiosity));
    s.error = estimated_error(s.residual, s.radius);
    s.curve.push_back({problem.products, s.residual, 0, s.error, problem.power(s.radiosity)});
    finish(problem, params, "no nearer: doubles are rounded", s);
    s.row_residual = relative(problem.norm(problem.residual(s.radiosity)), problem.norm(s.radiosity));
    return s;
}

}  // namespace plumb::radiosity
