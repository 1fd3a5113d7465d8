// The spatial kernel of probes, as in weight_kernel.h.

// w(t) = 2 t^3 - 3 t^2 + 1 for t in [0, 1], as (1 - t)^2 (1 + 2 t).
float spatial_weight(float t) {
    precise float s = 1.0 - t;
    precise float w = s * s * (1.0 + (t + t));
    return w;
}

// |a - b|^2
float distance2(vec3 a, vec3 b) {
    precise vec3 d = a - b;
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    return d2;
}
