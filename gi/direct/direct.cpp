#include "gi/direct/direct.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/parallel.h"
#include "gi/direct/bindings.h"
#include "gi/direct/direct_rows.h"
#include "gi/direct/log_blur.h"
#include "raster/light_view.h"

namespace plumb::direct {

namespace {

constexpr int band = raster::Covered::side;

void require_equal_sizes(const char* stage, const Image4* position, const Image4* normal,
                         const raster::Covered* tiles) {
    if (!position || !normal) throw InputError(fmt::format("{}: position and normal must be bound", stage));
    if (position->width != normal->width || position->height != normal->height)
        throw InputError(fmt::format("{}: normal is {} x {}, position is {} x {}: expected equal sizes", stage,
                                     normal->width, normal->height, position->width, position->height));
    if (tiles && !tiles->fits({position->width, position->height}))
        throw InputError(fmt::format("{}: tiles are of another size than position", stage));
}

void validate(const ShadowParams& params, const ShadowInputs& in) {
    ShadowParams copy = params;
    validate_fields("shadow", fields(copy));
    require_equal_sizes("shadow", in.position, in.normal, in.tiles);
    if (in.rsms.size() != 1 && in.rsms.size() != raster::light_faces)
        throw InputError(fmt::format("shadow: {} maps are bound: expected 1, or {} of a point light", in.rsms.size(),
                                     raster::light_faces));
    if (in.blurred.empty()) return;
    if (in.blurred.size() != in.rsms.size())
        throw InputError(fmt::format("shadow: {} blurred maps are bound: expected {}, as of maps", in.blurred.size(),
                                     in.rsms.size()));
    for (std::size_t m = 0; m < in.rsms.size(); ++m)
        if (in.blurred[m].width != in.rsms[m].size || in.blurred[m].height != in.rsms[m].size)
            throw InputError(fmt::format("shadow: blurred map {} is {} x {}: expected {} a side, as the map", m,
                                         in.blurred[m].width, in.blurred[m].height, in.rsms[m].size));
}

// The kernel's view of one of the light's maps.
ShadowInputsView view_of(const ShadowParams& params, const ShadowInputs& in, int face) {
    ShadowInputsView v{};
    v.u = shadow_uniforms(params, in, face);
    v.position = &in.position->data()->x;
    v.normal = &in.normal->data()->x;
    const Image4& map = map_of(in, face);
    v.map_position = map.empty() ? nullptr : &map.data()->x;  // a face that sees nothing is not drawn
    return v;
}

DirectInputsView view_of(const DirectParams& params, const DirectInputs& in,
                         const std::vector<raster::LightArgs>& lights) {
    DirectParams copy = params;
    validate_fields("direct", fields(copy));
    require_equal_sizes("direct", in.position, in.normal, in.tiles);
    if (!in.visibility || in.visibility->size() != lights.size() * in.position->size())
        throw InputError(fmt::format("direct: visibility has {} values: expected {} lights of {} pixels",
                                     in.visibility ? in.visibility->size() : 0, lights.size(), in.position->size()));
    // The kernel counts all of them by one 32-bit index.
    if (in.visibility->size() > 0x7fffffff)
        throw InputError(fmt::format("direct: {} lights of {} pixels: expected at most {} values of visibility",
                                     lights.size(), in.position->size(), 0x7fffffff));
    DirectInputsView v{};
    v.u = direct_uniforms(params, in);
    v.position = &in.position->data()->x;
    v.normal = &in.normal->data()->x;
    v.lights = lights.data();
    v.visibility = in.visibility->data();
    return v;
}

std::vector<raster::LightArgs> args_of(const DirectInputs& in) {
    std::vector<raster::LightArgs> args;
    for (const Light& light : *in.lights) args.push_back(raster::light_args(light));
    return args;
}

const std::uint8_t* tile_row(const raster::Covered* tiles, int y) { return tiles ? tiles->row(y) : nullptr; }

// Writes the visibility of the world's origin to the tiles that are not shaded.
void fill_where_nothing_is(const ShadowParams& params, const ShadowInputs& in, Isa isa, float* visibility) {
    const Image4 nothing(1, 1);
    RunOptions one;
    one.isa = isa, one.threads = 1;
    float value = 1;
    run(params, {&nothing, &nothing, in.rsms, nullptr, in.blurred}, one, &value);
    const int width = in.position->width;
    for (int y = 0; y < in.position->height; ++y)
        for (int x = 0; x < width; x += raster::Covered::side)
            if (!in.tiles->row(y)[x >> raster::Covered::shift])
                std::fill(visibility + std::ptrdiff_t(y) * width + x,
                          visibility + std::ptrdiff_t(y) * width + std::min(x + raster::Covered::side, width), value);
}

}  // namespace

const Image4& map_of(const ShadowInputs& in, int face) {
    return in.blurred.empty() ? in.rsms[std::size_t(face)].position : in.blurred[std::size_t(face)];
}

// A map alone serves every point; of six, each serves its face's.
ShadowUniforms shadow_uniforms(const ShadowParams& params, const ShadowInputs& in, int face) {
    ShadowUniforms u{};
    const raster::Rsm& rsm = in.rsms[std::size_t(face)];
    u.face = in.rsms.size() == 1 ? -1 : face;
    u.map = raster::projection_args(rsm.view, rsm.size, u.face >= 0);
    for (int c = 0; c < 3; ++c) u.eye[c] = float(rsm.view.eye[c]), u.forward[c] = float(rsm.view.forward[c]);
    u.kernel = params.mode == ShadowMode::density ? params.kernel : 1;
    u.soft = int(params.mode == ShadowMode::pcf ? Soft::pcf : params.mode == ShadowMode::esm ? Soft::esm : Soft::none);
    u.c = params.mode == ShadowMode::esm ? c_per_metre(params, in.rsms) : 0;
    u.samples = float(u.kernel * u.kernel);
    u.published = params.variant == ShadowVariant::published ? 1 : 0;
    u.footprint_scale = rsm.view.orthographic ? 0 : float(rsm.texel_scale);
    u.footprint_base = rsm.view.orthographic ? float(rsm.texel_scale) : 0;
    u.bias = params.bias;
    // The farthest texel centre of the kernel lies kernel/2 + 1/2 texels away along a side, of one texel 1/2.
    // The four texels of a soft test lie up to 1 away.
    u.slope_bias = params.slope_bias * float(u.soft != int(Soft::none) ? 2 : 2 * (u.kernel / 2) + 1);
    u.max_slope = params.max_slope;
    u.perspective = rsm.view.orthographic ? 0 : 1;
    u.width = in.position->width;
    u.height = in.position->height;
    return u;
}

DirectUniforms direct_uniforms(const DirectParams& params, const DirectInputs& in) {
    const bool printed = params.variant == DirectVariant::published;
    return {int(in.lights->size()), in.position->width, in.position->height, printed ? 2 : in.density ? 1 : 0};
}

std::vector<Field> fields(DirectParams& p) {
    return {
        {"variant", as_int(p.variant), "",
         "corrected, or VRSM 4.3 as printed: pi times the shadow density, without intensity and cosine", 0, 1,
         {"corrected", "published"}, false},
    };
}

std::vector<Field> fields(ShadowParams& p) {
    return {
        {"mode", as_int(p.mode), "",
         "hard: one texel; density: the share of a kernel of texels (VRSM Algorithm 4); pcf: four comparisons, weighed "
         "bilinearly; esm: four exponentials of the distance behind the map (ISR (30))", 0, 3,
         {"hard", "density", "pcf", "esm"}, false},
        {"variant", as_int(p.variant), "",
         "corrected, or as printed: VRSM Algorithm 4 with a constant bias; of pcf and esm ISR Listing 8", 0, 1,
         {"corrected", "published"}, false},
        {"kernel", &p.kernel, "texels", "side of the kernel of mode = density; 4 is ours", 1, 64, {}, true},
        {"bias", &p.bias, "m", "constant part of the depth bias; ours", 0, unbounded, {}, true},
        {"slope_bias", &p.slope_bias, "texels", "part that follows the surface's slope; 0.71 is exact, 1 is ours", 0, 64,
         {}, true},
        {"max_slope", &p.max_slope, "", "limit of that slope: 16 is a surface at 86 degrees to the light", 0, 1e6, {},
         true},
        {"esm_c", &p.esm_c, "",
         "c of ISR (30), for depths over the light's range (far plane, or depth of the box); 90 is Listing 8's", 1e-3, 1e9,
         {}, true},
        {"esm_blur_radius", &p.esm_blur_radius, "texels",
         "of the logarithmic blur of esm's map (ISR 4.6), 0 none; 3 is ours", 0, most_blur_radius, {}, true},
        {"esm_blur_sigma", &p.esm_blur_sigma, "texels", "of its Gaussian; ours", 0.05, 1e6, {}, false},
    };
}

void run(const ShadowParams& params, const ShadowInputs& in, const RunOptions& options, float* visibility) {
    validate(params, in);
    const int maps = int(in.rsms.size());
    if (maps > 1) std::fill_n(visibility, in.position->size(), 1.0f);
    if (in.tiles) fill_where_nothing_is(params, in, options.isa, visibility);
    for (int face = 0; face < maps; ++face) {
        if (in.rsms[std::size_t(face)].size == 0) continue;
        RunOptions part = options;
        if (options.progress) part.progress = [&, face](double done) { options.progress((face + done) / maps); };
        ShadowInputsView view = view_of(params, in, face);
        view.visibility = visibility;
        dispatch(options.isa, [&](auto isa) {
            parallel_bands(in.position->height, band, part,
                           [&](int first, int last) { Rows<isa()>::shadow(view, first, last, tile_row(in.tiles, first)); });
        });
    }
}

std::vector<TapValue> explain(const ShadowParams& params, const ShadowInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    FpEnvironment environment;
    Recorder recorder;
    int face = 0;
    if (in.rsms.size() > 1) {
        // Take the face that serves the point.
        const vec3<float> x(in.position->operator()(pixel.x, pixel.y));
        while (!serves<float>(view_of(params, in, face).u, x)) ++face;
        recorder("face", std::int32_t(face), "of the point light: +x -x +y -y +z -z");
    }
    if (in.rsms[std::size_t(face)].size == 0)
        recorder("visibility", 1.0f, "the face sees nothing");
    else
        shadow<float>(view_of(params, in, face), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo shadow_info() {
    ShadowParams defaults;
    StageInfo s;
    s.name = "shadow";
    s.source = "VRSM Algorithm 4; ISR 4.6, Listing 8";
    s.inputs = {{"position", "image rgba32f", "m", "world-space position of the shading points"},
                {"normal", "image rgba32f", "", "unit normal of the shading points"},
                {"rsm.position", "image rgba32f", "m",
                 "w: linear light-space depth; 0 where nothing is; of a point light a map a face; mode = esm: blurred"}};
    s.outputs = {{"visibility", "image r32f", "", "1 lit, 0 shadowed; but for the hard test in between"}};
    s.params = describe(fields(defaults));
    s.twin = "gi/direct/shadow.comp";
    return s;
}

void run(const DirectParams& params, const DirectInputs& in, const RunOptions& options, Image4& irradiance) {
    const std::vector<raster::LightArgs> lights = args_of(in);
    DirectInputsView view = view_of(params, in, lights);
    irradiance = Image4(in.position->width, in.position->height);
    view.irradiance = &irradiance.data()->x;
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(irradiance.height, band, options,
                       [&](int first, int last) { Rows<isa()>::direct(view, first, last, tile_row(in.tiles, first)); });
    });
}

std::vector<TapValue> explain(const DirectParams& params, const DirectInputs& in, glm::ivec2 pixel) {
    const std::vector<raster::LightArgs> lights = args_of(in);
    FpEnvironment environment;
    Recorder recorder;
    direct<float>(view_of(params, in, lights), pixel.x, pixel.y, recorder);
    return recorder.values;
}

StageInfo direct_info() {
    DirectParams defaults;
    StageInfo s;
    s.name = "direct";
    s.source = "the rendering equation for point-like lights; LRA 4.4; VRSM 4.3 (shadow density)";
    s.inputs = {{"position", "image rgba32f", "m", "world-space position of the shading points"},
                {"normal", "image rgba32f", "", "unit normal of the shading points; w: 1 on a surface"},
                {"lights", "buffer LightArgs", "W/sr, W/m2", "the lights that are on"},
                {"visibility", "image array r32f", "", "a layer a light: 1 lit, 0 shadowed"}};
    s.outputs = {{"irradiance", "image rgba32f", "W/m2", "direct irradiance; w: shadow density where it is asked for"}};
    s.params = describe(fields(defaults));
    s.twin = "gi/direct/direct.comp";
    return s;
}

}  // namespace plumb::direct
