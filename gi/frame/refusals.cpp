#include "gi/frame/refusals.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/keys.h"
#include "gi/frame/relief_use.h"
#include "gi/probes/bake.h"
#include "gi/probes/static_scene.h"
#include "gi/reference/triangle_test.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

// What the checks ask of a scene.
struct Asked {
    const Scene& scene;
    const Settings& settings;
    const Geometry& geometry;
    glm::vec3 low{0}, high{0};
    double extent = 0, size = 0;    // m: largest |coordinate|; longest side of the bounds
    std::set<std::int32_t> used{};  // materials

    View camera() const {
        const glm::ivec2 frame = scene.frame_size;
        return make_view(scene.camera, double(frame.x) / frame.y, scene.convention, frame);
    }
    // Rays that start at the G-buffer's points.
    bool points_send_rays() const {
        return settings.truth || (settings.method == Method::rsm && settings.rsm.gather == rsm::Gather::all_rays);
    }
};

std::set<std::int32_t> used_by(const Geometry& geometry) {
    std::set<std::int32_t> used;
    for (std::size_t t = 0; t < geometry.material.size(); ++t)  // neighbours mostly have the same
        if (t == 0 || geometry.material[t] != geometry.material[t - 1]) used.insert(geometry.material[t]);
    return used;
}

Asked ask(const Scene& scene, const Settings& settings, const Geometry& geometry) {
    Asked a{scene, settings, geometry};
    bounds(a.geometry, a.low, a.high);
    for (int c = 0; c < 3; ++c) {
        a.extent = std::max({a.extent, std::abs(double(a.low[c])), std::abs(double(a.high[c]))});
        a.size = std::max(a.size, double(a.high[c]) - a.low[c]);
    }
    a.used = used_by(geometry);
    return a;
}

double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

// ---- Formats
// ---------------------------------------------------------------------------------------------------------

void check_vanishing(const Asked& a, const Light& light, const View& view, const raster::Brightest& brightest) {
    const Format format = a.settings.layout.rsm_flux;
    const double flux = largest(raster::largest_flux(light, view, brightest));
    if (flux > 0 && flux < raster::range_of(format).least)
        throw InputError(
            fmt::format("rsm: light \"{}\": flux of at most {:.4g} W a texel vanishes in {}, which layout \"{}\" stores "
                        "it in: use fp32, fewer texels (rsm_size = {}) or a stronger light",
                        light.name, flux, info(format).name, a.settings.layout.name, light.rsm_size));
}

// Asks what the passes ask, of those that run and of what they draw.
void check_formats(const Asked& a, const Plan& plan) {
    const raster::Layout& layout = a.settings.layout;
    raster::check_view(layout, a.camera());
    const raster::Brightest brightest = raster::brightest_of(a.scene, a.geometry);
    const FrameGraph graph(a.scene, a.settings, a.geometry);
    for (const PlannedStage& stage : plan.stages) {
        const PlannedNode& node = graph.node(stage);
        if (!stage.needed || !node.of_scene) continue;
        if (stage.light < 0) {
            raster::check_gbuffer(layout, a.geometry, brightest, a.camera(), plan.gbuffer.emission, 1);
            continue;
        }
        const PlannedMaps& maps = plan.maps[std::size_t(stage.light)];
        const Light light = shining(a.scene.lights[std::size_t(stage.light)]);
        const std::vector<View> views = raster::light_views(light, a.low, a.high);
        for (std::size_t m = 0; m < views.size(); ++m)
            if (maps.faces >> m & 1)
                raster::check_rsm(layout, light, a.geometry, brightest, views[m], maps.wants.light, 1);
        if (a.settings.method == Method::rsm && maps.wants.light) check_vanishing(a, light, views[0], brightest);
    }
}

// ---- Floats
// ----------------------------------------------------------------------------------------------------------

// 2^60 m and 2^-60 m: squares of distances of a thousandth more or less are still normal floats, and rays farther than
// 1.8e18 m are none.
constexpr double farthest = 0x1p60, smallest = 0x1p-60;
constexpr double spacing = 0x1p-23;          // of floats, relative
constexpr int least_spacings = 8;            // a scene whose sides are no longer is not there any more
constexpr double largest_offset = 1.0 / 64;  // of the scene's size, by which rays may keep off surfaces

// The scene as it is placed: a mesh's own coordinates may be finite, and its transform as well.
void check_vertices(const Scene& scene, const Geometry& geometry) {
    std::size_t first = 0;
    for (const Mesh& mesh : scene.meshes) {
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            const glm::vec3& p = geometry.vertices[first + i].position;
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                throw InputError(fmt::format("{}: mesh \"{}\": vertex {} at ({}, {}, {}) m: expected finite coordinates",
                                             scene.name, mesh.name, i, p.x, p.y, p.z));
        }
        first += mesh.vertices.size();
    }
}

void check_floats(const Asked& a) {
    if (!(a.extent <= farthest))
        throw InputError(
            fmt::format("{}: coordinates up to {:.4g} m: squared distances overflow a float beyond {:.4g} m: "
                        "use a larger unit",
                        a.scene.name, a.extent, farthest));
    if (a.size > 0 && a.size < smallest)
        throw InputError(
            fmt::format("{}: a scene of {:.4g} m: squared distances vanish in a float below {:.4g} m: use a "
                        "smaller unit",
                        a.scene.name, a.size, smallest));
    if (a.size > 0 && a.size <= least_spacings * spacing * a.extent)
        throw InputError(
            fmt::format("{}: a scene of {:.4g} m lies {:.4g} m from the origin, where floats are {:.4g} m "
                        "apart: move it towards the origin",
                        a.scene.name, a.size, a.extent, spacing * a.extent));
    // rsm.all_rays keeps off by 2^-20 of the extent, paths by 2^-19.
    const double offset = a.extent * (a.settings.truth ? 0x1p-19 : 0x1p-20);
    if (a.points_send_rays() && a.size > 0 && offset > largest_offset * a.size)
        throw InputError(
            fmt::format("{}: a scene of {:.4g} m lies {:.4g} m from the origin: rays have to keep {:.4g} m "
                        "off its surfaces, because floats are no finer there: move it towards the origin",
                        a.scene.name, a.size, a.extent, offset));
}

// ---- Paths
// -----------------------------------------------------------------------------------------------------------

// Above it the variance of a path's weight is infinite (gi/reference/path_kernel.h, largest_survival).
constexpr double converges = 1 - 0x1p-21;

bool traces_all_bounces(const Settings& settings) {
    using reference::Mode;
    const bool all = settings.reference.mode == Mode::all || settings.reference.mode == Mode::indirect;
    return (settings.method == Method::reference || settings.truth) && all && settings.reference.max_bounces == 0;
}

// What a surface sends back for certain: a texture may darken the diffuse part, Phong's lobe loses what lies below
// the surface, and microfacets what meets several of them, where that is not counted: but then smooth dielectrics send out
// more, 0.0857 and 0.9565 of their base colour in the mean (gi/reference/README.md, "Errata").
double certain_reflectance(const Material& m, int channel, const Settings& settings) {
    if (m.microfacet && settings.reference.microfacets == reference::Microfacets::single)
        return (1 - double(m.metalness)) * (0.0857 + 0.9565 * double(m.reflectance[channel]));
    return (m.texture < 0 ? double(m.reflectance[channel]) : 0) + m.mirror[channel];
}

// Parts of the geometry that hang together by shared corners, and whether each is closed: every edge belongs to an even
// number of triangles. Corners in the same place are one.
struct Parts {
    std::vector<int> of_triangle;  // the part of each; -1: a triangle without area
    std::vector<bool> closed;
};

struct Welded {
    std::vector<int> corner;  // [vertex]: the first one in its place
    std::vector<int> root;    // [vertex]: union-find

    int find(int v) {
        while (root[std::size_t(v)] != v) v = root[std::size_t(v)] = root[std::size_t(root[std::size_t(v)])];
        return v;
    }
};

Welded weld(const Geometry& g) {
    Welded w;
    std::map<std::array<float, 3>, int> first;
    for (std::size_t i = 0; i < g.vertices.size(); ++i) {
        const glm::vec3 p = g.vertices[i].position + 0.0f;  // -0 and 0 are one place
        w.corner.push_back(first.emplace(std::array{p.x, p.y, p.z}, int(i)).first->second);
    }
    w.root = w.corner;
    return w;
}

Parts parts_of(const Geometry& g) {
    Welded w = weld(g);
    auto corners = [&](const glm::uvec3& t) { return std::array{w.corner[t.x], w.corner[t.y], w.corner[t.z]}; };
    auto flat = [](const std::array<int, 3>& c) { return c[0] == c[1] || c[1] == c[2] || c[2] == c[0]; };
    for (const glm::uvec3& t : g.triangles) {
        const std::array<int, 3> c = corners(t);
        w.root[std::size_t(w.find(c[1]))] = w.find(c[0]);
        w.root[std::size_t(w.find(c[2]))] = w.find(c[0]);
    }
    Parts parts;
    std::map<int, int> number;
    std::map<std::array<int, 2>, int> edges;
    for (const glm::uvec3& t : g.triangles) {
        const std::array<int, 3> c = corners(t);
        parts.of_triangle.push_back(flat(c) ? -1 : number.emplace(w.find(c[0]), int(number.size())).first->second);
        for (int i = 0; !flat(c) && i < 3; ++i) {
            const int a = c[std::size_t(i)], b = c[std::size_t((i + 1) % 3)];
            ++edges[{std::min(a, b), std::max(a, b)}];
        }
    }
    parts.closed.assign(number.size(), true);
    for (const auto& [edge, count] : edges)
        if (count % 2 != 0) parts.closed[std::size_t(number.at(w.find(edge[0])))] = false;
    return parts;
}

// Whether the eye lies in a closed part: a ray leaves it through an odd number of its triangles.
bool enclosed(const Geometry& g, const glm::dvec3& eye) {
    const Parts parts = parts_of(g);
    std::vector<int> crossings(parts.closed.size(), 0);
    // A direction along which no scene is built.
    const reference::ShearedRay ray =
        reference::shear(float(eye.x), float(eye.y), float(eye.z), 0.5377f, 0.6731f, -0.3119f);
    for (std::size_t i = 0; i < g.triangles.size(); ++i) {
        if (parts.of_triangle[i] < 0) continue;
        reference::Corners c{};
        float* const to[] = {c.a, c.b, c.c};
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis) to[k][axis] = g.vertices[g.triangles[i][k]].position[axis];
        reference::TriangleHit hit;
        crossings[std::size_t(parts.of_triangle[i])] += reference::meets(ray, c, hit) && hit.t > 0;
    }
    for (std::size_t p = 0; p < parts.closed.size(); ++p)
        if (parts.closed[p] && crossings[p] % 2 != 0) return true;
    return false;
}

void check_paths(const Asked& a) {
    if (!traces_all_bounces(a.settings) || a.used.empty()) return;
    for (int c = 0; c < 3; ++c) {
        double least = std::numeric_limits<double>::infinity();
        const Material* darkest = nullptr;
        for (const std::int32_t m : a.used) {
            const Material& material = a.scene.materials[std::size_t(m)];
            const double rho = material.alpha_cutoff > 0 ? 0 : certain_reflectance(material, c, a.settings);
            if (rho < least) least = rho, darkest = &material;
        }
        if (!(least > converges) || !enclosed(a.geometry, a.scene.camera.position)) continue;
        throw InputError(
            fmt::format("{}: the camera is in a closed room whose darkest material, \"{}\", reflects {:.9g} "
                        "in channel {}: the sum of all reflections does not converge: set [reference] "
                        "max_bounces, or a reflectance of at most {:.7f}",
                        a.scene.name, darkest->name, least, "RGB"[c], std::floor(converges * 1e7) / 1e7));
    }
}

// ---- Filters
// ---------------------------------------------------------------------------------------------------------

void check_filters(const Scene& scene, const Settings& settings) {
    if (settings.indirect.kernel % 2 == 0)
        throw InputError(fmt::format("{}: [indirect] kernel = {}: expected an odd number", scene.name, settings.indirect.kernel));
    if (settings.rsm.gather != rsm::Gather::all_rays || !filters_indirect(settings)) return;
    throw InputError(fmt::format("{}: [indirect] {}: rsm.all_rays is a truth with a standard error of its own, which no "
                                 "filter keeps: expected resolution = full and blur = none",
                                 scene.name, halves_indirect(settings) ? "resolution = half" : "blur"));
}

// What no range of one parameter says.
void check_gather(const Scene& scene, const Settings& settings) {
    if (settings.method != Method::rsm) return;
    try {
        rsm::validate(settings.rsm);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", scene.name, error.what()));
    }
}

}  // namespace

double spectral_radius_bound(const Scene& scene, const Geometry& geometry) {
    double radius = 0;
    for (const std::int32_t i : used_by(geometry)) {
        const Material& m = scene.materials[std::size_t(i)];
        for (int c = 0; c < 3; ++c) radius = std::max(radius, double(m.reflectance[c]) + m.specular[c] + m.mirror[c]);
    }
    return radius;
}

double passes_needed(double rho, double error) { return std::ceil(host::log(error) / host::log(rho)); }

namespace {

// A fit counts on what stands for directions that nobody asks (gi/probes/fit.h).
void check_unasked(const Scene& scene, const Settings& settings) {
    if (settings.probe_run.unasked != probes::Unasked::black) return;
    if (!settings.bake && !settings.probe_run.file.empty()) return;
    const bool fitted = settings.bake ? settings.bake->transport.fitted : probes::transport_params(settings.probes, probes::sends_light(scene.environment)).fitted;
    if (fitted)
        throw InputError("[probes] unasked = black: the bake's gather = fitted takes from probes what stands for directions that nobody asks: "
                         "expected unasked = nearest, or gather = interpolated");
}

// What is asked before a stage runs that no image or map tells.
void check_parameters(const Scene& scene, const Settings& settings) {
    try {
        compose::validate(settings.tonemap);
        if (settings.method == Method::zbuffer) zbuffer::validate(settings.zbuffer);
        if (!lights_probes(settings)) return;
        probes::validate(settings.lod);
        check_static_lamps(scene, settings);
        check_unasked(scene, settings);
        // Of what is known now: where a bake is made its parameters are, the scene's diagonal is not asked for.
        const probes::BakeParams& baked = settings.bake ? settings.bake->params : settings.probes;
        constexpr double no_diagonal = 1e-6;
        if (settings.bake || settings.probe_run.file.empty())
            probes::lod_of(settings.lod, no_diagonal, baked.degree, baked.relight_rays, baked.gap);
        if (settings.bake && settings.bake->scene_hash != probes::scene_hash(scene))
            throw InputError("the bake is of another scene: its static meshes, or what they are made of, were others; what moves has to be dynamic");
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", scene.name, error.what()));
    }
}

}  // namespace

void refuse_scene(const Scene& scene, const Settings& settings, const Geometry& geometry) {
    check_filters(scene, settings);
    check_gather(scene, settings);
    check_isr(scene, settings);
    check_parameters(scene, settings);
    if (geometry.triangles.empty()) return;
    check_vertices(scene, geometry);
    const Asked a = ask(scene, settings, geometry);
    check_floats(a);
    check_paths(a);
}

void refuse_plan(const Scene& scene, const Settings& settings, const Geometry& geometry, const Plan& plan) {
    try {
        check_formats(ask(scene, settings, geometry), plan);
    } catch (const InputError& error) {
        throw InputError(scene.name + ": " + error.what());  // passes know no scene
    }
}

std::vector<std::string> warnings(const Scene& scene, const Settings& settings) {
    const Geometry geometry = flatten(scene);
    const Asked a = ask(scene, settings, geometry);
    std::vector<std::string> out;
    if (a.size > 0 && spacing * a.extent > a.size / scene.frame_size.y)
        out.push_back(
            fmt::format("floats are {:.4g} m apart where the scene lies, which is more than a pixel of a frame "
                        "that shows all of its {:.4g} m: neighbouring pixels may see the same point",
                        spacing * a.extent, a.size));
    const double radius = spectral_radius_bound(scene, a.geometry);
    if (traces_all_bounces(settings) && radius >= 0.999) {
        const std::string passes =
            radius < 1 ? fmt::format("{:.0f} reflections leave a thousandth of it", passes_needed(radius, 1e-3))
                       : "no number of reflections takes any of it away";
        out.push_back(
            fmt::format("a material reflects {:.9g} of the light: where nothing darker is near, {}; [reference] "
                        "max_bounces sets a limit",
                        radius, passes));
    }
    return out;
}

}  // namespace plumb::frame
