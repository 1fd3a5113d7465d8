#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/hash.h"

using namespace plumb;

namespace {

// The generators as their authors write them, on unsigned words.
std::uint32_t pcg_reference(std::uint32_t v) {
    const std::uint32_t state = v * 747796405u + 2891336453u;
    const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
struct Words {
    std::uint32_t x, y, z;
};
Words pcg3d_reference(Words v) {
    v.x = v.x * 1664525u + 1013904223u, v.y = v.y * 1664525u + 1013904223u, v.z = v.z * 1664525u + 1013904223u;
    v.x += v.y * v.z, v.y += v.z * v.x, v.z += v.x * v.y;
    v.x ^= v.x >> 16u, v.y ^= v.y >> 16u, v.z ^= v.z >> 16u;
    v.x += v.y * v.z, v.y += v.z * v.x, v.z += v.x * v.y;
    return v;
}

std::uint32_t hash(std::uint32_t v) { return std::uint32_t(pcg(std::int32_t(v))); }

// Chi-square of counts that should be equal; its mean is the number of bins, its deviation sqrt(2 bins).
double chi_square(const std::vector<int>& counts, double expected) {
    double sum = 0;
    for (int n : counts) sum += (n - expected) * (n - expected) / expected;
    return sum;
}

}  // namespace

TEST_CASE("hash: pcg is the published function", "[hash]") {
    for (std::uint32_t i = 0; i < 1u << 20; ++i) {
        REQUIRE(hash(i) == pcg_reference(i));
        REQUIRE(hash(i * 0x9e3779b9u) == pcg_reference(i * 0x9e3779b9u));
    }
    // Worked out apart, in Python's integers.
    CHECK(hash(0) == 129708002u);
    CHECK(hash(1) == 2831084092u);
    CHECK(hash(0xffffffffu) == 3861530882u);
}

TEST_CASE("hash: pcg3d is the published function", "[hash]") {
    for (std::uint32_t i = 0; i < 1u << 16; ++i) {
        const Words v{i, i * 7919u + 3, ~i * 104729u};
        const Words expected = pcg3d_reference(v);
        const auto got = pcg3d(std::int32_t(v.x), std::int32_t(v.y), std::int32_t(v.z));
        REQUIRE(std::uint32_t(got.x) == expected.x);
        REQUIRE(std::uint32_t(got.y) == expected.y);
        REQUIRE(std::uint32_t(got.z) == expected.z);
    }
    const auto v = pcg3d(1, 2, 3);
    CHECK(std::uint32_t(v.x) == 4204755366u);
    CHECK(std::uint32_t(v.y) == 1223881804u);
    CHECK(std::uint32_t(v.z) == 1500469937u);
}

TEST_CASE("hash: pcg maps different words to different words", "[hash]") {
    // The multiplication, the addition and the permutation can each be undone; here on 2^22 consecutive words.
    std::vector<std::uint32_t> words(1 << 22);
    for (std::uint32_t i = 0; i < words.size(); ++i) words[i] = hash(i);
    std::sort(words.begin(), words.end());
    CHECK(std::adjacent_find(words.begin(), words.end()) == words.end());
}

TEST_CASE("hash: unit_float is in [0, 1), a multiple of 2^-24", "[hash]") {
    CHECK(unit_float<float>(0) == 0);
    CHECK(unit_float<float>(-1) == 1 - 0x1p-24f);
    CHECK(unit_float<float>(std::int32_t(0x80000000)) == 0.5f);
    CHECK(unit_float<float>(255) == 0);
    CHECK(unit_float<float>(256) == 0x1p-24f);
    CHECK(unit_float<double>(-1) == 1 - 0x1p-24);
}

TEST_CASE("hash: numbers of neighbouring pixels and samples are uniform", "[hash]") {
    // 2^20 numbers in 1024 bins, for each of the three words: chi-square within five deviations of its mean.
    const int bins = 1024, width = 128, height = 128, samples = 64;
    std::vector<int> counts[3] = {std::vector<int>(bins), std::vector<int>(bins), std::vector<int>(bins)};
    std::vector<int> pairs(bins);
    double sum = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int s = 0; s < samples; ++s) {
                const auto h = pixel_hash(x, y, s, 1);
                const float u[] = {unit_float<float>(h.x), unit_float<float>(h.y), unit_float<float>(h.z)};
                for (int c = 0; c < 3; ++c) ++counts[c][int(u[c] * bins)];
                ++pairs[int(u[0] * 32) * 32 + int(u[1] * 32)];
                sum += u[0];
            }
    const double n = double(width) * height * samples;
    for (const auto& c : counts) CHECK(std::fabs(chi_square(c, n / bins) - bins) < 5 * std::sqrt(2. * bins));
    CHECK(std::fabs(chi_square(pairs, n / bins) - bins) < 5 * std::sqrt(2. * bins));
    CHECK(std::fabs(sum / n - 0.5) < 5 / std::sqrt(12 * n));
}

TEST_CASE("hash: flipping any input bit flips each upper output bit about half of the time", "[hash]") {
    // 2^14 trials a pair: the standard deviation of a share is 1/256. Only the 24 bits that become a float count.
    const int trials = 1 << 14;
    double worst = 0;
    for (int argument = 0; argument < 4; ++argument)
        for (int bit = 0; bit < 16; ++bit) {
            int flipped[24] = {};
            for (int t = 0; t < trials; ++t) {
                std::int32_t v[4];
                for (int i = 0; i < 4; ++i) v[i] = std::int32_t(pcg_reference(std::uint32_t(4 * t + i)) >> 16);
                const auto before = pixel_hash(v[0], v[1], v[2], v[3]);
                v[argument] ^= 1 << bit;
                const auto after = pixel_hash(v[0], v[1], v[2], v[3]);
                const std::uint32_t change = std::uint32_t(before.x ^ after.x);
                for (int b = 0; b < 24; ++b) flipped[b] += change >> (b + 8) & 1;
            }
            for (int n : flipped) worst = std::max(worst, std::fabs(double(n) / trials - 0.5));
        }
    CAPTURE(worst);
    CHECK(worst < 6. / 256);
    CHECK(worst > 0);
}

TEST_CASE("hash: seeds give streams without correlation", "[hash]") {
    double sum = 0;
    const int n = 1 << 16;
    for (int i = 0; i < n; ++i) {
        const float a = unit_float<float>(pixel_hash(i & 255, i >> 8, 0, 1).x);
        const float b = unit_float<float>(pixel_hash(i & 255, i >> 8, 0, 2).x);
        sum += (a - 0.5) * (b - 0.5) * 12;
    }
    CHECK(std::fabs(sum / n) < 5 / std::sqrt(n));
}
