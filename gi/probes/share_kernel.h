// What a ray of a receiver counts for: its weight in the integral over directions, divided among the probes that see what it
// met. The algorithm that share.comp mirrors line by line.
//
//     share = f_k / sum_i w_i V_i        K_ij = w_i V_i Y_j / sum_k w_k V_k                                   IPR 3.1.2.3
//
// f_k is pi / N for directions distributed by the cosine, 2 pi cos(theta) / N for uniform ones. A ray whose end no probe sees
// counts for nothing.
//
// differs: the Monte-Carlo weight of IPR 3.2.3.2 lacks the cosine that (5) has.
// `published`: times W(x) = 1 - 1 / (2 pi x^2 + 1), x the ray's length (IPR 5.1.3.2). It depends on the unit of length.
// differs: as t / (t + 1), t = 2 pi x^2. As printed it cancels for short rays: below 0.1 mm no digit is right.
#pragma once

#include "core/number.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct ShareUniforms {
    std::int32_t width, height;    // receivers, rays of each
    std::int32_t slots;            // supporting probes of a receiver
    std::int32_t published;        // 1: weighted by the ray's length
};
static_assert(sizeof(ShareUniforms) == 16);

struct ShareView {
    ShareUniforms u;
    const float* supporting;       // [slots][width][4]: xyz the probe, m; w its weight, 0: none
    const float* factors;          // [height]: f_k
    const std::int32_t* visible;   // [height][width]: bit i: probe i sees what the ray met
    const float* lengths;          // [height][width]: m, of the ray; 1e15 where it met nothing
    float* share;                  // out: [height][width]
};

template <class F, class Tap>
PLUMB_INLINE F share(const ShareView& in, index_t<F> receiver, index_t<F> ray, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const ShareUniforms& u = in.u;
    const I at = ray * I(u.width) + receiver;
    const I visible = N::fetch(in.visible, at);                   tap("visible", visible, "a bit for each supporting probe");
    F sum(0.0f);
    for (int slot = 0; slot < u.slots; ++slot) {
        tap.sample(slot);
        const F w = N::fetch(in.supporting, (I(slot * u.width) + receiver) * I(4) + I(3));
        tap("w", w, "w_i(x)");
        sum += select((shift_right(visible, slot) & I(1)) == I(1), w, F(0.0f));
    }
    tap.sample(-1);                                               tap("sum", sum, "sum_k w_k V_k");
    const F x = N::fetch(in.lengths, at);                         tap("length", x, "x, m");
    const F t = F(6.28318531f) * x * x;
    const F w_x = t / (t + F(1.0f));                              tap("W", w_x, "W(x) = t / (t + 1), t = 2 pi x^2");
    const F factor = N::fetch(in.factors, ray) * (u.published == 1 ? w_x : F(1.0f));
    tap("factor", factor, "f_k, of the published variant times W(x), sr");
    const mask_t<F> seen = sum > F(0.0f);
    const F share = select(seen, factor / select(seen, sum, F(1.0f)), F(0.0f));
    tap("share", share, "f_k / sum_k w_k V_k, sr");
    return share;
}

struct ShareKernel {
    using View = ShareView;
    template <class F, class Tap>
    PLUMB_INLINE static F item(const View& in, index_t<F> receiver, index_t<F> ray, Tap& tap) {
        return probes::share<F>(in, receiver, ray, tap);
    }
    static float* out(const View& in) { return in.share; }
};

}  // namespace plumb::probes
