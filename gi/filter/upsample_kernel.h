// Half-size irradiance to full size (VRSM 4.5): the algorithm that upsample.comp mirrors line by line.
//
// A coarse pixel i was gathered at the full pixel p(i) = min(2 i + 1, width - 1) (reduce_kernel.h). A full pixel X lies
// between the picks i_0 and i_1; along one axis
//
//     X odd             it is a pick: i_0 = i_1 = (X - 1) / 2
//     X even            it lies half-way: i_0 = X / 2 - 1, i_1 = X / 2, with weights 1/2 and 1/2
//     X = 0             before the first pick: i_0 = i_1 = 0
//     X = width - 1     even: p(i_1) = X is a pick
//
// so that every bilinear weight is 0, 1/4, 1/2 or 1, and exact.
//
// differs: a GPU's bilinear filter takes coarse pixels for the middles of 2 x 2 pixels, with weights of 1/4 and 3/4: that
// moves the irradiance by half a pixel towards the origin (variant `published`).
#pragma once

#include "gi/filter/weights_kernel.h"

namespace plumb::filter {

enum class Upsample : int { bilateral, bilinear, published };

// The twin's uniform block (std140).
struct UpsampleUniforms {
    std::int32_t width, height;                // of the full image
    std::int32_t coarse_width, coarse_height;
    std::int32_t mode;                         // Upsample
    std::int32_t similarity;                   // Similarity
    float sigma_depth;                         // of the depth
    float normal_slope, normal_offset;         // 1 / sigma_normal, 1 - 1 / sigma_normal
    std::int32_t padding[3];
};
static_assert(sizeof(UpsampleUniforms) == 48);

struct UpsampleInputsView {
    UpsampleUniforms u;
    const float* coarse_irradiance;  // [coarse_height][coarse_width] rgba32f: xyz W/m2, w linear depth, m
    const float* coarse_position;    // xyz world, m
    const float* coarse_normal;      // xyz unit; all 0 where there is no surface
    const float* position;           // [height][width] rgba32f: xyz world, m, w linear depth, m
    const float* normal;
    float* upsampled;                // out: [height][width] rgba32f
};

// The two coarse pixels that x lies between along an axis of `size` pixels, and the second one's share.
template <class F>
struct Between {
    index_t<F> first, second;
    F share;
};
template <class F>
PLUMB_INLINE Between<F> between(index_t<F> x, int size, int coarse_size, bool published) {
    using I = index_t<F>;
    if (published) {
        // x / 2 - 1/4 coarse pixels from the first.
        const I first = (x - I(1)) >> 1;
        const F share = select((x & I(1)) == I(0), F(0.75f), F(0.25f));
        return {max(first, I(0)), min(first + I(1), I(coarse_size - 1)), share};
    }
    const I first = max((x - I(1)) >> 1, I(0)), second = min(x >> 1, I(coarse_size - 1));
    const I picked = min(second + second + I(1), I(size - 1));
    const F share = select(first == second, F(0.0f), select(picked == x, F(1.0f), F(0.5f)));
    return {first, second, share};
}

template <class F>
PLUMB_INLINE Texel<F> coarse_texel(const UpsampleInputsView& in, index_t<F> i) {
    const vec4<F> irradiance = number<F>::fetch4(in.coarse_irradiance, i);
    return {xyz<F>(irradiance), irradiance.w, xyz<F>(number<F>::fetch4(in.coarse_normal, i)),
            xyz<F>(number<F>::fetch4(in.coarse_position, i))};
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> upsample(const UpsampleInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const UpsampleUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec4<F> x = N::fetch4(in.position, pixel);                 tap("x", xyz<F>(x), "world, m");
    tap("depth", x.w, "linear, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));           tap("n", n, "unit normal of x");
    const bool published = u.mode == int(Upsample::published);
    const Between<F> across = between<F>(px, u.width, u.coarse_width, published);
    const Between<F> down = between<F>(py, u.height, u.coarse_height, published);
    const Centre<F> centre = centre_of(xyz<F>(x), x.w, n, u.sigma_depth, u.normal_slope);

    const F largest(3.4e38f);
    F total(0.0f), least = largest;
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)}, nearest = sum;
    for (int k = 0; k < 4; ++k) {
        tap.sample(k);
        const bool right = (k & 1) != 0, below = (k & 2) != 0;
        const I cx = right ? across.second : across.first, cy = below ? down.second : down.first;
        tap("coarse", ivec2<I>{cx, cy}, "pixel of the half-size image");
        const Texel<F> p = coarse_texel<F>(in, cy * I(u.coarse_width) + cx);
        const F share_x = right ? across.share : F(1.0f) - across.share;
        const F share_y = below ? down.share : F(1.0f) - down.share;
        const F bilinear = share_x * share_y;                        tap("bilinear", bilinear, "its share, exact");
        F weight = bilinear;
        if (u.mode == int(Upsample::bilateral)) {
            const F of_depth = depth_weight(u.similarity == int(Similarity::plane), centre, p, tap);
            const F of_normal = normal_weight(centre, p.normal, u.normal_offset, tap);
            weight = bilinear * of_depth * of_normal;
        }
        tap("weight", weight, "bilinear share x depth x normal");
        sum.x += weight * p.irradiance.x;
        sum.y += weight * p.irradiance.y;
        sum.z += weight * p.irradiance.z;
        total += weight;                                             tap("total", total, "sum of the weights so far");

        // Where no weight is left: the surface that is nearest in depth, of those that have a share.
        const F off = abs(p.depth - x.w);
        const mask_t<F> surface = dot3(p.normal, p.normal) > F(0.0f);
        const mask_t<F> nearer = (bilinear > F(0.0f)) & surface & (off < least);
        least = select(nearer, off, least);
        nearest = select3<F>(nearer, p.irradiance, nearest);
    }
    tap.sample(-1);
    const mask_t<F> weighed = total > F(0.0f);                       tap("weighed", weighed, "0: the nearest in depth");
    const F divisor = select(weighed, total, F(1.0f));
    const vec3<F> mean{sum.x / divisor, sum.y / divisor, sum.z / divisor};
    const mask_t<F> covered = dot3(n, n) > F(0.0f);
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> irradiance = select3<F>(covered, select3<F>(weighed, mean, nearest), zero);
    tap("irradiance", irradiance, "sum / total; 0 where no surface is, W/m2");
    return vec4<F>(irradiance, x.w);
}

struct UpsampleKernel {
    using View = UpsampleInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return upsample<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.upsampled; }
};

}  // namespace plumb::filter
