#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
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

// Tables of that many samples and rotations, of what `params` reads.
Pattern empty_pattern(const GatherParams& params, int samples, std::size_t weights) {
    Pattern pattern;
    pattern.samples = samples, pattern.rotations = params.rotations;
    const std::size_t n = std::size_t(samples) * std::size_t(params.rotations);
    if (params.texels == Texels::whole)
        pattern.offsets.resize(n);
    else
        pattern.positions.resize(2 * n);
    pattern.weights.resize(weights);
    return pattern;
}

// dx, dy in texels.
void set_offset(Pattern& pattern, std::size_t at, double dx, double dy) {
    if (pattern.positions.empty())
        pattern.offsets[at] = pack(round_to_texel(dx), round_to_texel(dy));
    else
        pattern.positions[2 * at] = float(dx), pattern.positions[2 * at + 1] = float(dy);
}

// Where the steps of a path lie: rho = r g(u), u from 0 to 1.
class Radii {
  public:
    // r: the paths' length, texels.
    Radii(const GatherParams& params, double r)
        : spacing_(params.spacing), log_growth_(host::log(double(params.growth))), jitter_(double(params.jitter)), r_(r),
          steps_(params.steps) {
        // Growing by nothing.
        if (spacing_ == Spacing::geometric && log_growth_ == 0) spacing_ = Spacing::uniform;
    }

    // Of step k, `stray` steps from its middle, texels.
    double at(int k, double stray) const {
        if (spacing_ == Spacing::uniform) return (k + 0.5 + stray) * (r_ / steps_);
        return r_ * g((k + 0.5 + stray) / steps_);
    }

    // The width of the ring that a sample there stands for, texels: r g' / steps, the inverse of the density along the path,
    // times what the ring of step k has in area over that which such rings have on the average over stray.
    double width(int k, double stray) const {
        const double step = r_ / steps_;
        if (spacing_ == Spacing::uniform) return step;  // the two areas are equal
        const double ring = half_square(k, k + 1);
        const double middle = k + 0.5, a = middle - jitter_ / 2, b = middle + jitter_ / 2;
        // Closer ends would cancel each other.
        const double mean =
            jitter_ < 1e-5 ? g(middle / steps_) * slope(middle / steps_) : half_square(a, b) * steps_ / (b - a);
        return step * slope((k + 0.5 + stray) / steps_) * (ring * steps_ / mean);
    }

  private:
    double g(double u) const {
        if (spacing_ == Spacing::quadratic) return u * u;
        return host::expm1(u * log_growth_) / host::expm1(log_growth_);
    }
    double slope(double u) const {
        if (spacing_ == Spacing::quadratic) return 2 * u;
        return log_growth_ * host::exp(u * log_growth_) / host::expm1(log_growth_);
    }
    // The integral of g g' from step a to step b: (g(b)^2 - g(a)^2) / 2.
    double half_square(double a, double b) const {
        const double ga = g(a / steps_), gb = g(b / steps_);
        return (gb - ga) * (gb + ga) / 2;
    }

    Spacing spacing_;
    double log_growth_, jitter_, r_;
    int steps_;
};

}  // namespace

Pattern disc_pattern(const GatherParams& params, int map_size, std::uint32_t seed) {
    const int n = params.samples;
    const double r = double(params.radius) * map_size, area = host::pi * r * r;
    Pattern pattern = empty_pattern(params, n, std::size_t(n));

    double sum_of_squares = 0;
    for (int k = 0; k < n; ++k) {
        const double xi1 = xi(params.sequence, k, n, seed).x;
        sum_of_squares += xi1 * xi1;
    }
    for (int k = 0; k < n; ++k) {
        const glm::dvec2 sample = xi(params.sequence, k, n, seed);
        for (int i = 0; i < params.rotations; ++i) {
            const double angle = 2 * host::pi * (sample.y + double(i) / params.rotations);
            set_offset(pattern, std::size_t(k) * params.rotations + i, r * sample.x * host::sin(angle),
                       r * sample.x * host::cos(angle));
        }
        // The density of (xi1 sin, xi1 cos) is 1 / (2 pi r^2 xi1) a texel: its inverse over N is the consistent weight.
        const double corrected = 2 * area * sample.x / n;
        const double published = area * sample.x * sample.x / sum_of_squares;  // LRA 4.3.3, its scale is ours
        pattern.weights[k] = float(params.variant == Variant::published ? published : corrected);
    }
    return pattern;
}

Pattern paths_pattern(const GatherParams& params, int map_size, std::uint32_t seed) {
    const int paths = params.directions, steps = params.steps, rotations = params.rotations;
    const double r = double(params.radius) * map_size;
    const Radii radii(params, r);
    Pattern pattern = empty_pattern(params, paths * steps, std::size_t(paths) * steps * rotations);

    for (int i = 0; i < rotations; ++i) {
        Buffer<double> rho(std::size_t(pattern.samples)), width(std::size_t(pattern.samples));
        double sum_of_squares = 0;
        for (int k = 0; k < pattern.samples; ++k) {
            const Hash3<std::int32_t> h = pixel_hash<std::int32_t>(k, 0, 1, std::int32_t(seed));
            // Over all rotations a sample's place in its step, and in its sector, is spread evenly, and otherwise in each
            // sample.
            const double along = van_der_corput(std::uint64_t(i)) + unit_float<float>(h.x);
            const double across = van_der_corput(std::uint64_t(i), 3) + unit_float<float>(h.y);
            auto centred = [](double u) { return u - __builtin_floor(u) - 0.5; };
            const double angle = 2 * host::pi *
                                 (k / steps + (i + 0.5) / rotations + double(params.turn_jitter) * centred(across)) / paths;
            const double stray = double(params.jitter) * centred(along);
            rho[std::size_t(k)] = radii.at(k % steps, stray), width[std::size_t(k)] = radii.width(k % steps, stray);
            set_offset(pattern, std::size_t(k) * rotations + i, rho[std::size_t(k)] * host::sin(angle),
                       rho[std::size_t(k)] * host::cos(angle));
            sum_of_squares += rho[std::size_t(k)] * rho[std::size_t(k)];
        }
        for (int k = 0; k < pattern.samples; ++k) {
            const double at = rho[std::size_t(k)];
            // A narrow ring has the area 2 pi rho width, and every path a share of it.
            const double corrected = 2 * host::pi * at / paths * width[std::size_t(k)];
            const double published = host::pi * r * r * at * at / sum_of_squares;  // VRSM 3.2, its scale is ours
            pattern.weights[std::size_t(k) * rotations + i] =
                float(params.variant == Variant::published ? published : corrected);
        }
    }
    return pattern;
}

Pattern own_pattern(const GatherParams& params) {
    const std::vector<glm::dvec3>& rows = params.own->rows;
    const bool paths = params.gather == Gather::paths;
    const std::size_t n = rows.size(), rotations = std::size_t(params.rotations);
    auto refuse = [&](const std::string& cause) {
        throw InputError(fmt::format("{}: {}: {}", params.own->path, stage_name(params), cause));
    };
    if (paths && n != std::size_t(params.directions) * std::size_t(params.steps))
        refuse(
            fmt::format("has {} samples: expected directions = {} x steps = {}", n, params.directions, params.steps));
    if (n > most_samples) refuse(fmt::format("has {} samples: expected at most {}", n, most_samples));
    Pattern pattern = empty_pattern(params, int(n), paths ? n * rotations : n);
    for (std::size_t i = 0; i < rotations; ++i) {
        const double turn = 2 * host::pi * double(i) / double(rotations) / (paths ? params.directions : 1);
        const double s = host::sin(turn), c = host::cos(turn);
        for (std::size_t k = 0; k < n; ++k) {
            // Angles are counted as in (sin, cos).
            const double dx = rows[k].x * c + rows[k].y * s, dy = rows[k].y * c - rows[k].x * s;
            if (!(__builtin_fabs(dx) <= 32767 && __builtin_fabs(dy) <= 32767))
                refuse(fmt::format("row {}, rotation {}: {:g}, {:g} texels: expected at most 32767", k, i, dx, dy));
            set_offset(pattern, k * rotations + i, dx, dy);
            pattern.weights[paths ? k * rotations + i : k] = float(rows[k].z);
        }
    }
    return pattern;
}

Pattern pattern_of(const GatherParams& params, int map_size, std::uint32_t seed) {
    validate(params);
    const bool samples = params.gather == Gather::disc || params.gather == Gather::paths;
    if (samples && params.pattern != (params.own ? params.own->name : ""))
        throw InputError(fmt::format("{}: pattern = \"{}\": the file was not read: expected it in a scene file or "
                                     "--set", stage_name(params), params.pattern));
    if (samples && params.own) return own_pattern(params);
    if (params.gather == Gather::disc) return disc_pattern(params, map_size, seed);
    if (params.gather == Gather::paths) return paths_pattern(params, map_size, seed);
    return {};
}

Pattern turned(Pattern pattern, int columns) {
    if (columns == 0 || pattern.rotations == 0) return pattern;
    const auto turn = [&](auto& table, std::size_t numbers) {
        const std::size_t row = numbers * std::size_t(pattern.rotations);
        for (std::size_t k = 0; k + row <= table.size(); k += row)
            std::rotate(table.begin() + std::ptrdiff_t(k), table.begin() + std::ptrdiff_t(k + numbers * std::size_t(columns)),
                        table.begin() + std::ptrdiff_t(k + row));
    };
    turn(pattern.offsets, 1), turn(pattern.positions, 2);
    // Of a disc a weight is a sample's, whatever its rotation.
    if (pattern.weights.size() > std::size_t(pattern.samples)) turn(pattern.weights, 1);
    return pattern;
}

Buffer<float> slot_edges(const GatherParams& params) {
    if (params.visibility == Visibility::none) return Buffer<float>(1);
    Buffer<float> edges(std::size_t(params.slots - 1));
    for (int i = 1; i < params.slots; ++i) {
        const double share = double(i) / params.slots;
        const double s =
            params.slot_edges == SlotEdges::solid_angle ? 2 * share - 1 : host::sin(host::pi * (share - 0.5));
        edges[std::size_t(i - 1)] = float(s * __builtin_fabs(s));
    }
    return edges;
}

}  // namespace plumb::rsm
