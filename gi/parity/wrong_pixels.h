// What the wrong pixels of a verdict have in common: got / expected, where they lie, and which of them lie together.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb::parity {

struct Pair;  // pair.h

// got / expected of one component, over wrong pixels where neither is 0 and both are numbers.
struct Ratios {
    std::string output;
    int channel = 0;
    std::int64_t differing = 0;         // wrong pixels where it differs from ours, in any way
    std::int64_t counted = 0;           // of these, where there is a ratio
    std::int64_t got_zero = 0;          // where more than 0 is expected, and got is 0
    std::array<double, 3> quartiles{};  // lower, median, upper
    // Whether it is one number but for rounding: half of all lie within a thousandth of the median.
    bool constant() const;
};

// Wrong pixels that touch: no two more than `reach` pixels apart are joined.
struct Cluster {
    std::int64_t pixels = 0;
    glm::ivec2 low{0}, high{0};       // both inside
    std::vector<glm::ivec2> members;  // in order of rows; all of them
};

// One pixel by the size of its error.
struct LargeError {
    glm::ivec2 pixel{0};
    std::string output;
    int channel = 0;
    double expected = 0, got = 0;
};

struct WrongPixels {
    std::int64_t pixels = 0;  // that are wrong and were written
    glm::ivec2 low{0}, high{0};
    std::vector<Ratios> ratios;       // of components that differ at any wrong pixel
    std::vector<Cluster> clusters;    // the largest first
    std::vector<LargeError> largest;  // by |got - expected|, the largest first; NaN before all
    std::int64_t unexpected = 0;      // wrong pixels where no more than 0 is expected
    std::vector<LargeError> unexpected_largest;
};

inline constexpr int cluster_reach = 3;

// `wrong`: [height][width], 1 where a pixel is wrong and was written. `rows`: how many of the largest errors are kept.
WrongPixels wrong_pixels(const std::vector<Pair>& pairs, glm::ivec2 size, const std::vector<std::uint8_t>& wrong,
                         int rows);
// The ratios of a part of the pixels.
std::vector<Ratios> ratios_of(const std::vector<Pair>& pairs, int width, const std::vector<glm::ivec2>& pixels);

}  // namespace plumb::parity
