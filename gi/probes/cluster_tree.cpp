#include "gi/probes/cluster_tree.h"

#include <algorithm>
#include <tuple>

namespace plumb::probes {

namespace {

constexpr int most_halvings = 192;  // 64 an axis: more than a double tells apart

bool has_probe(const TransportRows& rows, int i) {
    const std::int32_t* support = rows.support + std::size_t(i) * rows.overlaps;
    return std::any_of(support, support + rows.overlaps, [](std::int32_t p) { return p >= 0; });
}

int longest_axis(const glm::dvec3& extent) {
    int axis = 0;
    for (int a = 1; a < 3; ++a)
        if (extent[a] > extent[axis]) axis = a;
    return axis;
}

// Halves the cell until both sides have receivers. False: no halving came between two of them.
bool split_at_middle(const TransportRows& rows, TreeCell cell, TreeCell (&half)[2]) {
    for (int halving = 0; halving < most_halvings; ++halving) {
        const int axis = longest_axis(cell.high - cell.low);
        const double middle = cell.low[axis] + 0.5 * (cell.high[axis] - cell.low[axis]);
        for (TreeCell& h : half) h = {}, h.low = cell.low, h.high = cell.high;
        half[0].high[axis] = half[1].low[axis] = middle;
        for (std::int32_t r : cell.receivers) half[rows.position[r][axis] >= middle].receivers.push_back(r);
        if (!half[0].receivers.empty() && !half[1].receivers.empty()) return true;
        cell = std::move(half[half[0].receivers.empty()]);
    }
    return false;
}

// Half of the receivers each, along the longest axis of their own box; equals by their number.
void split_at_median(const TransportRows& rows, const TreeCell& cell, TreeCell (&half)[2]) {
    const auto [low, high] = box_of(rows, cell.receivers);
    const int axis = longest_axis(high - low);
    std::vector<std::int32_t> order = cell.receivers;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int32_t a, std::int32_t b) { return rows.position[a][axis] < rows.position[b][axis]; });
    const auto middle = order.begin() + std::ptrdiff_t(order.size() / 2);
    for (int side = 0; side < 2; ++side) {
        auto& receivers = half[side].receivers;
        side == 0 ? receivers.assign(order.begin(), middle) : receivers.assign(middle, order.end());
        std::sort(receivers.begin(), receivers.end());
        std::tie(half[side].low, half[side].high) = box_of(rows, receivers);
    }
}

// Counts different probes: each remembers the last cell that had it.
class ProbeCount {
  public:
    std::uint64_t of(const TransportRows& rows, const std::vector<std::int32_t>& receivers) {
        ++cell_;
        std::uint64_t n = 0;
        for (std::int32_t r : receivers)
            for (int s = 0; s < rows.overlaps; ++s) {
                const std::int32_t p = rows.support[std::size_t(r) * rows.overlaps + s];
                if (p < 0) continue;
                if (std::size_t(p) >= last_.size()) last_.resize(std::size_t(p) + 1, 0);
                if (last_[std::size_t(p)] != cell_) last_[std::size_t(p)] = cell_, ++n;
            }
        return n;
    }

  private:
    std::vector<std::uint32_t> last_;
    std::uint32_t cell_ = 0;
};

// Bytes of truncated_svd() of n rows and m columns: the matrix and its columns; the Gram matrix; vectors of both sides, made,
// turned, and put out in lists that grow; a block of columns.
std::uint64_t bytes_of_svd(std::uint64_t n, std::uint64_t m, std::uint64_t overlaps, std::uint64_t width, std::uint64_t kept) {
    const std::uint64_t s = std::min(n, m);
    return n * overlaps * 56 + (s + 8) * (s + 16) * 8 + kept * (2 * s + 2 * n + m) * 8 + kept * (n + m) * 24 +
           n * (kept + width) * 8 + 64 * (std::max(n, m) + 8) * 8;
}

// The bound of a cell and of all below it.
ClusterBound bound_of(const TransportRows& rows, const ClusterParams& params, TreeCell cell, ProbeCount& probes) {
    const std::uint64_t n = cell.receivers.size(), width = std::uint64_t(rows.coefficients);
    const auto [low, high] = box_of(rows, cell.receivers);
    ClusterBound own;
    const bool may_end = std::int64_t(n) < params.most_receivers;
    if (may_end) {
        const std::uint64_t columns = probes.of(rows, cell.receivers) * width, kept = std::uint64_t(params.singular_values);
        own.matrices = std::min({n, columns, kept}) * columns;
        own.spectrum = std::min(n, columns);
        own.lists = n + columns / width;
        own.clusters = 1;
        own.workspace = bytes_of_svd(n, columns, std::uint64_t(rows.overlaps), width, kept);
    }
    const bool accepted = params.by_size_only || std::int64_t(n) <= params.always_accepted || low == high;
    if (n < 2 || (may_end && accepted)) return own;

    TreeCell half[2];
    split(rows, cell, half);
    cell.receivers = {};
    const ClusterBound a = bound_of(rows, params, std::move(half[0]), probes), b = bound_of(rows, params, std::move(half[1]), probes);
    own.matrices = std::max(own.matrices, a.matrices + b.matrices);
    own.spectrum = std::max(own.spectrum, a.spectrum + b.spectrum);
    own.clusters = std::max(own.clusters, a.clusters + b.clusters);
    own.lists = std::max(own.lists, n + a.lists + b.lists);
    own.workspace = std::max({own.workspace, a.workspace, b.workspace});
    return own;
}

}  // namespace

TreeCell whole_tree(const TransportRows& rows) {
    TreeCell cell;
    for (int i = 0; i < rows.receivers; ++i)
        if (has_probe(rows, i)) cell.receivers.push_back(i);
    if (!cell.receivers.empty()) std::tie(cell.low, cell.high) = box_of(rows, cell.receivers);
    return cell;
}

std::pair<glm::dvec3, glm::dvec3> box_of(const TransportRows& rows, const std::vector<std::int32_t>& receivers) {
    glm::dvec3 low(rows.position[receivers[0]]), high = low;
    for (std::int32_t r : receivers) {
        low = glm::min(low, glm::dvec3(rows.position[r]));
        high = glm::max(high, glm::dvec3(rows.position[r]));
    }
    return {low, high};
}

bool split(const TransportRows& rows, const TreeCell& cell, TreeCell (&half)[2]) {
    if (split_at_middle(rows, cell, half)) return true;
    half[0] = half[1] = {};
    split_at_median(rows, cell, half);
    return false;
}

ClusterBound cluster_bound(const TransportRows& rows, const ClusterParams& params) {
    TreeCell cell = whole_tree(rows);
    if (cell.receivers.empty()) return {};
    ProbeCount probes;
    return bound_of(rows, params, std::move(cell), probes);
}

}  // namespace plumb::probes
