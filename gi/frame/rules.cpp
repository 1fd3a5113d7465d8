#include "gi/frame/rules.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "gi/frame/mirrors.h"
#include "gi/frame/relief_use.h"
#include "gi/probes/bake.h"
#include "gi/rsm/all_rays.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

const Light& light_of(const PlanFacts& known, const Work& work) {
    return known.scene.lights[std::size_t(work.light)];
}

bool any_lit(const PlanFacts& known, const Light& light, const std::vector<Box>& boxes) {
    return std::any_of(boxes.begin(), boxes.end(),
                       [&](const Box& box) { return may_light(light, grown(box, known.slack)); });
}

// ---- what the plan knows ----------------------------------------------------------------------------------------------

bool scene_empty(const PlanFacts& known, const Work&) { return known.empty; }

bool light_off(const PlanFacts& known, const Work& work) { return known.tame && !light_of(known, work).on; }

bool light_black(const PlanFacts& known, const Work& work) {
    return known.tame && light_of(known, work).intensity == glm::vec3(0);
}

// As it is printed ambient occlusion weighs a map that sees nothing, too.
bool weighs_all_maps(const Settings& s) {
    return occludes(s) && s.ao.views == screen::AoViews::lights && s.ao.variant == screen::AoVariant::published;
}

// Outside of a map the shadow test as it is printed finds no point lit, which a shadow density shows.
bool light_misses(const PlanFacts& known, const Work& work) {
    const Settings& s = known.settings;
    if (weighs_all_maps(s) && work.stage != "gather") return false;
    if (reads_density(s) && s.shadow.variant == direct::ShadowVariant::published && work.stage != "gather") return false;
    return known.tame && !any_lit(known, light_of(known, work), known.drawn);
}

// The density of a scene that its lights miss is 1; without a light that shines it is 0.
bool no_light(const PlanFacts& known, const Work& work) {
    const bool density = (work.stage == "direct" || work.stage == "reflect direct") && reads_density(known.settings);
    for (int l = 0; l < int(known.shines.size()); ++l) {
        const Work of{work.stage, work.part, l};
        if (known.shines[std::size_t(l)] || (density && !light_off(known, of) && !light_black(known, of))) return false;
    }
    return known.tame;
}

// The path tracer reads the scene itself.
bool paths_instead(const PlanFacts& known, const Work&) { return known.settings.method == Method::reference; }

// A pipeline goes on where nobody looks: what it leaves out now is missing in later frames.
bool in_a_pipeline(const PlanFacts& known) { return known.settings.method == Method::probes && known.settings.probe_run.loop == probes::Loop::pipelined; }

bool camera_blind(const PlanFacts& known, const Work& work) {
    const bool of_frame = work.stage == "camera" || work.stage.starts_with("truth");
    return known.tame && (of_frame || !in_a_pipeline(known)) && std::none_of(known.drawn.begin(), known.drawn.end(),
                                      [&](const Box& box) { return may_see(known.scene, box); });
}

bool nothing_reflects(const PlanFacts& known, const Work&) { return known.tame && known.reflecting.empty(); }

bool reflectors_missed(const PlanFacts& known, const Work& work) {
    return known.tame && !any_lit(known, light_of(known, work), known.reflecting);
}

bool no_albedo(const PlanFacts& known, const Work&) { return known.reflecting.empty(); }

bool no_emission(const PlanFacts& known, const Work&) { return !known.emits; }

bool no_mirror(const PlanFacts& known, const Work&) {
    return !any_mirror(known.scene) && (known.settings.reflect.lobe == screen::Lobe::off || !any_lobe(known.scene));
}

// What sends indirect light in image space: emitters, and what a light shines on. As printed, unlit colours.
bool no_radiosity(const PlanFacts& known, const Work& work) {
    return known.settings.isr.variant == isr::Variant::corrected && !known.emits && no_light(known, work);
}

bool isr_unseen(const PlanFacts& known, const Work&) { return known.settings.isr.k_isr == 0; }

// Without occlusion of direct light, and without light from everywhere, nobody asks how open a point is.
bool access_unread(const PlanFacts& known, const Work&) {
    const isr::IsrParams& p = known.settings.isr;
    const bool sky = p.variant == isr::Variant::corrected && p.ambient == isr::Ambient::environment &&
                     known.scene.environment.radiance != glm::vec3(0);
    return p.k_ssao == 0 && !sky;
}

bool isr_unread(const PlanFacts& known, const Work&) {
    return left_out_by(rules(), known, {"isr", ""}) && left_out_by(rules(), known, {"isr access", ""});
}

// Nothing to filter: every light's gather is left out.
bool no_gather(const PlanFacts& known, const Work&) {
    for (int l = 0; l < int(known.scene.lights.size()); ++l)
        if (!left_out_by(rules(), known, {"gather", "", l})) return false;
    return true;
}


// Neither lamps nor emitters nor the sky: the lightmap is black, and so is what radiosity solves.
bool no_radiance(const PlanFacts& known, const Work& work) {
    return !in_a_pipeline(known) && !known.emits && !probes::sends_light(known.scene.environment) && no_light(known, work);
}

// Without spheres and meshes nothing is hidden: indirect light stays as it is.
bool nothing_moves(const PlanFacts& known, const Work&) {
    return std::none_of(known.scene.meshes.begin(), known.scene.meshes.end(), [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); });
}

// Nothing but its own pixels reads the air about what moves: indirect shadows do, and static surfaces that ask where light comes from.
bool mesh_unseen(const PlanFacts& known, const Work& work) {
    const probes::Box box = probes::box_of(known.scene.meshes[std::size_t(work.index)]);
    return known.tame && known.settings.probe_run.indirect_shadow == probes::IndirectShadow::off &&
           !may_see(known.scene, grown({glm::dvec3(box.low), glm::dvec3(box.high)}, known.slack)) && !relief_use(known.scene, known.settings).fixed;
}

bool relief_off(const PlanFacts& known, const Work&) { return known.settings.probe_run.relief == probes::ReliefOf::off; }

// What moves has its normal maps in the G-buffer, and its light from the grid along them.
bool no_relief(const PlanFacts& known, const Work&) {
    const ReliefUse use = relief_use(known.scene, known.settings);
    return !use.any() && !use.maps;
}

bool relief_unknown(const PlanFacts& known, const Work&) { return !relief_use(known.scene, known.settings).any(); }

// plan() asks it of the maps that no gather of its own reads.
bool light_unread(const PlanFacts& known, const Work& work) {
    return known.settings.method != Method::rsm || nothing_reflects(known, work) || reflectors_missed(known, work);
}

// Where nothing is drawn the corrected shadow test finds every point lit, as it does without the face. The test as it is
// printed does not.
bool face_blind(const PlanFacts& known, const Work& work) {
    const Light& light = light_of(known, work);
    if (light.type != LightType::point || known.settings.shadow.variant == direct::ShadowVariant::published) return false;
    if (weighs_all_maps(known.settings)) return false;
    const View face = raster::light_views(light, known.low, known.high)[std::size_t(work.index)];
    return known.tame && std::none_of(known.drawn.begin(), known.drawn.end(), [&](const Box& box) {
        return raster::may_see(face, glm::vec3(box.low), glm::vec3(box.high));
    });
}

// ---- what only the run sees -------------------------------------------------------------------------------------------

bool nothing_covered(const RunFacts& seen, const Work&) {
    const Buffer<std::uint8_t>& any = seen.gbuffer.covered.any;
    return !any.empty() && std::find(any.begin(), any.end(), 1) == any.end();
}

bool map_dark(const RunFacts& seen, const Work&) {
    return std::all_of(seen.maps.begin(), seen.maps.end(),
                       [](const raster::Rsm& map) { return map.size == 0 || map.largest_flux == 0; });
}

// Without a normal no cosine is above 0; but nothing times an infinite flux is not 0.
bool tile_empty(const RunFacts& seen, const Work& work) {
    const bool finite = work.stage != "gather" || std::all_of(seen.maps.begin(), seen.maps.end(), [](const raster::Rsm& map) {
        return map.size == 0 || map.largest_flux <= std::numeric_limits<float>::max();
    });
    return finite && seen.covered.any[std::size_t(work.index)] == 0;
}

bool fits(float coordinate) { return std::abs(coordinate) <= 1e15f; }
bool fits(const glm::vec3& v) { return fits(v.x) && fits(v.y) && fits(v.z); }

// The bounds of each mesh's triangles of each material.
std::map<std::pair<std::int32_t, std::int32_t>, Box> boxes_of(const Geometry& geometry) {
    std::map<std::pair<std::int32_t, std::int32_t>, Box> boxes;
    const std::size_t count = geometry.triangles.size();
    for (std::size_t first = 0, end = 0; first < count; first = end) {
        // Neighbours mostly have the same.
        const std::pair key(geometry.object[first], geometry.material[first]);
        glm::vec3 low = geometry.vertices[geometry.triangles[first].x].position, high = low;
        for (end = first; end < count && std::pair(geometry.object[end], geometry.material[end]) == key; ++end)
            for (int k = 0; k < 3; ++k) {
                const glm::vec3& p = geometry.vertices[geometry.triangles[end][k]].position;
                for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
            }
        const auto [at, is_new] = boxes.try_emplace(key, Box{glm::dvec3(low), glm::dvec3(high)});
        if (is_new) continue;
        Box& box = at->second;
        box.low = glm::min(box.low, glm::dvec3(low)), box.high = glm::max(box.high, glm::dvec3(high));
    }
    return boxes;
}

const Material& material_of(const Scene& scene, std::int32_t index) {
    static const Material unknown;  // prepare() of raster/surfaces.h will say so
    return index >= 0 && index < int(scene.materials.size()) ? scene.materials[std::size_t(index)] : unknown;
}

}  // namespace

bool Rule::speaks_of(const Work& work) const {
    return part == work.part && std::find(stages.begin(), stages.end(), work.stage) != stages.end();
}

const std::vector<Rule>& rules() {
    static const std::vector<std::string> of_light = {"rsm", "shadow", "gather", "reflect shadow"};
    static const std::vector<std::string> of_view = {"camera",      "rsm",            "shadow", "gather",  "direct",
                                                     "truth.direct", "truth.indirect", "isr",    "isr access", "probes",
                                                     "relief",       "probes shadow", "radiosity", "zbuffer", "ao",  "ao light",
                                                     "truth.ao", "truth.reflection", "reflect", "reflect light", "reflect shadow", "reflect direct"};
    static const std::vector<std::string> of_screen = {"rsm",    "shadow", "gather",   "filter",
                                                       "direct", "isr",    "isr access", "isr lit", "zbuffer", "ao", "ao light",
                                                       "reflect", "reflect light", "reflect shadow", "reflect direct"};
    static const std::vector<Rule> all = {
        {"scene-empty", of_view, "", "the scene is empty", scene_empty},
        {"light-off", of_light, "", "the light is off", light_off},
        {"light-black", of_light, "", "the light is black", light_black},
        {"light-misses", {"rsm", "shadow", "gather", "ao light", "reflect light", "reflect shadow"}, "", "the light misses everything that is drawn", light_misses},
        {"paths-instead", {"rsm", "shadow", "direct", "compose"}, "", "paths are traced instead", paths_instead},
        {"camera-blind", of_view, "", "the camera sees nothing of the scene", camera_blind},
        {"no-radiance", {"probes", "probes shadow", "radiosity"}, "", "nothing sends light", no_radiance},
        {"nothing-moves", {"probes shadow"}, "", "no mesh is dynamic", nothing_moves},
        {"relief-off", {"relief"}, "", "probes.relief is off", relief_off},
        {"no-relief", {"relief"}, "", "nothing has a highlight, and nothing static a normal map", no_relief},
        {"relief-unknown", {"relief"}, "", "static normal maps ask spatial receivers, of which there are none", relief_unknown},
        {"no-light", {"direct", "truth.direct", "truth.indirect", "reflect direct"}, "", "no light shines on the scene", no_light},
        {"nothing-reflects", {"gather", "truth.indirect", "isr", "isr access"}, "", "nothing reflects", nothing_reflects},
        {"reflectors-missed", {"gather"}, "", "nothing that the light may meet reflects", reflectors_missed},
        {"no-mirror", {"reflect", "reflect light", "reflect shadow", "reflect direct", "truth.reflection"}, "", "nothing mirrors", no_mirror},
        {"no-radiosity", {"isr"}, "", "nothing sends light", no_radiosity},
        {"isr-unseen", {"isr"}, "", "k_isr is 0: indirect light is not shown", isr_unseen},
        {"access-unread", {"isr access"}, "", "nothing reads how open a point is", access_unread},
        {"isr-unread", {"isr lit", "isr view"}, "", "neither indirect light nor accessibility is read", isr_unread},
        {"no-gather", {"filter"}, "", "no gather runs", no_gather},
        {"no-albedo", {"camera"}, "albedo", "no albedo: nothing reflects", no_albedo},
        {"no-emission", {"camera"}, "emission", "no emission: nothing emits", no_emission},
        {"depth-alone", {"rsm"}, "light", "depth alone: no gather reads the light", light_unread},
        {"face-blind", {"rsm"}, "face", "sees nothing", face_blind},
        {"mesh-unseen", {"probes"}, "mesh", "is not in view", mesh_unseen},
        {"nothing-covered", of_screen, "", "no pixel sees a surface", nullptr, nothing_covered},
        {"map-dark", {"gather"}, "", "the light's map holds no flux", nullptr, map_dark},
        {"tile-empty", {"shadow", "gather", "filter", "direct", "isr", "isr access", "isr lit", "ao", "ao light", "reflect", "reflect light"}, "tile", "sees no surface", nullptr, tile_empty},
    };
    return all;
}

const Rule* left_out_by(const std::vector<Rule>& rules, const PlanFacts& known, const Work& work) {
    for (const Rule& rule : rules)
        if (rule.holds && rule.speaks_of(work) && rule.holds(known, work)) return &rule;
    return nullptr;
}

const Rule* left_out_by(const std::vector<Rule>& rules, const RunFacts& seen, const Work& work) {
    for (const Rule& rule : rules)
        if (rule.seen && rule.speaks_of(work) && rule.seen(seen, work)) return &rule;
    return nullptr;
}

PlanFacts known_of(const Scene& scene, const Settings& settings, const Geometry& geometry) {
    PlanFacts known{scene, settings, geometry};
    known.empty = !bounds(geometry, known.low, known.high);
    known.tame = fits(known.low) && fits(known.high) && fits(glm::vec3(scene.camera.position));
    for (const Light& light : scene.lights) known.tame = known.tame && fits(light.position);
    for (const auto& [key, box] : boxes_of(geometry)) {
        const Material& material = material_of(scene, key.second);
        known.drawn.push_back(box);
        if (material.reflectance != glm::vec3(0)) known.reflecting.push_back(box);
        known.emits = known.emits || material.emission != glm::vec3(0);
    }
    const glm::ivec2 size = scene.frame_size;
    const View view = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);
    known.slack = 2.0 * rsm::ray_offsets(settings.layout, known.low, known.high, view, size).receiver;
    known.tame = known.tame && known.slack < 1e15;
    for (int l = 0; l < int(scene.lights.size()); ++l) {
        const Work work{"shadow", "", l};
        known.shines.push_back(!light_off(known, work) && !light_black(known, work) && !light_misses(known, work));
    }
    return known;
}

}  // namespace plumb::frame
