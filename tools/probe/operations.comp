#version 450
// Single operations over hashed inputs, for `plumb probe-device`. Nothing is `precise` unless it says so: what a driver
// does when it is free to is part of the answer.

#extension GL_GOOGLE_include_directive : require
#include "tools/probe/operations.glsl"

void main() {
    uint i = this_input(), count = inputs_of_each();
    PROBE(0u, a + b)
    PROBE(1u, a - b)
    PROBE(2u, a * b)
    PROBE(3u, a / b)
    PROBE(4u, 1.0 / a)
    PROBE(5u, sqrt(a))
    PROBE(6u, inversesqrt(a))
    PROBE(7u, fma(a, b, c))
    PROBE(8u, a * b + c)
    PROBE_PRECISE(9u, a * b + c)
    PROBE(10u, (a + 0.1) + 0.2)
    PROBE_PRECISE(11u, (a + 0.1) + 0.2)
    PROBE(12u, min(a, b))
    PROBE(13u, max(a, b))
    PROBE(14u, floor(a))
    PROBE(15u, float(int(floor(a))))
    PROBE(16u, float(floatBitsToUint(a)))
    PROBE(17u, mix(a, b, c))
    PROBE(18u, smoothstep(a, b, c))
    PROBE(19u, length(vec3(a, b, c)))
    PROBE(20u, normalize(vec3(a, b, c)).x)
    PROBE(21u, dot(vec3(a, b, c), vec3(b, c, d)))
    PROBE(22u, dot(vec4(a, b, c, d), vec4(d, a, b, c)))
    // Absolute values, so that no two products have a factor in common that a compiler could take out.
    PROBE(23u, (mat4(abs(b), 0, 0, 0, abs(c), 0, 0, 0, abs(d), 0, 0, 0, abs(a), 0, 0, 0) * vec4(a, b, c, d)).x)
    PROBE(24u, exp2(a))
    PROBE(25u, exp(a))
    PROBE(26u, log2(a))
    PROBE(27u, log(a))
    PROBE(28u, pow(a, b))
    PROBE(29u, sin(a))
    PROBE(30u, cos(a))
    PROBE(31u, acos(a))
    PROBE(32u, atan(a))
    PROBE(33u, unpackUnorm4x8(floatBitsToUint(a)).x)
}
