#version 450

layout(location = 0) flat in float number;
layout(location = 0) out float visible;  // 1 + the number of the triangle; 0 where the target was cleared

void main() { visible = number + 1.0; }
