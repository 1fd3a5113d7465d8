// The edge-aware blur of VRSM 4.5, a variation of bilateral filtering: the algorithm that blur.comp mirrors line by line.
//
//     E = sum_i w_i E_i / sum_i w_i,    w_i = spatial_i depth_weight_i normal_weight_i
//
// over a kernel of 17 x 17 pixels, or 17 x 1 and then 1 x 17 (the separable form). The centre's own weight is 1, whatever
// its normal's length: the table of spatial weights has 0 in its place, and the sums begin with it.
//
// One template serves two ways to reach a pixel's neighbours: Texels is ImageTexels, the images as they are bound, or a
// packet's view of them taken apart into planes (BlurPlanes).
#pragma once

#include <cstddef>

#include "gi/filter/weights_kernel.h"

namespace plumb::filter {

// The twin's uniform block (std140).
struct BlurUniforms {
    std::int32_t width, height;
    std::int32_t radius_x, radius_y;    // of the kernel, pixels
    std::int32_t similarity;            // Similarity
    float sigma_depth;                  // of the depth
    float normal_slope, normal_offset;  // 1 / sigma_normal, 1 - 1 / sigma_normal
};
static_assert(sizeof(BlurUniforms) == 32);

// Images are [height][width] rgba32f.
struct BlurInputsView {
    BlurUniforms u;
    const float* irradiance;  // xyz W/m2, w linear depth, m
    const float* position;    // xyz world, m
    const float* normal;      // xyz unit; all 0 where there is no surface
    const float* spatial;     // [2 radius_y + 1][2 radius_x + 1]; 0 in the middle
    float* blurred;           // out: xyz W/m2, w linear depth, m
};

// The pixels around (px, py), from the images. Beyond the border there is no surface.
template <class F>
struct ImageTexels {
    const BlurInputsView& in;
    index_t<F> px, py;

    PLUMB_INLINE Texel<F> at(int dx, int dy) const {
        using N = number<F>;
        using I = index_t<F>;
        const I x = px + I(dx), y = py + I(dy);
        const mask_t<F> inside = in_range(x, I(in.u.width)) & in_range(y, I(in.u.height));
        const I i = select(inside, y * I(in.u.width) + x, I(0));
        const F zero(0.0f);
        const vec3<F> none{zero, zero, zero};
        const vec4<F> irradiance = N::fetch4(in.irradiance, i);
        return {select3<F>(inside, xyz<F>(irradiance), none), select(inside, irradiance.w, zero),
                select3<F>(inside, xyz<F>(N::fetch4(in.normal, i)), none),
                select3<F>(inside, xyz<F>(N::fetch4(in.position, i)), none)};
    }
};

template <class F, bool plane, class Texels, class Tap>
PLUMB_INLINE vec4<F> blur_by(const BlurUniforms& u, const float* spatial, const Texels& texels, Tap& tap) {
    const Texel<F> c = texels.at(0, 0);
    tap("x", c.position, "world, m");
    tap("depth", c.depth, "linear, m");
    tap("n", c.normal, "unit normal of x");
    const Centre<F> centre = centre_of(c.position, c.depth, c.normal, u.sigma_depth, u.normal_slope);

    vec3<F> sum = c.irradiance;
    F total(1.0f);
    int k = 0;
    for (int dy = -u.radius_y; dy <= u.radius_y; ++dy)
        for (int dx = -u.radius_x; dx <= u.radius_x; ++dx, ++k) {
            tap.sample(k);
            const Texel<F> p = texels.at(dx, dy);
            tap("irradiance_i", p.irradiance, "W/m2");
            const F of_depth = depth_weight(plane, centre, p, tap);
            const F of_normal = normal_weight(centre, p.normal, u.normal_offset, tap);
            const F weight = F(spatial[k]) * of_depth * of_normal;
            tap("weight", weight, "VRSM 4.5: spatial x depth x normal");
            sum.x += weight * p.irradiance.x;
            sum.y += weight * p.irradiance.y;
            sum.z += weight * p.irradiance.z;
            total += weight;
            tap("total", total, "sum of the weights so far");
        }
    tap.sample(-1);
    const mask_t<F> covered = dot3(c.normal, c.normal) > F(0.0f);
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    const vec3<F> mean{sum.x / total, sum.y / total, sum.z / total};
    const vec3<F> irradiance = select3<F>(covered, mean, zero);
    tap("irradiance", irradiance, "sum / total; 0 where no surface is, W/m2");
    return vec4<F>(irradiance, c.depth);
}

template <class F, class Texels, class Tap>
PLUMB_INLINE vec4<F> blur(const BlurUniforms& u, const float* spatial, const Texels& texels, Tap& tap) {
    if (u.similarity == int(Similarity::plane)) return blur_by<F, true>(u, spatial, texels, tap);
    return blur_by<F, false>(u, spatial, texels, tap);
}

// The images around a band of rows, taken apart into planes: a packet then reads its neighbours side by side, where
// fetch4() would collect and transpose them, which takes longer than their weights. Padding stands for what lies beyond
// the border: no surface.
struct BlurPlanes {
    enum : int { red, green, blue, depth, normal_x, normal_y, normal_z, position_x, position_y, position_z, count };
    static constexpr int padding = 16;  // floats before the first pixel and after the last; the largest radius is 16

    float* planes;     // [row][count][stride]: rows first - radius_y .. last + radius_y
    int stride;        // floats
    int first_row;     // of the image: may lie above it

    static int stride_of(int width) { return ((width + 15) & ~15) + 2 * padding; }
    static std::size_t floats(int width, int rows, int radius_y) {
        return std::size_t(rows + 2 * radius_y) * count * std::size_t(stride_of(width));
    }
    float* at(int plane, int y) const {
        return planes + (std::ptrdiff_t(y - first_row) * count + plane) * stride + padding;
    }
};

struct BlurKernel {
    using View = BlurInputsView;
    static constexpr int band = 32;  // each band reads the rows around it

    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return blur<F>(in.u, in.spatial, ImageTexels<F>{in, px, py}, tap);
    }
    static float* out(const View& in) { return in.blurred; }
    static std::size_t scratch(const View& in, int rows) { return BlurPlanes::floats(in.u.width, rows, in.u.radius_y); }
};

}  // namespace plumb::filter
