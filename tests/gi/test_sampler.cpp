// The numbers that paths are made of, and the choice among lights.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/sequences.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/light_kernel.h"
#include "gi/reference/sampler_kernel.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

using I = std::int32_t;

std::vector<vec2<float>> pairs(int n, I round, I dimension, I pixel = 5) {
    std::vector<vec2<float>> points;
    for (int i = 0; i < n; ++i) points.push_back(Sampler<float>::start(pixel, 9, round, 1, i).pair(dimension));
    return points;
}

}  // namespace

TEST_CASE("sampler: digits of the second coordinate are Sobol's", "[reference][sampler]") {
    // core/sequences.h has the sequence by its direction numbers.
    for (std::uint32_t i = 0; i < 70000; i += i < 1000 ? 1 : 997) {
        const std::uint32_t digits = std::uint32_t(reverse_bits(sobol_digits(I(i))));
        REQUIRE(digits * 0x1p-32 == sobol(i).y);
        REQUIRE(std::uint32_t(reverse_bits(I(i))) * 0x1p-32 == sobol(i).x);
    }
}

TEST_CASE("sampler: scrambling permutes nested intervals (Owen 1995)", "[reference][sampler]") {
    // Digits of equal value up to the k-th stay equal up to the k-th, and a differing k-th stays different.
    for (I seed : {0, 1, 12345, -7})
        for (I x : {0, 1, 0x1234567, -1, 0x55555555})
            for (int k = 0; k < 32; ++k) {
                const I other = I(std::uint32_t(x) ^ (1u << k));
                const std::uint32_t changed =
                    std::uint32_t(scramble_digits(x, seed)) ^ std::uint32_t(scramble_digits(other, seed));
                REQUIRE((changed & ((1u << k) - 1)) == 0);
                REQUIRE((changed >> k & 1) == 1);
            }
}

TEST_CASE("sampler: a round of 2^k points puts one into each dyadic box of area 2^-k", "[reference][sampler]") {
    for (int k : {1, 4, 6, 8})
        for (I dimension : {0, 1, 7})
            for (I round : {0, 3}) {
                const int n = 1 << k;
                const auto points = pairs(n, round, dimension);
                for (int columns = 0; columns <= k; ++columns) {
                    std::set<std::pair<int, int>> boxes;
                    for (const auto& p : points)
                        boxes.insert({int(p.x * float(1 << columns)), int(p.y * float(1 << (k - columns)))});
                    CAPTURE(k, dimension, round, columns);
                    REQUIRE(int(boxes.size()) == n);
                }
            }
}

TEST_CASE("sampler: rounds, pixels and dimensions are independent", "[reference][sampler]") {
    // Over 4096 pixels the product of two centred numbers has mean 0 and standard deviation 1/12.
    const int n = 4096;
    auto number = [](int pixel, I round, I dimension, int axis) {
        const vec2<float> p = Sampler<float>::start(pixel, 3, round, 1, 2).pair(dimension);
        return (axis == 0 ? p.x : p.y) - 0.5;
    };
    struct Pair {
        I round_a, dimension_a, axis_a, round_b, dimension_b, axis_b, shift;
    };
    for (const Pair& c : {Pair{0, 1, 0, 0, 1, 1, 0}, {0, 1, 0, 1, 1, 0, 0}, {0, 1, 0, 0, 2, 0, 0},
                          {0, 1, 1, 0, 4, 1, 0}, {0, 1, 0, 0, 1, 0, 1}, {2, 5, 1, 3, 5, 1, 0}}) {
        double sum = 0, squares = 0;
        for (int i = 0; i < n; ++i) {
            const double a = number(i, c.round_a, c.dimension_a, c.axis_a);
            sum += a * number(i + c.shift, c.round_b, c.dimension_b, c.axis_b), squares += a * a;
        }
        CAPTURE(c.round_a, c.dimension_a, c.axis_a, c.round_b, c.dimension_b, c.axis_b, c.shift);
        CHECK(std::abs(sum) < 4 * std::sqrt(double(n)) / 12);
        CHECK(squares / n == Approx(1.0 / 12).epsilon(0.05));
    }
}

TEST_CASE("sampler: the two coordinates have scrambles of their own", "[reference][sampler]") {
    // Over the pixels of a row one and the same sample falls evenly into 8 x 8 boxes: chi-square of 63 degrees of
    // freedom, with a standard deviation of sqrt(2 x 63) = 11.2. An even sample and the next fall into different halves
    // in x and in y; whether their second digits differ is a matter of chance, in x and, apart from that, in y: 2 x 2
    // boxes, 3 degrees of freedom, above 22 with probability 7e-5.
    const int n = 8192;
    for (I sample : {0, 2, 12})
        for (I dimension : {0, 1, 6}) {
            double boxes[64] = {}, digits[4] = {};
            for (int pixel = 0; pixel < n; ++pixel) {
                const vec2<float> p = Sampler<float>::start(pixel, 2, 1, 4, sample).pair(dimension);
                const vec2<float> q = Sampler<float>::start(pixel, 2, 1, 4, sample + 1).pair(dimension);
                REQUIRE((p.x < 0.5f) != (q.x < 0.5f));
                REQUIRE((p.y < 0.5f) != (q.y < 0.5f));
                ++boxes[int(p.x * 8) * 8 + int(p.y * 8)];
                ++digits[((int(p.x * 4) ^ int(q.x * 4)) & 1) * 2 + ((int(p.y * 4) ^ int(q.y * 4)) & 1)];
            }
            auto chi_square = [&](const double* counts, int number) {
                double sum = 0;
                const double even = double(n) / number;
                for (int i = 0; i < number; ++i) sum += (counts[i] - even) * (counts[i] - even) / even;
                return sum;
            };
            CAPTURE(sample, dimension);
            CHECK(std::abs(chi_square(boxes, 64) - 63) < 4 * 11.2);
            CHECK(chi_square(digits, 4) < 22);
        }
}

TEST_CASE("lights: what a choice leaves of u is passed on where it is enough", "[reference][lights]") {
    // Shares of 2^-9, 1/2, 2^-7 and the rest. A share below 2^-8 leaves fewer than 2^16 steps: a fresh number then.
    const float cdf[] = {0, 0x1p-9f, 0.5f + 0x1p-9f, 0.5f + 0x1p-7f + 0x1p-9f, 1};
    LightArgs args{};
    args.count = 4, args.steps = 2, args.cdf = cdf;
    for (int k = 0; k < 1 << 24; k += 97) {
        const float u = float(k) * 0x1p-24f, fresh = 0.3125f;
        const ChosenLight<float> c = choose_light<float>(args, u, fresh);
        const float first = cdf[c.light], probability = cdf[c.light + 1] - first;
        REQUIRE(first <= u);
        REQUIRE(u < cdf[c.light + 1]);
        REQUIRE(c.probability == probability);
        REQUIRE(c.rest == (probability < 0x1p-8f ? fresh : (u - first) / probability));
    }
}

TEST_CASE("lights: a choice has exactly the probability that it is weighted with", "[reference][lights]") {
    // Twelve triangles of unequal areas, a lamp and the sky, counted over all 2^24 numbers that u can be.
    Scene scene;
    add_rectangle(scene, grey(0, 1), {0, 0, 0}, {1, 0, 1});
    add_rectangle(scene, grey(0, 1e-9), {0, 1, 0}, {1, 1, 1});  // less than a step of u: it gets one step
    add_cube(scene, grey(0.5, 3), {2, 0, 0}, {2.7, 1.3, 0.4});
    scene.lights.push_back(point_lamp({0, 3, 0}, 10));
    scene.environment.radiance = glm::vec3(0.2f);
    const Geometry geometry = flatten(scene);
    const raster::Surfaces surfaces = raster::prepare(scene, geometry);
    const LightTable table = light_table(scene, geometry, surfaces, environment_table(scene.environment));
    REQUIRE(table.count == 1 + 2 + 2 + 12 + 1);
    REQUIRE(table.cdf.front() == 0);
    REQUIRE(table.cdf.back() == 1);
    LightArgs args{table.count, 5, table.rows.data(), table.cdf.data(), table.triangle_pdf.data(), 0};
    std::vector<int> chosen(std::size_t(table.count));
    std::vector<float> probability(std::size_t(table.count));
    for (int k = 0; k < 1 << 24; ++k) {
        const ChosenLight<float> c = choose_light<float>(args, float(k) * 0x1p-24f, 0.25f);
        ++chosen[std::size_t(c.light)];
        probability[std::size_t(c.light)] = c.probability;
        if (!(c.rest >= 0 && c.rest < 1)) FAIL("rest " << c.rest);
    }
    for (int i = 0; i < table.count; ++i) {
        CAPTURE(i);
        REQUIRE(chosen[std::size_t(i)] > 0);
        REQUIRE(chosen[std::size_t(i)] * 0x1p-24f == probability[std::size_t(i)]);
    }
    // Half evenly over five sources, half by power: the lamp sends 10 W (three channels: 30), the first rectangle
    // 2 x 3 x 1 W, the second nothing to speak of, the block 3 x 2 x 3 x 5.94 m2, the sky 3 x 0.2 pi of the sphere.
    const double even = 0.1, lamp = probability[0] - even, rectangle = probability[1] + probability[2] - even;
    CHECK(lamp / rectangle == Approx(5).epsilon(1e-4));
    CHECK(probability[3] + probability[4] == Approx(even).epsilon(1e-4));
    CHECK(table.environment_probability == probability.back());
    // Both triangles of the first rectangle have area 1/2.
    CHECK(table.triangle_pdf[0] == Approx(double(probability[1]) / 0.5));
}

TEST_CASE("lights: what does not shine is not in the table", "[reference][lights]") {
    Scene scene;
    add_rectangle(scene, grey(0.5), {0, 0, 0}, {1, 0, 1});
    Light off = point_lamp({0, 1, 0}, 1);
    off.on = false;
    scene.lights = {off, point_lamp({0, 2, 0}, 0)};
    const Geometry geometry = flatten(scene);
    const LightTable table =
        light_table(scene, geometry, raster::prepare(scene, geometry), environment_table(scene.environment));
    CHECK(table.count == 0);
    CHECK_FALSE(table.any_triangle);
    CHECK(table.environment_probability == 0);
}
