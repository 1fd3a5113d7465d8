// What a probe sees, as coefficients of harmonics: the algorithm that lambda.comp mirrors line by line.
//
//     lambda_ij = sum_r w_r f_i(r) Y_j(r)                r: the relight rays of the probe's level of detail          IPR (10)
//
// Levels of detail (IPR 4.2.1) have fewer rays, the first of them, with weights of their own, and fewer coefficients; of these on it
// is 0. Rays are added in parts of 128, and the parts then, as the coefficients of receivers are.
//
// differs: w_r = 4 pi / N there; relight_weights() integrate harmonics exactly. A window over the
// degrees is in the table of harmonics (window.h): the kernel does not know it.
#pragma once

#include "gi/probes/coefficients_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct LambdaUniforms {
    std::int32_t width, height;    // coefficients (degree + 1)^2; probes
    std::int32_t rays;             // of each probe at level 0
    std::int32_t levels;           // of detail
    std::int32_t rays_0, rays_1, rays_2, rays_3;                          // of each level: the first
    std::int32_t coefficients_0, coefficients_1, coefficients_2, coefficients_3;
};
static_assert(sizeof(LambdaUniforms) == 48);

struct LambdaView {
    LambdaUniforms u;
    const float* radiance;            // [height][rays][4]: xyz f, W/(m2 sr)
    const float* harmonics;           // [rays][width]
    const float* weights;             // [levels][rays], sr
    const std::int32_t* probe_level;  // [height]
    float* lambda;                    // out: [height][width][4]: xyz W/(m2 sr^(1/2)); w 0
};

// Of four numbers that of a level.
template <class I>
PLUMB_INLINE I of_level(I level, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    return select(level < I(2), select(level < I(1), I(a), I(b)), select(level < I(3), I(c), I(d)));
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> lambda(const LambdaView& in, index_t<F> j, index_t<F> probe, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const LambdaUniforms& u = in.u;
    // Whatever a dump holds, no table is left.
    const I level = max(I(0), min(N::fetch(in.probe_level, probe), I(u.levels - 1)));
    tap("level", level, "of detail");
    const I coefficients = of_level<I>(level, u.coefficients_0, u.coefficients_1, u.coefficients_2, u.coefficients_3);
    tap("coefficients", coefficients, "of the level");
    const I all = min(of_level<I>(level, u.rays_0, u.rays_1, u.rays_2, u.rays_3), I(u.rays));
    const I rays = select(j < coefficients, all, I(0));           tap("rays", rays, "of the level; 0 behind its coefficients");
    const F zero(0.0f);
    vec3<F> sum{zero, zero, zero};
    for (int first = 0; any(I(first) < rays); first += rays_a_sum) {
        vec3<F> part{zero, zero, zero};
        for (int r = first; r < first + rays_a_sum && any(I(r) < rays); ++r) {
            tap.sample(r);
            const mask_t<F> counts = I(r) < rays;
            const F w = N::fetch(in.weights, level * I(u.rays) + I(r));
            tap("w", w, "w_r, sr");
            const vec3<F> f = xyz<F>(N::fetch4(in.radiance, probe * I(u.rays) + I(r)));
            tap("f", f, "f(r), W/(m2 sr)");
            const F y = N::fetch(in.harmonics, I(r * u.width) + j);
            tap("y", y, "Y_j(r)");
            part.x = part.x + select(counts, w * f.x * y, zero);
            part.y = part.y + select(counts, w * f.y * y, zero);
            part.z = part.z + select(counts, w * f.z * y, zero);
            tap("part", part, "sum over the rays of this part so far of w_r f(r) Y_j(r)");
        }
        sum = {sum.x + part.x, sum.y + part.y, sum.z + part.z};
    }
    tap.sample(-1);                                               tap("lambda", sum, "lambda_ij, W/(m2 sr^(1/2))");
    return vec4<F>(sum, zero);
}

struct LambdaKernel {
    using View = LambdaView;
    static constexpr int band = 2;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> j, index_t<F> probe, Tap& tap) {
        return lambda<F>(in, j, probe, tap);
    }
    static float* out(const View& in) { return in.lambda; }
};

}  // namespace plumb::probes
