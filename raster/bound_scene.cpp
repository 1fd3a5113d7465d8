#include "raster/bound_scene.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace plumb::raster {
namespace {

constexpr std::int64_t largest_texture_side = 1 << 22;  // as prepare() has it: coordinates stay exact in a float

template <class... Args>
[[noreturn]] void refuse(const StageData& data, fmt::format_string<Args...> text, Args&&... args) {
    throw InputError((data.label.empty() ? data.stage : data.label) + ": " +
                     fmt::format(text, std::forward<Args>(args)...));
}

// Copies an input as rows of T; refuses a count of numbers that is no whole number of rows, or not `rows`.
template <class T, class Rows>
void copy(const StageData& data, const char* input, Rows& out, std::int64_t rows = any_extent) {
    const Array& array = at(data.inputs, input);
    const std::size_t n = array.bytes.size() / sizeof(T), row = sizeof(T) / 4;
    if (array.bytes.size() % sizeof(T) != 0)
        refuse(data, "input \"{}\" has {} numbers: expected rows of {}", input, array.bytes.size() / 4, row);
    if (rows != any_extent && n != std::size_t(rows))
        refuse(data, "input \"{}\" has {} rows: expected {}", input, n, rows);
    out.resize(n);
    std::memcpy(out.data(), array.bytes.data(), array.bytes.size());
}

void check_clip_positions(const StageData& data, const Buffer<glm::vec4>& positions) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const glm::vec4& p = positions[i];
        if (!(p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0 && p.w - p.w == 0))
            refuse(data, "input \"clip_positions\": vertex {} is not finite", i);
    }
}

void check_triangles(const StageData& data, const Geometry& g, std::size_t materials) {
    for (std::size_t t = 0; t < g.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k)
            if (g.triangles[t][k] >= g.vertices.size())
                refuse(data, "input \"triangles\": triangle {} names vertex {}: there are {}", t,
                       std::int32_t(g.triangles[t][k]), g.vertices.size());
        if (g.material[t] < 0 || std::size_t(g.material[t]) >= materials)
            refuse(data, "input \"triangle_material\": triangle {} names material {}: there are {}", t, g.material[t],
                   materials);
    }
}

// A texture's smaller levels are the rows that follow its own.
void check_textures(const StageData& data, const Surfaces& s) {
    const auto rows = std::int64_t(s.textures.size() / 4), texels = std::int64_t(s.texels.size());
    for (std::int64_t r = 0; r < rows; ++r) {
        const std::int32_t* row = s.textures.data() + 4 * r;
        const std::int64_t first = row[0], width = row[1], height = row[2], levels = row[3] >> levels_shift;
        if (width < 1 || height < 1 || width > largest_texture_side || height > largest_texture_side)
            refuse(data, "input \"textures\": row {} has {} x {} texels: expected 1 to {} a side", r, width, height,
                   largest_texture_side);
        if (first < 0 || first + width * height > texels)
            refuse(data, "input \"textures\": row {} takes texels {} to {}: there are {}", r, first,
                   first + width * height - 1, texels);
        if (row[3] < 0 || r + levels >= rows)
            refuse(data, "input \"textures\": row {} has {} smaller levels: there are {} rows", r, levels, rows);
    }
}

// Rows of textures are whole numbers in a float.
void check_materials(const StageData& data, const Surfaces& s, bool tangents) {
    const std::size_t rows = s.textures.size() / 4;
    const char* const names[] = {"base", "emission", "normal"};
    for (std::size_t m = 0; m < s.masked.size(); ++m)
        for (std::size_t k = 0; k < 3; ++k) {
            const float row = s.materials[record_stride * m + 8 + k];
            if (!(row >= 0 && row < float(rows) && row == std::floor(row)))
                refuse(data, "input \"materials\": material {} names {} texture {}: there are {}", m, names[k], row,
                       rows);
            if (k == 2 && row > 0 && !tangents)
                refuse(data, "input \"tangents\": material {} has a normal map: expected a tangent for each vertex", m);
        }
}

}  // namespace

BoundScene bound_scene(const StageData& data) {
    BoundScene scene;
    Geometry& g = scene.geometry;
    Surfaces& s = scene.surfaces;
    copy<Vertex>(data, "vertices", g.vertices);
    copy<glm::vec4>(data, "clip_positions", scene.clip_positions, std::int64_t(g.vertices.size()));
    copy<glm::vec4>(data, "tangents", g.tangents);
    copy<glm::uvec3>(data, "triangles", g.triangles);
    const auto triangles = std::int64_t(g.triangles.size());
    copy<std::int32_t>(data, "triangle_material", g.material, triangles);
    if (find(data.inputs, "objects"))
        copy<std::int32_t>(data, "objects", g.object, triangles);
    else
        g.object.resize(g.triangles.size());
    copy<float>(data, "materials", s.materials);
    copy<std::int32_t>(data, "textures", s.textures);
    copy<std::int32_t>(data, "texels", s.texels);
    copy<float>(data, "decode", s.decode, 512);
    if (s.materials.size() % record_stride != 0)
        refuse(data, "input \"materials\" has {} numbers: expected rows of {}", s.materials.size(), record_stride);
    for (std::size_t m = 0; m < s.materials.size(); m += record_stride) {
        s.masked.push_back(s.materials[m + 7] > 0 ? 1 : 0);
        s.any_masked = s.any_masked || s.masked.back();
    }
    check_clip_positions(data, scene.clip_positions);
    check_triangles(data, g, s.masked.size());
    check_textures(data, s);
    check_materials(data, s, g.tangents.size() == g.vertices.size());
    return scene;
}

SurfaceArgs surface_args(const BoundScene& scene, const float viewer[4], const float forward[3], float pixel_area) {
    SurfaceArgs a = surface_args(scene.geometry, scene.surfaces, View());
    for (int c = 0; c < 4; ++c) a.viewer[c] = viewer[c];
    for (int c = 0; c < 3; ++c) a.forward[c] = forward[c];
    a.pixel_area = pixel_area;
    a.textures.levels = pixel_area > 0;
    return a;
}

}  // namespace plumb::raster
