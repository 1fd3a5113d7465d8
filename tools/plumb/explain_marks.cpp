#include "tools/plumb/explain_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/page/markup.h"

namespace plumb::cli {

namespace {

std::string path_of(const std::string& shape) {
    return fmt::format("<path class=\"under\" d=\"{0}\"/><path class=\"line\" d=\"{0}\"/>\n", shape);
}

std::string title_of(const Sample& s, double all) {
    std::string text = fmt::format("sample {}", s.number);
    if (s.path) text += fmt::format(", path {}, step {}", *s.path, *s.step);
    text += fmt::format(": texel {:g}, {:g}", s.texel->x, s.texel->y);
    if (!s.inside) return text + ", outside";
    if (s.hidden()) return text + ", hidden";
    if (s.contribution.empty()) return text;
    return all > 0 ? text + fmt::format(", {:.3g} % of the sum", 100 * s.brought() / all) : text;
}

// Thin lines from the point of the first step outwards.
std::string path_lines(const Samples& samples) {
    std::string out, shape;
    int path = -1;
    for (const Sample& s : samples.all) {
        if (!s.path || !s.texel) continue;
        shape += fmt::format("{}{:g} {:g}", *s.path == path ? "L" : "M", s.texel->x + 0.5, s.texel->y + 0.5);
        path = *s.path;
    }
    return shape.empty() ? "" : fmt::format("<path class=\"path\" d=\"{}\"/>\n", shape);
}

}  // namespace

std::string pixel_mark(glm::ivec2 pixel, glm::ivec2 size, Scale scale) {
    // A frame of at least 9 px around the texel, and lines from the border that end before it.
    const double half = std::max(0.5, 4.5 * scale.texels_a_px), gap = half + 3 * scale.texels_a_px;
    const double x = pixel.x + 0.5, y = pixel.y + 0.5;
    std::string shape = fmt::format("M{:g} {:g}h{:g}v{:g}h{:g}z", x - half, y - half, 2 * half, 2 * half, -2 * half);
    if (x - gap > 0) shape += fmt::format("M0 {:g}H{:g}", y, x - gap);
    if (x + gap < size.x) shape += fmt::format("M{:g} {:g}H{}", x + gap, y, size.x);
    if (y - gap > 0) shape += fmt::format("M{:g} 0V{:g}", x, y - gap);
    if (y + gap < size.y) shape += fmt::format("M{:g} {:g}V{}", x, y + gap, size.y);
    return path_of(shape);
}

std::string point_mark(glm::dvec2 p, Scale scale) {
    const double r = 7 * scale.texels_a_px;
    return path_of(fmt::format("M{:g} {:g}l{:g} {:g}M{:g} {:g}l{:g} {:g}", p.x - r, p.y - r, 2 * r, 2 * r, p.x - r,
                               p.y + r, 2 * r, -2 * r));
}

std::string sample_marks(const Samples& samples, const std::string& key, Scale scale) {
    struct Mark {
        std::size_t sample = 0;
        double radius = 0;
    };
    std::vector<Mark> marks;
    const double all = samples.total();
    for (std::size_t i = 0; i < samples.all.size(); ++i) {
        const Sample& s = samples.all[i];
        if (!s.texel) continue;
        const double share = samples.most > 0 ? s.brought() / samples.most : 0;
        marks.push_back({i, share > 0 && s.inside ? std::max(least_mark_px, largest_mark_px * std::sqrt(share)) : 0});
    }
    // Small ones lie on top of large ones, and what brings nothing below them all.
    std::stable_sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) {
        return (a.radius == 0) != (b.radius == 0) ? a.radius == 0 : a.radius > b.radius;
    });
    std::string out = path_lines(samples);
    for (const Mark& m : marks) {
        const Sample& s = samples.all[m.sample];
        out += fmt::format("<circle class=\"{}\" data-key=\"{}{}\" cx=\"{:g}\" cy=\"{:g}\" r=\"{:.4g}\"><title>{}</title>"
                           "</circle>\n",
                           m.radius > 0 ? "mark" : "none", page::escaped(key), m.sample, s.texel->x + 0.5,
                           s.texel->y + 0.5, (m.radius > 0 ? m.radius : no_mark_px) * scale.texels_a_px,
                           page::escaped(title_of(s, all)));
    }
    return out;
}

std::optional<Extent> extent_of(const Samples& samples, std::optional<glm::dvec2> point) {
    std::optional<Extent> extent;
    auto add = [&](glm::dvec2 low, glm::dvec2 high) {
        if (!(std::isfinite(low.x) && std::isfinite(low.y))) return;
        if (!extent) extent = {low, high};
        extent->low = glm::min(extent->low, low), extent->high = glm::max(extent->high, high);
    };
    for (const Sample& s : samples.all)
        if (s.texel) add(*s.texel, *s.texel + 1.0);
    if (point) add(*point, *point);
    return extent;
}

std::string triangle_mark(const glm::dvec4 corners[3], glm::ivec2 size) {
    // Cut at a plane in front of the eye (Sutherland and Hodgman 1974).
    const double near = 1e-6 * std::max({std::abs(corners[0].w), std::abs(corners[1].w), std::abs(corners[2].w)});
    std::vector<glm::dvec4> polygon;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec4 &a = corners[i], &b = corners[(i + 1) % 3];
        if (a.w > near) polygon.push_back(a);
        if ((a.w > near) != (b.w > near)) polygon.push_back(a + (b - a) * ((near - a.w) / (b.w - a.w)));
    }
    std::string shape;
    for (const glm::dvec4& p : polygon) {
        const glm::dvec2 at = (glm::dvec2(p) / p.w * 0.5 + 0.5) * glm::dvec2(size);
        if (!std::isfinite(at.x) || !std::isfinite(at.y)) return "";
        const glm::dvec2 held = glm::clamp(at, glm::dvec2(-1e6), glm::dvec2(1e6));
        shape += fmt::format("{}{:.6g} {:.6g}", shape.empty() ? "M" : "L", held.x, held.y);
    }
    return shape.empty() ? "" : fmt::format("<path class=\"seen\" d=\"{}z\"/>\n", shape);
}

std::string triangle_mark(const StageData& data, int triangle) {
    const Array *positions = find(data.inputs, "clip_positions"), *triangles = find(data.inputs, "triangles");
    if (!positions || !triangles || triangle < 0 || triangles->shape.size() != 2 || triangle >= triangles->shape[0])
        return "";
    glm::dvec4 corners[3];
    for (int i = 0; i < 3; ++i) {
        const std::int32_t vertex = ints(data, "triangles")[3 * triangle + i];
        if (vertex < 0 || vertex >= positions->shape.at(0)) return "";
        for (int c = 0; c < 4; ++c) corners[i][c] = floats(data, "clip_positions")[4 * vertex + c];
    }
    return triangle_mark(corners, data.size);
}

}  // namespace plumb::cli
