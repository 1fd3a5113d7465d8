#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/isr.h"
#include "gi/frame/refusals.h"
#include "gi/frame/rules.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

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

void note(PlannedStage& stage, const Rule& rule, const std::string& reason, double ms) {
    ms = std::min(ms, stage.expected_ms);
    stage.parts.push_back({rule.name, reason, ms});
    stage.reason += "; " + reason;
    stage.expected_ms -= ms, stage.saved_ms += ms;
}

// Leaves out a whole node, or says that pruning would.
void leave_out(PlannedStage& stage, const Rule& rule, bool pruning) {
    stage.needed = !pruning;
    stage.reason = (pruning ? "" : "pruning is off: ") + rule.reason;
    if (!pruning) return;
    stage.rule = rule.name, stage.saved_ms = stage.expected_ms, stage.expected_ms = 0;
}

// Leaves out parts of a node that is needed.
void leave_out_parts(const PlannedNode& node, const std::vector<Rule>& rules, const PlanFacts& known, PlannedStage& stage,
                     Plan& plan) {
    struct Some {
        const Rule* rule = nullptr;
        int count = 0;
        double ms = 0;
    } some;  // of parts of one name
    for (std::size_t i = 0; i < node.parts.size(); ++i) {
        const Part& part = node.parts[i];
        if (const Rule* rule = left_out_by(rules, known, {node.work, part.name, stage.light, part.index})) {
            const double ms = part.ms(plan);
            part.leave_out(plan);
            if (part.index < 0)
                note(stage, *rule, rule->reason, ms);
            else
                some.rule = rule, ++some.count, some.ms += ms;
        }
        const bool last = i + 1 == node.parts.size() || node.parts[i + 1].name != part.name;
        if (last && some.rule) note(stage, *some.rule, fmt::format("{} left out: each {}", some.count, some.rule->reason), some.ms);
        if (last) some = {};
    }
}

// In a pipeline what nobody sees now is in later frames.
bool goes_on_unseen(const Settings& settings, const Rule& rule) {
    return lights_probes(settings) && settings.probe_run.loop == probes::Loop::pipelined && rule.part.empty();
}

// The graph of a frame, rewritten by the rules.
Plan plan_of(const Scene& scene, const Settings& settings, const Geometry& geometry, const std::vector<Rule>& rules) {
    const PlanFacts known = known_of(scene, settings, geometry);
    const FrameGraph graph(scene, settings, geometry);
    Plan plan;
    plan.maps.resize(scene.lights.size());
    double map_texels = 0;
    for (const PlannedNode& node : graph.nodes()) {
        if (!node.listed) continue;
        PlannedStage stage = node.plan;
        if (const Rule* rule = left_out_by(rules, known, {node.work, "", stage.light})) leave_out(stage, *rule, settings.pruning);
        if (stage.needed && node.map_texels > 0)
            add_texels(scene, scene.lights[std::size_t(stage.light)], node.map_texels, map_texels);
        if (stage.needed && settings.pruning) leave_out_parts(node, rules, known, stage, plan);
        plan.stages.push_back(std::move(stage));
    }
    if (settings.pruning && known.tame)
        for (const Rule& rule : rules)
            if (rule.seen && !goes_on_unseen(settings, rule)) plan.run_rules.push_back(rule);
    return plan;
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

Plan plan_after_run(const Plan& plan, const Frame& frame) {
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
