#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "gi/parity/hypothesis.h"
#include "gi/parity/texel_changes.h"
#include "gi/parity/uniform_rows.h"

namespace plumb::parity {

namespace {

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
        for (const Rows& rows : find_rows(binding_, data_)) add_rows(rows);
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
                                       {"times 10", 10},
                                       {"divided by 10", 0.1},
                                       {"in degrees", 180 / pi},
                                       {"in radians", pi / 180}})
            one(text, by * v);
        one("squared", v * v);
        if (v > 0) one("under a root", std::sqrt(v));
        if (v != 0) one("as its reciprocal", 1 / v);
        one("not set (0)", 0);
        one("not set (1)", 1);
        // What is compared with it always, or never, passes.
        one("left out, as a lower limit (-1e30)", -1e30);
        one("left out, as an upper limit (1e30)", 1e30);
        // Units that go by the frame.
        const double width = double(data_.size.x), height = double(data_.size.y);
        for (const auto& [text, side] : {std::pair<const char*, double>("width", width), {"height", height}}) {
            one(fmt::format("times the frame's {}", text), side * v);
            one(fmt::format("divided by the frame's {}", text), v / side);
            one(fmt::format("in percent of the frame's {}", text), 100 * v / side);
        }
        one("times width / height", v * width / height);
        one("times height / width", v * height / width);
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

    void add_rows(const Rows& m) {
        const Row x = row_of(binding_, data_, m.x), y = row_of(binding_, data_, m.y), w = row_of(binding_, data_, m.w);
        auto to_list = [](const Row& r) { return std::vector<double>(r.begin(), r.end()); };
        auto made = [&](const std::string& text, const Row& new_x, const Row& new_y, const Row& new_w) {
            add(m.name + ": " + text, computed_slack,
                {{m.x, to_list(new_x)}, {m.y, to_list(new_y)}, {m.w, to_list(new_w)}});
        };
        made("y flipped", x, m.height * w + -1.0 * y, w);
        made("x flipped", m.width * w + -1.0 * x, y, w);
        made("x and y swapped", y, x, w);
        // Of texels, and of clip space, before 0.5 x + 0.5.
        const Row one = {0, 0, 0, 1};
        made("no perspective divide", x, y, one);
        made("no perspective divide before 0.5 x + 0.5", x + 0.5 * m.width * (one + -1.0 * w),
             y + 0.5 * m.height * (one + -1.0 * w), one);
        for (const double d : {-1.0, -0.5, 0.5, 1.0}) {
            made(fmt::format("{:+g} texels in x and y", d), x + d * w, y + d * w, w);
            made(fmt::format("{:+g} texels in x, {:+g} in y", d, -d), x + d * w, y + -d * w, w);
            made(fmt::format("{:+g} texels in x", d), x + d * w, y, w);
            made(fmt::format("{:+g} texels in y", d), x, y + d * w, w);
        }
        // Another number of texels: one less, half and twice as many, each side's for the other; from a first row that is the
        // highest, and from one that is the lowest.
        struct Sides {
            std::string text;
            double x, y;
        };
        const Sides other_sides[] = {{"a texel less a side", (m.width - 1) / m.width, (m.height - 1) / m.height},
                                     {"half as many texels a side", 0.5, 0.5},
                                     {"twice as many texels a side", 2, 2},
                                     {"width and height swapped", m.height / m.width, m.width / m.height}};
        for (const Sides& s : other_sides) {
            if (s.x == 1 && s.y == 1) continue;
            made(s.text, s.x * x, s.y * y, w);
            made(s.text + ", y up", s.x * x, s.y * y + (1 - s.y) * m.height * w, w);
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

std::vector<Family> families(const StageBinding& binding, const StageData& data) {
    std::vector<Family> all;
    auto add = [&](const std::string& text, std::vector<std::pair<std::string, std::vector<double>>> members) {
        all.push_back({text, [&binding, text, members = std::move(members)](double by) {
                           Hypothesis h{fmt::format("{} times {:.4g}", text, by)};
                           h.slack = ratio_slack, h.fitted = true;
                           h.change = [&binding, members, by](StageData& d) {
                               for (auto [name, v] : members) {
                                   for (double& x : v) x *= by;
                                   set_uniform(binding, d, name, v, "hypothesis");
                               }
                               return true;
                           };
                           return h;
                       }});
    };
    for (const UniformMember& m : binding.uniforms) {
        const std::vector<double> v = uniform_value(binding, data, m.name);
        if (m.type == "float" && v[0] != 0 && std::abs(v[0]) < 1e6) add(m.name, {{m.name, v}});
    }
    for (const Rows& rows : find_rows(binding, data))
        add(rows.name + ": x and y in texels", {{rows.x, uniform_value(binding, data, rows.x)},
                                                {rows.y, uniform_value(binding, data, rows.y)}});
    // Lists of places and directions.
    for (const Slot& slot : binding.inputs) {
        const Array* array = find(data.inputs, slot.name);
        if (!array || slot.kind != SlotKind::buffer || slot.dtype != DType::f32 || slot.channels < 2) continue;
        all.push_back({slot.name, [name = slot.name](double by) {
                           Hypothesis h{fmt::format("{} times {:.4g}", name, by)};
                           h.slack = ratio_slack, h.fitted = true;
                           h.change = [name, by](StageData& d) {
                               for (Array& a : d.inputs.arrays) {
                                   if (a.name != name) continue;
                                   float* p = reinterpret_cast<float*>(a.bytes.data());
                                   for (std::size_t i = 0; i < a.bytes.size() / 4; ++i) p[i] = float(by * double(p[i]));
                               }
                               return true;
                           };
                           return h;
                       }});
    }
    return all;
}

std::vector<Hypothesis> uniform_hypotheses(const StageBinding& binding, const StageData& data) {
    return UniformHypotheses(binding, data).all();
}

}  // namespace plumb::parity
