// Screen-space ambient occlusion from one view (LRA 4.2.3, 6.2.3), and its share in the mean over views (4.3.2): the
// algorithm that ssao.comp mirrors line by line.
//
// Samples s lie in the half ball of radius R over the surface point p. A sample is hidden where the view sees a surface q
// before it. What is estimated is the share of the half ball that is hidden: of points, not of directions.
//
//     o = 1 - sum_s hidden(s) smoothstep(0, 1, R / |d_p - d_q|) / count                                   LRA 4.2.3
//     sum += w o,    weights += w,    w = (1 - b) max(0, n.v) + b (1 - sum_s min(|p - q|, R) / (K R))     LRA 4.3.2
//
// d: linear depth in the view. A sample beyond the view's border says nothing and does not count.
//
// differs: the listings compare world z in place of depths with a constant bias, count samples beyond the border as open, do
// not make the vector to the view's eye a unit one, take the samples' own distances, and weigh views that do not see p
// (variant `published`). Here a surface hides a sample if it also rises above the plane of p by more than the bias: what
// lies on that plane, whatever its slope and its texels, hides nothing above it.
#pragma once

#include <type_traits>

#include "core/tap.h"
#include "gi/reference/warp_kernel.h"
#include "gi/screen/view_kernel.h"

namespace plumb::screen {

// The twin's uniform block (std140).
struct SsaoUniforms {
    SeenFrom view;
    float radius;             // m
    float bias;               // m
    float weight_bias;        // b: what the distances weigh, beside 1 - b of the direction
    std::int32_t samples;     // K
    std::int32_t own;         // 1: the view is that of the receivers, and sees them all
    std::int32_t weighted;    // 0: w = 1
    std::int32_t published;
    std::int32_t width, height;
    std::int32_t padding[3];
};
static_assert(sizeof(SsaoUniforms) == 128);

struct SsaoInputsView {
    SsaoUniforms u;
    const float* position;   // [height][width] rgba32f: xyz world, m
    const float* normal;     // [height][width] rgba32f: xyz unit; all 0: no surface
    const float* map_position;  // [view.height][view.width] rgba32f: xyz world, m; w linear depth, m; 0: nothing
    const float* before;     // [height][width] rgba32f: what other views have summed; null: 0
    const float* samples;    // [samples][4]: xyz in the half ball of radius 1 about +z
    const float* rotations;  // [16][2]: cosine and sine; published: x and y of a vector
    float* summed;           // out: [height][width] rgba32f
};

// The surface point and the directions about it.
template <class F>
struct Receiver {
    vec3<F> p, n;                // world, m; unit
    vec3<F> from_anchor;         // m
    vec3<F> tangent, bitangent;  // turned by the pixel's rotation
    F depth;                     // that others are compared with, m
};

template <class F, class Tap>
PLUMB_INLINE Receiver<F> receiver_of(const SsaoInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const SsaoUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const vec3<F> p = xyz<F>(N::fetch4(in.position, pixel));      tap("p", p, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of p");
    const vec3<F> v{p.x - F(u.view.anchor[0]), p.y - F(u.view.anchor[1]), p.z - F(u.view.anchor[2])};
    const I turn = rotation_of<F>(px, py);
    const F x = N::fetch(in.rotations, turn + turn), y = N::fetch(in.rotations, turn + turn + I(1));
    Receiver<F> r{p, n, v, {}, {}, u.published != 0 ? -p.z : row_of(u.view.forward, v)};
    if (u.published != 0) {
        // Gram-Schmidt of a vector in the plane z = 0.
        const F along = x * n.x + y * n.y;
        const vec3<F> t{x - n.x * along, y - n.y * along, -(n.z * along)};
        const F inverse = F(1.0f) / sqrt(max(dot3(t, t), F(1e-37f)));
        r.tangent = {t.x * inverse, t.y * inverse, t.z * inverse};
        r.bitangent = {n.y * r.tangent.z - n.z * r.tangent.y, n.z * r.tangent.x - n.x * r.tangent.z,
                       n.x * r.tangent.y - n.y * r.tangent.x};
    } else {
        const reference::Basis<F> b = reference::basis_of<F>(n);
        r.tangent = {b.tangent.x * x + b.bitangent.x * y, b.tangent.y * x + b.bitangent.y * y,
                     b.tangent.z * x + b.bitangent.z * y};
        r.bitangent = {b.bitangent.x * x - b.tangent.x * y, b.bitangent.y * x - b.tangent.y * y,
                       b.bitangent.z * x - b.tangent.z * y};
    }
    tap("tangent", r.tangent, "the sample's x");
    return r;
}

// What the view sees at a place.
template <class F>
struct Surface {
    vec3<F> to_q;     // q - p, m
    F depth;          // as it is compared, m
    mask_t<F> known;  // the view has that texel, and a surface there
};

template <class F, class Tap>
PLUMB_INLINE Surface<F> surface_at(const SsaoInputsView& in, const Receiver<F>& r, const Place<F>& place, Tap& tap) {
    using I = index_t<F>;
    const I texel = place.texel.y * I(in.u.view.width) + place.texel.x;
    const vec4<F> q = number<F>::fetch4(in.map_position, select(place.inside, texel, I(0)));
    const vec3<F> to_q{q.x - r.p.x, q.y - r.p.y, q.z - r.p.z};
    tap("to_q", to_q, "q - p, m");
    const F depth = in.u.published != 0 ? -q.z : q.w;             tap("depth_q", depth, "of the view, m");
    const mask_t<F> known = place.inside & (q.w > F(0.0f));
    return {to_q, depth, known};
}

// Whether q is before a point at `depth`, and above the plane of p.
template <class F, class Tap>
PLUMB_INLINE mask_t<F> hides(const SsaoUniforms& u, const Receiver<F>& r, const Surface<F>& q, F depth, Tap& tap) {
    const F bias(u.bias), rise = dot3(q.to_q, r.n);               tap("rise", rise, "n.(q - p), m");
    const mask_t<F> before = q.depth < depth, above = rise > bias, printed = -q.depth >= bias - depth;
    const mask_t<F> hidden = q.known & (u.published != 0 ? printed : before & above);
    tap("hidden", hidden, "d_q < d and n.(q - p) > bias; as printed z_q >= z + bias");
    return hidden;
}

// Whether q may hide a point at `depth`, from one of its four numbers.
template <class F>
PLUMB_INLINE mask_t<F> may_hide(const SsaoInputsView& in, const Place<F>& place, F depth) {
    using I = index_t<F>;
    const I texel = select(place.inside, place.texel.y * I(in.u.view.width) + place.texel.x, I(0));
    const F seen = number<F>::fetch(in.map_position, texel * I(4) + I(in.u.published != 0 ? 2 : 3));
    return place.inside & (in.u.published != 0 ? seen >= F(in.u.bias) - depth : seen < depth);
}

// Sums over the samples.
template <class F>
struct Occlusion {
    F open;      // o
    F distance;  // sum of min(|p - q|, R), m
    F count;     // samples that the view has
};

template <class F, class Tap>
PLUMB_INLINE Occlusion<F> occlusion_of(const SsaoInputsView& in, const Receiver<F>& r, const mask_t<F>& covered,
                                       Tap& tap) {
    const SsaoUniforms& u = in.u;
    const F zero(0.0f), one(1.0f), radius(u.radius);
    F occlusion(0.0f), distance(0.0f), count(0.0f);
    // In the open most packets meet nothing before a sample: they read a number and not four, and divide once less.
    constexpr bool skips = number<F>::width > 1 && std::is_same_v<Tap, NoTap>;
    for (int k = 0; any(covered) && k < u.samples; ++k) {
        tap.sample(k);
        const float* local = in.samples + 4 * std::ptrdiff_t(k);
        const F x = F(local[0]) * radius, y = F(local[1]) * radius, z = F(local[2]) * radius;
        const vec3<F> s{r.tangent.x * x + r.bitangent.x * y + r.n.x * z, r.tangent.y * x + r.bitangent.y * y + r.n.y * z,
                        r.tangent.z * x + r.bitangent.z * y + r.n.z * z};
        tap("s", s, "the sample from p, m");
        const Place<F> place =
            place_of<F>(u.view, {r.from_anchor.x + s.x, r.from_anchor.y + s.y, r.from_anchor.z + s.z}, tap);
        const F depth = u.published != 0 ? -(r.p.z + s.z) : place.depth;
        count += u.published != 0 ? one : select(place.inside, one, zero);
        if (skips && u.weighted == 0 && !any(may_hide<F>(in, place, depth))) continue;
        const Surface<F> q = surface_at<F>(in, r, place, tap);
        const mask_t<F> hidden = hides<F>(u, r, q, depth, tap);
        const F near = radius / max(abs(r.depth - q.depth), radius);
        const F range = near * near * (F(3.0f) - (near + near));
        tap("range", range, "smoothstep(0, 1, R / |d_p - d_q|)");
        occlusion += select(hidden, range, zero);
        if (u.weighted != 0) {
            const vec3<F> to = u.published != 0 ? s : q.to_q;
            const F length = min(sqrt(dot3(to, to)), radius);
            distance += u.published != 0 ? length : select(q.known, length, radius);
        }
    }
    tap.sample(-1);
    tap("occlusion", occlusion, "sum over the samples");
    tap("count", count, "samples that the view has");
    const F open = one - occlusion / max(count, one);             tap("open", open, "o, LRA 4.2.3");
    return {open, distance, count};
}

// What the view weighs at p.
template <class F, class Tap>
PLUMB_INLINE F weight_of(const SsaoInputsView& in, const Receiver<F>& r, const Occlusion<F>& o, Tap& tap) {
    const SsaoUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    const vec3<F> v = r.from_anchor;
    const float* axis = u.view.forward;
    const F inverse = u.published != 0 ? one : one / sqrt(max(dot3(v, v), F(1e-37f)));
    const F to_eye = -(dot3(r.n, v) * inverse), along = -(r.n.x * F(axis[0]) + r.n.y * F(axis[1]) + r.n.z * F(axis[2]));
    const bool parallel = u.published == 0 && u.view.perspective == 0.0f;
    const F facing = max(zero, parallel ? along : to_eye);        tap("facing", facing, "max(0, n.v), to the view's eye");
    const F near = one - o.distance / (F(float(u.samples)) * F(u.radius));
    tap("near", near, "1 - sum min(|p - q|, R) / (K R)");
    const F weight = (one - F(u.weight_bias)) * facing + F(u.weight_bias) * near;
    if (u.published != 0) return weight;
    mask_t<F> sees = o.count > zero;
    if (u.own == 0) {
        const Place<F> place = place_of<F>(u.view, v, tap);
        const Surface<F> q = surface_at<F>(in, r, place, tap);
        sees = sees & q.known & (facing > zero) & !hides<F>(u, r, q, place.depth, tap);
    }
    return select(sees, weight, zero);
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> ssao(const SsaoInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using I = index_t<F>;
    const SsaoUniforms& u = in.u;
    const F zero(0.0f), one(1.0f);
    const Receiver<F> r = receiver_of<F>(in, px, py, tap);
    const mask_t<F> covered = dot3(r.n, r.n) > zero;
    const Occlusion<F> o = occlusion_of<F>(in, r, covered, tap);
    const F weight = u.weighted != 0 ? weight_of<F>(in, r, o, tap) : one;
    tap("weight", weight, "w, LRA 4.3.2");
    const vec4<F> none{zero, zero, zero, zero};
    const vec4<F> before = in.before ? number<F>::fetch4(in.before, py * I(u.width) + px) : none;
    const vec4<F> sum{before.x + weight * o.open, before.y + weight, u.own != 0 ? o.open : before.z, one};
    tap("sum", vec3<F>{sum.x, sum.y, sum.z}, "sum w o; sum w; o of the receivers' own view");
    return {select(covered, sum.x, zero), select(covered, sum.y, zero), select(covered, sum.z, zero),
            select(covered, one, zero)};
}

struct SsaoKernel {
    using View = SsaoInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return ssao<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.summed; }
};

}  // namespace plumb::screen
