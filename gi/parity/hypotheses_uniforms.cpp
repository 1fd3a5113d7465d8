#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "gi/parity/hypothesis.h"
#include "gi/parity/texel_changes.h"

namespace plumb::parity {

namespace {

using Row = std::array<double, 4>;

Row operator+(const Row& a, const Row& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}; }
Row operator*(double s, const Row& a) { return {s * a[0], s * a[1], s * a[2], s * a[3]}; }
double dot3(const Row& a, const Row& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Rows that take a point to texels: x = (to_x . (p, 1)) / (to_w . (p, 1)), and y.
struct Rows {
    std::string name;      // "map", "view"
    std::string x, y, w;   // members
    double width, height;  // texels
};

class UniformHypotheses {
  public:
    UniformHypotheses(const StageBinding& binding, const StageData& data) : binding_(binding), data_(data) {}

    std::vector<Hypothesis> all() {
        for (const UniformMember& m : binding_.uniforms) {
            if (m.name.find("pad") != std::string::npos || m.name == "width" || m.name == "height") continue;
            const std::size_t n = value(m.name).size();
            if (m.type == "int" || m.type == "uint")
                add_whole(m);
            else if (n == 1)
                add_scalar(m);
            else
                add_vector(m, n);
        }
        for (const Rows& rows : find_rows()) add_rows(rows);
        return std::move(all_);
    }

  private:
    std::vector<double> value(const std::string& member) const { return uniform_value(binding_, data_, member); }

    using Members = std::vector<std::pair<std::string, std::vector<double>>>;
    void add(const std::string& text, double slack, Members members) {
        for (const auto& [name, v] : members)
            if (std::any_of(v.begin(), v.end(), [](double x) { return !(std::abs(x) < 1e37); })) return;
        Hypothesis h{text};
        h.slack = slack;
        h.change = [binding = &binding_, members = std::move(members)](StageData& data) {
            const std::vector<unsigned char> before = data.uniforms;
            for (const auto& [name, v] : members) set_uniform(*binding, data, name, v, "hypothesis");
            return data.uniforms != before;
        };
        all_.push_back(std::move(h));
    }

    void add_scalar(const UniformMember& m) {
        constexpr double pi = std::numbers::pi;
        const double v = value(m.name)[0];
        auto one = [&](const std::string& text, double to) {
            add(m.name + " " + text, computed_slack, {{m.name, {to}}});
        };
        for (const auto& [text, by] : {std::pair<const char*, double>("negated", -1),
                                       {"times 2", 2},
                                       {"divided by 2", 0.5},
                                       {"times pi", pi},
                                       {"divided by pi", 1 / pi},
                                       {"times 2 pi", 2 * pi},
                                       {"divided by 2 pi", 0.5 / pi},
                                       {"times 1000 (a unit)", 1000},
                                       {"divided by 1000 (a unit)", 1e-3},
                                       {"times 100 (a unit)", 100},
                                       {"divided by 100 (a unit)", 1e-2},
                                       {"in degrees", 180 / pi},
                                       {"in radians", pi / 180}})
            one(text, by * v);
        one("squared", v * v);
        if (v > 0) one("under a root", std::sqrt(v));
        if (v != 0) one("as its reciprocal", 1 / v);
        one("not set (0)", 0);
        one("not set (1)", 1);
    }

    void add_whole(const UniformMember& m) {
        const double v = value(m.name)[0];
        auto one = [&](const std::string& text, double to) {
            if ((m.type == "uint" && (to < 0 || to >= 0x1p32)) || std::abs(to) > 0x1p31) return;
            add(m.name + " " + text, 0, {{m.name, {to}}});
        };
        one("one less", v - 1), one("one more", v + 1);
        one("not set (0)", 0), one("not set (1)", 1);
        one("times 2", 2 * v), one("divided by 2", std::floor(v / 2));
    }

    void add_vector(const UniformMember& m, std::size_t n) {
        const std::vector<double> v = value(m.name);
        auto made = [&](const std::string& text, double slack, auto change) {
            std::vector<double> to = v;
            for (std::size_t c = 0; c < std::min<std::size_t>(n, 3); ++c) to[c] = change(c);
            add(m.name + " " + text, slack, {{m.name, to}});
        };
        made("negated", 0, [&](std::size_t c) { return -v[c]; });
        for (std::size_t a = 0; a < std::min<std::size_t>(n, 3); ++a)
            made(fmt::format("with {} negated", "xyz"[a]), 0, [&](std::size_t c) { return c == a ? -v[c] : v[c]; });
        made("not set (0)", 0, [](std::size_t) { return 0.0; });
        made("not set (1)", 0, [](std::size_t) { return 1.0; });
        if (n >= 3)
            for (const Order& order : orders())
                made("with " + order.text, 0, [&](std::size_t c) { return v[std::size_t(order.from[c])]; });
        constexpr double pi = std::numbers::pi;
        for (const auto& [text, by] : {std::pair<const char*, double>("times pi", pi),
                                       {"divided by pi", 1 / pi},
                                       {"times 2", 2},
                                       {"divided by 2", 0.5},
                                       {"times 1000 (a unit)", 1000},
                                       {"divided by 1000 (a unit)", 1e-3},
                                       {"times 100 (a unit)", 100},
                                       {"divided by 100 (a unit)", 1e-2}})
            made(text, computed_slack, [&, by = by](std::size_t c) { return by * v[c]; });
        for (const Curve& curve : curves())
            if (curve.text.find("sRGB") != std::string::npos)
                made(curve.text, computed_slack, [&](std::size_t c) { return curve.at(v[c]); });
    }

    bool has(const std::string& name) const {
        return std::any_of(binding_.uniforms.begin(), binding_.uniforms.end(),
                           [&](const UniformMember& m) { return m.name == name; });
    }
    Row row(const std::string& name) const {
        const std::vector<double> v = value(name);
        return {v[0], v[1], v[2], v.size() > 3 ? v[3] : 0};
    }

    // Projection (raster/project.glsl) and SeenFrom (gi/screen/seen_from.glsl), under whatever name they are members.
    std::vector<Rows> find_rows() const {
        std::vector<Rows> found;
        for (const UniformMember& m : binding_.uniforms) {
            for (const auto& [x, y, w] : {std::array<const char*, 3>{"to_texel_x", "to_texel_y", "to_texel_w"},
                                          std::array<const char*, 3>{"to_x", "to_y", "forward"}}) {
                if (!m.name.ends_with(x) ||
                    (m.name.size() > std::string(x).size() && m.name[m.name.size() - std::string(x).size() - 1] != '.'))
                    continue;
                const std::string stem = m.name.substr(0, m.name.size() - std::string(x).size());
                if (!has(stem + y) || !has(stem + w)) continue;
                const std::string side = has(stem + "size") ? "size" : "";
                if (side.empty() && !(has(stem + "width") && has(stem + "height"))) continue;
                found.push_back({stem.empty() ? "the view" : stem.substr(0, stem.size() - 1), m.name, stem + y,
                                 stem + w, value(stem + (side.empty() ? "width" : side))[0],
                                 value(stem + (side.empty() ? "height" : side))[0]});
            }
        }
        return found;
    }

    void add_rows(const Rows& m) {
        const Row x = row(m.x), y = row(m.y), w = row(m.w);
        auto to_list = [](const Row& r) { return std::vector<double>(r.begin(), r.end()); };
        auto made = [&](const std::string& text, const Row& new_x, const Row& new_y, const Row& new_w) {
            add(m.name + ": " + text, computed_slack,
                {{m.x, to_list(new_x)}, {m.y, to_list(new_y)}, {m.w, to_list(new_w)}});
        };
        made("y flipped", x, m.height * w + -1.0 * y, w);
        made("x flipped", m.width * w + -1.0 * x, y, w);
        made("x and y swapped", y, x, w);
        made("no perspective divide", x, y, {0, 0, 0, 1});
        for (const double d : {-1.0, -0.5, 0.5, 1.0}) {
            made(fmt::format("{:+g} texels in x and y", d), x + d * w, y + d * w, w);
            made(fmt::format("{:+g} texels in x", d), x + d * w, y, w);
            made(fmt::format("{:+g} texels in y", d), x, y + d * w, w);
        }
        // -1..1 taken for 0..1, and the reverse.
        made("0.5 x + 0.5 left out", 2.0 * x + -m.width * w, 2.0 * y + -m.height * w, w);
        made("0.5 x + 0.5 done twice", 0.5 * x + (0.25 * m.width) * w, 0.5 * y + (0.25 * m.height) * w, w);
        auto negated = [](Row r, std::size_t axis) { return r[axis] = -r[axis], r; };
        for (std::size_t a = 0; a < 3; ++a)
            made(fmt::format("another handedness: {} of the world negated", "xyz"[a]), negated(x, a), negated(y, a),
                 negated(w, a));
        auto swapped = [](Row r) { return std::swap(r[1], r[2]), r; };
        made("y and z of the world swapped", swapped(x), swapped(y), swapped(w));
        made("turned without its translation", {x[0], x[1], x[2], 0}, {y[0], y[1], y[2], 0}, {w[0], w[1], w[2], 0});
        add_transposed(m, x, y, w, made);
    }

    // The rotation of the view is found from its rows: forward is the divisor's, right and down what is left of x and
    // y.
    template <class Made>
    void add_transposed(const Rows&, const Row& x, const Row& y, const Row& w, const Made& made) {
        const double length = std::sqrt(dot3(w, w));
        if (!(length > 0)) return;
        const Row f = (1 / length) * w;
        const double fx = dot3(x, f), fy = dot3(y, f);
        const Row across = x + -fx * f, down = y + -fy * f;
        const double sx = std::sqrt(dot3(across, across)), sy = std::sqrt(dot3(down, down));
        if (!(sx > 0) || !(sy > 0)) return;
        const Row r = (1 / sx) * across, d = (1 / sy) * down;
        const Row rt = {r[0], d[0], f[0], 0}, dt = {r[1], d[1], f[1], 0}, ft = {r[2], d[2], f[2], 0};
        auto with = [&](double tr, double td, double tf, const std::string& text) {
            Row right = rt, lower = dt, forward = ft;
            right[3] = tr, lower[3] = td, forward[3] = tf;
            made(text, sx * right + fx * forward, sy * lower + fy * forward, length * forward);
        };
        // The translations of the three axes of the eye, from the fourth column.
        const double tf = w[3] / length, tr = (x[3] - fx * tf) / sx, td = (y[3] - fy * tf) / sy;
        with(tr, td, tf, "its rotation transposed");
        with(0, 0, 0, "its matrix transposed (row-major)");
    }

    const StageBinding& binding_;
    const StageData& data_;
    std::vector<Hypothesis> all_;
};

}  // namespace

std::vector<Hypothesis> uniform_hypotheses(const StageBinding& binding, const StageData& data) {
    return UniformHypotheses(binding, data).all();
}

}  // namespace plumb::parity
