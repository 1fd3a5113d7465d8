// How alike two pixels of a surface are, as in weights_kernel.h.

struct Centre {
    vec3 x;
    float depth;
    float per_sigma;
    vec3 across;
    vec3 scaled_n;
};

Centre centre_of(vec3 x, float depth, vec3 n, float sigma_depth, float normal_slope) {
    precise float per_sigma = 1.0 / max(sigma_depth * depth, 1e-37);
    precise vec3 across = n * per_sigma;
    precise vec3 scaled_n = n * normal_slope;
    return Centre(x, depth, per_sigma, across, scaled_n);
}

// max(0, 1 - d^2), d the difference in depth in sigmas.
float depth_weight(bool plane, Centre c, vec3 position, float depth) {
    precise vec3 to = position - c.x;
    precise float off_plane = c.across.x * to.x + c.across.y * to.y + c.across.z * to.z;
    precise float off_depth = (depth - c.depth) * c.per_sigma;
    float d = plane ? off_plane : off_depth;
    precise float weight = max(0.0, 1.0 - d * d);                             TAP(depth_weight, weight);
    return weight;
}

// max(0, 1 - (1 - n . n_i) / sigma_normal).
float normal_weight(Centre c, vec3 n_i, float offset) {
    precise float cosine = c.scaled_n.x * n_i.x + c.scaled_n.y * n_i.y + c.scaled_n.z * n_i.z;
    precise float weight = max(0.0, cosine + offset);                         TAP(normal_weight, weight);
    return weight;
}
