// The disc gather of a shader that reads the map through samplers, or whose samples differ from pixel to pixel of a tile: what
// plumb validate holds such a shader against. No frame runs it and no twin is made of it.
//
//     linear    the four texels about a place, blended by its fractions along x and y
//     address   of a texel beyond the map: the border's colour, the nearest texel of the edge, or the map repeated
//     then      the normal made unit, and the position moved along it
//
// A sample is none of the map's where it reads the border; it is summed like any other, and a border without flux adds
// nothing. Or it is skipped.
#pragma once

#include <type_traits>

#include "core/bounded.h"
#include "gi/rsm/gather_kernel.h"

namespace plumb::rsm {

// As a buffer of floats that a manifest makes.
struct MapSampler {
    float linear, address;  // 0 or 1; 0 border, 1 edge, 2 wrap
    float border[3];
    float fraction_step;  // by how much the fraction of the way between two texels may be off
    float step;  // by how much a blend of two texels may be off, since the sampler keeps so few bits of it; 0: in float
};
struct Sampling {
    MapSampler position, normal, flux;
    float tile_width, tile_height;  // pixels, [samples][pixels of the tile] offsets and weights; 0: rotations by a hash
    float along_normal;             // m, by which x_p is moved along n_p once both are read
    float unit_normal;              // 1: n_p is made unit once it is read; a normal of 0 stays
    float skips_beyond;             // 1: a sample beyond the map adds nothing
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

// Widens what a device may have by `more`.
template <class F>
PLUMB_INLINE void widen(vec3<F>& v, const vec3<double>& more) {
    if constexpr (std::is_same_v<F, Bounded>) {
        auto wider = [](Bounded& b, double by) { b = Bounded::within(b.value, b.shadow, b.bound + by, b.ambiguous); };
        wider(v.x, more.x), wider(v.y, more.y), wider(v.z, more.z);
    }
}

// Which texel holds a place, where that is a choice; and where it decides nothing.
template <class F>
PLUMB_INLINE index_t<F> raster_chosen(const F& place) {
    using raster::chosen;
    return chosen(place);
}
template <class F>
PLUMB_INLINE index_t<F> own_floor(const F& place) {
    if constexpr (std::is_same_v<F, Bounded>)
        return number<float>::truncate_to_index(floor(place.value));
    else
        return raster_chosen(place);
}

// A place between two texels along one axis: the first of them, and the fraction of the way to the next. A device may be on
// the other side of either, and blend two others: `beside` says that it is no choice, since both blends meet in the texel.
template <class F>
struct SampledAxis {
    index_t<F> first{};
    F fraction{};
    bool beside = false;
    bool anywhere = false;  // half a texel away and more: all that is known is which texels it may blend

    SampledAxis() = default;
    PLUMB_INLINE explicit SampledAxis(const F& place) : first(own_floor(place)) {
        if constexpr (std::is_same_v<F, Bounded>) beside = place.bound < 0.5, anywhere = !beside;
        fraction = place - number<F>::from_index(first);
    }
    // How far a device may be before the first texel, or after the next: there, too, the fraction is rounded.
    double before(double step) const {
        if constexpr (std::is_same_v<F, Bounded>)
            if (beside && fraction.shadow < fraction.bound) return fraction.bound - fraction.shadow + step;
        return 0;
    }
    double after(double step) const {
        if constexpr (std::is_same_v<F, Bounded>)
            if (beside && fraction.shadow + fraction.bound > 1) return fraction.shadow + fraction.bound - 1 + step;
        return 0;
    }
    // Not held in 0 to 1: a comparison there would be undecided at every texel's centre.
    F rounded(double step) const {
        if constexpr (std::is_same_v<F, Bounded>)
            return Bounded::within(fraction.value, fraction.shadow, fraction.bound + step, fraction.ambiguous);
        else
            return fraction;
    }
};

template <class F>
PLUMB_INLINE vec3<F> difference(const vec3<F>& a, const vec3<F>& b) {
    return {b.x - a.x, b.y - a.y, b.z - a.z};
}

// at(0) and at(1) blended; at(-1) and at(2) are asked for where a device may have them. On their side a blend is off from the
// line through the two by the change of slope.
template <class F, class At>
PLUMB_INLINE vec3<F> blended(const SampledAxis<F>& axis, const MapSampler& s, const At& at) {
    const vec3<F> a = at(0), b = at(1), slope = difference(a, b);
    const F t = axis.rounded(s.fraction_step);
    vec3<F> v{a.x + slope.x * t, a.y + slope.y * t, a.z + slope.z * t};
    if constexpr (std::is_same_v<F, Bounded>) {
        auto bend = [&](const vec3<F>& other, double way) {
            const vec3<F> change = difference(other, slope);
            widen(v, {change.x.size() * way, change.y.size() * way, change.z.size() * way});
        };
        if (const double way = axis.before(s.fraction_step); way > 0) bend(difference(at(-1), a), way);
        if (const double way = axis.after(s.fraction_step); way > 0) bend(difference(b, at(2)), way);
    }
    widen(v, vec3<double>{s.step, s.step, s.step});
    return v;
}

// Of one sample: its place, the texel that holds it and, where some image is filtered, where it lies between texels.
template <class F>
struct SampledPlace {
    ivec2<index_t<F>> nearest;
    vec2<F> place{};
    SampledAxis<F> x, y;
};

// Widens what is read to all that a device may read instead: any texel within `margin` of the place, and so any blend of them.
template <class F>
PLUMB_INLINE void cover_others(vec3<F>& v, const float* image, std::int32_t size, const MapSampler& s, const SampledPlace<F>& at,
                               double margin) {
    if constexpr (std::is_same_v<F, Bounded>) {
        constexpr double most = 8;  // texels a side; beyond, nothing is known
        // Texels beyond the map are all alike, but where it is repeated.
        auto held = [&](double i) { return s.address == 2.0f ? i : min(max(i, -1.0), double(size)); };
        const double left = held(floor(at.place.x.low() - margin)), right = held(floor(at.place.x.high() + margin));
        const double top = held(floor(at.place.y.low() - margin)), bottom = held(floor(at.place.y.high() + margin));
        if (!(right - left < most && bottom - top < most))
            return widen(v, vec3<double>{__builtin_inf(), __builtin_inf(), __builtin_inf()});
        auto cover = [](Bounded& b, const Bounded& other) {
            const double reach = __builtin_fabs(other.shadow - b.shadow) + other.bound;
            if (reach > b.bound) b = Bounded::within(b.value, b.shadow, reach, b.ambiguous);
        };
        for (double y = top; y <= bottom; ++y)
            for (double x = left; x <= right; ++x) {
                const vec3<Bounded> other = sampled_texel<Bounded>(image, size, s, std::int32_t(x), std::int32_t(y));
                cover(v.x, other.x), cover(v.y, other.y), cover(v.z, other.z);
            }
    }
}

// Whether which texel holds the place is undecided, and its options are not followed one by one.
template <class F>
PLUMB_INLINE bool not_followed(const SampledPlace<F>& at) {
    if constexpr (std::is_same_v<F, Bounded>) {
        constexpr double most_options = 8;  // as chosen() has it
        const auto wide = [](const Bounded& b) { return !(floor(b.high()) - floor(b.low()) < most_options); };
        return bounded_state.decisions && (bounded_state.decisions->widen || wide(at.place.x) || wide(at.place.y));
    }
    return false;
}

template <class F>
PLUMB_INLINE vec3<F> sampled(const float* image, std::int32_t size, const MapSampler& s, const SampledPlace<F>& at) {
    if (s.linear != 1.0f) {
        vec3<F> texel = sampled_texel<F>(image, size, s, at.nearest.x, at.nearest.y);
        if (not_followed(at)) cover_others(texel, image, size, s, at, 0);
        return texel;
    }
    if (at.x.anywhere || at.y.anywhere) {
        vec3<F> texel = sampled_texel<F>(image, size, s, at.nearest.x, at.nearest.y);
        cover_others(texel, image, size, s, at, 0.5);
        widen(texel, vec3<double>{2 * s.step, 2 * s.step, 2 * s.step});
        return texel;
    }
    return blended(at.y, s, [&](int dy) {
        return blended(at.x, s, [&](int dx) {
            return sampled_texel<F>(image, size, s, at.x.first + dx, at.y.first + dy);
        });
    });
}

// Who reads through samplers projects to clip space, by rows c = 2 m / size - w in place of the texels' rows m, each number
// rounded: how far that may be from our projection, texels. Of a point near the light's plane it is much.
PLUMB_INLINE double by_clip_space(const raster::Projection& map, const vec3<Bounded>& x, const float* row, const Bounded& centre) {
    const double at[4] = {x.x.size(), x.y.size(), x.z.size(), 1};
    double terms = 0, terms_w = 0, w = 0;
    const double exact[4] = {x.x.shadow, x.y.shadow, x.z.shadow, 1};
    for (int i = 0; i < 4; ++i) {
        terms += __builtin_fabs(double(row[i])) * at[i], terms_w += __builtin_fabs(double(map.to_texel_w[i])) * at[i];
        w += double(map.to_texel_w[i]) * exact[i];
    }
    const double rounding = 0.5 * ulp_ratio + bounded_state.multiply + 3 * bounded_state.add;
    w = __builtin_fabs(w) - rounding * terms_w;
    return w > 0 ? rounding * (terms + (map.size + centre.size()) * terms_w) / w : __builtin_inf();
}

// Where a sample lies along one axis, texels. A sampler takes shares of the map: half a map is added, the offset multiplied and
// added, and the sampler multiplies by the map's side, each with a rounding of its own.
template <class F>
PLUMB_INLINE F along(const raster::Projection& map, const vec3<F>& x, const float* row, const F& centre, const F& offset) {
    F place = centre + offset;
    if constexpr (std::is_same_v<F, Bounded>) {
        const double rounding = bounded_state.add * (centre.size() + offset.size() + map.size);
        // What is held at the projection's limits is there whatever the roundings.
        const bool held = centre.exact();
        place = Bounded::within(place.value, place.shadow, place.bound + 4 * rounding + (held ? 0 : by_clip_space(map, x, row, centre)),
                                place.ambiguous);
    }
    return place;
}

template <class F, bool continuous, class Tap>
PLUMB_INLINE SampledPlace<F> sampled_place(const SampledView& in, const Sampling& s, const vec3<F>& x,
                                           const TexelsOf<F, continuous>& texels, std::int32_t row, Tap& tap) {
    if constexpr (!continuous) {
        const ivec2<index_t<F>> texel = texels.texel(in, row, tap);
        return {texel, {number<F>::from_index(texel.x), number<F>::from_index(texel.y)}};
    } else {
        const bool linear[] = {s.position.linear == 1.0f, s.normal.linear == 1.0f, s.flux.linear == 1.0f};
        SampledPlace<F> at;
        at.place = {along(in.u.map, x, in.u.map.to_texel_x, texels.centre.x, entry<F>(in.positions, row + row)),
                    along(in.u.map, x, in.u.map.to_texel_y, texels.centre.y, entry<F>(in.positions, row + row + 1))};
        tap("place", at.place, "the sample's position on the map, texels");
        if (linear[0] && linear[1] && linear[2])
            at.nearest = {own_floor(at.place.x), own_floor(at.place.y)};
        else
            at.nearest = {raster_chosen(at.place.x), raster_chosen(at.place.y)};
        if (!(linear[0] || linear[1] || linear[2])) return at;
        at.x = SampledAxis<F>(at.place.x - F(0.5f)), at.y = SampledAxis<F>(at.place.y - F(0.5f));
        tap("fraction", vec2<F>{at.x.fraction, at.y.fraction}, "of the way to the next texel");
        return at;
    }
}

// Whether a sample lies on the map, its edges with it.
template <class F, bool continuous>
PLUMB_INLINE mask_t<F> on_map(std::int32_t map_size, const SampledPlace<F>& at) {
    if constexpr (!continuous) {
        return in_range(at.nearest.x, map_size) & in_range(at.nearest.y, map_size);
    } else {
        const F none(0.0f), size = F(float(map_size));
        return (at.place.x >= none) & (at.place.x <= size) & (at.place.y >= none) & (at.place.y <= size);
    }
}

// To unit length; a vector of 0 stays.
template <class F>
PLUMB_INLINE vec3<F> made_unit(const vec3<F>& v) {
    const F square = v.x * v.x + v.y * v.y + v.z * v.z;
    if constexpr (std::is_same_v<F, Bounded>) {
        if (square.zero()) return v;
        const F length = sqrt(square);
        // However short it is, no component of what it becomes is longer than 1, but for roundings.
        auto held = [](const Bounded& c, bool none) {
            constexpr double longest = 1 + 0x1p-18;
            const double shadow = none ? 0 : c.shadow;
            const double low = max(c.low(), -longest), high = min(c.high(), longest);
            return Bounded::within(none ? 0.0f : c.value, shadow, max(high - shadow, shadow - low), c.ambiguous);
        };
        const bool none = square.value == 0 || square.shadow == 0;
        return {held(v.x / length, none), held(v.y / length, none), held(v.z / length, none)};
    } else {
        if (!(square > F(0.0f))) return v;
        const F length = sqrt(square);
        return {v.x / length, v.y / length, v.z / length};
    }
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
    const std::int32_t rotation = wide > 0 ? py % high * wide + px % wide : rotation_of(u, px, py);
    tap("rotation", rotation, "row of the table of offsets");

    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; k < u.samples; ++k) {
        tap.sample(k);
        const std::int32_t row = rotation + k * u.rotations;
        const SampledPlace<F> at = sampled_place<F, continuous>(in, s, x, texels, row, tap);
        tap("texel", at.nearest, "the texel that holds the sample");
        vec3<F> x_p = sampled(in.rsm_position, size, s.position, at), n_p = sampled(in.rsm_normal, size, s.normal, at);
        if (s.unit_normal == 1.0f) n_p = made_unit(n_p);
        if (s.along_normal != 0.0f) x_p = x_p + n_p * F(s.along_normal);
        const vec3<F> flux = sampled(in.rsm_flux, size, s.flux, at);
        const F weight(in.weights[wide > 0 ? row : k]);
        tap("x_p", x_p, "world, m");
        tap("n_p", n_p, "normal of x_p, as it is used");
        tap("flux", flux, "Phi_p, W");
        tap("weight", weight, "texels");
        F share(1.0f);
        if (u.sample_area > 0.0f) share = share_of_disc(u, x, x_p, n_p, weight, tap);
        F g = form(x, n, x_p, n_p, F(u.least_distance2), tap) * (weight * share);
        if (s.skips_beyond == 1.0f) g = select(on_map<F, continuous>(size, at), g, F(0.0f));
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
