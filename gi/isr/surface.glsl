// Where a coarse pixel's surface is and how much of it a sample stands for, as in surface_kernel.h.

struct SampleUniforms {
    vec4 right;
    vec4 down;
    vec4 of_depth;
    vec4 origin;
    int width;
    int height;
    int source_width;
    int source_height;
    int margin;
    int rings;
    int rotations;
    uint seed;
    int far_rings;
    int published;
    int inverse_matrix;
    int tile;
    float area;
    float least_cosine;
    float full_reach;
    float scale;
    float per_length;
};

const float farthest = 1e15;
const float least_distance2 = 1e-37;

struct Surface {
    vec3 position;
    float depth;
    vec3 normal;
    vec3 ray;
};

bool is_covered(Surface s) {
    precise float n2 = s.normal.x * s.normal.x + s.normal.y * s.normal.y + s.normal.z * s.normal.z;
    return n2 > 0.0;
}

// pixel: of the receivers' grid; outside 0 .. size - 1 in a guard band.
Surface surface_of(SampleUniforms u, ivec2 pixel, vec4 texel) {
    float fx = float(pixel.x), fy = float(pixel.y);
    precise vec3 ray = vec3(u.right.x * fx + u.down.x * fy + u.origin.x,
                            u.right.y * fx + u.down.y * fy + u.origin.y,
                            u.right.z * fx + u.down.z * fy + u.origin.z);
    precise float depth = texel.w;
    if (u.inverse_matrix != 0) {
        // The product of a matrix and (x, y, depth, 1); the division by w.
        ray.x = ray.x + u.of_depth.x * texel.w;
        ray.y = ray.y + u.of_depth.y * texel.w;
        ray.z = ray.z + u.of_depth.z * texel.w;
        precise float w = u.right.w * fx + u.down.w * fy + u.origin.w + u.of_depth.w * texel.w;
        depth = 1.0 / w;
    }
    vec3 n = texel.xyz;
    precise float n2 = n.x * n.x + n.y * n.y + n.z * n.z;
    bool is = n2 > 0.0 && !(depth < 0.0 || depth > farthest);
    float z = is ? depth : 0.0;
    precise vec3 position = vec3(ray.x * z, ray.y * z, ray.z * z);
    return Surface(position, z, is ? n : vec3(0.0), ray);
}

// A_X, m2.
float area_of(SampleUniforms u, Surface s) {
    precise float facing = (u.area * s.depth) * s.depth;
    if (u.published != 0) return facing;
    precise float ray2 = s.ray.x * s.ray.x + s.ray.y * s.ray.y + s.ray.z * s.ray.z;
    precise float least = u.least_cosine * sqrt(ray2);
    precise float cosine = s.normal.x * s.ray.x + s.normal.y * s.ray.y + s.normal.z * s.ray.z;
    precise float area = facing / max(abs(cosine), least);
    return area;
}

// A sample's offset in pixels.
ivec2 offset_of(int packed) { return ivec2((packed << 16) >> 16, packed >> 16); }
