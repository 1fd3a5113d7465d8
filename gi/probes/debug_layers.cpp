#include "gi/probes/debug_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "gi/probes/plot.h"
#include "gi/probes/scene_view.h"
#include "gi/probes/sky_probe.h"

namespace plumb::probes {

namespace {

// A colour for each number, bright enough to be told from nothing.
glm::vec4 colour_of(int i) {
    const auto h = pixel_hash<std::int32_t>(i, 7, 1, 3);
    return {0.25f + 0.75f * unit_float<float>(h.x), 0.25f + 0.75f * unit_float<float>(h.y), 0.25f + 0.75f * unit_float<float>(h.z),
            1};
}

// From blue over white to red, 0 white.
glm::vec4 signed_colour(double x) {
    const float t = float(std::min(1.0, std::fabs(x)));
    return x < 0 ? glm::vec4(1 - t, 1 - t, 1, 1) : glm::vec4(1, 1 - t, 1 - t, 1);
}

// ---- On the lightmap -------------------------------------------------------------------------------------------------

template <class ColourOf>
Image4 on_lightmap(const Receivers& r, ColourOf colour) {
    Image4 picture(r.size.x, r.size.y, nothing);
    for (int i = 0; i < r.count(); ++i) picture(r.texel[i].x, r.texel[i].y) = colour(i);
    return picture;
}

Image4 border_picture(const Receivers& r) {
    Image4 picture = on_lightmap(r, [&](int i) { return r.border[i] ? glm::vec4(1, 0.8f, 0.2f, 1) : grey; });
    for (int i = 0; i < r.count(); ++i)
        for (std::size_t k = 0; k < border_steps.size(); ++k) {
            const glm::ivec2 beside = r.texel[i] + border_steps[k];
            if (r.border[i] >> k & 1) picture(beside.x, beside.y) = glm::vec4(0.2f, 0.5f, 1, 1);
        }
    return picture;
}

// ---- Functions on the sphere, and singular values --------------------------------------------------------------------

// sum over the supporting probes of sum_j alpha_ij Y_j(d), by longitude and latitude, y up, over its largest value.
Image4 alpha_picture(const Bake& b, int receiver) {
    const int coefficients = b.coefficients(), slots = b.supports.overlaps;
    Image4 picture(512, 256);
    double largest = 0;
    std::vector<double> values;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const double theta = host::pi * (y + 0.5) / picture.height, phi = 2 * host::pi * ((x + 0.5) / picture.width - 0.5);
            const glm::dvec3 d(host::sin(theta) * host::sin(phi), host::cos(theta), -host::sin(theta) * host::cos(phi));
            const sh::Values basis = sh::basis(d, b.params.degree);
            double sum = 0;
            for (int s = 0; s < slots; ++s)
                for (int j = 0; j < coefficients; ++j)
                    sum += double(b.alpha[std::size_t((std::int64_t(receiver) * slots + s) * coefficients + j)]) * basis[std::size_t(j)];
            values.push_back(sum);
            largest = std::max(largest, std::fabs(sum));
        }
    for (std::size_t i = 0; i < values.size(); ++i) picture.texels[i] = signed_colour(largest > 0 ? values[i] / largest : 0);
    return picture;
}

// A curve a cluster: the singular values that are kept over the largest, 1 to 1e-6, logarithmic, by their number.
Image4 singular_picture(const Clusters& clusters) {
    constexpr int decades = 6;
    std::size_t most = 2;
    for (const Cluster& c : clusters.clusters) most = std::max(most, c.singular_values.size());
    const auto across = [&](std::size_t i) { return double(i) / double(most - 1); };
    PlotAxes axes{.across_name = "i", .upwards_name = "si/s1"};
    const std::size_t every = std::max(std::size_t(1), most / 8);
    for (std::size_t i = 0; i < most; ++i)
        if (i == 0 || (i + 1) % every == 0) axes.across.push_back({across(i), fmt::format("{}", i + 1)});
    for (int d = 0; d <= decades; ++d) axes.upwards.push_back({1 - double(d) / decades, d == 0 ? "1" : fmt::format("1e-{}", d)});
    Plot plot({640, 360}, axes);
    for (std::size_t k = 0; k < clusters.clusters.size(); ++k) {
        const std::vector<double>& s = clusters.clusters[k].singular_values;
        std::vector<glm::dvec2> points;
        for (std::size_t i = 0; i < s.size() && s[0] > 0; ++i)
            points.push_back({across(i), 1 + host::log(std::max(s[i] / s[0], 1e-12)) / host::log(10) / decades});
        plot.curve(points, 0.8f * colour_of(int(k)));
    }
    return plot.picture();
}

}  // namespace

std::vector<DebugLayer> debug_layers(const Bake& b, const raster::Surfaces& surfaces, const DebugView& view,
                                     const RunOptions& options) {
    const Receivers& r = b.receivers;
    std::vector<DebugLayer> layers;
    const auto add = [&](const char* name, const char* node, const char* meaning, Image4 picture) {
        layers.push_back({name, node, meaning, std::move(picture)});
    };
    const SceneView scene(b.atlas, surfaces, view.view, view.size, options);
    const auto add_both = [&](const std::string& name, const char* node, const char* meaning, Image4 lightmap) {
        const Image4 extended = extend_borders(r, lightmap);  // surfaces end between texel centres
        layers.push_back({name, node, meaning, std::move(lightmap)});
        layers.push_back({name + ".scene", node, meaning, scene.with(&extended)});
    };
    add_both("charts", "probes.atlas", "a colour each chart",
             on_lightmap(r, [&](int i) { return colour_of(b.atlas.chart[std::size_t(r.triangle[i])]); }));
    add("normals", "probes.receivers", "n / 2 + 1 / 2", on_lightmap(r, [&](int i) { return 0.5f * r.normal[i] + 0.5f; }));
    add("borders", "probes.receivers", "yellow: receivers that extend; blue: where", border_picture(r));
    float farthest = 1e-30f;
    for (const glm::vec4& s : r.shift) farthest = std::max(farthest, glm::length(glm::vec3(s)));
    add_both("shifts", "probes.receivers", "red: receivers that were moved, by how much of the farthest",
             on_lightmap(r, [&](int i) {
                 return r.shift[i].w == 0 ? grey : glm::vec4(1, 0.7f * (1 - glm::length(glm::vec3(r.shift[i])) / farthest), 0.2f, 1);
             }));
    const double ball = 0.006 * double(glm::length(glm::vec3(extent_of(b.atlas.geometry))));
    Image4 placed = scene.with(nullptr);
    for (const glm::vec4& c : b.placement.candidates) scene.ball(placed, glm::dvec3(c), 0.3 * ball, {0.9f, 0.6f, 0.2f, 1});
    add("candidates", "probes.placement", "all candidates", placed);
    placed = scene.with(nullptr);
    const Buffer<glm::vec4> standing(b.placement.probes.begin(), b.placement.probes.begin() + standing_probes(b.placement.probes));
    for (const glm::vec4& p : standing) scene.ball(placed, glm::dvec3(p), ball, {0.2f, 0.5f, 1, 1});
    const std::size_t shown = std::size_t(scene.in_sight(standing));
    const glm::dvec3 from(standing[shown]);
    scene.outline(placed, from, b.radius.radius_m, {1, 1, 1, 1});
    add("probes", "probes.placement", "probes; the outline is the reach of the one nearest to the middle", placed);
    add_both("supports", "probes.supports", "green: as many probes as there are slots; black: none",
             on_lightmap(r, [&](int i) {
                 const auto first = b.supports.probe.begin() + std::ptrdiff_t(i) * b.supports.overlaps;
                 const auto n = std::count_if(first, first + b.supports.overlaps, [](std::int32_t p) { return p >= 0; });
                 const float share = float(n) / float(b.supports.overlaps);
                 return n == 0 ? glm::vec4(0, 0, 0, 1) : glm::vec4(1 - share, 0.3f + 0.6f * share, 0.2f, 1);
             }));
    Image4 rays = scene.with(nullptr);
    for (int k = 0; k < std::min(64, b.relight.rays); ++k) {
        const std::size_t ray = shown * std::size_t(b.relight.rays) + std::size_t(k);
        const glm::dvec4 to(b.relight.position[ray]);
        const std::int32_t met = b.relight.material[ray];
        const glm::vec4 colour = met == met_nothing ? glm::vec4(0.3f, 0.5f, 1, 1) : met == met_back ? glm::vec4(0.1f, 0.1f, 0.1f, 1)
                                                                                                  : glm::vec4(1, 0.3f, 0.2f, 1);
        scene.line(rays, from, to.w > 0 ? glm::dvec3(to) : from + 100 * ball * glm::dvec3(to), colour);
    }
    if (!b.spatial.empty()) {
        Image4 air = scene.with(nullptr);
        const Receivers& s = b.spatial.receivers;
        for (int i = 0; i < b.spatial.grid.places(); ++i) {
            const glm::dvec3 at(s.position[std::size_t(i)]), was = at - glm::dvec3(s.shift[std::size_t(i)]);
            const bool moved = s.shift[std::size_t(i)].w == 1;
            if (moved) scene.line(air, was, at, {1, 0.3f, 0.2f, 1});
            scene.ball(air, at, 0.6 * ball, moved ? glm::vec4(1, 0.3f, 0.2f, 1) : glm::vec4(0.2f, 0.8f, 0.3f, 1));
        }
        add("spatial", "probes.spatial", "places of spatial receivers; red: moved out of what they lay in, from where the line begins", air);
    }
    add("rays", "probes.relight", "64 rays of the probe nearest to the middle: red to surfaces, blue into the sky, black to backs", rays);
    const int receiver = view.receiver >= 0 && view.receiver < r.count() ? view.receiver : r.count() / 2;
    if (!b.alpha.empty())
        add("alpha", "probes.coefficients", "alpha of a receiver by direction (longitude, latitude), all probes; blue: negative",
            alpha_picture(b, receiver));
    if (!b.alpha.empty())
        add_both("told", "probes.coefficients",
                 "share of what a receiver sees that probes tell it: white all; red none, the receiver stays black",
                 on_lightmap(r, [&](int i) {
                     const float share = told_share(b, i);
                     return share == 0 ? glm::vec4(1, 0, 0, 1) : glm::vec4(glm::vec3(std::clamp(share, 0.0f, 1.0f)), 1);
                 }));
    if (!b.clusters.clusters.empty()) {
        add_both("clusters", "probes.clusters", "a colour each cluster; black: no probe",
                 on_lightmap(r, [&](int i) { return b.clusters.cluster_of[i] < 0 ? glm::vec4(0, 0, 0, 1) : colour_of(b.clusters.cluster_of[i]); }));
        add("singular_values", "probes.clusters", "a curve a cluster: singular value i over the first (si/s1, 1 to 1e-6, logarithmic) by its number i",
            singular_picture(b.clusters));
    }
    return layers;
}

}  // namespace plumb::probes
