// What VRSM says of its sampling, measured (VRSM 3.1, 3.2, 4.4): one pattern of 400 samples for all points aliases, 150 samples
// along turned and jittered paths leave noise that a blur takes away, and paths count for more than samples along each.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/hash.h"
#include "core/host_math.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

constexpr int map_size = 256, side = 96;

// A map of many small surfaces: cells of 6 x 6 texels, each as bright as a hash says, every fourth one dark.
const raster::Rsm& patchwork() {
    static const raster::Rsm map = plane_map(map_size, [](double x, double y) {
        const int i = int((x + 1) / 2 * map_size) / 6, j = int((1 - y) / 2 * map_size) / 6;
        const Hash3<std::int32_t> h = pixel_hash<std::int32_t>(i, j, 0, 5);
        return unit_float<float>(h.x) < 0.25f ? 0.0 : 4 * double(unit_float<float>(h.y));
    });
    return map;
}

// Points of a plane across from it, 0.35 m away, that look at its middle: 0.7 texels from one to the next.
Points facing_points() {
    Points points(side, side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double step = 0.7 * 2 / map_size;
            points.position(x, y) = glm::vec4(float((x - side / 2) * step), float((y - side / 2) * step), 0.35f, 0);
            points.normal(x, y) = glm::vec4(0, 0, -1, 1);
        }
    return points;
}

rsm::GatherParams disc_params(int samples, int rotations) {
    rsm::GatherParams params{.gather = rsm::Gather::disc};
    params.samples = samples, params.rotations = rotations, params.turn = rsm::Turn::hash;
    return params;
}
rsm::GatherParams paths_params(int directions, int steps) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths, params.turn = rsm::Turn::hash;
    params.directions = directions, params.steps = steps;
    params.visibility = rsm::Visibility::none;
    return params;
}

using Errors = Image<double>;

Errors irradiance(const rsm::GatherParams& params, const Points& points, std::uint32_t seed) {
    const rsm::Pattern pattern = rsm::pattern_of(params, map_size, seed);
    Image4 gathered;
    rsm::run(params, {&points.position, &points.normal, &patchwork(), &pattern, seed}, {}, gathered);
    Errors field(side, side);
    for (std::size_t i = 0; i < field.size(); ++i) field.texels[i] = gathered.texels[i].x;
    return field;
}

// Every texel of the disc, once.
const Errors& truth() {
    static const Errors field = [] {
        rsm::GatherParams params = disc_params(1, 1);
        const double r = double(params.radius) * map_size;
        SampleRows own{"all.npy", "all.npy", {}};
        for (int dy = -int(r); dy <= int(r); ++dy)
            for (int dx = -int(r); dx <= int(r); ++dx)
                if (dx * dx + dy * dy < r * r) own.rows.push_back({double(dx), double(dy), 1});
        params.pattern = own.name;
        params.own = std::make_shared<const SampleRows>(own);
        return irradiance(params, facing_points(), 1);
    }();
    return field;
}

// Over the truth's mean.
Errors error_of(const rsm::GatherParams& params, std::uint32_t seed) {
    Errors field = irradiance(params, facing_points(), seed);
    double mean = 0;
    for (const double v : truth().texels) mean += v / double(field.size());
    for (std::size_t i = 0; i < field.size(); ++i) field.texels[i] = (field.texels[i] - truth().texels[i]) / mean;
    return field;
}

// As VRSM's post processing where nothing but the distance weighs: a Gaussian of 17 x 17, sigma 3. Its border is left out.
Errors blurred(const Errors& field) {
    Errors out(side - 16, side - 16);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            double sum = 0, weights = 0;
            for (int dy = -8; dy <= 8; ++dy)
                for (int dx = -8; dx <= 8; ++dx) {
                    const double w = std::exp(-(dx * dx + dy * dy) / 18.0);
                    sum += w * field(x + 8 + dx, y + 8 + dy), weights += w;
                }
            out(x, y) = sum / weights;
        }
    return out;
}

double rms(const Errors& field) {
    double squares = 0;
    for (const double v : field.texels) squares += v * v;
    return std::sqrt(squares / double(field.size()));
}

// Of the error of a point and of the next one in the row: 1 where it is a smooth pattern, 0 where it is noise.
double neighbours_correlation(const Errors& field) {
    double products = 0, squares = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x + 1 < side; ++x) products += field(x, y) * field(x + 1, y), squares += field(x, y) * field(x, y);
    return products / squares;
}

double mean_rms(const rsm::GatherParams& params, int seeds) {
    double squares = 0;
    for (int s = 1; s <= seeds; ++s) squares += std::pow(rms(error_of(params, std::uint32_t(s))), 2) / seeds;
    return std::sqrt(squares);
}

}  // namespace

TEST_CASE("rsm: 400 samples of one pattern alias, 150 along turned paths leave noise that a blur takes away",
          "[rsm][VRSM 3.1][VRSM 3.2]") {
    const Errors one = error_of(disc_params(400, 1), 1), paths = error_of(paths_params(15, 10), 1);
    const double kept_one = rms(blurred(one)) / rms(one), kept_paths = rms(blurred(paths)) / rms(paths);
    INFO(fmt::format("one pattern of 400: rms {:.4f}, blurred {:.4f}, neighbours {:.3f}; 15 x 10 along paths: {:.4f}, {:.4f}, {:.3f}",
                     rms(one), rms(blurred(one)), neighbours_correlation(one), rms(paths), rms(blurred(paths)),
                     neighbours_correlation(paths)));
    // What neighbours have in common is a pattern that one sees, and of which a blur leaves more than of noise.
    CHECK(neighbours_correlation(one) > 0.6);
    CHECK(std::abs(neighbours_correlation(paths)) < 0.1);
    // White noise keeps sqrt(sum w^2) / sum w = 0.094 of its rms.
    CHECK(kept_one > 0.25);
    CHECK(kept_paths < 0.12);
    // "A rather low number of samples": before the blur 150 err more than 400, behind it less.
    CHECK(rms(paths) > rms(one));
    CHECK(rms(blurred(paths)) < rms(blurred(one)));
    // Turning the disc by point does to it what it does to paths.
    const Errors turned = error_of(disc_params(400, 64), 1);
    CHECK(std::abs(neighbours_correlation(turned)) < 0.2);
}

TEST_CASE("rsm.paths: of as many samples more paths err less than more steps", "[rsm][paths][VRSM 4.4]") {
    const double steps = mean_rms(paths_params(5, 30), 4), thesis = mean_rms(paths_params(15, 10), 4),
                 paths = mean_rms(paths_params(30, 5), 4);
    INFO(fmt::format("5 x 30: {:.4f}, 15 x 10: {:.4f}, 30 x 5: {:.4f}", steps, thesis, paths));
    CHECK(thesis < 0.8 * steps);
    // Beyond the thesis' 15 paths as much is lost along them as is gained across.
    CHECK(std::abs(paths / thesis - 1) < 0.1);
}
