#include <cstring>

#include "core/shade_rows.h"
// After core/wide.h, so that the kernels see their number.
#include "gi/probes/basis_kernel.h"
#include "gi/probes/irradiance_kernel.h"
#include "gi/probes/lightmap_write_kernel.h"

namespace plumb::probes {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

constexpr int most_packets = 4;  // at once: a load for three products and sums each

// Calls work.run<n>() for n of 1 to most_packets: so many sums stay in registers.
template <class Work>
PLUMB_INLINE void with_packets(int n, const Work& work) {
    switch (n) {
        case 1: return work.template run<1>();
        case 2: return work.template run<2>();
        case 3: return work.template run<3>();
        default: return work.template run<most_packets>();
    }
}

template <int n>
PLUMB_INLINE void add(vec3<F> (&sums)[n], int k, F weight, F r, F g, F b) {
    sums[k].x = sums[k].x + weight * r;
    sums[k].y = sums[k].y + weight * g;
    sums[k].z = sums[k].z + weight * b;
}

// ---- probes.basis -----------------------------------------------------------------------------------------------------

// A probe's rows of a cluster's matrix, [coefficients][rank], its coefficients, and the sums of packets of singular values from
// `first` on.
struct ProbeRows {
    const float* rows;
    int rank, first, used, whole;  // whole: so many rows are followed by as many numbers as packets take
    const float* lambda;
    vec3<F>* sums;

    template <int n>
    PLUMB_INLINE void run() const {
        vec3<F> part[n];
#pragma GCC unroll 4
        for (int k = 0; k < n; ++k) part[k] = {F(0.0f), F(0.0f), F(0.0f)};
        const auto row = [&](int j, auto load) {
            const float *m = rows + std::ptrdiff_t(j) * rank + first, *l = lambda + 4 * std::ptrdiff_t(j);
            const F r(l[0]), g(l[1]), b(l[2]);
#pragma GCC unroll 4
            for (int k = 0; k < n; ++k) add<n>(part, k, load(m, k * N::width), r, g, b);
        };
        for (int j = 0; j < whole; ++j) row(j, [](const float* m, int at) { return N::load(m + at); });
        for (int j = whole; j < used; ++j)
            row(j, [&](const float* m, int at) { return N::fetch(m, min(N::iota(at), I(rank - 1 - first))); });
#pragma GCC unroll 4
        for (int k = 0; k < n; ++k)
            sums[k] = {sums[k].x + part[k].x, sums[k].y + part[k].y, sums[k].z + part[k].z};
    }
};

// All singular values of a cluster at once: its matrix is read once, in its order. Lanes beyond the rank hold what comes next in
// it, and are not stored.
void basis_of_cluster(const BasisView& in, int cluster) {
    const std::int32_t* of = in.clusters + 4 * std::ptrdiff_t(cluster);
    const int rank = of[3], used = coefficients_used<std::int32_t>(in.u, in.cluster_level[cluster]);
    const int packets = (rank + N::width - 1) / N::width;
    vec3<F> sums[most_singular_values / N::width + 1];
    for (int k = 0; k < packets; ++k) sums[k] = {F(0.0f), F(0.0f), F(0.0f)};
    const int probes = min(of[2], in.u.probes), all_rows = probes * in.u.coefficients;
    for (int p = 0; rank > 0 && p < probes; ++p) {
        const std::ptrdiff_t probe = in.cluster_probes[of[1] + p];
        const int row = p * in.u.coefficients;
        // Rows from which on a packet would end behind the matrix.
        const int beyond = (packets * N::width - rank + rank - 1) / rank;
        const int whole = max(0, min(used, all_rows - beyond - row));
        for (int first = 0; first < packets; first += most_packets)
            with_packets(min(packets - first, most_packets),
                         ProbeRows{in.matrix + of[0] + std::ptrdiff_t(row) * rank, rank, first * N::width, used, whole,
                                   in.lambda + 4 * probe * in.u.coefficients, sums + first});
    }
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    for (int s = 0; s < in.u.width; s += N::width) {
        const vec3<F> b = s < rank ? select3<F>(N::iota(s) < I(rank), sums[s / N::width], zero) : zero;
        N::store4(in.basis, I(cluster * in.u.width) + N::iota(s), vec4<F>(b, F(0.0f)), N::iota(s) < I(in.u.width));
    }
}

// ---- probes.irradiance ------------------------------------------------------------------------------------------------

PLUMB_INLINE I load_index(const std::int32_t* p) {
    I i;
    std::memcpy(&i, p, sizeof i);
    return i;
}

// Packets over `count` places of one cluster: its basis is the same for all, and U lies in the order of the places. Lanes beyond
// read the next cluster's U, and are not stored.
struct PlacesOfCluster {
    const IrradianceView& in;
    int first, count, cluster;

    template <int n>
    PLUMB_INLINE void run() const {
        vec3<F> sum[n];
        mask_t<F> computed[n];
        const bool there = in_range(cluster, in.u.clusters);
        const I level(there ? in.cluster_level[cluster] : 0);
        mask_t<F> some = I(1) < I(0);
#pragma GCC unroll 4
        for (int k = 0; k < n; ++k) {
            sum[k] = {F(0.0f), F(0.0f), F(0.0f)};
            computed[k] = (load_index(in.receiver_level + first + k * N::width) >= level) & (N::iota(k * N::width) < I(there ? count : 0));
            some = some | computed[k];
        }
        if (any(some)) add_basis(sum);
        const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
#pragma GCC unroll 4
        for (int k = 0; k < n; ++k)
            N::store4(in.irradiance, N::iota(first + k * N::width),
                      vec4<F>(select3<F>(computed[k], sum[k], zero), select(computed[k], F(1.0f), F(0.0f))),
                      N::iota(k * N::width) < I(count));
    }

    template <int n>
    PLUMB_INLINE void add_basis(vec3<F> (&sum)[n]) const {
        const float* b = in.basis + 4 * std::ptrdiff_t(cluster) * in.u.singular_values;
        const float* u = in.transport + first;
        for (int left = in.clusters[4 * std::ptrdiff_t(cluster) + 3]; left > 0; --left, b += 4, u += in.u.count) {
            const F red(b[0]), green(b[1]), blue(b[2]);
#pragma GCC unroll 4
            for (int k = 0; k < n; ++k) add<n>(sum, k, N::load(u + k * N::width), red, green, blue);
        }
    }
};

}  // namespace

}  // namespace plumb::probes

namespace plumb {

using namespace probes;

template <>
void Rows<BasisKernel, Isa::PLUMB_ISA>::run(const BasisView& in, int first, int last, const Tiles&, float*) {
    for (int cluster = first; cluster < last; ++cluster) basis_of_cluster(in, cluster);
}

template <>
void Rows<IrradianceKernel, Isa::PLUMB_ISA>::run(const IrradianceView& in, int first, int last, const Tiles&, float*) {
    const int end = min(last * in.u.width, in.u.count);
    for (int i = first * in.u.width; i < end;) {
        const int cluster = in.cluster[i], most = min(end - i, most_packets * N::width);
        int count = 1;
        while (count < most && in.cluster[i + count] == cluster) ++count;
        const int packets = (count + N::width - 1) / N::width;
        if (i + packets * N::width <= in.u.count) {
            with_packets(packets, PlacesOfCluster{in, i, count, cluster});
            i += count;
            continue;
        }
        // The last places of the list.
        NoTap tap;
        const I place = N::iota(i);
        N::store4(in.irradiance, place, irradiance<F>(in, place, I(0), tap), place < I(end));
        i += N::width;
    }
}

// Texel by texel: a value is copied whole, and lanes that gather would make all others wait.
template <>
void Rows<LightmapKernel, Isa::PLUMB_ISA>::run(const LightmapView& in, int first, int last, const Tiles& tiles, float*) {
    using One = number<float>;
    for (int y = first; y < last; ++y) {
        const std::uint8_t* row = tiles.row(y);
        for (int x = 0; x < in.u.width; ++x) {
            if (row && !row[x >> 4]) continue;
            NoTap tap;
            One::store4(in.lightmap, y * in.u.width + x, lightmap<float>(in, x, y, tap), true);
        }
    }
}

}  // namespace plumb
