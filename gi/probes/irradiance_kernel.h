// Irradiance of receivers: the basis vector of a receiver's cluster, weighed by its row of U. The algorithm that
// irradiance.comp mirrors line by line.
//
//     I(x) = sum_s U_xs b_cs, s below the cluster's rank                                                      IPR 3.3.1.3
//
// Places are receivers in the order of their clusters (run_data.h). A place is computed where its cluster is there and where the
// cluster's level of detail shows it (IPR 4.2.3); what is not computed is 0, never stale, and so is its w.
#pragma once

#include "core/number.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct IrradianceUniforms {
    std::int32_t width, height;    // of the domain: the list of places, folded to rows
    std::int32_t count;            // places
    std::int32_t clusters;
    std::int32_t singular_values;
    std::int32_t padding[3];
};
static_assert(sizeof(IrradianceUniforms) == 32);

struct IrradianceView {
    IrradianceUniforms u;
    const std::int32_t* clusters;        // [clusters][4]: w the rank
    const std::int32_t* cluster_level;   // [clusters]
    const std::int32_t* cluster;         // [count]; -1: none
    const std::int32_t* receiver_level;  // [count]
    const float* transport;              // [singular_values][count]: U
    const float* basis;                  // [clusters][singular_values][4]: xyz W/m2
    float* irradiance;                   // out: [height][width][4]
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> irradiance(const IrradianceView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const IrradianceUniforms& u = in.u;
    const I place = min(py * I(u.width) + px, I(u.count - 1));
    const I own = N::fetch(in.cluster, place);                    tap("cluster", own, "c; -1: none");
    const mask_t<F> there = in_range(own, I(u.clusters));
    const I cluster = select(there, own, I(0));
    const I level = N::fetch(in.receiver_level, place);           tap("level", level, "of the receiver");
    const mask_t<F> computed = there & (level >= N::fetch(in.cluster_level, cluster));
    tap("computed", computed, "1: the cluster's level of detail shows the receiver");
    const I rank = select(computed, N::fetch(in.clusters, cluster * I(4) + I(3)), I(0));
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int s = 0; any(I(s) < rank); ++s) {
        tap.sample(s);
        const F weight = N::fetch(in.transport, I(s * u.count) + place);
        tap("u", weight, "U_xs");
        const vec3<F> b = xyz<F>(N::fetch4(in.basis, cluster * I(u.singular_values) + I(s)));
        tap("b", b, "b_cs, W/m2");
        const vec3<F> with{sum.x + weight * b.x, sum.y + weight * b.y, sum.z + weight * b.z};
        sum = select3<F>(I(s) < rank, with, sum);
    }
    tap.sample(-1);                                               tap("irradiance", sum, "I = sum of U_xs b_cs, W/m2");
    return vec4<F>(sum, select(computed, F(1.0f), F(0.0f)));
}

struct IrradianceKernel {
    using View = IrradianceView;
    // Of 1024 places each.
    static constexpr int band = 4;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return irradiance<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.irradiance; }
    // The last row of the fold may be longer than the list.
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        using I = index_t<F>;
        return py * I(in.u.width) + px < I(in.u.count);
    }
};

}  // namespace plumb::probes
