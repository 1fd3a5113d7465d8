// One block of results for each operation, in the order of operations() in tools/vulkan/probe_operations.cpp.

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) readonly buffer Inputs { vec4 inputs[]; };     // [operation][row][column]
layout(std430, binding = 1) writeonly buffer Results { uint results[]; };  // bits, [operation][row][column]

const uint columns = 256;

uint this_input() {
    return gl_GlobalInvocationID.y * columns + gl_GlobalInvocationID.x;
}
uint inputs_of_each() {
    return gl_NumWorkGroups.x * gl_NumWorkGroups.y * 64u;
}

#define PROBE_BITS(operation, bits)                                                  \
    {                                                                                \
        uint at = operation * count + i;                                             \
        float a = inputs[at].x, b = inputs[at].y, c = inputs[at].z, d = inputs[at].w; \
        results[at] = bits;                                                          \
    }
#define PROBE(operation, value) PROBE_BITS(operation, floatBitsToUint(value))
#define PROBE_PRECISE(operation, value)                                              \
    {                                                                                \
        uint at = operation * count + i;                                             \
        float a = inputs[at].x, b = inputs[at].y, c = inputs[at].z;                  \
        precise float r = value;                                                     \
        results[at] = floatBitsToUint(r);                                            \
    }
