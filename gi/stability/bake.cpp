#include "gi/stability/bake.h"

#include <algorithm>

#include "core/error.h"
#include "gi/ddgi/volume.h"
#include "gi/lend.h"
#include "gi/methods.h"
#include "gi/probes/bake.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/level.h"
#include "gi/probes/relief.h"
#include "gi/probes/share.h"
#include "gi/stability/lookup.h"
#include "gi/stability/radiosity.h"
#include "gi/stability/relight.h"
#include "gi/probes/volume.h"

namespace plumb::stability {

namespace {

probes::BakeParams small_bake() {
    probes::BakeParams p;
    p.placement.overlaps = 10, p.placement.least = 8, p.receiver_rays = 512;
    p.lightmap_size = 48, p.receiver_rays = 32, p.test_rays = 16;
    p.placement.count = 6, p.placement.overlaps = 4;
    p.escapes = probes::Escapes::all_probes;  // so that directions of rays that meet nothing count, too
    return p;
}

template <class Kernel>
StageData owned_by(const StageData& data, const std::string& form = "") {
    StageData own = owned(stage<Kernel>(), data);
    own.label = data.stage + form;
    return own;
}

// Levels of the probes, and of boxes around receivers, seen by a viewer at the first receiver who looks at the last.
StageData level_data(const probes::Bake& bake) {
    Buffer<glm::vec4> low = bake.placement.probes, high = low;
    const float radius = float(bake.radius.radius_m);
    for (glm::vec4& p : low) p.w = radius;
    const Buffer<glm::vec4>& all = bake.receivers.position;
    for (std::size_t i = 0; i < all.size(); i += 64) {
        glm::vec4 a = all[i], b = a;
        for (std::size_t k = i; k < std::min(i + 64, all.size()); ++k) a = glm::min(a, all[k]), b = glm::max(b, all[k]);
        low.push_back(a), high.push_back(b);
    }
    probes::LevelRule rule;
    const glm::vec3 view = glm::vec3(all.back()) - glm::vec3(all.front());
    const float length = std::sqrt(glm::dot(view, view));
    rule.levels = 4, rule.eye = all.front(), rule.forward = glm::vec4(view / std::max(length, 1e-30f), 0);
    rule.zones = {0.5f, 0.8660254f, -0.5f, 0.8660254f}, rule.scales = {1, 2, 4, 0};
    rule.distances = {0.1f * length, 0.3f * length, 0.6f * length, 0}, rule.margins = {1, 2, 4, 0};
    return owned_by<probes::LevelKernel>(probes::data_of(probes::LevelInputs{&low, &high, rule}));
}

// Spheres about as large as the scene's parts: in the air, cut by surfaces, around their corners; every third of no radius.
void add_shadows(const Image4& position, const Image4& normal, const glm::vec3& low, const glm::vec3& high, std::vector<StageData>& all) {
    const int n = position.width;
    const Image4 lit(n, 1, glm::vec4(2, 1, 3, 1));
    const Image<glm::ivec2> id(n, 1, glm::ivec2(0));
    const glm::vec3 size = high - low;
    const float unit = std::max({size.x, size.y, size.z});
    probes::ShadowSpheres spheres;
    for (int i = 0; i < 9; ++i) {
        const glm::vec3 at = i % 2 == 0 ? low + size * glm::vec3(0.1f * float(i + 1), 0.5f, 0.9f - 0.1f * float(i)) : glm::vec3(position((7 * i) % n, 0));
        spheres.rows.push_back(glm::vec4(at, i % 3 == 2 ? 0 : 0.05f * float(i + 1) * unit));
        for (int c = 0; c < 3; ++c) spheres.rows.push_back({0.1f, 0.05f * float(c), -0.1f, 0.25f});
        for (int c = 0; c < 3; ++c) spheres.rows.push_back({-0.01f, 0, 0.01f, 0.03f});
        spheres.owner.push_back({1, 1});
    }
    probes::IndirectShadowInputs in;
    in.position = &position, in.normal = &normal, in.irradiance = &lit, in.id = &id, in.spheres = &spheres;
    all.push_back(owned_by<probes::IndirectShadowKernel>(probes::data_of(in)));
    in.directional = false;
    all.push_back(owned_by<probes::IndirectShadowKernel>(probes::data_of(in), " (uniform)"));
}

// Points of a scene's surfaces in a grid of spatial receivers over it, lit by what varies from place to place and side to side.
void add_volumes(const Scene& scene, std::vector<StageData>& all) {
    const Geometry geometry = flatten(scene);
    glm::vec3 low, high;
    if (!bounds(geometry, low, high)) return;
    probes::VolumeInputs in;
    try {
        in.grid = probes::spatial_grid(low, high, 30);
    } catch (const InputError&) {
        return;  // no extent: no grid
    }
    Buffer<glm::vec4> irradiance;
    for (int i = 0; i < in.grid.places() * probes::spatial_directions; ++i)
        irradiance.push_back({1 + float(i % 7), 0.25f * float(i % 5), i % 3 == 0 ? 0.0f : 2.0f, 0});
    const int n = std::min(96, int(geometry.triangles.size()));
    Image4 position(n, 1), normal(n, 1), uv(n, 1, glm::vec4(-1));
    for (int i = 0; i < n; ++i) {
        const Vertex& v = geometry.vertices[geometry.triangles[std::size_t(i) * geometry.triangles.size() / std::size_t(n)].x];
        const float length = glm::length(v.normal);
        position(i, 0) = glm::vec4(v.position, 1);
        normal(i, 0) = length > 0 ? glm::vec4(v.normal / length, 1) : glm::vec4(0);
    }
    in.irradiance = &irradiance, in.position = &position, in.normal = &normal, in.lightmap_uv = &uv;
    for (const auto& [form, name] : {std::pair(probes::VolumeForm::linear, ""), std::pair(probes::VolumeForm::cube, " (cube)"),
                                     std::pair(probes::VolumeForm::angles, " (angles)")}) {
        in.form = form;
        all.push_back(owned_by<probes::VolumeKernel>(probes::data_of(in), name));
    }
    add_shadows(position, normal, low, high, all);
    // Lit along the normal, seen from the corner of the scene, with a lobe of 20.
    const Image4 lit(n, 1, glm::vec4(2, 1, 3, 1)), less(n, 1, glm::vec4(1, 1, 2, 1)), lobe(n, 1, glm::vec4(0.25f, 0.5f, 0.125f, 20));
    probes::ReliefInputs relief;
    relief.eye = low, relief.position = &position, relief.normal = &normal, relief.irradiance = &lit, relief.mapped = &lit;
    relief.plain = &less, relief.light = &normal, relief.from_light = &lit, relief.specular = &lobe;
    all.push_back(owned_by<probes::ReliefKernel>(probes::data_of(relief)));
    // A lamp at the opposite corner, as bright as what arrives along the light vector.
    std::vector<Light> lamps(1);
    const glm::vec3 size = high - low;
    lamps[0].type = LightType::point, lamps[0].position = high, lamps[0].intensity = glm::vec3(size.x * size.x + size.y * size.y + size.z * size.z);
    const Buffer<float> seen(std::size_t(n), 1.0f);
    relief.lights = &lamps, relief.visibility = &seen;
    all.push_back(owned_by<probes::ReliefKernel>(probes::data_of(relief), " (lamp)"));
}

}  // namespace

bool is_of_bake(const std::string& stage) {
    return std::any_of(stages().begin(), stages().end(),
                       [&](const ListedStage& s) { return s.binding && s.info.name == stage; }) &&
           (stage.starts_with("probes.") || stage.starts_with("ddgi.") || stage.starts_with("radiosity."));
}

bool is_baked(const Case& c) {
    static const std::vector<std::string> groups = {"room", "scale", "offset", "triangles", "normals"};
    return !c.edit && std::find(groups.begin(), groups.end(), c.group) != groups.end();
}

std::vector<StageData> bake_data(const Scene& scene, const RunOptions& options) {
    // Rays of receivers are traced here, so that what follows the supports is not wanted.
    probes::BakeGraph graph(scene, small_bake());
    const std::vector<const graph::Node*> steps = graph.nodes_before_rays();
    graph::RunWith with;
    with.options = options;
    graph::run(steps, with);
    const probes::Bake& bake = graph.bake();

    std::vector<StageData> all;
    const auto radius = float(bake.placement.kernel_radius_m);
    all.push_back(owned_by<probes::DensityKernel>(probes::data_of(probes::DensityInputs{&bake.placement.candidates, radius})));
    for (const StageData& data : steps.back()->dispatches())
        all.push_back(owned_by<probes::SupportsKernel>(data));

    all.push_back(level_data(bake));

    const probes::TracedBlock block = graph.traced(0, options);
    const Buffer<float> factors = probes::ray_factors(
        probes::receiver_directions(block.rays, bake.transport.distribution), bake.transport.distribution);
    probes::ShareInputs share{block.count, block.rays, block.slots, false, block.supporting.data(), factors.data(),
                              block.visible.data(), block.lengths.data()};
    all.push_back(owned_by<probes::ShareKernel>(probes::data_of(share)));
    share.published = true;
    all.push_back(owned_by<probes::ShareKernel>(probes::data_of(share), " (published)"));
    const std::vector<std::int32_t> rows = probes::coefficient_rows(block.slots, bake.params.degree);
    const probes::CoefficientsInputs coefficients{block.count, block.rays, block.slots, bake.params.degree, rows.data(),
                                                  block.supporting.data(), block.seen.data(), block.visible.data(),
                                                  block.shares.data()};
    all.push_back(owned_by<probes::CoefficientsKernel>(probes::data_of(coefficients)));
    for (StageData& data : relight_data(scene, graph, options)) all.push_back(std::move(data));
    for (StageData& data : update_data(bake, block, options)) all.push_back(std::move(data));
    add_volumes(scene, all);
    for (StageData& data : lookup_data(bake)) all.push_back(std::move(data));
    return all;
}

std::vector<Cell> bake_cells(const std::vector<StageData>& data, const std::string& stage, const Effort& effort) {
    std::vector<Cell> cells;
    for (const StageData& d : data) {
        if (!stage.empty() && stage != d.stage) continue;
        for (const ListedStage& s : stages())
            if (s.info.name == d.stage) cells.push_back(evaluate(*s.binding, d, effort));
    }
    return cells;
}

std::vector<StageData> volume_data(const Scene& scene, const RunOptions& options) {
    const auto lit = probes::lit_scene(scene, Rays::exact);
    glm::vec3 low, high;
    bounds(lit->geometry, low, high);
    ddgi::VolumeParams params;
    params.rays = 32, params.rounds = 3, params.hysteresis = 0.3f;
    ddgi::Volume volume(*lit, ddgi::grid_over(low, high, {2, 2, 2}), params);
    volume.converge(options);
    return volume.dispatches();
}

namespace {

// The cells of data of a scene; where `part` refuses it, each stage of that prefix is refused.
template <class Data>
void add_cells(const Data& data, const std::string& part, const std::string& prefix, const std::string& stage, const Effort& effort,
               std::vector<Cell>& cells) {
    if (!stage.empty() && !stage.starts_with(prefix)) return;
    try {
        for (Cell& cell : bake_cells(data(), stage, effort)) cells.push_back(std::move(cell));
    } catch (const InputError& e) {
        if (!std::string(e.what()).starts_with(part)) throw;
        for (const ListedStage& s : stages()) {
            if (!is_of_bake(s.info.name) || !s.info.name.starts_with(prefix) || (!stage.empty() && stage != s.info.name)) continue;
            Cell& cell = cells.emplace_back();
            cell.stage = s.info.name, cell.refused = cell.ok = true, cell.reason = e.what();
        }
    }
}

}  // namespace

std::vector<Cell> bake_cells(const Scene& scene, const std::string& stage, const Effort& effort) {
    std::vector<Cell> cells;
    add_cells([&] { return bake_data(scene, effort.run); }, "atlas:", "probes.", stage, effort, cells);
    add_cells([&] { return volume_data(scene, effort.run); }, "ddgi:", "ddgi.", stage, effort, cells);
    add_cells([&] { return radiosity_data(scene, effort.run); }, "radiosity:", "radiosity.", stage, effort, cells);
    return cells;
}

}  // namespace plumb::stability
