#include "gi/radiosity/solve_audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/radiosity/solve_problem.h"

namespace plumb::radiosity {

namespace {

double sum(const glm::dvec3& v) { return (v.x + v.y) + v.z; }

// One look at all rows: their sums, what they gather, and what columns hand out: sum_i A_i F_ij.
struct RowSums {
    std::vector<double> row, column;
    Channels h;

    RowSums(const Problem& problem, const Channels& b) : row(b.size(), 0.0), column(b.size(), 0.0), h(b.size(), glm::dvec3(0)) {
        constexpr int bands = 16;  // whatever the threads
        const int n = problem.count, band = (n + bands - 1) / bands;
        std::vector<std::vector<double>> columns(bands, std::vector<double>(b.size(), 0.0));
        parallel_bands(n, band, problem.options.threads, [&](int first, int last) {
            std::vector<double>& to = columns[first / band];
            std::vector<float> f;
            for (int i = first; i < last; ++i) {
                problem.row(i, f);
                for (int j = 0; j < n; ++j) {
                    row[i] += f[j];
                    h[i] += double(f[j]) * b[j];
                    to[j] += problem.area[i] * f[j];
                }
            }
        });
        for (const std::vector<double>& from : columns)
            for (int j = 0; j < n; ++j) column[j] += from[j];
    }
};

void add_powers(const Problem& problem, const Channels& b, const RowSums& sums, const SmallEmitters& small, Audit& out) {
    const auto of = [](const Buffer<glm::vec4>* list, int i) { return list && !list->empty() ? sum(glm::dvec3((*list)[std::size_t(i)])) : 0.0; };
    for (int i = 0; i < problem.count; ++i) {
        const double a = problem.area[i];
        const glm::dvec3 h = problem.incident[i] + sums.h[i], rho = problem.reflectance[i];
        const double sent = of(small.exitance, i), arrived = of(small.irradiance, i);
        out.emitted += a * (sum(problem.exitance[i]) + sent), out.incident += a * (sum(problem.incident[i]) - arrived);
        out.not_arrived += a * (sent - arrived);
        out.absorbed += a * sum((1.0 - rho) * h);
        out.escaped += a * (1 - sums.row[i]) * sum(b[i]);
        out.not_reciprocal += (a * sums.row[i] - sums.column[i]) * sum(b[i]);
        out.unsolved += a * sum((problem.exitance[i] - b[i]) + rho * h);
    }
    out.unbalanced = (out.emitted + out.incident) -
                     ((out.absorbed + out.escaped) + (out.not_arrived + (out.not_reciprocal + out.unsolved)));
}

void add_rows(const RowSums& sums, Audit& out) {
    const std::size_t n = sums.row.size();
    out.least_row = sums.row[0], out.largest_row = sums.row[0], out.largest_row_at = 0;
    for (std::size_t i = 0; i < n; ++i) {
        out.least_row = std::min(out.least_row, sums.row[i]);
        if (sums.row[i] > out.largest_row) out.largest_row = sums.row[i], out.largest_row_at = int(i);
        out.mean_row += sums.row[i];
        out.rows_of_nothing += sums.row[i] == 0;
    }
    out.mean_row /= double(n);
}

void add_pairs(const Problem& problem, int sample, Audit& out) {
    const int m = std::min(sample, problem.count);
    std::vector<int> chosen;
    for (int k = 0; k < m; ++k) chosen.push_back(int(std::int64_t(k) * problem.count / m));
    std::vector<double> exchange(std::size_t(m) * m);  // A_i F_ij
    parallel_bands(m, 16, problem.options.threads, [&](int first, int last) {
        std::vector<float> row;
        for (int k = first; k < last; ++k) {
            problem.row(chosen[k], row);
            for (int l = 0; l < m; ++l) exchange[std::size_t(k) * m + l] = problem.area[chosen[k]] * row[chosen[l]];
        }
    });
    double squares = 0, all = 0;
    for (int k = 0; k < m; ++k)
        for (int l = 0; l < k; ++l) {
            const double x = exchange[std::size_t(k) * m + l], y = exchange[std::size_t(l) * m + k], d = std::fabs(x - y);
            squares += d * d, all += 0.5 * (x * x + y * y);
            if (d > out.defect_worst) out.defect_worst = d, out.worst_i = chosen[l], out.worst_j = chosen[k];
            ++out.pairs;
        }
    out.all_pairs = m == problem.count;
    if (out.pairs == 0) return;
    out.defect_rms = std::sqrt(squares / double(out.pairs)), out.exchange_rms = std::sqrt(all / double(out.pairs));
}

}  // namespace

Audit audit(const System& system, const Transport& transport, const std::vector<glm::dvec3>& radiosity, int sample,
            const RunOptions& options, const SmallEmitters& small) {
    FpEnvironment environment;
    Problem problem(system, transport, options);
    if (radiosity.size() != std::size_t(problem.count))
        throw InputError(fmt::format("radiosity: audit: {} radiosities: {} expected", radiosity.size(), problem.count));
    for (const glm::dvec3& b : radiosity)
        for (int c = 0; c < 3; ++c)
            if (!(std::fabs(b[c]) <= 0x1p127)) throw InputError("radiosity: audit: a radiosity that is not finite");
    if (sample < 1) throw InputError(fmt::format("radiosity: audit: sample = {}: expected 1 or more", sample));
    Audit out;
    if (problem.count == 0) return out;
    const RowSums sums(problem, radiosity);
    add_powers(problem, radiosity, sums, small, out);
    add_rows(sums, out);
    add_pairs(problem, sample, out);

    Channels h;
    problem.gather(radiosity, h);
    double off = 0, most = 0;
    for (int i = 0; i < problem.count; ++i)
        for (int c = 0; c < 3; ++c)
            off = std::max(off, std::fabs(h[i][c] - sums.h[i][c])), most = std::max(most, std::fabs(sums.h[i][c]));
    out.gather_off = off > 0 ? off / most : 0;
    return out;
}

}  // namespace plumb::radiosity
