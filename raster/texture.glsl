// Twin of texture_kernel.h: the same functions, in the same order.
#include "core/tap.glsl"

layout(std430, binding = 6) readonly buffer Textures { ivec4 textures[]; };  // first texel, width, height, flags
layout(std430, binding = 7) readonly buffer Texels { int texels[]; };        // RGBA8
layout(std430, binding = 8) readonly buffer Decode { float decode[]; };      // [2][256]

const int flag_nearest = 1;
const int flag_srgb = 2;
const int wrap_u_shift = 2;
const int wrap_v_shift = 4;
const int levels_shift = 6;

float texel_coordinate(float u, int size, int wrap, bool nearest) {
    bool mirrored = wrap == 1;
    bool clamped = wrap == 2;
    precise float periods = u * (mirrored ? 0.5 : 1.0);
    precise float within = clamped ? min(max(u, 0.0), 1.0) : periods - floor(periods);
    precise float along = within * float(mirrored ? size + size : size);
    precise float coordinate = nearest ? floor(along) : along - 0.5;
    return abs(u) <= 3.40282347e+38 ? coordinate : 0.0;
}

int wrap_index(int i, int size, int wrap) {
    bool mirrored = wrap == 1;
    bool clamped = wrap == 2;
    int below = mirrored ? -1 - i : i + size;
    int above = mirrored ? size + size - 1 - i : i - size;
    int folded = i < 0 ? below : (i < size ? i : above);
    return min(max(clamped ? i : folded, 0), size - 1);
}

struct TexelQuad {
    int a;
    int b;
    int c;
    int d;
    float along_u;
    float along_v;
    int curve;
};

TexelQuad fetch_quad(int row, vec2 uv) {
    int first = textures[row].x;
    int width = textures[row].y;
    int height = textures[row].z;
    int flags = textures[row].w;
    int wrap_u = (flags >> wrap_u_shift) & 3;
    int wrap_v = (flags >> wrap_v_shift) & 3;
    bool nearest = (flags & flag_nearest) > 0;

    float x = texel_coordinate(uv.x, width, wrap_u, nearest);
    float y = texel_coordinate(uv.y, height, wrap_v, nearest);
    float left = floor(x);
    float top = floor(y);
    int i = int(left);
    int j = int(top);
    int x0 = wrap_index(i, width, wrap_u);
    int x1 = wrap_index(i + 1, width, wrap_u);
    int upper = first + wrap_index(j, height, wrap_v) * width;
    int lower = first + wrap_index(j + 1, height, wrap_v) * width;
    precise float along_u = x - left;
    precise float along_v = y - top;
    TAP(texel, ivec2(i, j));
    TAP(texel_weight, vec2(along_u, along_v));
    return TexelQuad(texels[upper + x0], texels[upper + x1], texels[lower + x0], texels[lower + x1], along_u, along_v,
                     (flags & flag_srgb) << 7);
}

float filter_channel(TexelQuad q, int curve, int channel) {
    float a = decode[curve + ((q.a >> (8 * channel)) & 255)];
    float b = decode[curve + ((q.b >> (8 * channel)) & 255)];
    float c = decode[curve + ((q.c >> (8 * channel)) & 255)];
    float d = decode[curve + ((q.d >> (8 * channel)) & 255)];
    precise float upper = a + q.along_u * (b - a);
    precise float lower = c + q.along_u * (d - c);
    precise float value = upper + q.along_v * (lower - upper);
    return value;
}
vec3 filter_rgb(TexelQuad q, int curve) {
    return vec3(filter_channel(q, curve, 0), filter_channel(q, curve, 1), filter_channel(q, curve, 2));
}

struct Detail {
    int level;
    float blend;
};
Detail detail(float texels_covered, int last) {
    precise float root = sqrt(texels_covered);
    precise float ratio = 1.0 < root ? min(root, 1073741824.0) : 1.0;  // not a number: 1
    int level = 0;
    for (int halvings = 16; halvings > 0; halvings /= 2) {
        if (ratio >= float(1 << halvings)) {
            ratio = ratio * (1.0 / float(1 << halvings));
            level += halvings;
        }
    }
    precise float blend = level < last ? ratio - 1.0 : 0.0;
    return Detail(min(level, last), blend);
}

vec3 sample_texture(int row, vec2 uv, float uv_area, bool levels, bool plain) {
    Detail d = Detail(0, 0.0);
    if (levels) {
        precise float covered = uv_area * (float(textures[row].y) * float(textures[row].z));
        d = detail(covered, textures[row].w >> levels_shift);
        TAP(level, d.level);
        TAP(level_blend, d.blend);
    }
    TexelQuad q = fetch_quad(row + d.level, uv);
    vec3 c = filter_rgb(q, plain ? 0 : q.curve);
    if (!(d.blend > 0.0)) return c;
    TAP_OFF;
    TexelQuad r = fetch_quad(row + d.level + 1, uv);
    TAP_ON;
    vec3 e = filter_rgb(r, plain ? 0 : r.curve);
    precise vec3 colour = c + d.blend * (e - c);
    return colour;
}
