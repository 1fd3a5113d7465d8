// plumb experiment hemicube: what the thesis' choices cost. One picture in place of a hemicube (HEM 4.5.3); multiplier maps, eyes and
// buffers as published (5.5 to 5.7).
#include <fmt/format.h>

#include <cmath>

#include "core/formats.h"
#include "core/host_math.h"
#include "gi/radiosity/hemicube_factor.h"
#include "gi/radiosity/projections.h"
#include "gi/radiosity/published_pass.h"
#include "gi/reference/form_factors.h"
#include "tools/experiments/hemicube_world.h"

namespace plumb::cli {

namespace {

// ---- One picture in place of five ---------------------------------------------------------------------------------------

// From points of a surface to a polygon that nothing hides.
struct Case {
    std::vector<radiosity::SourcePoint> points;
    radiosity::Polygon target;
    Geometry geometry;
    double truth = 0;  // mean of Lambert's formula over the points
};

Case case_of(const radiosity::RaySource& from, int points, const radiosity::Polygon& target) {
    Case c{radiosity::source_points(from, points), target, {}, 0};
    for (const glm::dvec3& p : target) {
        Vertex v;
        v.position = glm::vec3(p);
        c.geometry.vertices.push_back(v);
    }
    for (std::uint32_t k = 2; k < target.size(); ++k) c.geometry.triangles.push_back({0, k - 1, k});
    c.geometry.material.assign(c.geometry.triangles.size(), 0), c.geometry.object = c.geometry.material;
    for (const radiosity::SourcePoint& p : c.points) c.truth += radiosity::point_form_factor(p.position, p.normal, {target}) / double(c.points.size());
    return c;
}

const radiosity::Polygon floor_square = {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}, opposed_square = {{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}},
                         wall_square = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};

Case disc_case() {
    radiosity::RaySource patch;
    patch.normal = {0, 1, 0};
    radiosity::Polygon disc;
    for (int k = 0; k < 256; ++k) {
        const double a = 2 * host::pi * k / 256;
        disc.push_back({0.5 * host::cos(a), 1, 0.5 * host::sin(a)});
    }
    return case_of(patch, 1, disc);
}
Case square_case(const radiosity::Polygon& target, int points) {
    radiosity::RaySource square;
    square.faces = {floor_square};
    return case_of(square, points, target);
}

struct Way {
    std::string name, settings;
    double texels = 0, lost = 0;
    double view_deg = 0;   // of what is not rescaled: where it stands in the chart
    std::size_t line = 0;  // of the chart
    std::function<double(const Case&)> factor;
    std::function<radiosity::RotationErrors()> rotations;
};

constexpr double off_surface = 1e-5;  // m

Way hemicube_way(int size, radiosity::Weights weights, const std::string& name, const RunOptions& options) {
    return {name, fmt::format("{} texels a side", size), 3.0 * size * size, 0, 0, 0,
            [=](const Case& c) {
                const std::vector<std::int32_t> all(2 * c.geometry.triangles.size(), 0);
                return radiosity::hemicube_form_factor(c.geometry, nullptr, c.points, all, size, weights, off_surface, options);
            },
            [=] { return radiosity::rotation_errors(size, weights, options); }};
}

Way projected_way(const radiosity::ProjectionParams& p, const RunOptions& options) {
    const bool plane = p.projection == radiosity::Projection::plane;
    return {fmt::format("{}, {:g} degrees{}", plane ? "plane" : "fish-eye", p.view_deg, p.rescale ? ", rescaled" : ""), fmt::format("{0} x {0} texels", p.size),
            double(p.size) * p.size, 1 - radiosity::share_of_view(p.view_deg), p.rescale ? 0 : p.view_deg, plane ? 0u : 1u,
            [=](const Case& c) {
                const std::vector<std::int32_t> all(2 * c.geometry.triangles.size(), 0);
                return radiosity::projected_form_factor(c.geometry, nullptr, c.points, all, p, off_surface, options);
            },
            [=] {
                return radiosity::rotation_errors([&](const Geometry& g) {
                    return radiosity::projected_form_factor(g, nullptr, {{{0, 0, 0}, {0, 1, 0}}}, std::vector<std::int32_t>(2 * g.triangles.size(), 0), p, off_surface,
                                                            options);
                });
            }};
}

std::vector<Way> ways_of(int hemicube, const RunOptions& options) {
    std::vector<Way> ways = {hemicube_way(hemicube, radiosity::Weights::exact, "hemicube", options),
                             hemicube_way(hemicube, radiosity::Weights::published, "hemicube, published maps", options)};
    for (const radiosity::Projection kind : {radiosity::Projection::plane, radiosity::Projection::fish_eye})
        for (const double view : {90., 120., 150., 160., 170., 175.})
            for (const bool rescale : {false, true})
                if (!rescale || view == 160 || view == 170) ways.push_back(projected_way({kind, radiosity::size_of_equal_texels(hemicube), view, rescale}, options));
    return ways;
}

}  // namespace

IprSheet measure_projections(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    tell("one picture in place of five");
    const int hemicube = request.quick ? 16 : 64, points = request.quick ? 8 : 64;
    const Case opposed = square_case(opposed_square, points), wall = square_case(wall_square, points), disc = disc_case();
    IprSheet sheet{"HEM 4.5.3", "one picture in place of a hemicube, as many texels", "error of form factors against Lambert's formula at the same points", {}, {}, {}, {}};
    sheet.heads = {{"texels"}, {"lost: % of the hemisphere", 3}, {"patch to a square (B-3), turned: rms %", 3}, {"largest %", 3},
                   {"opposed squares (C-11) %", 3}, {"squares at a right angle (C-14) %", 3}, {"patch to a disc (B-12) %", 3}};
    page::Chart chart{"form factors of one picture", "angle of view, degrees", "|error| of C-14, %", false, true, {{"plane"}, {"fish-eye"}}};
    for (const Way& way : ways_of(hemicube, options)) {
        const auto error = [&](const Case& c) { return 100 * (way.factor(c) / c.truth - 1); };
        const radiosity::RotationErrors turned = way.rotations();
        const double corner = error(wall);
        sheet.rows.push_back({way.name, way.settings, {way.texels, 100 * way.lost, turned.rms, turned.largest, error(opposed), corner, error(disc)}, {}});
        if (way.view_deg > 0) chart.lines[way.line].points.push_back({way.view_deg, std::fabs(corner), {{"row", way.name}}});
    }
    sheet.charts = {chart};
    sheet.lines = {fmt::format("Lambert's formula at the {} points has {:.6f} for C-11 ({:.6f} over the squares) and {:.6f} for C-14 ({:.6f}); of the disc's 256 corners {:.6f} ({:.6f}).",
                               points, opposed.truth, reference::opposed_rectangles(1, 1, 1), wall.truth, reference::perpendicular_rectangles(1, 1, 1), disc.truth,
                               reference::patch_to_disc(0.5, 1)),
                   "A plane loses what is lower than its edge, and its middle, where most light comes from, has the largest texels: at 170 degrees one weighs as much as tan(85)^2 / 3 = 44 of a hemicube's. "
                   "Resampled by a lens, texels of the middle are read many times and those of the border left out: no more is known of the scene than the plane's picture has."};
    return sheet;
}

// ---- Maps, eyes and buffers as published --------------------------------------------------------------------------------

namespace {

glm::vec3 through_rgbe(const glm::vec3& v) { return decode_rgbe(encode_rgbe(v)); }

// Corners' colours are encoded, and what lies between is made of the codes (5.5 has vertices in A8R8G8B8).
glm::vec3 between_codes(const std::array<glm::vec3, 3>& corners, const glm::vec3& at) {
    glm::vec4 code(0);
    for (int k = 0; k < 3; ++k) code += at[k] * glm::vec4(encode_rgbe(corners[std::size_t(k)]));
    return glm::vec3(code) / 255.0f * float(host::exp2(double(code.w) - 128));
}

glm::vec3 linear(const std::array<glm::vec3, 3>& corners, const glm::vec3& at) { return at.x * corners[0] + at.y * corners[1] + at.z * corners[2]; }

void each_colour(Buffer<glm::vec4>& b, const std::function<glm::vec3(const glm::vec3&)>& change) {
    for (glm::vec4& v : b) v = glm::vec4(change(glm::vec3(v)), 0);
}
glm::vec3 saturated_8_bits(const glm::vec3& v) { return glm::floor(glm::clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f) / 255.0f; }

struct Choice {
    std::string name, source;
    bool published_eyes = false;
    radiosity::Weights weights = radiosity::Weights::exact;
    decltype(radiosity::PublishedPass::texel) texel = {};
    std::function<void(Buffer<glm::vec4>&)> store = {};
    radiosity::Reduction reduction = {};
};

std::vector<Choice> choices() {
    const auto rgbe_texel = [](const std::array<glm::vec3, 3>& c, const glm::vec3& at) { return through_rgbe(linear(c, at)); };
    const auto rgbe_store = [](Buffer<glm::vec4>& b) { each_colour(b, through_rgbe); };
    const auto saturate = [](Buffer<glm::vec4>& b) { each_colour(b, [](const glm::vec3& v) { return glm::clamp(v, 0.0f, 1.0f); }); };
    const auto bytes = [](Buffer<glm::vec4>& b) { each_colour(b, saturated_8_bits); };
    using W = radiosity::Weights;
    return {
        {"floats", "exact weights, eyes in from borders"},
        {"weights at texels' centres", "raster/hemicube.h", false, W::centre},
        {"multiplier maps", "HEM (5.5), (5.7), scaled to a sum of 1", false, W::published},
        {"eyes along the normal alone", "HEM 5.6.3", true},
        {"maps and eyes", "HEM 5.5, 5.6", true, W::published},
        {"RGBE texels", "HEM 5.7, decoder divides by 255", false, W::exact, rgbe_texel},
        {"RGBE texels and vertices", "HEM 5.7", false, W::exact, rgbe_texel, rgbe_store},
        {"codes between vertices", "vertices encoded, Gouraud between codes", false, W::exact, between_codes, rgbe_store},
        {"vertices saturated", "HEM 5.6.5", false, W::exact, {}, saturate},
        {"vertices in X8R8G8B8", "HEM 5.6.5: no exponent", false, W::exact, {}, bytes},
        {"decoder as printed", "HEM 5.7, without / 255", false, W::exact, [](const std::array<glm::vec3, 3>& c, const glm::vec3& at) { return 255.0f * through_rgbe(linear(c, at)); }},
        {"summed on the device", "HEM 6.7.1, radiosity.reduce: boxes of 2 x 2 texels, floats", false, W::exact, {}, {}, {2}},
        {"sums in halves", "HEM 6.7.1, RGBA16F between its passes", false, W::exact, {}, {}, {2, false, Format::rgba16f}},
        {"means in halves", "HEM 6.7.1, weights times the texels, means of boxes", false, W::exact, {}, {}, {2, true, Format::rgba16f}},
        {"all as published", "maps, eyes, RGBE texels, vertices saturated", true, W::published, rgbe_texel, saturate},
    };
}

// Passes from black, each drawn and summed anew; H of the last.
Buffer<glm::vec4> passes_as_published(const Box& box, const Choice& choice, int size, int passes, const RunOptions& options) {
    radiosity::PublishedPass pass;
    pass.row.size = size, pass.row.weights = choice.weights, pass.texel = choice.texel, pass.reduction = choice.reduction;
    const radiosity::Elements& e = box.elements;
    Buffer<glm::vec4> b(std::size_t(e.count()), glm::vec4(0)), h;
    for (int k = 0; k < passes; ++k) {
        radiosity::published_irradiance(e, pass, b, 0, e.count(), options, h);
        for (std::size_t i = 0; i < b.size(); ++i) b[i] = e.exitance[i] + e.reflectance[i] * h[i];
        if (choice.store) choice.store(b);
    }
    radiosity::published_irradiance(e, pass, b, 0, e.count(), options, h);
    return h;
}

}  // namespace

IprSheet measure_buffers(const HemicubeRequest& request, const RunOptions& options, const Tell& tell) {
    const int size = request.quick ? 16 : 64, passes = request.quick ? 3 : 10;
    IprSheet sheet{"HEM 5.5 to 5.7", "multiplier maps, eyes and buffers as published",
                   fmt::format("the box of 774 vertices, hemicubes of {}, {} passes, each drawn and summed anew", size, passes), {}, {}, {}, {}};
    sheet.heads = {{"mean irradiance W/m2", 4}, {"against floats: mean %", 3}, {"largest %", 2}};
    add_error_heads(sheet.heads, "truth");
    const Box box = benchmark_box(benchmark_meshes[0].triangles, false, options), published = benchmark_box(benchmark_meshes[0].triangles, true, options);
    tell("buffers: truth");
    const ElementTruth truth = trace_elements(box, request, options);
    Buffer<glm::vec4> floats;
    for (const Choice& c : choices()) {
        tell("buffers: " + c.name);
        const Buffer<glm::vec4> h = passes_as_published(c.published_eyes ? published : box, c, size, passes, options);
        if (floats.empty()) floats = h;
        double mean = 0, area = 0, largest = 0;
        for (std::size_t i = 0; i < h.size(); ++i) {
            const double own = luminance_of(h[i]), its = luminance_of(floats[i]);
            mean += box.elements.area[i] * own, area += box.elements.area[i];
            largest = std::max(largest, std::fabs(own - its) / its);
        }
        IprSheetRow row{c.name, c.source, {mean / area, 100 * mean_difference(h, floats, box.elements.area), 100 * largest}, {}};
        add_error_values(row.values, errors_of(h, truth));
        sheet.rows.push_back(std::move(row));
    }
    sheet.lines = {"The decoder as printed makes every texel 255 times as bright: each pass multiplies what it reflects by that.",
                   "Saturated vertices make the lamp of 100 one of 1: the thesis calls it overexposure what makes up for it (5.11)."};
    return sheet;
}

}  // namespace plumb::cli
