// Which probes support a receiver (IPR 3.2.3.2, figure 3.16), and with which weight: the algorithm that supports.comp
// mirrors line by line.
//
// An item is a slot of a receiver, the nearest probe in slot 0. Each sorts the nearest probes into all slots and takes its
// own: comparisons are between different probes, so that what two roundings of one distance are is never asked.
// stages_isa.cpp sorts once for all slots of a receiver.
#pragma once

#include "core/store_index.h"
#include "gi/probes/weight_kernel.h"

namespace plumb::probes {

// The twin's uniform block (std140).
struct SupportsUniforms {
    std::int32_t width, height;  // slots of a receiver; receivers
    std::int32_t probes;
    float radius;                // m
};
static_assert(sizeof(SupportsUniforms) == 16);

struct SupportsView {
    SupportsUniforms u;
    const float* receivers;  // [height][4]: xyz m
    const float* probes;     // [probes][4]: xyz m
    std::int32_t* support;   // out: [height][width]
    float* weight;           // out: [height][width]
};
inline constexpr int most_overlaps = 16;

template <class F>
struct Support {
    index_t<F> probe;  // -1: none
    F weight;
    template <class Each>
    void components(Each each) const {
        each(number<F>::from_index(probe)), each(weight);
    }
};

// The nearest probes of a receiver: distance^2 and index, in [0, width).
template <class F>
struct Nearest {
    F d2[most_overlaps];
    index_t<F> probe[most_overlaps];  // -1: none
};

// Sorted by distance; of equals the lower index is first. Only what is nearer than the radius counts.
template <class F>
PLUMB_INLINE Nearest<F> nearest_probes(const SupportsView& in, const vec3<F>& x) {
    using I = index_t<F>;
    const int last = in.u.width - 1;
    Nearest<F> n;
    for (int k = 0; k <= last; ++k) n.d2[k] = F(in.u.radius) * F(in.u.radius), n.probe[k] = I(-1);
    for (int j = 0; j < in.u.probes; ++j) {
        const F d2 = distance2<F>(position_of<F>(in.probes, j), x);
        mask_t<F> nearer = d2 < n.d2[last];
        if (!any(nearer)) continue;
        for (int k = last; k > 0; --k) {
            const mask_t<F> passes = d2 < n.d2[k - 1];
            n.d2[k] = select(nearer, select(passes, n.d2[k - 1], d2), n.d2[k]);
            n.probe[k] = select(nearer, select(passes, n.probe[k - 1], I(j)), n.probe[k]);
            nearer = passes;
        }
        n.d2[0] = select(nearer, d2, n.d2[0]);
        n.probe[0] = select(nearer, I(j), n.probe[0]);
    }
    return n;
}

// What is written of slot k.
template <class F>
PLUMB_INLINE Support<F> support_of(const SupportsView& in, const Nearest<F>& n, int k) {
    const mask_t<F> found = index_t<F>(-1) < n.probe[k];
    return {n.probe[k], select(found, spatial_weight<F>(sqrt(n.d2[k]) / F(in.u.radius)), F(0.0f))};
}

template <class F, class Tap>
PLUMB_INLINE Support<F> support(const SupportsView& in, index_t<F> slot, index_t<F> receiver, Tap& tap) {
    using I = index_t<F>;
    const vec3<F> x = xyz<F>(number<F>::fetch4(in.receivers, receiver));
    tap("receiver", x, "x, m");
    const Nearest<F> n = nearest_probes<F>(in, x);
    Support<F> own{I(-1), F(0.0f)};
    for (int k = 0; k < in.u.width; ++k) {
        tap.sample(k);
        const Support<F> s = support_of<F>(in, n, k);
        tap("probe", s.probe, "the next by distance, then by index; -1: none within the radius");
        tap("distance2", n.d2[k], "|x - p|^2, m2; radius^2: none");
        tap("weight", s.weight, "w_i(x) = w(|x - p| / r)");
        const mask_t<F> here = slot == I(k);
        own.probe = select(here, s.probe, own.probe);
        own.weight = select(here, s.weight, own.weight);
    }
    tap.sample(-1);
    return own;
}

struct SupportsKernel {
    using View = SupportsView;
    static constexpr int band = 64;
    template <class F, class Tap>
    PLUMB_INLINE static Support<F> item(const View& in, index_t<F> slot, index_t<F> receiver, Tap& tap) {
        return support<F>(in, slot, receiver, tap);
    }
    template <class F>
    PLUMB_INLINE static void store(const View& in, index_t<F> at, const Support<F>& s, mask_t<F> active) {
        store_index<F>(in.support, at, s.probe, active);
        number<F>::store(in.weight, at, s.weight, active);
    }
};

}  // namespace plumb::probes
