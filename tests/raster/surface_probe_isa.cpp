#include "tests/raster/surface_probe.h"

#include "core/wide.h"

namespace plumb::raster {

template <>
void probe_surfaces<Isa::PLUMB_ISA>(const SurfaceProbe& in) {
    using F = PLUMB_ISA::Real;
    using N = number<F>;
    using I = index_t<F>;
    NoTap tap;
    for (int i = 0; i < in.count; i += N::width) {
        const I at = N::iota(i), triangle = N::fetch(in.triangle, at), out = at * I(4);
        const vec2<F> l{N::fetch(in.barycentrics, at * I(2)), N::fetch(in.barycentrics, at * I(2) + I(1))};
        const Surface<F> s = surface<F>(in.surfaces, triangle, l, tap);
        const F drawn = select(passes_alpha<F>(in.surfaces, triangle, l), F(1.0f), F(0.0f));
        const mask_t<F> all = at < I(in.count);
        N::store4(in.out, out, vec4<F>(s.position, F(0.0f)), all);
        N::store4(in.out, out + I(1), vec4<F>(s.normal, F(0.0f)), all);
        N::store4(in.out, out + I(2), vec4<F>(s.albedo, F(0.0f)), all);
        N::store4(in.out, out + I(3), vec4<F>(s.emission, drawn), all);
    }
}

}  // namespace plumb::raster
