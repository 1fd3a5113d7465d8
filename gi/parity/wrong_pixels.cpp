#include "gi/parity/wrong_pixels.h"

#include <algorithm>
#include <cmath>

#include "gi/parity/pair.h"

namespace plumb::parity {

namespace {

std::size_t index(glm::ivec2 p, int width) { return std::size_t(p.y) * std::size_t(width) + std::size_t(p.x); }

// Larger first; NaN before all; then by rows.
bool larger(const LargeError& a, const LargeError& b) {
    const double x = std::abs(a.got - a.expected), y = std::abs(b.got - b.expected);
    if (std::isnan(x) != std::isnan(y)) return std::isnan(x);
    if (!std::isnan(x) && x != y) return x > y;
    return a.pixel.y != b.pixel.y ? a.pixel.y < b.pixel.y : a.pixel.x < b.pixel.x;
}

void keep(std::vector<LargeError>& all, std::size_t most) {
    if (all.size() > most) {
        std::partial_sort(all.begin(), all.begin() + std::ptrdiff_t(most), all.end(), larger);
        all.resize(most);
    } else {
        std::sort(all.begin(), all.end(), larger);
    }
}

// The component of a pixel that is farthest off.
LargeError largest_of(const std::vector<Pair>& pairs, glm::ivec2 pixel, int width) {
    LargeError worst{pixel, "", 0, 0, 0};
    const std::size_t at = index(pixel, width);
    for (const Pair& p : pairs)
        for (int c = 0; c < p.channels; ++c) {
            if (!p.compared(c)) continue;
            const LargeError one{pixel, p.slot->name, c, p.ours(at, c), p.got(at, c)};
            if (worst.output.empty() || larger(one, worst)) worst = one;
        }
    return worst;
}

// Joins all wrong pixels within reach of each other, from the first in order of rows.
std::vector<Cluster> clusters_of(glm::ivec2 size, std::vector<std::uint8_t> wrong) {
    std::vector<Cluster> clusters;
    std::vector<glm::ivec2> open;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if (!wrong[index({x, y}, size.x)]) continue;
            Cluster c{0, {x, y}, {x, y}, {}};
            open.assign(1, {x, y});
            wrong[index({x, y}, size.x)] = 0;
            while (!open.empty()) {
                const glm::ivec2 p = open.back();
                open.pop_back();
                c.members.push_back(p);
                c.low = glm::min(c.low, p), c.high = glm::max(c.high, p);
                const glm::ivec2 low = glm::max(p - cluster_reach, glm::ivec2(0)),
                                 high = glm::min(p + cluster_reach, size - 1);
                for (int v = low.y; v <= high.y; ++v)
                    for (int u = low.x; u <= high.x; ++u)
                        if (std::uint8_t& next = wrong[index({u, v}, size.x)]; next) next = 0, open.push_back({u, v});
            }
            c.pixels = std::int64_t(c.members.size());
            clusters.push_back(std::move(c));
        }
    std::stable_sort(clusters.begin(), clusters.end(),
                     [](const Cluster& a, const Cluster& b) { return a.pixels > b.pixels; });
    for (Cluster& c : clusters)
        std::sort(c.members.begin(), c.members.end(),
                  [](glm::ivec2 a, glm::ivec2 b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
    return clusters;
}

}  // namespace

bool Ratios::constant() const {
    return counted > 0 && quartiles[1] != 0 && std::abs(quartiles[2] - quartiles[0]) <= 1e-3 * std::abs(quartiles[1]);
}

std::vector<Ratios> ratios_of(const std::vector<Pair>& pairs, int width, const std::vector<glm::ivec2>& pixels) {
    std::vector<Ratios> all;
    std::vector<double> values;
    for (const Pair& p : pairs)
        for (int c = 0; c < p.channels; ++c) {
            if (!p.compared(c) || p.slot->dtype != DType::f32) continue;
            Ratios r{p.slot->name, c};
            values.clear();
            for (const glm::ivec2 pixel : pixels) {
                const std::size_t at = index(pixel, width);
                const double ours = p.ours(at, c), got = p.got(at, c);
                if (got == ours) continue;
                ++r.differing;
                if (ours != 0 && got == 0) ++r.got_zero;
                if (ours != 0 && std::isfinite(got / ours)) values.push_back(got / ours);
            }
            if (r.differing == 0) continue;
            std::sort(values.begin(), values.end());
            r.counted = std::int64_t(values.size());
            for (std::size_t q = 0; q < 3 && !values.empty(); ++q)
                r.quartiles[q] = values[(values.size() - 1) * (q + 1) / 4];
            all.push_back(r);
        }
    return all;
}

WrongPixels wrong_pixels(const std::vector<Pair>& pairs, glm::ivec2 size, const std::vector<std::uint8_t>& wrong,
                         int rows) {
    WrongPixels w;
    w.clusters = clusters_of(size, wrong);
    std::vector<glm::ivec2> all;
    for (const Cluster& c : w.clusters) all.insert(all.end(), c.members.begin(), c.members.end());
    std::sort(all.begin(), all.end(), [](glm::ivec2 a, glm::ivec2 b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
    w.pixels = std::int64_t(all.size());
    if (all.empty()) return w;
    w.low = w.high = all.front();
    for (const glm::ivec2 p : all) {
        w.low = glm::min(w.low, p), w.high = glm::max(w.high, p);
        w.largest.push_back(largest_of(pairs, p, size.x));
        const bool nothing =
            std::all_of(pairs.begin(), pairs.end(), [&](const Pair& q) { return q.expects_nothing(index(p, size.x)); });
        if (!nothing) continue;
        ++w.unexpected;
        w.unexpected_largest.push_back(w.largest.back());
    }
    keep(w.largest, std::size_t(rows));
    keep(w.unexpected_largest, std::size_t(rows));
    w.ratios = ratios_of(pairs, size.x, all);
    return w;
}

}  // namespace plumb::parity
