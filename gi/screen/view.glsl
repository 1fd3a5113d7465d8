// Where points fall in the image of a view, as in view_kernel.h.

#include "gi/screen/seen_from.glsl"

struct Place {
    ivec2 texel;
    float depth;
    bool inside;
};

// v: from the view's anchor, m.
Place place_of(SeenFrom view, vec3 v) {
    precise float depth = view.forward.x * v.x + view.forward.y * v.y + view.forward.z * v.z + view.forward.w;
    precise float row_x = view.to_x.x * v.x + view.to_x.y * v.y + view.to_x.z * v.z + view.to_x.w;
    precise float row_y = view.to_y.x * v.x + view.to_y.y * v.y + view.to_y.z * v.z + view.to_y.w;
    bool perspective = view.perspective > 0.0;
    float divisor = perspective ? max(depth, view.least_depth) : 1.0;
    // Far outside is far enough: an index must not overflow.
    precise vec2 at = min(max(vec2(row_x / divisor, row_y / divisor), vec2(-65536.0)), vec2(65536.0));
    TAP(depth, depth);
    CHOICE(int(floor(at.x)));
    CHOICE(int(floor(at.y)));
    ivec2 texel = ivec2(floor(at));                               TAP(texel, texel);
    bool inside = texel.x >= 0 && texel.x < view.width && texel.y >= 0 && texel.y < view.height;
    inside = inside && (!perspective || depth >= view.least_depth);
    TAP(inside, inside);
    return Place(texel, depth, inside);
}
