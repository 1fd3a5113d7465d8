#include "gi/probes/clusters.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/probes/cluster_tree.h"

namespace plumb::probes {

namespace {

constexpr float largest_alpha = 1e36f;  // the root of 4095 squares of it is still a float

// ---- What comes in --------------------------------------------------------------------------------------------------

[[noreturn]] void refuse(const std::string& cause) { throw InputError("clusters: " + cause); }

void require_range(const char* name, int value, int low, int high) {
    if (value < low || value > high)
        refuse(std::string(name) + " is " + std::to_string(value) + "; it may be " + std::to_string(low) + " to " +
               std::to_string(high));
}

void validate(const ClusterParams& p) {
    require_range("singular_values", p.singular_values, 4, 64);
    if (!(p.threshold >= 0 && p.threshold <= 1)) refuse("threshold is not between 0 and 1");
    require_range("most_receivers", p.most_receivers, 2, 4096);
    require_range("always_accepted", p.always_accepted, 1, 4096);
}

void validate_row(const TransportRows& rows, int i) {
    auto refuse_receiver = [&](const std::string& cause) { refuse("receiver " + std::to_string(i) + ": " + cause); };
    for (int a = 0; a < 3; ++a)
        if (!std::isfinite(rows.position[i][a])) refuse_receiver("its position is not finite");
    const std::int32_t* support = rows.support + std::size_t(i) * rows.overlaps;
    for (int s = 0; s < rows.overlaps; ++s) {
        const std::int32_t probe = support[s];
        if (probe < -1) refuse_receiver("there is no probe " + std::to_string(probe));
        if (probe < 0) continue;
        if (std::find(support, support + s, probe) != support + s)
            refuse_receiver("it has probe " + std::to_string(probe) + " twice");
        const float* alpha = rows.alpha + (std::size_t(i) * rows.overlaps + s) * rows.coefficients;
        for (int c = 0; c < rows.coefficients; ++c)
            if (!(std::fabs(alpha[c]) <= largest_alpha))
                refuse_receiver("coefficient " + std::to_string(c) + " of probe " + std::to_string(probe) +
                                (std::isfinite(alpha[c]) ? " is larger than 1e36" : " is not finite"));
    }
}

void validate(const TransportRows& rows) {
    require_range("receivers", rows.receivers, 0, std::numeric_limits<int>::max());
    require_range("overlaps", rows.overlaps, 1, 64);
    bool square = false;
    for (int l = 1; l <= 8; ++l) square = square || rows.coefficients == l * l;
    if (!square) refuse("coefficients is " + std::to_string(rows.coefficients) + "; it may be 1, 4, 9 ... 64");
    for (int i = 0; i < rows.receivers; ++i) validate_row(rows, i);
}

// ---- The tree -------------------------------------------------------------------------------------------------------

struct Cell : TreeCell {
    int children[2] = {-1, -1};  // in the list of cells; -1: a leaf
    bool split_at_median = false, coincident = false;
    Verdict verdict = Verdict::rejected;
    bool decomposed = false;
    SvdSeconds seconds;
    Cluster cluster;  // of a leaf
};

Cell cell_of(TreeCell of_tree) {
    Cell cell;
    static_cast<TreeCell&>(cell) = std::move(of_tree);
    return cell;
}

// ---- A cluster ------------------------------------------------------------------------------------------------------

// Figure 3.21.
BlockMatrix matrix_of(const TransportRows& rows, const std::vector<std::int32_t>& receivers,
                      std::vector<std::int32_t>& probes) {
    probes.clear();
    for (std::int32_t r : receivers)
        for (int s = 0; s < rows.overlaps; ++s)
            if (const std::int32_t p = rows.support[std::size_t(r) * rows.overlaps + s]; p >= 0) probes.push_back(p);
    std::sort(probes.begin(), probes.end());
    probes.erase(std::unique(probes.begin(), probes.end()), probes.end());

    BlockMatrix a;
    a.blocks = int(probes.size());
    a.width = rows.coefficients;
    for (std::int32_t r : receivers) {
        for (int s = 0; s < rows.overlaps; ++s) {
            const std::size_t slot = std::size_t(r) * rows.overlaps + s;
            if (rows.support[slot] < 0) continue;
            const auto column = std::lower_bound(probes.begin(), probes.end(), rows.support[slot]);
            a.add_entry(int(column - probes.begin()), rows.alpha + slot * rows.coefficients);
        }
        a.end_row();
    }
    return a;
}

// Decomposes the cell. Where it is accepted, puts the cluster into it and U into the receivers' rows.
void decompose(const TransportRows& rows, const ClusterParams& params, Isa isa, Cell& cell, float* u) {
    const int count = int(cell.receivers.size());
    const auto [low, high] = box_of(rows, cell.receivers);
    cell.coincident = low == high;
    const bool any_error = params.by_size_only || count <= params.always_accepted || cell.coincident;

    Cluster c;
    const BlockMatrix a = matrix_of(rows, cell.receivers, c.probes);
    Svd svd;
    cell.decomposed = true;
    cell.verdict = truncated_svd(a, params.singular_values, any_error ? 2 : params.threshold, isa, svd, &cell.seconds);
    if (cell.verdict != Verdict::accepted) return;

    c.receivers = cell.receivers;
    c.rank = svd.rank;
    c.sigma_vt.assign(svd.sigma_vt.begin(), svd.sigma_vt.end());
    c.singular_values.assign(svd.singular_values.begin(), svd.singular_values.begin() + svd.rank);
    c.spectrum = std::move(svd.singular_values);
    for (double s : c.spectrum) c.sum_of_all += s;
    c.error_published = published_error(c.spectrum, params.singular_values);
    c.error_frobenius = frobenius_error(c.spectrum, params.singular_values);
    c.low = low, c.high = high;
    c.cell_low = cell.low, c.cell_high = cell.high;
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < svd.rank; ++k)
            u[std::size_t(cell.receivers[i]) * params.singular_values + k] = float(svd.u[std::size_t(k) * count + i]);
    cell.cluster = std::move(c);
}

// Appends the leaves of a tree, low side first.
void collect(std::vector<Cell>& cells, Clusters& out) {
    std::vector<int> open = {0};
    while (!open.empty()) {
        Cell& cell = cells[open.back()];
        open.pop_back();
        if (cell.children[0] >= 0) {
            open.push_back(cell.children[1]);
            open.push_back(cell.children[0]);
            continue;
        }
        for (std::int32_t r : cell.receivers) out.cluster_of[r] = std::int32_t(out.clusters.size());
        out.clusters.push_back(std::move(cell.cluster));
    }
}

void add(SvdSeconds& sum, const SvdSeconds& s) {
    sum.gram += s.gram, sum.tridiagonal += s.tridiagonal, sum.eigenvalues += s.eigenvalues;
    sum.vectors += s.vectors, sum.products += s.products;
}

ClusterReport report_on(const std::vector<Cell>& cells, const Clusters& clusters, const ClusterParams& params) {
    ClusterReport r;
    r.of_rank.resize(std::size_t(params.singular_values) + 1);
    for (const Cell& cell : cells) {
        const bool leaf = cell.children[0] < 0;
        r.decompositions += cell.decomposed;
        r.rejected += cell.decomposed && !leaf;
        r.rejected_early += cell.verdict == Verdict::rejected_early;
        r.split_at_median += cell.split_at_median;
        add(r.seconds, cell.seconds);
        if (!leaf) continue;
        const Cluster& c = clusters.clusters[std::size_t(clusters.cluster_of[cell.receivers[0]])];
        ++r.of_rank[std::size_t(c.rank)];
        r.coincident += cell.coincident && c.error_published >= params.threshold;
    }
    for (std::int32_t c : clusters.cluster_of) r.without_probe += c < 0;
    return r;
}

}  // namespace

Clusters make_clusters(const TransportRows& rows, const ClusterParams& params, const RunOptions& options,
                       ClusterReport* report) {
    const auto start = std::chrono::steady_clock::now();
    validate(params);
    validate(rows);
    Clusters out;
    out.singular_values = params.singular_values;
    out.cluster_of.assign(std::size_t(rows.receivers), -1);
    out.u.resize(std::size_t(rows.receivers) * params.singular_values);

    std::vector<Cell> cells;
    cells.push_back(cell_of(whole_tree(rows)));
    const int all = int(cells[0].receivers.size());
    if (all == 0) cells.clear();

    // Generation by generation: within one, cells are independent.
    std::atomic<int> accepted{0};
    for (std::size_t first = 0; first < cells.size();) {
        const std::size_t last = cells.size();
        std::vector<std::pair<Cell, Cell>> born(last - first);
        parallel_bands(int(last - first), 1, options.threads, [&](int i, int) {
            Cell& cell = cells[first + i];
            if (int(cell.receivers.size()) < params.most_receivers)
                decompose(rows, params, options.isa, cell, out.u.data());
            if (cell.decomposed && cell.verdict == Verdict::accepted) {
                const int now = accepted += int(cell.receivers.size());
                if (options.progress) options.progress(double(now) / all);
                return;
            }
            TreeCell half[2];
            cell.split_at_median = !split(rows, cell, half);
            born[i] = {cell_of(std::move(half[0])), cell_of(std::move(half[1]))};
        });
        for (std::size_t i = 0; i < born.size(); ++i) {
            if (born[i].first.receivers.empty()) continue;
            cells[first + i].children[0] = int(cells.size());
            cells.push_back(std::move(born[i].first));
            cells[first + i].children[1] = int(cells.size());
            cells.push_back(std::move(born[i].second));
            std::vector<std::int32_t>().swap(cells[first + i].receivers);  // its halves have them
        }
        first = last;
    }

    if (!cells.empty()) collect(cells, out);
    if (report) {
        *report = report_on(cells, out, params);
        report->wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    return out;
}

TruncationError truncation_error(const Cluster& cluster, int kept) {
    return {published_error(cluster.spectrum, kept), frobenius_error(cluster.spectrum, kept)};
}

TruncationError truncation_error(const Clusters& clusters, int kept) {
    double sum = 0, head = 0, squares = 0, tail_squares = 0;
    for (const Cluster& c : clusters.clusters)
        for (std::size_t i = 0; i < c.spectrum.size(); ++i) {
            const double s = c.spectrum[i];
            sum += s, squares += s * s;
            (i < std::size_t(kept) ? head : tail_squares) += i < std::size_t(kept) ? s : s * s;
        }
    return {sum > 0 ? 1 - std::sqrt(head / sum) : 0, squares > 0 ? std::sqrt(tail_squares / squares) : 0};
}

}  // namespace plumb::probes
