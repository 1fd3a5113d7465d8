#include "core/shade_rows.h"
#include "gi/probes/density_kernel.h"
#include "gi/probes/supports_kernel.h"

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
            for (int j = b * block; j < min((b + 1) * block, count); ++j) sum = sum + density_term<F>(in, p, lane, j);
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

}  // namespace plumb
