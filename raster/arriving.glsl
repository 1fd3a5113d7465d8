// What arrives from a lamp at x: irradiance on a plane across the rays, W/m2; w: towards the lamp, unit. arriving_kernel.h has
// the same; light.glsl comes first.
vec3 arriving_from(LightArgs light, vec3 x, out vec3 w) {
    vec3 axis = light.direction;
    if (light.directional > 0.0) {
        w = -axis;
        return light.intensity;
    }
    precise vec3 d = light.position - x;
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    precise float inverse = 1.0 / sqrt(max(d2, 1e-37));
    precise vec3 direction = d * inverse;
    w = direction;
    precise float cos_axis = -(direction.x * axis.x + direction.y * axis.y + direction.z * axis.z);
    precise float factor = inverse * inverse;
    precise vec3 arriving = light_intensity(light, cos_axis, d2) * factor;
    return arriving;
}
