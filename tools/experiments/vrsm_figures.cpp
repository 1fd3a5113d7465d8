// plumb experiment vrsm's page: figures 3.1 to 3.4, drawn from the pattern, the pictures and the samples of the run.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "tools/experiments/vrsm.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"

namespace plumb::cli {

namespace {

constexpr int picture_width = 400;  // on the page, px

std::string svg(int width, int height, const std::string& marks, const std::string& caption) {
    return fmt::format("<figure><svg role=\"img\" aria-label=\"{0}\" width=\"{1}\" height=\"{2}\" viewBox=\"0 0 {1} {2}\" "
                       "style=\"background:#fff\">\n{3}</svg><figcaption style=\"max-width:{1}px\">{0}</figcaption></figure>\n",
                       page::escaped(caption), width, height, marks);
}

std::string line(const glm::dvec2& a, const glm::dvec2& b, const char* colour, double width) {
    return fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" stroke-width=\"{}\"/>\n", a.x, a.y,
                       b.x, b.y, colour, width);
}
std::string dot(const glm::dvec2& at, double radius, const std::string& fill, const std::string& stroke) {
    return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" fill=\"{}\" stroke=\"{}\"/>\n", at.x, at.y, radius, fill, stroke);
}

// Figure 3.1: the samples of one rotation around the projection, each a disc of the area of its texels.
std::string pattern_svg(rsm::Spacing spacing, const std::string& name) {
    rsm::GatherParams params;
    params.gather = rsm::Gather::paths;
    params.spacing = spacing, params.growth = vrsm_growth, params.jitter = 0, params.rotations = 1;
    params.texels = rsm::Texels::continuous;
    const int map_size = 512;
    const rsm::Pattern pattern = rsm::paths_pattern(params, map_size, 1);
    const double radius = double(params.radius) * map_size, scale = 0.78 * (picture_width / 2) / radius;
    const glm::dvec2 centre(picture_width / 2);
    std::string marks;
    for (int m = 0; m < params.directions; ++m) {
        const double angle = 2 * host::pi * (m + 0.5) / params.directions;
        marks += line(centre, centre + radius * scale * glm::dvec2(host::sin(angle), host::cos(angle)), "#bbb", 1);
    }
    for (int k = 0; k < pattern.samples; ++k) {
        const float* offset = &pattern.positions[2 * std::size_t(k)];
        const glm::dvec2 at = centre + scale * glm::dvec2(offset[0], offset[1]);
        const double weight = std::max(double(pattern.weights[std::size_t(k)]), 0.0);
        marks += dot(at, scale * std::sqrt(weight / host::pi), "#2b7bba33", "#2b7bba") + dot(at, 1, "#000", "none");
    }
    marks += dot(centre, 3, "#d62728", "none");
    return svg(picture_width, picture_width, marks, name);
}

// Figure 3.3 or 3.4: one path. Across is to the right, towards the light is up, both to one scale.
std::string path_svg(const VrsmPath& path, bool by_2, const std::string& caption) {
    double right = 0, low = 0, high = 0;
    auto reach = [&](const glm::dvec2& p) {
        if (std::isfinite(p.x)) right = std::max(right, p.x), low = std::min(low, p.y), high = std::max(high, p.y);
    };
    for (const glm::dvec2& p : path.surface) reach(p);
    for (const VrsmPath::Sample& s : path.samples) reach(s.at);
    const double margin = 12, width = picture_width * 1.3, scale = (width - 2 * margin) / std::max({right, high - low, 1e-9});
    const double height = std::max((high - low) * scale, 80.0) + 2 * margin;
    auto place = [&](const glm::dvec2& p) { return glm::dvec2(margin + p.x * scale, margin + (high - p.y) * scale); };
    const glm::dvec2 start = place({0, 0});
    std::string marks;
    for (const double edge : path.edges) {
        // To where the ray leaves the picture.
        const glm::dvec2 way(host::cos(edge), -host::sin(edge));
        const double to_side = (width - start.x) / std::max(way.x, 1e-9);
        const double to_end = way.y < 0 ? start.y / -way.y : way.y > 0 ? (height - start.y) / way.y : to_side;
        marks += line(start, start + way * std::min(to_side, to_end), "#7a9", 1);
    }
    std::string points;
    for (const glm::dvec2& p : path.surface) {
        if (std::isfinite(p.x)) {
            points += fmt::format("{:.2f},{:.2f} ", place(p).x, place(p).y);
            continue;
        }
        marks += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#444\" stroke-width=\"1.5\"/>\n", points);
        points.clear();
    }
    marks += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#444\" stroke-width=\"1.5\"/>\n", points);
    for (const VrsmPath::Sample& s : path.samples) {
        const bool seen = by_2 ? s.seen_by_2 : s.seen_by_6;
        marks += dot(place(s.at), 5, seen ? "#d62728" : "#000", "#fff");
        marks += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\" fill=\"#000\">{}</text>\n", place(s.at).x + 5,
                             place(s.at).y - 6, s.slot);
    }
    marks += dot(start, 4, "#2b7bba", "#fff");
    return svg(int(width), int(height), marks, caption);
}

std::string point_text(const VrsmPath& path) {
    return fmt::format("pixel {},{}, path {}", path.pixel.x, path.pixel.y, path.path);
}

void show(page::Page& page, const Image4& image, const std::string& caption) {
    page.figure(page.picture(image, caption),
                {glm::dvec2(image.width, image.height), glm::dvec4(0, 0, image.width, image.height), picture_width, ""});
}

}  // namespace

void add_pattern_figure(page::Page& page, const Vrsm&) {
    page.heading("Figure 3.1: the base sampling pattern", "pattern");
    page.paragraph(
        "15 paths of 10 samples around the projection of a point (red), without jitter, one rotation of them. A disc has the area of "
        "the texels that its sample stands for. VRSM 3.2: density decreases with the distance, and the weight increases.");
    page.raw(pattern_svg(rsm::Spacing::uniform, "uniform: steps of one length") +
             pattern_svg(rsm::Spacing::quadratic, "quadratic: steps grow with the root of the distance (the default)") +
             pattern_svg(rsm::Spacing::geometric, fmt::format("geometric, growth {:g}: steps grow with the distance, for which alone "
                                                              "the weight by its square is right", vrsm_growth)));
}

void add_noise_figure(page::Page& page, const VrsmScene& scene) {
    page.raw("<h3>Figure 3.2: noised irradiance, and what the blur makes of it</h3>\n");
    show(page, scene.pictures.noised, "(a) 15 x 10 samples, half resolution, upsampled, no blur");
    show(page, scene.pictures.indirect_with, "(b) And the edge-aware blur of 17");
}

void add_buffer_figure(page::Page& page, const VrsmScene& scene) {
    page.raw("<h3>Figures 3.3 and 3.4: the micro linear buffer along one path</h3>\n");
    page.paragraph(
        "A point (blue), the surface that the light's map shows along one path, and the path's samples with the slot of each: red ones "
        "are visible, black ones hidden. Right is across the light's axis, up towards the light, to one scale; lines from the point "
        "are where slots meet. As the kernel has them (plumb explain).");
    if (scene.hidden)
        page.raw(path_svg(*scene.hidden, false, "Figure 3.3: most samples hidden by Algorithm 6: " + point_text(*scene.hidden)));
    if (scene.neighbours)
        page.raw(path_svg(*scene.neighbours, true,
                          "Figure 3.4 (a): neighbours on a surface fall into one slot, and Algorithm 2 hides them: " +
                              point_text(*scene.neighbours)) +
                 path_svg(*scene.neighbours, false, "(b) The same by Algorithm 6: a sample inherits the visibility of the one before"));
    if (!scene.hidden && !scene.neighbours) page.paragraph("None of 24 x 24 points has a path on which a sample is hidden.");
    show(page, scene.pictures.without_check, "Figure 3.4 (c): irradiance by Algorithm 2, 5 slots");
    show(page, scene.pictures.indirect_with, "(d) By Algorithm 6");
}

}  // namespace plumb::cli
