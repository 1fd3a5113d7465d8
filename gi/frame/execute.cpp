#include <algorithm>
#include <functional>

#include "core/fp_environment.h"
#include "gi/direct/log_blur.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/kept.h"
#include "gi/frame/rules.h"

namespace plumb::frame {

namespace {

// Asks the rules of the plan that only a run can ask: what stages before have made tells what the next may leave out.
bool left_out(const Plan& plan, const Frame& frame, const PlannedNode& node, StageRun& run) {
    RunFacts seen{frame.gbuffer, {}, frame.gbuffer.covered};
    if (node.plan.light >= 0) seen.maps = frame.rsms[std::size_t(node.plan.light)];
    const Rule* rule = left_out_by(plan.run_rules, seen, {node.work, "", node.plan.light});
    if (!rule) return false;
    run.needed = false;
    run.rule = rule->name, run.reason = rule->reason;
    run.saved_ms += node.plan.expected_ms;
    return true;
}

bool makes(const Plan& plan, const std::string& layer) {
    return std::any_of(plan.stages.begin(), plan.stages.end(), [&](const PlannedStage& s) { return s.layer == layer; });
}

// Takes away what an earlier frame has left that this one does not make.
void forget(Context& c, const Plan& plan) {
    Frame& f = c.frame;
    std::erase_if(f.traced, [&](const Traced& t) { return !makes(plan, t.layer); });
    if (!makes(plan, "truth")) f.truth_display = {};
    if (c.settings.probe_run.indirect_shadow == probes::IndirectShadow::off) f.probes.fitted.clear(), f.probes.shadow_spheres = {}, f.probes.unshaded = {};
    const isr::IsrParams& isr = c.settings.isr;
    if (!gathers_isr(c.settings)) f.isr = {};
    if (!lights_probes(c.settings)) f.probes = {};
    if (!solves_radiosity(c.settings)) f.radiosity = {};
    if (!occludes(c.settings)) f.ao = {};
    if (!reflects(c.settings)) f.reflect = {};
    if (c.settings.reflect.lobe == screen::Lobe::off) f.reflect.rays = {};
    if (c.settings.method != Method::zbuffer) f.zbuffer = {};
    if (zbuffer::per_pixel(c.settings.zbuffer.technique)) f.zbuffer.vertex_light = {};
    if (!c.settings.zbuffer.normals) f.zbuffer.vertex_normals = {};
    if (c.static_lamps.empty()) f.probes.static_light.clear();
    if (!c.relief.layers)
        for (ReliefBuffers::Layer& layer : f.probes.relief.layers) layer.radiance = layer.display = {};
    if (c.settings.probe_run.loop != probes::Loop::pipelined) f.probes.last = f.probes.next = {};
    if (isr.bounces < 2) f.isr.reflectance = {};
    if (isr.guard > 0) f.isr.radiosity = {};  // the wider view's takes its place
    const bool native = isr.resolution == isr::Resolution::native;
    if (isr.blur == isr::Blur::none) f.isr.blurred_across = f.isr.blurred = {};
    if (native && isr.blur == isr::Blur::none) f.isr.lit = {};
    if (native) f.isr.blurred = {};
    if (!casts_shadows(c.settings))
        for (std::vector<raster::Rsm>& maps : f.rsms) maps.clear();
    if (!direct::blurs_maps(c.settings.shadow))
        for (std::size_t l = 0; l < c.lights.size(); ++l) f.maps_blurred_across[l] = f.maps_blurred[l] = {};
    if (!filters_shadows(c.settings)) f.visibility_across = f.visibility_filtered = {};
    const bool half = halves_indirect(c.settings);
    if (!half) f.half_position = f.half_normal = {};
    if (!filters_indirect(c.settings)) f.gathered = {};
    if (!reuses_light(c.settings)) f.reused = f.reused_age = {}, f.last_light = f.next_light = {}, f.light_frames = 0;
    if (!half || blur_of(c.settings) == filter::Blur::none) f.upsampled = {};
    if (!filters_indirect(c.settings) || blur_of(c.settings) != filter::Blur::separable) f.blurred_across = {};
    if (c.keeps && c.settings.method == Method::rsm) return;
    for (Image4& image : c.memory->irradiance) image = {};
    for (Image4& image : c.memory->irradiance_error) image = {};
}

// kept: null where nothing is kept.
void execute_in(KeptMemory& memory, const Scene& scene, const Settings& settings, const Plan& plan,
                const RunOptions& options, const Progress& progress, const Stores& stores, const KeptStages* kept) {
    FrameGraph graph(scene, settings, plan, memory);
    Context& c = graph.context();
    if (kept) c.keys = scene_keys(scene, settings), c.bake_key = memory.bake_key.of(settings.bake);
    memory.world.update(scene, settings, kept ? &c.keys : nullptr);
    c.tracer = std::make_unique<Tracer>(scene, settings, memory.world.geometry, stores.traced, &memory.world.paths);
    c.rows = stores.rows, c.keeps = kept != nullptr, c.isa = options.isa;
    memory.irradiance.resize(c.lights.size()), memory.irradiance_error.resize(c.lights.size());
    graph.make_room();
    forget(c, plan);
    if (kept && kept->other_key()) memory.ao_shares.clear();  // then nothing is reused but what those keys say
    if (!c.keeps && sums_gathers(settings)) begin_sum(c);

    graph::RunWith with{options, progress};
    if (kept) with.kept = &memory.made;
    if (kept && kept->other_key()) with.other_key = std::cref(kept->other_key());  // not a copy: it may have a state
    with.leaves_out = [&](const graph::Node& node, StageRun& run) {
        return node.listed && left_out(plan, memory.frame, static_cast<const PlannedNode&>(node), run);
    };
    memory.frame.stages = graph::run(graph.planned(plan), with);
}

}  // namespace

Frame execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
              const Progress& progress, const Stores& stores) {
    FpEnvironment environment;
    KeptMemory memory;
    execute_in(memory, scene, settings, plan, options, progress, stores, nullptr);
    return std::move(memory.frame);
}

const Frame& execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& options,
                     KeptStages& kept, const Progress& progress, const Stores& stores) {
    FpEnvironment environment;
    KeptMemory& memory = kept.memory();
    try {
        execute_in(memory, scene, settings, plan, options, progress, stores, &kept);
    } catch (...) {
        memory = KeptMemory();
        throw;
    }
    return memory.frame;
}

}  // namespace plumb::frame
