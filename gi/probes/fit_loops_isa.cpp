#include "core/wide.h"
// After core/wide.h, so that the loop sees its number.
#include "gi/probes/fit_loops.h"

namespace plumb::probes {

using F = PLUMB_ISA::Real;

namespace {

using N = number<F>;

// C(x, y) = ((1 + n_x . n_y) / 2)^4 / (1 + |x - y| / range)^2
PLUMB_INLINE F covariance(const F& x, const F& y, const F& z, const F& nx, const F& ny, const F& nz, const FitPoint& p, F scale) {
    const F dx = x - F(p.x), dy = y - F(p.y), dz = z - F(p.z);
    const F near = F(1.0f) / (F(1.0f) + sqrt(dx * dx + dy * dy + dz * dz) * scale);
    const F alike = F(0.5f) + F(0.5f) * (nx * F(p.nx) + ny * F(p.ny) + nz * F(p.nz));
    const F squared = alike * alike;
    return near * near * (squared * squared);
}

}  // namespace

template <>
void FitLoops<Isa::PLUMB_ISA>::covariances(const FitPoints& points, const FitPoint* others, int count, float scale, float* sums) {
    for (int i = 0; i < points.padded; i += N::width) {
        const F x = N::load(points.x + i), y = N::load(points.y + i), z = N::load(points.z + i);
        const F nx = N::load(points.nx + i), ny = N::load(points.ny + i), nz = N::load(points.nz + i);
        F sum(0.0f);
        for (int k = 0; k < count; ++k) sum = sum + F(others[k].weight) * covariance(x, y, z, nx, ny, nz, others[k], F(scale));
        N::save(sums + i, sum);
    }
}

}  // namespace plumb::probes
