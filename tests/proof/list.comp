#version 450
// Twin of ListKernel (stages.h): what each receiver of a list gathers from the senders that it names, into a buffer.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform ListUniforms {
    int width;    // receivers
    int height;   // 1
    int senders;
    int links;    // of each receiver
    float scale;
} u;
layout(std430, binding = 1) readonly buffer Positions { float positions[]; };
layout(std430, binding = 2) readonly buffer Links { int links[]; };
layout(std430, binding = 3) readonly buffer Radiosity { vec4 radiosity[]; };  // w: where it is sent from
layout(std430, binding = 4) writeonly buffer Gathered { vec4 gathered[]; };

vec4 gather(int receiver) {
    float x = positions[receiver];
    precise vec3 sum = vec3(0.0);
    for (int k = 0; k < u.links; ++k) {
        vec4 b = radiosity[min(links[receiver * u.links + k], u.senders - 1)];
        precise float d = (x - b.w) * (x - b.w) + 1.0;
        precise float w = u.scale / d;
        sum = vec3(sum.x + w * b.x, sum.y + w * b.y, sum.z + w * b.z);
    }
    return vec4(sum, x);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= u.width || at.y >= u.height) return;
    gathered[at.x] = gather(at.x);
}
