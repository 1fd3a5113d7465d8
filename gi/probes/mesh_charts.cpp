#include "gi/probes/mesh_charts.h"

#include <algorithm>

#include "core/parallel.h"
#include "gi/probes/planar_charts.h"

namespace plumb::probes {
namespace {

// The triangles of each of `count` groups, in ascending order.
std::vector<std::vector<std::uint32_t>> members(const std::vector<std::int32_t>& group_of, std::size_t count) {
    std::vector<std::vector<std::uint32_t>> groups(count);
    for (std::size_t t = 0; t < group_of.size(); ++t)
        if (group_of[t] >= 0) groups[std::size_t(group_of[t])].push_back(std::uint32_t(t));
    return groups;
}

void find_shapes(MeshCharts& m, double chart_angle_deg) {
    const UvIslands islands = judge_own_uv(m.mesh);
    m.verdict = islands.verdict;
    if (m.verdict == OwnUv::kept) {
        m.mirrored_islands = islands.mirrored;
        for (auto& triangles : members(islands.of, std::size_t(islands.count)))
            m.shapes.push_back(own_shape(m.mesh, islands.metres, std::move(triangles)));
    } else {
        const PlanarCharts charts = cut_into_charts(m.mesh, chart_angle_deg);
        m.overlaps_cut = charts.split;
        auto triangles = members(charts.of, charts.normal.size());
        for (std::size_t i = 0; i < triangles.size(); ++i)
            m.shapes.push_back(planar_shape(m.mesh, charts.normal[i], std::move(triangles[i])));
    }
    m.mesh.normal = {}, m.mesh.half_edges = m.mesh.edge_begin = m.mesh.edge_of = m.mesh.point = {};
}

void add_pieces(std::vector<ChartPiece>& pieces, const MeshCharts& m, std::uint32_t mesh, double scale, int gap) {
    auto add = [&](std::uint32_t first, std::uint32_t count, const TexelRectangle& r) {
        pieces.push_back({mesh, first, count, r, holes(m.mesh, &m.shapes[first], count, r, scale, gap)});
    };
    const std::uint32_t count = std::uint32_t(m.shapes.size());
    if (m.verdict == OwnUv::kept && count > 1) {
        const TexelRectangle r = texel_rectangle(m.mesh, m.shapes.data(), count, scale);
        if (r.has_centre && apart(m.mesh, m.shapes, r, scale, gap)) return add(0, count, r);
    }
    for (std::uint32_t i = 0; i < count; ++i) add(i, 1, texel_rectangle(m.mesh, &m.shapes[i], 1, scale));
}

}  // namespace

std::vector<MeshCharts> mesh_charts(const Geometry& geometry, double chart_angle_deg) {
    // Triangles come object by object.
    std::vector<std::size_t> begin;
    for (std::size_t t = 0; t < geometry.triangles.size(); ++t)
        if (t == 0 || geometry.object[t] != geometry.object[t - 1]) begin.push_back(t);
    const std::size_t count = begin.size();
    begin.push_back(geometry.triangles.size());
    std::vector<MeshCharts> meshes(count);
    parallel_bands(int(count), 1, 0, [&](int first, int last) {
        for (std::size_t i = std::size_t(first); i < std::size_t(last); ++i) {
            meshes[i].mesh = surface_mesh(geometry, geometry.object[begin[i]], begin[i], begin[i + 1] - begin[i]);
            find_shapes(meshes[i], chart_angle_deg);
        }
    });
    return meshes;
}

std::vector<ChartPiece> chart_pieces(const std::vector<MeshCharts>& meshes, double texels_per_m, int gap) {
    std::vector<std::vector<ChartPiece>> of_mesh(meshes.size());
    parallel_bands(int(meshes.size()), 1, 0, [&](int first, int last) {
        for (std::size_t i = std::size_t(first); i < std::size_t(last); ++i)
            add_pieces(of_mesh[i], meshes[i], std::uint32_t(i), texels_per_m, gap);
    });
    std::vector<ChartPiece> pieces;
    for (const auto& some : of_mesh) pieces.insert(pieces.end(), some.begin(), some.end());
    return pieces;
}

}  // namespace plumb::probes
