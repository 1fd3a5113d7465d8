#include "gi/direct/shadow.h"

#include <algorithm>

#include "gi/direct/log_blur.h"
#include "gi/direct/visibility_filter_kernel.h"
#include "raster/light_view.h"

namespace plumb::direct {

namespace {

void validate(const ShadowParams& params, const ShadowInputs& in) {
    ShadowParams copy = params;
    validate_fields("shadow", fields(copy));
    const Image4& position = bound("shadow", "position", in.position);
    if (in.tiles && !in.tiles->fits(size_of(position))) throw InputError("shadow: tiles are of another size");
    if (in.rsms.size() != 1 && in.rsms.size() != raster::light_faces)
        throw InputError(fmt::format("shadow: {} maps are bound: expected 1, or {} of a point light", in.rsms.size(),
                                     raster::light_faces));
    if (!(in.rounding >= 0 && in.rounding < 1))
        throw InputError(fmt::format("shadow: rounding = {}: expected 0 to below 1", in.rounding));
    if (!in.blurred.empty() && in.blurred.size() != in.rsms.size())
        throw InputError(fmt::format("shadow: {} blurred maps are bound: expected {}, as of maps", in.blurred.size(),
                                     in.rsms.size()));
}

// What the shadow test of that map reads: its own depth, or the blurred one.
const Image4& map_of(const ShadowInputs& in, int face) {
    return in.blurred.empty() ? in.rsms[std::size_t(face)].position : in.blurred[std::size_t(face)];
}

// As printed, and of exponentials, depths alone are known.
Test test_of(const ShadowParams& params) {
    if (params.variant == ShadowVariant::published || params.mode == ShadowMode::esm) return Test::depth;
    return params.test == ShadowTest::planes ? Test::planes : params.test == ShadowTest::plane ? Test::plane : Test::depth;
}

// Side of what is averaged, texels; Listing 8 prints four comparisons.
int kernel_of(const ShadowParams& params) {
    if (params.mode == ShadowMode::density) return params.kernel;
    return params.mode == ShadowMode::pcf && params.variant == ShadowVariant::corrected ? params.pcf_kernel : 1;
}

// A map alone serves every point; of six, each serves its face's.
ShadowUniforms block_of(const ShadowParams& params, const ShadowInputs& in, int face) {
    ShadowUniforms u{};
    const raster::Rsm& rsm = in.rsms[std::size_t(face)];
    u.face = in.rsms.size() == 1 ? -1 : face;
    u.map = raster::projection_args(rsm.view, rsm.size, u.face >= 0);
    for (int c = 0; c < 3; ++c) u.eye[c] = float(rsm.view.eye[c]), u.forward[c] = float(rsm.view.forward[c]);
    u.kernel = kernel_of(params);
    u.soft = int(params.mode == ShadowMode::pcf ? Soft::pcf : params.mode == ShadowMode::esm ? Soft::esm : Soft::none);
    u.c = params.mode == ShadowMode::esm ? c_per_metre(params, in.rsms) : 0;
    u.samples = float(u.kernel * u.kernel);
    u.published = params.variant == ShadowVariant::published ? 1 : 0;
    u.footprint_scale = rsm.view.orthographic ? 0 : float(rsm.texel_scale);
    u.footprint_base = rsm.view.orthographic ? float(rsm.texel_scale) : 0;
    u.bias = params.bias;
    // The farthest texel centre of the kernel lies kernel/2 + 1/2 texels away along a side, of one texel 1/2.
    // Those of a soft test lie up to kernel/2 + 1/2 away.
    u.slope_bias = params.slope_bias * float(u.soft != int(Soft::none) ? u.kernel + 1 : 2 * (u.kernel / 2) + 1);
    u.max_slope = params.max_slope;
    u.perspective = rsm.view.orthographic ? 0 : 1;
    u.test = int(test_of(params));
    u.least_sine = params.least_sine + in.rounding;
    u.rounding = in.rounding;
    // Of coordinates that are rounded by as much as pixels are apart no plane is left.
    u.beside = in.picture && in.rounding < 0x1p-20f && u.test != int(Test::depth) ? 1 : 0;
    u.width = in.position->width;
    u.height = in.position->height;
    return u;
}

// Writes the visibility of the world's origin to the tiles that are not shaded.
void fill_where_nothing_is(const ShadowParams& params, const ShadowInputs& in, Isa isa, float* visibility) {
    const Image4 nothing(1, 1);
    RunOptions one;
    one.isa = isa, one.threads = 1;
    float value = 1;
    run(params, {&nothing, &nothing, in.rsms, nullptr, in.blurred, in.rounding}, one, &value);
    const int width = in.position->width;
    for (int y = 0; y < in.position->height; ++y)
        for (int x = 0; x < width; x += raster::Covered::side)
            if (!in.tiles->row(y)[x >> raster::Covered::shift])
                std::fill(visibility + std::ptrdiff_t(y) * width + x,
                          visibility + std::ptrdiff_t(y) * width + std::min(x + raster::Covered::side, width), value);
}

}  // namespace

std::vector<Field> fields(ShadowParams& p) {
    return {
        {"mode", as_int(p.mode), "",
         "hard: one texel; density: the share of a kernel of texels (VRSM Algorithm 4); pcf: the share of a square around "
         "the point; esm: four exponentials of the distance behind the map (ISR (30))", 0, 3,
         {"hard", "density", "pcf", "esm"}, false},
        {"variant", as_int(p.variant), "",
         "corrected, or as printed: VRSM Algorithm 4 with a constant bias; of pcf and esm ISR Listing 8", 0, 1,
         {"corrected", "published"}, false},
        {"kernel", &p.kernel, "texels", "side of the kernel of mode = density; 4 is ours", 1, 64, {}, true},
        {"pcf_kernel", &p.pcf_kernel, "texels", "side of the square of mode = pcf; 1: four comparisons, weighed bilinearly", 1, 64,
         {}, true},
        {"test", as_int(p.test), "",
         "what shadows, of hard, density and pcf: depth: what is nearer than the point, by a bias; plane: what lies over the "
         "point's plane; planes: and has the point under its own", 0, 2, {"depth", "plane", "planes"}, false},
        {"least_sine", &p.least_sine, "",
         "sine of the angle over the point's plane up to which nothing shadows within the texels that are read, for normals that are "
         "not the surface's own; of test = plane and planes; ours", 0, 1, {}, true},
        {"bias", &p.bias, "m", "how far from a plane lies on it; of test = depth the constant part of the depth bias; ours", 0,
         unbounded, {}, true},
        {"slope_bias", &p.slope_bias, "texels",
         "part of the depth bias that follows the surface's slope; 0.71 is exact, 1 is ours", 0, 64, {}, true},
        {"max_slope", &p.max_slope, "", "limit of that slope: 16 is a surface at 86 degrees to the light", 0, 1e6, {},
         true},
        {"esm_c", &p.esm_c, "",
         "c of ISR (30), for depths over the light's range (far plane, or depth of the box); 90 is Listing 8's", 1e-3, 1e9,
         {}, true},
        {"esm_blur_radius", &p.esm_blur_radius, "texels",
         "of the logarithmic blur of esm's map (ISR 4.6), 0 none; 3 is ours", 0, most_blur_radius, {}, true},
        {"esm_blur_sigma", &p.esm_blur_sigma, "texels", "of its Gaussian; ours", 0.05, 1e6, {}, false},
        {"filter", as_int(p.filter), "",
         "of the frame's shadows, a light at a time, along rows and then columns (ISR 4.7): gaussian, or edge_aware: times "
         "how alike pixels are in depth and normal (VRSM 4.5)", 0, 2, {"none", "gaussian", "edge_aware"}, true},
        {"filter_radius", &p.filter_radius, "pixels", "of that filter; ours", 1, most_filter_radius, {}, true},
        {"filter_sigma", &p.filter_sigma, "pixels", "of its Gaussian; ours", 0.05, 1e6, {}, false},
        {"filter_sigma_depth", &p.filter_sigma_depth, "depths",
         "of edge_aware: as far from the pixel's plane, in shares of its depth, nothing counts; ours", 1e-6, 1e6, {}, true},
        {"filter_sigma_normal", &p.filter_sigma_normal, "",
         "of edge_aware: nor where 1 - cosine of the normals is this; ours", 1e-4, 1, {}, true},
    };
}

bool reads_normals(const ShadowParams& params) { return test_of(params) == Test::planes; }

float rounding_of(const raster::Layout& layout) {
    const bool half = layout.position == Format::rgba16f || layout.rsm_position == Format::rgba16f;
    return half ? 0x1p-10f : 0x1p-22f;
}

StageData data_of(const ShadowParams& params, const ShadowInputs& in, int face) {
    validate(params, in);
    StageData d = begin_data<ShadowKernel>(size_of(*in.position), block_of(params, in, face));
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"map_position", &map_of(in, face)}});
    static const Image4 nothing(1, 1);
    lend(d, {{"map_normal", reads_normals(params) ? &in.rsms[std::size_t(face)].normal : &nothing}});
    lend_tiles(d, in.tiles);
    return d;
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
        run(stage<ShadowKernel>(), data_of(params, in, face), part, visibility);
    }
}

std::vector<TapValue> explain(const ShadowParams& params, const ShadowInputs& in, glm::ivec2 pixel) {
    validate(params, in);
    Recorder recorder;
    int face = 0;
    if (in.rsms.size() > 1) {
        // Take the face that serves the point.
        const vec3<float> x(in.position->operator()(pixel.x, pixel.y));
        while (!serves<float>(block_of(params, in, face), x)) ++face;
        recorder("face", std::int32_t(face), "of the point light: +x -x +y -y +z -z");
    }
    if (in.rsms[std::size_t(face)].size == 0) {
        recorder("visibility", 1.0f, "the face sees nothing");
    } else {
        const std::vector<TapValue> taps = explain(stage<ShadowKernel>(), data_of(params, in, face), pixel);
        recorder.values.insert(recorder.values.end(), taps.begin(), taps.end());
    }
    return recorder.values;
}

}  // namespace plumb::direct
