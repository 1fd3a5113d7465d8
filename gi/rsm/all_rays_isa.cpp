#include "core/tap.h"
#include "core/wide.h"
#include "gi/rsm/all_rays_rows.h"

namespace plumb::rsm {

using F = PLUMB_ISA::Real;
using I = index_t<F>;

// A packet is a tile about as high as it is wide: its rays to one texel stay close together.
template <>
std::uint64_t all_rays_rows<Isa::PLUMB_ISA>(const AllRaysView& in, const RayQuery& query, RayOffsets offsets, int first,
                                            int last) {
    using N = number<F>;
    constexpr int lanes = N::width, across_log2 = lanes >= 8 ? 2 : lanes >= 4 ? 1 : 0, across = 1 << across_log2;
    constexpr int down = lanes / across;
    static_assert(all_rays_band % down == 0);
    const I dx = N::iota(0) & I(across - 1), dy = shift_right(N::iota(0), across_log2);
    ShadowRays<F> rays(query, offsets);
    NoTap tap;
    for (int y = first; y < last; y += down)
        for (int x = 0; x < in.width; x += across) {
            const I px = I(x) + dx, py = I(y) + dy, pixel = py * I(in.width) + px;
            const mask_t<F> inside = in_range(px, I(in.width)) & in_range(py, I(last));
            if (in.strata_log2 < 0) {
                const vec3<F> e = gather_all_rays<F>(in, px, py, rays, tap);
                N::store4(in.irradiance, pixel, vec4<F>(e, F(0.0f)), inside);
            } else {
                const SubsetEstimate<F> e = gather_subset<F>(in, px, py, rays, tap);
                N::store4(in.irradiance, pixel, vec4<F>(e.irradiance, F(0.0f)), inside);
                N::store4(in.standard_error, pixel, vec4<F>(e.standard_error, F(0.0f)), inside);
            }
        }
    return rays.tracer.traced();
}

}  // namespace plumb::rsm
