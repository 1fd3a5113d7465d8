#include <algorithm>

#include "core/host_math.h"
#include "gi/isr/isr.h"

namespace plumb::isr {

namespace {

std::int32_t pack(int dx, int dy) { return std::int32_t((std::uint32_t(dx) & 0xffffu) | (std::uint32_t(dy) << 16)); }

int round_to_pixel(double x) { return int(__builtin_floor(x + 0.5)); }

// Sample i of 8 r in ring r of the square grid: clockwise from the top left corner, y down.
glm::ivec2 on_ring(int r, int i) {
    const int side = 2 * r, along = i % side - r;
    switch (i / side) {
        case 0: return {along, -r};
        case 1: return {r, along};
        case 2: return {-along, r};
        default: return {-r, -along};
    }
}

// Rings of a square grid: a quarter turn maps it to itself, so that rotations share out a quarter turn.
Pattern rings_of(int rings, double spacing, int rotations) {
    Pattern pattern;
    pattern.samples = sample_count(rings), pattern.rotations = rotations;
    pattern.offsets.reserve(std::size_t(pattern.samples) * std::size_t(rotations));
    for (int r = 1; r <= rings; ++r)
        for (int i = 0; i < 8 * r; ++i)
            for (int turn = 0; turn < rotations; ++turn) {
                const double angle = host::pi / 2 * turn / rotations, c = host::cos(angle), s = host::sin(angle);
                const glm::dvec2 at = spacing * glm::dvec2(on_ring(r, i));
                const int dx = round_to_pixel(at.x * c - at.y * s), dy = round_to_pixel(at.x * s + at.y * c);
                pattern.offsets.push_back(pack(dx, dy));
                pattern.reach = std::max({pattern.reach, std::abs(dx), std::abs(dy)});
            }
    return pattern;
}

}  // namespace

Pattern gather_pattern(const IsrParams& params) {
    validate(params);
    return rings_of(params.rings, double(params.spacing), params.rotations);
}

Pattern ssao_pattern(const IsrParams& params) {
    validate(params);
    return rings_of(params.ssao_rings, double(params.ssao_spacing), params.rotations);
}

}  // namespace plumb::isr
