#include "gi/stability/unbound.h"

#include <algorithm>
#include <cmath>

#include "gi/reference/ray_query.h"
#include "gi/rsm/all_rays.h"
#include "gi/stability/unbound_stages.h"
#include "raster/bindings.h"
#include "raster/gbuffer.h"
#include "raster/light_view.h"
#include "raster/texture_space.h"
#include "raster/hemicube.h"

namespace plumb::stability {

namespace {

// A scene's cells are many: what is drawn and traced for them is small.
constexpr int map_side = 16, looked_at_lights = 3, lightmap_side = 64, hemicube_side = 16, hemicubes = 2;
constexpr int longest_path = 6;  // reflections: what rounds on a path rounds on each of its surfaces
constexpr int pixels_share = 4;  // of Effort::pixels

struct Drawn {
    const Scene& scene;
    const frame::Settings& settings;
    Effort effort;
    Drawable drawable;
    glm::vec3 low{0}, high{0};
    View view{};
    raster::GBuffer gbuffer{};

    std::vector<const Light*> lights() const {
        std::vector<const Light*> some;
        for (const Light& l : scene.lights)
            if (l.on && int(some.size()) < looked_at_lights) some.push_back(&l);
        return some;
    }
    std::vector<View> views(const Light& light) const {
        std::vector<View> seen = raster::light_views(light, low, high);
        std::erase_if(seen, [&](const View& v) { return seen.size() > 1 && !raster::may_see(v, low, high); });
        return seen;
    }
    void draw_gbuffer() {
        raster::draw_gbuffer(drawable.geometry, drawable.surfaces, view, scene.frame_size, settings.layout, effort.run,
                             gbuffer);
    }
};

Cell look_at_visibility(const Drawn& d) {
    Cell cell = visibility_cell(d.drawable, d.view, d.scene.frame_size, d.effort);
    for (const Light* light : d.lights())
        for (const View& view : d.views(*light))
            merge(cell, visibility_cell(d.drawable, view, glm::ivec2(std::min(light->rsm_size, map_side)), d.effort));
    return cell;
}

// The share of the largest coordinate by which rays keep off surfaces is how near a hemicube may see.
Cell look_at_hemicubes(const Drawn& d) {
    const double extent =
        std::max({1e-30, std::abs(double(d.low.x)), std::abs(double(d.low.y)), std::abs(double(d.low.z)),
                  std::abs(double(d.high.x)), std::abs(double(d.high.y)), std::abs(double(d.high.z))});
    Cell cell;
    int done = 0;
    for (const std::size_t i : picked(d.gbuffer.position.size(), d.effort.pixels)) {
        const glm::dvec3 x(d.gbuffer.position.texels[i]), n(d.gbuffer.normal.texels[i]);
        if (n == glm::dvec3(0)) continue;
        merge(cell, hemicube_cell(d.drawable, x, n, extent * 0x1p-19, hemicube_side, d.effort));
        if (++done == hemicubes) break;
    }
    return cell;
}

Cell look_at_texture_space(const Drawn& d) {
    return texture_space_cell(d.drawable, raster::texture_coordinates(d.drawable.geometry), lightmap_side, d.effort);
}

Cell look_at_all_rays(const Drawn& d) {
    const auto rays = reference::build_ray_query(d.drawable.geometry, d.drawable.surfaces, Rays::exact);
    Cell cell;
    cell.stage = rsm::stage_name(rsm::Gather::all_rays);
    for (const Light* light : d.lights()) {
        Light small = *light;
        small.rsm_size = std::min(light->rsm_size, map_side);
        std::vector<raster::Rsm> maps;
        for (const View& view : d.views(small))
            raster::draw_rsm(d.drawable.geometry, d.drawable.surfaces, small, view, d.settings.layout, d.effort.run,
                             maps.emplace_back());
        rsm::GatherInputs in{&d.gbuffer.position, &d.gbuffer.normal};
        in.rays = rays.get();
        in.offsets = rsm::ray_offsets(d.settings.layout, d.low, d.high, d.view, d.scene.frame_size);
        merge(cell, all_rays_cell(in, maps, d.effort));
    }
    return cell;
}

Cell look_at_paths(const Drawn& d) {
    const std::unique_ptr<reference::PathScene> scene = reference::prepare(d.scene, Rays::exact);
    reference::PathParams params = d.settings.reference;
    params.mode = reference::Mode::all;
    params.max_bounces = params.max_bounces > 0 ? std::min(params.max_bounces, longest_path) : longest_path;
    Cell cell = paths_cell(*scene, params, d.scene.camera, d.scene.frame_size, d.effort);
    if (d.gbuffer.position.empty()) return cell;
    params.mode = reference::Mode::indirect;
    merge(cell, points_cell(*scene, params, d.gbuffer.position, d.gbuffer.normal, d.effort));
    return cell;
}

}  // namespace

std::vector<Cell> unbound_cells(const std::string& case_name, const Scene& scene, const frame::Settings& settings,
                                const Effort& effort) {
    std::vector<Cell> cells;
    auto add = [&](const std::string& stage, const std::function<Cell()>& body) {
        Cell cell = or_refused(stage, body);
        // A stage that has nothing to do in a case has no cell there.
        if (cell.stage.empty() || (cell.pixels == 0 && !cell.refused)) return;
        cell.case_name = case_name;
        cells.push_back(std::move(cell));
    };
    Drawn d{scene, settings, effort, drawable(scene)};
    d.effort.pixels = std::max(effort.pixels / pixels_share, 1);
    d.effort.run.progress = nullptr;
    const bool any = bounds(d.drawable.geometry, d.low, d.high);
    const glm::ivec2 size = scene.frame_size;
    d.view = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);

    add("visibility", [&] { return look_at_visibility(d); });
    if (any) add(raster::info_texture_space().name, [&] { return look_at_texture_space(d); });
    // What reads the G-buffer is refused with it.
    const Cell refused = or_refused(raster::gbuffer_binding().info.name, [&] { return d.draw_gbuffer(), Cell(); });
    if (any && !refused.refused) {
        add(raster::info_hemicube().name, [&] { return look_at_hemicubes(d); });
        add(rsm::stage_name(rsm::Gather::all_rays), [&] { return look_at_all_rays(d); });
    }
    add("reference", [&] { return look_at_paths(d); });
    return cells;
}

}  // namespace plumb::stability
