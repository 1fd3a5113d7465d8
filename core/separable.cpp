#include "core/separable.h"

#include <algorithm>

#include "core/parallel.h"

namespace plumb::compare {

void filter_rows(Image<Lanes>& picture, const Taps& taps, int threads) {
    const int width = picture.width, radius = taps.radius, count = 2 * radius + 1;
    parallel_bands(picture.height, 16, threads, [&](int first, int last) {
        Buffer<Lanes> padded(std::size_t(width) + 2 * radius);
        for (int y = first; y < last; ++y) {
            // Repeat the outermost pixels on both sides, so that the sum needs no test of the border.
            Lanes* row = &picture(0, y);
            std::fill_n(padded.begin(), radius, row[0]);
            std::copy_n(row, width, padded.begin() + radius);
            std::fill_n(padded.end() - radius, radius, row[width - 1]);

            for (int x = 0; x < width; ++x) {
                Lanes sum{};
                for (int k = 0; k < count; ++k) sum += taps.weights[k] * padded[x + k];
                row[x] = sum;
            }
        }
    });
}

void filter_columns(const Image<Lanes>& picture, const Taps& taps, int y, Lanes* out) {
    const int width = picture.width, count = 2 * taps.radius + 1;
    Buffer<const Lanes*> rows(count);
    for (int k = 0; k < count; ++k) {
        rows[k] = &picture(0, std::clamp(y + k - taps.radius, 0, picture.height - 1));
    }
    for (int x = 0; x < width; ++x) {
        Lanes sum{};
        for (int k = 0; k < count; ++k) sum += taps.weights[k] * rows[k][x];
        out[x] = sum;
    }
}

}  // namespace plumb::compare
