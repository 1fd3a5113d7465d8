#include "raster/rsm.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>

#include "core/error.h"
#include "core/formats.h"
#include "core/fp_environment.h"
#include "core/large_pages.h"
#include "raster/light_view.h"
#include "raster/pass_args.h"
#include "raster/resolve_tiles.h"
#include "raster/rsm_rows.h"
#include "raster/visibility.h"
#include "raster/visible_tiles.h"
#include "raster/workspace.h"

namespace plumb::raster {
namespace {

void validate(const Light& light) {
    if (light.rsm_size < 1 || light.rsm_size > max_frame_side)
        throw InputError(fmt::format("rsm: light \"{}\": rsm_size = {}: expected 1 to {} texels", light.name,
                                     light.rsm_size, max_frame_side));
}

// The map's half side, at depth 1 m or in metres: what the projection divides by.
double half_width(const View& view) { return 1 / view.view_to_clip[0][0]; }

RsmStore store_of(const Layout& layout) {
    return {layout.rsm_position, layout.rsm_normal, layout.rsm_flux, layout.rsm_depth};
}

// Makes room for a map, unless it is there; every texel will be written, and the padding of the records stays 0.
void fit(int size, bool half, const RsmWants& wants, Rsm& out) {
    for (Image4* image : {&out.position, &out.normal, &out.flux}) {
        if ((image == &out.normal && !wants.normals()) || (image == &out.flux && !wants.light))
            *image = Image4();
        else if (image->width != size || image->height != size)
            *image = Image4(size, size);
    }
    const std::size_t components = wants.light ? std::size_t(size) * std::size_t(size) * record_stride : 0;
    // A gather reads a record here and one there: with small pages a map of 2048^2 texels costs 1.4 times the time.
    resize_in_large_pages(out.half_records, half ? components : 0);
    resize_in_large_pages(out.records, half ? 0 : components);
    out.size = size;
    out.half = half;
}

// The bits of the largest magnitude among pixels [first, end): those of a float, in the order of floats; what is not a
// number is larger than any.
std::uint32_t largest_bits(const Image4& image, glm::ivec2 first, glm::ivec2 end) {
    std::uint32_t largest = 0;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) {
            const glm::vec4& texel = image(x, y);
            for (int c = 0; c < 3; ++c) largest = std::max(largest, std::bit_cast<std::uint32_t>(texel[c]) & 0x7fffffff);
        }
    return largest;
}

}  // namespace

RsmArgs rsm_args(const Geometry& geometry, const Surfaces& surfaces, const Light& light, const View& view) {
    RsmArgs a{};
    a.surfaces = surface_args(geometry, surfaces, view, glm::ivec2(light.rsm_size));
    for (int c = 0; c < 3; ++c) a.eye[c] = float(view.eye[c]), a.forward[c] = float(view.forward[c]);
    a.light = light_args(light);
    a.texel_scale = float(2 * half_width(view) / light.rsm_size);
    a.half_width = float(half_width(view));
    a.size = light.rsm_size;
    return a;
}

Rsm unseen_rsm(const Light& light, const View& light_view) {
    validate(light);
    Rsm out;
    out.size = light.rsm_size;
    out.view = light_view;
    out.type = light.type;
    for (Image4* image : {&out.position, &out.normal, &out.flux}) *image = Image4(out.size, out.size);
    out.texel_scale = 2 * half_width(light_view) / out.size;
    return out;
}

void draw_rsm(const Geometry& geometry, const Surfaces& surfaces, const Light& light, const View& light_view,
              const Layout& layout, const RunOptions& options, Rsm& out, Workspace* workspace,
              const RsmWants& wants) {
    validate(light);
    check_rsm(layout, light, geometry, surfaces.brightest, light_view, wants.light, options.threads);
    const int size = light.rsm_size;
    fit(size, layout.half_records(), wants, out);
    out.view = light_view;
    out.type = light.type;
    out.texel_scale = 2 * half_width(light_view) / size;
    RsmArgs args = rsm_args(geometry, surfaces, light, light_view);
    RsmImages images{&out.position.data()->x, nullptr, nullptr};
    if (wants.normals()) images.normal = &out.normal.data()->x;
    if (wants.light) images.flux = &out.flux.data()->x;
    args.position = images.position, args.normal = images.normal, args.flux = images.flux;
    const RsmStore store = store_of(layout);
    Workspace temporary;
    Workspace& memory = workspace ? *workspace : temporary;
    std::atomic<std::uint32_t> flux_bits{0};
    dispatch(options.isa, [&](auto isa) {
        auto resolve = [&](const TilePixels& seen) {
            ResolveTile<isa()>::rsm(args, seen, store);
            if (!wants.light) return;
            quantise_rest(layout.rsm_flux, out.flux, seen.origin, seen.end);
            for (int y = seen.origin.y; y < seen.end.y; ++y) {
                const std::ptrdiff_t row = std::ptrdiff_t(y) * size;
                const std::ptrdiff_t first = row + seen.origin.x, end = row + seen.end.x;
                if (out.half)
                    RsmRows<isa()>::pack(images, out.half_records.data(), first, end);
                else
                    RsmRows<isa()>::pack(images, out.records.data(), first, end);
            }
            const std::uint32_t bits = largest_bits(out.flux, seen.origin, seen.end);
            for (std::uint32_t now = flux_bits; bits > now && !flux_bits.compare_exchange_weak(now, bits);) {}
        };
        draw_visible_tiles(geometry, &surfaces, light_view, {size, size}, options, memory.depth, &memory, resolve);
    });
    out.largest_flux = wants.light ? std::bit_cast<float>(flux_bits.load()) : Rsm().largest_flux;
}

std::vector<TapValue> explain_rsm(const Geometry& geometry, const Surfaces& surfaces, const Light& light,
                                  const View& light_view, glm::ivec2 texel, const Layout& layout) {
    validate(light);
    RunOptions one;
    one.threads = 1;
    const VisibilityBuffer visible =
        draw_visibility_rows(geometry, &surfaces, light_view, {light.rsm_size, light.rsm_size}, texel.y,
                             texel.y + 1, one);
    const std::int32_t triangle = visible.triangle(texel.x, texel.y);
    FpEnvironment environment;
    Recorder recorder;
    if (triangle < 0) {
        recorder("triangle", triangle, "nothing is seen");
        return recorder.values;
    }
    recorder("object", geometry.object[std::size_t(triangle)], "index, of the triangle");
    recorder("z", visible.depth(texel.x, texel.y), "of the depth buffer, 0 to 1; not the linear depth");
    RsmTexel<float> t = rsm<float>(rsm_args(geometry, surfaces, light, light_view), texel.x, texel.y, triangle,
                                   visible.barycentrics(texel.x, texel.y), recorder);

    // What the targets make of it.
    t = stored<float>(store_of(layout), t);
    Image4 flux(1, 1, glm::vec4(t.flux.x, t.flux.y, t.flux.z, t.flux.w));
    quantise_rest(layout.rsm_flux, flux, {0, 0}, {1, 1});
    const std::string rounded = "as layout " + layout.name + " stores it";
    recorder("stored_position", xyz<float>(t.position), rounded.c_str());
    recorder("stored_depth", t.position.w, rounded.c_str());
    recorder("stored_normal", xyz<float>(t.normal), rounded.c_str());
    recorder("stored_flux", vec3<float>(glm::vec3(flux(0, 0))), rounded.c_str());
    return recorder.values;
}

}  // namespace plumb::raster
