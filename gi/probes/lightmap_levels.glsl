// Twin of lightmap_kernel.h: levels of the lightmap in one strip, and the bilinear lookup.

struct LightmapLevel {
    int first;    // row of the strip
    int side;     // texels
    float scale;  // 2^-k
};
LightmapLevel lightmap_level(int side, int levels, int level) {
    LightmapLevel of = LightmapLevel(0, side, 1.0);
    int first = 0;
    int texels = side;
    precise float scale = 1.0;
    for (int k = 1; k < levels; ++k) {
        first = first + texels + 2;
        texels = (texels + 1) >> 1;
        scale = scale * 0.5;
        if (level >= k) of = LightmapLevel(first, texels, scale);
    }
    return of;
}

vec3 mixed(vec3 a, vec3 b, float share) {
    precise vec3 value = a + share * (b - a);
    return value;
}

// Bilinear, x then y: xyz of the four texels around uv.
vec3 lightmap_at(sampler2D strip, int side, int levels, vec2 uv, int level) {
    LightmapLevel k = lightmap_level(side, levels, level);        TAP(lightmap_first, k.first);
    int last = k.side - 1;
    float most = float(last);
    precise vec2 place = (uv * float(side) - 0.5) * k.scale;
    place = min(max(place, vec2(0.0)), vec2(most));               TAP(lightmap_place, place);
    CHOICE(int(floor(place.x)));
    CHOICE(int(floor(place.y)));
    ivec2 first = max(ivec2(0), min(ivec2(floor(place)), ivec2(last)));
    ivec2 next = min(first + 1, ivec2(last));
    precise vec2 share = vec2(place.x - float(first.x), place.y - float(first.y));
    TAP(lightmap_share, share);
    int row = k.first + first.y;
    int below = k.first + next.y;
    vec3 upper = mixed(texelFetch(strip, ivec2(first.x, row), 0).xyz, texelFetch(strip, ivec2(next.x, row), 0).xyz, share.x);
    vec3 lower = mixed(texelFetch(strip, ivec2(first.x, below), 0).xyz, texelFetch(strip, ivec2(next.x, below), 0).xyz, share.x);
    vec3 value = mixed(upper, lower, share.y);                    TAP(looked_up, value);
    return value;
}
