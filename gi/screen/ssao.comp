#version 450
// Twin of ssao_kernel.h: ambient occlusion from one view, LRA 4.2.3 and 4.3.2.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/screen/view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform SsaoUniforms {
    SeenFrom view;
    float radius;
    float bias;
    float weight_bias;
    int samples;
    int own;
    int weighted;
    int published;
    int width;
    int height;
} u;
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit; all 0: no surface
layout(binding = 3) uniform sampler2D map_position;      // of the view: xyz world, m; w linear depth, m; 0: nothing
layout(binding = 4) uniform sampler2D before_image;    // what other views have summed
layout(std430, binding = 5) readonly buffer Samples { vec4 samples[]; };      // [samples]
layout(std430, binding = 6) readonly buffer Rotations { vec2 rotations[]; };  // [16]
layout(binding = 7, rgba32f) uniform writeonly image2D summed_image;

struct Receiver {
    vec3 p;
    vec3 n;
    vec3 from_anchor;
    vec3 tangent;
    vec3 bitangent;
    float depth;
};

Receiver receiver_of(ivec2 pixel) {
    vec3 p = texelFetch(position_image, pixel, 0).xyz;            TAP(p, p);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;              TAP(n, n);
    precise vec3 v = p - u.view.anchor.xyz;
    vec2 turn = rotations[(pixel.x & 3) + (pixel.y & 3) * 4];
    vec4 axis = u.view.forward;
    precise float d_p = axis.x * v.x + axis.y * v.y + axis.z * v.z + axis.w;
    precise vec3 tangent;
    precise vec3 bitangent;
    if (u.published != 0) {
        // Gram-Schmidt of a vector in the plane z = 0.
        precise float along = turn.x * n.x + turn.y * n.y;
        precise vec3 t = vec3(turn.x - n.x * along, turn.y - n.y * along, -(n.z * along));
        precise float length2 = t.x * t.x + t.y * t.y + t.z * t.z;
        precise float inverse = 1.0 / sqrt(max(length2, 1e-37));
        tangent = t * inverse;
        bitangent = vec3(n.y * tangent.z - n.z * tangent.y, n.z * tangent.x - n.x * tangent.z,
                         n.x * tangent.y - n.y * tangent.x);
    } else {
        // Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
        float side = n.z < 0.0 ? -1.0 : 1.0;
        precise float a = -1.0 / (side + n.z);
        precise float b = n.x * n.y * a;
        precise vec3 first = vec3(1.0 + side * n.x * n.x * a, side * b, -(side * n.x));
        precise vec3 second = vec3(b, side + n.y * n.y * a, -n.y);
        tangent = first * turn.x + second * turn.y;
        bitangent = second * turn.x - first * turn.y;
    }
    TAP(tangent, tangent);
    return Receiver(p, n, v, tangent, bitangent, u.published != 0 ? -p.z : d_p);
}

struct Surface {
    vec3 to_q;
    float depth;
    bool known;
};

Surface surface_at(Receiver r, Place place) {
    vec4 q = texelFetch(map_position, place.inside ? place.texel : ivec2(0), 0);
    precise vec3 to_q = q.xyz - r.p;                              TAP(to_q, to_q);
    float depth = u.published != 0 ? -q.z : q.w;                  TAP(depth_q, depth);
    return Surface(to_q, depth, place.inside && q.w > 0.0);
}

// Whether q is before a point at `depth`, and above the plane of p.
bool hides(Receiver r, Surface q, float depth) {
    precise float rise = q.to_q.x * r.n.x + q.to_q.y * r.n.y + q.to_q.z * r.n.z;
    TAP(rise, rise);
    precise float limit = u.bias - depth;
    bool printed = -q.depth >= limit;
    bool hidden = q.known && (u.published != 0 ? printed : q.depth < depth && rise > u.bias);
    TAP(hidden, hidden);
    return hidden;
}

struct Occlusion {
    float open;
    float distance;
    float count;
};

Occlusion occlusion_of(Receiver r, bool covered) {
    precise float occlusion = 0.0;
    precise float distance = 0.0;
    float count = 0.0;
    for (int k = 0; covered && k < u.samples; ++k) {
        TAP_SAMPLE(k);
        precise vec3 local = samples[k].xyz * u.radius;
        precise vec3 s = r.tangent * local.x + r.bitangent * local.y + r.n * local.z;
        TAP(s, s);
        precise vec3 v = r.from_anchor + s;
        Place place = place_of(u.view, v);
        Surface q = surface_at(r, place);
        precise float printed_depth = -(r.p.z + s.z);
        bool hidden = hides(r, q, u.published != 0 ? printed_depth : place.depth);
        precise float near = u.radius / max(abs(r.depth - q.depth), u.radius);
        precise float range = near * near * (3.0 - (near + near));
        TAP(range, range);
        occlusion += hidden ? range : 0.0;
        count += u.published != 0 || place.inside ? 1.0 : 0.0;
        if (u.weighted != 0) {
            vec3 to = u.published != 0 ? s : q.to_q;
            precise float length2 = to.x * to.x + to.y * to.y + to.z * to.z;
            float along = min(sqrt(length2), u.radius);
            distance += u.published != 0 || q.known ? along : u.radius;
        }
    }
    TAP_SAMPLE(-1);
    TAP(occlusion, occlusion);
    TAP(count, count);
    precise float open = 1.0 - occlusion / max(count, 1.0);       TAP(open, open);
    return Occlusion(open, distance, count);
}

// What the view weighs at p.
float weight_of(Receiver r, Occlusion o) {
    vec3 v = r.from_anchor;
    vec3 axis = u.view.forward.xyz;
    precise float length2 = v.x * v.x + v.y * v.y + v.z * v.z;
    precise float inverse = 1.0 / sqrt(max(length2, 1e-37));
    precise float dot_v = r.n.x * v.x + r.n.y * v.y + r.n.z * v.z;
    precise float unit = dot_v * inverse;
    float to_eye = -(u.published != 0 ? dot_v : unit);
    precise float along = -(r.n.x * axis.x + r.n.y * axis.y + r.n.z * axis.z);
    bool parallel = u.published == 0 && u.view.perspective == 0.0;
    float facing = max(0.0, parallel ? along : to_eye);           TAP(facing, facing);
    precise float near = 1.0 - o.distance / (float(u.samples) * u.radius);
    TAP(near, near);
    precise float weight = (1.0 - u.weight_bias) * facing + u.weight_bias * near;
    if (u.published != 0) return weight;
    bool sees = o.count > 0.0;
    if (u.own == 0) {
        Place place = place_of(u.view, v);
        Surface q = surface_at(r, place);
        bool hidden = hides(r, q, place.depth);
        sees = sees && q.known && facing > 0.0 && !hidden;
    }
    return sees ? weight : 0.0;
}

vec4 ssao(ivec2 pixel) {
    Receiver r = receiver_of(pixel);
    precise float n2 = r.n.x * r.n.x + r.n.y * r.n.y + r.n.z * r.n.z;
    bool covered = n2 > 0.0;
    Occlusion o = occlusion_of(r, covered);
    float weight = u.weighted != 0 ? weight_of(r, o) : 1.0;       TAP(weight, weight);
    vec4 before = texelFetch(before_image, pixel, 0);
    precise vec3 sum = vec3(before.x + weight * o.open, before.y + weight, u.own != 0 ? o.open : before.z);
    TAP(sum, sum);
    return covered ? vec4(sum, 1.0) : vec4(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(summed_image, pixel, ssao(pixel));
}
