#include "raster/gbuffer.h"

#include <cmath>

#include "core/formats.h"
#include "core/fp_environment.h"
#include "raster/pass_args.h"
#include "raster/resolve_tiles.h"
#include "raster/visibility.h"
#include "raster/visible_tiles.h"

namespace plumb::raster {
namespace {

// F0, FU, FV of ISR (24) at depth store.range, with f_x and f_y of (23) as its errata have them: f_y = tan(fov_y / 2),
// f_x = aspect f_y, which a projection holds inverted.
void set_frustum(const View& view, GBufferStore& store) {
    const double fx = store.range / std::abs(view.view_to_clip[0][0]);
    const double fy = store.range / std::abs(view.view_to_clip[1][1]);
    const glm::dmat4& m = view.world_to_view;
    for (int c = 0; c < 3; ++c) {
        const double right = m[c][0], up = m[c][1];
        store.corner[c] = float(view.forward[c] * store.range - right * fx + up * fy);
        store.across[c] = float(2 * fx * right);
        store.down[c] = float(-2 * fy * up);
    }
}

GBufferStore store_of(const Layout& layout, const View& view) {
    GBufferStore s;
    s.position = layout.position, s.normal = layout.normal, s.albedo = layout.albedo, s.emission = layout.emission;
    s.depth = layout.depth;
    s.position_from_depth = layout.position_from_depth;
    s.depth_from_position = layout.depth_from_position;
    s.radiation_mask = layout.radiation_mask;
    if (layout.depth_over_far) s.range = float(view.far), s.over_range = float(1 / view.far);
    if (s.position_from_depth) set_frustum(view, s);
    return s;
}

// Makes room for an image that is wanted, unless it is there; every texel will be written.
template <class T>
void fit(Image<T>& image, glm::ivec2 size, bool wanted) {
    if (!wanted)
        image = Image<T>();
    else if (image.width != size.x || image.height != size.y)
        image = Image<T>(size.x, size.y);
}

// Rounds pixels [first, end) of a depth buffer to 24 bits.
void round_depth(const Image1& exact, Image1& depth, glm::ivec2 first, glm::ivec2 end) {
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) depth(x, y) = decode_depth24(encode_d24s8(exact(x, y), 0));
}

}  // namespace

GBufferArgs gbuffer_args(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size) {
    GBufferArgs a{};
    a.surfaces = surface_args(geometry, surfaces, view, size);
    for (int c = 0; c < 3; ++c) a.eye[c] = float(view.eye[c]), a.forward[c] = float(view.forward[c]);
    a.width = size.x, a.height = size.y;
    a.object = geometry.object.data();
    return a;
}

void draw_gbuffer(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size,
                  const Layout& layout, const RunOptions& options, GBuffer& out, const GBufferWants& wants,
                  Workspace* workspace, const Image1* behind) {
    check_gbuffer(layout, geometry, surfaces.brightest, view, wants.emission, options.threads);
    check_frame_size(size);
    check_behind(behind, size);
    fit(out.position, size, wants.position);
    fit(out.normal, size, wants.normal);
    fit(out.albedo, size, wants.albedo);
    fit(out.emission, size, wants.emission);
    fit(out.id, size, wants.id);
    const bool rounds = layout.depth_buffer == Format::d24s8;
    fit(out.depth, size, true);
    fit(out.exact_depth, size, rounds);
    Image1& depth = rounds ? out.exact_depth : out.depth;
    GBufferArgs args = gbuffer_args(geometry, surfaces, view, size);
    args.store = store_of(layout, view);
    if (wants.position) args.position = &out.position.data()->x;
    if (wants.normal) args.normal = &out.normal.data()->x;
    if (wants.albedo) args.albedo = &out.albedo.data()->x;
    if (wants.emission) args.emission = &out.emission.data()->x;
    if (wants.id) args.id = &out.id.data()->x;
    out.covered = Covered(size);
    args.covered = out.covered.any.data();
    args.covered_columns = out.covered.tiles.x;
    dispatch(options.isa, [&](auto isa) {
        auto resolve = [&](const TilePixels& seen) {
            ResolveTile<isa()>::gbuffer(args, seen);
            quantise_rest(layout.albedo, out.albedo, seen.origin, seen.end);
            quantise_rest(layout.emission, out.emission, seen.origin, seen.end);
            if (rounds) round_depth(depth, out.depth, seen.origin, seen.end);
        };
        draw_visible_tiles(geometry, &surfaces, view, size, options, depth, workspace, resolve, behind);
    });
}

std::vector<TapValue> explain_gbuffer(const Geometry& geometry, const Surfaces& surfaces, const View& view,
                                      glm::ivec2 size, glm::ivec2 pixel, const Layout& layout, const Image1* behind) {
    RunOptions one;
    one.threads = 1;
    const VisibilityBuffer visible =
        draw_visibility_rows(geometry, &surfaces, view, size, pixel.y, pixel.y + 1, one, behind);
    const std::int32_t triangle = visible.triangle(pixel.x, pixel.y);
    FpEnvironment environment;
    Recorder recorder;
    if (triangle < 0) {
        recorder("triangle", triangle, "nothing is seen");
        return recorder.values;
    }
    recorder("object", geometry.object[std::size_t(triangle)], "index, of the triangle");
    recorder("z", visible.depth(pixel.x, pixel.y), "of the depth buffer, 0 to 1; not the linear depth");
    GBufferArgs args = gbuffer_args(geometry, surfaces, view, size);
    args.store = store_of(layout, view);
    GBufferPixel<float> p = gbuffer<float>(args, triangle, visible.barycentrics(pixel.x, pixel.y), recorder);

    // What the targets make of it.
    p = stored<float>(args, p, pixel.x, pixel.y);
    auto rest = [&](Format format, const vec4<float>& v) {
        Image4 texel(1, 1, glm::vec4(v.x, v.y, v.z, v.w));
        quantise_rest(format, texel, {0, 0}, {1, 1});
        return vec3<float>(glm::vec3(texel(0, 0)));
    };
    const std::string rounded = "as layout " + layout.name + " stores it";
    recorder("stored_position", xyz<float>(p.position), rounded.c_str());
    recorder("stored_depth", p.position.w, rounded.c_str());
    recorder("stored_normal", xyz<float>(p.normal), rounded.c_str());
    recorder("stored_albedo", rest(layout.albedo, p.albedo), rounded.c_str());
    recorder("stored_emission", rest(layout.emission, p.emission), rounded.c_str());
    return recorder.values;
}

}  // namespace plumb::raster
