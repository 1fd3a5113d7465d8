// How a view sees, as in view_kernel.h.

struct SeenFrom {
    vec4 anchor;
    vec4 forward;
    vec4 to_x;
    vec4 to_y;
    int width;
    int height;
    float least_depth;
    float perspective;
};
