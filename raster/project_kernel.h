// Where a point falls on a light's map, as the shadow test and the gathers read it; project.glsl is the twin.
#pragma once

#include "core/number.h"

namespace plumb::raster {

// A member of the kernels' uniform blocks (std140: four vec4). Filled by projection_args(), light_view.h.
struct Projection {
    float to_texel_x[4];  // rows of world -> texel: x_texel = (to_texel_x . (x, 1)) / (to_texel_w . (x, 1))
    float to_texel_y[4];
    float to_texel_w[4];
    float least_w;        // m, > 0: points behind the light project far outside the map, on their own side
    float low, high;      // the projection is held within [low, high] texels: the map's own range where it is clamped,
                          //   far outside of it otherwise
    std::int32_t size;    // texels a side of the map
};
static_assert(sizeof(Projection) == 64);

// floor(x) as an index: a choice that a device may make otherwise. A number type that follows such choices has a chosen()
// of its own, found by argument.
template <class F>
PLUMB_INLINE index_t<F> chosen(const F& x) {
    return number<F>::truncate_to_index(floor(x));
}

// Where x projects to, texels; not rounded.
template <class F, class Tap>
PLUMB_INLINE vec2<F> projected(const Projection& map, const vec3<F>& x, Tap& tap) {
    auto row = [&](const float* m) { return F(m[0]) * x.x + F(m[1]) * x.y + F(m[2]) * x.z + F(m[3]); };
    const F w = max(F(map.least_w), row(map.to_texel_w));
    const F low(map.low), high(map.high);
    const vec2<F> texel{clamp(row(map.to_texel_x) / w, low, high), clamp(row(map.to_texel_y) / w, low, high)};
    tap("projection", texel, "x projected to the map, texels");
    return texel;
}

// The texel that x projects to: the one rounding that decides which texels are read.
template <class F, class Tap>
PLUMB_INLINE ivec2<index_t<F>> project(const Projection& map, const vec3<F>& x, Tap& tap) {
    const vec2<F> texel = projected(map, x, tap);
    return {chosen(texel.x), chosen(texel.y)};
}

// Which of a point light's six maps sees along v, a vector from the light: +x -x +y -y +z -z, by the largest component.
// Equal components go to the earlier axis, 0 to the positive face, so that every v has one face.
template <class F>
PLUMB_INLINE index_t<F> face_of(const vec3<F>& v) {
    using I = index_t<F>;
    const F x = abs(v.x), y = abs(v.y), z = abs(v.z);
    const mask_t<F> along_x = (x >= y) & (x >= z), along_y = y >= z;
    const F along = select(along_x, v.x, select(along_y, v.y, v.z));
    const I positive = select(along_x, I(0), select(along_y, I(2), I(4)));
    return positive + select(along < F(0.0f), I(1), I(0));
}

}  // namespace plumb::raster
