// Real spherical harmonics to degree 7: the twin of add_harmonic() in core/sh_kernel.h.
//
// Before it is included, SH_RECURRENCE names the buffer: rise[l][m] at 8 l + m, then fall[l][m].
#ifndef PLUMB_SH_GLSL
#define PLUMB_SH_GLSL

// sum + weight Y_lm(d). m: |m|; sine: whether m < 0.
float add_harmonic(int l, int m, bool sine, vec3 d, float weight, float sum) {
    // weight (x + i y)^m
    precise float c = weight;
    precise float s = 0.0;
    for (int k = 0; k < m; ++k) {
        precise float next = c * d.x - s * d.y;
        s = c * d.y + s * d.x;
        c = next;
    }
    precise float p = SH_RECURRENCE[9 * m];
    precise float before = 0.0;
    for (int k = m + 1; k <= l; ++k) {
        precise float next = SH_RECURRENCE[8 * k + m] * (d.z * p - SH_RECURRENCE[64 + 8 * k + m] * before);
        before = p;
        p = next;
    }
    precise float added = sum + p * (sine ? s : c);
    return added;
}

#endif
