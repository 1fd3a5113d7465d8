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

constexpr int most_packets = 4;      // at once: a load for three products and sums each
constexpr int numbers_ahead = 1024;  // of a matrix

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

// How far ahead of a row of a matrix, in numbers, one is fetched that is read: where not all coefficients are used the same row of a
// probe further on, for between them lies what nobody reads.
PLUMB_INLINE std::ptrdiff_t ahead_of_row(int rank, int used, int coefficients) {
    if (used == coefficients || used == 0 || rank == 0) return numbers_ahead;
    const int a_probe = used * rank, probes = (numbers_ahead + a_probe - 1) / a_probe;
    return std::ptrdiff_t(probes) * coefficients * rank;
}

// A probe's rows of a cluster's matrix, [coefficients][rank], its coefficients, and the sums of packets of singular values from
// `first` on.
struct ProbeRows {
    const float* rows;
    int rank, first, used, whole;  // whole: so many rows are followed by as many numbers as packets take
    std::ptrdiff_t ahead;          // ahead_of_row()
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
            // A page further on: what a processor fetches by itself ends with its page.
            for (int k = 0; k + 16 <= n * N::width; k += 16) __builtin_prefetch(m + ahead + k);
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
    const std::ptrdiff_t ahead = ahead_of_row(rank, used, in.u.coefficients);
    for (int p = 0; rank > 0 && p < probes; ++p) {
        const std::ptrdiff_t probe = in.cluster_probes[of[1] + p];
        const int row = p * in.u.coefficients;
        // Rows from which on a packet would end behind the matrix.
        const int beyond = (packets * N::width - rank + rank - 1) / rank;
        const int whole = max(0, min(used, all_rows - beyond - row));
        for (int first = 0; first < packets; first += most_packets)
            with_packets(min(packets - first, most_packets),
                         ProbeRows{in.matrix + of[0] + std::ptrdiff_t(row) * rank, rank, first * N::width, used, whole, ahead,
                                   in.lambda + 4 * probe * in.u.coefficients, sums + first});
    }
    const vec3<F> zero{F(0.0f), F(0.0f), F(0.0f)};
    for (int s = 0; s < in.u.width; s += N::width) {
        const vec3<F> b = s < rank ? select3<F>(N::iota(s) < I(rank), sums[s / N::width], zero) : zero;
        N::store4(in.basis, I(cluster * in.u.width) + N::iota(s), vec4<F>(b, F(0.0f)), N::iota(s) < I(in.u.width));
    }
}

// ---- probes.irradiance ------------------------------------------------------------------------------------------------

PLUMB_INLINE I load_index(const std::int32_t* p) { return N::bits(N::load(reinterpret_cast<const float*>(p))); }

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

constexpr int places_ahead = 256;

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
            // Of each plane the places that come next: more planes than a processor follows by itself, and later than the next
            // packets are, for those memory would be too slow.
            for (int ahead = 0; ahead + 16 <= n * N::width; ahead += 16) __builtin_prefetch(u + places_ahead + ahead);
#pragma GCC unroll 4
            for (int k = 0; k < n; ++k) add<n>(sum, k, N::load(u + k * N::width), red, green, blue);
        }
    }
};

// ---- probes.lightmap --------------------------------------------------------------------------------------------------

// The four numbers of a texel, in one register of every instruction set.
using Texel = float __attribute__((vector_size(16)));
using TexelBits = std::int32_t __attribute__((vector_size(16)));

PLUMB_INLINE Texel load_texel(const float* p) {
    Texel t;
    std::memcpy(&t, p, sizeof t);
    return t;
}
PLUMB_INLINE void store_texel(float* p, Texel t) { std::memcpy(p, &t, sizeof t); }
PLUMB_INLINE Texel covered(Texel t) {
    t[3] = 1;
    return t;
}

// A bit each of 16 covers: whether it is `ring`.
PLUMB_INLINE std::uint32_t bits_of_ring(const std::int32_t* cover, std::int32_t ring) {
    const auto four = [&](int k) {
        return _mm_cmpeq_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(cover + k)), _mm_set1_epi32(ring));
    };
    const __m128i low = _mm_packs_epi32(four(0), four(4)), high = _mm_packs_epi32(four(8), four(12));
    return std::uint32_t(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
}

// Calls each(x) for the columns [first, last) of a row that are `ring`.
template <class Each>
PLUMB_INLINE void each_of_ring(const std::int32_t* cover, int first, int last, std::int32_t ring, Each each) {
    int x = first;
    for (; x + 16 <= last; x += 16)
        for (std::uint32_t bits = bits_of_ring(cover + x, ring); bits != 0; bits &= bits - 1) each(x + __builtin_ctz(bits));
    for (; x < last; ++x)
        if (cover[x] == ring) each(x);
}

// Rows of the lightmap from above to below, as texels that are there have them, w 1, and 0 elsewhere: what no sum sees, for one that
// begins at 0 is never -0. Three rows of receivers and three of ring 1, each with a texel more on either side, so that nothing lies
// beyond an edge. Of the columns [first, last) that are written, with what their rings reach.
class LightmapRows {
  public:
    LightmapRows(const LightmapView& in, float* scratch, int first, int last)
        : in_(in), width_(in.u.width), scratch_(scratch), first_(first), last_(last) {}

    // Rows [top, below).
    void write(int top, int below) const {
        for (int y = top - 2; y < below + 2; ++y) {
            gather_receivers(y);
            if (y >= top) fill_ring_1(y - 1);
            if (y >= top + 2) write_row(y - 2);
        }
    }

  private:
    // Columns, by how many texels more on either side.
    int begin_with(int more) const { return max(first_ - more, 0); }
    int end_with(int more) const { return min(last_ + more, in_.u.width); }

    // No branch: it would be guessed wrong at every edge of a chart. What comes two rows later is fetched from memory, a line of it
    // holds four texels.
    void gather_receivers(int y) const {
        const int first = begin_with(2), last = end_with(2);
        float* out = cleared(receivers(y), first, last);
        if (y < 0 || y >= in_.u.height) return;
        const std::int32_t *cover = in_.cover + y * width_, *later = cover + (y + 2 < in_.u.height ? 2 * width_ : 0), places = in_.u.places;
        const float* irradiance = in_.irradiance;
        for (std::ptrdiff_t x = first; x < last; ++x) {
            if ((x & 3) == 0) __builtin_prefetch(irradiance + 4 * std::ptrdiff_t(later[x] & -std::int32_t(in_range(later[x], places))));
            const std::int32_t is = -std::int32_t(in_range(cover[x], places));
            const Texel t = covered(load_texel(irradiance + 4 * std::ptrdiff_t(cover[x] & is)));
            store_texel(out + 4 * x, (Texel)((TexelBits)t & TexelBits{is, is, is, is}));
        }
    }
    // Receivers of the rows y - 1 to y + 1 are gathered.
    void fill_ring_1(int y) const {
        const int first = begin_with(1), last = end_with(1);
        float* out = cleared(ring_1(y), first, last);
        if (y < 0 || y >= in_.u.height) return;
        each_of_ring(in_.cover + y * width_, first, last, -2, [&](int x) {
            store_texel(out + 4 * std::ptrdiff_t(x), mean_around(x, receivers(y - 1), receivers(y), receivers(y + 1)));
        });
    }
    // Ring 1 of the rows y - 1 to y + 1 is filled.
    void write_row(int y) const {
        const float *r = receivers(y), *one = ring_1(y);
        float* out = in_.lightmap + 4 * y * width_;
        std::ptrdiff_t i = 4 * std::ptrdiff_t(first_);
        for (; i + N::width <= 4 * std::ptrdiff_t(last_); i += N::width) {
            const F value = N::from_bits(N::bits(N::load(r + i)) | N::bits(N::load(one + i)));
            N::save(out + i, select(value == value, value, F(__builtin_nanf(""))));
        }
        for (; i < 4 * std::ptrdiff_t(last_); i += 4) store_canonical(out + i, (Texel)((TexelBits)load_texel(r + i) | (TexelBits)load_texel(one + i)));
        each_of_ring(in_.cover + y * width_, first_, last_, -3, [&](int x) {
            store_canonical(out + 4 * std::ptrdiff_t(x), mean_around(x, ring_1(y - 1), ring_1(y), ring_1(y + 1)));
        });
    }

    float* receivers(int y) const { return scratch_ + 4 * (((y + 3) % 3) * (width_ + 2) + 1); }
    float* ring_1(int y) const { return receivers(y) + 3 * 4 * (width_ + 2); }
    // The columns and one more on either side.
    static float* cleared(float* row, int first, int last) {
        std::memset(row + 4 * std::ptrdiff_t(first - 1), 0, 4 * sizeof(float) * std::size_t(last - first + 2));
        return row;
    }
    // The mean of the texels around one that are there, in the order of rows; w 1.
    static PLUMB_INLINE Texel mean_around(std::ptrdiff_t x, const float* above, const float* own, const float* below) {
        Texel sum{};
        for (const float* row : {above, own, below})
            for (int k = -1; k <= 1; ++k) sum = sum + load_texel(row + 4 * (x + k));
        const float n = max(sum[3], 1.0f);
        return covered(sum / Texel{n, n, n, n});
    }
    static PLUMB_INLINE void store_canonical(float* p, Texel t) {
        constexpr float nan = __builtin_nanf("");
        store_texel(p, t == t ? t : Texel{nan, nan, nan, nan});
    }

    const LightmapView& in_;
    std::ptrdiff_t width_;
    float* scratch_;
    int first_, last_;
};

// Calls each(first, last) for the columns of a row of tiles that are wanted, side by side.
template <class Each>
void each_run(const std::uint8_t* tiles, int width, Each each) {
    if (!tiles) return each(0, width);
    for (int x = 0; x < width;) {
        const int first = x;
        while (x < width && tiles[x >> 4]) x += 16;
        if (x > first) each(first, min(x, width));
        x += 16;
    }
}

// Whether a row of tiles wants the same as another.
bool alike(const std::uint8_t* tiles, const std::uint8_t* other, int width) {
    return std::memcmp(tiles, other, std::size_t((width + 15) >> 4)) == 0;
}

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

template <>
void Rows<LightmapKernel, Isa::PLUMB_ISA>::run(const LightmapView& in, int first, int last, const Tiles& tiles, float* scratch) {
    for (int y = first; y < last;) {
        const std::uint8_t* row = tiles.row(y);
        int below = row ? min((y | 15) + 1, last) : last;
        while (below < last && alike(row, tiles.row(below), in.u.width)) below = min(below + 16, last);
        each_run(row, in.u.width, [&](int x, int beyond) { LightmapRows(in, scratch, x, beyond).write(y, below); });
        y = below;
    }
}

}  // namespace plumb
