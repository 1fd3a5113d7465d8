#version 450
// Halves packed and unpacked, for `plumb probe-device`: apart from other operations, since there is a driver that no
// program survives which asks for them.
#extension GL_GOOGLE_include_directive : require
#include "tools/probe/operations.glsl"

void main() {
    uint i = this_input(), count = inputs_of_each();
    PROBE_BITS(34u, packHalf2x16(vec2(a, b)))
    PROBE(35u, unpackHalf2x16(floatBitsToUint(a)).x)
}
