// Cases that no scene and no frame has.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/host_math.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/stability/cases_parts.h"
#include "gi/stability/unbound.h"
#include "gi/stability/unbound_stages.h"
#include "raster/screen_triangle.h"
#include "raster/hemicube.h"
#include "raster/texture_space.h"

namespace plumb::stability {

namespace {

using reference::Measured;

// ---- Closed forms: what paths find, within four standard errors
// ------------------------------------------------------

// `condition` is what makes four standard errors the budget. One that is above a quarter of the truth says nothing.
Cell closed_form_cell(double expected, const Measured& measured) {
    Cell cell;
    cell.stage = "reference";
    cell.pixels = std::int64_t(measured.samples);
    const double rounding = 4e-6 * expected;  // of floats in the scene, on the way and in the result
    const double error = std::sqrt(measured.standard_error * measured.standard_error + rounding * rounding);
    const double condition = 4 * error / (cell.budget * 0x1p-23 * expected);
    judge(
        {{measured.got, expected, condition}},
        [&](std::size_t) { return fmt::format("mean, standard error {:.3g}", measured.standard_error); }, cell);
    cell.nonfinite += std::int64_t(measured.nonfinite);
    if (!(measured.standard_error <= expected / 4)) cell.used = std::numeric_limits<double>::infinity();
    conclude(cell);
    return cell;
}

reference::ClosedFormOptions options_of(const Effort& effort) {
    reference::ClosedFormOptions options;
    options.error = 0.02;
    options.run = effort.run;
    options.run.progress = nullptr;
    return options;
}

using Point = glm::dvec3;

// A closed cube whose walls all emit 1 W/m2.
Scene furnace(const Point& centre, double half, float rho) {
    Scene scene;
    reference::add_cube(scene, reference::grey(rho, 1), centre - half, centre + half);
    return scene;
}

Cell furnace_cell(const Point& centre, double half, float rho, const Effort& effort) {
    const Scene scene = furnace(centre, half, rho);
    auto points = [&](std::uint64_t n) { return reference::spread(scene.meshes[0], centre, n); };
    return or_refused("reference", [&] {
        return closed_form_cell(1 / (1 - double(rho)),
                                trace_points(scene, reference::Mode::all, points, options_of(effort)));
    });
}

// The same as a camera in it sees, which is served wherever the cube lies: M / (pi (1 - rho)).
Cell seen_furnace_cell(const Point& centre, double half, float rho, const Effort& effort) {
    Camera camera;
    camera.position = centre, camera.look_at = centre + half * Point(0.5, -0.25, -1);
    const Measured seen = reference::trace_frame(furnace(centre, half, rho), camera, options_of(effort));
    return closed_form_cell(1 / (host::pi * (1 - double(rho))), seen);
}

// Few paths, but of as many reflections: the sum of rho^k up to k = `reflections`. To all of the series a path brings
// what its chance length is, and a dozen would tell nothing; so long, most paths live.
Cell long_paths_cell(float rho, int reflections, const Effort& effort) {
    const Scene scene = furnace(Point(0), 1, rho);
    const std::unique_ptr<reference::PathScene> prepared = reference::prepare(scene, Rays::native);
    const reference::ReceiverPoints points = reference::spread(scene.meshes[0], Point(0), 1);
    Image4 position(4, 1), normal(4, 1);
    for (int i = 0; i < 4; ++i) {
        const std::size_t from = points.position.size() * std::size_t(2 * i + 1) / 8;
        position.texels[std::size_t(i)] = points.position.texels[from];
        normal.texels[std::size_t(i)] = points.normal.texels[from];
    }
    reference::PathParams params;
    params.samples = 4, params.rounds = 4, params.max_bounces = reflections;
    const reference::Estimate e =
        reference::trace_irradiance(params, *prepared, {&position, &normal}, 1, options_of(effort).run);
    Measured m;
    double variance = 0;
    for (int i = 0; i < 4; ++i) {
        const double error = e.error.texels[std::size_t(i)].x;
        m.got += double(e.mean.texels[std::size_t(i)].x) / 4, variance += error * error / 16;
    }
    m.standard_error = std::sqrt(variance);
    m.samples = 16, m.nonfinite = e.nonfinite;
    return closed_form_cell((1 - host::pow(rho, reflections + 1)) / (1 - double(rho)), m);
}

// A sphere with two lamps: (P/A) rho / (1 - rho), wherever they are.
Cell lamps_cell(double ratio, const Effort& effort) {
    Scene scene;
    reference::add_sphere(scene, reference::grey(0.5), Point(0), 1, 5);
    scene.lights = {reference::point_lamp({0.3, 0.2, -0.4}, 100), reference::point_lamp({-0.2, 0, 0.3}, 100 * ratio)};
    const reference::SurfacePoint p = reference::middle_of(scene.meshes[0], 5000, Point(0));
    auto points = [&](std::uint64_t n) { return reference::repeated(p.position, p.normal, n); };
    return closed_form_cell(100 * (1 + ratio) / (4 * host::pi),
                            trace_points(scene, reference::Mode::indirect, points, options_of(effort)));
}

void add_closed_forms(std::vector<UnboundCase>& out) {
    const Point off(0.25, 0.5, -0.125);
    for (const double by : {1e-4, 1e-2, 1e2, 1e4, 1e6})
        out.push_back({"furnace, scale " + power_text(by), "closed forms",
                       fmt::format("a closed cube {:g} m wide, rho 0.5, M = 1: B = M / (1 - rho)", 2 * by),
                       [=](const Effort& e) { return std::vector{furnace_cell(by * off, by, 0.5f, e)}; }});
    for (const double by : {1e3, 1e4, 1e5, 1e6})
        out.push_back({"furnace, offset " + power_text(by), "closed forms",
                       fmt::format("the cube of 2 m lies {:g} m from the origin along every axis", by),
                       [=](const Effort& e) { return std::vector{furnace_cell(Point(by), 1, 0.5f, e)}; }});
    for (const double by : {1e3, 1e5, 1e6, 1e7})
        out.push_back({"furnace seen, offset " + power_text(by), "closed forms",
                       fmt::format("a camera in the cube, {:g} m from the origin along every axis", by),
                       [=](const Effort& e) { return std::vector{seen_furnace_cell(Point(by), 1, 0.5f, e)}; }});
    for (const double ratio : {1e-6, 1e-3, 1e4, 1e8})
        out.push_back({"two lamps, ratio " + power_text(ratio), "closed forms",
                       fmt::format("in a sphere, one {:g} times as strong as the other: (P/A) rho / (1 - rho)", ratio),
                       [=](const Effort& e) { return std::vector{lamps_cell(ratio, e)}; }});
    out.push_back({"furnace, rho 0.999999", "closed forms", "200,000 reflections: B = M (1 - rho^200001) / (1 - rho)",
                   [](const Effort& e) { return std::vector{long_paths_cell(0.999999f, 200000, e)}; }});
}

// ---- Hemicubes
// -------------------------------------------------------------------------------------------------------

Vertex vertex(const glm::vec3& position, const glm::vec3& normal = glm::vec3(0)) {
    Vertex v;
    v.position = position, v.normal = normal;
    return v;
}

// A room: a box around the origin, and a sliver that passes through it.
Scene box(double half) {
    Scene scene;
    reference::add_cube(scene, reference::grey(0.5), Point(-half), Point(half));
    Mesh sliver;
    sliver.vertices = {vertex({-0.5f, 0.25f, -0.5f}), vertex({0.5f, 0.25f, 0.5f}), vertex({0.5f, 0.25f + 1e-6f, 0.5f})};
    sliver.triangles = {{0, 1, 2}};
    sliver.material = {0};
    scene.meshes.push_back(sliver);
    return scene;
}

UnboundCase hemicube(const std::string& name, const std::string& meaning, const Point& eye, const Point& normal,
                     int size) {
    return {name, raster::info_hemicube().name, meaning, [=](const Effort& effort) {
                const Drawable room = drawable(box(1));
                return std::vector{
                    or_refused(raster::info_hemicube().name, [&] { return hemicube_cell(room, eye, normal, 1e-5, size, effort); })};
            }};
}

void add_hemicubes(std::vector<UnboundCase>& out) {
    const Point eye(0.25, -1, 0.125), up(0, 1, 0);
    out.push_back(hemicube("hemicube of 2", "2 x 2 pixels and four times 2 x 1", eye, up, 2));
    out.push_back(hemicube("hemicube of 1024", "1024 x 1024 pixels and four times 1024 x 512", eye, up, 1024));
    out.push_back(hemicube("hemicube without a normal", "of a vertex whose normal is 0: refused", eye, Point(0), 64));
    out.push_back(hemicube("hemicube, normal 1e-20", "a normal as short as that, and not along an axis", eye,
                           Point(1e-20, 3e-20, -2e-20), 64));
    out.push_back(hemicube("hemicube in a corner", "the eye is a vertex of three walls: all of them are seen edge-on",
                           Point(-1), Point(1), 64));
    out.push_back(hemicube("hemicube on a sliver", "the eye lies on a triangle 1 um wide", {0, 0.25, 0}, up, 64));
}

// ---- Charts
// ----------------------------------------------------------------------------------------------------------

// Two quads, the second with the corners of `chart` for texture coordinates.
UnboundCase chart(const std::string& name, const std::string& meaning, const std::array<glm::vec2, 4>& corners) {
    return {
        name, "chart", meaning, [=](const Effort& effort) {
            Scene scene;
            for (const double y : {0.0, 1.0})
                reference::add_rectangle(scene, reference::grey(0.5, 1), {-1, y, -1}, {1, y, 1});
            const Drawable drawn = drawable(scene);
            const glm::vec2 whole[] = {{0, 0}, {0, 0.5}, {0.5, 0.5}, {0.5, 0}};
            std::vector<glm::vec2> uv;
            for (int q = 0; q < 2; ++q)
                for (const int c : {0, 1, 2, 0, 2, 3}) uv.push_back(q == 0 ? whole[c] : corners[std::size_t(c)]);
            return std::vector{or_refused(raster::info_texture_space().name, [&] { return texture_space_cell(drawn, uv, 64, effort); })};
        }};
}

void add_charts(std::vector<UnboundCase>& out) {
    const float nan = std::nanf("");
    out.push_back(
        chart("chart without area", "all corners in one point", {{{.7f, .7f}, {.7f, .7f}, {.7f, .7f}, {.7f, .7f}}}));
    out.push_back(chart("chart on a line", "corners along a line through centres of texels",
                        {{{.6015625f, .7f}, {.6015625f, .8f}, {.6015625f, .9f}, {.6015625f, .75f}}}));
    out.push_back(chart("chart of slivers", "1e-6 of the map wide, across it",
                        {{{.5f, .5f}, {.5f, .500001f}, {1, 1}, {1, .999999f}}}));
    out.push_back(chart("chart upon another", "both in the same place: the first stays",
                        {{{0, 0}, {0, .5f}, {.5f, .5f}, {.5f, 0}}}));
    out.push_back(chart("chart beyond the map", "reaches 1e6 maps far",
                        {{{-1e6f, -1e6f}, {-1e6f, 1e6f}, {1e6f, 1e6f}, {1e6f, -1e6f}}}));
    out.push_back(
        chart("chart that is no number", "refused by the vertex's name", {{{nan, 0}, {0, 1}, {1, 1}, {1, 0}}}));
}

// ---- Coverage
// --------------------------------------------------------------------------------------------------------

// A fan that fills the screen: its blades meet in one point and end on a square of 2 `reach` frames.
Geometry fan(int blades_a_side, double reach) {
    Geometry g;
    g.vertices.push_back(vertex({0.0137f, -0.0291f, 0.5f}));
    const glm::dvec2 corners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int side = 0; side < 4; ++side)
        for (int i = 0; i < blades_a_side; ++i) {
            const double along = double(i) / blades_a_side;
            const glm::dvec2 p = reach * (corners[side] * (1 - along) + corners[(side + 1) % 4] * along);
            g.vertices.push_back(vertex({float(p.x), float(p.y), 0.5f}));
        }
    const auto n = std::uint32_t(4 * blades_a_side);
    for (std::uint32_t i = 0; i < n; ++i) g.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % n);
    g.material.assign(n, 0), g.object.assign(n, 0);
    return g;
}

// How many triangles cover each pixel against one.
Cell coverage_cell(const Geometry& geometry, glm::ivec2 size) {
    Cell cell;
    cell.stage = "visibility";
    std::vector<Checked> counts(std::size_t(size.x) * std::size_t(size.y), Checked{0, 1, 1});
    View view;
    view.orthographic = true, view.forward = {0, 0, 1};
    const raster::ScreenTriangles screen = raster::screen_triangles(geometry, view, size, 1);
    for (const raster::ScreenTriangle& t : screen.triangles)
        for (int y = 0; y < size.y; ++y) {
            raster::EdgeRow edges[3];
            for (int i = 0; i < 3; ++i) edges[i] = raster::edge_row(t, raster::area2(t) > 0, i, y);
            std::int64_t first = 0, last = size.x - 1;
            raster::covered_columns(edges, first, last);
            for (std::int64_t x = first; x <= last; ++x)
                ++counts[std::size_t(y) * std::size_t(size.x) + std::size_t(x)].got;
        }
    judge(
        counts, [&](std::size_t i) { return fmt::format("triangles on pixel {}", i); }, cell);
    cell.pixels = std::int64_t(counts.size());
    conclude(cell);
    return cell;
}

UnboundCase coverage(const std::string& name, const std::string& meaning, int blades_a_side, double reach) {
    return {name, "coverage", meaning, [=](const Effort& effort) {
                const glm::ivec2 size{160, 90};
                const Geometry g = fan(blades_a_side, reach);
                Cell cell = coverage_cell(g, size);
                // Depth and barycentrics.
                Drawable drawn{g, {}};
                Scene scene;
                scene.materials.emplace_back();
                drawn.surfaces = raster::prepare(scene, drawn.geometry);
                View view;
                view.orthographic = true, view.forward = {0, 0, 1};
                merge(cell, visibility_cell(drawn, view, size, effort));
                return std::vector{cell};
            }};
}

void add_coverage(std::vector<UnboundCase>& out) {
    out.push_back(coverage("fan of 4", "four triangles fill the screen: each pixel lies in one", 1, 1.5));
    out.push_back(coverage("fan of 4096", "blades thinner than a pixel: each pixel lies in one", 1024, 1.5));
    out.push_back(coverage("fan that reaches 400 frames", "as far as the guard band: each pixel lies in one", 16, 400));
}

}  // namespace

const std::vector<UnboundCase>& unbound_cases() {
    static const std::vector<UnboundCase> all = [] {
        std::vector<UnboundCase> list;
        add_closed_forms(list);
        add_hemicubes(list);
        add_charts(list);
        add_coverage(list);
        return list;
    }();
    return all;
}

}  // namespace plumb::stability
