// A hemicube's texels, weighed and summed box by box: against sums in double, one texel alone, and rows of form factors.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/hash.h"
#include "gi/lend.h"
#include "gi/radiosity/published_pass.h"
#include "gi/radiosity/reduce.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;

namespace {

Buffer<glm::vec4> noise(int n, std::uint32_t seed) {
    Buffer<glm::vec4> texels;
    for (int i = 0; i < n; ++i) {
        const auto h = pixel_hash<std::int32_t>(i, 0, 0, std::int32_t(seed));
        const auto unit = [](std::int32_t v) { return float(std::uint32_t(v) >> 8) * 0x1p-24f; };
        texels.push_back({unit(h.x), 100 * unit(h.y), 1e-3f * unit(h.x ^ h.y), i % 3 == 0 ? 0.0f : 1.0f});
    }
    return texels;
}

constexpr int sizes[] = {2, 6, 8, 10, 14, 64, 74};

}  // namespace

TEST_CASE("reduction: boxes divide what is left, down to one texel", "[radiosity][HEM 6.7.1]") {
    using Boxes = std::vector<glm::ivec2>;
    CHECK(reduction_boxes(64, 2) == Boxes{{2, 2}, {2, 2}, {2, 2}, {2, 2}, {2, 2}, {2, 2}, {1, 3}});
    CHECK(reduction_boxes(64, 8) == Boxes{{8, 8}, {8, 8}, {1, 3}});
    CHECK(reduction_boxes(10, 4) == Boxes{{2, 2}, {5, 5}, {1, 3}});
    CHECK(reduction_boxes(74, 8) == Boxes{{2, 2}, {37, 37}, {1, 3}});
    for (int size = 2; size <= largest_hemicube; size += 2)
        for (const int most : {2, 3, 4, 8, 16, largest_hemicube}) {
            int columns = size, rows = 3 * size;
            for (const glm::ivec2 box : reduction_boxes(size, most)) {
                REQUIRE((columns % box.x == 0 && rows % box.y == 0));
                columns /= box.x, rows /= box.y;
            }
            REQUIRE((columns == 1 && rows == 1));
        }
    for (const int size : {0, 1, 7, 1026}) CHECK_THROWS_AS(reduction_boxes(size, 2), InputError);
    for (const int most : {-1, 0, 1, 1025}) CHECK_THROWS_AS(reduction_boxes(8, most), InputError);
}

TEST_CASE("reduction: an even room is its radiosity, and all of it is fronts", "[radiosity][HEM 5.5][analytic]") {
    for (const int size : sizes)
        for (const int box : {2, 8})
            for (const bool means : {false, true}) {
                const Buffer<glm::vec4> even(std::size_t(2 * 3 * size * size), glm::vec4(0.75f, 3, 1e6f, 1));
                const Buffer<glm::vec4> h = reduced_irradiance(size, even, texel_weights(size, Weights::exact), {box, means}, {});
                CAPTURE(size, box, means);
                REQUIRE(h.size() == 2);
                for (const glm::vec4& v : h) {
                    CHECK(v.x == Approx(0.75).epsilon(2e-6));
                    CHECK(v.y == Approx(3).epsilon(2e-6));
                    CHECK(v.z == Approx(1e6).epsilon(2e-6));
                    CHECK(v.w == Approx(1).epsilon(2e-6));
                }
            }
}

TEST_CASE("reduction: one lit texel brings its weight, to the bit, and to its hemicube alone", "[radiosity][HEM 5.5][analytic]") {
    const int size = 12, texels = 3 * size * size;
    const std::vector<double> weights = texel_weights(size, Weights::published);
    for (const int lit : {0, 11, 12, 143, 144, 200, 215, 216, 300, 431}) {
        Buffer<glm::vec4> drawn(std::size_t(3 * texels), glm::vec4(0));
        drawn[std::size_t(texels + lit)] = {1, 2, 0.5f, 1};
        for (const int box : {2, 4, 12}) {
            const Buffer<glm::vec4> h = reduced_irradiance(size, drawn, weights, {box}, {});
            const float w = float(weights[std::size_t(lit)]);
            CAPTURE(lit, box);
            CHECK((h[1] == glm::vec4(w, 2 * w, 0.5f * w, w)));
            CHECK((h[0] == glm::vec4(0) && h[2] == glm::vec4(0)));
        }
    }
}

TEST_CASE("reduction: the sum in double, to the rounding of a tree", "[radiosity][HEM 6.7.1]") {
    for (const int size : sizes) {
        const int texels = 3 * size * size, cubes = 3;
        const std::vector<double> weights = texel_weights(size, Weights::exact);
        const Buffer<glm::vec4> drawn = noise(cubes * texels, 7);
        for (const int box : {2, 4, 1024})
            for (const bool means : {false, true}) {
                const Buffer<glm::vec4> h = reduced_irradiance(size, drawn, weights, {box, means}, {});
                // A rounding for each addition on the way from a texel to the end, of weights, products and means.
                double roundings = 3;
                for (const glm::ivec2 b : reduction_boxes(size, box)) roundings += b.x * b.y + 1;
                for (int k = 0; k < cubes; ++k)
                    for (int c = 0; c < 4; ++c) {
                        double sum = 0;
                        for (int i = 0; i < texels; ++i) sum += weights[std::size_t(i)] * double(drawn[std::size_t(k * texels + i)][c]);
                        CAPTURE(size, box, means, k, c);
                        CHECK(std::fabs(double(h[std::size_t(k)][c]) - sum) <= roundings * 0x1p-24 * sum);
                    }
            }
    }
}

TEST_CASE("reduction: halves between passes lose sums' small terms, and means' hardly any", "[radiosity][HEM 6.7.1]") {
    const int size = 256;
    const std::vector<double> weights = texel_weights(size, Weights::exact);
    const float light = 0.001f;
    const Buffer<glm::vec4> dim(std::size_t(3 * size * size), glm::vec4(light, light, light, 1));
    const auto error = [&](bool means) {
        return std::fabs(double(reduced_irradiance(size, dim, weights, {2, means, Format::rgba16f}, {})[0].x) / double(light) - 1);
    };
    const double of_sums = error(false), of_means = error(true);
    CAPTURE(of_sums, of_means);
    // First sums are about 2e-7: three steps of the smallest half.
    CHECK(of_sums > 0.02);
    CHECK(of_means < 2e-3);
}

TEST_CASE("reduction: the published pass by it, as by sums in double", "[radiosity][HEM 5.6]") {
    const Scene scene = test::cube(3, {{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, {1, 0, 0, 0, 0, 0}});
    const Elements e = elements_of(scene, {});
    Buffer<glm::vec4> b, sums, reduced;
    for (int i = 0; i < e.count(); ++i) b.push_back({1 + float(i % 7), float(i % 3), 0.25f * float(i % 5), 0});
    PublishedPass pass{{16, Weights::exact}, {}, {}};
    published_irradiance(e, pass, b, 3, 20, {}, sums);
    pass.reduction.box = 2;
    const PassTimes times = published_irradiance(e, pass, b, 3, 20, {}, reduced);
    CHECK(times.sum_seconds > 0);
    REQUIRE(reduced.size() == 20);
    for (std::size_t i = 0; i < sums.size(); ++i)
        for (int c = 0; c < 3; ++c) CHECK(reduced[i][c] == Approx(sums[i][c]).epsilon(3e-6));
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            Buffer<glm::vec4> again;
            published_irradiance(e, pass, b, 3, 20, options, again);
            CHECK(std::memcmp(again.data(), reduced.data(), 20 * sizeof(glm::vec4)) == 0);
        }
}

TEST_CASE("reduction: refuses lists that do not fit", "[radiosity][bad input]") {
    const Buffer<glm::vec4> texels(2 * 48, glm::vec4(1));
    const Buffer<float> weights(48, 1.0f), few(47, 1.0f);
    CHECK_NOTHROW(data_of(ReduceInputs{&texels, 4, 12, &weights}));
    CHECK_THROWS_AS(data_of(ReduceInputs{nullptr, 4, 12, &weights}), InputError);
    CHECK_THROWS_AS(data_of(ReduceInputs{&texels, 4, 12, &few}), InputError);
    CHECK_THROWS_AS(data_of(ReduceInputs{&texels, 4, 12, &weights, {3, 2}}), InputError);
    CHECK_THROWS_AS(data_of(ReduceInputs{&texels, 5, 15, &weights}), InputError);
}
