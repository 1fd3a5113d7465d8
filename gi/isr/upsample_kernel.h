// The coarse result to every pixel (ISR 4.5): the algorithm that upsample.comp mirrors line by line.
//
//     w_i' = w_i^b w_i^z,    w_i^z = 1 / (epsilon + |z_p - z_i| / z_p)                                  ISR (27)
//     w_i  = w_i' / sum_j w_j'                                                                          ISR (28)
//
// i the 2 x 2 coarse pixels around p. Coarse pixel i lies at the common corner of its four pixels, 2 i + 1, a full
// pixel X at X + 1/2: along an axis p is X / 2 - 1/4 coarse pixels from the first; bilinear shares are 1/4 and 3/4.
//
// differs: |z_p - z_i| of (27) is a length; here it is a share of the pixel's depth (published: of the far plane's).
// differs: a coarse pixel without a surface has no weight (published: it counts, at depth 0).
// differs: where all w_i' are 0, those that have a surface count by their bilinear share.
//
// One template serves two ways to reach coarse pixels: Texels is UpsampleImageTexels, the images as they are bound, or
// a packet's view of them taken apart into planes (upsample_isa.cpp).
#pragma once

#include <cstddef>

#include "core/number.h"

namespace plumb::isr {

// The twin's uniform block (std140).
struct UpsampleUniforms {
    std::int32_t width, height;                // of the full image
    std::int32_t coarse_width, coarse_height;
    std::int32_t bilateral;                    // 0: bilinear shares alone
    std::int32_t published;
    std::int32_t clip_depth;                   // 1: surface.w of the coarse image is a depth of clip space
    float epsilon;                             // a share of the depth
    float far;                                 // m; read where published and bilateral
    float per_near, per_far_less_near;         // 1/m: 1 / near and 1 / far - 1 / near; read where clip_depth
    std::int32_t padding;
};
static_assert(sizeof(UpsampleUniforms) == 48);

struct UpsampleInputsView {
    UpsampleUniforms u;
    const float* lit;       // [coarse_height][coarse_width] rgba32f: xyz irradiance, W/m2, w accessibility
    const float* surface;   // xyz unit normal, w depth; all 0 where none is
    const float* position;  // [height][width] rgba32f: w linear eye depth, m
    const float* normal;    // xyz unit; all 0 where nothing is
    float* upsampled;       // out: as lit, [height][width]
};

// A coarse pixel.
template <class F>
struct UpsampleTexel {
    vec3<F> irradiance;  // W/m2
    F accessibility;
    F covered;           // 1 where a surface is, else 0
    F depth;             // linear, m; 0 where no surface is
};

// Linear depth: 1 / z is linear in the depth of clip space.
template <class F>
PLUMB_INLINE F coarse_depth(const UpsampleUniforms& u, F depth) {
    if (u.clip_depth == 0) return depth;
    // At an infinite far plane 1 / z is 0, or less by its rounding.
    return F(1.0f) / max(F(u.per_near) + depth * F(u.per_far_less_near), F(1e-30f));
}

template <class F>
PLUMB_INLINE UpsampleTexel<F> coarse_texel(const UpsampleInputsView& in, index_t<F> i) {
    const vec4<F> lit = number<F>::fetch4(in.lit, i), surface = number<F>::fetch4(in.surface, i);
    const vec3<F> n = xyz<F>(surface);
    const mask_t<F> covered = dot3(n, n) > F(0.0f);
    return {xyz<F>(lit), lit.w, select(covered, F(1.0f), F(0.0f)),
            select(covered, coarse_depth<F>(in.u, surface.w), F(0.0f))};
}

// The coarse pixel before and the one after x along an axis.
template <class I>
PLUMB_INLINE I coarse_before(I x) {
    return max((x - I(1)) >> 1, I(0));
}
template <class I>
PLUMB_INLINE I coarse_after(I x, int coarse_size) {
    return min((x + I(1)) >> 1, I(coarse_size - 1));
}

// The 2 x 2 coarse pixels around (px, py), from the images.
template <class F>
struct UpsampleImageTexels {
    const UpsampleInputsView& in;
    index_t<F> px, py;

    PLUMB_INLINE UpsampleTexel<F> at(bool right, bool below) const {
        using I = index_t<F>;
        const I x = right ? coarse_after(px, in.u.coarse_width) : coarse_before(px);
        const I y = below ? coarse_after(py, in.u.coarse_height) : coarse_before(py);
        return coarse_texel<F>(in, y * I(in.u.coarse_width) + x);
    }
};

template <class F, bool bilateral, bool published, class Texels, class Tap>
PLUMB_INLINE vec4<F> upsample_by(const UpsampleInputsView& in, const Texels& texels, index_t<F> px, index_t<F> py,
                                 Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const UpsampleUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const F z = N::fetch4(in.position, pixel).w;                     tap("depth", z, "z_p, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));           tap("n", n, "unit normal");
    const F share_x = select((px & I(1)) == I(0), F(0.75f), F(0.25f));
    const F share_y = select((py & I(1)) == I(0), F(0.75f), F(0.25f));
    const F scale = published ? F(u.far) : max(z, F(1e-37f));        tap("scale", scale, "of depths, m");

    UpsampleTexel<F> coarse[4];
    F weights[4], shares[4];
    F total(0.0f), share(0.0f);
    for (int k = 0; k < 4; ++k) {
        tap.sample(k);
        const bool right = (k & 1) != 0, below = (k & 2) != 0;
        const UpsampleTexel<F> t = texels.at(right, below);          tap("z_i", t.depth, "m");
        coarse[k] = t;
        const F of_x = right ? share_x : F(1.0f) - share_x, of_y = below ? share_y : F(1.0f) - share_y;
        const F bilinear = of_x * of_y;                              tap("bilinear", bilinear, "ISR (27): w^b, exact");
        shares[k] = published ? bilinear : bilinear * t.covered;
        weights[k] = shares[k];
        if (bilateral) {
            const F of_depth = F(1.0f) / (F(u.epsilon) + abs(z - t.depth) / scale);
            tap("of_depth", of_depth, "ISR (27): w^z = 1 / (epsilon + |z_p - z_i| / scale)");
            weights[k] = shares[k] * of_depth;
        }
        tap("weight", weights[k], "ISR (27): w' = w^b w^z");
        share += shares[k];
        total += weights[k];                                         tap("total", total, "sum of the weights so far");
    }
    // Where no weight is left: bilinear, of those that have a surface.
    const mask_t<F> weighed = total > F(0.0f);
    const F divisor = select(weighed, total, select(share > F(0.0f), share, F(1.0f)));
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    F open(0.0f);
    for (int k = 0; k < 4; ++k) {
        tap.sample(k);
        const UpsampleTexel<F>& t = coarse[k];
        const F w = select(weighed, weights[k], shares[k]) / divisor; tap("w", w, "ISR (28)");
        sum.x += w * t.irradiance.x;
        sum.y += w * t.irradiance.y;
        sum.z += w * t.irradiance.z;
        open += w * t.accessibility;
    }
    tap.sample(-1);
    const mask_t<F> lit = (dot3(n, n) > F(0.0f)) & (share > F(0.0f));
    const F zero(0.0f);
    const vec3<F> irradiance = select3<F>(lit, sum, vec3<F>{zero, zero, zero});
    tap("irradiance", irradiance, "ISR 4.5: sum w_i E_i; 0 where no surface is, W/m2");
    const F accessibility = select(lit, open, F(1.0f));
    tap("accessibility", accessibility, "ISR 4.5: sum w_i A_i; 1 where no surface is");
    return vec4<F>(irradiance, accessibility);
}

template <class F, class Texels, class Tap>
PLUMB_INLINE vec4<F> upsample(const UpsampleInputsView& in, const Texels& texels, index_t<F> px, index_t<F> py,
                              Tap& tap) {
    const bool published = in.u.published != 0;
    if (in.u.bilateral == 0)
        return published ? upsample_by<F, false, true>(in, texels, px, py, tap)
                         : upsample_by<F, false, false>(in, texels, px, py, tap);
    return published ? upsample_by<F, true, true>(in, texels, px, py, tap)
                     : upsample_by<F, true, false>(in, texels, px, py, tap);
}

// The coarse rows that a band of full rows lies between, taken apart into planes of full width: at column x the coarse
// pixel before x, and so at column x + 2 the one after it. Each is fetched once for the four rows that read it.
struct UpsamplePlanes {
    enum : int { red, green, blue, open, covered, depth, count };

    float* planes;      // [row][count][stride]: coarse rows first_row ..
    int stride;         // floats
    int first_row;

    static int stride_of(int width) { return ((width + 2 + 15) & ~15) + 16; }
    static std::size_t floats(int width, int rows) {
        return std::size_t(rows / 2 + 2) * count * std::size_t(stride_of(width));
    }
    float* at(int plane, int y) const { return planes + (std::ptrdiff_t(y - first_row) * count + plane) * stride; }
};

struct UpsampleKernel {
    using View = UpsampleInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return upsample<F>(in, UpsampleImageTexels<F>{in, px, py}, px, py, tap);
    }
    static float* out(const View& in) { return in.upsampled; }
    static std::size_t scratch(const View& in, int rows) { return UpsamplePlanes::floats(in.u.width, rows); }
};

}  // namespace plumb::isr
