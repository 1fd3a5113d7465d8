#include "gi/probes/candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/sequences.h"

namespace plumb::probes {

namespace {

// What an empty voxel stands beside.
enum : unsigned char { beside = 1, in_front = 2, of_no_normal = 4 };

template <class Visit>
void each_neighbour(const Voxels& v, const glm::ivec3& at, Visit visit) {
    glm::ivec3 n;
    for (n.z = std::max(at.z - 1, 0); n.z <= std::min(at.z + 1, v.size.z - 1); ++n.z)
        for (n.y = std::max(at.y - 1, 0); n.y <= std::min(at.y + 1, v.size.y - 1); ++n.y)
            for (n.x = std::max(at.x - 1, 0); n.x <= std::min(at.x + 1, v.size.x - 1); ++n.x) visit(n);
}

std::vector<unsigned char> sides(const Voxels& v) {
    std::vector<unsigned char> seen(v.surface.size(), 0);
    glm::ivec3 at;
    for (at.z = 0; at.z < v.size.z; ++at.z)
        for (at.y = 0; at.y < v.size.y; ++at.y)
            for (at.x = 0; at.x < v.size.x; ++at.x) {
                const std::int32_t i = v.surface[v.cell(at)];
                if (i < 0) continue;
                const Surface& s = v.surfaces[std::size_t(i)];
                const glm::dvec3 centre = s.centre / s.area;
                const bool normal = s.has_normal();
                each_neighbour(v, at, [&](const glm::ivec3& n) {
                    if (v.surface[v.cell(n)] >= 0) return;
                    const glm::dvec3 to = glm::dvec3(n) + 0.5 - centre;
                    const bool front = to.x * s.normal.x + to.y * s.normal.y + to.z * s.normal.z > 0;
                    seen[v.cell(n)] |= beside | (normal ? (front ? in_front : 0) : of_no_normal);
                });
            }
    return seen;
}

bool in_ring(const Voxels& v, const glm::ivec3& at, glm::bvec3 beyond) {
    for (int c = 0; c < 3; ++c)
        if (!beyond[c] && (at[c] == 0 || at[c] == v.size[c] - 1)) return true;
    return false;
}

// Of the test rays, those that hit a front face, and those that hit a back face.
struct Faces {
    int front = 0, back = 0;
};

// Rays [first, first + 16): each such run of Sobol's sequence is as even as all of them.
void look_around(const glm::dvec3& from, const RayQuery& rays, int first, Faces& faces) {
    constexpr int lanes = 16;
    std::int32_t active[lanes];
    std::fill(active, active + lanes, -1);
    RayPacket<lanes> packet{};
    for (int k = 0; k < lanes; ++k) {
        const glm::dvec3 d = sample_sphere(sobol(std::uint32_t(first + k)) + 0.5 / test_rays);
        packet.origin_x[k] = float(from.x), packet.origin_y[k] = float(from.y), packet.origin_z[k] = float(from.z);
        packet.direction_x[k] = float(d.x), packet.direction_y[k] = float(d.y), packet.direction_z[k] = float(d.z);
        packet.t_far[k] = std::numeric_limits<float>::infinity();
    }
    rays.nearest(active, packet);
    for (int k = 0; k < lanes; ++k) {
        if (packet.triangle[k] == no_hit) continue;
        const double along = double(packet.normal_x[k]) * packet.direction_x[k] +
                             double(packet.normal_y[k]) * packet.direction_y[k] +
                             double(packet.normal_z[k]) * packet.direction_z[k];
        ++(along < 0 ? faces.front : faces.back);
    }
}

bool is_inside(const glm::dvec3& from, const RayQuery& rays) {
    Faces f;
    look_around(from, rays, 0, f);
    const bool agree = (f.front == 0) != (f.back == 0);
    if (agree) return f.back > 0;
    for (int first = 16; first < test_rays; first += 16) look_around(from, rays, first, f);
    return f.back > 0 && f.back >= back_share * (f.front + f.back);
}

}  // namespace

Candidates beside_surfaces(const Voxels& v, bool both_sides, glm::bvec3 beyond) {
    Candidates c;
    const std::vector<unsigned char> seen = sides(v);
    glm::ivec3 at;
    for (at.z = 0; at.z < v.size.z; ++at.z)
        for (at.y = 0; at.y < v.size.y; ++at.y)
            for (at.x = 0; at.x < v.size.x; ++at.x) {
                const unsigned char s = seen[v.cell(at)];
                if (v.surface[v.cell(at)] >= 0)
                    ++c.in_surface;
                else if (!(s & beside))
                    continue;
                else if (in_ring(v, at, beyond))
                    ++c.beyond;
                else if (!both_sides && (s & of_no_normal))
                    ++c.without_normal;
                else if (!(s & (in_front | of_no_normal)))
                    ++c.behind;
                else
                    c.cells.push_back(at);
            }
    return c;
}

void remove_inside(Candidates& c, const Voxels& v, const RayQuery& rays, const RunOptions& options) {
    std::vector<char> inside(c.cells.size(), 0);
    parallel_bands(int(c.cells.size()), 64, options, [&](int first, int last) {
        for (int i = first; i < last; ++i)
            inside[std::size_t(i)] = is_inside(v.centre_m(c.cells[std::size_t(i)]), rays);
    });
    std::vector<glm::ivec3> kept;
    for (std::size_t i = 0; i < inside.size(); ++i)
        if (!inside[i]) kept.push_back(c.cells[i]);
    c.inside = std::int64_t(c.cells.size() - kept.size());
    c.cells = std::move(kept);
}

}  // namespace plumb::probes
