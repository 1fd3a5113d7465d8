// Twin of light_kernel.h.

struct LightArgs {
    vec3 position;
    float cos_outer;
    vec3 direction;
    float falloff_scale;
    vec3 intensity;
    float directional;
    float inverse_radius2;
    float radius2;
};

float spot_falloff(LightArgs light, float cosine) {
    precise float t = min(max((cosine - light.cos_outer) * light.falloff_scale, 0.0), 1.0);
    precise float falloff = t * t * (3.0 - 2.0 * t);
    return falloff;
}

// Radiant intensity of a spot or point light in that direction, W/sr; with a radius: ISR (16), I (1 - s) s r^2.
vec3 light_intensity(LightArgs light, float cosine, float d2) {
    precise float falloff = spot_falloff(light, cosine);
    if (light.inverse_radius2 > 0.0) {
        precise float s = min(d2 * light.inverse_radius2, 1.0);
        falloff = falloff * ((1.0 - s) * s * light.radius2);
    }
    precise vec3 intensity = light.intensity * falloff;
    return intensity;
}
