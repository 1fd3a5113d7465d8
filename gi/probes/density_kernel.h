// The kernel density of candidates for probes, K_i = sum over j != i of w(|p_j - p_i| / r) (IPR 3.2.2.1): the algorithm
// that density.comp mirrors line by line.
//
// Plain: every candidate asks all others, in their order, and adds up blocks of them before it adds these: one sum of thousands
// would lose a digit. stages_isa.cpp leaves out blocks that are farther away than r, whose terms are 0: the same sum, to the bit.
#pragma once

#include "gi/probes/weight_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct DensityUniforms {
    std::int32_t width, height;  // of the domain: the list, folded to rows
    std::int32_t count;          // candidates
    float inverse_radius;        // 1/r, in one over the positions' unit
};
static_assert(sizeof(DensityUniforms) == 16);

inline constexpr int block = 64;  // candidates

struct DensityView {
    DensityUniforms u;
    const float* positions;  // [count][4]: xyz
    const float* blocks;     // of our own: [blocks][6], bounds of `block` candidates each: low xyz, high xyz
    float* density;          // out: [height][width]
};

// What candidate j adds to the density at p.
template <class F>
PLUMB_INLINE F density_term(const DensityView& in, const vec3<F>& p, index_t<F> i, int j) {
    using I = index_t<F>;
    const F t = sqrt(distance2<F>(position_of<F>(in.positions, j), p)) * F(in.u.inverse_radius);
    const mask_t<F> counts = (t < F(1.0f)) & !(i == I(j));
    return select(counts, spatial_weight<F>(t), F(0.0f));
}

template <class F, class Tap>
PLUMB_INLINE F density(const DensityView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const I i = min(py * I(in.u.width) + px, I(in.u.count - 1));
    const vec3<F> p = xyz<F>(N::fetch4(in.positions, i));         tap("position", p, "p_i");
    F sum(0.0f);
    for (int first = 0; first < in.u.count; first += block) {
        F part(0.0f);
        for (int j = first; j < min(first + block, in.u.count); ++j) {
            tap.sample(j);
            const F w = density_term<F>(in, p, i, j);             tap("w", w, "w(|p_j - p_i| / r), 0 for i itself");
            part = part + w;
        }
        sum = sum + part;
    }
    tap.sample(-1);
    tap("density", sum, "K_i = sum of w");
    return sum;
}

struct DensityKernel {
    using View = DensityView;
    static constexpr int band = 1;
    template <class F, class Tap>
    PLUMB_INLINE static F item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return density<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.density; }
    // The last row of the fold may be longer than the list.
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        using I = index_t<F>;
        return py * I(in.u.width) + px < I(in.u.count);
    }
};

}  // namespace plumb::probes
