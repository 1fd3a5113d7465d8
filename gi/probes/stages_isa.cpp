#include "core/shade_rows.h"
#include "gi/probes/coefficients_kernel.h"
#include "gi/probes/density_kernel.h"
#include "gi/probes/indirect_shadow_kernel.h"
#include "gi/probes/radiance_kernel.h"
#include "gi/probes/level_kernel.h"
#include "gi/probes/lightmap_uv_kernel.h"
#include "gi/probes/lookup_kernel.h"
#include "gi/probes/relief_kernel.h"
#include "gi/probes/share_kernel.h"
#include "gi/probes/supports_kernel.h"
#include "gi/probes/volume_kernel.h"

namespace plumb::probes {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

struct Bounds {
    float low[3], high[3];
};

// Of the candidates [first, last).
Bounds bounds_of(const float* positions, int first, int last) {
    Bounds b;
    for (int c = 0; c < 3; ++c) b.low[c] = b.high[c] = positions[4 * std::ptrdiff_t(first) + c];
    for (int i = first + 1; i < last; ++i)
        for (int c = 0; c < 3; ++c) {
            const float x = positions[4 * std::ptrdiff_t(i) + c];
            b.low[c] = min(b.low[c], x), b.high[c] = max(b.high[c], x);
        }
    return b;
}

// Whether nothing of the block lies within the radius; what rounding may add to a distance is left to the kernel.
bool far_apart(const Bounds& a, const float* block, float radius) {
    float d2 = 0;
    for (int c = 0; c < 3; ++c) {
        const float gap = max(max(block[c] - a.high[c], a.low[c] - block[3 + c]), 0.0f);
        d2 = d2 + gap * gap;
    }
    return d2 > radius * radius * 1.001f;
}

// How many rows from `row` on, before `last`, are all harmonics of one slot up to some degree, in their order.
int whole_degrees(const std::int32_t* rows, int row, int last, int& degree) {
    const std::int32_t* r = rows + 4 * std::ptrdiff_t(row);
    degree = -1;
    for (int l = 0; l < sh::kernel_degrees && row + (l + 1) * (l + 1) <= last; ++l) {
        for (int m = -l; m <= l; ++m) {
            const std::int32_t* at = r + 4 * (l * (l + 1) + m);
            if (at[0] != r[0] || at[1] != l || at[2] != (m < 0 ? -m : m) || at[3] != (m < 0 ? 1 : 0))
                return (degree + 1) * (degree + 1);
        }
        degree = l;
    }
    return (degree + 1) * (degree + 1);
}

// All harmonics of one slot at once: what a ray met is fetched once, and not at all where no lane's probe sees it.
PLUMB_INLINE void coefficients_of_slot(const CoefficientsView& in, int row, int slot, int degree, int x, mask_t<F> active) {
    const int width = in.u.width, count = (degree + 1) * (degree + 1);
    const I receiver = min(N::iota(x), I(width - 1));
    const vec4<F> probe = N::fetch4(in.supporting, I(slot * width) + receiver);
    F sums[sh::kernel_degrees * sh::kernel_degrees], part[sh::kernel_degrees * sh::kernel_degrees];
    for (int j = 0; j < count; ++j) sums[j] = F(0.0f);
    NoTap tap;
    for (int first = 0; first < in.u.rays; first += rays_a_sum) {
        for (int j = 0; j < count; ++j) part[j] = F(0.0f);
        for (int k = first; k < min(first + rays_a_sum, in.u.rays); ++k) {
            const I at = I(k * width) + receiver;
            const mask_t<F> sees = (shift_right(N::fetch(in.visible, at), slot) & I(1)) == I(1);
            if (!any(sees)) continue;
            const F weight = select(sees, N::fetch(in.shares, at) * probe.w, F(0.0f));
            sh::add_harmonics<F>(in.recurrence, degree, direction_to<F>(N::fetch4(in.seen, at), probe, tap), weight, part);
        }
        for (int j = 0; j < count; ++j) sums[j] = sums[j] + part[j];
    }
    for (int j = 0; j < count; ++j) N::store(in.alpha, I((row + j) * width) + receiver, sums[j], active);
}

}  // namespace

}  // namespace plumb::probes

namespace plumb {

using namespace probes;

template <>
void Rows<DensityKernel, Isa::PLUMB_ISA>::run(const DensityView& in, int first, int last, const Tiles&, float*) {
    const int count = in.u.count, blocks = (count + block - 1) / block;
    const float radius = 1 / in.u.inverse_radius;
    for (int i = first * in.u.width; i < min(last * in.u.width, count); i += N::width) {
        const int end = min(min(i + N::width, last * in.u.width), count);
        const I lane = min(N::iota(i), I(count - 1));
        const vec3<F> p = xyz<F>(N::fetch4(in.positions, lane));
        const Bounds around = bounds_of(in.positions, i, end);
        F sum(0.0f);
        for (int b = 0; b < blocks; ++b) {
            if (far_apart(around, in.blocks + 6 * std::ptrdiff_t(b), radius)) continue;
            F part(0.0f);
            for (int j = b * block; j < min((b + 1) * block, count); ++j) part = part + density_term<F>(in, p, lane, j);
            sum = sum + part;
        }
        N::store(in.density, lane, sum, N::iota(i) < I(end));
    }
}

template <>
void Rows<SupportsKernel, Isa::PLUMB_ISA>::run(const SupportsView& in, int first, int last, const Tiles&, float*) {
    const int width = in.u.width;
    for (int r = first; r < last; r += N::width) {
        const I receiver = min(N::iota(r), I(last - 1));
        const Nearest<F> n = nearest_probes<F>(in, xyz<F>(N::fetch4(in.receivers, receiver)));
        for (int k = 0; k < width; ++k)
            SupportsKernel::store<F>(in, receiver * I(width) + I(k), support_of<F>(in, n, k), N::iota(r) < I(last));
    }
}

template struct Rows<ShareKernel, Isa::PLUMB_ISA>;
template struct Rows<RadianceKernel, Isa::PLUMB_ISA>;
template struct Rows<LevelKernel, Isa::PLUMB_ISA>;
template struct Rows<VolumeKernel, Isa::PLUMB_ISA>;
template struct Rows<ReliefKernel, Isa::PLUMB_ISA>;
template struct Rows<IndirectShadowKernel, Isa::PLUMB_ISA>;

template <>
void Rows<CoefficientsKernel, Isa::PLUMB_ISA>::run(const CoefficientsView& in, int first, int last, const Tiles& tiles,
                                                   float*) {
    for (int row = first; row < last;) {
        int degree = -1;
        const int slot = in.rows[4 * std::ptrdiff_t(row)], whole = whole_degrees(in.rows, row, last, degree);
        if (whole > 0 && slot >= 0 && slot < in.u.slots) {
            for (int x = 0; x < in.u.width; x += N::width)
                coefficients_of_slot(in, row, slot, degree, x, N::iota(x) < I(in.u.width));
            row += whole;
            continue;
        }
        shade_packets<F>(in.u.width, row, row + 1, tiles, in.alpha,
                         [&](int, I px, int y, NoTap& tap) { return coefficient<F>(in, px, I(y), tap); });
        ++row;
    }
}

template struct Rows<LightmapUvKernel, Isa::PLUMB_ISA>;
template struct Rows<LookupKernel, Isa::PLUMB_ISA>;

}  // namespace plumb
