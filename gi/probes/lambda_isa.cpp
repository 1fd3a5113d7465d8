#include "core/shade_rows.h"
#include "gi/probes/lambda_kernel.h"

namespace plumb::probes {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// What one probe is summed over.
struct Rays {
    const LambdaView& in;
    const float *radiance, *weights;
    int probe, count;    // rays
    int coefficients;
};

// Columns [column, column + lanes) of a row; lanes behind the row's end hold anything. Read whole where the table does not end
// within them.
template <bool inside>
PLUMB_INLINE F harmonics(const LambdaView& in, int ray, int column) {
    const int at = ray * in.u.width;
    if constexpr (inside) return N::load(in.harmonics + at + column);
    return N::fetch(in.harmonics, I(at) + min(N::iota(column), I(in.u.width - 1)));
}

template <int packets, bool inside>
PLUMB_INLINE void add_rays(const Rays& of, int column, int first, int last, F (&part)[packets][3]) {
    for (int r = first; r < last; ++r) {
        const float w = of.weights[r], *f = of.radiance + 4 * std::ptrdiff_t(r);
        const F x(w * f[0]), y(w * f[1]), z(w * f[2]);
        for (int k = 0; k < packets; ++k) {
            const F value = harmonics<inside>(of.in, r, column + k * N::width);
            part[k][0] = part[k][0] + x * value;
            part[k][1] = part[k][1] + y * value;
            part[k][2] = part[k][2] + z * value;
        }
    }
}

// Coefficients [column, column + packets of lanes) of a probe, all rays.
template <int packets>
void add_columns(const Rays& of, int column) {
    // Rows up to here may be read to the end of the last packet.
    const LambdaUniforms& u = of.in.u;
    const int room = u.rays * u.width - column - packets * N::width, whole = room < 0 ? 0 : room / u.width + 1;
    const F zero(0.0f);
    F sum[packets][3];
    for (int k = 0; k < packets; ++k) sum[k][0] = sum[k][1] = sum[k][2] = zero;
    for (int first = 0; first < of.count; first += rays_a_sum) {
        const int end = min(first + rays_a_sum, of.count), safe = max(first, min(end, whole));
        F part[packets][3];
        for (int k = 0; k < packets; ++k) part[k][0] = part[k][1] = part[k][2] = zero;
        add_rays<packets, true>(of, column, first, safe, part);
        add_rays<packets, false>(of, column, safe, end, part);
        for (int k = 0; k < packets; ++k)
            for (int c = 0; c < 3; ++c) sum[k][c] = sum[k][c] + part[k][c];
    }
    for (int k = 0; k < packets; ++k) {
        const I j = N::iota(column + k * N::width);
        N::store4(of.in.lambda, I(of.probe * u.width) + j, vec4<F>(sum[k][0], sum[k][1], sum[k][2], zero), j < I(of.coefficients));
    }
}

}  // namespace

}  // namespace plumb::probes

namespace plumb {

using namespace probes;

// Lanes are coefficients: a ray's radiance is read once for all of them, and a row of the table as it lies. Four packets and three
// channels are twelve sums that do not wait for each other.
template <>
void Rows<LambdaKernel, Isa::PLUMB_ISA>::run(const LambdaView& in, int first, int last, const Tiles&, float*) {
    const LambdaUniforms& u = in.u;
    for (int p = first; p < last; ++p) {
        const int level = max(0, min(in.probe_level[p], u.levels - 1));
        const int rays = min(of_level<std::int32_t>(level, u.rays_0, u.rays_1, u.rays_2, u.rays_3), u.rays);
        const int coefficients =
            min(of_level<std::int32_t>(level, u.coefficients_0, u.coefficients_1, u.coefficients_2, u.coefficients_3), u.width);
        const Rays of{in, in.radiance + 4 * std::ptrdiff_t(p) * u.rays, in.weights + std::ptrdiff_t(level) * u.rays, p, rays, coefficients};
        for (int j = 0; j < coefficients;) {
            const int packets = min(4, (coefficients - j + N::width - 1) / N::width);
            if (packets == 4) add_columns<4>(of, j);
            if (packets == 3) add_columns<3>(of, j);
            if (packets == 2) add_columns<2>(of, j);
            if (packets == 1) add_columns<1>(of, j);
            j += packets * N::width;
        }
        float* rest = in.lambda + 4 * (std::ptrdiff_t(p) * u.width + coefficients);
        for (int k = 0; k < 4 * (u.width - coefficients); ++k) rest[k] = 0;
    }
}

}  // namespace plumb
