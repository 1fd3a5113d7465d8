#version 450
// One function for each way in which a generic mutant is wrong: test_generic_mutants.cpp counts its sites.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform Block { int turns; float gain; };
layout(binding = 1) uniform sampler2D texels;
layout(std430, binding = 2) readonly buffer Numbers { float numbers[]; };
layout(binding = 3, rgba32f) uniform writeonly image2D result;

float sum_of(float a, float b) { return a + b; }
float difference_of(float a, float b) { return a - b; }
float product_of(float a, float b) { return a * b; }
float square_of(float a) { return a * a; }
float quotient_of(float a, float b) { return a / b; }
float unit_of(float a, float b) { return a / sqrt(b); }
float larger_of(float a, float b) { return max(a, b); }
float saturated(float a) { return min(max(a, 0.0), 1.0); }
float not_negative(float a) { return max(0.0, a); }
float size_of(float a) { return abs(a); }
float doubled(float a) { return 2.0 * a; }
int next_of(int a) { return a + 1; }
bool is_less(int a, int b) { return a < b; }
bool is_smaller(float a, float b) { return a < b; }
bool is_positive(float a) { return a > 0.0; }
bool is_same(int a, int b) { return a == b; }
bool are_both(bool a, bool b) { return a && b; }
vec2 turned(vec2 v) { return v.yx; }
float second_of(vec3 v) { return v.y; }
float element(int i) { return numbers[i]; }
vec4 texel_at(ivec2 p) { return texelFetch(texels, p, 0); }
float gain_of() { return gain; }
float summed(int n) {
    float sum = 0.0;
    for (int i = 0; i < n; i += n) sum = gain;
    return sum;
}
bool either(ivec2 p, int n) {
    bool ends = p.x < n || summed(n) == gain_of();
    return ends;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    float a = sum_of(element(p.x), gain_of()) + difference_of(summed(turns), product_of(second_of(texel_at(p).xyz), square_of(gain)));
    float b = quotient_of(a, unit_of(a, larger_of(saturated(a), not_negative(size_of(doubled(a))))));
    bool c = are_both(is_less(next_of(p.x), p.y), is_smaller(a, b)) != are_both(is_positive(a), is_same(p.x, p.y));
    imageStore(result, p, vec4(turned(vec2(a, b)), c ? 1.0 : 0.0, either(p, turns) ? 1.0 : 0.0));
}
