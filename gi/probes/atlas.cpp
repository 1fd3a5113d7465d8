#include "gi/probes/atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/atlas_room.h"
#include "gi/probes/mesh_charts.h"
#include "gi/probes/pack.h"

namespace plumb::probes {
namespace {

void require(bool good, const char* name, const std::string& value, const std::string& expected) {
    if (!good) throw InputError(fmt::format("atlas: {} = {}: expected {}", name, value, expected));
}

void check(const AtlasParams& p) {
    require(p.max_size >= 1 && p.max_size <= 16384, "max_size", std::to_string(p.max_size), "1 to 16384");
    require(p.size >= 0 && p.size <= p.max_size, "size", std::to_string(p.size), fmt::format("0 to {}", p.max_size));
    require(p.gap >= 0 && p.gap <= 64, "gap", std::to_string(p.gap), "0 to 64");
    require(p.receivers_per_m2 > 0 && p.receivers_per_m2 < 1e30, "receivers_per_m2",
            fmt::format("{}", p.receivers_per_m2), "a number above 0");
    require(p.chart_angle_deg >= 1 && p.chart_angle_deg <= 80, "chart_angle_deg", fmt::format("{}", p.chart_angle_deg),
            "1 to 80");
}

// A scale, the charts' rectangles at that scale, and where they lie.
struct Layout {
    double texels_per_m = 0;
    std::vector<ChartPiece> pieces;
    Packing packing;
    bool fits() const { return !packing.placed.empty(); }
};

Layout lay_out(const std::vector<MeshCharts>& meshes, double texels_per_m, const AtlasParams& p) {
    Layout l;
    l.texels_per_m = texels_per_m;
    l.pieces = chart_pieces(meshes, texels_per_m, p.gap);
    std::vector<RectangleToPack> rectangles;
    for (const ChartPiece& piece : l.pieces) rectangles.push_back({piece.rectangle.size, piece.holes});
    l.packing = pack_rectangles(rectangles, p.gap, p.size, p.max_size);
    if (p.size == 0 && l.fits() && rectangles.size() <= 1 << 16) l.packing = pack_closer(rectangles, p.gap, l.packing);
    return l;
}

double total_area(const std::vector<MeshCharts>& meshes) {
    double sum = 0;
    for (const MeshCharts& m : meshes)
        for (const ChartShape& shape : m.shapes) sum += shape.area;
    return sum;
}

[[noreturn]] void refuse_room(double area_m2, double receivers_per_m2, int max_size) {
    throw InputError(fmt::format("atlas: {:.4g} m2 of surfaces with {:.4g} receivers a m2: expected what fits {} x {} "
                                 "texels; a lower receivers_per_m2, or a lightmap_size, does",
                                 area_m2, receivers_per_m2, max_size, max_size));
}

// The density asked for, and the square that it takes.
Layout layout_of_density(const std::vector<MeshCharts>& meshes, double area, const AtlasParams& p) {
    require_room(area, p.receivers_per_m2, p.max_size);
    Layout l = lay_out(meshes, std::sqrt(p.receivers_per_m2), p);
    if (!l.fits()) refuse_room(area, p.receivers_per_m2, p.max_size);
    return l;
}

// The largest scale that fits the square. Scales are those that would fill it with the area, divided by powers of
// 2^(1/256): finds one that fits whose larger neighbour does not.
Layout layout_of_size(const std::vector<MeshCharts>& meshes, double area, const AtlasParams& p) {
    const double full = p.size / std::sqrt(area);
    int fits = 1, fits_not = 0;
    Layout best;
    auto tries = [&](int step) {
        Layout l = lay_out(meshes, full * host::exp2(-step / 256.0), p);
        if (!l.fits()) return fits_not = step, false;
        best = std::move(l), fits = step;
        return true;
    };
    if (tries(0)) return best;
    for (int step = 64; !tries(step); step *= 2)
        if (step > 1 << 14)
            throw InputError(fmt::format("atlas: a lightmap of {0} x {0} texels: expected room for {1} charts and {2} texels "
                                         "between any two",
                                         p.size, lay_out(meshes, full * 0x1p-60, p).pieces.size(), p.gap));
    while (fits - fits_not > 1) tries((fits + fits_not) / 2);
    return best;
}

// Writes the atlas chart by chart: a vertex that an earlier chart has taken is doubled.
class Writer {
  public:
    Writer(const std::vector<MeshCharts>& meshes, const Layout& layout, Atlas& atlas)
        : meshes_(meshes),
          layout_(layout),
          atlas_(atlas),
          owner_(atlas.geometry.vertices.size(), -1),
          place_(atlas.geometry.vertices.size(), 0) {}

    void write() {
        atlas_.uv.assign(atlas_.geometry.vertices.size(), glm::vec2(0));
        atlas_.chart.assign(atlas_.geometry.triangles.size(), -1);
        for (std::size_t i = 0; i < layout_.pieces.size(); ++i) write_chart(std::int32_t(i));
        for (const MeshCharts& m : meshes_)
            for (std::size_t t = 0; t < m.mesh.count; ++t)
                if (m.mesh.area[t] == 0) write_point(m.mesh, t);
    }

  private:
    void write_chart(std::int32_t chart) {
        const ChartPiece& piece = layout_.pieces[std::size_t(chart)];
        const MeshCharts& m = meshes_[piece.mesh];
        const PackedRectangle& placed = layout_.packing.placed[std::size_t(chart)];
        glm::ivec2 size = piece.rectangle.size;
        if (placed.turned) std::swap(size.x, size.y);
        atlas_.charts.push_back({m.mesh.object, placed.origin, size, m.verdict == OwnUv::kept});
        for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i)
            for (std::uint32_t t : m.shapes[i].triangles) {
                atlas_.chart[m.mesh.first + t] = chart;
                glm::uvec3& corners = atlas_.geometry.triangles[m.mesh.first + t];
                for (int k = 0; k < 3; ++k)
                    corners[k] = vertex(corners[k], chart, m.shapes[i], piece.rectangle, placed);
            }
    }

    std::uint32_t vertex(std::uint32_t v, std::int32_t chart, const ChartShape& shape, const TexelRectangle& r,
                         const PackedRectangle& placed) {
        if (owner_[v] == chart) return place_[v];
        const std::uint32_t at = owner_[v] < 0 ? v : doubled(v);
        owner_[v] = chart, place_[v] = at;
        glm::dvec2 p = shape.at(atlas_.geometry.vertices[v]) * layout_.texels_per_m + r.shift;
        if (placed.turned) p = {r.size.y - p.y, p.x};
        const glm::dvec2 uv = (p + glm::dvec2(placed.origin)) / double(layout_.packing.side);
        atlas_.uv[at] = glm::vec2(glm::clamp(uv, 0.0, 1.0));
        return at;
    }

    std::uint32_t doubled(std::uint32_t v) {
        Geometry& g = atlas_.geometry;
        g.vertices.push_back(Vertex(g.vertices[v]));
        if (!g.tangents.empty()) g.tangents.push_back(glm::vec4(g.tangents[v]));
        atlas_.uv.push_back(atlas_.uv[v]);
        return std::uint32_t(g.vertices.size() - 1);
    }

    // A triangle without area takes one place for all corners: that of one of them in a chart, else of its mesh.
    void write_point(const SurfaceMesh& mesh, std::size_t t) {
        glm::uvec3& corners = atlas_.geometry.triangles[mesh.first + t];
        glm::vec2 uv(0);
        for (int k = 2; k >= 0; --k)
            if (owner_[corners[k]] >= 0) uv = atlas_.uv[place_[corners[k]]];
        for (int k = 0; k < 3; ++k) {
            corners[k] = doubled(corners[k]);
            atlas_.uv[corners[k]] = uv;
        }
        ++atlas_.summary.triangles_without_area;
    }

    const std::vector<MeshCharts>& meshes_;
    const Layout& layout_;
    Atlas& atlas_;
    std::vector<std::int32_t> owner_;   // [the scene's vertex]: the last chart that took it
    std::vector<std::uint32_t> place_;  // and as which vertex
};

void summarise(const std::vector<MeshCharts>& meshes, const Layout& layout, Atlas& atlas) {
    AtlasSummary& s = atlas.summary;
    std::vector<int> pieces(meshes.size(), 0);
    for (const ChartPiece& piece : layout.pieces) {
        ++pieces[piece.mesh];
        s.charts_without_texel += !piece.rectangle.has_centre;
        for (std::uint32_t i = 0; i < piece.count; ++i) s.used += meshes[piece.mesh].shapes[piece.first + i].area;
    }
    s.used *= layout.texels_per_m * layout.texels_per_m / (double(layout.packing.side) * layout.packing.side);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const MeshCharts& m = meshes[i];
        if (m.shapes.empty()) continue;
        (m.verdict == OwnUv::kept ? s.meshes_kept : s.meshes_cut) += 1;
        s.degenerate += m.verdict == OwnUv::degenerate;
        s.stretched += m.verdict == OwnUv::stretched;
        s.overlapping += m.verdict == OwnUv::overlapping;
        s.layouts_split += m.verdict == OwnUv::kept && pieces[i] > 1;
        s.mirrored_islands += m.mirrored_islands;
        s.overlaps_cut += m.overlaps_cut;
    }
}

}  // namespace

void require_room(double area_m2, double receivers_per_m2, int max_size) {
    if (!(area_m2 * receivers_per_m2 <= double(max_size) * max_size)) refuse_room(area_m2, receivers_per_m2, max_size);
}

Atlas make_atlas(const Scene& scene, const Geometry& geometry, const AtlasParams& params) {
    check(params);
    const std::vector<MeshCharts> meshes = mesh_charts(geometry, params.chart_angle_deg);
    const double area = total_area(meshes);
    if (!(area > 0))
        throw InputError(fmt::format("atlas: {}: no surfaces: expected a triangle that has an area",
                                     scene.name.empty() ? "scene" : scene.name));
    const Layout layout =
        params.size > 0 ? layout_of_size(meshes, area, params) : layout_of_density(meshes, area, params);
    Atlas atlas;
    atlas.geometry = geometry;
    atlas.size = glm::ivec2(layout.packing.side);
    atlas.texels_per_m = layout.texels_per_m;
    summarise(meshes, layout, atlas);
    Writer(meshes, layout, atlas).write();
    return atlas;
}

}  // namespace plumb::probes
