#include "raster/gbuffer.h"

#include "core/formats.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "raster/resolve_rows.h"
#include "raster/visibility.h"

namespace plumb::raster {
namespace {

constexpr int band_rows = 16;

GBufferArgs args_of(const Geometry& geometry, const Surfaces& surfaces, const View& view,
                    const VisibilityBuffer& visible) {
    GBufferArgs a{};
    a.surfaces = surface_args(geometry, surfaces, view);
    for (int c = 0; c < 3; ++c) a.eye[c] = float(view.eye[c]), a.forward[c] = float(view.forward[c]);
    a.width = visible.triangle.width;
    a.triangle = visible.triangle.data();
    a.barycentrics = &visible.barycentrics.data()->x;
    return a;
}

void quantise_rows(Image4& image, int first, int last) {
    for (int y = first; y < last; ++y)
        for (int x = 0; x < image.width; ++x) quantise(Format::rgba16f, image(x, y));
}

}  // namespace

void draw_gbuffer(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size,
                  const Layout& layout, const RunOptions& options, GBuffer& out) {
    RunOptions half = options;
    if (options.progress) half.progress = [&](double share) { options.progress(0.5 * share); };
    VisibilityBuffer visible = draw_visibility(geometry, view, size, half);
    if (options.progress) half.progress = [&](double share) { options.progress(0.5 + 0.5 * share); };

    const glm::vec4 nothing(0);
    out.position = Image4(size.x, size.y, nothing);
    out.normal = Image4(size.x, size.y, nothing);
    out.albedo = Image4(size.x, size.y, nothing);
    out.emission = Image4(size.x, size.y, nothing);
    out.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
    GBufferArgs args = args_of(geometry, surfaces, view, visible);
    args.position = &out.position.data()->x;
    args.normal = &out.normal.data()->x;
    args.albedo = &out.albedo.data()->x;
    args.emission = &out.emission.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(size.y, band_rows, half, [&](int first, int last) {
            ResolveRows<isa()>::gbuffer(args, first, last);
            for (int y = first; y < last; ++y)
                for (int x = 0; x < size.x; ++x)
                    if (const std::int32_t t = visible.triangle(x, y); t >= 0)
                        out.id(x, y) = {geometry.object[std::size_t(t)], t};
            if (layout == Layout::rgba16f)
                for (Image4* image : {&out.position, &out.normal, &out.albedo, &out.emission})
                    quantise_rows(*image, first, last);
        });
    });
    out.depth = std::move(visible.depth);
}

std::vector<TapValue> explain_gbuffer(const Geometry& geometry, const Surfaces& surfaces, const View& view,
                                      glm::ivec2 size, glm::ivec2 pixel) {
    RunOptions one;
    one.threads = 1;
    const VisibilityBuffer visible = draw_visibility_rows(geometry, view, size, pixel.y, pixel.y + 1, one);
    const std::int32_t triangle = visible.triangle(pixel.x, pixel.y);
    FpEnvironment environment;
    Recorder recorder;
    if (triangle < 0) {
        recorder("triangle", triangle, "nothing is seen");
        return recorder.values;
    }
    recorder("object", geometry.object[std::size_t(triangle)], "index, of the triangle");
    recorder("z", visible.depth(pixel.x, pixel.y), "of the depth buffer, 0 to 1; not the linear depth");
    gbuffer<float>(args_of(geometry, surfaces, view, visible), triangle, visible.barycentrics(pixel.x, pixel.y),
                   recorder);
    return recorder.values;
}

StageInfo info_gbuffer() {
    StageInfo s;
    s.name = "gbuffer";
    s.source = "ISR 4.2-4.3, VRSM 4.2, LRA 4.2.1";
    s.inputs = surface_ports();
    s.outputs = {
        {"position", "image rgba32f", "m", "world-space position; w: linear eye depth"},
        {"normal", "image rgba32f", "", "unit normal on the side that is seen; w: 1 covered"},
        {"albedo", "image rgba32f", "", "diffuse reflectance rho, linear"},
        {"emission", "image rgba32f", "W/m2", "radiant exitance"},
        {"depth", "image r32f", "", "z of the depth buffer"},
        {"id", "image rg32i", "", "object, triangle; -1 where nothing is seen"},
    };
    s.twin = "raster/gbuffer.frag";
    return s;
}

}  // namespace plumb::raster
