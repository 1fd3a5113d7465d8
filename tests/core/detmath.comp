// Twin of detmath_batch_isa.cpp: core/detmath.glsl applied to arrays.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "core/detmath.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) readonly buffer X { float x[]; };
layout(std430, set = 0, binding = 1) readonly buffer Y { float y[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Result { float result[]; };

// The number of the function in Elementary (detmath_batch.h).
layout(push_constant) uniform Push { int elementary; };

float evaluate(float a, float b) {
    switch (elementary) {
        case 0: return det_exp(a);
        case 1: return det_exp2(a);
        case 2: return det_log(a);
        case 3: return det_log2(a);
        case 4: return det_sin(a);
        case 5: return det_cos(a);
        case 6: return det_acos(a);
        case 7: return det_pow(a, b);
        default: return det_expm1(a);
    }
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < result.length()) result[i] = evaluate(x[i], y[i]);
}
