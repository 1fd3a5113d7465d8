#include "gi/parity/uniform_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb::parity {

std::vector<Rows> find_rows(const StageBinding& binding, const StageData& data) {
    auto has = [&](const std::string& name) {
        return std::any_of(binding.uniforms.begin(), binding.uniforms.end(),
                           [&](const UniformMember& m) { return m.name == name; });
    };
    auto number = [&](const std::string& name) { return uniform_value(binding, data, name)[0]; };
    std::vector<Rows> found;
    for (const UniformMember& m : binding.uniforms) {
        for (const auto& [x, y, w] : {std::array<std::string, 3>{"to_texel_x", "to_texel_y", "to_texel_w"},
                                      std::array<std::string, 3>{"to_x", "to_y", "forward"}}) {
            if (!m.name.ends_with(x) || (m.name.size() > x.size() && m.name[m.name.size() - x.size() - 1] != '.'))
                continue;
            const std::string stem = m.name.substr(0, m.name.size() - x.size());
            if (!has(stem + y) || !has(stem + w)) continue;
            const std::string size = has(stem + "size") ? stem + "size" : "";
            if (size.empty() && !(has(stem + "width") && has(stem + "height"))) continue;
            found.push_back({stem.empty() ? "the view" : stem.substr(0, stem.size() - 1), stem, m.name, stem + y,
                             stem + w, size, number(size.empty() ? stem + "width" : size),
                             number(size.empty() ? stem + "height" : size)});
        }
    }
    return found;
}

Row row_of(const StageBinding& binding, const StageData& data, const std::string& member) {
    const std::vector<double> v = uniform_value(binding, data, member);
    return {v[0], v[1], v[2], v.size() > 3 ? v[3] : 0};
}

namespace {

struct Planes {
    std::string text;
    double scale, shift;  // z of clip space = scale w + shift
};

// Where w is the distance along the axis: 0 <= z <= w, z from -w to w, and both the other way round.
std::vector<Planes> usual_planes() {
    std::vector<Planes> all;
    for (const double n : {0.01, 0.05, 0.1, 0.2, 0.25, 0.5, 1.0})
        for (const double f : {5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 10000.0, 1e30}) {
            const std::string text = f > 1e29 ? fmt::format("{:g} m and infinity", n) : fmt::format("{:g} and {:g} m", n, f);
            all.push_back({text, f / (f - n), -f * n / (f - n)});
            all.push_back({text + ", z from -1", (f + n) / (f - n), -2 * f * n / (f - n)});
            all.push_back({text + ", z reversed", -n / (f - n), f * n / (f - n)});
        }
    return all;
}

}  // namespace

std::vector<Hypothesis> row_major_hypotheses(const StageBinding& binding, const StageData& data) {
    std::vector<Hypothesis> all;
    for (const Rows& rows : find_rows(binding, data)) {
        // Rows of a view are about an anchor, and leave out what is transposed to the divisor.
        if (rows.size.empty()) continue;
        const Row w = row_of(binding, data, rows.w), one = {0, 0, 0, 1};
        const Row x = 2 / rows.width * row_of(binding, data, rows.x) + -1.0 * w,
                  y = 2 / rows.height * row_of(binding, data, rows.y) + -1.0 * w;
        for (const Planes& planes : usual_planes()) {
            const Row z = planes.scale * w + planes.shift * one;
            auto column = [&](std::size_t c) { return Row{x[c], y[c], z[c], w[c]}; };
            const Row to_w = column(3), to_x = 0.5 * rows.width * (column(0) + to_w),
                      to_y = 0.5 * rows.height * (column(1) + to_w);
            Hypothesis h{fmt::format("{}: its matrix transposed (row-major), planes {}", rows.name, planes.text)};
            h.slack = computed_slack;
            h.change = [&binding, rows, to_x, to_y, to_w](StageData& d) {
                for (const auto& [member, row] : {std::pair(rows.x, to_x), {rows.y, to_y}, {rows.w, to_w}})
                    set_uniform(binding, d, member, row, "hypothesis");
                return true;
            };
            all.push_back(std::move(h));
        }
    }
    return all;
}

}  // namespace plumb::parity
