#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/error.h"
#include "gi/direct/log_blur.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame.h"
#include "gi/frame/isr.h"
#include "gi/frame/refusals.h"
#include "gi/methods.h"
#include "gi/rsm/all_rays.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

// Milliseconds for a million turns of a stage's inner loop on one core with AVX-512, measured by plumb_bench
// on a 2.x GHz server core. They order stages by cost; they promise nothing.
// Those of stages with a kernel are their descriptions'.
constexpr double ms_pixels = 60, ms_exact_rays = 100, ms_native_rays = 25, ms_paths = 1000;
// What a part of a stage takes of that, for a million pixels: the light of a map, by `tools/bench pruning` (the Cornell
// box with direct light alone); the two colours of a G-buffer with their textures and one of them alone, estimated.
constexpr double ms_light = 45, ms_colours = 12, ms_colour = 4;

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
    const std::vector<Rule>& rules;
    const Known& known;
    Plan plan;
    std::vector<IsrView> views = isr_views(scene, settings);

    const Rule* left_out(const Work& work) const { return left_out_by(rules, known, work); }

    // `kind`: the stage as rules name it.
    PlannedStage& add(const char* name, const char* kind, int light, double work, const char* unit,
                      double ms_per_million, const std::string& why) {
        PlannedStage& s = plan.stages.emplace_back();
        const Rule* rule = left_out({kind, "", light});
        const double ms = work * 1e-6 * ms_per_million;
        s.name = name;
        s.light = light;
        s.label = light < 0 ? name : fmt::format("{} ({})", name, scene.lights[light].name);
        s.needed = !rule || !settings.pruning;
        s.reason = !rule ? why : (settings.pruning ? "" : "pruning is off: ") + rule->reason;
        s.work = work;
        s.work_unit = unit;
        s.expected_ms = s.needed ? ms : 0;
        if (!s.needed) s.rule = rule->name, s.saved_ms = ms;
        return s;
    }

    // The same at the cost that the stage's description states.
    PlannedStage& add(const char* name, const char* kind, int light, double work, const std::string& why) {
        for (const ListedStage& s : stages())
            if (s.binding && s.info.name == name)
                return add(name, kind, light, work, s.binding->cost.unit.c_str(), s.binding->cost.ms_per_million, why);
        throw std::logic_error(fmt::format("plan: {} states no cost", name));
    }

    // The rule that leaves out a part of a needed stage, or null.
    const Rule* part_left_out(const PlannedStage& stage, const Work& work) const {
        return settings.pruning && stage.needed ? left_out(work) : nullptr;
    }
    static void note(PlannedStage& stage, const Rule& rule, const std::string& reason, double ms) {
        ms = std::min(ms, stage.expected_ms);
        stage.parts.push_back({rule.name, reason, ms});
        stage.reason += "; " + reason;
        stage.expected_ms -= ms, stage.saved_ms += ms;
    }
    bool leave_out(PlannedStage& stage, const Work& work, double ms) const {
        const Rule* rule = part_left_out(stage, work);
        if (rule) note(stage, *rule, rule->reason, ms);
        return rule;
    }

    // What a stage of a view beside the frame is, of the stage that is planned already.
    static void note_view(PlannedStage& s, int v, const std::string& name) {
        s.view = v;
        if (s.label.ends_with(')'))
            s.label.insert(s.label.size() - 1, ", " + name);
        else
            s.label += " (" + name + ")";
        s.reason = s.reason.empty() ? "indirect light reads it" : s.reason;
    }

    void add_view_gbuffers(double triangles) {
        for (int v = 1; v < int(views.size()); ++v) {
            const double pixels = double(views[std::size_t(v)].size.x) * views[std::size_t(v)].size.y;
            const bool layer = views[std::size_t(v)].kind == ViewKind::layer;
            PlannedStage& s = add(layer ? "gbuffer.layer" : "gbuffer", "isr.view", -1, triangles + pixels,
                                  "triangles + pixels", ms_pixels, "");
            note_view(s, v, views[std::size_t(v)].name);
        }
    }
    void add_view_shadows(int light) {
        for (int v = 1; v < int(views.size()); ++v) {
            const double pixels = double(views[std::size_t(v)].size.x) * views[std::size_t(v)].size.y;
            note_view(add("shadow", "shadow", light, pixels, ""), v, views[std::size_t(v)].name);
        }
    }
    void add_view_direct() {
        for (int v = 1; v < int(views.size()); ++v) {
            const double pixels = double(views[std::size_t(v)].size.x) * views[std::size_t(v)].size.y;
            note_view(add("direct", "direct", -1, pixels * double(scene.lights.size()), ""), v,
                      views[std::size_t(v)].name);
        }
    }

    // Stages of gi/isr, from G-buffers and direct light to indirect light of every pixel.
    void add_isr() {
        const isr::IsrParams& p = settings.isr;
        for (const IsrStage& i : isr_stages(scene, settings)) {
            PlannedStage of;
            of.name = i.name, of.form = i.form, of.view = i.view;
            const glm::ivec2 size = isr_size(scene, settings, of);
            const double pixels = double(size.x) * size.y;
            PlannedStage* s = nullptr;
            if (is_isr_gather(i.name))
                s = &add(i.name.c_str(), "isr", -1, pixels * isr::sample_count(p.rings), "indirect light");
            else if (i.name == "isr.ssao")
                s = &add("isr.ssao", "isr.ssao", -1, pixels * isr::sample_count(p.ssao_rings), "accessibility");
            else if (i.name == "isr.blur")
                s = &add("isr.blur", "isr.lit", -1, pixels * (2 * p.blur_radius + 1), "indirect light without its noise");
            else if (i.name == "isr.upsample")
                s = &add("isr.upsample", "isr.lit", -1, pixels, "indirect light of every pixel");
            else if (i.form == "surface")
                s = &add("isr.downsample", "isr.lit", -1, pixels, "gathers read it");
            else
                s = &add(i.name.c_str(), "isr", -1, pixels, "gathers read it");
            s->form = i.form, s->pass = i.pass;
            if (!i.form.empty()) s->label += " (" + i.form + ")";
            if (i.view > 0) note_view(*s, i.view, views[std::size_t(i.view)].name);
        }
    }

    void add_gbuffer(double triangles, double pixels) {
        const bool paths = settings.method == Method::reference;
        PlannedStage& s = add("gbuffer", "gbuffer", -1, triangles + pixels, "triangles + pixels", ms_pixels,
                              paths ? "its layers" : "every later stage reads it");
        plan.gbuffer.albedo = !leave_out(s, {"gbuffer", "albedo"}, pixels * 1e-6 * ms_colour);
        // Without either colour no texture is read.
        plan.gbuffer.emission = !leave_out(s, {"gbuffer", "emission"},
                                           pixels * 1e-6 * (plan.gbuffer.albedo ? ms_colour : ms_colours - ms_colour));
    }

    // ms: of one face.
    void leave_out_faces(PlannedStage& stage, PlannedMaps& planned, double ms) const {
        const int maps = raster::map_count(scene.lights[std::size_t(stage.light)]);
        const Rule* by = nullptr;
        int left_out = 0;
        for (int m = 0; maps > 1 && m < maps; ++m)
            if (const Rule* rule = part_left_out(stage, {"rsm", "face", stage.light, m}))
                by = rule, ++left_out, planned.faces &= ~(1u << m);
        if (by) note(stage, *by, fmt::format("{} left out: each {}", left_out, by->reason), left_out * ms);
    }

    // What leaves out a light's shadow leaves out the blur of its maps.
    void add_map_blur(int light, double texels) {
        if (!direct::blurs_maps(settings.shadow)) return;
        for (const char* form : {"horizontal", "vertical"}) {
            PlannedStage& s = add("shadow.blur", "shadow", light, texels * (2 * settings.shadow.esm_blur_radius + 1),
                                  "shadow reads it");
            s.form = form;
            s.label.insert(s.label.size() - 1, std::string(", ") + form);
        }
    }

    // The stages rsm and shadow of a light, and its gather. Adds the texels of its maps to those of the lights before.
    void add_light(int l, double triangles, double pixels, double& total_texels) {
        const Light& light = scene.lights[std::size_t(l)];
        const int maps = raster::map_count(light);
        const double side = light.rsm_size, texels = maps * side * side;
        PlannedStage& s = add("rsm", "rsm", l, maps * triangles + texels, "triangles + texels", ms_pixels,
                              maps > 1 ? fmt::format("shadow and gather read it; {} faces", maps)
                                       : "shadow and gather read it");
        if (s.needed) add_texels(scene, light, texels, total_texels);
        PlannedMaps& planned = plan.maps[std::size_t(l)];
        planned.wants.light = !leave_out(s, {"rsm", "light", l}, texels * 1e-6 * ms_light);
        leave_out_faces(s, planned, (triangles + side * side) * 1e-6 * ms_pixels);
        add_map_blur(l, texels);
        add("shadow", "shadow", l, pixels, "direct light reads it");
        add_view_shadows(l);
        if (settings.method != Method::rsm) return;
        const glm::ivec2 size = gather_size(settings, scene.frame_size);
        add_gather(l, double(size.x) * size.y, maps, texels);
    }

    void add_gather(int light, double pixels, int maps, double texels) {
        const rsm::GatherParams& params = settings.rsm;
        const std::string name = rsm::stage_name(params), why = "indirect light of this light";
        if (params.gather == rsm::Gather::disc || params.gather == rsm::Gather::paths) {
            add(name.c_str(), "gather", light, pixels * maps * rsm::sample_count(params), why);
        } else if (params.gather == rsm::Gather::all) {
            add(name.c_str(), "gather", light, pixels * texels, why);
        } else {
            // How many texels are lit and how many pixels see a surface, only the run knows.
            const double asked = double(rsm::texels_asked(params, std::uint64_t(pixels), std::uint64_t(texels)));
            const std::string subset =
                asked < texels ? fmt::format("; subset of at least {} of {} texels a pixel", asked, texels) : "";
            const double ms = params.rays == Rays::exact ? ms_exact_rays : ms_native_rays;
            add(name.c_str(), "gather", light, pixels * asked, "shadow rays at most", ms, why + subset);
        }
    }

    void add_filters(const std::vector<FilterStage>& filters, double pixels) {
        const double kernel = settings.indirect.kernel;
        for (const FilterStage& f : filters) {
            PlannedStage* s = nullptr;
            if (f.name == "filter.reduce")
                s = &add("filter.reduce", "filter", -1, pixels / 4, "gathers read it");
            else if (f.name == "filter.upsample")
                s = &add("filter.upsample", "filter", -1, pixels, "indirect light of every pixel");
            else
                s = &add("filter.blur", "filter", -1, pixels * kernel * (f.form.empty() ? kernel : 1), "indirect light without its noise");
            s->form = f.form;
            if (!f.form.empty()) s->label += " (" + f.form + ")";
        }
    }

    // A layer that is path traced. Until the error is small enough, nobody knows how many samples that takes: what is
    // expected is the number that is given all the same.
    void add_traced(const char* layer, double pixels, const std::string& why) {
        const reference::PathParams& p = settings.reference;
        std::string reason = why;
        if (p.until_error > 0)
            reason += fmt::format("; until its error is {} of its mean, at most {} samples", p.until_error,
                                  p.max_samples);
        PlannedStage& s = add("reference", layer, -1, pixels * double(p.samples), "paths", ms_paths, reason);
        s.layer = layer;
        s.samples = p.until_error > 0 ? 0 : p.samples;
        if (s.layer != "color") s.label = layer;
    }
};

Plan plan_of(const Scene& scene, const Settings& settings, const Geometry& geometry, const std::vector<Rule>& rules) {
    const Known known = known_of(scene, settings, geometry);
    const double pixels = double(scene.frame_size.x) * scene.frame_size.y;
    const double triangles = double(geometry.triangles.size());

    Planner planner{scene, settings, rules, known, {}};
    planner.plan.maps.resize(scene.lights.size());
    planner.add_gbuffer(triangles, pixels);
    planner.add_filters(filters_before_gathers(settings), pixels);
    planner.add_view_gbuffers(triangles);
    double total_texels = 0;
    for (int l = 0; casts_shadows(settings) && l < int(scene.lights.size()); ++l)
        planner.add_light(l, triangles, pixels, total_texels);
    planner.add_filters(filters_after_gathers(settings), pixels);
    planner.add("direct", "direct", -1, pixels * double(scene.lights.size()), "direct light");
    planner.add_view_direct();
    planner.add_isr();
    planner.add(gathers_isr(settings) ? "isr.compose" : "compose", "compose", -1, pixels, "the picture");
    if (settings.method == Method::reference) planner.add_traced("color", pixels, "the picture");
    planner.add("tonemap", "tonemap", -1, pixels, "the picture");
    if (settings.truth) {
        planner.add_traced("truth", pixels, "the truth of color");
        planner.add_traced("truth.direct", pixels, "the truth of direct: lamps alone");
        const std::vector<std::string>& own = methods().at(std::size_t(settings.method)).transport;
        if (std::find(own.begin(), own.end(), "truth.indirect") != own.end())
            planner.add_traced("truth.indirect", pixels, "the truth of indirect: one bounce of the lamps' light");
    }
    if (settings.pruning && known.tame)
        for (const Rule& rule : rules)
            if (rule.seen) planner.plan.at_run.push_back(rule);
    return std::move(planner.plan);
}

}  // namespace

Plan plan(const Scene& scene, const Settings& settings) {
    const Geometry geometry = flatten(scene);
    refuse_scene(scene, settings, geometry);
    Plan plan = plan_of(scene, settings, geometry, rules());
    refuse_plan(scene, settings, geometry, plan);
    return plan;
}

Plan plan(const Scene& scene, const Settings& settings, const std::vector<Rule>& rules) {
    return plan_of(scene, settings, flatten(scene), rules);
}

Plan as_it_ran(const Plan& plan, const Frame& frame) {
    Plan ran = plan;
    for (std::size_t i = 0; i < ran.stages.size() && i < frame.stages.size(); ++i) {
        PlannedStage& stage = ran.stages[i];
        const StageRun& run = frame.stages[i];
        if (!stage.needed || run.needed || stage.label != run.label) continue;
        stage.needed = false, stage.reason = run.reason, stage.rule = run.rule, stage.saved_ms = run.saved_ms;
        stage.expected_ms = 0;
    }
    return ran;
}

}  // namespace plumb::frame
