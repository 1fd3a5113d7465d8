// Twin of project_kernel.h.
#include "core/tap.glsl"

struct Projection {
    vec4 to_texel_x;
    vec4 to_texel_y;
    vec4 to_texel_w;
    float least_w;
    float low;
    float high;
    int size;
};

// Where x projects to, texels; not rounded.
vec2 projected(Projection map, vec3 x) {
    precise float row_x = map.to_texel_x.x * x.x + map.to_texel_x.y * x.y + map.to_texel_x.z * x.z + map.to_texel_x.w;
    precise float row_y = map.to_texel_y.x * x.x + map.to_texel_y.y * x.y + map.to_texel_y.z * x.z + map.to_texel_y.w;
    precise float row_w = map.to_texel_w.x * x.x + map.to_texel_w.y * x.y + map.to_texel_w.z * x.z + map.to_texel_w.w;
    precise float w = max(map.least_w, row_w);
    precise vec2 texel = vec2(min(max(row_x / w, map.low), map.high), min(max(row_y / w, map.low), map.high));
    TAP(projection, texel);
    return texel;
}

// The texel that x projects to: the one rounding that decides which texels are read.
ivec2 project(Projection map, vec3 x) {
    vec2 texel = projected(map, x);
    CHOICE(int(floor(texel.x)));
    CHOICE(int(floor(texel.y)));
    return ivec2(floor(texel));
}

// Which of a point light's six maps sees along v, a vector from the light: +x -x +y -y +z -z, by the largest component.
int face_of(vec3 v) {
    vec3 a = abs(v);
    bool along_x = a.x >= a.y && a.x >= a.z;
    bool along_y = a.y >= a.z;
    float along = along_x ? v.x : along_y ? v.y : v.z;
    int positive = along_x ? 0 : along_y ? 2 : 4;
    return positive + (along < 0.0 ? 1 : 0);
}
