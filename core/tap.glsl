// What a twin says about itself besides its result: the twin of core/tap.h. Compiled as it is, all of it is nothing.
//
//     TAP(name, value)       a named value, where the kernel says tap("name", value, ...)
//     TAP_SAMPLE(k)          tap.sample(k)
//     TAP_OFF  TAP_ON        around calls that the kernel gives a NoTap
//     TAP_BEGIN(pixel, run)  first in main(): this invocation's pixel, and its triangle (0 in a compute stage)
//     CHOICE(index)          a discrete choice of this pixel
//
// With PLUMB_TAPS the invocations at one pixel write their values to a buffer: each TAP() that is left in the
// preprocessed text becomes tap_value(number of the site, value) (tools/twins/number_taps.cpp). With PLUMB_CHOICES every
// invocation stores its choices, so that a reference can follow them. Neither changes an operation of the twin.
#ifndef PLUMB_TAP_GLSL
#define PLUMB_TAP_GLSL

#ifdef PLUMB_TAPS

struct Tap {
    int site;
    int sample_index;  // -1: not part of a loop over samples
    int components;
    int run;           // several triangles may be drawn at one pixel
    vec4 value;        // integers as floats
};
layout(std430, binding = 31) buffer Taps {
    int tap_x;
    int tap_y;
    int tap_capacity;
    int tap_count;  // may exceed the capacity: then some are missing
    Tap taps[];
};

int tap_current = -1;
int tap_run = 0;
int tap_muted = 1;  // so that nothing is written before TAP_BEGIN()

void tap_write(int site, int components, vec4 value) {
    if (tap_muted > 0) return;
    int at = atomicAdd(tap_count, 1);
    if (at < tap_capacity) taps[at] = Tap(site, tap_current, components, tap_run, value);
}
void tap_value(int site, float v) { tap_write(site, 1, vec4(v, 0.0, 0.0, 0.0)); }
void tap_value(int site, int v) { tap_write(site, 1, vec4(float(v), 0.0, 0.0, 0.0)); }
void tap_value(int site, bool v) { tap_write(site, 1, vec4(v ? 1.0 : 0.0, 0.0, 0.0, 0.0)); }
void tap_value(int site, vec2 v) { tap_write(site, 2, vec4(v, 0.0, 0.0)); }
void tap_value(int site, vec3 v) { tap_write(site, 3, vec4(v, 0.0)); }
void tap_value(int site, vec4 v) { tap_write(site, 4, v); }
void tap_value(int site, ivec2 v) { tap_write(site, 2, vec4(vec2(v), 0.0, 0.0)); }

#define TAP_SAMPLE(k) tap_current = (k)
#define TAP_OFF ++tap_muted
#define TAP_ON --tap_muted
#define TAP_BEGIN_TAPS(pixel, run) tap_muted = (pixel) == ivec2(tap_x, tap_y) ? 0 : 1, tap_run = (run);

#else

#define TAP(name, value)
#define TAP_SAMPLE(k)
#define TAP_OFF
#define TAP_ON
#define TAP_BEGIN_TAPS(pixel, run)

#endif

#ifdef PLUMB_CHOICES

layout(std430, binding = 30) buffer Choices {
    int choices_width;  // pixels
    int choices_per_pixel;
    int choices[];      // [height][width][choices_per_pixel]
};

int choice_at = 0;
int choice_end = 0;

void choose(int index) {
    if (choice_at < choice_end) choices[choice_at] = index;
    ++choice_at;
}

#define CHOICE(index) choose(index)
#define TAP_BEGIN_CHOICES(pixel)                                             \
    choice_at = ((pixel).y * choices_width + (pixel).x) * choices_per_pixel, \
    choice_end = choice_at + choices_per_pixel;

#else

#define CHOICE(index)
#define TAP_BEGIN_CHOICES(pixel)

#endif

#define TAP_BEGIN(pixel, run) TAP_BEGIN_TAPS(pixel, run) TAP_BEGIN_CHOICES(pixel)

#endif
