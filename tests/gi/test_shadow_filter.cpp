// The filter of shadows over the screen (ISR 4.7): closed forms, edges, and what it leaves as it was.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/direct/visibility_filter.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;
using direct::Direction;
using direct::ShadowParams;
using direct::VisibilityFilter;
using direct::VisibilityFilterInputs;

namespace {

constexpr double ulp = 0x1p-24;  // of a rounding, relative

float noise(int x, int y, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 11).x); }

ShadowParams params_of(VisibilityFilter filter, int radius, float sigma) {
    ShadowParams params;
    params.filter = filter, params.filter_radius = radius, params.filter_sigma = sigma;
    return params;
}

// A wall at z = -2 that faces the camera at the origin, 1 cm a pixel.
Points wall(int width, int height) {
    Points p(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            p.position(x, y) = {0.01f * float(x), 0.01f * float(y), -2, 2};
            p.normal(x, y) = {0, 0, 1, 1};
        }
    return p;
}

Buffer<float> filtered(const ShadowParams& params, const Points& points, const Buffer<float>& visibility,
                       const RunOptions& options = {}) {
    Buffer<float> out(visibility.size(), -1.0f);
    direct::filter_visibility(params, {visibility.data(), &points.position, &points.normal}, options, out.data());
    return out;
}

// Lit from column `edge` on.
Buffer<float> lit_from(int edge, int width, int height) {
    Buffer<float> visibility(std::size_t(width * height));
    for (int i = 0; i < width * height; ++i) visibility[std::size_t(i)] = i % width < edge ? 0.0f : 1.0f;
    return visibility;
}

// sum of g_i over lit columns / sum of all, g in double precision.
double cumulative(int x, int edge, int width, int radius, double sigma) {
    double lit = 0, all = 0;
    for (int d = -radius; d <= radius; ++d) {
        if (x + d < 0 || x + d >= width) continue;
        const double g = host::exp(-(d * d) / (2 * sigma * sigma));
        all += g;
        if (x + d >= edge) lit += g;
    }
    return lit / all;
}

const VisibilityFilter filters[] = {VisibilityFilter::gaussian, VisibilityFilter::edge_aware};

// What two passes round, of a visibility of at most 1: a weight rounds by its table, twice by similarity and once by its
// product, sums of n terms n times, the quotient once.
double allowed(int radius) { return 2 * 2 * (2 * radius + 1 + 8) * ulp; }

}  // namespace

TEST_CASE("shadow.filter: a constant stays what it is: 0, 1 and powers of two bit for bit", "[shadow][filter][analytic]") {
    Points points = wall(37, 23);
    Buffer<float> visibility(points.position.size());
    for (const VisibilityFilter filter : filters)
        for (const int radius : {1, 4, 32})
            for (const float constant : {0.0f, 1.0f, 0.5f, 0.125f, 0.3f, 3 / 16.0f, 1 / 3.0f}) {
                CAPTURE(int(filter), radius, constant);
                for (std::size_t i = 0; i < visibility.size(); ++i) {
                    // Holes hold something else, and planes stand at all depths and angles.
                    const int x = int(i) % 37, y = int(i) / 37;
                    const bool hole = i % 11 == 3;
                    visibility[i] = hole ? 0.75f : constant;
                    const float z = 2 + 0.1f * noise(x, y, 0);
                    const glm::vec3 n(noise(x, y, 1) - 0.5f, noise(x, y, 2) - 0.5f, 1);
                    points.position.texels[i] = hole ? glm::vec4(0) : glm::vec4(0.01f * float(x), 0.01f * float(y), -z, z);
                    points.normal.texels[i] = hole ? glm::vec4(0) : glm::vec4(normalize3<float>(n), 1);
                }
                const Buffer<float> got = filtered(params_of(filter, radius, 0.5f * float(radius)), points, visibility);
                const bool exact = std::exp2(std::round(std::log2(constant))) == constant;
                for (std::size_t i = 0; i < got.size(); ++i) {
                    if (exact || i % 11 == 3)
                        CHECK(got[i] == visibility[i]);
                    else
                        CHECK(std::abs(got[i] - double(constant)) <= constant * allowed(radius));
                }
            }
}

TEST_CASE("shadow.filter: behind a straight edge the profile is the Gaussian's cumulative sum", "[shadow][filter][analytic]") {
    const int width = 48, height = 48, edge = 21;
    const Points points = wall(width, height);
    const Buffer<float> columns = lit_from(edge, width, height);
    Buffer<float> rows(columns.size()), corner(columns.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = std::size_t(y * width + x);
            rows[i] = columns[std::size_t(x * width + y)], corner[i] = columns[i] * rows[i];
        }
    for (const VisibilityFilter filter : filters)
        for (const auto& [radius, sigma] : {std::pair(1, 0.7f), std::pair(4, 2.0f), std::pair(12, 3.0f), std::pair(32, 40.0f)}) {
            const ShadowParams params = params_of(filter, radius, sigma);
            const Buffer<float> across = filtered(params, points, columns), down = filtered(params, points, rows),
                                both = filtered(params, points, corner);
            for (int y = 0; y < height; y += 3)
                for (int x = 0; x < width; ++x) {
                    CAPTURE(int(filter), radius, x, y);
                    const std::size_t i = std::size_t(y * width + x);
                    const double of_x = cumulative(x, edge, width, radius, sigma);
                    const double of_y = cumulative(y, edge, height, radius, sigma);
                    CHECK(std::abs(across[i] - of_x) <= allowed(radius));
                    CHECK(std::abs(down[i] - of_y) <= allowed(radius));
                    // Rows, then columns: the product.
                    CHECK(std::abs(both[i] - of_x * of_y) <= allowed(radius));
                }
        }
    // A Gaussian that the kernel holds whole: its integral, from the edge between two pixels on. The sum at whole numbers is
    // off by less than max |g'| / 24 and what 4 sigma cut.
    const double sigma = 3, root = std::sqrt(2 * 3.14159265358979);
    const Buffer<float> got = filtered(params_of(VisibilityFilter::gaussian, 12, 3), points, columns);
    const double coarse = 2 * std::exp(-0.5) / (root * sigma * sigma) / 24 + 1e-4;
    for (int x = 12; x < width - 12; ++x) {
        const double integral = 0.5 * std::erfc(-(x - edge + 0.5) / (sigma * std::sqrt(2.0)));
        CHECK(std::abs(got[std::size_t(20 * width + x)] - integral) < coarse);
    }
}

TEST_CASE("shadow.filter: nothing crosses an edge in depth or normal, where the Gaussian alone mixes",
          "[shadow][filter][analytic]") {
    const int width = 40, height = 9, edge = 17;
    const Buffer<float> lit = lit_from(edge, width, height);
    const auto bleeds = [&](const Points& points, VisibilityFilter filter) {
        const Buffer<float> got = filtered(params_of(filter, 8, 4), points, lit);
        return std::memcmp(got.data(), lit.data(), got.size() * sizeof(float)) != 0;
    };
    const auto right = [&](auto change) {
        Points p = wall(width, height);
        for (int y = 0; y < height; ++y)
            for (int x = edge; x < width; ++x) change(p.position(x, y), p.normal(x, y), x);
        return p;
    };
    // One wall is no edge; then two planes, by 5 % of the depth behind each other and far away, and a corner.
    CHECK(bleeds(wall(width, height), VisibilityFilter::edge_aware));
    for (const float behind : {0.1f, 3.0f}) {
        const Points p = right([=](glm::vec4& x, glm::vec4&, int) { x.z -= behind, x.w += behind; });
        CHECK_FALSE(bleeds(p, VisibilityFilter::edge_aware));
        CHECK(bleeds(p, VisibilityFilter::gaussian));
    }
    const Points corner = right([&](glm::vec4& x, glm::vec4& n, int column) {
        x = {0.01f * float(edge), x.y, -2 + 0.01f * float(column - edge), 2 - 0.01f * float(column - edge)}, n = {-1, 0, 0, 1};
    });
    CHECK_FALSE(bleeds(corner, VisibilityFilter::edge_aware));
    CHECK(bleeds(corner, VisibilityFilter::gaussian));

    // A wall at 80 degrees to the camera, each pixel deeper than the last by 2 to 8 % of its depth, is one plane, and no edge.
    Points slanted = wall(width, height);
    const double tangent = std::tan(80 * 3.14159265358979 / 180), across = 0.03;
    const float length = float(std::sqrt(1 + tangent * tangent));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float z = float(2 + tangent * across * x);
            slanted.position(x, y) = {float(across * x), 0.01f * float(y), -z, z};
            slanted.normal(x, y) = {float(tangent) / length, 0, 1 / length, 1};
            if (x > 0) CHECK((z - slanted.position(x - 1, y).w) / z > 0.018);
        }
    // n.(x_i - x) is of positions up to 9 m that round by an ulp each, 2e-6 m in all, over 0.02 times at least 2 m, squared.
    const Buffer<float> got = filtered(params_of(VisibilityFilter::edge_aware, 8, 4), slanted, lit);
    for (int x = 0; x < width; ++x)
        CHECK(std::abs(got[std::size_t(4 * width + x)] - cumulative(x, edge, width, 8, 4)) <= allowed(8) + 1e-8);
}

TEST_CASE("shadow.filter: pixels without a surface stay as they are, and give nothing", "[shadow][filter][analytic]") {
    const int width = 21, height = 5;
    Points points = wall(width, height);
    Buffer<float> visibility = lit_from(10, width, height);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (int y = 0; y < height; ++y) {
        points.position(12, y) = points.normal(12, y) = glm::vec4(0);
        visibility[std::size_t(y * width + 12)] = y == 2 ? nan : 0.25f;
    }
    for (const VisibilityFilter filter : filters) {
        const Buffer<float> got = filtered(params_of(filter, 4, 2), points, visibility);
        for (int y = 0; y < height; ++y) {
            if (y == 2)
                CHECK(std::isnan(got[std::size_t(y * width + 12)]));
            else
                CHECK(got[std::size_t(y * width + 12)] == 0.25f);
            for (int x = 0; x < width; ++x) {
                if (x == 12) continue;
                double lit = 0, all = 0;
                for (int d = -4; d <= 4; ++d) {
                    if (x + d < 0 || x + d >= width || x + d == 12) continue;
                    const double g = std::exp(-d * d / 8.0);
                    all += g, lit += x + d >= 10 ? g : 0;
                }
                CHECK(std::abs(got[std::size_t(y * width + x)] - lit / all) <= allowed(4));
            }
        }
    }
}

TEST_CASE("shadow.filter: the same bits for every instruction set and thread count, within 0 and 1", "[shadow][filter][bits]") {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), {3, 2}, {17, 5}, {64, 33}}) {
        Points points(size.x, size.y);
        Buffer<float> visibility(points.position.size());
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                visibility[std::size_t(y * size.x + x)] = noise(x, y, 5) < 0.3f ? 1 : noise(x, y, 6);
                if ((y * size.x + x) % 7 == 5) continue;
                const float z = 2 + 0.06f * noise(x, y, 0);
                points.position(x, y) = {0.01f * float(x), 0.01f * float(y), -z, z};
                points.normal(x, y) = glm::vec4(normalize3<float>(glm::vec3(noise(x, y, 1) - 0.5f, noise(x, y, 2) - 0.5f, 1)), 1);
            }
        for (const VisibilityFilter filter : filters)
            for (const int radius : {1, 5, 32}) {
                const ShadowParams params = params_of(filter, radius, 2.5f);
                RunOptions scalar;
                scalar.isa = Isa::scalar, scalar.threads = 1;
                const Buffer<float> expected = filtered(params, points, visibility, scalar);
                for (const float v : expected) CHECK((v >= 0 && v <= 1));
                for (const Isa isa : supported_isas())
                    for (const int threads : {1, 3}) {
                        CAPTURE(isa_name(isa), threads, size.x, radius);
                        RunOptions options;
                        options.isa = isa, options.threads = threads;
                        const Buffer<float> got = filtered(params, points, visibility, options);
                        CHECK(std::memcmp(got.data(), expected.data(), got.size() * sizeof(float)) == 0);
                    }
            }
    }
}

TEST_CASE("shadow.filter: what is out of range is refused, none copies, and pixels are explained", "[shadow][filter][explain]") {
    const Points points = wall(13, 3);
    const Buffer<float> lit = lit_from(6, 13, 3);
    const VisibilityFilterInputs in{lit.data(), &points.position, &points.normal};
    for (const int radius : {0, 33})
        CHECK_THROWS_WITH(direct::data_of(params_of(VisibilityFilter::gaussian, radius, 2), in),
                          Catch::Contains("filter_radius"));
    CHECK_THROWS_WITH(direct::data_of(params_of(VisibilityFilter::gaussian, 4, 0.01f), in), Catch::Contains("filter_sigma"));
    ShadowParams params = params_of(VisibilityFilter::edge_aware, 4, 2);
    params.filter_sigma_depth = 0;
    CHECK_THROWS_WITH(direct::data_of(params, in), Catch::Contains("filter_sigma_depth"));
    params = params_of(VisibilityFilter::edge_aware, 4, 2), params.filter_sigma_normal = 2;
    CHECK_THROWS_WITH(direct::data_of(params, in), Catch::Contains("filter_sigma_normal"));
    params = params_of(VisibilityFilter::edge_aware, 4, 2);
    CHECK_THROWS_WITH(direct::data_of(params, VisibilityFilterInputs{nullptr, &points.position, &points.normal}),
                      "shadow.filter: visibility must be bound");
    CHECK_THROWS_WITH(direct::data_of(params, VisibilityFilterInputs{lit.data(), nullptr, &points.normal}),
                      "shadow.filter: position must be bound");
    const ShadowParams off = params_of(VisibilityFilter::none, 4, 2);
    CHECK_THROWS_WITH(direct::data_of(off, in), Catch::Contains("filter is none"));
    CHECK(filtered(off, points, lit) == lit);

    VisibilityFilterInputs down = in;
    down.direction = Direction::vertical;
    for (const VisibilityFilterInputs& pass : {in, down}) {
        Buffer<float> out(lit.size());
        run(stage<direct::VisibilityFilterKernel>(), data_of(params, pass), {}, out.data());
        const std::vector<TapValue> taps = explain(stage<direct::VisibilityFilterKernel>(), data_of(params, pass), {5, 1});
        CHECK(taps.back().name == "filtered");
        CHECK(float(taps.back().value.at(0)) == out[13 + 5]);
        CHECK((out[13 + 5] == 0) == (pass.direction == Direction::vertical));
    }
}
