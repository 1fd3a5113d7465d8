// Twin of gather_kernel.h, gather_disc(): one-bounce indirect irradiance from a reflective shadow map. A .comp file
// includes it behind the choice of texels: whole_texels.glsl or continuous_texels.glsl.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std140, binding = 0) uniform GatherUniformBlock { GatherUniforms u; };
layout(binding = 1) uniform sampler2D position_image;  // xyz world, m
layout(binding = 2) uniform sampler2D normal_image;    // xyz unit
layout(binding = 3) uniform sampler2D rsm_position;    // xyz world, m
layout(binding = 4) uniform sampler2D rsm_normal;      // xyz unit
layout(binding = 5) uniform sampler2D rsm_flux;        // xyz W
layout(std430, binding = 7) readonly buffer Weights { float weights[]; };  // [samples]
layout(binding = 8, rgba32f) uniform writeonly image2D irradiance_image;

// The disc gather (Dachsbacher and Stamminger 2005; LRA 4.3.3).
vec3 gather_disc(ivec2 pixel) {
    vec3 x = texelFetch(position_image, pixel, 0).xyz;          TAP(x, x);
    vec3 n = texelFetch(normal_image, pixel, 0).xyz;            TAP(n, n);
    CENTRE centre = centre_of(u.map, x);
    uint hash = pixel_hash(uint(pixel.x), uint(pixel.y), 0u, u.seed).x;
    int rotation = u.tile != 0 ? tile_place(u.tile, pixel) : int(hash >> 16) & (u.rotations - 1);
    TAP(rotation, rotation);

    bool near = is_near(centre, u.map.size, u.reach);
    precise vec3 sum = vec3(0.0);
    for (int k = 0; near && k < u.samples; ++k) {
        TAP_SAMPLE(k);
        ivec2 texel = texel_of(centre, rotation + k * u.rotations);
        TAP(texel, texel);

        // A sample outside the map contributes nothing, and the divisor stays.
        bool inside = texel.x >= 0 && texel.x < u.map.size && texel.y >= 0 && texel.y < u.map.size;
        TAP(inside, inside);
        ivec2 fetched = inside ? texel : ivec2(0);
        vec3 x_p = texelFetch(rsm_position, fetched, 0).xyz;    TAP(x_p, x_p);
        vec3 n_p = texelFetch(rsm_normal, fetched, 0).xyz;      TAP(n_p, n_p);
        vec3 flux = texelFetch(rsm_flux, fetched, 0).xyz;       TAP(flux, flux);
        float weight = inside ? weights[k] : 0.0;                       TAP(weight, weight);

        float share = 1.0;
        if (u.sample_area > 0.0)
            share = share_of_disc(u.map, u.texel_area, u.sample_area, u.least_distance2, x, x_p, n_p, weight);
        precise float g = form(x, n, x_p, n_p, u.least_distance2) * (weight * share);
        sum.x += flux.x * g;
        sum.y += flux.y * g;
        sum.z += flux.z * g;                                    TAP(sum, sum);
    }
    TAP_SAMPLE(-1);
    precise vec3 irradiance = sum * u.scale;                   TAP(irradiance, irradiance);
    return irradiance;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= u.width || pixel.y >= u.height) return;
    TAP_BEGIN(pixel, 0);
    imageStore(irradiance_image, pixel, vec4(gather_disc(pixel), 0.0));
}
