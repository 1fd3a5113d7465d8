#include "tests/gi/shade_probe.h"

#include "core/wide.h"

namespace plumb::reference {

template <>
void probe_shading<Isa::PLUMB_ISA>(const ShadeProbe& in) {
    using F = PLUMB_ISA::Real;
    using N = number<F>;
    using I = index_t<F>;
    for (int i = 0; i < in.count; i += N::width) {
        const I at = N::iota(i);
        auto read = [&](int column) { return N::fetch(in.in, at * I(shade_inputs) + I(column)); };
        auto read3 = [&](int column) -> vec3<F> { return {read(column), read(column + 1), read(column + 2)}; };
        int written = 0;
        auto write = [&](F x) { N::store(in.out, at * I(shade_outputs) + I(written++), x, at < I(in.count)); };
        auto write3 = [&](const vec3<F>& v) { write(v.x), write(v.y), write(v.z); };
        const F u_lobe = read(0), u1 = read(1), u2 = read(2), exponent = read(3);
        const vec3<F> n = read3(4), w_o = read3(7), w_i = read3(10);
        const Bsdf<F> bsdf{read3(13), read3(16), exponent, read3(19)};

        write3(cosine_hemisphere(u1, u2));
        write3(cosine_power(u1, u2, exponent));
        write(pdf_cosine_power(u1, exponent));
        const vec2<F> l = uniform_triangle(u1, u2);
        write(l.x), write(l.y);
        const Basis<F> basis = basis_of(n);
        write3(basis.tangent), write3(basis.bitangent), write3(to_world(basis, w_i));

        write3(evaluate(bsdf, n, w_o, w_i)), write(pdf(bsdf, n, w_o, w_i));
        const BsdfSample<F> s = sample(bsdf, n, w_o, u_lobe, u1, u2);
        write3(s.direction), write3(s.weight), write(s.pdf), write(select(s.mirror, F(1.0f), F(0.0f)));
        const BsdfSample<F> d = sample_diffuse(bsdf.diffuse, n, u1, u2);
        write3(d.direction), write3(d.weight), write(d.pdf);

        const EnvironmentSample<F> e = sample_environment(in.environment, u1, u2);
        write3(e.direction), write3(e.radiance), write(e.pdf);
        write3(environment_radiance(in.environment, w_i)), write(environment_pdf(in.environment, w_i));
    }
}

}  // namespace plumb::reference
