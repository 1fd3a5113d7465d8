#version 450
// Twin of lookup_kernel.h: indirect light of a pixel from the lightmap.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/lightmap_levels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform LookupUniforms {
    int width;
    int height;
    int side;    // texels of the lightmap's finest level
    int levels;
} u;
layout(binding = 1) uniform sampler2D uv_image;        // xy on the lightmap, z level of detail, w 1: it has a place there
layout(binding = 2) uniform sampler2D lightmap_image;  // the levels below each other
layout(binding = 3, rgba32f) uniform writeonly image2D irradiance_image;

vec4 lookup(ivec2 pixel) {
    vec4 at = texelFetch(uv_image, pixel, 0);                     TAP(uv, at.xyz);
    bool has = at.w > 0.0;
    precise float z = max(0.0, min(at.z, float(u.levels - 1)));
    CHOICE(int(floor(z)));
    int level = int(floor(z));
    precise float share = z - float(level);                       TAP(share, share);
    vec3 fine = lightmap_at(lightmap_image, u.side, u.levels, at.xy, level);
    TAP(fine, fine);
    vec3 coarse = lightmap_at(lightmap_image, u.side, u.levels, at.xy, level + 1);
    TAP(coarse, coarse);
    vec3 mean = mixed(fine, coarse, share);
    vec4 irradiance = vec4(has ? mean.x : 0.0, has ? mean.y : 0.0, has ? mean.z : 0.0, 0.0);
    TAP(irradiance, irradiance.xyz);
    return irradiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(irradiance_image, pixel, lookup(pixel));
}
