// The environment in a direction, and directions by its luminance. Tables: environment.h.
//
// Column c of row r is the patch of longitudes 2 pi (c..c + 1) / width - pi and of polar angles pi (r..r + 1) / height
// from +y (core/scene.h, Environment). Its radiance is constant, or its texel's in its middle and interpolated elsewhere.
// The density of samples in it is constant.
#pragma once

#include "gi/reference/warp_kernel.h"

namespace plumb::reference {

struct EnvironmentArgs {
    std::int32_t width, height;  // patches; 0: black
    const float* radiance;
    const float* row_cdf;
    const float* column_cdf;
    const float* pdf;
    bool bilinear = false;
};

template <class F>
struct EnvironmentSample {
    vec3<F> direction;  // unit
    vec3<F> radiance;   // W/(m2 sr)
    F pdf;              // 1/sr
};

// atan2(y, x) / (2 pi) for x, y that are not both 0, between -1/2 and 1/2; a zero's sign does not matter. The smaller
// over the larger, in one division with atan q = pi/4 + atan((q - 1)/(q + 1)); then a minimax polynomial to 4.1e-8.
template <class F>
PLUMB_INLINE F turn_of(F y, F x) {
    const F zero(0.0f), a = abs(x), b = abs(y), larger = max(a, b), smaller = min(a, b);
    const mask_t<F> steep = smaller > larger * 0.414213562f;
    const F t = select(steep, smaller - larger, smaller) / select(steep, smaller + larger, larger);
    const F u = t * t;
    const F bend = 0.159154937f + u * (-0.0530505218f + u * (0.0317845680f + u * (-0.0220012274f + u * 0.0125942983f)));
    const F octant = select(steep, F(0.125f), zero) + t * bend;
    const F quadrant = select(b > a, 0.25f - octant, octant);
    const F half = select(x < zero, 0.5f - quadrant, quadrant);
    return select(y < zero, -half, half);
}

// Where direction d, of any length but 0, points at: patches from the map's left and upper border. x is no number at a
// pole, where all columns meet.
template <class F>
PLUMB_INLINE vec2<F> environment_place(const EnvironmentArgs& in, const vec3<F>& d) {
    using I = index_t<F>;
    const F width = number<F>::from_index(I(in.width)), height = number<F>::from_index(I(in.height));
    const F u = F(0.5f) + turn_of(d.x, -d.z), v = 2.0f * turn_of(sqrt(d.x * d.x + d.z * d.z), d.y);
    return {u * width, v * height};
}

// The patch there. Within 1e-7 turns of a border it may be the neighbour; at a pole it is column 0.
template <class F>
PLUMB_INLINE index_t<F> environment_patch(const EnvironmentArgs& in, const vec3<F>& d) {
    using I = index_t<F>;
    const vec2<F> place = environment_place<F>(in, d);
    const I column = min(number<F>::truncate_to_index(place.x), I(in.width - 1));
    const I row = min(number<F>::truncate_to_index(place.y), I(in.height - 1));
    return max(row, I(0)) * I(in.width) + max(column, I(0));
}

// Between the middles of the four patches around. The last column's right neighbour is the first; above the first row and
// below the last are these again.
template <class F>
PLUMB_INLINE vec3<F> interpolated_radiance(const EnvironmentArgs& in, const vec3<F>& d) {
    using N = number<F>;
    using I = index_t<F>;
    const F zero(0.0f), one(1.0f), width = N::from_index(I(in.width));
    const vec2<F> place = environment_place<F>(in, d);
    const F x = select(place.x >= zero, place.x, zero) + 0.5f, y = max(place.y, zero) + 0.5f;
    const I column = min(N::truncate_to_index(x), I(in.width)), row = min(N::truncate_to_index(y), I(in.height));
    const F right_share = min(x - N::from_index(column), one), lower_share = min(y - N::from_index(row), one);
    const I left = select(x < one, I(in.width - 1), column - I(1)), right = select(x >= width, I(0), column);
    const I top = max(row - I(1), I(0)) * I(in.width), bottom = min(row, I(in.height - 1)) * I(in.width);
    const vec3<F> a = xyz<F>(N::fetch4(in.radiance, top + left)), b = xyz<F>(N::fetch4(in.radiance, top + right));
    const vec3<F> c = xyz<F>(N::fetch4(in.radiance, bottom + left)), e = xyz<F>(N::fetch4(in.radiance, bottom + right));
    const vec3<F> upper = a + (b - a) * right_share, lower = c + (e - c) * right_share;
    return upper + (lower - upper) * lower_share;
}

template <class F>
PLUMB_INLINE vec3<F> environment_radiance(const EnvironmentArgs& in, const vec3<F>& d) {
    if (in.width == 0) return {F(0.0f), F(0.0f), F(0.0f)};
    if (in.bilinear) return interpolated_radiance<F>(in, d);
    return xyz<F>(number<F>::fetch4(in.radiance, environment_patch(in, d)));
}

// The density of sample_environment(), 1/sr.
template <class F>
PLUMB_INLINE F environment_pdf(const EnvironmentArgs& in, const vec3<F>& d) {
    if (in.width == 0) return F(0.0f);
    return number<F>::fetch(in.pdf, environment_patch(in, d));
}

// The interval of a table from 0 to 1 in which u lies, cdf[first + i] <= u < cdf[first + i + 1] for 0 <= i < count, and
// where in it: u and the table count steps of 2^-24, and u stands for the middle of its step.
template <class F>
struct Interval {
    index_t<F> i;
    F rest;  // 0..1
};
template <class F>
PLUMB_INLINE Interval<F> invert_cdf(const float* cdf, index_t<F> first, std::int32_t count, F u) {
    using N = number<F>;
    using I = index_t<F>;
    std::int32_t step = 1;
    while (step < count) step *= 2;
    I i(0);
    for (step /= 2; step > 0; step /= 2) {
        const I middle = min(i + I(step), I(count));
        i = select(N::fetch(cdf, first + middle) <= u, middle, i);
    }
    const F low = N::fetch(cdf, first + i), high = N::fetch(cdf, first + i + I(1));
    return {i, ((u - low) + 0x1p-25f) / (high - low)};
}

// A row by u1, a patch of it by u2, and a direction of the patch, uniform in solid angle, by what is left of both.
template <class F>
PLUMB_INLINE EnvironmentSample<F> sample_environment(const EnvironmentArgs& in, F u1, F u2) {
    using N = number<F>;
    using I = index_t<F>;
    const F zero(0.0f);
    if (in.width == 0) return {{zero, F(1.0f), zero}, {zero, zero, zero}, zero};
    const Interval<F> row = invert_cdf<F>(in.row_cdf, I(0), in.height, u1);
    const Interval<F> column = invert_cdf<F>(in.column_cdf, row.i * I(in.width + 1), in.width, u2);

    // Solid angle goes with sin^2 and with cos^2 of half the polar angle; from both, either pole is exact.
    const F half_turns = 0.25f / N::from_index(I(in.height)), r = N::from_index(row.i);
    const vec2<F> top = on_circle<F>(r * half_turns), bottom = on_circle<F>((r + 1.0f) * half_turns);
    const vec2<F> top2 = top * top, bottom2 = bottom * bottom;
    const vec2<F> p = top2 + (bottom2 - top2) * row.rest;
    const F sine = 2.0f * sqrt(p.x * p.y), cosine = p.x - p.y;

    // u = 1/2 + atan2(x, -z) / (2 pi): the angle from +z, the other way round.
    const vec2<F> q = on_circle<F>((N::from_index(column.i) + column.rest) / N::from_index(I(in.width)));
    const I patch = row.i * I(in.width) + column.i;
    const vec3<F> direction = {-(sine * q.y), cosine, sine * q.x};
    const vec3<F> radiance = in.bilinear ? interpolated_radiance<F>(in, direction) : xyz<F>(N::fetch4(in.radiance, patch));
    return {direction, radiance, N::fetch(in.pdf, patch)};
}

}  // namespace plumb::reference
