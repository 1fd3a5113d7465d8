#include "tools/plumb/verdict_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/host_math.h"
#include "tools/plumb/explain_pictures.h"

namespace plumb::cli {

namespace {

constexpr std::uint32_t rgb(std::uint32_t r, std::uint32_t g, std::uint32_t b) {
    return r | g << 8 | b << 16 | 0xff000000u;
}

// Told apart by who sees no red or green, too (Okabe and Ito 2008).
constexpr std::uint32_t colours[parity::verdicts] = {rgb(77, 86, 92), rgb(0, 114, 178), rgb(240, 228, 66),
                                                     rgb(213, 94, 0)};
// Of places that are wrong, the largest first.
struct PlaceColour {
    const char* name;
    std::uint32_t colour;
};
constexpr PlaceColour places[] = {{"orange", colours[int(parity::Verdict::wrong)]},
                                  {"purple", rgb(204, 121, 167)},
                                  {"sky blue", rgb(86, 180, 233)},
                                  {"green", rgb(0, 158, 115)}};
constexpr std::uint32_t black = rgb(0, 0, 0), white = rgb(255, 255, 255), red = rgb(213, 0, 0);

// A square around the pixel, drawn where it is inside.
void frame(Image<std::uint32_t>& image, glm::ivec2 pixel, int radius) {
    for (int d = -radius; d <= radius; ++d)
        for (const glm::ivec2 p : {pixel + glm::ivec2(d, -radius), pixel + glm::ivec2(d, radius),
                                   pixel + glm::ivec2(-radius, d), pixel + glm::ivec2(radius, d)})
            if (p.x >= 0 && p.y >= 0 && p.x < image.width && p.y < image.height) image(p.x, p.y) = white;
}

double value(const Array& array, std::size_t i) {
    std::int32_t bits;
    std::memcpy(&bits, array.bytes.data() + 4 * i, 4);
    float number;
    std::memcpy(&number, &bits, 4);
    return array.dtype == DType::f32 ? double(number) : double(bits);
}

std::size_t channels(const Array& array) { return array.shape.size() == 3 ? std::size_t(array.shape[2]) : 1; }

// One output beside ours.
struct Pair {
    const Array& got;
    const Array& expected;
    unsigned dumped;

    // NaN is larger than everything.
    double error(std::size_t pixel) const {
        double largest = 0;
        const std::size_t n = std::min(channels(got), channels(expected));
        for (std::size_t c = 0; c < n; ++c) {
            if (!(dumped >> c & 1)) continue;
            const double e = value(got, pixel * channels(got) + c) - value(expected, pixel * channels(expected) + c);
            if (!(std::abs(e) <= largest)) largest = std::abs(e);
            if (std::isnan(largest)) return largest;
        }
        return largest;
    }
    double largest_expected() const {
        double largest = 0;
        for (std::size_t i = 0; i < expected.bytes.size() / 4; ++i) {
            const double v = std::abs(value(expected, i));
            if (v > largest && std::isfinite(v)) largest = v;
        }
        return largest;
    }
};

std::uint32_t grey(double share) {
    if (std::isnan(share)) return red;
    if (share <= 0) return black;
    const double step = host::log2(share) / host::log2(1e8) + 1;  // 0 at 1e-8, 1 at 1
    const std::uint32_t level = 40 + std::uint32_t(215 * std::clamp(step, 0.0, 1.0));
    return rgb(level, level, level);
}

}  // namespace

Image<std::uint32_t> verdict_picture(const parity::StageVerdict& verdict, const parity::Diagnosis& diagnosis) {
    Image<std::uint32_t> image(verdict.map.width, verdict.map.height, black);
    for (std::size_t i = 0; i < image.size(); ++i)
        if (verdict.map.texels[i] < parity::verdicts) image.texels[i] = colours[verdict.map.texels[i]];
    const std::vector<parity::Cluster>& wrong = diagnosis.wrong.clusters;
    for (std::size_t i = 0; i < std::min(std::size(places), wrong.size()); ++i)
        for (const glm::ivec2 p : wrong[i].members) image(p.x, p.y) = places[i].colour;
    for (const parity::WorstPixel& worst : verdict.worst)
        if (worst.verdict != parity::Verdict::equal)
            for (int radius : {5, 6}) frame(image, worst.pixel, radius);
    return image;
}

Image<std::uint32_t> error_picture(const parity::StageVerdict& verdict, const std::vector<parity::Dumped>& dumped,
                                   const Bundle& expected) {
    std::vector<Pair> pairs;
    std::vector<double> scale;
    for (const parity::Dumped& d : dumped) {
        pairs.push_back({d.array, at(expected, d.output), d.channels});
        scale.push_back(pairs.back().largest_expected());
    }
    Image<std::uint32_t> image(verdict.map.width, verdict.map.height, black);
    for (std::size_t i = 0; i < image.size(); ++i) {
        const std::uint8_t v = verdict.map.texels[i];
        if (v == std::uint8_t(parity::Verdict::equal) || v >= parity::verdicts) continue;
        double largest = 0;
        for (std::size_t p = 0; p < pairs.size(); ++p) {
            const double share = pairs[p].error(i) / (scale[p] > 0 ? scale[p] : 1);
            if (!(share <= largest)) largest = share;
            if (std::isnan(largest)) break;
        }
        image.texels[i] = grey(largest);
    }
    return image;
}

std::string place_colour(std::size_t place) { return places[place < std::size(places) ? place : 0].name; }

std::vector<DrawnPicture> output_pictures(const StageBinding& binding, const std::vector<parity::Dumped>& dumped,
                                          const Bundle& expected) {
    constexpr int kept_texels = 512;
    std::vector<DrawnPicture> all;
    for (const Slot& slot : binding.outputs) {
        const auto d = std::find_if(dumped.begin(), dumped.end(),
                                    [&](const parity::Dumped& one) { return one.output == slot.name; });
        if (d == dumped.end()) continue;
        const Array& ours = at(expected, slot.name);
        // Of what was not dumped nothing can be shown, and an output of other components has other colours.
        if (d->array.shape != ours.shape || layers_of(slot, ours) != 1) continue;
        for (const bool is_ours : {true, false}) {
            const SlotPicture picture = slot_picture_like(slot, is_ours ? ours : d->array, ours, 0);
            const int by = reduction(picture.texels, kept_texels);
            all.push_back({reduced(picture.texels, by),
                           fmt::format("{}: {}{}; {}", is_ours ? "Expected" : "Got, in the same colours", picture.name,
                                       by > 1 ? fmt::format(", shown at 1/{}", by) : "", picture.mapping),
                           {}});
        }
    }
    return all;
}

}  // namespace plumb::cli
