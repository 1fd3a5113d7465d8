// What gather.comp and gather_all.comp share: the uniform block and VRSM (3.2), as in gather_kernel.h.
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
