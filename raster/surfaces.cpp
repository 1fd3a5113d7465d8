#include "raster/surfaces.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/host_math.h"

namespace plumb::raster {
namespace {

void append_texture(Surfaces& s, const Image<std::uint32_t>& image, bool nearest, bool srgb) {
    s.textures.insert(s.textures.end(), {std::int32_t(s.texels.size()), image.width, image.height,
                                         (nearest ? 1 : 0) | (srgb ? 2 : 0)});
    for (const std::uint32_t texel : image.texels) s.texels.push_back(std::int32_t(texel));
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

Surfaces prepare(const Scene& scene, const Geometry& geometry) {
    Surfaces s;
    s.decode = decode_table();
    append_texture(s, Image<std::uint32_t>(1, 1, 0xffffffffu), true, false);
    for (const Texture& texture : scene.textures) {
        check(texture, s.texels.size());
        append_texture(s, texture.texels, texture.filter == Filter::nearest, texture.srgb);
    }
    for (const Material& m : scene.materials) {
        if (m.texture < -1 || m.texture >= int(scene.textures.size()))
            throw InputError(fmt::format("material \"{}\": texture = {}: the scene has {}", m.name, m.texture,
                                         scene.textures.size()));
        s.materials.insert(s.materials.end(), {m.reflectance.x, m.reflectance.y, m.reflectance.z, 0,  //
                                               m.emission.x, m.emission.y, m.emission.z, 0,           //
                                               0, 0, 0, 0, 0, 0, 0, 0});
        s.material_texture.push_back(m.texture + 1);
    }
    for (std::size_t t = 0; t < geometry.material.size(); ++t)
        if (geometry.material[t] < 0 || geometry.material[t] >= int(scene.materials.size()))
            throw InputError(fmt::format("triangle {}: material = {}: the scene has {}", t, geometry.material[t],
                                         scene.materials.size()));
    return s;
}

SurfaceArgs surface_args(const Geometry& geometry, const Surfaces& surfaces, const View& view) {
    SurfaceArgs a{};
    a.vertices = reinterpret_cast<const float*>(geometry.vertices.data());  // null where there is none
    a.triangles = reinterpret_cast<const std::int32_t*>(geometry.triangles.data());
    a.material = geometry.material.data();
    a.materials = surfaces.materials.data();
    a.material_texture = surfaces.material_texture.data();
    a.textures = surfaces.textures.data();
    a.texels = surfaces.texels.data();
    a.decode = surfaces.decode.data();
    for (int c = 0; c < 3; ++c) a.viewer[c] = float(view.orthographic ? -view.forward[c] : view.eye[c]);
    a.viewer[3] = view.orthographic ? 0.0f : 1.0f;
    return a;
}

std::vector<Port> surface_ports() {
    return {
        {"vertices", "buffer vec4", "m", "[vertex][2]: position, u; normal, v"},
        {"triangles", "buffer i32", "", "[triangle][3] vertices"},
        {"material", "buffer i32", "", "[triangle] material"},
        {"materials", "buffer vec4", "W/m2", "[material][4]: reflectance; emission; padding"},
        {"material_texture", "buffer i32", "", "[material] texture, 0 = none"},
        {"textures", "buffer i32", "", "[texture][4]: first texel, width, height, 1 nearest | 2 sRGB"},
        {"texels", "buffer i32", "", "RGBA8 texels of all textures"},
        {"decode", "buffer f32", "", "[2][256]: byte to linear value, plain and sRGB"},
    };
}

}  // namespace plumb::raster
