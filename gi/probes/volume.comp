#version 450
// Twin of volume_kernel.h: irradiance of what has no lightmap, from the grid of spatial receivers, and its light vector.
#extension GL_GOOGLE_include_directive : require
#include "core/tap.glsl"
#include "gi/probes/volume.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform VolumeUniforms {
    int width;       // of the points
    int height;
    int count_x;     // places
    int count_y;
    int count_z;
    int form;        // 0 cube, 1 linear, 2 angles
    int everywhere;  // 1: of surfaces with a lightmap, too
    float least;     // of the light vector along n, of S
    vec4 origin;
    vec4 spacing;
} u;
layout(binding = 1) uniform sampler2D position_image;     // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;       // xyz unit; w 1: a point
layout(binding = 3) uniform sampler2D lightmap_uv_image;  // x < 0: no lightmap
layout(std430, binding = 4) readonly buffer Grid { vec4 grid[]; };  // [place][direction]
layout(binding = 5, rgba32f) uniform writeonly image2D irradiance_image;
layout(binding = 6, rgba32f) uniform writeonly image2D light_image;
layout(binding = 7, rgba32f) uniform writeonly image2D from_light_image;

SixSides grid_at(vec3 x) {
    GridCell cx = grid_cell(x.x, u.origin.x, u.spacing.x, u.count_x);
    GridCell cy = grid_cell(x.y, u.origin.y, u.spacing.y, u.count_y);
    GridCell cz = grid_cell(x.z, u.origin.z, u.spacing.z, u.count_z);
    TAP(cell, ivec2(cx.first, cy.first));
    TAP(cell_z, cz.first);
    precise vec3 x_plus = vec3(0.0);
    precise vec3 x_minus = vec3(0.0);
    precise vec3 y_plus = vec3(0.0);
    precise vec3 y_minus = vec3(0.0);
    precise vec3 z_plus = vec3(0.0);
    precise vec3 z_minus = vec3(0.0);
    for (int k = 0; k < 8; ++k) {
        TAP_SAMPLE(k);
        bool right = (k & 1) != 0;
        bool up = (k & 2) != 0;
        bool far = (k & 4) != 0;
        precise float along_x = right ? cx.share : 1.0 - cx.share;
        precise float along_y = up ? cy.share : 1.0 - cy.share;
        precise float along_z = far ? cz.share : 1.0 - cz.share;
        precise float weight = along_x * along_y * along_z;       TAP(weight, weight);
        int row = (far ? cz.next : cz.first) * u.count_y + (up ? cy.next : cy.first);
        int place = row * u.count_x + (right ? cx.next : cx.first);
        TAP(place, place);
        int at = place * 6;
        x_plus = x_plus + weight * grid[at].xyz;
        x_minus = x_minus + weight * grid[at + 1].xyz;
        y_plus = y_plus + weight * grid[at + 2].xyz;
        y_minus = y_minus + weight * grid[at + 3].xyz;
        z_plus = z_plus + weight * grid[at + 4].xyz;
        z_minus = z_minus + weight * grid[at + 5].xyz;
    }
    TAP_SAMPLE(-1);
    TAP(E_x_plus, x_plus);
    TAP(E_x_minus, x_minus);
    TAP(E_y_plus, y_plus);
    TAP(E_y_minus, y_minus);
    TAP(E_z_plus, z_plus);
    TAP(E_z_minus, z_minus);
    return SixSides(x_plus, x_minus, y_plus, y_minus, z_plus, z_minus);
}

void in_volume(ivec2 pixel) {
    vec4 normal = texelFetch(normal_image, pixel, 0);
    vec3 n = normal.xyz;                                          TAP(n, n);
    float uv = texelFetch(lightmap_uv_image, pixel, 0).x;         TAP(uv, uv);
    bool point = normal.w > 0.0;
    bool served = u.everywhere != 0 ? point : point && uv < 0.0;  TAP(served, served);
    vec4 irradiance = vec4(0.0);
    vec4 light = vec4(0.0);
    vec4 from_light = vec4(0.0);
    if (served) {
        vec3 x = texelFetch(position_image, pixel, 0).xyz;        TAP(x, x);
        SixSides sides = grid_at(x);
        vec3 e = irradiance_towards(u.form, sides, n);            TAP(E, e);
        vec3 l = light_vector(u.form, u.least, sides, n);         TAP(l, l);
        vec3 most = irradiance_towards(u.form, sides, l);         TAP(E_l, most);
        irradiance = vec4(e, 1.0);
        light = vec4(l, 1.0);
        from_light = vec4(most, 1.0);
    }
    imageStore(irradiance_image, pixel, irradiance);
    imageStore(light_image, pixel, light);
    imageStore(from_light_image, pixel, from_light);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    in_volume(pixel);
}
