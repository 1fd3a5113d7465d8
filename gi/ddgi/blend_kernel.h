// Rays of a probe into its octahedral texels: irradiance, or the first two moments of distance (DDGI 2019, section 4.2 and
// its listing). The algorithm that blend.comp mirrors line by line.
//
//     w_r   = max(0, d . w_r)^sharpness, 0 below `least_weight`       d: the texel's direction; 1: irradiance, 50: moments
//     mean  = scale sum_r w_r v_r / sum_r w_r                         v: radiance; or (m, m^2), m = min(distance, farthest)
//     texel = (1 - hysteresis) mean + hysteresis previous
//
// With scale = pi the mean of radiances over a cosine lobe is irradiance, W/m2: of a constant radiance L exactly pi L.
//
// differs: whole exponents, by squaring; pow() is another rounding on every device. A texel that no ray has a weight for keeps
// what it held, as in the published code. Texels of the gutter are ddgi.border's.
#pragma once

#include "gi/ddgi/octahedral_kernel.h"

namespace plumb::ddgi {

// The twin's uniform block (std140).
struct BlendUniforms {
    std::int32_t width, height;  // of the atlas, texels
    std::int32_t side;           // of a tile, without its gutter
    std::int32_t columns;        // tiles of a row
    std::int32_t probes;
    std::int32_t rays;           // of each probe
    std::int32_t moments;        // 1: of distance; 0: irradiance
    std::int32_t sharpness;
    float hysteresis;
    float scale;
    float farthest;              // m
    float least_weight;
};
static_assert(sizeof(BlendUniforms) == 48);

struct BlendView {
    BlendUniforms u;
    const float* directions;  // [rays][4]: unit
    const float* hits;        // [probes][rays][4]: xyz radiance that comes back, W/(m2 sr); w distance, m
    const float* previous;    // [height][width][4]
    float* blended;           // out: [height][width][4]
};

// x^n for x in [0, 1] and n >= 1, by squaring.
template <class F>
PLUMB_INLINE F whole_power(F x, int n) {
    F power(1.0f);
    for (int left = n; left > 0; left >>= 1) {
        if ((left & 1) != 0) power = power * x;
        x = x * x;
    }
    return power;
}

template <class F>
PLUMB_INLINE index_t<F> probe_of(const BlendUniforms& u, const InTile<F>& at) {
    return at.tile.y * index_t<F>(u.columns) + at.tile.x;
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> blend(const BlendView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const BlendUniforms& u = in.u;
    const InTile<F> at = in_tile<F>(px, py, u.side);
    const I probe = min(probe_of<F>(u, at), I(u.probes - 1));
    tap("probe", probe, "the tile's");
    const vec3<F> d = direction_of<F>({centre_of_texel<F>(at.texel.x, u.side), centre_of_texel<F>(at.texel.y, u.side)});
    tap("direction", d, "of the texel's centre, unit");
    F total(0.0f);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int r = 0; r < u.rays; ++r) {
        tap.sample(r);
        const float* ray = in.directions + 4 * std::ptrdiff_t(r);
        const F cosine = max(F(0.0f), d.x * F(ray[0]) + d.y * F(ray[1]) + d.z * F(ray[2]));
        tap("cosine", cosine, "max(0, d . w_r)");
        const F power = whole_power(cosine, u.sharpness);
        const F w = select(power >= F(u.least_weight), power, F(0.0f));
        tap("w", w, "its power; 0 below the least weight");
        const vec4<F> hit = N::fetch4(in.hits, probe * I(u.rays) + I(r));
        const F m = min(hit.w, F(u.farthest));
        const vec3<F> value = u.moments != 0 ? vec3<F>{m, m * m, F(0.0f)} : xyz<F>(hit);
        tap("value", value, "radiance, W/(m2 sr); or distance m, m2");
        sum.x = sum.x + w * value.x;
        sum.y = sum.y + w * value.y;
        sum.z = sum.z + w * value.z;
        total = total + w;                                        tap("total", total, "sum of the weights so far");
    }
    tap.sample(-1);
    const mask_t<F> found = total > F(0.0f);
    const F factor = F(u.scale) / select(found, total, F(1.0f));
    const vec3<F> mean{sum.x * factor, sum.y * factor, sum.z * factor};
    tap("mean", mean, "scale sum w v / sum w");
    const vec4<F> before = N::fetch4(in.previous, py * I(u.width) + px);
    const F kept(u.hysteresis), taken = F(1.0f) - F(u.hysteresis);
    const vec3<F> blended{taken * mean.x + kept * before.x, taken * mean.y + kept * before.y,
                          taken * mean.z + kept * before.z};
    const vec3<F> texel = select3<F>(found, blended, xyz<F>(before));
    tap("texel", texel, "(1 - hysteresis) mean + hysteresis previous; previous where no ray counts");
    return vec4<F>(texel, F(0.0f));
}

struct BlendKernel {
    using View = BlendView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return blend<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.blended; }
    // Texels of probes; not the gutter, nor tiles behind the last probe.
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        using I = index_t<F>;
        const InTile<F> at = in_tile<F>(px, py, in.u.side);
        return in_range(at.texel.x - I(1), I(in.u.side)) & in_range(at.texel.y - I(1), I(in.u.side)) &
               (at.tile.x < I(in.u.columns)) & (probe_of<F>(in.u, at) < I(in.u.probes));
    }
};

}  // namespace plumb::ddgi
