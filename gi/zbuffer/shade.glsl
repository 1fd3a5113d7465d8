// Twin of shade_kernel.h: what lamps send by way of a point. Before it: shade_uniforms.glsl, a block `u` with it as `shade`,
// `lights[]` and `objects[]`, core/detmath.glsl.

vec3 normalised(vec3 v) {
    precise float len = max(sqrt(v.x * v.x + v.y * v.y + v.z * v.z), 1e-30);
    precise vec3 unit = vec3(v.x / len, v.y / len, v.z / len);
    return unit;
}

// The unit vector along d, whatever its length.
vec3 unit_along(vec3 d) {
    precise float scale = 1.0 / max(max(abs(d.x), max(abs(d.y), abs(d.z))), 1e-37);
    precise vec3 scaled = d * scale;
    return normalised(scaled);
}

float dot3(vec3 a, vec3 b) {
    precise float d = a.x * b.x + a.y * b.y + a.z * b.z;
    return d;
}

// By three rows of the object's matrices from `first` on: 0 for normals, 3 for light.
vec3 turned(int object, int first, vec3 v) {
    int row = object * 6 + first;
    return normalised(vec3(dot3(objects[row].xyz, v), dot3(objects[row + 1].xyz, v), dot3(objects[row + 2].xyz, v)));
}

// max(0, R . V)^n, of the half vector max(0, N . H)^n.
float lobe_of(vec3 n, float n_l, vec3 l, vec3 v, float exponent) {
    float cosine;
    if (u.shade.blinn != 0) {
        precise vec3 between = l + v;
        cosine = dot3(n, normalised(between));
    } else {
        float away = n_l < 0.0 ? min(-n_l, 1.0) : 0.0;
        precise float twice = 2.0 * (u.shade.published != 0 ? away : n_l);
        float turn = u.shade.published != 0 ? 1.0 : -1.0;
        precise vec3 mirrored = vec3(twice * n.x + turn * l.x, twice * n.y + turn * l.y, twice * n.z + turn * l.z);
        cosine = dot3(normalised(mirrored), v);
    }
    cosine = min(max(cosine, 0.0), 1.0);                          TAP(cosine, cosine);
    float raised = det_pow(cosine, exponent);
    bool open = n_l > 0.0 || u.shade.published != 0;
    float power = open && cosine > 0.0 && raised > 1e-30 ? raised : 0.0;
    TAP(power, power);
    return power;
}

// Of all lamps, with what is there without one: returns diffuse light.
vec3 lit_by(vec3 x, vec3 n, vec3 v, float exponent, int object, out vec3 specular) {
    precise vec3 sum_diffuse = u.shade.ambient.xyz;
    precise vec3 sum_specular = vec3(0.0);
    for (int first = 0; first < u.shade.lights; first += 32) {
        precise vec3 part_diffuse = vec3(0.0);
        precise vec3 part_specular = vec3(0.0);
        for (int k = first; k < min(first + 32, u.shade.lights); ++k) {
            TAP_SAMPLE(k);
            vec3 l;
            vec3 irradiance = arriving_from(lights[k], x, l);
            if (u.shade.published != 0 && lights[k].directional > 0.0) l = turned(object, 3, l);
            TAP(L, l);
            float n_l = dot3(n, l);
            float facing = n_l > 0.0 ? n_l : 0.0;                 TAP(facing, facing);
            if (u.shade.diffuse != 0) {
                precise vec3 e = irradiance * facing;             TAP(E, e);
                part_diffuse += e;
            }
            if (u.shade.specular != 0) {
                precise vec3 e = irradiance * lobe_of(n, n_l, l, v, exponent);
                TAP(E_lobe, e);
                part_specular += e;
            }
        }
        sum_diffuse += part_diffuse;
        sum_specular += part_specular;
    }
    TAP_SAMPLE(-1);
    specular = sum_specular;
    return sum_diffuse;
}

// 1 over what a channel's colour exceeds 1 by; else 1.
float saturating(float diffuse, float specular, float rho, float k) {
    precise float colour = (rho * diffuse + k * specular) * 0.318309886;
    precise float scale = 1.0 / max(1.0, colour);
    return scale;
}

// The light, its specular part times C_s; where asked for, no brighter than its colour may be.
void colour(inout vec3 diffuse, inout vec3 specular, vec3 rho, vec3 k) {
    vec3 scale = vec3(1.0);
    if (u.shade.saturated != 0)
        scale = vec3(saturating(diffuse.x, specular.x, rho.x, k.x), saturating(diffuse.y, specular.y, rho.y, k.y),
                     saturating(diffuse.z, specular.z, rho.z, k.z));
    TAP(scale, scale);
    precise vec3 of_diffuse = diffuse * scale;
    precise vec3 of_specular = k * specular * scale;
    diffuse = of_diffuse;
    specular = of_specular;
    TAP(diffuse, diffuse);
    TAP(specular, specular);
}
