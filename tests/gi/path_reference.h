// VRSM's algorithms for visibility as printed, in double precision and with the angle itself: what the kernel of
// rsm.paths is held against, which knows neither an angle nor a counter.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/host_math.h"

namespace plumb::test {

// Algorithm 2.
struct Algorithm2 {
    std::vector<bool> occluded;
    explicit Algorithm2(int slots) : occluded(std::size_t(slots), false) {}
    double visibility(int idx) {
        if (occluded[std::size_t(idx)]) return 0;
        occluded[std::size_t(idx)] = true;
        return 1;
    }
};

// Algorithm 3.
struct Algorithm3 {
    std::vector<bool> occluded;
    int idx_before = -1;
    double v_before = 0;
    explicit Algorithm3(int slots) : occluded(std::size_t(slots), false) {}
    double visibility(int idx) {
        double v = v_before;
        if (idx != idx_before) {
            v = occluded[std::size_t(idx)] ? 0 : 1;
            occluded[std::size_t(idx)] = true;
        }
        idx_before = idx, v_before = v;
        return v;
    }
};

// Algorithm 6, and line 12 of Algorithm 5.
struct Algorithm6 {
    std::vector<float> buffers;
    int idx_before = -1;
    float v_before = 0;
    explicit Algorithm6(int slots) : buffers(std::size_t(slots), 1.0f) {}
    double visibility(int idx) {
        float v = v_before;
        if (idx != idx_before) v = buffers[std::size_t(idx)], buffers[std::size_t(idx)] -= 1;
        idx_before = idx, v_before = v;
        return std::clamp(v, 0.0f, 1.0f);
    }
};

// The elevation of d over the plane that is normal to the unit vector `axis`: in [-pi/2, pi/2].
inline double elevation(const double (&d)[3], const double (&axis)[3]) {
    const double dz = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
    double across = 0;
    for (int c = 0; c < 3; ++c) across += (d[c] - dz * axis[c]) * (d[c] - dz * axis[c]);
    return std::atan2(dz, std::sqrt(across));
}

// "Equally divides all possible angles" (VRSM 3.3), or all directions.
inline int slot_by_angle(double phi, int slots) {
    return std::clamp(int(std::floor((phi + host::pi / 2) / host::pi * slots)), 0, slots - 1);
}
inline int slot_by_solid_angle(double phi, int slots) {
    return std::clamp(int(std::floor((std::sin(phi) + 1) / 2 * slots)), 0, slots - 1);
}

}  // namespace plumb::test
