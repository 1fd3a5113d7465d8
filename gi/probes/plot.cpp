#include "gi/probes/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb::probes {

namespace {

constexpr int scale = 2, glyph_width = 3, glyph_height = 5, step = (glyph_width + 1) * scale;
constexpr glm::vec4 ink(0.1f, 0.1f, 0.1f, 1), pale(0.88f, 0.88f, 0.88f, 1);

// Five rows of three bits, the top one first, the leftmost bit highest.
std::uint32_t glyph(char c) {
    switch (c) {
        case '0': return 075557;
        case '1': return 026227;
        case '2': return 071747;
        case '3': return 071717;
        case '4': return 055711;
        case '5': return 074717;
        case '6': return 074757;
        case '7': return 071122;
        case '8': return 075757;
        case '9': return 075717;
        case '-': return 000700;
        case '/': return 011244;
        case 'e': return 003743;
        case 'i': return 020222;
        case 's': return 003636;
        default: return 0;
    }
}

int width_of(const std::string& text) { return int(text.size()) * step - scale; }

}  // namespace

Plot::Plot(glm::ivec2 size, const PlotAxes& axes)
    : picture_(size.x, size.y, glm::vec4(1)), low_(56, 24), high_(size.x - 16, size.y - 40) {
    const int half = glyph_height * scale / 2;
    for (const PlotTick& t : axes.across) {
        const int x = texel({t.at, 0}).x;
        for (int y = low_.y; y <= high_.y; ++y) picture_(x, y) = pale;
        for (int y = high_.y; y < high_.y + 5; ++y) picture_(x, y) = ink;
        write({x - width_of(t.label) / 2, high_.y + 8}, t.label);
    }
    for (const PlotTick& t : axes.upwards) {
        const int y = texel({0, t.at}).y;
        for (int x = low_.x; x <= high_.x; ++x) picture_(x, y) = pale;
        for (int x = low_.x - 4; x <= low_.x; ++x) picture_(x, y) = ink;
        write({low_.x - 8 - width_of(t.label), y - half}, t.label);
    }
    for (int x = low_.x; x <= high_.x; ++x) picture_(x, high_.y) = ink;
    for (int y = low_.y; y <= high_.y; ++y) picture_(low_.x, y) = ink;
    write({(low_.x + high_.x) / 2, size.y - 4 - glyph_height * scale}, axes.across_name);
    write({4, 4}, axes.upwards_name);
}

glm::ivec2 Plot::texel(glm::dvec2 at) const {
    const glm::dvec2 extent(high_ - low_);
    return {low_.x + int(std::floor(at.x * extent.x + 0.5)), high_.y - int(std::floor(at.y * extent.y + 0.5))};
}

void Plot::write(glm::ivec2 at, const std::string& text) {
    for (const char c : text) {
        const std::uint32_t bits = glyph(c);
        for (int y = 0; y < glyph_height * scale; ++y)
            for (int x = 0; x < glyph_width * scale; ++x) {
                const int bit = (glyph_height - 1 - y / scale) * glyph_width + glyph_width - 1 - x / scale;
                const glm::ivec2 p = at + glm::ivec2(x, y);
                if (bits >> bit & 1 && p.x >= 0 && p.y >= 0 && p.x < picture_.width && p.y < picture_.height) picture_(p.x, p.y) = ink;
            }
        at.x += step;
    }
}

void Plot::curve(const std::vector<glm::dvec2>& points, const glm::vec4& colour) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const glm::dvec2 pixels = glm::abs(points[i + 1] - points[i]) * glm::dvec2(high_ - low_);
        const int steps = 1 + int(std::min(1e6, 4 * std::max(pixels.x, pixels.y)));
        for (int k = 0; k <= steps; ++k) {
            const glm::dvec2 at = points[i] + (double(k) / steps) * (points[i + 1] - points[i]);
            if (!(at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1)) continue;
            const glm::ivec2 p = texel(at);
            picture_(p.x, p.y) = colour;
        }
    }
}

}  // namespace plumb::probes
