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

// The first `count` lanes side by side, as store4() has them: four at once are turned around in registers.
PLUMB_INLINE void store_places(float* out, int first, int count, const vec4<F>& value) {
    if constexpr (N::width >= 4) {
        if (count >= N::width) {
            alignas(64) float lanes[4][N::width];
            const F all[4] = {value.x, value.y, value.z, value.w};
            for (int c = 0; c < 4; ++c) N::save(lanes[c], select(all[c] == all[c], all[c], F(__builtin_nanf(""))));
            for (int k = 0; k < N::width; k += 4) {
                __m128 x = _mm_load_ps(lanes[0] + k), y = _mm_load_ps(lanes[1] + k), z = _mm_load_ps(lanes[2] + k), w = _mm_load_ps(lanes[3] + k);
                _MM_TRANSPOSE4_PS(x, y, z, w);
                float* at = out + 4 * (std::ptrdiff_t(first) + k);
                _mm_storeu_ps(at, x), _mm_storeu_ps(at + 4, y), _mm_storeu_ps(at + 8, z), _mm_storeu_ps(at + 12, w);
            }
            return;
        }
    }
    N::store4(out, N::iota(first), value, N::iota(0) < I(count));
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
            store_places(in.irradiance, first + k * N::width, count - k * N::width,
                         vec4<F>(select3<F>(computed[k], sum[k], zero), select(computed[k], F(1.0f), F(0.0f))));
    }

    template <int n>
    PLUMB_INLINE void add_basis(vec3<F> (&sum)[n]) const {
        const float* b = in.basis + 4 * std::ptrdiff_t(cluster) * in.u.singular_values;
        const float* u = in.transport + first;
        for (int left = in.clusters[4 * std::ptrdiff_t(cluster) + 3]; left > 0; --left, b += 4, u += in.u.count) {
            const F red(b[0]), green(b[1]), blue(b[2]);
            // Of each plane the places that come next: more planes than a processor follows by itself.
            for (int ahead = 0; ahead + 16 <= n * N::width; ahead += 16) __builtin_prefetch(u + n * N::width + ahead);
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

// Texel by texel: a value is copied whole, and lanes that gather would make all others wait. Means of ring 1 are kept for the band
// and a row on either side, for ring 2 to ask.
template <>
void Rows<LightmapKernel, Isa::PLUMB_ISA>::run(const LightmapView& in, int first, int last, const Tiles& tiles, float* scratch) {
    using One = number<float>;
    const int width = in.u.width;
    const auto kept = [&](int x, int y) { return scratch + 3 * (std::ptrdiff_t(y - first + 1) * width + x); };
    for (int y = max(first - 1, 0); y < min(last + 1, in.u.height); ++y)
        for (int x = 0; x < width; ++x) {
            if (in.cover[y * width + x] != -2) continue;
            const vec3<float> mean = mean_of_receivers<float>(in, x, y);
            float* to = kept(x, y);
            to[0] = mean.x, to[1] = mean.y, to[2] = mean.z;
        }
    for (int y = first; y < last; ++y) {
        const std::uint8_t* row = tiles.row(y);
        for (int x = 0; x < width; ++x) {
            if (row && !row[x >> 4]) continue;
            const int at = y * width + x, cover = in.cover[at];
            const bool covered = in_range(cover, in.u.places) || cover == -2 || cover == -3;
            vec3<float> value = irradiance_at<float>(in, cover);
            if (cover == -2) value = {kept(x, y)[0], kept(x, y)[1], kept(x, y)[2]};
            if (cover == -3) {
                NeighbourMean<float> all;
                for (int k = 0; k < 9; ++k) {
                    const int nx = x + k % 3 - 1, ny = y + k / 3 - 1;
                    if (cover_at<float>(in, nx, ny) == -2) all.add(true, {kept(nx, ny)[0], kept(nx, ny)[1], kept(nx, ny)[2]});
                }
                value = all.mean();
            }
            One::store4(in.lightmap, at, vec4<float>(value, covered ? 1.0f : 0.0f), true);
        }
    }
}

}  // namespace plumb
