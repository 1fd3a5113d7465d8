// What an additional camera sees and another view does not (ISR chapter 6): the algorithm that unseen.comp mirrors line by
// line. Light that a view's own surfaces send must not be counted again.
//
// A surface X of the camera projects to a pixel of the view. It is seen there if the view's surface at that pixel is as
// far away as X, or farther, up to a tolerance; then X is left out: its texel becomes 0.
#pragma once

#include "gi/isr/surface_kernel.h"
#include "raster/project_kernel.h"

namespace plumb::isr {

// Where points lie in the coarse image of a view, from positions relative to another eye.
struct ViewProjection {
    glm::vec4 eye;       // xyz: the first eye as seen from the view's, m
    glm::vec4 to_x;      // x_pixel = (to_x . X) / (forward . X), X from the view's eye
    glm::vec4 to_y;
    glm::vec4 forward;   // xyz unit
    std::int32_t width, height;  // coarse pixels of the view's image
    std::int32_t margin;         // of that image, left of and above pixel (0, 0)
    float least_depth;           // m, above 0: what is nearer, or behind the eye, is not seen
};
static_assert(sizeof(ViewProjection) == 80);

// The twin's uniform block (std140).
struct UnseenUniforms {
    SampleUniforms u;     // of the camera: its own rays and size; what belongs to gathering is not read
    ViewProjection view;
    float reach;          // seen is what is no farther than the view's own depth times this, a little more than 1
    std::int32_t padding[3];
};
static_assert(sizeof(UnseenUniforms) == 240);

struct UnseenInputsView {
    UnseenUniforms u;
    const float* surface;       // [height][width] rgba32f of the camera: xyz unit normal, w depth; all 0: none
    const float* view_surface;  // [view.height][view.width] rgba32f of the view
    float* unseen;              // out: [height][width] rgba32f
};

template <class F>
struct Projected {
    vec2<F> position;  // pixels of the view's image; not rounded
    F depth;           // m
    mask_t<F> before;  // whether it lies in front of the view's eye
};

// from_eye: m, from the first eye.
template <class F>
PLUMB_INLINE Projected<F> project_to(const ViewProjection& v, const vec3<F>& from_eye) {
    const vec3<F> x{from_eye.x + F(v.eye.x), from_eye.y + F(v.eye.y), from_eye.z + F(v.eye.z)};
    auto row = [&](const glm::vec4& m) { return F(m.x) * x.x + F(m.y) * x.y + F(m.z) * x.z; };
    const F depth = row(v.forward), divisor = max(depth, F(v.least_depth));
    // Far outside is far enough: an index must not overflow.
    const F low(-65536.0f), high(65536.0f);
    const vec2<F> position{clamp(row(v.to_x) / divisor, low, high), clamp(row(v.to_y) / divisor, low, high)};
    return {position, depth, depth >= F(v.least_depth)};
}

template <class F, class Tap>
PLUMB_INLINE vec4<F> unseen(const UnseenInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const SampleUniforms& u = in.u.u;
    const ViewProjection& v = in.u.view;
    const vec4<F> texel = N::fetch4(in.surface, py * I(u.width) + px);
    const Surface<F> s = surface_of<F>(u, px, py, texel);
    tap("x", s.position, "X, from the camera's eye, m");
    const Projected<F> p = project_to(v, s.position);
    tap("projection", p.position, "X in the view's image, coarse pixels");
    tap("depth", p.depth, "of X from the view's eye, m");
    const ivec2<I> pixel{raster::chosen(p.position.x), raster::chosen(p.position.y)};
    tap("pixel", pixel, "of the view's image");
    const mask_t<F> inside = in_range(pixel.x, I(v.width)) & in_range(pixel.y, I(v.height)) & p.before;
    tap("inside", inside, "1 if the view has that pixel, and X lies before its eye");
    const vec4<F> other = N::fetch4(in.view_surface, select(inside, pixel.y * I(v.width) + pixel.x, I(0)));
    // The view's image in its own pixels: the margin belongs to it.
    const Surface<F> there = surface_of<F>(u, pixel.x - I(v.margin), pixel.y - I(v.margin), other);
    tap("view_depth", there.depth, "of what the view sees there, m; 0: nothing");
    const mask_t<F> seen = inside & is_covered(there) & (p.depth <= there.depth * F(in.u.reach));
    tap("seen", seen, "1 if the view sees X itself");
    const mask_t<F> kept = is_covered(s) & !seen;
    const F zero(0.0f);
    const vec4<F> result{select(kept, texel.x, zero), select(kept, texel.y, zero), select(kept, texel.z, zero),
                         select(kept, texel.w, zero)};
    tap("unseen", xyz<F>(result), "normal of X; 0 where the view sees it");
    return result;
}

struct UnseenKernel {
    using View = UnseenInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return unseen<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.unseen; }
    static auto& frame(auto& in) { return in.u.u; }
};

}  // namespace plumb::isr
