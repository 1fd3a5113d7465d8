// Reflections in what a view sees, from texel to texel: the algorithm that cells.comp mirrors line by line.
//
// McGuire and Mara 2014, "Efficient GPU Screen-Space Ray Tracing": the mirrored ray p + t r in the view's image,
//
//     x(t) = (x_0 + t x_1) / (c_0 + t c_1),    y(t) likewise,    d(t) = d_0 + t d_1
//
// c: the depth, or 1 of parallel rays. It passes every texel that it crosses, so that nothing thin is stepped over. A texel
// is a box from its depth to the thickness behind it; the ray meets it where it is within. Uludag 2014, "Hi-Z Screen-Space
// Cone-Traced Reflections": where a block of texels lies behind the whole of the ray in it, the block is passed at once,
// and the next may be larger; else one of its quarters is asked.
//
// differs: both work on depths after the division, where t is not linear. The next texel is found from which border is
// crossed, in whole numbers, and not from a point that is moved by a little.
#pragma once

#include "gi/screen/mirrored_ray_kernel.h"
#include "gi/screen/nearest_kernel.h"
#include "gi/screen/sheet_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct CellsUniforms {
    SeenFrom view;
    float eye[4];             // xyz world, m: of the camera that sees the mirrors
    float reach;              // m, along the ray
    float thickness;          // m
    float bias;               // m
    std::int32_t cells, levels;
    std::int32_t number;      // of the view: 1 the camera's, then its layers, then the lights' maps
    std::int32_t padded;      // of `nearest`: NearestUniforms::padded
    std::int32_t width, height;
    std::int32_t columns, rows;  // of a picture, where items are pixels of a sheet with drawn rays; 0: mirrored rays, one picture
    std::int32_t padding;
};
static_assert(sizeof(CellsUniforms) == 144);

struct CellsInputsView {
    CellsUniforms u;
    const float* position;      // as screen.reflect has them
    const float* normal;
    const float* mirror;
    const float* map_position;
    const float* map_normal;
    const float* nearest;       // as screen.nearest makes them
    const float* before;
    const float* rays;
    float* hit;                 // out: as screen.reflect writes it
};

// The ray in the view's image.
template <class F>
struct Track {
    F x_0, x_1, y_0, y_1, c_0, c_1, d_0, d_1;
    F first, last;  // t of the part within the view, m; none: last < first
};

template <class F>
PLUMB_INLINE F rate_of(const float* m, const vec3<F>& r) {
    return F(m[0]) * r.x + F(m[1]) * r.y + F(m[2]) * r.z;
}

// Keeps of first..last where a + t b >= 0 (Liang and Barsky 1984).
template <class F>
PLUMB_INLINE void clip(F a, F b, F& first, F& last) {
    const F zero(0.0f);
    const mask_t<F> along = b == zero;
    const F t = -a / select(along, F(1.0f), b);
    first = select(b > zero, max(first, t), first);
    last = select(b < zero, min(last, t), last);
    last = select(along & (a < zero), F(-1.0f), last);
}

template <class F, class Tap>
PLUMB_INLINE Track<F> track_of(const CellsInputsView& in, const MirroredRay<F>& ray, Tap& tap) {
    const SeenFrom& v = in.u.view;
    const F zero(0.0f), one(1.0f), width(float(v.width)), height(float(v.height)), least(v.least_depth);
    const bool perspective = v.perspective > 0.0f;
    Track<F> k{row_of(v.to_x, ray.from_anchor), rate_of(v.to_x, ray.r), row_of(v.to_y, ray.from_anchor), rate_of(v.to_y, ray.r),
               one, zero, row_of(v.forward, ray.from_anchor), rate_of(v.forward, ray.r), zero, F(in.u.reach)};
    if (perspective) {
        k.c_0 = k.d_0, k.c_1 = k.d_1;
        clip<F>(k.d_0 - least, k.d_1, k.first, k.last);
    }
    clip<F>(k.x_0, k.x_1, k.first, k.last);
    clip<F>(width * k.c_0 - k.x_0, width * k.c_1 - k.x_1, k.first, k.last);
    clip<F>(k.y_0, k.y_1, k.first, k.last);
    clip<F>(height * k.c_0 - k.y_0, height * k.c_1 - k.y_1, k.first, k.last);
    tap("within", vec2<F>{k.first, k.last}, "t of the ray's part within the view, m");
    return k;
}

// Where a coordinate (a + t b) / (c_0 + t c_1) leaves [low, high), by which border.
template <class F>
struct Border {
    F t;            // m; no_depth: it does not
    mask_t<F> up;
};
template <class F>
PLUMB_INLINE Border<F> border_of(const Track<F>& k, F a, F b, index_t<F> low, index_t<F> high) {
    using N = number<F>;
    const F zero(0.0f);
    const mask_t<F> up = b * k.c_0 - a * k.c_1 > zero;
    const F at = N::from_index(select(up, high, low)), rate = b - at * k.c_1;
    const mask_t<F> leaves = select(up, rate, -rate) > zero;
    return {select(leaves, (at * k.c_0 - a) / select(leaves, rate, F(1.0f)), F(no_depth)), up};
}

// The texel of that coordinate at t, within [low, high).
template <class F>
PLUMB_INLINE index_t<F> texel_at(const Track<F>& k, F a, F b, F t, index_t<F> low, index_t<F> high) {
    using I = index_t<F>;
    const F far(65536.0f), x = (a + t * b) / (k.c_0 + t * k.c_1);
    return min(max(raster::chosen(clamp(x, -far, far)), low), high - I(1));
}

// The ray's depth at t.
template <class F>
PLUMB_INLINE F depth_at(const Track<F>& k, F t) {
    return k.d_0 + t * k.d_1;
}

// Where the ray is as deep.
template <class F>
PLUMB_INLINE F reached_at(const Track<F>& k, F depth) {
    return (depth - k.d_0) / k.d_1;
}

template <class F, class Tap>
PLUMB_INLINE Crossing<F> walk(const CellsInputsView& in, const MirroredRay<F>& ray, const Track<F>& k, mask_t<F> looking,
                              Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const CellsUniforms& u = in.u;
    const F zero(0.0f), thickness(u.thickness);
    const I none(0), width(u.view.width), height(u.view.height);
    const mask_t<F> nowhere = looking & !looking;
    Crossing<F> c{zero, {zero, zero}, zero, nowhere};
    mask_t<F> in_front = looking;  // the ray left the last texel before what is seen there
    F t = k.first;
    I level(0), x = texel_at(k, k.x_0, k.x_1, t, none, width), y = texel_at(k, k.y_0, k.y_1, t, none, height);
    for (int i = 0; any(looking) && i < u.cells; ++i) {
        tap.sample(i);
        const I across = shift_right(x, level), down = shift_right(y, level);
        const I low_x = across << level, low_y = down << level, high_x = (across + I(1)) << level, high_y = (down + I(1)) << level;
        const Border<F> of_x = border_of(k, k.x_0, k.x_1, low_x, high_x), of_y = border_of(k, k.y_0, k.y_1, low_y, high_y);
        const F leaves = max(t, min(k.last, min(of_x.t, of_y.t)));
        tap("texel", ivec2<I>{x, y}, "of the view");
        tap("level", level, "blocks of 2^level texels; 0: one");
        tap("leaves", leaves, "t at which the ray leaves it, m");

        // What lies there, and where the ray is.
        const mask_t<F> single = level == none;
        const I texel = y * width + x, row = I(u.padded) - shift_right(I(2 * u.padded), level) + down;
        const F depth = N::fetch(in.map_position, select(looking, texel, none) * I(4) + I(3));
        const F of_block = N::fetch(in.nearest, select(single | !looking, none, row * I((u.view.width + 1) / 2) + across) * I(4));
        const F least = select(single, select(depth > zero, depth, F(no_depth)), of_block);
        const F d_in = depth_at(k, t), d_out = depth_at(k, leaves);
        tap("least", least, "depth of what is seen there, m");
        tap("depths", vec2<F>{d_in, d_out}, "of the ray where it enters and leaves, m");
        const mask_t<F> clear = max(d_in, d_out) < least, before = in_front | (d_in < least);
        mask_t<F> met = looking & single & !clear & before & (min(d_in, d_out) - least <= thickness);
        if (any(met)) {
            const I at = select(met, texel, none);
            met = met & may_be_met<F>(ray, xyz<F>(N::fetch4(in.map_position, at)), xyz<F>(N::fetch4(in.map_normal, at)), u.bias, tap);
            const F reaches = select(d_in < least, clamp(reached_at(k, least), t, leaves), t);
            take<F>(met, reaches, {x, y}, depth_at(k, reaches) - least, c);
            c.found = c.found | met;
        }
        tap("met", met, "the ray is within the texel's box, and may meet it");
        looking = looking & !met;

        // Into a quarter of the block, or on into the next.
        const mask_t<F> on = single | clear, by_x = of_x.t <= of_y.t;
        const mask_t<F> within = leaves < k.last, into = !on;
        looking = looking & (into | within);
        const I beside = texel_at(k, select(by_x, k.y_0, k.x_0), select(by_x, k.y_1, k.x_1), leaves, select(by_x, low_y, low_x),
                                  select(by_x, high_y, high_x));
        const I next_x = select(by_x, select(of_x.up, high_x, low_x - I(1)), beside);
        const I next_y = select(by_x, beside, select(of_y.up, high_y, low_y - I(1)));
        x = select(on, min(max(next_x, none), width - I(1)), x), y = select(on, min(max(next_y, none), height - I(1)), y);
        in_front = (in_front & into) | (on & (d_out < least));
        t = select(on, leaves, t);
        level = select(on, min(level + I(1), I(u.levels)), level - I(1));
    }
    tap.sample(-1);
    return c;
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> cells(const CellsInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const CellsUniforms& u = in.u;
    const F zero(0.0f);
    const I item = py * I(u.width) + px, pixel = pixel_in_sheet<F>(px, py, u.columns, u.rows, u.width);
    const vec3<F> p = xyz<F>(N::fetch4(in.position, pixel));      tap("p", p, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of p");
    MirroredRay<F> ray = mirrored_ray<F>(p, n, from(u.eye, p), u.view.anchor, tap);
    const vec4<F> none{zero, zero, zero, zero}, before = in.before ? N::fetch4(in.before, item) : none;
    const mask_t<F> open = !(before.w == F(1.0f));
    mask_t<F> starts = (ray.cosine < zero) & (N::fetch4(in.mirror, pixel).w > zero);
    if (u.rows > 0) starts = take_drawn(in.rays ? N::fetch4(in.rays, item) : none, ray, tap);
    const Track<F> track = track_of(in, ray, tap);
    const mask_t<F> looking = starts & open & (track.first <= track.last);
    return nearer_hit(before, walk<F>(in, ray, track, looking, tap), u.number, tap);
}

struct CellsKernel {
    using View = CellsInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return cells<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.hit; }
};

}  // namespace plumb::screen
