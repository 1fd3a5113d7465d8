// A texture's lookup over Bounded: the hull of what every place that a device may take for (u, v) gives. A bilinear
// filter is continuous, so this is no wider than its slope asks; a nearest one widens by the texels that may be meant.
#pragma once

#include "core/bounded.h"
#include "core/inexact_inputs.h"
#include "raster/texture_kernel.h"

namespace plumb::raster {

// Texel coordinates along one axis, unwrapped: repeat by repeat, texel i of the image is i, i + size, ...
struct TexelSpan {
    static constexpr double most_texels = 8;
    double low = 0, high = 0;
    std::int32_t size = 1, wrap = 0;
    bool all = true;  // too many to be looked at one by one, or none is known

    TexelSpan(const Bounded& u, std::int32_t texels, std::int32_t mode, bool nearest) : size(texels), wrap(mode) {
        // Of u a device makes a fraction, texels of that, and takes off a half: each rounds a number below 2 size.
        const double slack = 2 * size * (bounded_state.add + bounded_state.multiply), half = nearest ? 0 : 0.5;
        auto place = [&](double v) { return (wrap == 2 ? clamp(v, 0.0, 1.0) : v) * size - half; };
        low = place(u.low()) - slack, high = place(u.high()) + slack;
        all = !(high - low < most_texels && abs(low) < 0x1p30 && abs(high) < 0x1p30);
    }
    std::int32_t first() const { return std::int32_t(floor(low)); }
    std::int32_t last() const { return std::int32_t(floor(high)); }
    // The texel of the image.
    std::int32_t texel(std::int32_t i) const {
        if (wrap != 2) {
            const std::int32_t period = wrap == 1 ? 2 * size : size;
            i -= i / period * period;
            if (i < 0) i += period;
        }
        return wrap_index<float>(i, size, wrap);
    }
};

template <>
struct TextureFilter<Bounded> {
    template <class Tap>
    static vec3<Bounded> rgb(const TextureArgs& in, std::int32_t row, const vec2<Bounded>& uv, bool plain, Tap& tap) {
        const vec2<float> own{uv.x.value, uv.y.value};
        const vec3<float> value = TextureFilter<float>::rgb(in, row, own, plain, tap);
        const std::int32_t flags = in.rows[4 * std::ptrdiff_t(row) + 3];
        Bounded c[3];
        for (int k = 0; k < 3; ++k) c[k] = hull(in, row, uv, plain ? 0 : (flags & flag_srgb) << 7, k, value[k]);
        return {c[0], c[1], c[2]};
    }
    static Bounded alpha(const TextureArgs& in, std::int32_t row, const vec2<Bounded>& uv) {
        const vec2<float> own{uv.x.value, uv.y.value};
        return hull(in, row, uv, 0, 3, TextureFilter<float>::alpha(in, row, own));
    }

  private:
    struct Range {
        double low = __builtin_inf(), high = -__builtin_inf();
        void widen(double v) { low = min(v, low), high = max(v, high); }
    };

    static Bounded hull(const TextureArgs& in, std::int32_t row, const vec2<Bounded>& uv, std::int32_t curve,
                        int channel, float value) {
        const std::int32_t* r = in.rows + 4 * std::ptrdiff_t(row);
        const bool nearest = r[3] & flag_nearest;
        const TexelSpan u(uv.x, r[1], (r[3] >> wrap_u_shift) & 3, nearest);
        const TexelSpan v(uv.y, r[2], (r[3] >> wrap_v_shift) & 3, nearest);
        Range range;
        if (u.all || v.all) {
            for (int byte = 0; byte < 256; ++byte) range.widen(in.decode[curve + byte]);
        } else {
            auto texel = [&](std::int32_t i, std::int32_t j) -> double {
                const std::int32_t t = in.texels[r[0] + v.texel(j) * r[1] + u.texel(i)];
                return in.decode[curve + (shift_right(t, 8 * channel) & 255)];
            };
            for (std::int32_t j = v.first(); j <= v.last(); ++j)
                for (std::int32_t i = u.first(); i <= u.last(); ++i)
                    nearest ? range.widen(texel(i, j)) : widen_cell(range, u, v, i, j, texel);
        }
        // Each of three blends a + t (b - a), or a (1 - t) + t b, rounds four numbers of at most twice the largest.
        const double largest = max(abs(range.low), abs(range.high));
        const double rounding = nearest ? 0 : 12 * largest * (bounded_state.add + bounded_state.multiply);
        return Bounded::within(value, (range.low + range.high) / 2, (range.high - range.low) / 2 + rounding);
    }

    // Between four texel centres the filter is linear along either axis: its extremes over a box lie at the corners.
    template <class Texel>
    static void widen_cell(Range& range, const TexelSpan& u, const TexelSpan& v, std::int32_t i, std::int32_t j,
                           const Texel& texel) {
        const double a = texel(i, j), b = texel(i + 1, j), c = texel(i, j + 1), d = texel(i + 1, j + 1);
        for (double x : {max(u.low - i, 0.0), min(u.high - i, 1.0)})
            for (double y : {max(v.low - j, 0.0), min(v.high - j, 1.0)}) {
                const double upper = a + x * (b - a), lower = c + x * (d - c);
                range.widen(upper + y * (lower - upper));
            }
    }
};

}  // namespace plumb::raster
