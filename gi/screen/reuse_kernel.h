// Indirect light of frames before this one, read where its surface was seen then (LRA 4.3.3 and its conclusion, after Lambru et
// al.: few samples a frame, turned in each, and what the last frame had): the algorithm that reuse.comp mirrors line by line.
//
//     E' = H + (E - H) / n        n = min(m + 1, N)
//
//     H = sum_k w_k H_k / W,  m = sum_k w_k m_k / W,  W = sum_k w_k       over the four pixels about the place where p was seen,
//                                                                         x + (last view's image of p - this view's)
//     w_k = bilinear_k depth_k normal_k                                   as gi/filter's upsampling weighs them
//
// H_k and m_k: irradiance that the last frame had, and of how many frames. The first N frames are a mean; after that each new one
// has a share of 1/N, and noise keeps 1 / (2 N - 1) of its variance. Where nothing of W is left the surface was not seen: n = 1.
//
// A history is a ghost where it lies outside of what the 3 x 3 pixels about this one have now: it may be moved to their border.
#pragma once

#include "gi/filter/weights_kernel.h"
#include "gi/screen/view_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct ReuseUniforms {
    SeenFrom last, now;          // the views of the last frame and of this one
    float most;                  // N
    float least_weight;          // W below it: not seen
    float sigma_depth, normal_slope, normal_offset;  // as gi/filter has them
    std::int32_t clamps;         // 1: ghosts are moved to the border
    std::int32_t there;          // 0: there is no last frame
    std::int32_t width, height;
    std::int32_t padding[3];
};
static_assert(sizeof(ReuseUniforms) == 208);

struct ReuseInputsView {
    ReuseUniforms u;
    const float* irradiance;       // [height][width] rgba32f: E, W/m2
    const float* position;         // xyz world, m; w linear depth, m
    const float* normal;           // xyz unit; all 0: no surface
    const float* last_irradiance;  // [last.height][last.width] rgba32f: H_k, W/m2
    const float* last_age;         // x m_k; w 1 on a surface
    const float* last_position;    // xyz world, m; w linear depth, m
    const float* last_normal;
    float* reused;                 // out: [height][width] rgba32f: E', W/m2; w linear depth, m
    float* age;                    // out: x n, y W, z by how much H was a ghost, W/m2; w 1 on a surface
};

template <class F>
struct Reused {
    vec4<F> light, age;
    template <class Each>
    void components(Each each) const {
        for (const vec4<F>& v : {light, age}) each(v.x), each(v.y), each(v.z), each(v.w);
    }
};

// Where a point falls in a view's image, in its pixels.
template <class F>
struct At {
    F x, y, depth;
};

template <class F>
PLUMB_INLINE At<F> image_of(const SeenFrom& view, const vec3<F>& p) {
    const vec3<F> v{p.x - F(view.anchor[0]), p.y - F(view.anchor[1]), p.z - F(view.anchor[2])};
    const F depth = row_of(view.forward, v), divisor = view.perspective > 0.0f ? max(depth, F(view.least_depth)) : F(1.0f);
    return {row_of(view.to_x, v) / divisor, row_of(view.to_y, v) / divisor, depth};
}

// What the last frame had of a point.
template <class F>
struct Before {
    vec3<F> irradiance;
    F frames, weight;
};

template <class F, class Tap>
PLUMB_INLINE Before<F> before_of(const ReuseInputsView& in, index_t<F> px, index_t<F> py, const vec4<F>& p, const vec3<F>& n,
                                 const mask_t<F>& covered, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ReuseUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    // Rasterized positions lie beside their pixel's centre, by as much in both views: only the difference of the two moves.
    const At<F> was = image_of<F>(u.last, xyz<F>(p)), is = image_of<F>(u.now, xyz<F>(p));
    tap("depth", was.depth, "in the last frame, m");
    tap("moved", vec2<F>{was.x - is.x, was.y - is.y}, "from this frame's image to the last one's, pixels");
    const F low(-65536.0f), high(65536.0f);
    const F x = clamp(N::from_index(px) + (was.x - is.x), low, high), y = clamp(N::from_index(py) + (was.y - is.y), low, high);
    const I left = raster::chosen(x), top = raster::chosen(y);
    tap("pixel", ivec2<I>{left, top}, "of the last frame: the first of four");
    const F right = x - N::from_index(left), down = y - N::from_index(top);
    mask_t<F> there = covered;
    if (u.last.perspective > 0.0f) there = there & (was.depth >= F(u.last.least_depth));
    const filter::Centre<F> own = filter::centre_of(xyz<F>(p), p.w, n, u.sigma_depth, u.normal_slope);
    Before<F> sum{{zero, zero, zero}, zero, zero};
    for (int k = 0; k < 4; ++k) {
        tap.sample(k);
        const I at_x = left + I(k & 1), at_y = top + I(k >> 1);
        const mask_t<F> inside = there & in_range(at_x, I(u.last.width)) & in_range(at_y, I(u.last.height));
        const I at = select(inside, at_y * I(u.last.width) + at_x, I(0));
        const vec4<F> q = N::fetch4(in.last_position, at), age = N::fetch4(in.last_age, at);
        const vec3<F> m = xyz<F>(N::fetch4(in.last_normal, at)), h = xyz<F>(N::fetch4(in.last_irradiance, at));
        tap("last", h, "H_k, W/m2");
        const F bilinear = ((k & 1) != 0 ? right : one - right) * (k > 1 ? down : one - down);
        const F of_depth = filter::depth_weight(true, own, filter::Texel<F>{h, q.w, m, xyz<F>(q)}, tap);
        const F of_normal = filter::normal_weight(own, m, u.normal_offset, tap);
        const F weight = select(inside & (age.w > zero), bilinear * of_depth * of_normal, zero);
        tap("weight", weight, "w_k = bilinear depth normal");
        sum.irradiance = {sum.irradiance.x + weight * h.x, sum.irradiance.y + weight * h.y, sum.irradiance.z + weight * h.z};
        sum.frames += weight * age.x;
        sum.weight += weight;
    }
    tap.sample(-1);
    return sum;
}

// What the 3 x 3 pixels about one have now.
template <class F>
struct Box {
    vec3<F> low, high;
};

template <class F>
PLUMB_INLINE Box<F> box_of(const ReuseInputsView& in, index_t<F> px, index_t<F> py, const vec3<F>& e) {
    using N = number<F>;
    using I = index_t<F>;
    Box<F> box{e, e};
    for (int k = 0; k < 9; ++k) {
        const I x = min(max(px + I(k % 3 - 1), I(0)), I(in.u.width - 1)), y = min(max(py + I(k / 3 - 1), I(0)), I(in.u.height - 1));
        const I at = y * I(in.u.width) + x;
        const vec3<F> n = xyz<F>(N::fetch4(in.normal, at)), o = xyz<F>(N::fetch4(in.irradiance, at));
        const mask_t<F> surface = dot3(n, n) > F(0.0f);
        box.low = select3<F>(surface, {min(box.low.x, o.x), min(box.low.y, o.y), min(box.low.z, o.z)}, box.low);
        box.high = select3<F>(surface, {max(box.high.x, o.x), max(box.high.y, o.y), max(box.high.z, o.z)}, box.high);
    }
    return box;
}

template <class F, class Tap>
PLUMB_INLINE Reused<F> reuse(const ReuseInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ReuseUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    const vec3<F> dark{zero, zero, zero};
    const I pixel = py * I(u.width) + px;
    const vec4<F> p = N::fetch4(in.position, pixel);              tap("p", xyz<F>(p), "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of p");
    const vec3<F> e = xyz<F>(N::fetch4(in.irradiance, pixel));    tap("e", e, "E of this frame, W/m2");
    const mask_t<F> covered = dot3(n, n) > zero;
    Before<F> last{dark, zero, zero};
    if (u.there != 0) last = before_of<F>(in, px, py, p, n, covered, tap);
    tap("total", last.weight, "W");
    const mask_t<F> known = last.weight > F(u.least_weight);      tap("known", known, "0: not seen in the last frame");
    const F total = select(known, last.weight, one);
    const vec3<F> h{last.irradiance.x / total, last.irradiance.y / total, last.irradiance.z / total};
    tap("h", h, "H, W/m2");
    const Box<F> box = box_of<F>(in, px, py, e);
    const vec3<F> held{clamp(h.x, box.low.x, box.high.x), clamp(h.y, box.low.y, box.high.y), clamp(h.z, box.low.z, box.high.z)};
    tap("held", held, "H within what the 3 x 3 pixels have, W/m2");
    const F off = select(known, abs(h.x - held.x) + abs(h.y - held.y) + abs(h.z - held.z), zero);
    tap("ghost", off, "|H - held|, all channels, W/m2");
    const vec3<F> history = u.clamps != 0 ? held : h;
    const F frames = select(known, min(last.frames / total + one, F(u.most)), one);
    tap("frames", frames, "n = min(m + 1, N)");
    const vec3<F> mean{history.x + (e.x - history.x) / frames, history.y + (e.y - history.y) / frames, history.z + (e.z - history.z) / frames};
    const vec3<F> light = select3<F>(covered, select3<F>(known, mean, e), dark);
    tap("reused", light, "E' = H + (E - H) / n, W/m2");
    return {vec4<F>(light, p.w), {select(covered, frames, zero), select(covered, last.weight, zero), select(covered, off, zero), select(covered, one, zero)}};
}

struct ReuseKernel {
    using View = ReuseInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static Reused<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return reuse<F>(in, px, py, tap);
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Reused<F>& r, mask_t<F> active) {
        number<F>::store4(in.reused, at, r.light, active);
        number<F>::store4(in.age, at, r.age, active);
    }
};

}  // namespace plumb::screen
