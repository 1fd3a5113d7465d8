// The disc gather of a shader that reads the map through samplers, or whose samples differ from pixel to pixel of a tile: what
// plumb validate holds such a shader against. No frame runs it and no twin is made of it.
//
//     linear    the four texels about a place, blended by its fractions along x and y
//     address   of a texel beyond the map: the border's colour, the nearest texel of the edge, or the map repeated
//
// A sample is none of the map's where it reads the border; it is summed like any other, and a border without flux adds
// nothing.
#pragma once

#include <type_traits>

#include "core/bounded.h"
#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

// As a buffer of floats that a manifest makes.
struct MapSampler {
    float linear, address;  // 0 or 1; 0 border, 1 edge, 2 wrap
    float border[3];
};
struct Sampling {
    MapSampler position, normal, flux;
    float tile_width, tile_height;  // pixels, [samples][pixels of the tile] offsets and weights; 0: rotations by a hash
};
inline constexpr std::size_t sampling_floats = sizeof(Sampling) / sizeof(float);

// As GatherInputsView, and what is bound to it beside.
struct SampledView {
    GatherUniforms u;
    const float* position;
    const float* normal;
    const float* rsm_position;
    const float* rsm_normal;
    const float* rsm_flux;
    const float* records;  // not read: images are filtered one by one
    const std::int32_t* offsets;
    const float* positions;
    const float* weights;   // [samples], or of a tile [samples][rotations]
    const float* sampling;  // a Sampling
    float* irradiance;
};

inline Sampling sampling_of(const SampledView& in) {
    Sampling s;
    std::memcpy(&s, in.sampling, sizeof s);
    return s;
}

// Samplers have fractions of at least so many bits, and no more is told of how they round (Vulkan 1.3, 16.8; limits:
// subTexelPrecisionBits, of which desktop devices have 8).
inline constexpr double fraction_step = 1.0 / 256;

template <class F>
PLUMB_INLINE F filtered_fraction(const F& fraction) {
    if constexpr (std::is_same_v<F, Bounded>)
        // Not held in 0 to 1: a comparison there would be undecided at every texel's centre.
        return Bounded::within(fraction.value, fraction.shadow, fraction.bound + fraction_step, fraction.ambiguous);
    else
        return fraction;
}

// The texel's place along one axis, or -1 for the border's.
inline std::int32_t addressed(std::int32_t i, std::int32_t size, float address) {
    if (in_range(i, size)) return i;
    if (address == 1.0f) return i < 0 ? 0 : size - 1;
    if (address != 2.0f) return -1;
    const std::int32_t rest = i % size;
    return rest < 0 ? rest + size : rest;
}

template <class F>
PLUMB_INLINE vec3<F> sampled_texel(const float* image, std::int32_t size, const MapSampler& s, std::int32_t x,
                                   std::int32_t y) {
    const std::int32_t column = addressed(x, size, s.address), row = addressed(y, size, s.address);
    if (column < 0 || row < 0) return {F(s.border[0]), F(s.border[1]), F(s.border[2])};
    return xyz<F>(number<F>::fetch4(image, row * size + column));
}

template <class F>
PLUMB_INLINE vec3<F> blended(const vec3<F>& a, const vec3<F>& b, const F& t) {
    return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}

// Of one sample: the texel that holds its place and, where some image is filtered, the one left of and above the place and
// the fractions of the way to the next.
template <class F>
struct SampledPlace {
    ivec2<index_t<F>> nearest, first{};
    vec2<F> fraction{};
};

template <class F>
PLUMB_INLINE vec3<F> sampled(const float* image, std::int32_t size, const MapSampler& s, const SampledPlace<F>& at) {
    if (s.linear != 1.0f) return sampled_texel<F>(image, size, s, at.nearest.x, at.nearest.y);
    auto texel = [&](int dx, int dy) { return sampled_texel<F>(image, size, s, at.first.x + dx, at.first.y + dy); };
    const vec3<F> above = blended(texel(0, 0), texel(1, 0), at.fraction.x);
    const vec3<F> below = blended(texel(0, 1), texel(1, 1), at.fraction.x);
    return blended(above, below, at.fraction.y);
}

template <class F, bool continuous, class Tap>
PLUMB_INLINE SampledPlace<F> sampled_place(const SampledView& in, const Sampling& s,
                                           const TexelsOf<F, continuous>& texels, std::int32_t row, Tap& tap) {
    SampledPlace<F> at{texels.texel(in, row, tap)};
    if constexpr (continuous) {
        if (s.position.linear != 1.0f && s.normal.linear != 1.0f && s.flux.linear != 1.0f) return at;
        using raster::chosen;
        const vec2<F> place{texels.centre.x + entry<F>(in.positions, row + row) - F(0.5f),
                            texels.centre.y + entry<F>(in.positions, row + row + 1) - F(0.5f)};
        at.first = {chosen(place.x), chosen(place.y)};
        at.fraction = {filtered_fraction(place.x - number<F>::from_index(at.first.x)),
                       filtered_fraction(place.y - number<F>::from_index(at.first.y))};
        tap("fraction", at.fraction, "of the way to the next texel");
    }
    return at;
}

// One pixel; F has one lane.
template <class F, bool continuous, class Tap>
PLUMB_INLINE vec3<F> gather_sampled(const SampledView& in, std::int32_t px, std::int32_t py, Tap& tap) {
    using N = number<F>;
    const GatherUniforms& u = in.u;
    const Sampling s = sampling_of(in);
    const std::int32_t pixel = py * u.width + px, size = u.map.size;
    const vec3<F> x = xyz<F>(N::fetch4(in.position, pixel));      tap("x", x, "world, m");
    const vec3<F> n = xyz<F>(N::fetch4(in.normal, pixel));        tap("n", n, "unit normal of x");
    const TexelsOf<F, continuous> texels(u.map, x, tap);
    const std::int32_t wide = std::int32_t(s.tile_width), high = std::int32_t(s.tile_height);
    const std::int32_t rotation = wide > 0 ? py % high * wide + px % wide : rotation_of<std::int32_t>(u, px, py);
    tap("rotation", rotation, "row of the table of offsets");

    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; k < u.samples; ++k) {
        tap.sample(k);
        const std::int32_t row = rotation + k * u.rotations;
        const SampledPlace<F> at = sampled_place<F, continuous>(in, s, texels, row, tap);
        tap("texel", at.nearest, "the texel that holds the sample");
        const vec3<F> x_p = sampled(in.rsm_position, size, s.position, at), n_p = sampled(in.rsm_normal, size, s.normal, at);
        const vec3<F> flux = sampled(in.rsm_flux, size, s.flux, at);
        const F weight(in.weights[wide > 0 ? row : k]);
        tap("x_p", x_p, "world, m");
        tap("n_p", n_p, "normal of x_p, as it was read");
        tap("flux", flux, "Phi_p, W");
        tap("weight", weight, "texels");
        const F g = form(x, n, x_p, n_p, F(u.least_distance2), tap) * weight;
        sum.x += flux.x * g;
        sum.y += flux.y * g;
        sum.z += flux.z * g;
        tap("sum", sum, "sum so far of weight Phi_p form, W/m2");
    }
    tap.sample(-1);
    const vec3<F> irradiance = sum * F(u.scale);
    tap("irradiance", irradiance, "E = sum / pi, W/m2");
    return irradiance;
}

template <bool continuous_texels>
struct SampledDisc {
    using View = SampledView;
    static constexpr bool continuous = continuous_texels;

    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, std::int32_t px, std::int32_t py, Tap& tap) {
        return vec4<F>(gather_sampled<F, continuous>(in, px, py, tap), F(0.0f));
    }
};

}  // namespace plumb::rsm
