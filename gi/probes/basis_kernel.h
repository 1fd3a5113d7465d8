// Basis vectors of clusters: what the light at their probes amounts to, in the few directions that their receivers tell apart.
// The algorithm that basis.comp mirrors line by line.
//
//     b_c = (Sigma V^T)_c lambda                IPR 3.3.1.2, figure 3.31; lambda: the coefficients of the cluster's probes
//
// differs: a probe's coefficients are added up before they are added to the other probes': one sum of 30 x 64 terms would lose a
// digit. A cluster takes as many coefficients as its level of detail has (IPR 4.2.2); of a level that is none of 0 to 3 none.
//
// One item a lane: stages_isa.cpp has the loop over packets, which reads each row of a matrix once.
#pragma once

#include "core/number.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct BasisUniforms {
    std::int32_t width, height;   // singular values; clusters
    std::int32_t coefficients;    // of a probe
    std::int32_t probes;
    std::int32_t coefficients_0, coefficients_1, coefficients_2, coefficients_3;  // that are used, by level of detail
};
static_assert(sizeof(BasisUniforms) == 32);

struct BasisView {
    BasisUniforms u;
    const std::int32_t* clusters;        // [height][4]: first number of its matrix, first of its probes, probes, rank
    const std::int32_t* cluster_probes;  // cluster by cluster
    const std::int32_t* cluster_level;   // [height]
    const float* matrix;                 // cluster by cluster: [probes x coefficients][rank]
    const float* lambda;                 // [probes][coefficients][4]: xyz W/m2
    float* basis;                        // out: [height][width][4]
};

inline constexpr int most_singular_values = 64;
inline constexpr int no_level = 4;  // of detail: of no coefficients

template <class I>
PLUMB_INLINE I coefficients_used(const BasisUniforms& u, I level) {
    const I upper = select(level == I(2), I(u.coefficients_2), select(level == I(3), I(u.coefficients_3), I(0)));
    return select(level == I(0), I(u.coefficients_0), select(level == I(1), I(u.coefficients_1), upper));
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> basis(const BasisView& in, index_t<F> s, index_t<F> cluster, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const BasisUniforms& u = in.u;
    const I first = N::fetch(in.clusters, cluster * I(4)), first_probe = N::fetch(in.clusters, cluster * I(4) + I(1));
    const I probes = N::fetch(in.clusters, cluster * I(4) + I(2)), rank = N::fetch(in.clusters, cluster * I(4) + I(3));
    const I used = coefficients_used<I>(u, N::fetch(in.cluster_level, cluster));
    tap("rank", rank, "of the cluster's matrix"), tap("coefficients", used, "of a probe, by the cluster's level of detail");
    const I added = select(s < rank, min(probes, I(u.probes)), I(0));
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; any(I(k) < added); ++k) {
        tap.sample(k);
        const I probe = N::fetch(in.cluster_probes, first_probe + I(k));
        tap("probe", probe, "k-th of the cluster's");
        vec3<F> part{F(0.0f), F(0.0f), F(0.0f)};
        for (int j = 0; any(I(j) < used); ++j) {
            const F m = N::fetch(in.matrix, first + (I(k * u.coefficients + j)) * rank + s);
            const vec4<F> lambda = N::fetch4(in.lambda, probe * I(u.coefficients) + I(j));
            part.x = part.x + m * lambda.x;
            part.y = part.y + m * lambda.y;
            part.z = part.z + m * lambda.z;
        }
        tap("part", part, "sum of the probe's coefficients, W/m2");
        sum.x = sum.x + part.x;
        sum.y = sum.y + part.y;
        sum.z = sum.z + part.z;
    }
    tap.sample(-1);                                               tap("b", sum, "b_c, W/m2; 0 beyond the rank");
    return vec4<F>(sum, F(0.0f));
}

struct BasisKernel {
    using View = BasisView;
    // Clusters differ in size: each is a task of its own.
    static constexpr int band = 1;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> s, index_t<F> cluster, Tap& tap) {
        return basis<F>(in, s, cluster, tap);
    }
    static float* out(const View& in) { return in.basis; }
};

}  // namespace plumb::probes
