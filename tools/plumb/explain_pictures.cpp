#include "tools/plumb/explain_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/host_math.h"

namespace plumb::cli {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t magenta = 0xffff00ffu, opaque = 0xff000000u;

// How numbers become colours.
enum class Shown {
    bounds,     // each component from its least value to its largest
    direction,  // 0.5 + 0.5 n
    grey,       // one component, linear from its least value to its largest
    share,      // one component, 0 black and 1 white
    exposed,    // radiometric: the 99th percentile white, sRGB
    linear,     // 0..1, sRGB
    as_it_is,   // 0..1, encoded already
    indices,    // a colour each
};

struct Layer {
    const Slot& slot;
    const Array& array;
    int width = 0, height = 0, channels = 1;
    std::size_t offset = 0;  // elements in front of it

    double at(std::size_t texel, int c) const {
        const unsigned char* p =
            array.bytes.data() + 4 * (offset + texel * std::size_t(channels) + std::size_t(c));
        std::int32_t i;
        float f;
        std::memcpy(&i, p, 4), std::memcpy(&f, p, 4);
        if (array.dtype == DType::f32) return double(f);
        return array.dtype == DType::u32 ? double(std::uint32_t(i)) : double(i);
    }
    std::size_t texels() const { return std::size_t(width) * std::size_t(height); }
};

Layer layer_of(const Slot& slot, const Array& array, int layer) {
    const glm::ivec2 size = layer_size(slot, array);
    Layer out{slot, array, size.x, size.y};
    if (slot.kind == SlotKind::image_array)
        out.offset = std::size_t(layer) * out.texels();
    else if (array.shape.size() == 3)
        out.channels = int(array.shape[2]);
    return out;
}

bool starts(const std::string& text, const char* with) { return text.rfind(with, 0) == 0; }
bool holds(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

struct Range {
    double least = nan, largest = nan;
    std::size_t odd = 0;  // not finite

    void add(double v) {
        if (!std::isfinite(v)) {
            ++odd;
            return;
        }
        if (!(least <= v)) least = v;
        if (!(largest >= v)) largest = v;
    }
    double place(double v) const { return largest > least ? (v - least) / (largest - least) : v > 0 ? 1.0 : 0.0; }
    std::string text() const { return std::isnan(least) ? "no number" : fmt::format("{:.5g} to {:.5g}", least, largest); }
};

// The sRGB curve (IEC 61966-2-1), 0..1.
std::uint32_t encoded(double linear) {
    static const std::array<std::uint8_t, 4097> table = [] {
        std::array<std::uint8_t, 4097> t{};
        for (std::size_t i = 0; i < t.size(); ++i) {
            const double c = double(i) / 4096;
            t[i] = std::uint8_t(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * host::pow(c, 1 / 2.4) - 0.055) + 0.5);
        }
        return t;
    }();
    return table[std::size_t(4096 * std::clamp(linear, 0.0, 1.0) + 0.5)];
}
std::uint32_t plain(double v) { return std::uint32_t(255 * std::clamp(v, 0.0, 1.0) + 0.5); }

// A layer's way into colours, decided once from all of its texels.
struct Mapping {
    Shown shown = Shown::linear;
    int first = 0, components = 3;
    std::array<Range, 4> ranges{};
    double white = 1;
    std::size_t odd = 0;

    explicit Mapping(const Layer& l) {
        choose(l);
        const bool depths = shown == Shown::grey && first == 3;
        for (std::size_t i = 0; i < l.texels(); ++i) {
            // 0 stands for nothing in positions and depths.
            if (shown == Shown::bounds && l.at(i, 0) == 0 && l.at(i, 1) == 0 && l.at(i, 2) == 0) continue;
            if (depths && l.at(i, 3) == 0) continue;
            for (int c = 0; c < components; ++c) ranges[std::size_t(c)].add(l.at(i, first + c));
        }
        for (const Range& r : ranges) odd += r.odd;
        if (shown == Shown::exposed) white = percentile(l);
        // Of small shares, as texels have of a hemisphere, nothing would be seen from 0 to 1.
        const bool seen = ranges[0].largest == 0 || ranges[0].largest > 0.1;
        if (shown == Shown::grey && ranges[0].least >= 0 && ranges[0].largest <= 1 && seen) shown = Shown::share;
        if (shown == Shown::linear)
            for (int c = 0; c < components; ++c)
                if (ranges[std::size_t(c)].least < 0 || ranges[std::size_t(c)].largest > 1) shown = Shown::bounds;
    }

    void choose(const Layer& l) {
        const Slot& s = l.slot;
        components = std::min(l.channels, 3);
        if (l.array.dtype != DType::f32)
            shown = Shown::indices;
        else if (l.channels == 1)
            shown = Shown::grey;
        else if (starts(s.unit, "W"))
            shown = Shown::exposed;  // light is what is looked at, whatever its w holds
        else if (starts(s.meaning, "w:") && l.channels == 4)
            shown = Shown::grey, first = 3, components = 1;
        else if (holds(s.name, "normal"))
            shown = Shown::direction;
        else if (s.unit == "m")
            shown = Shown::bounds;
        else if (s.name == "display")
            shown = Shown::as_it_is;
        if (l.channels == 2 && shown != Shown::indices) shown = Shown::bounds;
        // Normals whose w alone is read are normals all the same.
        if (holds(s.name, "normal") && l.channels == 4) shown = Shown::direction, first = 0, components = 3;
    }

    // Of what is there at all.
    double percentile(const Layer& l) const {
        std::vector<double> brightest;
        for (std::size_t i = 0; i < l.texels(); ++i) {
            double most = 0;
            for (int c = 0; c < components; ++c) most = std::max(most, l.at(i, c));
            if (most > 0 && std::isfinite(most)) brightest.push_back(most);
        }
        if (brightest.empty()) return 1;
        const auto at = brightest.begin() + std::ptrdiff_t(0.99 * double(brightest.size() - 1));
        std::nth_element(brightest.begin(), at, brightest.end());
        return *at;
    }

    std::uint32_t colour(const Layer& l, std::size_t texel) const {
        if (shown == Shown::indices) {
            const double index = l.at(texel, l.channels - 1);
            return index < 0 ? opaque : opaque | (std::uint32_t(std::int64_t(index)) * 2654435761u >> 8);
        }
        std::uint32_t c[3] = {0, 0, 0};
        for (int k = 0; k < components; ++k) {
            const double v = l.at(texel, first + k);
            if (!std::isfinite(v)) return magenta;
            const Range& r = ranges[std::size_t(k)];
            switch (shown) {
                case Shown::bounds: case Shown::grey: c[k] = plain(r.place(v)); break;
                case Shown::direction: c[k] = plain(0.5 + 0.5 * v); break;
                case Shown::share: case Shown::as_it_is: c[k] = plain(v); break;
                case Shown::exposed: c[k] = encoded(v / white); break;
                default: c[k] = encoded(v);
            }
        }
        if (components == 1) c[1] = c[2] = c[0];
        return opaque | c[0] | c[1] << 8 | c[2] << 16;
    }

    std::string text() const {
        std::string values;
        for (int c = 0; c < components; ++c)
            values += fmt::format("{}{}", c > 0 ? "; " : "", ranges[std::size_t(c)].text());
        if (odd > 0) values += fmt::format("; {} not finite, magenta", odd);
        switch (shown) {
            case Shown::bounds: return "each component from its least value, dark, to its largest, light: " + values;
            case Shown::direction: return "as 0.5 + 0.5 n; " + values;
            case Shown::grey:
                return fmt::format("{}linear from least, black, to largest, white: {}", first == 3 ? "w, " : "", values);
            case Shown::share: return "0 black, 1 white: " + values;
            case Shown::exposed:
                return fmt::format("white is {:.4g}, the 99th percentile of what is not 0, by the sRGB curve: {}", white,
                                   values);
            case Shown::linear: return "0 black, 1 white, by the sRGB curve: " + values;
            case Shown::as_it_is: return "0 black, 1 white, as encoded: " + values;
            case Shown::indices: return "a colour for each number, black below 0: " + values;
        }
        return values;
    }
};

std::string name_text(const Slot& slot, int layer) {
    std::string text = slot.name;
    if (slot.kind == SlotKind::image_array) text += fmt::format(" {}", layer);
    if (!slot.unit.empty()) text += fmt::format(" ({})", slot.unit);
    return slot.meaning.empty() ? text : text + ": " + slot.meaning;
}

}  // namespace

int layers_of(const Slot& slot, const Array& array) {
    if (slot.kind == SlotKind::buffer || dtype_size(array.dtype) != 4 || array.bytes.empty()) return 0;
    if (slot.kind == SlotKind::image_array) return array.shape.size() == 3 ? int(array.shape[0]) : 0;
    return array.shape.size() == 2 || (array.shape.size() == 3 && array.shape[2] > 0) ? 1 : 0;
}

glm::ivec2 layer_size(const Slot& slot, const Array& array) {
    const std::size_t skip = slot.kind == SlotKind::image_array ? 1 : 0;
    return {int(array.shape.at(skip + 1)), int(array.shape.at(skip))};
}

SlotPicture slot_picture(const Slot& slot, const Array& array, int layer) {
    return slot_picture_like(slot, array, array, layer);
}

SlotPicture slot_picture_like(const Slot& slot, const Array& array, const Array& like, int layer) {
    const Layer l = layer_of(slot, array, layer);
    const Mapping mapping(layer_of(slot, like, layer));
    Image<std::uint32_t> whole(l.width, l.height);
    for (std::size_t i = 0; i < whole.size(); ++i) whole.texels[i] = mapping.colour(l, i);
    return {std::move(whole), name_text(slot, layer), mapping.text()};
}

int reduction(const Image<std::uint32_t>& image, int most) {
    return std::max(1, (std::max(image.width, image.height) + most - 1) / most);
}

// At the border the mean of those that are there.
Image<std::uint32_t> reduced(const Image<std::uint32_t>& image, int by) {
    if (by == 1) return image;
    Image<std::uint32_t> to((image.width + by - 1) / by, (image.height + by - 1) / by);
    for (int y = 0; y < to.height; ++y)
        for (int x = 0; x < to.width; ++x) {
            std::uint32_t sum[4] = {}, n = 0;
            for (int v = y * by; v < std::min((y + 1) * by, image.height); ++v)
                for (int u = x * by; u < std::min((x + 1) * by, image.width); ++u, ++n)
                    for (int c = 0; c < 4; ++c) sum[c] += image(u, v) >> (8 * c) & 255u;
            for (int c = 0; c < 4; ++c) to(x, y) |= (sum[c] + n / 2) / n << (8 * c);
        }
    return to;
}

Image<std::uint32_t> crop(const Image<std::uint32_t>& image, glm::ivec2 first, glm::ivec2 size) {
    Image<std::uint32_t> out(size.x, size.y, opaque);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const glm::ivec2 p = first + glm::ivec2(x, y);
            if (p.x >= 0 && p.y >= 0 && p.x < image.width && p.y < image.height) out(x, y) = image(p.x, p.y);
        }
    return out;
}

std::string buffer_text(const Slot& slot, const Array& array) {
    std::string text = fmt::format("{}{}: {} {}", slot.name, slot.unit.empty() ? "" : fmt::format(" ({})", slot.unit),
                                   shape_text(array.shape), dtype_name(array.dtype));
    if (array.dtype == DType::f32) {
        Range range;
        for (std::size_t i = 0; i < array.bytes.size() / 4; ++i) {
            float f;
            std::memcpy(&f, array.bytes.data() + 4 * i, 4);
            range.add(f);
        }
        text += ", " + range.text();
    }
    return slot.meaning.empty() ? text : text + "; " + slot.meaning;
}

}  // namespace plumb::cli
