// How much of each harmonic of each supporting probe a receiver gathers: the algorithm that coefficients.comp mirrors line by
// line.
//
//     alpha_ij = sum_k share_k w_i V_i(w_k) Y_j(Psi_i(w_k))        Psi_i: from probe i to what ray k met       IPR (4), (9)
//
// share_k (share_kernel.h) holds the weight of the ray and the sum over probes. A ray that met nothing (seen.w = 0) goes in
// its own direction from every probe.
#pragma once

#include "core/number.h"
#include "core/sh_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct CoefficientsUniforms {
    std::int32_t width, height;    // receivers; slots x coefficients
    std::int32_t rays;             // of each receiver
    std::int32_t slots;            // supporting probes of a receiver
};
static_assert(sizeof(CoefficientsUniforms) == 16);

struct CoefficientsView {
    CoefficientsUniforms u;
    const std::int32_t* rows;      // [height][4]: slot, degree l, |m|, 1 where m < 0
    const float* recurrence;       // core/sh_kernel.h
    const float* supporting;       // [slots][width][4]: xyz the probe, m; w its weight, 0: none
    const float* seen;             // [rays][width][4]: xyz what the ray met, m, w 1; or its direction, w 0
    const std::int32_t* visible;   // [rays][width]: bit i: probe i sees what the ray met
    const float* shares;           // [rays][width], sr
    float* alpha;                  // out: [slots][coefficients][width], sr
};

// Rays that are added up before they are added to the others. One sum of 2048 equal terms is off by 75 times what its inputs
// explain; a part of 128 and sums of 256 parts stay within the budget (README.md).
inline constexpr int rays_a_sum = 128;

// Psi: the direction from a probe to what was seen. The least length keeps 0 / 0 out of the way.
template <class F, class Tap>
PLUMB_INLINE vec3<F> direction_to(const vec4<F>& seen, const vec4<F>& probe, Tap& tap) {
    const vec3<F> d{seen.x - seen.w * probe.x, seen.y - seen.w * probe.y, seen.z - seen.w * probe.z};
    const F length = max(sqrt(d.x * d.x + d.y * d.y + d.z * d.z), F(1e-18f));
    tap("distance", length, "m, from the probe to what the ray met; 1 where it met nothing");
    return {d.x / length, d.y / length, d.z / length};
}

template <class F, class Tap>
PLUMB_INLINE F coefficient(const CoefficientsView& in, index_t<F> receiver, index_t<F> row, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const CoefficientsUniforms& u = in.u;
    // Whatever a dump holds, no table is left.
    const I slot = max(I(0), min(N::fetch(in.rows, row * I(4)), I(u.slots - 1)));
    const I l = max(I(0), min(N::fetch(in.rows, row * I(4) + I(1)), I(sh::kernel_degrees - 1)));
    const I m = max(I(0), min(N::fetch(in.rows, row * I(4) + I(2)), l));
    const mask_t<F> sine = N::fetch(in.rows, row * I(4) + I(3)) == I(1);
    tap("slot", slot, "i"), tap("l", l, "degree"), tap("m", m, "|m|");
    const vec4<F> probe = N::fetch4(in.supporting, slot * I(u.width) + receiver);
    tap("probe", xyz<F>(probe), "p_i, m"), tap("w", probe.w, "w_i(x)");
    F sum(0.0f);
    for (int first = 0; first < u.rays; first += rays_a_sum) {
        F part(0.0f);
        for (int k = first; k < min(first + rays_a_sum, u.rays); ++k) {
            tap.sample(k);
            const I at = I(k * u.width) + receiver;
            const mask_t<F> sees = (shift_right(N::fetch(in.visible, at), slot) & I(1)) == I(1);
            tap("V", sees, "V_i: 1 if the probe sees what the ray met");
            const F weight = select(sees, N::fetch(in.shares, at) * probe.w, F(0.0f));
            tap("weight", weight, "f_k w_i V_i / sum_k w_k V_k, sr");
            const vec3<F> psi = direction_to<F>(N::fetch4(in.seen, at), probe, tap);
            tap("psi", psi, "Psi_i, unit");
            const F before = part;
            part = sh::add_harmonic<F>(in.recurrence, l, m, sine, psi, weight, before);
            tap("part", part, "sum over the rays of this part so far of weight Y_j(Psi_i), sr");
        }
        sum = sum + part;
    }
    tap.sample(-1);                                               tap("alpha", sum, "alpha_ij, sr");
    return sum;
}

struct CoefficientsKernel {
    using View = CoefficientsView;
    // Rows of one slot that are computed at once.
    static constexpr int band = 64;
    template <class F, class Tap>
    PLUMB_INLINE static F item(const View& in, index_t<F> receiver, index_t<F> row, Tap& tap) {
        return coefficient<F>(in, receiver, row, tap);
    }
    static float* out(const View& in) { return in.alpha; }
};

}  // namespace plumb::probes
