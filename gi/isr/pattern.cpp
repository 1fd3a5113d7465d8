#include <algorithm>
#include <cmath>
#include <vector>

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

void add(Pattern& pattern, const glm::dvec2& at) {
    const int dx = round_to_pixel(at.x), dy = round_to_pixel(at.y);
    pattern.offsets.push_back(pack(dx, dy));
    pattern.reach = std::max({pattern.reach, std::abs(dx), std::abs(dy)});
}

Pattern begin(int rings, int rotations, double side) {
    Pattern pattern;
    pattern.samples = sample_count(rings), pattern.rotations = rotations, pattern.side = side;
    pattern.offsets.reserve(std::size_t(pattern.samples) * std::size_t(rotations));
    return pattern;
}

// Rings of a square grid: a quarter turn maps it to itself, so that rotations share out a quarter turn.
Pattern grid_of(int rings, double spacing, int rotations) {
    Pattern pattern = begin(rings, rotations, spacing);
    for (int r = 1; r <= rings; ++r)
        for (int i = 0; i < 8 * r; ++i)
            for (int turn = 0; turn < rotations; ++turn) {
                const double angle = host::pi / 2 * turn / rotations, c = host::cos(angle), s = host::sin(angle);
                const glm::dvec2 at = spacing * glm::dvec2(on_ring(r, i));
                add(pattern, {at.x * c - at.y * s, at.x * s + at.y * c});
            }
    pattern.weights.assign(std::size_t(pattern.samples), 1.0f);
    return pattern;
}

// Rounded to pixels, but never to the receiver's own.
glm::dvec2 off_receiver(const glm::dvec2& at) {
    if (round_to_pixel(at.x) != 0 || round_to_pixel(at.y) != 0) return at;
    return std::abs(at.x) > std::abs(at.y) ? glm::dvec2(at.x < 0 ? -1 : 1, 0) : glm::dvec2(0, at.y < 0 ? -1 : 1);
}

// The circles that part the samples' cells, coarse pixels, ascending: samples + 1 of them. The first is as large as the receiver's own
// pixel, which is no sample. Each is at least so much larger than the one before that a ring is a pixel wide.
std::vector<double> circles_of(int rings, double radius, double growth) {
    std::vector<double> circles{std::sqrt(1 / host::pi)};
    const double samples = sample_count(rings);
    for (int r = 1, k = 1; r <= rings; ++r)
        for (int i = 0; i < 8 * r; ++i, ++k)
            circles.push_back(std::max(radius * host::pow(k / samples, growth / 2), circles.back() + 1.0 / (8 * r)));
    return circles;
}

// A spiral of growing radius: sample k stands for the annulus between circles k and k + 1, and lies on the circle that halves its area, a
// golden angle further than the one before it (Vogel 1979). Rotations share out a full turn.
Pattern rings_of(int rings, double radius, double growth, int rotations) {
    Pattern pattern = begin(rings, rotations, 1);
    const std::vector<double> circles = circles_of(rings, radius, growth);
    const double golden = host::pi * (3 - std::sqrt(5.0));
    for (int k = 0; k < pattern.samples; ++k) {
        const double inner = circles[std::size_t(k)] * circles[std::size_t(k)],
                     outer = circles[std::size_t(k) + 1] * circles[std::size_t(k) + 1], r = std::sqrt((inner + outer) / 2);
        pattern.weights.push_back(float(host::pi * (outer - inner)));
        for (int turn = 0; turn < rotations; ++turn) {
            const double angle = k * golden + 2 * host::pi * turn / rotations;
            add(pattern, off_receiver({r * host::cos(angle), r * host::sin(angle)}));
        }
    }
    return pattern;
}

}  // namespace

Pattern gather_pattern(const IsrParams& params, int height) {
    validate(params);
    const IsrParams p = resolved(params);
    const double reach = double(p.reach) * height;
    if (p.pattern == PatternKind::rings) return rings_of(p.rings, reach, double(p.growth), p.rotations);
    // The outermost samples stand for half a spacing beyond them.
    const double spacing = p.spacing != 0 ? double(p.spacing) : std::max(1.0, reach / (p.rings + 0.5));
    return grid_of(p.rings, spacing, p.rotations);
}

Pattern ssao_pattern(const IsrParams& params) {
    validate(params);
    return grid_of(params.ssao_rings, double(params.ssao_spacing), resolved(params).rotations);
}

}  // namespace plumb::isr
