// What volume.comp and relief.comp share, twin of volume_kernel.h: irradiance towards a direction from those of six.

// Along one axis: the places before and behind x, and how far behind the first it is, in cells.
struct GridCell {
    int first;
    int next;
    float share;
};
GridCell grid_cell(float x, float origin, float spacing, int count) {
    precise float cells = min(max((x - origin) / spacing, 0.0), float(count - 1));
    CHOICE(int(floor(cells)));
    int first = max(0, min(int(floor(cells)), count - 1));
    precise float share = cells - float(first);
    return GridCell(first, min(first + 1, count - 1), share);
}

struct SixSides {
    vec3 x_plus;
    vec3 x_minus;
    vec3 y_plus;
    vec3 y_minus;
    vec3 z_plus;
    vec3 z_minus;
};

// w(d, n) = 1 - 2 acos(max(0, c)) / pi, c = d . n. acos by Abramowitz and Stegun 4.4.46, to 2e-8, whose sqrt(1 - c) is taken as
// |d x n| / sqrt(1 + c): where both are nearly the same direction, 1 - c has no digits left. s2 = |d x n|^2.
float angle_weight(float c, float s2) {
    precise float x = min(max(c, 0.0), 1.0);
    precise float p = -0.0012624911 * x + 0.0066700901;
    p = p * x + -0.0170881256;
    p = p * x + 0.0308918810;
    p = p * x + -0.0501743046;
    p = p * x + 0.0889789874;
    p = p * x + -0.2145988016;
    p = p * x + 1.5707963050;
    precise float w = 1.0 - 0.636619772 * (sqrt(s2 / (1.0 + x)) * p);
    return c > 0.0 ? w : 0.0;
}

// What the two sides of an axis count for: x plus, y minus.
vec2 side_weights(int form, float c, float s2) {
    precise float squared = c * c;
    if (form == 1) {
        precise vec2 linear = vec2(0.5 * (squared + c), 0.5 * (squared - c));
        return linear;
    }
    if (form == 2) return vec2(angle_weight(c, s2), angle_weight(-c, s2));
    return c > 0.0 ? vec2(squared, 0.0) : vec2(0.0, squared);
}

// E(n), by the form.
vec3 irradiance_towards(int form, SixSides e, vec3 n) {
    precise vec3 s2 = vec3(n.y * n.y + n.z * n.z, n.x * n.x + n.z * n.z, n.x * n.x + n.y * n.y);
    vec2 x = side_weights(form, n.x, s2.x);
    vec2 y = side_weights(form, n.y, s2.y);
    vec2 z = side_weights(form, n.z, s2.z);
    precise vec3 sum = ((x.x * e.x_plus + x.y * e.x_minus) + (y.x * e.y_plus + y.y * e.y_minus)) + (z.x * e.z_plus + z.y * e.z_minus);
    return max(sum, vec3(0.0));
}

float channels(vec3 e) {
    precise float sum = e.x + e.y + e.z;
    return max(sum, 0.0);
}
// The light vector of a point with normal n; n where there is no light.
vec3 light_vector(int form, float least, SixSides e, vec3 n) {
    vec2 x = vec2(channels(e.x_plus), channels(e.x_minus));
    vec2 y = vec2(channels(e.y_plus), channels(e.y_minus));
    vec2 z = vec2(channels(e.z_plus), channels(e.z_minus));
    precise float sum = ((x.x + x.y) + (y.x + y.y)) + (z.x + z.y);
    TAP(S, sum);
    precise float scale = 1.0 / max(sum, 1e-30);
    precise vec3 v = vec3(0.0);
    if (form == 2) {
        precise vec3 s2 = vec3(n.y * n.y + n.z * n.z, n.x * n.x + n.z * n.z, n.x * n.x + n.y * n.y);
        vec2 wx = side_weights(2, n.x, s2.x);
        vec2 wy = side_weights(2, n.y, s2.y);
        vec2 wz = side_weights(2, n.z, s2.z);
        v = vec3((wx.x * x.x - wx.y * x.y) * scale, (wy.x * y.x - wy.y * y.y) * scale, (wz.x * z.x - wz.y * z.y) * scale);
    } else {
        precise vec3 d = vec3((x.x - x.y) * scale, (y.x - y.y) * scale, (z.x - z.y) * scale);
        TAP(D, d);
        precise float along = least + max(-(n.x * d.x + n.y * d.y + n.z * d.z), 0.0);
        TAP(along, along);
        v = vec3(d.x + along * n.x, d.y + along * n.y, d.z + along * n.z);
    }
    TAP(V, v);
    precise float squared = v.x * v.x + v.y * v.y + v.z * v.z;
    bool is = squared > 1e-12;
    precise float len = sqrt(is ? squared : 1.0);
    precise vec3 l = vec3(v.x / len, v.y / len, v.z / len);
    return is ? l : n;
}
