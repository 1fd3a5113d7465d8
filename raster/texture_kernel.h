// A texture's lookup: addressing, filter and level of detail; texture.glsl is the twin, line by line. Equations:
// README.md, "Textures and normal maps" and "Level of detail".
#pragma once

#include "core/number.h"
#include "core/tap.h"

namespace plumb {
struct Bounded;
}

namespace plumb::raster {

struct TextureArgs {
    const std::int32_t* rows;    // [row][4]: first texel, width, height, flags; row 0 is one white texel; a texture's
                                 // smaller levels follow its own row
    const std::int32_t* texels;  // RGBA8
    const float* decode;         // [2][256]: byte to linear value, plain and sRGB
    bool levels;                 // whether any texture chooses a level of detail; else level 0 everywhere
};

// A row's flags: wrap modes are numbered as in core/scene.h, two bits along u and two along v; then the number of
// smaller levels.
inline constexpr std::int32_t flag_nearest = 1, flag_srgb = 2;
inline constexpr int wrap_u_shift = 2, wrap_v_shift = 4, levels_shift = 6;

// Coordinate u in texels, within one period: texel centres lie at whole numbers when filtering; nearest takes the whole
// part. Repeat has the period 1, mirrored repeat 2. What is not finite becomes texel 0 with weight 0.
template <class F>
PLUMB_INLINE F texel_coordinate(F u, index_t<F> size, index_t<F> wrap, mask_t<F> nearest) {
    using N = number<F>;
    using I = index_t<F>;
    const mask_t<F> mirrored = wrap == I(1), clamped = wrap == I(2);
    const F periods = u * select(mirrored, F(0.5f), F(1.0f));
    const F within = select(clamped, clamp(u, F(0.0f), F(1.0f)), periods - floor(periods));
    const F texels = within * N::from_index(select(mirrored, size + size, size));
    const F coordinate = select(nearest, floor(texels), texels - F(0.5f));
    return select(abs(u) <= F(0x1.fffffep127f), coordinate, F(0.0f));
}

// The texel that index i, from -1 to one period + 1, stands for (Vulkan 1.3, 16.6.2 "Wrapping Operation"). The last
// clamp is clamp_to_edge, and keeps every read inside the image.
template <class F>
PLUMB_INLINE index_t<F> wrap_index(index_t<F> i, index_t<F> size, index_t<F> wrap) {
    using I = index_t<F>;
    const auto mirrored = wrap == I(1), clamped = wrap == I(2);
    const I below = select(mirrored, I(-1) - i, i + size);
    const I above = select(mirrored, size + size - I(1) - i, i - size);
    const I folded = select(i < I(0), below, select(i < size, i, above));
    return min(max(select(clamped, i, folded), I(0)), size - I(1));
}

// The four texels that a lookup reads (upper left, upper right, lower left, lower right), and the weights of the right
// and of the lower ones.
template <class F>
struct TexelQuad {
    index_t<F> a, b, c, d;  // RGBA8
    F along_u, along_v;
    index_t<F> curve;       // where the texture's decode table starts
};

template <class F, class Tap>
PLUMB_INLINE TexelQuad<F> fetch_quad(const TextureArgs& in, index_t<F> texture, const vec2<F>& uv, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I row = texture * I(4);
    const I first = N::fetch(in.rows, row), width = N::fetch(in.rows, row + I(1));
    const I height = N::fetch(in.rows, row + I(2)), flags = N::fetch(in.rows, row + I(3));
    const I wrap_u = shift_right(flags, wrap_u_shift) & I(3), wrap_v = shift_right(flags, wrap_v_shift) & I(3);
    const mask_t<F> nearest = (flags & I(flag_nearest)) > I(0);

    const F x = texel_coordinate<F>(uv.x, width, wrap_u, nearest);
    const F y = texel_coordinate<F>(uv.y, height, wrap_v, nearest);
    const F left = floor(x), top = floor(y);
    const I i = N::truncate_to_index(left), j = N::truncate_to_index(top);
    const I x0 = wrap_index<F>(i, width, wrap_u), x1 = wrap_index<F>(i + I(1), width, wrap_u);
    const I upper = first + wrap_index<F>(j, height, wrap_v) * width;
    const I lower = first + wrap_index<F>(j + I(1), height, wrap_v) * width;
    tap("texel", ivec2<I>{i, j}, "upper left of the texels that are read, before wrapping");
    tap("texel_weight", vec2<F>{x - left, y - top}, "of the right and the lower texels");
    return {N::fetch(in.texels, upper + x0), N::fetch(in.texels, upper + x1),
            N::fetch(in.texels, lower + x0), N::fetch(in.texels, lower + x1),
            x - left, y - top, (flags & I(flag_srgb)) << 7};
}

// One channel: decoded, then filtered, along u first. channel: 0 red .. 3 alpha.
template <class F>
PLUMB_INLINE F filter_channel(const TextureArgs& in, const TexelQuad<F>& q, index_t<F> curve, int channel) {
    using I = index_t<F>;
    auto value = [&](I texel) {
        return number<F>::fetch(in.decode, curve + (shift_right(texel, 8 * channel) & I(255)));
    };
    const F a = value(q.a), b = value(q.b), c = value(q.c), d = value(q.d);
    const F upper = a + q.along_u * (b - a), lower = c + q.along_u * (d - c);
    return upper + q.along_v * (lower - upper);
}
template <class F>
PLUMB_INLINE vec3<F> filter_rgb(const TextureArgs& in, const TexelQuad<F>& q, index_t<F> curve) {
    return {filter_channel(in, q, curve, 0), filter_channel(in, q, curve, 1), filter_channel(in, q, curve, 2)};
}

// A texture's row looked up at (u, v).
template <class F>
struct TextureFilter {
    // plain: never by the sRGB curve.
    template <class Tap>
    static PLUMB_INLINE vec3<F> rgb(const TextureArgs& in, index_t<F> row, const vec2<F>& uv, bool plain, Tap& tap) {
        const TexelQuad<F> q = fetch_quad<F>(in, row, uv, tap);
        return filter_rgb<F>(in, q, plain ? index_t<F>(0) : q.curve);
    }
    static PLUMB_INLINE F alpha(const TextureArgs& in, index_t<F> row, const vec2<F>& uv) {
        NoTap quiet;
        const TexelQuad<F> q = fetch_quad<F>(in, row, uv, quiet);
        return filter_channel<F>(in, q, index_t<F>(0), 3);
    }
};
// Over all places that a device may take for (u, v): texture_bounded.h, which who computes with Bounded includes.
template <>
struct TextureFilter<Bounded>;

// Level of detail for a pixel that covers so many texels of level 0, by area: `level` halvings and `blend` of one more.
// With r = sqrt(texels), in [2^level, 2^(level + 1)), blend is r / 2^level - 1: log2 r by straight lines, less than it
// by at most 0.0861. Powers of two change no digit of r. What is not a number reads level 0.
template <class F>
struct Detail {
    index_t<F> level;
    F blend;
};
template <class F>
PLUMB_INLINE Detail<F> detail(F texels, index_t<F> last) {
    using I = index_t<F>;
    F ratio = min(max(F(1.0f), sqrt(texels)), F(0x1p30f));
    I level(0);
    for (int step = 16; step > 0; step /= 2) {
        const mask_t<F> above = ratio >= F(float(1 << step));
        ratio = select(above, ratio * F(1.0f / float(1 << step)), ratio);
        level = level + select(above, I(step), I(0));
    }
    return {min(level, last), select(level < last, ratio - F(1.0f), F(0.0f))};
}

// Colour of a texture where a pixel covers `uv_area` of (u, v): filtered within the two nearest levels, and between
// them. plain: never by the sRGB curve.
template <class F, class Tap>
PLUMB_INLINE vec3<F> sample(const TextureArgs& in, index_t<F> texture, const vec2<F>& uv, F uv_area, bool plain,
                            Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    Detail<F> d{I(0), F(0.0f)};
    if (in.levels) {
        const I row = texture * I(4);
        const F width = N::from_index(N::fetch(in.rows, row + I(1)));
        const F height = N::from_index(N::fetch(in.rows, row + I(2)));
        d = detail<F>(uv_area * (width * height), shift_right(N::fetch(in.rows, row + I(3)), levels_shift));
        tap("level", d.level, "of detail: 0 is the texture itself");
        tap("level_blend", d.blend, "towards the next level");
    }
    const vec3<F> c = TextureFilter<F>::rgb(in, texture + d.level, uv, plain, tap);
    if (!in.levels || !any(d.blend > F(0.0f))) return c;
    NoTap quiet;
    const I next = texture + d.level + select(d.blend > F(0.0f), I(1), I(0));
    const vec3<F> e = TextureFilter<F>::rgb(in, next, uv, plain, quiet);
    return {c.x + d.blend * (e.x - c.x), c.y + d.blend * (e.y - c.y), c.z + d.blend * (e.z - c.z)};
}

}  // namespace plumb::raster
