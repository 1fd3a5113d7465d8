// The images of lamps in flat mirrors. A path cannot run into a lamp, which is a point, and a mirror sends light from it into
// one direction alone: so that light is asked for where the lamp's image stands. The lamp P is mirrored at a plane, that
// image at another, and so on, k of them:
//
//     P_j = P_(j-1) - 2 (n_j . P_(j-1) - d_j) n_j
//
// From x a ray to P_k must meet plane k on a mirror that lies in it, from there one to P_(k-1) plane k - 1, ..., and at last
// P itself must be seen. Then x receives I cos / D^2 times the mirrors' reflectances, D = |x - P_k| the length of all
// segments together, I the lamp's intensity towards the last mirror.
//
// Lamp, k and planes are chosen by chance and the light divided by their probability: lamps and planes evenly, each plane
// another than the one before; k with 1/2, 1/4, 1/8, 1/8.
#pragma once

#include "gi/reference/light_kernel.h"

namespace plumb::reference {

struct MirrorArgs {
    std::int32_t count;          // planes; 0: no flat mirror, or no lamp
    std::int32_t lamps;          // the first rows of the lights
    const float* planes;         // [plane][4]: normal, d
    const std::int32_t* plane;   // [triangle]; -1: none
};

inline constexpr int longest_mirror_chain = 4;
// One plane alone mirrors once.
inline int longest_of(const MirrorArgs& in) { return in.count > 1 ? longest_mirror_chain : 1; }

// An image, and the way to it.
template <class F>
struct LampImage {
    index_t<F> lamp;
    index_t<F> length;                              // k
    vec3<F> point[longest_mirror_chain + 1];        // P_0 to P_k; of a directional light the direction of its light
    index_t<F> plane[longest_mirror_chain];         // of P_(j+1)
    mask_t<F> infinite;
    F weight;                                       // 1 / probability
};

// One of 0 to n - 1.
template <class F>
PLUMB_INLINE index_t<F> choose_evenly(F u, index_t<F> n) {
    using N = number<F>;
    return min(N::truncate_to_index(u * N::from_index(n)), n - index_t<F>(1));
}

// `first` chooses lamp, length and plane, `others` further planes: numbers in [0, 1).
template <class F>
PLUMB_INLINE LampImage<F> choose_image(const LightArgs& lights, const MirrorArgs& in, const vec3<F>& first, const vec3<F>& others) {
    using N = number<F>;
    using I = index_t<F>;
    const F half(0.5f), two(2.0f);
    LampImage<F> image;
    image.lamp = choose_evenly<F>(first.x, I(in.lamps));
    const Record<F> row = N::fetch_record(lights.rows, image.lamp);
    image.infinite = row.c.w == F(float(int(LightKind::directional)));
    image.point[0] = select3<F>(image.infinite, xyz<F>(row.b), xyz<F>(row.a));

    const int longest = longest_of(in);
    image.length = I(1);
    F probability(in.count > 1 ? 0.5f : 1.0f), bound = half;
    for (int k = 2; k <= longest; ++k) {
        const mask_t<F> longer = first.y >= bound;
        image.length = select(longer, I(k), image.length);
        if (k < longest) probability = select(longer, probability * half, probability);
        bound = bound + (F(1.0f) - bound) * half;
    }

    image.weight = N::from_index(I(in.lamps)) / probability;
    for (int j = 0; j < longest; ++j) {
        const mask_t<F> has = image.length > I(j);
        if (j == 0) {
            image.plane[0] = choose_evenly<F>(first.z, I(in.count));
        } else {
            const F u = j == 1 ? others.x : j == 2 ? others.y : others.z;
            const I other = choose_evenly<F>(u, I(in.count - 1));
            image.plane[j] = select(other < image.plane[j - 1], other, other + I(1));
        }
        image.weight = select(has, image.weight * F(float(j == 0 ? in.count : in.count - 1)), image.weight);
        const vec4<F> plane = N::fetch4(in.planes, image.plane[j]);
        const vec3<F> n = xyz<F>(plane), p = image.point[j];
        const F away = select(image.infinite, dot3(n, p), dot3(n, p) - plane.w);
        image.point[j + 1] = select3<F>(has, p - n * (two * away), p);
    }
    return image;
}

}  // namespace plumb::reference
