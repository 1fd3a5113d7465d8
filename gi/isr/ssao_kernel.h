// Ambient occlusion by what the camera sees: the algorithm that ssao.comp mirrors line by line.
//
// Every sample X is a sphere whose great circle has the area that the sample stands for: pi r^2 = (footprint z)^2 s^2.
// A sphere covers r^2 / d^2 of the receiver's cosine-weighted hemisphere per unit cosine, exactly while it is above the
// horizon (Nusselt: its shadow on the unit sphere is a disc of area pi r^2 / d^2, whose base is cos_p times that):
//
//     occlusion = sum_X min(1, r^2 / d^2) max(0, cos_p),    accessibility = clamp(1 - occlusion, 0, 1)
//
// differs: ISR (26) has the solid angle of a cap, 2 pi (1 - sqrt(1 - r^2 / d^2)), over N, times a cosine whose vector is
// not normalised (variant `published`). A length has no place in it: the vector is in units of `length_unit`, or of |PX|.
#pragma once

#include "gi/isr/gather_kernel.h"

namespace plumb::isr {

struct SsaoInputsView {
    SampleUniforms u;             // area: over pi
    const float* surface;         // [height][width] rgba32f
    const float* source_surface;  // [source_height][source_width] rgba32f
    const float* gathered;        // [height][width] rgba32f: xyz goes through; null: 0
    const std::int32_t* offsets;  // [samples][rotations]
    float* lit;                   // out: [height][width] rgba32f
    const float* shared;          // SourcePlanes
};

// What a sample X of the occlusion is.
template <class F>
struct Sphere {
    vec3<F> position;  // from the eye, m
    F radius2;         // m2
};

template <class F>
PLUMB_INLINE Sphere<F> sphere_of(const SampleUniforms& u, index_t<F> x, index_t<F> y, const vec4<F>& texel) {
    const Surface<F> s = surface_of<F>(u, x, y, texel);
    return {s.position, (F(u.area) * s.depth) * s.depth};
}

// The samples of pixel (px, py), from the image. Beyond the border there is no surface.
template <class F>
struct SphereImage {
    const SsaoInputsView& in;
    index_t<F> px, py, rotation;

    template <class Tap>
    PLUMB_INLINE Sphere<F> at(int k, Tap& tap) const {
        using N = number<F>;
        using I = index_t<F>;
        const SampleUniforms& u = in.u;
        const ivec2<I> offset = offset_of(N::fetch(in.offsets, rotation + I(k * u.rotations)));
        const ivec2<I> texel{px + offset.x + I(u.margin), py + offset.y + I(u.margin)};
        tap("texel", texel, "pixel of the sources");
        const mask_t<F> inside = in_range(texel.x, I(u.source_width)) & in_range(texel.y, I(u.source_height));
        tap("inside", inside, "1 if the sources have that pixel");
        const I i = select(inside, texel.y * I(u.source_width) + texel.x, I(0));
        const vec4<F> fetched = N::fetch4(in.source_surface, i);
        const F zero(0.0f);
        const vec4<F> surface{select(inside, fetched.x, zero), select(inside, fetched.y, zero),
                              select(inside, fetched.z, zero), select(inside, fetched.w, zero)};
        return sphere_of<F>(u, px + offset.x, py + offset.y, surface);
    }
};

template <class F, bool published, class Tap>
PLUMB_INLINE F occlusion_of(const Surface<F>& p, const Sphere<F>& x, float per_length, Tap& tap) {
    const vec3<F> d = x.position - p.position;
    const F distance = sqrt(max(dot3(d, d), F(least_distance2))); tap("distance", distance, "|X - P|, m");
    const F cos_p = max(F(0.0f), dot3(p.normal, d));              tap("cos_p", cos_p, "max(0, n_p.(X - P)), m");
    const F inverse = F(1.0f) / distance;
    const F ratio = min(F(1.0f), (x.radius2 * inverse) * inverse);
    tap("ratio", ratio, "min(1, r^2 / d^2)");
    // 1 - sqrt(1 - ratio), without its cancellation.
    const F cap = published ? ratio / (F(1.0f) + sqrt(F(1.0f) - ratio)) : ratio;
    const F cosine = cos_p * (published && per_length > 0.0f ? F(per_length) : inverse);
    const F occlusion = cap * cosine;
    tap("occlusion", occlusion, "min(1, r^2 / d^2) cos_p; ISR (26): (1 - sqrt(1 - r^2 / d^2)) max(n.PX, 0)");
    return occlusion;
}

template <class F, bool published, class Spheres, class Tap>
PLUMB_INLINE F accessibility_by(const SampleUniforms& u, const Surface<F>& p, const Spheres& spheres, Tap& tap) {
    const mask_t<F> covered = is_covered(p);
    const F zero(0.0f), one(1.0f);
    F sum(0.0f);
    const int samples = 4 * u.rings * (u.rings + 1);
    for (int k = 0; any(covered) && k < samples; ++k) {
        tap.sample(k);
        const Sphere<F> x = spheres.at(k, tap);
        tap("x", x.position, "X, from the eye, m");
        sum += occlusion_of<F, published>(p, x, u.per_length, tap);
    }
    tap.sample(-1);
    const F occlusion = published ? sum * F(u.scale) : sum;       tap("sum", occlusion, "of all samples");
    const F accessibility = select(covered, clamp(one - occlusion, zero, one), one);
    tap("accessibility", accessibility, "1 open .. 0 closed");
    return accessibility;
}

// The pixel (px, py), by whatever reads its samples: SphereImage, or a packet's view of planes (source_planes.h).
template <class F, class Spheres, class Tap>
PLUMB_INLINE vec4<F> ssao(const SsaoInputsView& in, index_t<F> px, index_t<F> py, const Spheres& spheres, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const SampleUniforms& u = in.u;
    const I pixel = py * I(u.width) + px;
    const Surface<F> p = surface_of<F>(u, px, py, N::fetch4(in.surface, pixel));
    tap("p", p.position, "P, from the eye, m");
    tap("n_p", p.normal, "unit normal of P");
    const F accessibility = u.published != 0 ? accessibility_by<F, true>(u, p, spheres, tap)
                                             : accessibility_by<F, false>(u, p, spheres, tap);
    const F zero(0.0f);
    const vec3<F> none{zero, zero, zero};
    const vec3<F> gathered = in.gathered ? xyz<F>(N::fetch4(in.gathered, pixel)) : none;
    return vec4<F>(select3<F>(is_covered(p), gathered, none), accessibility);
}

struct SsaoKernel {
    using View = SsaoInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return ssao<F>(in, px, py, SphereImage<F>{in, px, py, rotation_of<F>(in.u, px, py)}, tap);
    }
    static float* out(const View& in) { return in.lit; }
    static std::size_t shared_floats(const View& in) { return SourcePlanes::floats(in.u, SourcePlanes::of_ssao); }
    static int shared_rows(const View& in) { return in.u.source_height; }
};

}  // namespace plumb::isr
