#include "gi/probes/spatial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/basis_kernel.h"
#include "gi/probes/directions.h"
#include "gi/probes/sky_probe.h"

namespace plumb::probes {

namespace {

// The smallest whole number from 1 on whose power is at least q, and at most `most`: ceil() of its root. Sides of boxes are floats: what
// differs from a whole number by their rounding is one.
int least_root(double q, int power, int most) {
    int n = 1;
    const auto raised = [&] { return power == 3 ? double(n) * n * n : double(n) * n; };
    while (n < most && raised() < q * (1 - 1e-5)) ++n;
    return n;
}

Receivers of_places(const SpatialGrid& g) {
    Receivers r;
    for (int z = 0; z < g.count.z; ++z)
        for (int y = 0; y < g.count.y; ++y)
            for (int x = 0; x < g.count.x; ++x) {
                const glm::dvec3 at = glm::dvec3(g.origin) + glm::dvec3(x, y, z) * glm::dvec3(g.spacing);
                r.position.push_back(glm::vec4(glm::vec3(at), 0));
            }
    r.normal.assign(r.position.size(), glm::vec4(0, 0, 1, 0));
    r.shift.assign(r.position.size(), glm::vec4(0));
    return r;
}

// The distance within which every place has `overlaps` probes, or all there are; its rounding included.
double covering_radius(const Buffer<glm::vec4>& places, const Buffer<glm::vec4>& probes, int overlaps) {
    const std::size_t k = std::min(std::size_t(overlaps), probes.size());
    double largest = 0;
    std::vector<double> d2(probes.size());
    for (const glm::vec4& place : places) {
        for (std::size_t p = 0; p < probes.size(); ++p) {
            const glm::dvec3 d = glm::dvec3(probes[p]) - glm::dvec3(place);
            d2[p] = glm::dot(d, d);
        }
        std::nth_element(d2.begin(), d2.begin() + std::ptrdiff_t(k - 1), d2.end());
        largest = std::max(largest, d2[k - 1]);
    }
    return 1.01 * std::sqrt(largest);
}

template <class List>
List repeated(const List& once) {
    List all;
    for (int d = 0; d < spatial_directions; ++d) all.insert(all.end(), once.begin(), once.end());
    return all;
}

}  // namespace

glm::vec3 spatial_direction(int d) {
    glm::vec3 v(0);
    v[d / 2] = d % 2 == 0 ? 1.0f : -1.0f;
    return v;
}

SpatialGrid spatial_grid(const glm::vec3& low, const glm::vec3& high, int wanted, double inset) {
    const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
    const double largest = std::max({size.x, size.y, size.z});
    if (!(largest > 0 && std::isfinite(largest))) throw InputError("spatial receivers: the scene has no extent");
    if (wanted < 1) throw InputError(fmt::format("spatial receivers: {}: expected 1 or more", wanted));
    // A flat scene has cells that are thin, too, but no fewer than that.
    const glm::dvec3 s = glm::max(size, glm::dvec3(1e-3 * largest));
    SpatialGrid g;
    g.count.z = least_root(wanted * (s.z / s.x) * (s.z / s.y), 3, wanted);
    g.count.y = least_root(wanted * (s.y / s.x) / g.count.z, 2, wanted);
    g.count.x = int((std::int64_t(wanted) - 1) / (std::int64_t(g.count.y) * g.count.z)) + 1;
    for (int c = 0; c < 3; ++c) {
        // One place stands in the middle.
        const double cells = g.count[c] - 1 + 2 * inset, spacing = cells > 0 ? size[c] / cells : 0;
        const double first = cells > 0 ? inset * spacing : size[c] / 2;
        g.origin[c] = float(double(low[c]) + first);
        g.spacing[c] = float(spacing > 0 ? spacing : largest);
    }
    return g;
}

Spatial place_spatial(const glm::vec3& low, const glm::vec3& high, const SpatialParams& params, const raster::SurfaceArgs& surfaces,
                      const RayQuery& query, float offset, const Buffer<glm::vec4>& probes, float radius, int overlaps,
                      const RunOptions& options) {
    Spatial s;
    s.grid = spatial_grid(low, high, params.wanted);
    Receivers places = of_places(s.grid);
    ShiftParams shift;
    shift.rays = params.test_rays, shift.share = params.back_share, shift.in_the_air = true;
    s.shifted = shift_receivers(places, surfaces, query, offset, shift, options);
    SupportsInputs in;
    const Buffer<glm::vec4> standing(probes.begin(), probes.begin() + standing_probes(probes));
    s.radius = std::max(radius, float(covering_radius(places.position, standing, overlaps)));
    in.receivers = &places.position, in.probes = &standing, in.radius = s.radius, in.overlaps = overlaps;
    Supports once = run(in, options);
    add_sky(once, probes);
    s.supports = {once.overlaps, repeated(once.probe), repeated(once.weight), spatial_directions * once.unsupported,
                  spatial_directions * once.incomplete};
    s.receivers.position = repeated(places.position), s.receivers.shift = repeated(places.shift);
    for (int d = 0; d < spatial_directions; ++d)
        s.receivers.normal.insert(s.receivers.normal.end(), places.position.size(), glm::vec4(spatial_direction(d), 0));
    return s;
}

Buffer<float> spatial_factors(const Buffer<glm::vec4>& directions, Distribution distribution, SpatialWeight weight) {
    Buffer<float> factors = ray_factors(directions, distribution);
    if (weight == SpatialWeight::corrected) return factors;
    for (std::size_t k = 0; k < factors.size(); ++k) {
        // (1 - 2 theta / pi) / cos(theta), of theta = pi / 2 - asin(z).
        const double z = double(directions[k].z);
        factors[k] = float(double(factors[k]) * (2 / host::pi) * (z > 1e-9 ? host::asin(std::min(z, 1.0)) / z : 1));
    }
    return factors;
}

Clusters spatial_clusters(const Spatial& s, int coefficients, const ClusterParams& params, const RunOptions& options) {
    const int places = s.grid.places();
    const std::size_t slots = std::size_t(s.supports.overlaps), row = slots * std::size_t(coefficients);
    Clusters all;
    for (int d = 0; d < spatial_directions; ++d) {
        const std::size_t first = std::size_t(d) * std::size_t(places);
        TransportRows rows;
        rows.receivers = places, rows.overlaps = s.supports.overlaps, rows.coefficients = coefficients;
        rows.position = s.receivers.position.data() + first;
        rows.support = s.supports.probe.data() + first * slots, rows.alpha = s.alpha.data() + first * row;
        Clusters one = make_clusters(rows, params, options);
        const std::int32_t before = std::int32_t(all.clusters.size());
        for (Cluster& c : one.clusters) {
            for (std::int32_t& r : c.receivers) r += std::int32_t(first);
            all.clusters.push_back(std::move(c));
        }
        for (const std::int32_t c : one.cluster_of) all.cluster_of.push_back(c < 0 ? -1 : before + c);
        all.singular_values = one.singular_values;
        all.u.insert(all.u.end(), one.u.begin(), one.u.end());
    }
    return all;
}

// ---- Run time ----------------------------------------------------------------------------------------------------------

Box box_of(const Mesh& mesh) {
    glm::dvec3 low(HUGE_VAL), high(-HUGE_VAL);
    for (const Vertex& v : mesh.vertices) {
        const glm::dvec3 p(mesh.transform * glm::dvec4(glm::dvec3(v.position), 1));
        low = glm::min(low, p), high = glm::max(high, p);
    }
    return {glm::vec3(low), glm::vec3(high)};
}

std::vector<Box> dynamic_boxes(const Scene& scene, const std::vector<int>& left_out) {
    std::vector<Box> boxes;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        if (!mesh.dynamic || mesh.vertices.empty() || std::binary_search(left_out.begin(), left_out.end(), int(m))) continue;
        boxes.push_back(box_of(mesh));
    }
    return boxes;
}

CellRange cells_of(const SpatialGrid& g, const Box& box) {
    CellRange range;
    for (int c = 0; c < 3; ++c) {
        const double a = box.low[c], b = box.high[c], spacing = g.spacing[c], end = g.count[c] - 1;
        if (!std::isfinite(a) || !std::isfinite(b)) throw InputError("spatial receivers: a dynamic mesh is not finite");
        range.margin[c] = 1e-3 * spacing + 0x1p-10 * std::max(std::fabs(a), std::fabs(b));
        range.first[c] = int(std::floor(std::clamp((a - range.margin[c] - double(g.origin[c])) / spacing, 0.0, end)));
        range.last[c] = int(std::floor(std::clamp((b + range.margin[c] - double(g.origin[c])) / spacing, 0.0, end)));
    }
    return range;
}

std::vector<std::uint8_t> active_places(const SpatialGrid& g, const std::vector<Box>& boxes) {
    std::vector<std::uint8_t> active(std::size_t(g.places()), 0);
    if (active.empty()) return active;
    for (const Box& box : boxes) {
        const auto [first, last_cell, margin] = cells_of(g, box);
        const glm::ivec3 last = glm::min(last_cell + 1, g.count - 1);
        for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
                for (int x = first.x; x <= last.x; ++x) active[std::size_t(x + g.count.x * (y + g.count.y * z))] = 1;
    }
    return active;
}

std::vector<std::int32_t> active_levels(const SpatialGrid& g, const std::vector<std::uint8_t>& active,
                                        const std::vector<std::int32_t>& receiver, int coarsest) {
    std::vector<std::int32_t> levels;
    for (const std::int32_t r : receiver) levels.push_back(active[std::size_t(r % g.places())] ? coarsest : -1);
    return levels;
}

std::vector<std::int32_t> active_clusters(const std::vector<std::int32_t>& active, const std::vector<std::int32_t>& cluster, std::size_t clusters) {
    std::vector<std::int32_t> levels(clusters, no_level);
    for (std::size_t i = 0; i < active.size(); ++i)
        if (active[i] >= 0 && cluster.at(i) >= 0) levels.at(std::size_t(cluster[i])) = 0;
    return levels;
}

void gather_grid(const SpatialGrid& g, const std::vector<std::int32_t>& receiver, const Buffer<glm::vec4>& irradiance,
                 Buffer<glm::vec4>& gathered) {
    const std::size_t places = std::size_t(g.places());
    if (receiver.size() != spatial_directions * places || irradiance.size() < receiver.size())
        throw InputError(fmt::format("spatial receivers: irradiance of {}: expected {}", irradiance.size(), spatial_directions * places));
    gathered.resize(receiver.size());
    for (std::size_t i = 0; i < receiver.size(); ++i) {
        const std::size_t of = std::size_t(receiver[i]);
        gathered[of % places * spatial_directions + of / places] = irradiance[i];
    }
}

}  // namespace plumb::probes
