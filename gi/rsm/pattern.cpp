#include "core/hash.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/rsm/gather.h"

namespace plumb::rsm {

namespace {

// Sample k of N in the unit square.
glm::dvec2 xi(Sequence sequence, int k, int n, std::uint32_t seed) {
    switch (sequence) {
        case Sequence::hammersley: return {(k + 0.5) / n, van_der_corput(std::uint64_t(k))};
        case Sequence::r2: return r2(std::uint64_t(k));
        case Sequence::random: break;
    }
    const Hash3<std::int32_t> h = pixel_hash<std::int32_t>(k, 0, 0, std::int32_t(seed));
    return {unit_float<float>(h.x), unit_float<float>(h.y)};
}

std::int32_t pack(int dx, int dy) { return std::int32_t((std::uint32_t(dx) & 0xffffu) | (std::uint32_t(dy) << 16)); }

int round_to_texel(double x) { return int(__builtin_floor(x + 0.5)); }

}  // namespace

Pattern disc_pattern(const GatherParams& params, int map_size, std::uint32_t seed) {
    const int n = params.samples;
    const double r = double(params.radius) * map_size, area = host::pi * r * r;
    Pattern pattern;
    pattern.samples = n;
    pattern.rotations = params.rotations;
    pattern.offsets.resize(std::size_t(n) * params.rotations);
    pattern.weights.resize(n);

    double sum_of_squares = 0;
    for (int k = 0; k < n; ++k) {
        const double xi1 = xi(params.sequence, k, n, seed).x;
        sum_of_squares += xi1 * xi1;
    }
    for (int k = 0; k < n; ++k) {
        const glm::dvec2 sample = xi(params.sequence, k, n, seed);
        for (int i = 0; i < params.rotations; ++i) {
            const double angle = 2 * host::pi * (sample.y + double(i) / params.rotations);
            pattern.offsets[std::size_t(k) * params.rotations + i] =
                pack(round_to_texel(r * sample.x * host::sin(angle)), round_to_texel(r * sample.x * host::cos(angle)));
        }
        // The density of (xi1 sin, xi1 cos) is 1 / (2 pi r^2 xi1) a texel: its inverse over N is the consistent weight.
        const double corrected = 2 * area * sample.x / n;
        const double published = area * sample.x * sample.x / sum_of_squares;  // LRA 4.3.3, its scale is ours
        pattern.weights[k] = float(params.variant == Variant::published ? published : corrected);
    }
    return pattern;
}

}  // namespace plumb::rsm
