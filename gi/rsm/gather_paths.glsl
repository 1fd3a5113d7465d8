// Twin of paths_kernel.h: the gather along paths with a micro linear buffer for visibility (VRSM 3.2, 3.3). A .comp file
// includes it behind the choice of texels: whole_texels.glsl or continuous_texels.glsl.
layout(local_size_x = 8, local_size_y = 8) in;

struct PathsUniforms {
    Projection map;
    vec4 axis;
    float least_distance2;
    float scale;
    int directions;
    int steps;
    int rotations;
    int tile;
    int width;
    int height;
    uint seed;
    int reach;
    int slots;
    int propagates;
    vec4 texel_area;
    float sample_area;
    float fade;
    float thickness;
};

layout(std140, binding = 0) uniform PathsUniformBlock { PathsUniforms u; };
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit
layout(binding = 3) uniform sampler2D rsm_position;    // xyz world, m
layout(binding = 4) uniform sampler2D rsm_normal;      // xyz unit; w 1 where there is a surface
layout(binding = 5) uniform sampler2D rsm_flux;        // xyz W
layout(std430, binding = 7) readonly buffer Weights { float weights[]; };  // [directions][steps][rotations]
layout(std430, binding = 8) readonly buffer Edges { float edges[]; };      // [slots - 1]
layout(binding = 9, rgba32f) uniform writeonly image2D irradiance_image;

struct MicroLinearBuffer {
    int free;
    int last;
    int last_visible;
};

// Bits: the slots below a sample's own down to that of the lower end of its surface.
int slots_below(vec3 d, vec3 n, float dz, int slot) {
    precise float over = n.x * d.x + n.y * d.y + n.z * d.z;
    // Behind the plane of x it is below 0: the end then lies above the sample, and no slot between.
    precise float depth = min(u.thickness, over);               TAP(depth, depth);
    precise vec3 low = d - u.axis.xyz * depth;
    precise float low_dz = dz - depth;                          TAP(low_dz, low_dz);
    precise float low_height = low_dz * abs(low_dz);
    precise float low_d2 = low.x * low.x + low.y * low.y + low.z * low.z;
    int below = 0;
    for (int i = 0; i + 1 < u.slots; ++i) {
        precise float edge = edges[i] * low_d2;
        bool covered = i < slot && low_height < edge;
        below = covered ? below | 1 << i : below;
    }
    TAP(below, below);
    return below;
}

// The visibility of a sample, 0 or 1.
float visibility_of(vec3 d, vec3 n, bool surface, inout MicroLinearBuffer met) {
    precise float dz = u.axis.x * d.x + u.axis.y * d.y + u.axis.z * d.z;  TAP(dz, dz);
    precise float height = dz * abs(dz);
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    int slot = 0;
    int bit = 1;
    for (int i = 0; i + 1 < u.slots; ++i) {
        precise float edge = edges[i] * d2;
        bool above = height >= edge;
        slot = above ? i + 1 : slot;
        bit = above ? 2 << i : bit;
    }
    TAP(slot, slot);

    // Where there is no surface nothing is met: the sample repeats the one before.
    bit = surface ? bit : met.last;
    int visible = bit == met.last ? met.last_visible : met.free & bit;
    met.free = met.free & ~bit;
    if (u.thickness > 0.0) {
        int below = slots_below(d, n, dz, slot);
        met.free = surface ? met.free & ~below : met.free;
    }
    met.last = bit & u.propagates;
    met.last_visible = visible;
    return visible == 0 ? 0.0 : 1.0;
}

vec3 gather_paths(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    CENTRE centre = centre_of(u.map, x);
    int rotation = int(pixel_hash(uint(pixel.x), uint(pixel.y), 0u, u.seed).x >> 16) & (u.rotations - 1);
    if (u.tile != 0) rotation = tile_place(u.tile, pixel);
    TAP(rotation, rotation);

    float sight = 1.0;
    if (u.map.low >= 0.0) {
        precise float faded = within(centre, u.map) * u.fade;
        sight = min(max(faded, 0.0), 1.0);
    }
    TAP(sight, sight);

    bool near = is_near(centre, u.map.size, u.reach);
    precise vec3 sum = vec3(0.0);
    for (int path = 0; near && path < u.directions; ++path) {
        MicroLinearBuffer met = MicroLinearBuffer(-1, 0, 0);
        for (int step = 0; step < u.steps; ++step) {
            int k = path * u.steps + step;
            TAP_SAMPLE(k);
            ivec2 texel = texel_of(centre, rotation + k * u.rotations);
            TAP(texel, texel);

            // A sample outside the map contributes nothing, and the divisor stays.
            bool inside = texel.x >= 0 && texel.x < u.map.size && texel.y >= 0 && texel.y < u.map.size;
            TAP(inside, inside);
            ivec2 fetched = inside ? texel : ivec2(0);
            vec3 x_p = texelFetch(rsm_position, fetched, 0).xyz;    TAP(x_p, x_p);
            vec4 n_p = texelFetch(rsm_normal, fetched, 0);          TAP(n_p, n_p.xyz);
            vec3 flux = texelFetch(rsm_flux, fetched, 0).xyz;       TAP(flux, flux);
            float weight = inside ? weights[rotation + k * u.rotations] : 0.0;
            TAP(weight, weight);

            float visibility = 1.0;
            precise vec3 d = x_p - x;
            if (u.slots > 0) visibility = visibility_of(d, n, inside && n_p.w > 0.0, met);
            precise float least = 1.0 - sight;
            visibility = max(visibility, least);
            TAP(visibility, visibility);

            float share = 1.0;
            if (u.sample_area > 0.0)
                share = share_of_disc(u.map, u.texel_area, u.sample_area, u.least_distance2, x, x_p, n_p.xyz, weight);
            precise float g = form(x, n, x_p, n_p.xyz, u.least_distance2) * (weight * visibility * share);
            sum.x += flux.x * g;
            sum.y += flux.y * g;
            sum.z += flux.z * g;                                    TAP(sum, sum);
        }
    }
    TAP_SAMPLE(-1);
    precise vec3 irradiance = sum * u.scale;                   TAP(irradiance, irradiance);
    return irradiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(irradiance_image, pixel, vec4(gather_paths(pixel), 0.0));
}
