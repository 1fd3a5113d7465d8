#include "gi/frame/relief_use.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/nearest_known.h"
#include "gi/frame/isr.h"
#include "gi/probes/bake.h"

namespace plumb::frame {

namespace {

// Whether a material that the mesh is drawn with is such a one.
template <class Is>
bool any_material(const Scene& scene, const Mesh& mesh, Is is) {
    std::int32_t last = -1;
    for (const std::int32_t m : mesh.material) {
        if (m == last) continue;  // neighbours mostly have the same
        last = m;
        if (m >= 0 && m < int(scene.materials.size()) && is(scene.materials[std::size_t(m)])) return true;
    }
    return false;
}

bool has_map(const Material& m) { return m.normal_texture >= 0; }
bool is_glossy(const Material& m) { return m.specular != glm::vec3(0); }

}  // namespace

ReliefUse relief_use(const Scene& scene, const Settings& settings) {
    ReliefUse use;
    if (!lights_probes(settings)) return use;
    const bool maps = probes::maps_normals(settings.probe_run), highlights = probes::has_highlights(settings.probe_run);
    for (const Mesh& mesh : scene.meshes) {
        if (mesh.triangles.empty()) continue;
        const bool mapped = !mesh.dynamic && (maps || settings.probe_run.layers) && any_material(scene, mesh, has_map);
        const bool glossy = highlights && any_material(scene, mesh, is_glossy);
        use.dynamic = use.dynamic || mesh.dynamic;
        use.maps = use.maps || (mapped && maps);
        use.highlights = use.highlights || glossy;
        use.fixed = use.fixed || (!mesh.dynamic && ((mapped && maps) || glossy));
    }
    // Before there is a bake: one that is made has them where something moves (probe_bake.h).
    use.volume = settings.bake ? !settings.bake->spatial.empty()
                               : use.dynamic || settings.probes.spatial_receivers > 0 || !settings.probe_run.file.empty();
    use.dynamic = use.dynamic && use.volume, use.fixed = use.fixed && use.volume;
    use.layers = settings.probe_run.layers;
    return use;
}

bool drops_normal_maps(const Settings& settings) { return lights_probes(settings) && !probes::maps_normals(settings.probe_run); }

namespace {

// "a, b": without the blanks around each.
std::vector<std::string> names_in(const std::string& list) {
    std::vector<std::string> names;
    for (std::size_t at = 0; at < list.size();) {
        const std::size_t end = std::min(list.find(',', at), list.size());
        const std::string part = list.substr(at, end - at);
        const std::size_t first = part.find_first_not_of(' '), last = part.find_last_not_of(' ');
        names.push_back(first == part.npos ? "" : part.substr(first, last + 1 - first));
        at = end + 1;
    }
    return names;
}

}  // namespace

std::vector<bool> static_lamps(const Scene& scene, const Settings& settings) {
    std::vector<bool> lamps;
    if (!lights_probes(settings)) return lamps;
    for (const std::string& name : names_in(settings.probe_run.static_lamps))
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            if (scene.lights[l].name != name) continue;
            lamps.resize(scene.lights.size(), false);
            lamps[l] = true;
        }
    return lamps;
}

void check_static_lamps(const Scene& scene, const Settings& settings) {
    if (!lights_probes(settings)) return;
    std::vector<std::string> known;
    for (const Light& light : scene.lights) known.push_back(light.name);
    for (const std::string& name : names_in(settings.probe_run.static_lamps))
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw InputError(fmt::format("[probes] static_lamps: no lamp is called \"{}\"{}", name, nearest_known(name, known, "\"\"")));
    const bool moves = std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& m) { return m.dynamic && !m.triangles.empty(); });
    if (moves && !static_lamps(scene, settings).empty() && settings.bake && settings.bake->spatial.empty())
        throw InputError("[probes] static_lamps: the bake has no spatial receivers, by which what moves sees them: expected one of spatial_receivers above 0");
}

}  // namespace plumb::frame
