#include "gi/probes/voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace plumb::probes {

namespace {

using glm::dvec3;

constexpr double margin = 0x1p-30, touching = 0x1p-20;
constexpr int bands = 16;

double dot(const dvec3& a, const dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
dvec3 cross(const dvec3& a, const dvec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const dvec3& v) { return std::sqrt(dot(v, v)); }

dvec3 cells_of(const dvec3& low, const dvec3& high, double cell_m) {
    dvec3 n;
    for (int c = 0; c < 3; ++c) n[c] = std::floor((high[c] - low[c]) / cell_m + 0.5) + 3;
    return n;
}

// A triangle in cells from the grid's corner.
struct Triangle {
    dvec3 p[3];
    dvec3 n{0};  // unit
    dvec3 low, high;
};

bool has_area(Triangle& t) {
    const dvec3 n = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
    const double size = length(n);
    if (!(size > 0)) return false;
    t.n = n / size;
    return true;
}

// Whether some axis that is a product of an edge and an axis of the box parts the triangle from the cell's cube.
bool parted_by_edges(const Triangle& t, const dvec3& centre) {
    const dvec3 p[3] = {t.p[0] - centre, t.p[1] - centre, t.p[2] - centre};
    for (int e = 0; e < 3; ++e) {
        const dvec3 edge = p[(e + 1) % 3] - p[e];
        for (int c = 0; c < 3; ++c) {
            const int i = (c + 1) % 3, j = (c + 2) % 3;
            // edge x unit(c) has components edge[j] along i and -edge[i] along j.
            const auto along = [&](const dvec3& v) { return edge[j] * v[i] - edge[i] * v[j]; };
            const double a = along(p[e]), b = along(p[(e + 2) % 3]);
            const double reach = (0.5 + margin) * (std::fabs(edge[i]) + std::fabs(edge[j]));
            if (std::min(a, b) > reach || std::max(a, b) < -reach) return true;
        }
    }
    return false;
}

// A triangle cut by the six sides of a cube: nine corners at most, and room for what rounding may bend.
struct Polygon {
    static constexpr int room = 16;
    dvec3 p[room];
    int n = 0;
};

// Keeps what is not beyond `side` along axis c.
void cut(Polygon& poly, int c, double side, double sign) {
    Polygon kept;
    for (int k = 0; k < poly.n && kept.n + 2 <= Polygon::room; ++k) {
        const dvec3 &a = poly.p[k], &b = poly.p[(k + 1) % poly.n];
        const double da = sign * (side - a[c]), db = sign * (side - b[c]);
        if (da >= 0) kept.p[kept.n++] = a;
        if ((da >= 0) != (db >= 0)) {
            dvec3 q = a + (b - a) * (da / (da - db));
            q[c] = side;
            kept.p[kept.n++] = q;
        }
    }
    poly = kept;
}

void add_polygon(Surface& s, const Triangle& t, const Polygon& poly, const dvec3& cell_centre) {
    double area = 0;
    dvec3 centre(0);
    for (int k = 2; k < poly.n; ++k) {
        const double a = 0.5 * length(cross(poly.p[k - 1] - poly.p[0], poly.p[k] - poly.p[0]));
        area += a;
        centre += (poly.p[0] + poly.p[k - 1] + poly.p[k]) * (a / 3);
    }
    if (area < touching) {
        // The nearest point of its bounds will do.
        dvec3 near = poly.n > 0 ? poly.p[0] : cell_centre;
        for (int c = 0; c < 3; ++c) near[c] = std::min(std::max(near[c], t.low[c]), t.high[c]);
        area = touching, centre = near * touching;
    }
    s.area += area, s.centre += centre, s.normal += t.n * area;
}

// The surfaces of a slab of cells.
struct Slab {
    std::vector<std::size_t> cell;
    std::vector<Surface> surface;
};

class Filler {
  public:
    Filler(Voxels& voxels, Slab& slab, int first, int last) : v_(voxels), slab_(slab), first_(first), last_(last) {}

    void add(const Triangle& t) {
        glm::ivec3 from, to;
        bool one = true;
        for (int c = 0; c < 3; ++c) {
            const double low = std::floor(t.low[c] - margin), high = std::floor(t.high[c] + margin);
            from[c] = int(std::max(low, c == 2 ? double(first_) : 0.0));
            to[c] = int(std::min(high, (c == 2 ? last_ : v_.size[c]) - 1.0));
            one = one && low == high;
            if (low > to[c] || high < from[c]) return;
        }
        int k = 0;
        for (int c = 1; c < 3; ++c)
            if (std::fabs(t.n[c]) > std::fabs(t.n[k])) k = c;
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        // Columns of cells along the axis that the triangle faces most: its plane meets a few cells of each.
        const double reach = (0.5 + margin) * (std::fabs(t.n.x) + std::fabs(t.n.y) + std::fabs(t.n.z)) / std::fabs(t.n[k]);
        glm::ivec3 at;
        for (at[j] = from[j]; at[j] <= to[j]; ++at[j])
            for (at[i] = from[i]; at[i] <= to[i]; ++at[i]) {
                const double x = t.p[0][k] - (t.n[i] * (at[i] + 0.5 - t.p[0][i]) + t.n[j] * (at[j] + 0.5 - t.p[0][j])) / t.n[k];
                const double low = std::max(std::ceil(x - reach - 0.5), double(from[k]));
                const double high = std::min(std::floor(x + reach - 0.5), double(to[k]));
                for (double m = low; m <= high; ++m) {
                    at[k] = int(m);
                    if (one || !parted_by_edges(t, dvec3(at) + 0.5)) add(t, at, one);
                }
            }
    }

  private:
    void add(const Triangle& t, const glm::ivec3& at, bool whole) {
        std::int32_t& index = v_.surface[v_.cell(at)];
        if (index < 0) {
            index = std::int32_t(slab_.surface.size());
            slab_.surface.emplace_back(), slab_.cell.push_back(v_.cell(at));
        }
        Polygon poly{{t.p[0], t.p[1], t.p[2]}, 3};
        for (int c = 0; c < 3 && !whole; ++c) cut(poly, c, at[c], -1), cut(poly, c, at[c] + 1, 1);
        add_polygon(slab_.surface[std::size_t(index)], t, poly, dvec3(at) + 0.5);
    }

    Voxels& v_;
    Slab& slab_;
    int first_, last_;  // layers
};

}  // namespace

bool Surface::has_normal() const { return length(normal) >= least_agreement * area; }

std::int64_t cell_count(const glm::dvec3& low, const glm::dvec3& high, double cell_m) {
    const dvec3 n = cells_of(low, high, cell_m);
    const double all = n.x * n.y * n.z;
    return all < 0x1p62 ? std::int64_t(all) : std::int64_t(1) << 62;
}

Voxels voxelise(const Geometry& geometry, const glm::dvec3& low, const glm::dvec3& high, double cell_m,
                const RunOptions& options) {
    if (!(cell_m > 0) || cell_count(low, high, cell_m) > most_cells)
        throw InputError(fmt::format("probes: cells of {} m over {} x {} x {} m: expected at most {} of them", cell_m,
                                     high.x - low.x, high.y - low.y, high.z - low.z, most_cells));
    for (const glm::uvec3& t : geometry.triangles)
        for (int c = 0; c < 3; ++c) {
            const glm::vec3& p = geometry.vertices[t[c]].position;
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                throw InputError("probes: a triangle's corner is not finite");
        }
    Voxels v;
    v.cell_m = cell_m;
    v.size = glm::ivec3(cells_of(low, high, cell_m));
    v.low = (low + high) * 0.5 - dvec3(v.size) * (0.5 * cell_m);
    v.surface.assign(std::size_t(v.size.x) * std::size_t(v.size.y) * std::size_t(v.size.z), -1);

    // Layers are parted into slabs; each reads all triangles in their order.
    const int layers = (v.size.z + bands - 1) / bands;
    std::vector<Slab> slabs(std::size_t((v.size.z + layers - 1) / layers));
    parallel_bands(v.size.z, layers, options, [&](int first, int last) {
        Filler filler(v, slabs[std::size_t(first / layers)], first, last);
        for (const glm::uvec3& corners : geometry.triangles) {
            Triangle t;
            for (int c = 0; c < 3; ++c) t.p[c] = (dvec3(geometry.vertices[corners[c]].position) - v.low) / cell_m;
            const double least = std::min({t.p[0].z, t.p[1].z, t.p[2].z}), most = std::max({t.p[0].z, t.p[1].z, t.p[2].z});
            if (most < first - margin || least > last + margin || !has_area(t)) continue;
            for (int c = 0; c < 3; ++c) {
                t.low[c] = std::min({t.p[0][c], t.p[1][c], t.p[2][c]});
                t.high[c] = std::max({t.p[0][c], t.p[1][c], t.p[2][c]});
            }
            filler.add(t);
        }
    });
    // In the order of cells.
    for (const Slab& slab : slabs) {
        std::vector<std::int32_t> order(slab.cell.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = std::int32_t(i);
        std::sort(order.begin(), order.end(),
                  [&](std::int32_t a, std::int32_t b) { return slab.cell[std::size_t(a)] < slab.cell[std::size_t(b)]; });
        for (const std::int32_t i : order) {
            v.surface[slab.cell[std::size_t(i)]] = std::int32_t(v.surfaces.size());
            v.surfaces.push_back(slab.surface[std::size_t(i)]);
        }
    }
    return v;
}

}  // namespace plumb::probes
