// What gather.comp and gather_all.comp share: the uniform block and VRSM (3.2), and what a sample's size makes of it, as in
// gather_kernel.h.
#include "core/tile.glsl"
#include "raster/project.glsl"

struct GatherUniforms {
    Projection map;
    float least_distance2;
    float scale;
    int samples;
    int rotations;
    int width;
    int height;
    uint seed;
    int reach;
    vec4 texel_area;
    float sample_area;
    int tile;
};

// The geometry of VRSM (3.2), everything but the flux: 1/m2.
float form(vec3 x, vec3 n, vec3 x_p, vec3 n_p, float least_distance2) {
    precise vec3 d = x_p - x;
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;                              TAP(d2, d2);
    precise float cos_p = max(0.0, -(n_p.x * d.x + n_p.y * d.y + n_p.z * d.z));  TAP(cos_p, cos_p);
    precise float cos_x = max(0.0, n.x * d.x + n.y * d.y + n.z * d.z);           TAP(cos_x, cos_x);
    precise float inverse = 1.0 / max(d2, least_distance2);
    precise float form = (cos_p * inverse) * (cos_x * inverse);                    TAP(form, form);
    return form;
}

// How much of what `weight` pixel lights send from one point a disc as large as their texels does:
// d^2 / (d^2 + weight A / pi), A = h^3 / |n_p . (texel_area.xyz - texel_area.w x_p)|.
float share_of_disc(Projection map, vec4 texel_area, float sample_area, float least_distance2, vec3 x, vec3 x_p, vec3 n_p,
                    float weight) {
    precise vec3 d = x_p - x;
    precise float w = map.to_texel_w.x * x_p.x + map.to_texel_w.y * x_p.y + map.to_texel_w.z * x_p.z + map.to_texel_w.w;
    // Beyond 1e12 m its cube would leave the range of a float.
    precise float h = min(max(w, map.least_w), 1e12);
    precise vec3 seen = texel_area.xyz - texel_area.w * x_p;
    precise float facing = abs(n_p.x * seen.x + n_p.y * seen.y + n_p.z * seen.z);
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    // No product of infinity and 0.
    precise float point = min(min(max(d2, least_distance2), 1e37) * facing, 1e37);
    precise float disc = point + (weight * sample_area * h) * (h * h);
    precise float share = point / max(disc, 1e-37);                                TAP(share, share);
    return share;
}
