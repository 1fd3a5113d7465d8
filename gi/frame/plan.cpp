#include <fmt/format.h>

#include "core/error.h"
#include "gi/frame/frame.h"
#include "gi/rsm/all_rays.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million turns of a stage's inner loop on one core with AVX-512, measured by plumb_bench
// on a 2.x GHz server core. They order stages by cost; they promise nothing.
constexpr double ms_pixels = 60, ms_shadow = 8, ms_direct = 6, ms_disc = 4.2, ms_all = 0.55,
                 ms_exact_rays = 100, ms_native_rays = 25, ms_compose = 5, ms_tonemap = 25,
                 ms_paths = 1000;

bool black(const glm::vec3& v) { return !(v.x > 0 || v.y > 0 || v.z > 0); }

// Why a light cannot change the picture; empty if it may.
std::string why_dark(const Light& light, const glm::vec3& low, const glm::vec3& high) {
    if (!light.on) return "the light is off";
    if (black(light.intensity)) return "the light is black";
    if (light.type != LightType::spot) return "";
    // A spot of half angle below 90 degrees lights nothing when every corner of the scene's bounds lies behind it.
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z);
        if (dot3(p - light.position, light.direction) > 0) return "";
    }
    return "everything lies behind the light";
}

// True if that colour of some material is not 0. Textures multiply it.
bool any_surface(const Scene& scene, const Geometry& geometry, glm::vec3 Material::* colour) {
    for (std::int32_t m : geometry.material)
        if (scene.materials[m].*colour != glm::vec3(0)) return true;
    return false;
}

// The buffers that can hold anything but 0; adds to `left_out` what the others are.
raster::GBufferWants wanted(bool reflects, bool emits, std::string& left_out) {
    raster::GBufferWants wants;
    wants.albedo = reflects;
    wants.emission = emits;
    if (!reflects) left_out += "; no albedo: nothing reflects";
    if (!emits) left_out += "; no emission: nothing emits";
    return wants;
}

// All maps of a frame are held at once, three images and a record a texel: 112 bytes in fp32, 28 GiB at this bound.
constexpr double max_map_texels = 0x1p28;

// Adds a light's maps to the texels of those before it.
void add_texels(const Scene& scene, const Light& light, double texels, double& total) {
    total += texels;
    if (total <= max_map_texels) return;
    const int maps = raster::map_count(light);
    throw InputError(fmt::format("{}: light \"{}\": rsm_size = {}{}: {:.0f} texels in all reflective shadow maps up to "
                                 "this light: expected at most {:.0f}",
                                 scene.name, light.name, light.rsm_size,
                                 maps > 1 ? fmt::format(", {} faces", maps) : "", total, max_map_texels));
}

struct Planner {
    const Scene& scene;
    const Settings& settings;
    Plan plan;

    void add(const char* name, int light, double work, const char* unit, double ms_per_million, const std::string& why,
             const std::string& why_not) {
        PlannedStage s;
        s.name = name;
        s.light = light;
        s.label = light < 0 ? name : fmt::format("{} ({})", name, scene.lights[light].name);
        s.needed = why_not.empty() || !settings.pruning;
        s.reason = why_not.empty() ? why : settings.pruning ? why_not : "pruning is off: " + why_not;
        s.work = work;
        s.work_unit = unit;
        s.expected_ms = s.needed ? work * 1e-6 * ms_per_million : 0;
        plan.stages.push_back(std::move(s));
    }

    void add_gather(int light, double pixels, int maps, double texels, const std::string& why_not) {
        const rsm::GatherParams& params = settings.rsm;
        const std::string name = rsm::stage_name(params.gather), why = "indirect light of this light";
        if (params.gather == rsm::Gather::disc)
            return add(name.c_str(), light, pixels * maps * params.samples, "samples", ms_disc, why, why_not);
        if (params.gather == rsm::Gather::all)
            return add(name.c_str(), light, pixels * texels, "texel pairs", ms_all, why, why_not);
        // How many texels are lit and how many pixels see a surface, only the run knows.
        const double asked = double(rsm::texels_asked(params, std::uint64_t(pixels), std::uint64_t(texels)));
        const std::string subset =
            asked < texels ? fmt::format("; subset of at least {} of {} texels a pixel", asked, texels) : "";
        const double ms = params.rays == Rays::exact ? ms_exact_rays : ms_native_rays;
        add(name.c_str(), light, pixels * asked, "shadow rays at most", ms, why + subset, why_not);
    }

    // A layer that is path traced. Until the error is small enough, nobody knows how many samples that takes: what is
    // expected is the number that is given all the same.
    void add_traced(const char* layer, double pixels, const std::string& why, const std::string& why_not = "") {
        const reference::PathParams& p = settings.reference;
        std::string reason = why;
        if (p.until_error > 0)
            reason += fmt::format("; until its error is {} of its mean, at most {} samples", p.until_error,
                                  p.max_samples);
        add("reference", -1, pixels * double(p.samples), "paths", ms_paths, reason, why_not);
        PlannedStage& s = plan.stages.back();
        s.layer = layer;
        s.samples = p.until_error > 0 ? 0 : p.samples;
        if (s.layer != "color") s.label = layer;
    }
};

}  // namespace

Plan plan(const Scene& scene, const Settings& settings) {
    const Geometry geometry = flatten(scene);
    glm::vec3 low(0), high(0);
    const bool empty = !bounds(geometry, low, high);
    const std::string nothing = empty ? "the scene is empty" : "";
    const double pixels = double(scene.frame_size.x) * scene.frame_size.y;
    const double triangles = double(geometry.triangles.size());
    const bool reflects = any_surface(scene, geometry, &Material::reflectance);
    // The path tracer reads the scene itself.
    const std::string by_paths = settings.method == Method::reference ? "paths are traced instead" : "";
    const std::string no_bounce = empty ? nothing : reflects ? "" : "nothing reflects";

    Planner planner{scene, settings, {}};
    std::string without;
    if (settings.pruning)
        planner.plan.gbuffer = wanted(reflects, any_surface(scene, geometry, &Material::emission), without);
    planner.add("gbuffer", -1, triangles + pixels, "triangles + pixels", ms_pixels,
                (by_paths.empty() ? "every later stage reads it" : "its layers") + without, nothing);
    double total_texels = 0;
    std::string no_lamp = empty ? nothing : "no light shines on the scene";
    for (int l = 0; l < int(scene.lights.size()); ++l) {
        const Light& light = scene.lights[l];
        std::string dark = empty ? nothing : why_dark(light, low, high);
        if (dark.empty()) no_lamp = "";
        if (dark.empty()) dark = by_paths;
        const int maps = raster::map_count(light);
        const double texels = double(maps) * light.rsm_size * light.rsm_size;
        if (dark.empty() || !settings.pruning) add_texels(scene, light, texels, total_texels);
        planner.add("rsm", l, maps * triangles + texels, "triangles + texels", ms_pixels,
                    maps > 1 ? fmt::format("shadow and gather read it; {} faces", maps) : "shadow and gather read it",
                    dark);
        planner.add("shadow", l, pixels, "pixels", ms_shadow, "direct light reads it", dark);
        if (settings.method != Method::rsm) continue;
        planner.add_gather(l, pixels, maps, texels, dark.empty() ? no_bounce : dark);
    }
    planner.add("direct", -1, pixels * double(scene.lights.size()), "pixels x lights", ms_direct, "direct light",
                empty ? nothing : scene.lights.empty() ? "there is no light" : by_paths);
    planner.add("compose", -1, pixels, "pixels", ms_compose, "the picture", by_paths);
    if (settings.method == Method::reference) planner.add_traced("color", pixels, "the picture");
    planner.add("tonemap", -1, pixels, "pixels", ms_tonemap, "the picture", "");
    if (settings.truth) {
        planner.add_traced("truth", pixels, "the truth of color");
        planner.add_traced("truth.direct", pixels, "the truth of direct: lamps alone", no_lamp);
        if (settings.method == Method::rsm)
            planner.add_traced("truth.indirect", pixels, "the truth of indirect: one bounce of the lamps' light",
                               no_lamp.empty() ? no_bounce : no_lamp);
    }
    return std::move(planner.plan);
}

}  // namespace plumb::frame
