// Twin of light_kernel.h.

struct LightArgs {
    vec3 position;
    float cos_outer;
    vec3 direction;
    float falloff_scale;
    vec3 intensity;
    float directional;
};

float spot_falloff(LightArgs light, float cosine) {
    precise float t = min(max((cosine - light.cos_outer) * light.falloff_scale, 0.0), 1.0);
    precise float falloff = t * t * (3.0 - 2.0 * t);
    return falloff;
}

// Radiant intensity of a spot or point light in that direction, W/sr.
vec3 light_intensity(LightArgs light, float cosine) {
    float falloff = spot_falloff(light, cosine);
    precise vec3 intensity = light.intensity * falloff;
    return intensity;
}
