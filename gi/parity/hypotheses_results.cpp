#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gi/parity/hypothesis.h"
#include "gi/parity/texel_changes.h"

namespace plumb::parity {

namespace {

using Values = std::vector<BoundedValue>;

// An output of floats, and where its components stand among all.
struct Output {
    const Slot* slot;
    int first;
    int colours() const { return std::min(slot->channels, 3); }
};

class ResultHypotheses {
  public:
    ResultHypotheses(const StageBinding& binding, const StageData& data) : binding_(binding), data_(data) {
        int first = 0;
        for (const Slot& slot : binding.outputs) {
            if (slot.dtype == DType::f32) outputs_.push_back({&slot, first});
            first += slot.channels;
        }
    }

    std::vector<Hypothesis> all(const std::vector<double>& ratios) {
        for (const Output& o : outputs_) {
            add_factors(o, ratios);
            add_orders(o);
            add_curves(o);
        }
        add_places();
        for (const Output& o : outputs_) {
            add_quantities(o);
            add_left_out(o);
        }
        return std::move(all_);
    }

  private:
    void made(const Output& o, const std::string& what, double slack,
              std::function<void(glm::ivec2, BoundedValue*)> change) {
        const int first = o.first;
        Hypothesis h{o.slot->name + " " + what};
        h.result = [first, change](glm::ivec2 pixel, Values& values) { change(pixel, values.data() + first); };
        h.slack = slack;
        all_.push_back(std::move(h));
    }
    void scaled(const Output& o, const std::string& what, double by, double slack = 0, int channel = -1) {
        const int low = channel < 0 ? 0 : channel, high = channel < 0 ? o.colours() : channel + 1;
        made(o, what, slack, [=](glm::ivec2, BoundedValue* v) {
            for (int c = low; c < high; ++c) scale(v[c], by);
        });
    }

    void add_factors(const Output& o, const std::vector<double>& ratios) {
        const std::vector<NamedNumber> named = named_numbers(binding_, data_);
        for (const NamedNumber& n : named) {
            scaled(o, "times " + n.name, n.value);
            scaled(o, "divided by " + n.name, 1 / n.value);
        }
        scaled(o, "with its sign turned", -1);
        for (const double ratio : ratios) {
            const auto is = [ratio](double x) { return std::abs(ratio - x) <= ratio_slack * std::abs(x); };
            const bool has_name = is(-1) || std::any_of(named.begin(), named.end(), [&](const NamedNumber& n) {
                                      return is(n.value) || is(1 / n.value);
                                  });
            const std::string text = fmt::format("times {:.4g}", ratio);
            if (!has_name) scaled(o, text, ratio, ratio_slack), all_.back().fitted = true;
            for (int c = 0; c < o.slot->channels && o.slot->channels > 1; ++c) {
                scaled(o, fmt::format("times {:.4g} in {} alone", ratio, "xyzw"[c]), ratio, ratio_slack, c);
                all_.back().fitted = true;
            }
        }
    }

    void add_orders(const Output& o) {
        if (o.slot->channels < 3) return;
        for (const Order& order : orders())
            made(o, "with " + order.text, 0, [order](glm::ivec2, BoundedValue* v) {
                const BoundedValue old[3] = {v[0], v[1], v[2]};
                for (int c = 0; c < 3; ++c) v[c] = old[order.from[c]];
            });
        for (int c = 0; c < 3; ++c)
            made(o, fmt::format("with {} negated", "xyz"[c]), 0,
                 [c](glm::ivec2, BoundedValue* v) { v[c].shadow = -v[c].shadow; });
        for (int c = 0; c < 3; ++c)
            made(o, fmt::format("with {} in all channels", "xyz"[c]), 0, [c](glm::ivec2, BoundedValue* v) {
                const BoundedValue one = v[c];
                for (int d = 0; d < 3; ++d) v[d] = one;
            });
        if (o.slot->channels < 4) return;
        made(o, "with x, y and z times w", computed_slack, [](glm::ivec2, BoundedValue* v) {
            const double w = v[3].shadow;
            for (int c = 0; c < 3; ++c) scale(v[c], w);
        });
        for (const double w : {0.0, 1.0})
            made(o, fmt::format("with {:g} in w", w), 0, [w](glm::ivec2, BoundedValue* v) { v[3] = {w, 0}; });
    }

    void add_curves(const Output& o) {
        for (const Curve& curve : curves()) {
            const int channels = o.colours();
            made(o, curve.text, computed_slack, [curve, channels](glm::ivec2, BoundedValue* v) {
                for (int c = 0; c < channels; ++c)
                    if (std::isfinite(v[c].bound))
                        put(v[c], curve.at(v[c].shadow - v[c].bound), curve.at(v[c].shadow + v[c].bound));
            });
        }
        made(o, "taken from 1", computed_slack, [n = o.colours()](glm::ivec2, BoundedValue* v) {
            for (int c = 0; c < n; ++c) v[c].shadow = 1 - v[c].shadow;
        });
    }

    void add_places() {
        const glm::ivec2 last = data_.size - 1;
        auto placed = [&](const std::string& text, std::function<glm::ivec2(glm::ivec2)> place) {
            Hypothesis h{"the result " + text};
            h.place = std::move(place);
            all_.push_back(std::move(h));
        };
        if (last.y > 0) placed("flipped in y", [last](glm::ivec2 p) { return glm::ivec2(p.x, last.y - p.y); });
        if (last.x > 0) placed("flipped in x", [last](glm::ivec2 p) { return glm::ivec2(last.x - p.x, p.y); });
        if (last.x > 0 && last.y > 0) placed("turned by half a turn", [last](glm::ivec2 p) { return last - p; });
        if (last.x == last.y && last.x > 0) placed("transposed", [](glm::ivec2 p) { return glm::ivec2(p.y, p.x); });
        for (const glm::ivec2 d : {glm::ivec2(1, 0), {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}})
            placed(fmt::format("shifted by ({}, {}) pixels", d.x, d.y), [d](glm::ivec2 p) { return p - d; });
        add_upside_down();
    }

    // The first row is the lowest in all that the shader reads and writes: only what depends on the number of a pixel
    // (a rotation by its hash) is another.
    void add_upside_down() {
        if (data_.size.y < 2) return;
        Hypothesis h{"rows counted from below"};
        const int last = data_.size.y - 1;
        h.place = [last](glm::ivec2 p) { return glm::ivec2(p.x, last - p.y); };
        h.change = [this_binding = &binding_](StageData& data) {
            bool any = false;
            for (const Slot& slot : this_binding->inputs) {
                if (!slot.frame || (slot.kind != SlotKind::image && slot.kind != SlotKind::image_array)) continue;
                for (Array& a : data.inputs.arrays) {
                    if (a.name != slot.name || a.shape.size() < 2) continue;
                    const std::size_t axis = slot.kind == SlotKind::image_array ? 1 : 0, h = std::size_t(a.shape[axis]);
                    const std::size_t layers = axis == 1 ? std::size_t(a.shape[0]) : 1,
                                      row = a.bytes.size() / (layers * h);
                    unsigned char* bytes = a.bytes.data();
                    for (std::size_t l = 0; l < layers; ++l)
                        for (std::size_t y = 0; y < h / 2; ++y)
                            std::swap_ranges(bytes + (l * h + y) * row, bytes + (l * h + y + 1) * row,
                                             bytes + (l * h + h - 1 - y) * row);
                    any = true;
                }
            }
            return any;
        };
        all_.push_back(std::move(h));
    }

    // A factor that is missing, or there twice: each component times that of an input, or by a component of one.
    void add_quantities(const Output& o) {
        for (const Slot& slot : binding_.inputs) {
            const Array* array = find(data_.inputs, slot.name);
            if (!array || !slot.frame || slot.dtype != DType::f32 || slot.kind != SlotKind::image) continue;
            if (array->shape.size() < 2 || array->shape[0] != data_.size.y || array->shape[1] != data_.size.x) continue;
            const int channels = slot.channels, width = data_.size.x, colours = o.colours();
            auto factor = [&](const std::string& text, bool divided, auto component) {
                made(o, text, computed_slack, [=](glm::ivec2 p, BoundedValue* v) {
                    const float* texel =
                        reinterpret_cast<const float*>(array->bytes.data()) +
                        (std::size_t(p.y) * std::size_t(width) + std::size_t(p.x)) * std::size_t(channels);
                    for (int c = 0; c < colours; ++c)
                        scale(v[c], divided ? 1.0 / double(texel[component(c)]) : double(texel[component(c)]));
                });
            };
            for (const bool divided : {false, true}) {
                const std::string words = divided ? "divided by " : "times ";
                if (channels >= 3 && colours == 3) factor(words + slot.name, divided, [](int c) { return c; });
                if (channels == 1) factor(words + slot.name, divided, [](int) { return 0; });
                if (channels == 4) factor(words + slot.name + ".w", divided, [](int) { return 3; });
            }
        }
    }

    // Anything agrees there.
    void left_out(const std::string& text, int first, int last) {
        Hypothesis h{text};
        h.result = [=](glm::ivec2, Values& values) {
            for (int i = first; i < last; ++i) values[std::size_t(i)] = {0, 1e300};
        };
        h.aside = true;
        all_.push_back(std::move(h));
    }
    void add_left_out(const Output& o) {
        for (int c = 0; c < o.slot->channels && o.slot->channels > 1; ++c) {
            std::string kept = std::string("xyzw").substr(0, std::size_t(o.slot->channels));
            kept[std::size_t(c)] = '_';
            if (c == o.slot->channels - 1) kept.pop_back();
            left_out(fmt::format("{}.{} left aside: channels = \"{}\"", o.slot->name, "xyzw"[c], kept), o.first + c,
                     o.first + c + 1);
        }
        if (binding_.outputs.size() > 1)
            left_out(o.slot->name + " left aside: all other outputs", o.first, o.first + o.slot->channels);
    }

    const StageBinding& binding_;
    const StageData& data_;
    std::vector<Output> outputs_;
    std::vector<Hypothesis> all_;
};

}  // namespace

std::vector<NamedNumber> named_numbers(const StageBinding& binding, const StageData& data) {
    constexpr double pi = std::numbers::pi;
    std::vector<NamedNumber> all = {{"pi", pi},
                                    {"2", 2},
                                    {"2 pi", 2 * pi},
                                    {"4", 4},
                                    {"4 pi", 4 * pi},
                                    {"pi^2", pi * pi},
                                    {"pi / 2", pi / 2},
                                    {"3", 3},
                                    {"1000 (a unit)", 1000},
                                    {"100 (a unit)", 100},
                                    {"10", 10},
                                    {"683 (lm/W)", 683},
                                    {"255", 255},
                                    {"65535", 65535}};
    auto add = [&](const std::string& name, double value) {
        // What is beyond is a limit that nothing reaches, and a result times it black or nothing.
        if (std::abs(value) >= 1e-9 && std::abs(value) <= 1e9 && std::abs(value) != 1) all.push_back({name, value});
    };
    for (const UniformMember& m : binding.uniforms) {
        if (m.name.find("pad") != std::string::npos) continue;
        const std::vector<double> value = uniform_value(binding, data, m.name);
        if (value.size() == 1) add(m.name, value[0]), add(m.name + "^2", value[0] * value[0]);
    }
    for (const Slot& slot : binding.inputs) {
        const Array* array = find(data.inputs, slot.name);
        if (!array || slot.kind != SlotKind::image || array->shape.size() < 2 || slot.frame) continue;
        add("the texels of " + slot.name, double(array->shape[0]) * double(array->shape[1]));
    }
    return all;
}

std::vector<Hypothesis> result_hypotheses(const StageBinding& binding, const StageData& data,
                                          const std::vector<double>& ratios) {
    return ResultHypotheses(binding, data).all(ratios);
}

}  // namespace plumb::parity
