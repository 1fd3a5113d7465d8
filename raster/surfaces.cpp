#include "raster/surfaces.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "core/content_hasher.h"
#include "core/error.h"
#include "core/host_math.h"
#include "raster/mips.h"

namespace plumb::raster {
namespace {

void append_image(Surfaces& s, const Image<std::uint32_t>& image, std::int32_t flags) {
    s.textures.insert(s.textures.end(), {std::int32_t(s.texels.size()), image.width, image.height, flags});
    const std::size_t first = s.texels.size();
    s.texels.resize(first + image.size());
    std::memcpy(s.texels.data() + first, image.texels.data(), 4 * image.size());
}

std::int32_t flags_of(const Texture& t) {
    return (t.filter == Filter::nearest ? flag_nearest : 0) | (t.srgb ? flag_srgb : 0) |
           int(t.wrap_u) << wrap_u_shift | int(t.wrap_v) << wrap_v_shift;
}

// Texels are addressed by 32-bit indices, and their coordinates must be exact in a float.
void check(const Texture& texture, std::size_t texels_so_far) {
    const Image<std::uint32_t>& image = texture.texels;
    if (image.width < 1 || image.height < 1 || image.size() != std::size_t(image.width) * std::size_t(image.height))
        throw InputError(fmt::format("texture \"{}\": {} x {} texels: expected at least one", texture.name, image.width,
                                     image.height));
    if (image.width > (1 << 22) || image.height > (1 << 22) || texels_so_far + image.size() >= (std::size_t(1) << 31))
        throw InputError(fmt::format("texture \"{}\": {} x {} texels, after {} of others: at most 2^31 fit in all",
                                     texture.name, image.width, image.height, texels_so_far));
}

// Appends a texture and its levels; returns its row.
std::int32_t append_texture(Surfaces& s, const Texture& texture) {
    check(texture, s.texels.size());
    std::vector<Image<std::uint32_t>> levels;
    if (texture.mips) levels = smaller_levels(texture, s.decode);
    const auto row = std::int32_t(s.textures.size() / 4);
    append_image(s, texture.texels, flags_of(texture) | int(levels.size()) << levels_shift);
    for (const Image<std::uint32_t>& level : levels) {
        if (s.texels.size() + level.size() >= (std::size_t(1) << 31))
            throw InputError(fmt::format("texture \"{}\": mips: at most 2^31 texels fit in all", texture.name));
        append_image(s, level, flags_of(texture));
    }
    s.any_levels = s.any_levels || !levels.empty();
    return row;
}

// Everything that rows, texels and levels are made of.
std::uint64_t hash_of(const std::vector<Texture>& textures) {
    ContentHasher h;
    h.add(textures.size());
    for (const Texture& texture : textures) {
        const auto& [name, texels, srgb, filter, wrap_u, wrap_v, mips] = texture;
        h.add_image(texels);
        h.add(srgb, filter, wrap_u, wrap_v, mips);
    }
    return h.hash;
}

void append_textures(Surfaces& s, const std::vector<Texture>& textures) {
    append_image(s, Image<std::uint32_t>(1, 1, 0xffffffffu), flag_nearest);
    for (const Texture& texture : textures) s.texture_rows.push_back(append_texture(s, texture));
    if (s.textures.size() / 4 > (std::size_t(1) << 24))
        throw InputError(fmt::format("{} textures with {} levels: at most 2^24 - 1 in all", textures.size(),
                                     s.textures.size() / 4 - 1));
}

// The row of a material's texture, as a kernel reads it from a record of floats: exact below 2^24.
float row_of(const Material& m, const char* field, int texture, const std::vector<std::int32_t>& rows) {
    if (texture < -1 || texture >= int(rows.size()))
        throw InputError(
            fmt::format("material \"{}\": {} = {}: the scene has {}", m.name, field, texture, rows.size()));
    return texture < 0 ? 0.0f : float(rows[std::size_t(texture)]);
}

void append_material(Surfaces& s, const Material& m, const std::vector<std::int32_t>& rows, bool tangents) {
    const float base = row_of(m, "texture", m.texture, rows);
    const float emission = row_of(m, "emission_texture", m.emission_texture, rows);
    const float normal = row_of(m, "normal_texture", m.normal_texture, rows);
    // A zero has no sign, so that a colour which nobody computes is the 0 that it would be.
    const glm::vec3 reflectance = m.reflectance + 0.0f, exitance = m.emission + 0.0f;
    s.materials.insert(s.materials.end(), {reflectance.x, reflectance.y, reflectance.z, m.alpha,          //
                                           exitance.x, exitance.y, exitance.z, m.alpha_cutoff,            //
                                           base, emission, tangents ? normal : 0.0f, m.normal_scale,      //
                                           0, 0, 0, 0});
    s.masked.push_back(m.alpha_cutoff > 0 ? 1 : 0);
    s.any_masked = s.any_masked || m.alpha_cutoff > 0;
}

}  // namespace

Buffer<float> decode_table() {
    Buffer<float> table(512);
    for (int byte = 0; byte < 256; ++byte) {
        const double v = byte / 255.0;
        table[std::size_t(byte)] = float(v);
        // IEC 61966-2-1.
        table[std::size_t(256 + byte)] = float(v <= 0.04045 ? v / 12.92 : host::pow((v + 0.055) / 1.055, 2.4));
    }
    return table;
}

Surfaces prepare(const Scene& scene, const Geometry& geometry, const Surfaces* before) {
    Surfaces s;
    s.decode = decode_table();
    s.textures_hash = hash_of(scene.textures);
    if (before && !before->textures.empty() && before->textures_hash == s.textures_hash) {
        s.textures = before->textures, s.texture_rows = before->texture_rows;
        s.texels = before->texels, s.any_levels = before->any_levels;
    } else {
        append_textures(s, scene.textures);
    }
    for (const Material& m : scene.materials) append_material(s, m, s.texture_rows, !geometry.tangents.empty());
    for (std::size_t t = 0; t < geometry.material.size(); ++t)
        if (geometry.material[t] < 0 || geometry.material[t] >= int(scene.materials.size()))
            throw InputError(fmt::format("triangle {}: material = {}: the scene has {}", t, geometry.material[t],
                                         scene.materials.size()));
    s.brightest = brightest_of(scene, geometry);
    return s;
}

SurfaceArgs surface_args(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size) {
    SurfaceArgs a{};
    a.vertices = reinterpret_cast<const float*>(geometry.vertices.data());  // null where there is none
    a.tangents = reinterpret_cast<const float*>(geometry.tangents.data());
    a.triangles = reinterpret_cast<const std::int32_t*>(geometry.triangles.data());
    a.material = geometry.material.data();
    a.materials = surfaces.materials.data();
    a.textures.rows = surfaces.textures.data();
    a.textures.texels = surfaces.texels.data();
    a.textures.decode = surfaces.decode.data();
    a.textures.levels = surfaces.any_levels && size.x > 0 && size.y > 0;
    for (int c = 0; c < 3; ++c) a.viewer[c] = float(view.orthographic ? -view.forward[c] : view.eye[c]);
    a.viewer[3] = view.orthographic ? 0.0f : 1.0f;
    for (int c = 0; c < 3; ++c) a.forward[c] = float(view.forward[c]);
    if (a.textures.levels)
        a.pixel_area = float(4 / std::abs(view.view_to_clip[0][0] * view.view_to_clip[1][1] * size.x * size.y));
    return a;
}

}  // namespace plumb::raster
