#version 450
// Twin of horizon_kernel.h: horizon-based ambient occlusion (Jimenez et al. 2016).
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"
#include "core/tap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform HorizonUniforms {
    vec4 anchor;  // w: the least depth, m
    vec4 forward;
    vec4 right;
    vec4 down;
    float radius;
    float bias;
    int slices;
    int steps;
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m; w linear depth, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit; all 0: no surface
layout(std430, binding = 3) readonly buffer Turns { vec2 turns[]; };     // [16][slices]
layout(std430, binding = 4) readonly buffer Shares { float shares[]; };  // [steps]
layout(binding = 5, rgba32f) uniform writeonly image2D summed_image;

struct Slice {
    vec3 t;
    float across;
    float down;
};

struct Eye {
    vec3 p;
    vec3 v;
    vec3 tangent;
    vec3 bitangent;
    float depth;
    float tan_x;
    float tan_y;
};

Eye eye_of(vec3 p) {
    TAP(p, p);
    precise vec3 w = p - u.anchor.xyz;
    precise float w2 = w.x * w.x + w.y * w.y + w.z * w.z;
    precise float inverse = -1.0 / sqrt(max(w2, 1e-37));
    precise vec3 v = w * inverse;                                 TAP(v, v);
    vec3 right = u.right.xyz;
    vec3 down = u.down.xyz;
    precise float along = right.x * v.x + right.y * v.y + right.z * v.z;
    precise vec3 t = right - v * along;
    precise float t2 = t.x * t.x + t.y * t.y + t.z * t.z;
    precise float scale = 1.0 / sqrt(max(t2, 1e-37));
    precise vec3 tangent = t * scale;
    precise vec3 bitangent = vec3(v.y * tangent.z - v.z * tangent.y, v.z * tangent.x - v.x * tangent.z,
                                  v.x * tangent.y - v.y * tangent.x);
    vec4 axis = u.forward;
    precise float d_p = axis.x * w.x + axis.y * w.y + axis.z * w.z + axis.w;
    float depth = max(d_p, u.anchor.w);
    precise float tan_x = (right.x * w.x + right.y * w.y + right.z * w.z) / depth;
    precise float tan_y = (down.x * w.x + down.y * w.y + down.z * w.z) / depth;
    return Eye(p, v, tangent, bitangent, depth, tan_x, tan_y);
}

Slice slice_of(Eye e, int turn) {
    vec2 angle = turns[turn];
    precise vec3 t = e.tangent * angle.x + e.bitangent * angle.y; TAP(t, t);
    // How (right . p) / depth and (down . p) / depth change along t.
    vec3 axis = u.forward.xyz;
    precise float forward = axis.x * t.x + axis.y * t.y + axis.z * t.z;
    precise float right_t = u.right.x * t.x + u.right.y * t.y + u.right.z * t.z;
    precise float down_t = u.down.x * t.x + u.down.y * t.y + u.down.z * t.z;
    precise float across = u.right.w * (right_t - forward * e.tan_x) / e.depth;
    precise float down = u.down.w * (down_t - forward * e.tan_y) / e.depth;
    TAP(pixels, vec2(across, down));
    return Slice(t, across, down);
}

// The largest cosine to v of what lies within the radius to that side of p, above its plane; -1: nothing does.
float horizon_of(Eye e, vec3 n, Slice slice, ivec2 pixel, float side) {
    // What is nearer to the eye spans more pixels.
    precise float nearest = max(e.depth - u.radius, 0.5 * e.depth);
    precise float reach = side * u.radius * e.depth / nearest;
    precise float radius2 = u.radius * u.radius;
    float highest = -1.0;
    for (int k = 0; k < u.steps; ++k) {
        TAP_SAMPLE(k);
        precise float length = shares[k] * reach;
        precise vec2 at = vec2(pixel) + vec2(0.5) + vec2(slice.across, slice.down) * length;
        at = min(max(at, vec2(-65536.0)), vec2(65536.0));
        CHOICE(int(floor(at.x)));
        CHOICE(int(floor(at.y)));
        ivec2 texel = ivec2(floor(at));                           TAP(texel, texel);
        bool inside = texel.x >= 0 && texel.x < u.width && texel.y >= 0 && texel.y < u.height;
        vec4 q = texelFetch(position_image, inside ? texel : ivec2(0), 0);
        precise vec3 d = q.xyz - e.p;
        precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;     TAP(d2, d2);
        precise float rise = d.x * n.x + d.y * n.y + d.z * n.z;   TAP(rise, rise);
        bool within = inside && q.w > 0.0 && rise > u.bias && d2 <= radius2;
        TAP(within, within);
        precise float d_v = d.x * e.v.x + d.y * e.v.y + d.z * e.v.z;
        precise float cosine = d_v / sqrt(max(d2, 1e-37));
        highest = within ? max(highest, cosine) : highest;        TAP(highest, highest);
    }
    TAP_SAMPLE(-1);
    return highest;
}

// a(h) of the horizon with that cosine to v, on one side (1 or -1).
float arc(float highest, float side, float g, float cos_g, float sin_g) {
    float cosine = min(max(highest, -1.0), 1.0);
    precise float angle = side * det_acos(cosine);
    precise float limit = g + side * 1.57079637;
    bool below = side > 0.0 ? angle > limit : angle < limit;
    precise float sine = side * sqrt(max(0.0, 1.0 - cosine * cosine));
    precise float cos_2h = (cosine + cosine) * cosine - 1.0;
    precise float sin_2h = (cosine + cosine) * sine;
    precise float above = cos_2h * cos_g + sin_2h * sin_g;
    float turned = below ? -cos_g : above;
    float h = below ? limit : angle;                              TAP(h, h);
    precise float a = 0.25 * (cos_g - turned + (h + h) * sin_g);
    return a;
}

float open_share(Eye e, vec3 n, int turn, ivec2 pixel) {
    Slice slice = slice_of(e, turn);
    float ahead = horizon_of(e, n, slice, pixel, 1.0);
    float behind = horizon_of(e, n, slice, pixel, -1.0);
    precise float n_v = n.x * e.v.x + n.y * e.v.y + n.z * e.v.z;
    precise float n_t = n.x * slice.t.x + n.y * slice.t.y + n.z * slice.t.z;
    precise float length2 = n_v * n_v + n_t * n_t;
    precise float length = sqrt(max(length2, 1e-37));             TAP(length, length);
    precise float cos_g = min(max(n_v / length, -1.0), 1.0);
    precise float sin_g = min(max(n_t / length, -1.0), 1.0);
    float angle = det_acos(cos_g);
    float g = n_t < 0.0 ? -angle : angle;                         TAP(g, g);
    float second = arc(ahead, 1.0, g, cos_g, sin_g);
    float first = arc(behind, -1.0, g, cos_g, sin_g);
    precise float share = length * (first + second);
    TAP(share, share);
    return share;
}

vec4 horizon(ivec2 pixel) {
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;              TAP(n, n);
    Eye e = eye_of(texelFetch(position_image, pixel, 0).xyz);
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool covered = n2 > 0.0;
    int turn = (pixel.x & 3) + (pixel.y & 3) * 4;
    precise float sum = 0.0;
    for (int i = 0; covered && i < u.slices; ++i) sum += open_share(e, n, turn * u.slices + i, pixel);
    precise float open = min(max(sum / float(u.slices), 0.0), 1.0);
    TAP(open, open);
    return covered ? vec4(open, 1.0, open, 1.0) : vec4(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(summed_image, pixel, horizon(pixel));
}
