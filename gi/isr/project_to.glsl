// Where points lie in the coarse image of another view, as in unseen_kernel.h.

struct ViewProjection {
    vec4 eye;
    vec4 to_x;
    vec4 to_y;
    vec4 forward;
    int width;
    int height;
    int margin;
    float least_depth;
};

struct Projected {
    vec2 position;
    float depth;
    bool before;
};

// from_eye: m, from the first eye.
Projected project_to(ViewProjection v, vec3 from_eye) {
    precise vec3 x = from_eye + v.eye.xyz;
    precise float depth = v.forward.x * x.x + v.forward.y * x.y + v.forward.z * x.z;
    float divisor = max(depth, v.least_depth);
    precise float along_x = v.to_x.x * x.x + v.to_x.y * x.y + v.to_x.z * x.z;
    precise float along_y = v.to_y.x * x.x + v.to_y.y * x.y + v.to_y.z * x.z;
    // Far outside is far enough: an index must not overflow.
    precise vec2 position = min(max(vec2(along_x / divisor, along_y / divisor), vec2(-65536.0)), vec2(65536.0));
    return Projected(position, depth, depth >= v.least_depth);
}
