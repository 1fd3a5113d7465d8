#include "gi/probes/lod_air.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "gi/probes/basis_kernel.h"
#include "gi/probes/level_kernel.h"
#include "gi/probes/lightmap_kernel.h"

namespace plumb::probes {

namespace {

// The level whose lattice's cells are no wider than so many of the grid's.
int level_as_wide(double cells) { return std::min(int(std::bit_width(unsigned(std::clamp(cells, 1.0, 1024.0)))) - 1, most_levels - 1); }

// Of a lattice of every 2^level-th place and the last: the two about a place, and how far behind the first it is, of their distance.
struct Between {
    int first, next;
    float share;
};
Between between(int place, int level, int count) {
    const int first = (place >> level) << level, next = std::min(first + (1 << level), count - 1);
    return {first, next, next > first ? float(place - first) / float(next - first) : 0.0f};
}
struct Lattice {
    Between x, y, z;
};
Lattice lattice_at(const SpatialGrid& g, const glm::ivec3& at, const glm::ivec3& level) {
    return {between(at.x, level.x, g.count.x), between(at.y, level.y, g.count.y), between(at.z, level.z, g.count.z)};
}

// Calls one(place, weight) for the eight.
template <class One>
void each_corner(const SpatialGrid& g, const Lattice& l, One one) {
    for (int k = 0; k < 8; ++k) {
        const bool right = (k & 1) != 0, up = (k & 2) != 0, far = (k & 4) != 0;
        const float weight = (right ? l.x.share : 1 - l.x.share) * (up ? l.y.share : 1 - l.y.share) * (far ? l.z.share : 1 - l.z.share);
        const glm::ivec3 at(right ? l.x.next : l.x.first, up ? l.y.next : l.y.first, far ? l.z.next : l.z.first);
        one(std::size_t(at.x + g.count.x * (at.y + g.count.y * at.z)), weight);
    }
}

// The six of a place; false where one that counts is not computed.
bool filled(const SpatialGrid& g, const Lattice& l, const std::vector<std::int32_t>& level, Buffer<glm::vec4>& gathered, std::size_t place) {
    bool all = true;
    each_corner(g, l, [&](std::size_t at, float weight) { all = all && (weight == 0 || level[at] != no_level); });
    if (!all) return false;
    for (std::size_t d = 0; d < spatial_directions; ++d) {
        glm::vec3 sum(0);
        each_corner(g, l, [&](std::size_t at, float weight) {
            if (weight != 0) sum += weight * glm::vec3(gathered[at * spatial_directions + d]);
        });
        gathered[place * spatial_directions + d] = glm::vec4(sum, 0);
    }
    return true;
}

}  // namespace

AirReads air_reads(const SpatialGrid& g, const std::vector<Box>& boxes) {
    AirReads reads;
    for (const Box& box : boxes) {
        const CellRange range = cells_of(g, box);
        // Beyond the grid the box has no cells. Within it how wide it is does not depend on where in its cells it lies.
        const glm::dvec3 size = glm::min((glm::dvec3(box.high) - glm::dvec3(box.low)) / glm::dvec3(g.spacing), glm::dvec3(range.last - range.first + 1));
        const glm::ivec3 widest(level_as_wide(size.x), level_as_wide(size.y), level_as_wide(size.z));
        for (int z = range.first.z; z <= range.last.z; ++z)
            for (int y = range.first.y; y <= range.last.y; ++y)
                for (int x = range.first.x; x <= range.last.x; ++x) {
                    const glm::ivec3 cell(x, y, z);
                    glm::dvec3 low = glm::dvec3(box.low) - range.margin, high = glm::dvec3(box.high) + range.margin;
                    for (int c = 0; c < 3; ++c) {
                        // Beyond the grid those at its edge are read.
                        const double from = double(g.origin[c]) + cell[c] * double(g.spacing[c]) - range.margin[c];
                        if (cell[c] > 0) low[c] = std::max(low[c], from);
                        if (cell[c] < g.count[c] - 1) high[c] = std::min(high[c], from + double(g.spacing[c]) + 2 * range.margin[c]);
                        high[c] = std::max(high[c], low[c]);
                    }
                    reads.low.push_back(glm::vec4(glm::vec3(low), 0)), reads.high.push_back(glm::vec4(glm::vec3(high), 0));
                    reads.cell.push_back(cell), reads.coarsest.push_back(widest);
                }
    }
    return reads;
}

AirLevels air_levels(const SpatialGrid& g, const AirReads& reads, const std::vector<std::int32_t>& level,
                     const std::vector<std::int32_t>& cluster_of, int clusters) {
    AirLevels of;
    of.place.assign(std::size_t(g.places()), no_level), of.cluster.assign(std::size_t(clusters), no_level);
    for (std::size_t i = 0; i < reads.cell.size(); ++i)
        each_corner(g, lattice_at(g, reads.cell[i], glm::min(glm::ivec3(level[i]), reads.coarsest[i])),
                    [&](std::size_t at, float) { of.place[at] = std::min(of.place[at], level[i]); });
    for (std::size_t r = 0; r < cluster_of.size(); ++r)
        if (cluster_of[r] >= 0) {
            std::int32_t& own = of.cluster[std::size_t(cluster_of[r])];
            own = std::min(own, of.place[r % of.place.size()]);
        }
    return of;
}

void fill_air(const SpatialGrid& g, const std::vector<std::int32_t>& level, Buffer<glm::vec4>& gathered) {
    for (std::size_t place = 0; place < level.size(); ++place) {
        if (level[place] != no_level) continue;
        const int i = int(place);
        const glm::ivec3 at(i % g.count.x, i / g.count.x % g.count.y, i / (g.count.x * g.count.y));
        bool found = false;
        for (int sum = 1; sum <= 3 * (most_levels - 1) && !found; ++sum)
            for (int x = std::max(0, sum - 2 * (most_levels - 1)); x < most_levels && x <= sum && !found; ++x)
                for (int y = std::max(0, sum - x - (most_levels - 1)); y < most_levels && x + y <= sum && !found; ++y)
                    found = filled(g, lattice_at(g, at, {x, y, sum - x - y}), level, gathered, place);
    }
}

}  // namespace plumb::probes
