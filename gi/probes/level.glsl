// Levels of detail of points, as in level_kernel.h.

// How far from_eye counts, for all within radius of it.
float zone_scale(vec3 v, float radius, vec3 axis, vec4 zones, vec4 scales) {
    precise float along = v.x * axis.x + v.y * axis.y + v.z * axis.z;
    precise vec3 across = vec3(v.x - along * axis.x, v.y - along * axis.y, v.z - along * axis.z);
    precise float aside = sqrt(across.x * across.x + across.y * across.y + across.z * across.z);
    precise float beyond_front = aside * zones.x - along * zones.y;
    precise float beyond_side = aside * zones.z - along * zones.w;
    return beyond_front <= radius ? scales.x : beyond_side <= radius ? scales.y : scales.z;
}

// Of a point: its distance from the eye, scaled.
float point_distance(vec3 point, vec3 eye, vec3 axis, vec4 zones, vec4 scales) {
    precise vec3 v = vec3(point.x - eye.x, point.y - eye.y, point.z - eye.z);
    precise float d = sqrt(v.x * v.x + v.y * v.y + v.z * v.z) * zone_scale(v, 0.0, axis, zones, scales);
    return d;
}

// d: the scaled distance that each boundary is held against; of a point three times the same.
int level_of(vec3 d, vec4 distances, int levels) {
    int first = distances.x <= d.x ? 1 : 0;
    int second = distances.y <= d.y ? 2 : first;
    int third = distances.z <= d.z ? 3 : second;
    return min(third, levels - 1);
}

// The share of the next coarser level; 0 in the last one, and where widths are 0.
float blend_of(float d, int level, vec4 distances, vec4 widths, int levels) {
    float boundary = level < 1 ? distances.x : level < 2 ? distances.y : distances.z;
    float width = level < 1 ? widths.x : level < 2 ? widths.y : widths.z;
    precise float left = boundary - d;
    bool blends = left < width && level < levels - 1;
    precise float share = 1.0 - left / max(width, 1e-18);
    return blends ? share : 0.0;
}
