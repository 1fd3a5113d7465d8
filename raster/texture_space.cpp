#include "raster/texture_space.h"

#include <fmt/format.h>

#include "core/error.h"
#include "raster/bindings.h"
#include "raster/resolve_tiles.h"
#include "raster/visibility_kernel.h"
#include "raster/workspace.h"

namespace plumb::raster {
namespace {

// The unit square becomes the frame; every triangle lies at depth 0, so that the first one stays.
Buffer<glm::vec4> clip_from_uv(const std::vector<glm::vec2>& uv, std::size_t vertices) {
    if (uv.size() != vertices)
        throw InputError(fmt::format("texture_space: {} texture coordinates: expected one for each of {} vertices",
                                     uv.size(), vertices));
    Buffer<glm::vec4> clip(uv.size());
    for (std::size_t i = 0; i < uv.size(); ++i) {
        if (!(uv[i].x - uv[i].x == 0 && uv[i].y - uv[i].y == 0))
            throw InputError(fmt::format("texture_space: vertex {}: texture coordinate ({}, {}): expected finite numbers",
                                         i, uv[i].x, uv[i].y));
        clip[i] = {float(2 * double(uv[i].x) - 1), float(2 * double(uv[i].y) - 1), 0, 1};
    }
    return clip;
}

// Makes room for an image, unless it is there; every texel will be written.
template <class T>
void fit(Image<T>& image, glm::ivec2 size) {
    if (image.width != size.x || image.height != size.y) image = Image<T>(size.x, size.y);
}

}  // namespace

std::vector<glm::vec2> texture_coordinates(const Geometry& geometry) {
    std::vector<glm::vec2> uv;
    uv.reserve(geometry.vertices.size());
    for (const Vertex& v : geometry.vertices) uv.push_back({v.u, v.v});
    return uv;
}

void draw_texture_space(const Geometry& geometry, const Surfaces& surfaces, const std::vector<glm::vec2>& uv,
                        glm::ivec2 size, const RunOptions& options, TextureSpace& out, Workspace* workspace) {
    const Buffer<glm::vec4> clip = clip_from_uv(uv, geometry.vertices.size());
    check_frame_size(size);
    for (Image4* image : {&out.position, &out.normal, &out.albedo, &out.emission}) fit(*image, size);
    fit(out.id, size);
    fit(out.barycentrics, size);
    // A viewer of no direction leaves every normal on the front of its face.
    GBufferArgs args{};
    args.surfaces = surface_args(geometry, surfaces, View{});
    for (float& c : args.surfaces.viewer) c = 0;
    args.width = size.x;
    args.position = &out.position.data()->x;
    args.normal = &out.normal.data()->x;
    args.albedo = &out.albedo.data()->x;
    args.emission = &out.emission.data()->x;
    Image<std::int32_t> triangle(size.x, size.y);
    Workspace temporary;
    Workspace& memory = workspace ? *workspace : temporary;
    dispatch(options.isa, [&](auto isa) {
        auto resolve = [&](const TilePixels& seen) {
            ResolveTile<isa()>::gbuffer(args, seen);
            VisibilityKernels<isa()>::write_rows(seen, size.x, triangle.data(), &out.barycentrics.data()->x);
            for (int y = seen.origin.y; y < seen.end.y; ++y)
                for (int x = seen.origin.x; x < seen.end.x; ++x) {
                    const std::int32_t t = triangle(x, y);
                    out.id(x, y) = t < 0 ? glm::ivec3(-1)
                                         : glm::ivec3(geometry.object[std::size_t(t)], t,
                                                      geometry.material[std::size_t(t)]);
                }
        };
        draw_visible_tiles(geometry, &surfaces, clip, false, size, options, memory.depth, &memory, resolve);
    });
}

StageInfo info_texture_space() {
    StageInfo s;
    s.name = "texture_space";
    s.source = "IPR 3.2.1.2; a draw for its caller, so bound to no data of its own: the gbuffer's, with clip_positions "
               "made of uv and a viewer of zeros";
    s.inputs = surface_ports();
    s.inputs.push_back({"uv", "buffer f32 x 2", "", "[vertex] lightmap coordinate, (0, 0) is the top left corner"});
    s.outputs = {
        {"position", "image rgba32f", "m", "world-space position of the texel's centre"},
        {"normal", "image rgba32f", "", "unit normal on the front of the triangle; w: 1 covered"},
        {"albedo", "image rgba32f", "", "diffuse reflectance rho, linear"},
        {"emission", "image rgba32f", "W/m2", "radiant exitance"},
        {"id", "image rgb32i", "", "object, triangle, material; -1 where no surface is"},
    };
    s.twin = "raster/gbuffer.frag";
    return s;
}

}  // namespace plumb::raster
