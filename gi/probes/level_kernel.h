// Which level of detail a box, a probe or a point has (IPR 4.2, figures 4.4, 4.7, 4.8): the algorithm that level.comp and
// level.glsl mirror line by line.
//
//     level = the number of boundaries k with distance_k <= scale max(0, |box - eye| - margin m_k), at most levels - 1
//     scale = that of the nearest zone about the view direction which the box may meet: front, side, behind
//     share = 1 - (distance_k - d) / width_k where d is that near its boundary: what a fragment takes of the next level (4.2.4)
//
// Of a box grown by its margin no point has a smaller distance, in floats either: gaps, squares, sums and roots are rounded the
// same way, and rounding keeps order. A zone is asked with a margin of 1e-5 for what rounding may do. So whatever lies in the box
// has the box's level or a coarser one.
//
// differs: figure 4.8 prints neither zones nor their distances. Zones are two cones about the view direction; beyond each distances
// count for more. levels of a list are whole numbers; the thesis compares in each shader again.
#pragma once

#include "gi/probes/supports_kernel.h"

namespace plumb::probes {

// How far `from_eye` counts, for all within `radius` of it: scales = of the front, the side and the back, ascending; zones =
// cosine and sine of the front's half angle, and of the side's.
template <class F>
PLUMB_INLINE F zone_scale(const vec3<F>& from_eye, F radius, const float* forward, const float* zones, const float* scales) {
    const vec3<F> axis{F(forward[0]), F(forward[1]), F(forward[2])};
    const F along = dot3(from_eye, axis);
    const vec3<F> across{from_eye.x - along * axis.x, from_eye.y - along * axis.y, from_eye.z - along * axis.z};
    const F aside = sqrt(dot3(across, across));
    // The distance from each cone, negative inside of it; of what lies before its apex an upper bound of minus that.
    const F beyond_front = aside * F(zones[0]) - along * F(zones[1]);
    const F beyond_side = aside * F(zones[2]) - along * F(zones[3]);
    return select(beyond_front <= radius, F(scales[0]), select(beyond_side <= radius, F(scales[1]), F(scales[2])));
}

// Of a point: its distance from the eye, scaled.
template <class F>
PLUMB_INLINE F point_distance(const vec3<F>& point, const float* eye, const float* forward, const float* zones,
                              const float* scales) {
    const vec3<F> v{point.x - F(eye[0]), point.y - F(eye[1]), point.z - F(eye[2])};
    return sqrt(dot3(v, v)) * zone_scale<F>(v, F(0.0f), forward, zones, scales);
}

// d: the scaled distance that each boundary is held against; of a point three times the same. distances ascend.
template <class F>
PLUMB_INLINE index_t<F> level_of(const vec3<F>& d, const float* distances, int levels) {
    using I = index_t<F>;
    const I first = select(F(distances[0]) <= d.x, I(1), I(0));
    const I second = select(F(distances[1]) <= d.y, I(2), first);
    const I third = select(F(distances[2]) <= d.z, I(3), second);
    return min(third, I(levels - 1));
}

// The share of the next coarser level; 0 in the last one, and where widths are 0.
template <class F>
PLUMB_INLINE F blend_of(F d, index_t<F> level, const float* distances, const float* widths, int levels) {
    using I = index_t<F>;
    const F boundary = select(level < I(1), F(distances[0]), select(level < I(2), F(distances[1]), F(distances[2])));
    const F width = select(level < I(1), F(widths[0]), select(level < I(2), F(widths[1]), F(widths[2])));
    const F left = boundary - d;
    const mask_t<F> blends = (left < width) & (level < I(levels - 1));
    return select(blends, F(1.0f) - left / max(width, F(1e-18f)), F(0.0f));
}

// The twin's uniform block (std140).
struct LevelUniforms {
    std::int32_t width, height;  // of the domain: the list, folded to rows
    std::int32_t count;          // boxes
    std::int32_t levels;         // 1..4
    float eye[4];                // xyz m
    float forward[4];            // xyz unit
    float zones[4];              // cosine, sine of the front's half angle; of the side's
    float scales[4];             // xyz: front, side, behind
    float distances[4];          // xyz m: where levels 1, 2, 3 begin
    float margins[4];            // xyz: what a box's margin is multiplied by at each of them, ascending
};
static_assert(sizeof(LevelUniforms) == 112);

struct LevelView {
    LevelUniforms u;
    const float* low;     // [count][4]: xyz m; w the margin, m
    const float* high;    // [count][4]: xyz m
    std::int32_t* level;  // out: [height][width]
};

template <class F>
struct Level {
    index_t<F> level;
    template <class Each>
    void components(Each each) const {
        each(number<F>::from_index(level));
    }
};

template <class F, class Tap>
PLUMB_INLINE Level<F> level_of_box(const LevelView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const LevelUniforms& u = in.u;
    const I i = min(py * I(u.width) + px, I(u.count - 1));
    const vec4<F> low = N::fetch4(in.low, i), high = N::fetch4(in.high, i);
    const vec3<F> from{low.x - F(u.eye[0]), low.y - F(u.eye[1]), low.z - F(u.eye[2])};
    const vec3<F> to{high.x - F(u.eye[0]), high.y - F(u.eye[1]), high.z - F(u.eye[2])};
    tap("low", from, "of the box, from the eye, m"), tap("high", to, "of the box, from the eye, m");
    const vec3<F> gap{max(max(from.x, F(0.0f) - to.x), F(0.0f)), max(max(from.y, F(0.0f) - to.y), F(0.0f)),
                      max(max(from.z, F(0.0f) - to.z), F(0.0f))};
    const F distance = sqrt(dot3(gap, gap));                      tap("distance", distance, "of the box's nearest point, m");
    const vec3<F> centre{F(0.5f) * (from.x + to.x), F(0.5f) * (from.y + to.y), F(0.5f) * (from.z + to.z)};
    const vec3<F> half{to.x - centre.x, to.y - centre.y, to.z - centre.z};
    const F radius = sqrt(dot3(half, half)) + low.w * F(u.margins[2]);
    tap("radius", radius, "of a ball around the grown box, m");
    // A point is asked as point_distance() asks it.
    const F slack = select(F(0.0f) < radius, F(1e-5f) * (radius + sqrt(dot3(centre, centre))), F(0.0f));
    const F scale = zone_scale<F>(centre, radius + slack, u.forward, u.zones, u.scales);
    tap("scale", scale, "of the zone");
    const vec3<F> d{max(distance - low.w * F(u.margins[0]), F(0.0f)) * scale,
                    max(distance - low.w * F(u.margins[1]), F(0.0f)) * scale,
                    max(distance - low.w * F(u.margins[2]), F(0.0f)) * scale};
    tap("d", d, "distance less margin, scaled, for each boundary, m");
    const Level<F> own{level_of<F>(d, u.distances, u.levels)};    tap("level", own.level, "of detail");
    return own;
}

struct LevelKernel {
    using View = LevelView;
    template <class F, class Tap>
    PLUMB_INLINE static Level<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return level_of_box<F>(in, px, py, tap);
    }
    template <class F>
    PLUMB_INLINE static void store(const View& in, index_t<F> at, const Level<F>& own, mask_t<F> active) {
        store_index<F>(in.level, at, own.level, active);
    }
    // The last row of the fold may be longer than the list.
    template <class F>
    PLUMB_INLINE static mask_t<F> writes(const View& in, index_t<F> px, index_t<F> py) {
        using I = index_t<F>;
        return py * I(in.u.width) + px < I(in.u.count);
    }
};

}  // namespace plumb::probes
