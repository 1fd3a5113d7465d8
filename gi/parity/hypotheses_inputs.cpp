#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "core/parallel.h"
#include "gi/parity/hypothesis.h"
#include "gi/parity/slot_texels.h"
#include "gi/parity/texel_changes.h"
#include "gi/parity/uniform_rows.h"

namespace plumb::parity {

namespace {

Array* find_array(StageData& data, const std::string& name) {
    for (Array& a : data.inputs.arrays)
        if (a.name == name) return &a;
    return nullptr;
}

float* numbers_of(Array& array) { return reinterpret_cast<float*>(array.bytes.data()); }

class InputHypotheses {
  public:
    InputHypotheses(const StageBinding& binding, const StageData& data) : binding_(binding), data_(data) {}

    std::vector<Hypothesis> all() {
        for (const Slot& slot : binding_.inputs) {
            const Array* array = find(data_.inputs, slot.name);
            if (!array || array->bytes.empty()) continue;
            // A list of flags and whole numbers alone is no quantity.
            if (slot.kind == SlotKind::buffer && slot.fixed == (1u << slot.channels) - 1) continue;
            if (slot.dtype == DType::f32) {
                const Texels texels = texels_of(slot, *array);
                if (slot.kind != SlotKind::buffer) add_places(slot, texels);
                add_channels(slot, texels);
                add_factors(slot, texels);
                add_curves(slot, texels);
                if (slot.kind == SlotKind::buffer) add_rows(slot, *array);
                if (slot.kind == SlotKind::buffer && slot.channels == 1) add_lists(slot, texels);
                if (slot.kind == SlotKind::buffer && slot.channels == 2 && slot.unit == "texels")
                    add_sub_texels(slot, texels);
            } else if (slot.kind == SlotKind::buffer && slot.name == "offsets") {
                add_offsets(slot);
                add_rows(slot, *array);
            }
        }
        add_exchanges();
        return std::move(all_);
    }

    // Images of the frame some pixels away, and maps with something beyond their border.
    std::vector<Hypothesis> far() {
        for (const Slot& slot : binding_.inputs) {
            const Array* array = find(data_.inputs, slot.name);
            if (!array || array->bytes.empty() || slot.dtype != DType::f32) continue;
            const Texels texels = texels_of(slot, *array);
            if (is_of_frame(slot, texels)) add_far_places(slot, texels);
        }
        for (const Rows& rows : find_rows(binding_, data_))
            if (!rows.size.empty()) add_borders(rows);
        return std::move(all_);
    }

  private:
    void add(const std::string& text, double slack, std::function<bool(StageData&)> change) {
        Hypothesis h{text};
        h.change = std::move(change);
        h.slack = slack;
        all_.push_back(std::move(h));
    }

    // Changes each texel; what is 0 in all of x, y and z is nothing, and stays.
    void each(const Slot& slot, const Texels& t, const std::string& what, double slack,
              std::function<void(float*)> change) {
        auto one = [n = t.channels, change](float* p) {
            if (std::any_of(p, p + std::min<std::size_t>(n, 3), [](float x) { return x != 0; })) change(p);
        };
        add(slot.name + " " + what, slack, [name = slot.name, t, one](StageData& data) {
            float* p = numbers_of(*find_array(data, name));
            parallel_bands(int(t.count()), 4096, 0, [&](int first, int last) {
                for (std::size_t i = std::size_t(first); i < std::size_t(last); ++i) one(p + i * t.channels);
            });
            return true;
        });
        if (is_of_frame(slot, t))
            all_.back().texels = {slot.name, t.channels, [one](const float*, glm::ivec2, float* p) { one(p); }};
    }
    // What a shader makes of a vector whose cosine it does not keep at 0 and above. What is linear in max(0, c) of it
    // is, for |c|, the sum of both signs, and for c their difference.
    void add_sides(const Slot& slot, const Texels& t) {
        for (const int sign : {1, -1}) {
            each(slot, t, sign > 0 ? "from both sides (abs for max(0, .))" : "from behind less than 0 (no max(0, .))",
                 computed_slack, [](float* p) {
                     for (int c = 0; c < 3; ++c) p[c] = -p[c];
                 });
            all_.back().added = sign;
        }
    }

    bool is_of_frame(const Slot& slot, const Texels& t) const {
        return slot.frame && slot.kind == SlotKind::image && t.width == std::size_t(data_.size.x) &&
               t.height == std::size_t(data_.size.y);
    }

    // ---- Places: each texel takes the mean of some others, within the layer; beyond the edge lies the edge.

    using Place = std::function<std::array<std::ptrdiff_t, 2>(std::ptrdiff_t x, std::ptrdiff_t y)>;
    void moved(const Slot& slot, const Texels& t, const std::string& what, const Place& place) {
        add(slot.name + " " + what, 0, [name = slot.name, t, place](StageData& data) {
            Array& array = *find_array(data, name);
            const std::vector<unsigned char> old(array.bytes.begin(), array.bytes.end());
            const float* from = reinterpret_cast<const float*>(old.data());
            float* to = numbers_of(array);
            const std::ptrdiff_t w = std::ptrdiff_t(t.width), h = std::ptrdiff_t(t.height);
            for (std::size_t l = 0; l < t.layers; ++l)
                for (std::ptrdiff_t y = 0; y < h; ++y)
                    for (std::ptrdiff_t x = 0; x < w; ++x) {
                        const auto [px, py] = place(x, y);
                        const std::size_t source = t.at(l, std::size_t(std::clamp<std::ptrdiff_t>(py, 0, h - 1)),
                                                        std::size_t(std::clamp<std::ptrdiff_t>(px, 0, w - 1)));
                        std::memcpy(to + t.at(l, std::size_t(y), std::size_t(x)), from + source, 4 * t.channels);
                    }
            return true;
        });
        if (is_of_frame(slot, t))
            all_.back().texels = {slot.name, t.channels, [t, place](const float* image, glm::ivec2 at, float* p) {
                                      const auto [x, y] = place(at.x, at.y);
                                      const std::ptrdiff_t w = std::ptrdiff_t(t.width), h = std::ptrdiff_t(t.height);
                                      std::memcpy(p,
                                                  image + t.at(0, std::size_t(std::clamp<std::ptrdiff_t>(y, 0, h - 1)),
                                                               std::size_t(std::clamp<std::ptrdiff_t>(x, 0, w - 1))),
                                                  4 * t.channels);
                                  }};
    }

    // Bilinear between texels: half of each neighbour in a direction.
    void between(const Slot& slot, const Texels& t, std::ptrdiff_t dx, std::ptrdiff_t dy) {
        const std::string text =
            fmt::format("{} filtered half a texel off ({:g}, {:g})", slot.name, 0.5 * double(dx), 0.5 * double(dy));
        add(text, computed_slack, [name = slot.name, t, dx, dy](StageData& data) {
            Array& array = *find_array(data, name);
            const std::vector<unsigned char> old(array.bytes.begin(), array.bytes.end());
            const float* from = reinterpret_cast<const float*>(old.data());
            float* to = numbers_of(array);
            const std::ptrdiff_t w = std::ptrdiff_t(t.width), h = std::ptrdiff_t(t.height);
            auto texel = [&](std::size_t l, std::ptrdiff_t x, std::ptrdiff_t y) {
                return from + t.at(l, std::size_t(std::clamp<std::ptrdiff_t>(y, 0, h - 1)),
                                   std::size_t(std::clamp<std::ptrdiff_t>(x, 0, w - 1)));
            };
            for (std::size_t l = 0; l < t.layers; ++l)
                for (std::ptrdiff_t y = 0; y < h; ++y)
                    for (std::ptrdiff_t x = 0; x < w; ++x) {
                        const float *a = texel(l, x, y), *b = texel(l, x + dx, y), *c = texel(l, x, y + dy),
                                    *d = texel(l, x + dx, y + dy);
                        float* p = to + t.at(l, std::size_t(y), std::size_t(x));
                        for (std::size_t k = 0; k < t.channels; ++k)
                            p[k] = float(0.25 * (double(a[k]) + double(b[k]) + double(c[k]) + double(d[k])));
                    }
            return true;
        });
    }

    void add_places(const Slot& slot, const Texels& t) {
        const std::ptrdiff_t w = std::ptrdiff_t(t.width), h = std::ptrdiff_t(t.height);
        using P = std::array<std::ptrdiff_t, 2>;
        using I = std::ptrdiff_t;
        if (h > 1) moved(slot, t, "flipped in y", [h](I x, I y) { return P{x, h - 1 - y}; });
        if (w > 1) moved(slot, t, "flipped in x", [w](I x, I y) { return P{w - 1 - x, y}; });
        if (w > 1 && w == h) moved(slot, t, "transposed", [](I x, I y) { return P{y, x}; });
        for (const auto& [dx, dy] : {std::pair<I, I>(1, 0), {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}}) {
            const I x0 = dx, y0 = dy;
            moved(slot, t, fmt::format("read at ({:+}, {:+}) texels", x0, y0), [x0, y0](I x, I y) {
                return P{x + x0, y + y0};
            });
            between(slot, t, x0, y0);
        }
        between(slot, t, 1, -1);
        between(slot, t, -1, 1);
    }

    // As the frame before had it where the camera moved by whole pixels: this image alone.
    void add_far_places(const Slot& slot, const Texels& t) {
        using P = std::array<std::ptrdiff_t, 2>;
        for (std::ptrdiff_t dy = -far_reach; dy <= far_reach; ++dy)
            for (std::ptrdiff_t dx = -far_reach; dx <= far_reach; ++dx) {
                if (std::abs(dx) <= 1 && std::abs(dy) <= 1) continue;
                moved(slot, t, fmt::format("read at ({:+}, {:+}) texels, as of another frame", dx, dy),
                      [dx, dy](std::ptrdiff_t x, std::ptrdiff_t y) { return P{x + dx, y + dy}; });
            }
    }

    // All images of the map become larger on each side, and what projects to them moves along.
    void add_borders(const Rows& rows) {
        const std::ptrdiff_t side = std::ptrdiff_t(rows.width), more = side > 256 ? side / 2 : side;
        std::vector<std::string> maps;
        for (const Slot& slot : binding_.inputs) {
            const Array* array = find(data_.inputs, slot.name);
            if (array && !array->bytes.empty() && !slot.frame && slot.kind == SlotKind::image &&
                slot.dtype == DType::f32 && array->shape.size() >= 2 && array->shape[0] == side &&
                array->shape[1] == side)
                maps.push_back(slot.name);
        }
        if (maps.empty()) return;
        using From = std::ptrdiff_t (*)(std::ptrdiff_t at, std::ptrdiff_t side);
        for (const auto& [text, from] :
             {std::pair<const char*, From>("its edge is repeated",
                                           [](std::ptrdiff_t at, std::ptrdiff_t n) {
                                               return std::clamp<std::ptrdiff_t>(at, 0, n - 1);
                                           }),
              {"it begins anew (wrap)", [](std::ptrdiff_t at, std::ptrdiff_t n) { return (at % n + n) % n; }},
              {"it is mirrored", [](std::ptrdiff_t at, std::ptrdiff_t n) {
                   const std::ptrdiff_t m = (at % (2 * n) + 2 * n) % (2 * n);
                   return m < n ? m : 2 * n - 1 - m;
               }}}) {
            const From source = from;
            add(fmt::format("beyond the border of {} {}", rows.name, text), computed_slack, [=, binding = &binding_](StageData& data) {
                for (const std::string& name : maps) enlarge(*find_array(data, name), side, more, source);
                const std::vector<double> w = uniform_value(*binding, data, rows.w);
                for (const std::string& member : {rows.x, rows.y}) {
                    std::vector<double> v = uniform_value(*binding, data, member);
                    for (std::size_t c = 0; c < v.size(); ++c) v[c] += double(more) * w[c];
                    set_uniform(*binding, data, member, v, "hypothesis");
                }
                set_uniform(*binding, data, rows.size, std::vector<double>{double(side + 2 * more)}, "hypothesis");
                return true;
            });
        }
    }
    static void enlarge(Array& array, std::ptrdiff_t side, std::ptrdiff_t more,
                        std::ptrdiff_t (*from)(std::ptrdiff_t, std::ptrdiff_t)) {
        const std::ptrdiff_t n = side + 2 * more;
        const std::size_t texel = array.bytes.size() / std::size_t(side * side);
        const unsigned char* old = std::as_const(array.bytes).data();
        Bytes larger(texel * std::size_t(n * n));
        for (std::ptrdiff_t y = 0; y < n; ++y)
            for (std::ptrdiff_t x = 0; x < n; ++x)
                std::memcpy(larger.data() + texel * std::size_t(y * n + x),
                            old + texel * std::size_t(from(y - more, side) * side + from(x - more, side)), texel);
        array.bytes = std::move(larger);
        array.shape[0] = array.shape[1] = n;
    }

    // ---- Channels

    void add_channels(const Slot& slot, const Texels& t) {
        const std::size_t axes = std::min<std::size_t>(t.channels, 3);
        each(slot, t, "negated", 0, [axes](float* p) {
            for (std::size_t c = 0; c < axes; ++c) p[c] = -p[c];
        });
        for (std::size_t a = 0; a < axes && axes > 1; ++a)
            each(slot, t, fmt::format("with {} negated", "xyz"[a]), 0, [a](float* p) { p[a] = -p[a]; });
        if (t.channels == 2) each(slot, t, "with x and y swapped", 0, [](float* p) { std::swap(p[0], p[1]); });
        if (t.channels < 3) return;
        for (const Order& order : orders())
            each(slot, t, "with " + order.text, 0, [order](float* p) {
                const float old[3] = {p[0], p[1], p[2]};
                for (int c = 0; c < 3; ++c) p[c] = old[order.from[c]];
            });
        auto normalised = [](float* p) {
            const double length = std::sqrt(double(p[0]) * p[0] + double(p[1]) * p[1] + double(p[2]) * p[2]);
            for (int c = 0; c < 3 && length > 0; ++c) p[c] = float(p[c] / length);
        };
        each(slot, t, "normalised", computed_slack, normalised);
        // Codes of 0..1 taken for -1..1, or the reverse, by a shader that makes them unit vectors.
        for (const auto& [text, by, plus] : {std::tuple<const char*, double, double>(
                                                 "packed once more (0.5 x + 0.5), then normalised", 0.5, 0.5),
                                             {"unpacked once more (2 x - 1), then normalised", 2, -1}})
            each(slot, t, text, computed_slack, [normalised, by = by, plus = plus](float* p) {
                for (int c = 0; c < 3; ++c) p[c] = float(by * double(p[c]) + plus);
                normalised(p);
            });
        // As octahedral codes, on a plane: Cigolle et al. 2014.
        each(slot, t, "as its octahedral code (x, y, 0)", computed_slack, [](float* p) {
            const double sum = std::abs(double(p[0])) + std::abs(double(p[1])) + std::abs(double(p[2]));
            double x = p[0] / sum, y = p[1] / sum;
            if (p[2] < 0) {
                const double folded = (1 - std::abs(y)) * (x >= 0 ? 1 : -1);
                y = (1 - std::abs(x)) * (y >= 0 ? 1 : -1), x = folded;
            }
            p[0] = float(x), p[1] = float(y), p[2] = 0;
        });
        add_sides(slot, t);
        if (t.channels < 4) return;
        for (const float w : {0.0f, 1.0f})
            each(slot, t, fmt::format("with {:g} in w", w), 0, [w](float* p) { p[3] = w; });
        each(slot, t, "divided by its w", computed_slack, [](float* p) {
            if (p[3] != 0)
                for (int c = 0; c < 3; ++c) p[c] = float(double(p[c]) / p[3]);
        });
        each(slot, t, "times its w", computed_slack, [](float* p) {
            for (int c = 0; c < 3; ++c) p[c] = p[c] * p[3];
        });
    }

    void add_curves(const Slot& slot, const Texels& t) {
        const std::size_t colours = std::min<std::size_t>(t.channels, 3);
        for (const Curve& curve : curves())
            each(slot, t, curve.text, computed_slack, [curve, colours](float* p) {
                for (std::size_t c = 0; c < colours; ++c) p[c] = float(curve.at(double(p[c])));
            });
        each(slot, t, "taken from 1", computed_slack, [colours](float* p) {
            for (std::size_t c = 0; c < colours; ++c) p[c] = 1 - p[c];
        });
    }

    void add_factors(const Slot& slot, const Texels& t) {
        constexpr double pi = std::numbers::pi;
        const std::size_t colours = std::min<std::size_t>(t.channels, 3);
        for (const auto& [text, by] : {std::pair<const char*, double>("not read (0)", 0),
                                       {"times pi", pi},
                                       {"divided by pi", 1 / pi},
                                       {"times 2", 2},
                                       {"divided by 2", 0.5},
                                       {"times 1000 (a unit)", 1000},
                                       {"divided by 1000 (a unit)", 1e-3},
                                       {"times 100 (a unit)", 100},
                                       {"divided by 100 (a unit)", 1e-2}}) {
            const double factor = by;
            each(slot, t, text, by == 0 || by == 2 || by == 0.5 ? 0 : computed_slack, [factor, colours](float* p) {
                for (std::size_t c = 0; c < colours; ++c) p[c] = float(factor * double(p[c]));
            });
        }
        each(slot, t, "not read (1)", 0, [colours](float* p) {
            for (std::size_t c = 0; c < colours; ++c) p[c] = 1;
        });
    }

    // ---- Buffers

    // Of [items][n]: another column, or the first one for all. Records of several vectors are no such thing.
    void add_rows(const Slot& slot, const Array& array) {
        const std::size_t words = array.bytes.size() / 4, rows = array.shape.empty() ? 1 : std::size_t(array.shape[0]);
        const std::size_t element = slot.channels > 0 ? std::size_t(slot.channels) : 1;
        if (rows == 0 || words % rows != 0) return;
        const std::size_t columns = words / rows / element;
        auto rearranged = [&](const std::string& what,
                              std::function<std::size_t(std::size_t row, std::size_t column)> from) {
            add(slot.name + " " + what, 0, [=, name = slot.name](StageData& data) {
                Array& a = *find_array(data, name);
                const std::vector<unsigned char> old(a.bytes.begin(), a.bytes.end());
                for (std::size_t r = 0; r < rows; ++r)
                    for (std::size_t c = 0; c < columns; ++c)
                        std::memcpy(a.bytes.data() + 4 * element * (r * columns + c),
                                    old.data() + 4 * element * from(r, c), 4 * element);
                return true;
            });
        };
        if (columns > 1) {
            rearranged("the same for all (one rotation)", [=](std::size_t r, std::size_t) { return r * columns; });
            rearranged("of the next rotation",
                       [=](std::size_t r, std::size_t c) { return r * columns + (c + 1) % columns; });
            rearranged("read as [column][row]", [=](std::size_t r, std::size_t c) { return c * rows + r; });
        }
        if (rows > 1) {
            rearranged("one row on",
                       [=](std::size_t r, std::size_t c) { return std::min(r + 1, rows - 1) * columns + c; });
            rearranged("one row back", [=](std::size_t r, std::size_t c) { return (r > 0 ? r - 1 : 0) * columns + c; });
            rearranged("in the reverse order",
                       [=](std::size_t r, std::size_t c) { return (rows - 1 - r) * columns + c; });
        }
    }

    // Places of samples: rounded, or half a texel and whole ones off.
    void add_sub_texels(const Slot& slot, const Texels& t) {
        auto placed = [&](const std::string& what, auto change) {
            add(slot.name + " " + what, 0, [name = slot.name, t, change](StageData& data) {
                float* p = numbers_of(*find_array(data, name));
                for (std::size_t i = 0; i < t.count(); ++i, p += t.channels) change(p);
                return true;
            });
        };
        placed("rounded to whole numbers", [](float* p) { p[0] = std::rint(p[0]), p[1] = std::rint(p[1]); });
        placed("rounded down to whole numbers", [](float* p) { p[0] = std::floor(p[0]), p[1] = std::floor(p[1]); });
    }

    // Numbers of samples: weights, kernels.
    void add_lists(const Slot& slot, const Texels& t) {
        const std::size_t n = t.count();
        auto whole = [&](const std::string& what, std::function<void(float*)> change) {
            add(slot.name + " " + what, computed_slack, [name = slot.name, change](StageData& data) {
                change(numbers_of(*find_array(data, name)));
                return true;
            });
        };
        auto sum = [n](const float* p) {
            double s = 0;
            for (std::size_t i = 0; i < n; ++i) s += double(p[i]);
            return s;
        };
        whole("all the same (their mean)", [=](float* p) {
            const float mean = float(sum(p) / double(n));
            std::fill(p, p + n, mean);
        });
        whole("with a sum of 1", [=](float* p) {
            const double s = sum(p);
            for (std::size_t i = 0; i < n && s != 0; ++i) p[i] = float(double(p[i]) / s);
        });
        whole(fmt::format("times their number, {}", n), [=](float* p) {
            for (std::size_t i = 0; i < n; ++i) p[i] = float(double(p[i]) * double(n));
        });
        whole(fmt::format("divided by their number, {}", n), [=](float* p) {
            for (std::size_t i = 0; i < n; ++i) p[i] = float(double(p[i]) / double(n));
        });
        whole("without the last", [=](float* p) { p[n - 1] = 0; });
        whole("without the first", [=](float* p) { p[0] = 0; });
    }

    // Whole texels: dx in the lower 16 bits, dy in the upper.
    void add_offsets(const Slot& slot) {
        auto each_offset = [&](const std::string& what, std::function<std::array<int, 2>(int x, int y)> change) {
            add(slot.name + " " + what, 0, [name = slot.name, change](StageData& data) {
                Array& a = *find_array(data, name);
                for (std::size_t i = 0; i + 4 <= a.bytes.size(); i += 4) {
                    std::uint32_t word;
                    std::memcpy(&word, a.bytes.data() + i, 4);
                    const auto [x, y] = change(std::int16_t(word & 0xffff), std::int16_t(word >> 16));
                    word = (std::uint32_t(x) & 0xffffu) | std::uint32_t(y) << 16;
                    std::memcpy(a.bytes.data() + i, &word, 4);
                }
                return true;
            });
        };
        using O = std::array<int, 2>;
        each_offset("with y negated", [](int x, int y) { return O{x, -y}; });
        each_offset("with x negated", [](int x, int y) { return O{-x, y}; });
        each_offset("negated", [](int x, int y) { return O{-x, -y}; });
        each_offset("with x and y swapped", [](int x, int y) { return O{y, x}; });
        each_offset("divided by 2", [](int x, int y) { return O{x / 2, y / 2}; });
        for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}})
            each_offset(fmt::format("and ({:+}, {:+}) texels", dx, dy), [dx = dx, dy = dy](int x, int y) {
                return O{x + dx, y + dy};
            });
    }

    // One input in the place of another, or both exchanged.
    void add_exchanges() {
        for (const Slot& a : binding_.inputs)
            for (const Slot& b : binding_.inputs) {
                const Array *from = find(data_.inputs, b.name), *to = find(data_.inputs, a.name);
                if (&a == &b || !from || !to || a.kind == SlotKind::buffer || from->dtype != to->dtype ||
                    from->shape != to->shape || from->bytes.empty())
                    continue;
                add(fmt::format("{} read in the place of {}", b.name, a.name), 0,
                    [to = a.name, from = b.name](StageData& data) {
                        Array* read = find_array(data, from);
                        find_array(data, to)->bytes = Bytes::lent(read->bytes.data(), read->bytes.size());
                        return true;
                    });
                if (&a < &b)
                    add(fmt::format("{} and {} exchanged", a.name, b.name), 0,
                        [one = a.name, other = b.name](StageData& data) {
                            std::swap(find_array(data, one)->bytes, find_array(data, other)->bytes);
                            return true;
                        });
            }
    }

    static constexpr std::ptrdiff_t far_reach = 3;  // pixels

    const StageBinding& binding_;
    const StageData& data_;
    std::vector<Hypothesis> all_;
};

}  // namespace

std::vector<Hypothesis> input_hypotheses(const StageBinding& binding, const StageData& data) {
    return InputHypotheses(binding, data).all();
}

std::vector<Hypothesis> far_hypotheses(const StageBinding& binding, const StageData& data) {
    std::vector<Hypothesis> all = InputHypotheses(binding, data).far();
    for (Hypothesis& h : row_major_hypotheses(binding, data)) all.push_back(std::move(h));
    return all;
}

}  // namespace plumb::parity
