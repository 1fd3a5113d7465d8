#include "gi/probes/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/probes/candidates.h"
#include "gi/probes/supports_kernel.h"
#include "gi/probes/thinning.h"

namespace plumb::probes {

namespace {

constexpr const char* place = "probes";
constexpr int most_halvings = 7;  // to rho / 256
constexpr int patience = 3;  // halvings until a scene without any place is given up

// The edge of the cubes of which n cover the bounds, where a flat axis takes one: n rho^3 = product of max(size, rho).
double edge_of(const glm::dvec3& size, int n) {
    double s[3] = {size.x, size.y, size.z};
    std::sort(s, s + 3);
    const double c = s[0], b = s[1], a = s[2];
    const double of_volume = a > 0 ? a * host::pow(b / a * (c / a) / n, 1.0 / 3) : 0;
    return std::max({of_volume, std::sqrt(b / n) * std::sqrt(a), a / n});
}

struct Grid {
    Voxels voxels;
    Candidates candidates;
    int halvings = 0;
};

// Cells of rho/2, halved until there are enough candidates, or `most_halvings` or too many cells are reached.
Grid find_candidates(const Geometry& geometry, const RayQuery& rays, const glm::dvec3& low, const glm::dvec3& high,
                     double rho, glm::bvec3 beyond, const PlacementParams& params, std::size_t enough,
                     const RunOptions& options) {
    Grid g;
    for (double cell = rho / 2;; cell /= 2, ++g.halvings) {
        g.voxels = voxelise(geometry, low, high, cell, options);
        g.candidates = beside_surfaces(g.voxels, params.both_sides, beyond);
        const bool last = g.halvings == most_halvings || cell_count(low, high, cell / 2) > most_cells;
        const bool hopeless = g.halvings >= patience && g.candidates.cells.empty() && !glm::all(beyond);
        if (g.candidates.cells.size() < enough && !last && !hopeless) continue;
        remove_inside(g.candidates, g.voxels, rays, options);
        if (g.candidates.cells.size() >= enough || last || hopeless) return g;
    }
}

glm::vec4 rounded(const glm::dvec3& p) { return {float(p.x), float(p.y), float(p.z), 0}; }

void check_finite(const char* what, const Buffer<glm::vec4>& list) {
    if (list.empty()) throw InputError(fmt::format("{}: no {}", place, what));
    for (const glm::vec4& p : list)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            throw InputError(fmt::format("{}: a position of {} is not finite", place, what));
}

// The distance to the n-th nearest probe, or to the farthest of fewer.
double reach_of(const glm::vec4& x, const Buffer<glm::vec4>& probes, int n) {
    double nearest[most_overlaps];
    int known = 0;
    for (const glm::vec4& p : probes) {
        const glm::dvec3 d = glm::dvec3(p) - glm::dvec3(x);
        const double d2 = d.x * d.x + d.y * d.y + d.z * d.z;
        if (known == n && !(d2 < nearest[n - 1])) continue;
        int k = known < n ? known++ : n - 1;
        for (; k > 0 && d2 < nearest[k - 1]; --k) nearest[k] = nearest[k - 1];
        nearest[k] = d2;
    }
    return std::sqrt(nearest[known - 1]);
}

}  // namespace

std::vector<Field> fields(PlacementParams& p) {
    return {
        {"probes_per_m3", &p.probes_per_m3, "1/m3", "density of probes over the scene's bounds (IPR 3.1.1)", 1e-15, 1e15, {},
         false},
        {"count", &p.count, "", "exactly so many probes; 0: as the density asks; ours", 0, most_wanted, {}, false},
        {"least", &p.least, "", "so many probes where the density asks for fewer; ours", 1, most_wanted, {}, false},
        {"both_sides", &p.both_sides, "",
         "probes on both sides of surfaces without a normal, such as thin sheets; off: nowhere beside them (IPR 3.2.2.1 "
         "has both)",
         0, 1, {}, false},
        {"beyond_bounds", &p.beyond_bounds, "",
         "probes around the scene's bounds, too; they are anyway where a scene is thin or has no place within; ours", 0, 1,
         {}, false},
        {"candidates_per_probe", &p.candidates_per_probe, "",
         "voxels are halved until there are so many candidates for each probe; ours", 1, 64, {}, false},
        {"overlaps", &p.overlaps, "", "N_OVERLAPS: probes that support a receiver (IPR 3.2.2.2)", 1, most_overlaps, {}, false},
        {"sample_receivers", &p.sample_receivers, "", "receivers that the radius is measured at; ours", 1, 1 << 24, {}, false},
        {"radius_of", as_int(p.radius_of), "",
         "radius of the probes: the mean over the sample (IPR 3.2.2.2); covering: larger where a receiver would have no probe; "
         "largest: so large that each has as many as it may have", 0, 2, {"covering", "mean", "largest"}, false},
    };
}

int wanted_probes(const glm::dvec3& size, const PlacementParams& params) {
    PlacementParams copy = params;
    validate_fields(place, fields(copy));
    if (params.count > 0) return params.count;
    const double per_m = host::pow(double(params.probes_per_m3), 1.0 / 3);
    double n = 1;
    for (int c = 0; c < 3; ++c) n *= std::max(1.0, size[c] * per_m);
    n = std::floor(n + 0.5);
    if (!(n <= most_wanted))
        throw InputError(fmt::format("{}: probes_per_m3 = {:.3g} asks for {:.4g} probes in {:.4g} x {:.4g} x {:.4g} m: "
                                     "expected at most {}",
                                     place, params.probes_per_m3, n, size.x, size.y, size.z, most_wanted));
    return std::max(params.least, int(n));
}

Placement place_probes(const Geometry& geometry, const RayQuery& rays, const PlacementParams& params,
                       const RunOptions& options) {
    glm::vec3 from, to;
    if (!bounds(geometry, from, to)) throw InputError(fmt::format("{}: the scene has no surfaces", place));
    const glm::dvec3 low(from), high(to), size = high - low;
    for (int c = 0; c < 3; ++c)
        if (!std::isfinite(size[c])) throw InputError(fmt::format("{}: the scene's bounds are not finite", place));
    Placement p;
    p.wanted = wanted_probes(size, params);
    p.rho_m = edge_of(size, p.wanted);
    if (!(p.rho_m > 0 && std::isfinite(p.rho_m))) throw InputError(fmt::format("{}: the scene has no size", place));

    const std::size_t enough = std::size_t(p.wanted) * std::size_t(params.candidates_per_probe);
    // A scene thinner than a cell has all its places beyond its bounds, and so has a solid that stands alone.
    glm::bvec3 beyond(params.beyond_bounds);
    for (int c = 0; c < 3; ++c) beyond[c] = beyond[c] || size[c] < p.rho_m / 2;
    Grid g = find_candidates(geometry, rays, low, high, p.rho_m, beyond, params, enough, options);
    if (g.candidates.cells.empty())
        g = find_candidates(geometry, rays, low, high, p.rho_m, glm::bvec3(true), params, enough, options);
    const Candidates& c = g.candidates;
    p.cell_m = g.voxels.cell_m, p.halvings = g.halvings;
    p.in_surface = c.in_surface, p.beyond = c.beyond, p.behind = c.behind;
    p.without_normal = c.without_normal, p.inside = c.inside;
    if (c.cells.empty())
        throw InputError(fmt::format("{}: no place beside a surface: {} voxels lie behind, {} inside; do normals point to "
                                     "where light is?", place, c.behind + c.without_normal, c.inside));
    const int found = int(c.cells.size());
    if (params.count > found)
        throw InputError(fmt::format("{}: count = {}: there are places for {}", place, params.count, found));

    // In cells, so that distances are exact and scenes of any size have the same bits.
    Buffer<glm::vec4> positions;
    for (const glm::ivec3& cell : c.cells) positions.push_back(glm::vec4(glm::vec3(cell), 0));
    const Thinned t = thin(positions, float(p.rho_m / p.cell_m), std::min(p.wanted, found), options);
    p.kernel_radius_m = t.radius * p.cell_m;
    for (std::size_t i = 0; i < c.cells.size(); ++i) {
        p.candidates.push_back(rounded(g.voxels.centre_m(c.cells[i])));
        p.candidates.back().w = t.density[i];
    }
    p.candidate = t.kept;
    for (const std::int32_t i : t.kept) {
        p.probes.push_back(p.candidates[std::size_t(i)]);
        p.probes.back().w = 0;
    }
    return p;
}

ProbeRadius probe_radius(const Buffer<glm::vec4>& probes, const Buffer<glm::vec4>& receivers, const PlacementParams& params,
                         const RunOptions& options) {
    PlacementParams copy = params;
    validate_fields(place, fields(copy));
    check_finite("probes", probes), check_finite("receivers", receivers);
    std::vector<double> reach(receivers.size()), nearest(receivers.size());
    parallel_bands(int(receivers.size()), 256, options, [&](int first, int last) {
        for (std::size_t i = std::size_t(first); i < std::size_t(last); ++i) {
            reach[i] = reach_of(receivers[i], probes, params.overlaps);
            nearest[i] = reach_of(receivers[i], probes, 1);
        }
    });
    ProbeRadius r;
    const std::size_t most = std::size_t(params.sample_receivers), step = (receivers.size() + most - 1) / most;
    double sum = 0;
    for (std::size_t i = 0; i < receivers.size(); i += step) sum += reach[i], ++r.sampled;
    r.mean_m = sum / r.sampled;
    r.largest_m = *std::max_element(reach.begin(), reach.end()) * (17.0 / 16);
    r.covering_m = std::max(r.mean_m, *std::max_element(nearest.begin(), nearest.end()) * (17.0 / 16));
    r.radius_m = params.radius_of == RadiusOf::mean       ? r.mean_m
                 : params.radius_of == RadiusOf::covering ? r.covering_m
                                                          : r.largest_m;
    return r;
}

}  // namespace plumb::probes
