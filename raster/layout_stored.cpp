// What a target gives back of what a compute stage stores there.
#include <cmath>
#include <mutex>

#include "core/parallel.h"
#include "core/quantise_kernel.h"
#include "raster/layout.h"

namespace plumb::raster {
namespace {

constexpr int band = 16;

glm::vec4 stored(Format format, const glm::vec4& v) {
    if (quantised_by_kernel(format)) return quantised<float>(format, v);
    glm::vec4 copy = v;
    plumb::quantise(format, copy);
    return copy;
}

bool overflows(float before, float after) { return std::isfinite(before) && !std::isfinite(after); }

// Calls one(x, y), which returns a value that did not fit, for all pixels; the first of them whatever band ends first.
template <class One>
std::optional<Overflow> first_overflow(glm::ivec2 size, int threads, One one) {
    std::optional<Overflow> first;
    std::mutex mutex;
    parallel_bands(size.y, band, threads, [&](int begin, int end) {
        std::optional<Overflow> found;
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < size.x; ++x) {
                const std::optional<float> value = one(x, y);
                if (value && !found) found = Overflow{{x, y}, *value};
            }
        const std::lock_guard lock(mutex);
        if (found && (!first || found->pixel.y < first->pixel.y)) first = found;
    });
    return first;
}

}  // namespace

std::optional<Overflow> quantise(Format format, Image4& image, int threads) {
    if (format == Format::rgba32f) return std::nullopt;
    return first_overflow({image.width, image.height}, threads, [&](int x, int y) {
        glm::vec4& v = image(x, y);
        const glm::vec4 before = v;
        v = stored(format, before);
        std::optional<float> value;
        for (int c = 3; c >= 0; --c)
            if (overflows(before[c], v[c])) value = before[c];
        return value;
    });
}

std::optional<Overflow> quantise(Format format, float* values, glm::ivec2 size, int threads) {
    if (format == Format::r32f) return std::nullopt;
    return first_overflow(size, threads, [&](int x, int y) {
        float& v = values[std::ptrdiff_t(y) * size.x + x];
        const float before = v;
        v = stored(format, {before, 0, 0, 1}).x;
        return overflows(before, v) ? std::optional(before) : std::nullopt;
    });
}

}  // namespace plumb::raster
