// The buffers of a quarter of the pixels (ISR Listing 3): the algorithm that downsample.comp mirrors line by line.
//
// A coarse pixel (x, y) is the mean over the full pixels (2 x, 2 y) .. (2 x + 1, 2 y + 1) that exist and see a surface.
//
// At native resolution (ISR chapter 6) it is the pixel (x, y) itself.
//
// differs: the thesis averages all four, whatever they see, lets normals shorten, and sends the unlit colour
// (variant `published`).
#pragma once

#include "core/number.h"

namespace plumb::isr {

// The twin's uniform block (std140).
struct DownsampleUniforms {
    std::int32_t width, height;            // coarse
    std::int32_t full_width, full_height;
    std::int32_t what;                     // Coarse: 0 surface, 1 radiosity, 2 reflectance
    std::int32_t published;
    std::int32_t clip_depth;               // 1: the surface's w is clip depth
    float depth_slope, depth_offset;       // clip depth: slope + offset / z
    std::int32_t native;                   // 1: a coarse pixel is one of the full image
    std::int32_t padding[2];
};
static_assert(sizeof(DownsampleUniforms) == 48);

// Images are [full_height][full_width] rgba32f; those that `what` does not read may be null.
struct DownsampleInputsView {
    DownsampleUniforms u;
    const float* position;  // w: linear eye depth, m
    const float* normal;    // xyz unit, w 1; all 0 where nothing is
    const float* albedo;    // rho; w: radiation mask where above 0
    const float* emission;  // W/m2
    const float* direct;    // irradiance, W/m2
    float* coarse;          // out: [height][width] rgba32f
};

// rho, and as w the radiation mask: the layout's, or the luminance of rho, ISR (17).
template <class F>
PLUMB_INLINE vec4<F> reflectance_of(const DownsampleInputsView& in, index_t<F> i) {
    const vec4<F> rho = number<F>::fetch4(in.albedo, i);
    const F luminance = F(0.27f) * rho.x + F(0.67f) * rho.y + F(0.06f) * rho.z;
    return vec4<F>(xyz<F>(rho), select(rho.w > F(0.0f), rho.w, luminance));
}

// What is averaged.
template <class F>
PLUMB_INLINE vec4<F> value_of(const DownsampleInputsView& in, index_t<F> i, const vec4<F>& normal) {
    using N = number<F>;
    if (in.u.what == 0) return vec4<F>(xyz<F>(normal), N::fetch4(in.position, i).w);
    const vec4<F> rho = reflectance_of<F>(in, i);
    if (in.u.what == 2) return vec4<F>(xyz<F>(rho), F(0.0f));
    if (in.u.published != 0) return rho;
    const vec4<F> m = N::fetch4(in.emission, i), e = N::fetch4(in.direct, i);
    return {m.x + rho.x * e.x, m.y + rho.y * e.y, m.z + rho.z * e.z, rho.w};
}

// The mean of the normals made unit; where they cancel, the first.
template <class F>
PLUMB_INLINE vec3<F> unit_or(const vec3<F>& sum, const vec3<F>& first) {
    const F length2 = dot3(sum, sum);
    const mask_t<F> cancel = length2 < F(1e-6f);
    const F length = sqrt(select(cancel, F(1.0f), length2));
    const vec3<F> unit{sum.x / length, sum.y / length, sum.z / length};
    return select3<F>(cancel, first, unit);
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> downsample(const DownsampleInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const DownsampleUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    vec4<F> sum{zero, zero, zero, zero};
    vec3<F> first{zero, zero, zero};
    F total(0.0f);
    for (int k = 0; k < (u.native != 0 ? 1 : 4); ++k) {
        tap.sample(k);
        const I x = u.native != 0 ? px : px + px + I(k & 1), y = u.native != 0 ? py : py + py + I(k >> 1);
        const mask_t<F> inside = in_range(x, I(u.full_width)) & in_range(y, I(u.full_height));
        const I i = min(y, I(u.full_height - 1)) * I(u.full_width) + min(x, I(u.full_width - 1));
        const vec4<F> normal = N::fetch4(in.normal, i);           tap("normal", xyz<F>(normal), "unit normal");
        const mask_t<F> covered = inside & (normal.w > zero);     tap("covered", covered, "1 if it exists, with a surface");
        const vec4<F> value = value_of<F>(in, i, normal);         tap("value", xyz<F>(value), "what is averaged");
        tap("value_w", value.w, "m, or the radiation mask");
        // A mean of four (published) counts what is not there as a GPU reads it: the border again, and background.
        const F weight = u.published != 0 ? one : select(covered, one, zero);
        const mask_t<F> counted = weight > zero;
        first = select3<F>(counted & (total == zero), xyz<F>(normal), first);
        const vec4<F> term{select(counted, value.x, zero), select(counted, value.y, zero), select(counted, value.z, zero),
                           select(counted, value.w, zero)};
        // Drivers take 0 + -0 for -0: the sum does not begin with 0.
        sum = k == 0 ? term : vec4<F>{sum.x + term.x, sum.y + term.y, sum.z + term.z, sum.w + term.w};
        total += weight;                                          tap("total", total, "pixels so far");
    }
    tap.sample(-1);
    const F divisor = max(total, one);
    vec3<F> mean{sum.x / divisor, sum.y / divisor, sum.z / divisor};
    F w = sum.w / divisor;
    if (u.what == 0) {
        if (u.published == 0) mean = unit_or<F>(xyz<F>(sum), first);
        // 1e-30 m: nothing is divided by 0.
        const F clip = F(u.depth_slope) + F(u.depth_offset) / max(w, F(1e-30f));
        if (u.clip_depth != 0) w = select(total > zero, clip, zero);
    }
    tap("mean", mean, "over those that see a surface; a normal is made unit");
    tap("mean_w", w, "depth, m (inverse_matrix: of clip space); or the radiation mask");
    return vec4<F>(mean, w);
}

struct DownsampleKernel {
    using View = DownsampleInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return downsample<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.coarse; }
};

}  // namespace plumb::isr
