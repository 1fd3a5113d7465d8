#version 450
// Which triangle a pixel sees, and where in it, for `plumb probe-device`.

layout(location = 0) flat in int triangle;
layout(location = 1) in vec2 barycentrics;

layout(location = 0) out int item;    // 1 + the number of the triangle; 0 where the target was cleared
layout(location = 1) out vec2 place;  // l1, l2

void main() {
    item = triangle + 1;
    place = barycentrics;
}
