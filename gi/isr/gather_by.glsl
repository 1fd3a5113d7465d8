// The sum over a pixel's samples, as in gather_kernel.h. source_at(pixel, rotation, k, p), which is declared before, reads one.

// F_pX.
float form_factor(vec3 n_p, Source x) {
    vec3 d = x.to;
    precise float d2 = max(d.x * d.x + d.y * d.y + d.z * d.z, least_distance2);    TAP(d2, d2);
    precise float cos_p = max(0.0, n_p.x * d.x + n_p.y * d.y + n_p.z * d.z);       TAP(cos_p, cos_p);
    precise float cos_x = max(0.0, -(x.normal.x * d.x + x.normal.y * d.y + x.normal.z * d.z));
    TAP(cos_x, cos_x);
    if (u.published == 3) {
        precise float seen = cos_x > 0.0 ? cos_p / sqrt(d2) : 0.0;
        precise float share = seen * 0.318309886;                 TAP(form, share);
        return share;
    }
    precise float cosines = cos_p * (1.0 / d2) * cos_x;
    precise float pi_d2 = 3.14159265 * d2;
    precise float divisor = u.published != 0 ? pi_d2 : pi_d2 + x.area;
    precise float form = cosines * (x.area / divisor);                             TAP(form, form);
    return form;
}

vec4 gather_by(Surface p, vec4 before, float mask, ivec2 pixel, int rotation) {
    bool covered = is_covered(p);
    bool published = u.published != 0;
    float largest = published ? 1.0 : max(1.0, before.w);
    precise vec3 started = vec3(before.x * largest, before.y * largest, before.z * largest);
    precise vec3 sum = published ? vec3(0.0) : started;
    precise float forms = before.w;
    int k = 0;
    for (int ring = 1; ring <= u.rings; ++ring) {
        // ISR chapter 6: fewer samples for pixels far away.
        float reach = ring <= u.far_rings ? 3.4e38 : u.full_reach;
        precise float at_ring = float(ring) * p.depth;
        if (!(covered && at_ring <= reach)) break;
        for (int i = 0; i < 8 * ring; ++i, ++k) {
            TAP_SAMPLE(k);
            Source x = source_at(pixel, rotation, k, p);
            TAP(d, x.to);
            TAP(n_x, x.normal);
            TAP(area, x.area);
            TAP(radiosity, x.radiosity);
            precise float form = x.weight * form_factor(p.normal, x);
            sum.x += form * x.radiosity.x;
            sum.y += form * x.radiosity.y;
            sum.z += form * x.radiosity.z;
            forms += form;                                        TAP(forms, forms);
        }
    }
    TAP_SAMPLE(-1);
    // N of (25) is of the samples that the pixel has: with fewer far away fewer than 4 k (k + 1).
    precise float fewer = float(4 * u.rings * (u.rings + 1)) / max(float(k), 1.0);
    precise float scaled = u.scale * fewer;
    precise float by_mask = mask * (u.published == 2 ? u.scale : scaled);
    precise float by_forms = 1.0 / max(1.0, forms);
    float share = published ? by_mask : by_forms;
    precise vec3 light = sum * share;
    if (published) light = light + before.xyz;
    vec3 irradiance = covered ? light : vec3(0.0);                TAP(irradiance, irradiance);
    return vec4(irradiance, covered ? forms : 0.0);
}
