#version 450
// An item buffer (HEM 4.5.3): which triangle is seen, and where in it. What visibility.h writes.

layout(location = 0) flat in int triangle;
layout(location = 1) in vec2 barycentrics;

layout(location = 0) out int item;
layout(location = 1) out vec2 place;  // l1, l2

void main() {
    item = triangle;
    place = barycentrics;
}
