#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "gi/parity/hypothesis.h"
#include "gi/parity/texel_changes.h"
#include "gi/parity/uniform_rows.h"

namespace plumb::parity {

namespace {

// Numbers of a buffer that are looked through: lists of lights, not meshes.
constexpr std::size_t most_numbers = 256;

// Three numbers that the stage is given: a vector of the block, or of a record of a buffer.
struct Given {
    std::string name;
    std::array<double, 3> value;
};

std::vector<Given> given_vectors(const StageBinding& binding, const StageData& data) {
    std::vector<std::string> rows;
    for (const Rows& r : find_rows(binding, data)) rows.insert(rows.end(), {r.x, r.y, r.w});
    std::vector<Given> all;
    for (const UniformMember& m : binding.uniforms) {
        const std::vector<double> v = uniform_value(binding, data, m.name);
        if (v.size() < 3 || std::find(rows.begin(), rows.end(), m.name) != rows.end()) continue;
        all.push_back({m.name, {v[0], v[1], v[2]}});
    }
    for (const Slot& slot : binding.inputs) {
        const Array* array = find(data.inputs, slot.name);
        if (!array || slot.kind != SlotKind::buffer || slot.dtype != DType::f32) continue;
        const std::size_t n = array->bytes.size() / 4;
        if (n > most_numbers) continue;
        // std430: vectors of three start at every fourth number.
        for (std::size_t i = 0; i + 3 <= n; i += 4) {
            float v[3];
            std::memcpy(v, array->bytes.data() + 4 * i, sizeof v);
            all.push_back({fmt::format("what {} holds, ({:.4g}, {:.4g}, {:.4g})", slot.name, v[0], v[1], v[2]),
                           {double(v[0]), double(v[1]), double(v[2])}});
        }
    }
    std::erase_if(all, [](const Given& g) {
        return std::any_of(g.value.begin(), g.value.end(), [](double x) { return !(std::abs(x) < 1e18); }) ||
               std::all_of(g.value.begin(), g.value.end(), [](double x) { return x == 0; });
    });
    return all;
}

using Change = std::function<void(glm::ivec2, BoundedValue*)>;

Hypothesis of_output(const std::string& text, int first, double slack, Change change) {
    Hypothesis h{text};
    h.result = [first, change = std::move(change)](glm::ivec2 pixel, std::vector<BoundedValue>& values) {
        change(pixel, values.data() + first);
    };
    h.slack = slack;
    return h;
}

// A result of colours times a vector: as it was seen, and one that is given and equals it, or is its reciprocal.
void add_vectors(const Slot& output, int first, const std::vector<Given>& given, const std::vector<double>& ratio,
                 std::vector<Hypothesis>& all) {
    auto times = [&](const std::string& text, std::array<double, 3> by, bool fitted) {
        all.push_back(of_output(output.name + " " + text, first, fitted ? ratio_slack : computed_slack,
                                [by](glm::ivec2, BoundedValue* v) {
                                    for (std::size_t c = 0; c < 3; ++c) scale(v[c], by[c]);
                                }));
        all.back().fitted = fitted;
    };
    const auto is = [](double x, double y) { return std::abs(x - y) <= 2 * ratio_slack * std::abs(y); };
    if (is(ratio[0], ratio[1]) && is(ratio[1], ratio[2])) return;  // one number
    bool named = false;
    for (const Given& g : given) {
        bool same = true, reciprocal = true;
        for (std::size_t c = 0; c < 3; ++c) {
            same = same && is(ratio[c], g.value[c]);
            reciprocal = reciprocal && is(ratio[c], 1 / g.value[c]);
        }
        if (same) times("times " + g.name, g.value, false);
        if (reciprocal) times("divided by " + g.name, {1 / g.value[0], 1 / g.value[1], 1 / g.value[2]}, false);
        named = named || same || reciprocal;
        // The vector itself in another colour space, where the result is a multiple of it.
        for (const Curve& curve : curves()) {
            std::array<double, 3> by{};
            bool curved = true;
            for (std::size_t c = 0; c < 3; ++c) {
                by[c] = curve.at(g.value[c]) / g.value[c];
                curved = curved && is(ratio[c], by[c]);
            }
            if (curved) times(fmt::format("of {} {}", g.name, curve.text), by, false);
            named = named || curved;
        }
    }
    if (!named)
        times(fmt::format("times ({:.4g}, {:.4g}, {:.4g})", ratio[0], ratio[1], ratio[2]),
              {ratio[0], ratio[1], ratio[2]}, true);
}

// A power of a distance that is missing, or there once more.
void add_distances(const Slot& output, int first, const StageBinding& binding, const StageData& data,
                   const std::vector<Given>& given, std::vector<Hypothesis>& all) {
    const int colours = std::min(output.channels, 3), width = data.size.x;
    for (const Slot& slot : binding.inputs) {
        const Array* array = find(data.inputs, slot.name);
        if (!array || !slot.frame || slot.dtype != DType::f32 || slot.kind != SlotKind::image || slot.channels < 3 ||
            array->shape.size() < 2 || array->shape[0] != data.size.y || array->shape[1] != width)
            continue;
        const int channels = slot.channels;
        for (const Given& g : given)
            for (const int power : {1, 2, -1, -2}) {
                const std::string text =
                    fmt::format("{} {} the {}distance from {} to {}", output.name, power > 0 ? "times" : "divided by",
                                std::abs(power) == 2 ? "squared " : "", slot.name, g.name);
                all.push_back(of_output(text, first, computed_slack, [=](glm::ivec2 p, BoundedValue* v) {
                    const float* texel = reinterpret_cast<const float*>(array->bytes.data()) +
                                         (std::size_t(p.y) * std::size_t(width) + std::size_t(p.x)) * std::size_t(channels);
                    double squared = 0;
                    for (std::size_t c = 0; c < 3; ++c)
                        squared += (double(texel[c]) - g.value[c]) * (double(texel[c]) - g.value[c]);
                    const double one = std::abs(power) == 2 ? squared : std::sqrt(squared);
                    for (int c = 0; c < colours; ++c) scale(v[c], power > 0 ? one : 1 / one);
                }));
            }
    }
}

}  // namespace

std::vector<Hypothesis> vector_hypotheses(const StageBinding& binding, const StageData& data,
                                          const std::vector<SeenRatio>& ratios) {
    const std::vector<Given> given = given_vectors(binding, data);
    std::vector<Hypothesis> all;
    int first = 0;
    for (const Slot& output : binding.outputs) {
        if (output.dtype == DType::f32) {
            for (const SeenRatio& seen : ratios)
                if (seen.output == output.name && seen.ratio.size() == 3)
                    add_vectors(output, first, given, seen.ratio, all);
            add_distances(output, first, binding, data, given, all);
        }
        first += output.channels;
    }
    return all;
}

}  // namespace plumb::parity
