#include "raster/mips.h"

#include <algorithm>

#include "core/parallel.h"

namespace plumb::raster {
namespace {

constexpr int band_rows = 16;

// The texels of `size` that texel i of the next smaller side is made of. Where size = 2 m + 1, it covers the part from
// i (2 + 1/m) to (i + 1) (2 + 1/m): weights are lengths times m. They are whole numbers, so that equal texels give the
// same value again, exactly.
struct Span {
    int first, count;
    double weight[3], total;
};
Span span_of(int i, int size) {
    if (size == 1) return {0, 1, {1, 0, 0}, 1};
    if (size % 2 == 0) return {2 * i, 2, {1, 1, 0}, 2};
    const int m = size / 2;
    return {2 * i, 3, {double(m - i), double(m), double(i + 1)}, double(size)};
}

// texel(x, y): the linear value of a level of width x height.
template <class Texel>
Image4 halved(int width, int height, const Texel& texel) {
    Image4 half(std::max(width / 2, 1), std::max(height / 2, 1));
    parallel_bands(half.height, band_rows, 0, [&](int begin, int end) {
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < half.width; ++x) {
                const Span across = span_of(x, width), down = span_of(y, height);
                glm::dvec4 mean(0);
                for (int j = 0; j < down.count; ++j) {
                    glm::dvec4 row(0);
                    for (int i = 0; i < across.count; ++i)
                        row += across.weight[i] * glm::dvec4(texel(across.first + i, down.first + j));
                    mean += down.weight[j] * (row / across.total);
                }
                half(x, y) = glm::vec4(mean / down.total);
            }
    });
    return half;
}

std::uint32_t nearest_code(const float* table, float value) {
    const auto above = std::uint32_t(std::lower_bound(table + 1, table + 255, value) - table);
    return value - table[above - 1] <= table[above] - value ? above - 1 : above;
}

Image<std::uint32_t> encoded(const Image4& level, const float* colour, const float* alpha) {
    Image<std::uint32_t> out(level.width, level.height);
    parallel_bands(level.height, band_rows, 0, [&](int begin, int end) {
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < level.width; ++x) {
                const glm::vec4& c = level(x, y);
                out(x, y) = nearest_code(colour, c.x) | nearest_code(colour, c.y) << 8 |
                            nearest_code(colour, c.z) << 16 | nearest_code(alpha, c.w) << 24;
            }
    });
    return out;
}

}  // namespace

std::vector<Image<std::uint32_t>> smaller_levels(const Texture& texture, const Buffer<float>& decode) {
    const Image<std::uint32_t>& image = texture.texels;
    const float *alpha = decode.data(), *colour = decode.data() + (texture.srgb ? 256 : 0);
    std::vector<Image<std::uint32_t>> levels;
    if (image.width == 1 && image.height == 1) return levels;
    Image4 level = halved(image.width, image.height, [&](int x, int y) {
        const std::uint32_t t = image(x, y);
        return glm::vec4(colour[t & 255], colour[t >> 8 & 255], colour[t >> 16 & 255], alpha[t >> 24]);
    });
    levels.push_back(encoded(level, colour, alpha));
    while (level.width > 1 || level.height > 1) {
        level = halved(level.width, level.height, [&](int x, int y) { return level(x, y); });
        levels.push_back(encoded(level, colour, alpha));
    }
    return levels;
}

}  // namespace plumb::raster
