#include "core/shade_rows.h"
// After core/wide.h, so that the kernel sees its number.
#include "gi/radiosity/items_draw.h"
#include "gi/radiosity/row_kernel.h"

namespace plumb::radiosity {
namespace {

// Triangles in their order, in memory for 10 padded numbers.
DrawList list_of(const ItemsView& in, float* memory) {
    const std::size_t padded = DrawList::padded(std::size_t(in.u.triangles));
    std::int32_t *to = reinterpret_cast<std::int32_t*>(memory), *corner[3] = {to, to + padded, to + 2 * padded}, *numbers = to + 3 * padded;
    float* plane = memory + 4 * padded;
    int n = 0;
    for (int i = 0; i < in.u.triangles; ++i) {
        const std::int32_t* of = in.triangles + 4 * std::ptrdiff_t(i);
        if (!has_corners(of, in.u.vertices)) continue;
        vec3<float> v[3];
        for (int k = 0; k < 3; ++k) corner[k][n] = of[k], v[k] = xyz<float>(number<float>::fetch4(in.vertices, of[k]));
        const vec3<float> normal = normal_of<float>(v[0], v[1], v[2]);
        for (int k = 0; k < 3; ++k) plane[std::size_t(k) * padded + std::size_t(n)] = normal[k], plane[std::size_t(k + 3) * padded + std::size_t(n)] = v[0][k];
        numbers[n++] = i;
    }
    for (; n % DrawList::pad != 0; ++n) {
        corner[0][n] = corner[1][n] = corner[2][n] = numbers[n] = 0;
        for (std::size_t k = 0; k < 6; ++k) plane[k * padded + std::size_t(n)] = 0;
    }
    return {{corner[0], corner[1], corner[2]}, numbers, {plane, plane + padded, plane + 2 * padded, plane + 3 * padded, plane + 4 * padded, plane + 5 * padded}, n};
}

// Sixteen sums, whatever the processor has: lane k has numbers k, k + 16, ...
struct DoubleSums {
#if defined(__AVX512F__)
    __m512d low = _mm512_setzero_pd(), high = _mm512_setzero_pd();
    PLUMB_INLINE void add(int, F x) {
        low = _mm512_add_pd(low, _mm512_cvtps_pd(_mm512_castps512_ps256(x.v)));
        high = _mm512_add_pd(high, _mm512_cvtps_pd(_mm512_extractf32x8_ps(x.v, 1)));
    }
    PLUMB_INLINE void lanes(double* to) const { _mm512_storeu_pd(to, low), _mm512_storeu_pd(to + 8, high); }
#else
    double lane[row_packet] = {};
    PLUMB_INLINE void add(int first, F x) {
        alignas(64) float from[N::width];
        N::save(from, x);
        for (int k = 0; k < N::width; ++k) lane[first + k] += double(from[k]);
    }
    PLUMB_INLINE void lanes(double* to) const { std::memcpy(to, lane, sizeof lane); }
#endif
    double total() const {
        double sum[row_packet];
        lanes(sum);
        for (int half = row_packet / 2; half > 0; half /= 2)
            for (int k = 0; k < half; ++k) sum[k] += sum[k + half];
        return sum[0];
    }
};

// The lower half of each lane's bits.
PLUMB_INLINE void save_lower(std::uint16_t* to, const I& bits) {
#if defined(__AVX512F__)
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_cvtepi32_epi16((__m512i)bits.v));
#else
    alignas(64) Lanes from;
    std::memcpy(from, &bits, sizeof from);
    for (int k = 0; k < N::width; ++k) to[k] = std::uint16_t(from[k]);
#endif
}

}  // namespace

// Texels in their order: so each sum has one, too.
template <>
RowShares RowMaker<Isa::PLUMB_ISA>::run(const RowArgs& in, int i, float* share, float* memory) {
    const int size = in.u.width, rows = rows_of_hemicube(size);
    Drawing drawing(in.u, in.list, memory);
    drawing.draw(in.vertices, in.eyes + 16 * std::ptrdiff_t(i), 0, rows);
    const DrawMemory& seen = drawing.memory();
    RowShares shares{0, 0};
    alignas(64) float of0[N::width], of1[N::width], of2[N::width];
    for (int row = 0; row < rows; ++row)
        for (int x = 0; x < size; x += N::width) {
            const int at = row * size + x;
            const F weight = N::load(in.weights + at), b1 = N::load(seen.b1 + at), b2 = N::load(seen.b2 + at);
            N::save(of0, weight * (F(1.0f) - b1 - b2)), N::save(of1, weight * b1), N::save(of2, weight * b2);
            for (int k = 0; k < N::width && x + k < size; ++k) {
                const std::int32_t what = seen.seen[at + k];
                if (what >= 0 && what % 2 == 0) {
                    const std::int32_t* of = in.of + 2 * std::ptrdiff_t(what);
                    share[of[0]] += of0[k], share[of[1]] += of1[k], share[of[2]] += of2[k];
                } else {
                    (what < 0 ? shares.escaped : shares.back) += double(in.weights[at + k]);
                }
            }
        }
    return shares;
}

template <>
RowSums RowMaker<Isa::PLUMB_ISA>::halve(const float* share, int n, const RowHalves& out) {
    const int padded = (n + row_packet - 1) / row_packet * row_packet;
    F largest(0.0f);
    DoubleSums all, kept;
    for (int j = 0; j < padded; j += row_packet)
        for (int k = 0; k < row_packet; k += N::width) {
            const F s = N::load(share + j + k);
            largest = max(largest, s), all.add(k, s);
        }
    alignas(64) float lane[N::width];
    N::save(lane, largest);
    float most = 0;
    for (const float x : lane) most = max(most, x);
    const F up(most > 0 ? 0x1p15f / most : 0.0f), least(0x1p-14f);
    for (int j = 0; j < padded; j += row_packet) {
        unsigned bits = 0;
        for (int k = 0; k < row_packet; k += N::width) {
            const F value = N::load(share + j + k) * up;
            const Mask keeps = least <= value;
            // Half a unit more, less one where the last bit that stays is even: ties go there.
            const I raw = N::bits(value), rounded = select(keeps, (raw + I(0xfff) + (shift_right(raw, 13) & I(1))) & I(-0x2000), I(0));
            kept.add(k, N::from_bits(rounded));
            save_lower(out.half + j + k, select(keeps, shift_right(rounded - I(112 << 23), 13), I(0)));
            bits |= bits_of(keeps) << k;
        }
        out.kept[j / row_packet] = std::uint16_t(bits);
    }
    return {all.total(), kept.total()};
}

}  // namespace plumb::radiosity

namespace plumb {

using namespace radiosity;

template <>
void Rows<ItemsKernel, Isa::PLUMB_ISA>::run(const ItemsView& in, int first, int last, const Tiles&, float* scratch) {
    const int rows = rows_of_hemicube(in.u.width);
    const DrawList list = list_of(in, scratch + DrawMemory::floats(in.u.vertices, in.u.width));
    Drawing drawing(in.u, list, scratch);
    for (int row = first; row < last;) {
        const int cube = row / rows, end = min(last, (cube + 1) * rows);
        drawing.draw(in.vertices, in.eyes + 16 * std::ptrdiff_t(cube), row - cube * rows, end - cube * rows);
        for (; row < end; ++row)
            for (int x = 0; x < in.u.width; x += N::width)
                ItemsKernel::store<F>(in, I(row * in.u.width) + N::iota(x), drawing.resolve(row - cube * rows, x), N::iota(x) < I(in.u.width));
    }
}

}  // namespace plumb
