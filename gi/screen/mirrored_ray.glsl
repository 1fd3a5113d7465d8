// The ray of which a mirror makes the ray to the eye, as in mirrored_ray_kernel.h.

struct MirroredRay {
    vec3 p;
    vec3 n;
    vec3 r;
    vec3 from_anchor;
    float cosine;
};

// w: from the eye to p, of any length.
MirroredRay mirrored_ray(vec3 p, vec3 n, vec3 w, vec3 anchor) {
    precise float length2 = w.x * w.x + w.y * w.y + w.z * w.z;
    precise float inverse = 1.0 / sqrt(max(length2, 1e-37));
    precise vec3 v = w * inverse;                                 TAP(v, v);
    precise float cosine = n.x * v.x + n.y * v.y + n.z * v.z;     TAP(cosine, cosine);
    precise float twice = cosine + cosine;
    precise vec3 r = v - n * twice;                               TAP(r, r);
    precise vec3 from_anchor = p - anchor;
    return MirroredRay(p, n, r, from_anchor, cosine);
}

// Takes the ray that screen.lobe has drawn in place of the mirrored one. Returns whether there is one.
bool take_drawn(vec4 drawn, inout MirroredRay ray) {
    ray.r = drawn.xyz;                                            TAP(drawn, ray.r);
    return drawn.w > 0.0;
}

// Whether the ray may meet the surface point q.
bool may_be_met(MirroredRay ray, vec3 q, vec3 n_q, float bias) {
    precise vec3 to_q = q - ray.p;
    precise float rise = to_q.x * ray.n.x + to_q.y * ray.n.y + to_q.z * ray.n.z;
    TAP(rise, rise);
    precise float facing = n_q.x * ray.r.x + n_q.y * ray.r.y + n_q.z * ray.r.z;
    TAP(facing, facing);
    return rise > bias && facing < 0.0;
}

struct Crossing {
    float t;
    ivec2 texel;
    float behind;
    bool found;
};

// The hit that stands.
vec4 nearer_hit(vec4 before, Crossing c, int number) {
    TAP(error, c.behind);
    bool found = c.found && (before.w == 0.0 || c.t < before.z);
    vec4 hit = found ? vec4(vec2(c.texel), c.t, float(number)) : before;
    TAP(hit, hit.xyz);
    TAP(view, hit.w);
    return hit;
}
