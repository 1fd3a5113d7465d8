#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "core/error.h"
#include "gi/frame/filters.h"
#include "gi/frame/frame.h"
#include "gi/frame/isr.h"
#include "gi/frame/run_stage.h"
#include "gi/reference/ray_query.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

void require_inside(const std::string& label, glm::ivec2 pixel, glm::ivec2 size) {
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y)
        throw InputError(fmt::format("explain: pixel {},{} is outside of {}, which is {} x {}", pixel.x, pixel.y, label,
                                     size.x, size.y));
}

glm::ivec2 map_size(const Light& light) { return {raster::map_count(light) * light.rsm_size, light.rsm_size}; }

// Appends the result of that name as a target of that format gives it back to the stages after.
std::vector<TapValue> with_stored(std::vector<TapValue> values, const char* name, Format format,
                                  const raster::Layout& layout) {
    if (format == Format::r32f || format == Format::rgba32f) return values;
    const auto result = std::find_if(values.rbegin(), values.rend(), [&](const TapValue& v) { return v.name == name; });
    if (result == values.rend()) return values;
    glm::vec4 texel(0);
    for (std::size_t c = 0; c < result->value.size(); ++c) texel[int(c)] = float(result->value[c]);
    quantise(format, texel);
    TapValue stored{std::string("stored_") + name, -1, {}, "as layout " + layout.name + " stores it"};
    for (std::size_t c = 0; c < result->value.size(); ++c) stored.value.push_back(texel[int(c)]);
    values.push_back(std::move(stored));
    return values;
}

struct Explainer {
    const Scene& scene;
    const Settings& settings;
    const Frame& frame;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::vector<Light> lights;
    glm::vec3 low{0}, high{0};

    // A texel of the light's map, or of its six maps side by side.
    std::vector<TapValue> explain_texel(const Light& light, glm::ivec2 texel) const {
        const int face = texel.x / light.rsm_size;
        const View view = raster::light_views(light, low, high)[std::size_t(face)];
        std::vector<TapValue> values;
        if (raster::map_count(light) > 1)
            values.push_back({"face", -1, {double(face)}, "of the point light: +x -x +y -y +z -z"});
        const std::vector<TapValue> taps =
            raster::explain_rsm(geometry, surfaces, light, view, {texel.x - face * light.rsm_size, texel.y},
                                settings.layout);
        values.insert(values.end(), taps.begin(), taps.end());
        return values;
    }

    // A texel of the blurred map, or of its six maps side by side.
    std::vector<TapValue> explain_blur(const PlannedStage& stage, const Light& light, glm::ivec2 texel) const {
        const int face = texel.x / light.rsm_size;
        std::vector<TapValue> values;
        if (raster::map_count(light) > 1)
            values.push_back({"face", -1, {double(face)}, "of the point light: +x -x +y -y +z -z"});
        const std::size_t m = std::size_t(face);
        if (frame.rsms[std::size_t(stage.light)][m].size == 0) {
            values.push_back({"depth", -1, {0.0}, "the face sees nothing"});
            return values;
        }
        const std::vector<TapValue> taps = direct::explain(settings.shadow, map_blur_inputs(frame, stage, m),
                                                           {texel.x - face * light.rsm_size, texel.y});
        values.insert(values.end(), taps.begin(), taps.end());
        return values;
    }

    std::vector<TapValue> isr_values(const PlannedStage& stage, glm::ivec2 pixel) const {
        const isr::IsrParams& params = settings.isr;
        if (stage.name == "isr.downsample")
            return isr::explain(params, downsample_inputs(scene, frame, stage), pixel);
        if (stage.name == "isr.gather") {
            const isr::Pattern pattern = isr::gather_pattern(params);
            return isr::explain(params, gather_inputs(scene, settings, frame, stage, pattern), pixel);
        }
        if (stage.name == "isr.gather_camera") {
            const isr::Pattern pattern = isr::gather_pattern(params);
            return isr::explain(params, camera_gather_inputs(scene, settings, frame, stage, pattern), pixel);
        }
        if (stage.name == "isr.unseen") return isr::explain(params, unseen_inputs(scene, settings, frame, stage), pixel);
        if (stage.name == "isr.ssao") {
            const isr::Pattern pattern = isr::ssao_pattern(params);
            return isr::explain(params, ssao_inputs(scene, settings, frame, pattern), pixel);
        }
        if (stage.name == "isr.bounce") return isr::explain(params, bounce_inputs(scene, settings, frame, stage), pixel);
        if (stage.name == "isr.blur") return isr::explain(params, isr_blur_inputs(settings, frame, stage), pixel);
        if (stage.name == "isr.upsample") return isr::explain(params, upsample_inputs(scene, settings, frame), pixel);
        return isr::explain(params, compose_inputs(scene, frame), pixel);
    }

    std::vector<TapValue> values(const PlannedStage& stage, glm::ivec2 pixel) const {
        if (is_isr(stage.name)) return isr_values(stage, pixel);
        const raster::GBuffer& g = frame.gbuffer;
        const int l = stage.light;
        if (draws_view(stage.name)) {
            const glm::ivec2 size = stage.view == 0 ? scene.frame_size : frame.views[std::size_t(stage.view)].size;
            const Camera& camera = stage.view == 0 ? scene.camera : frame.views[std::size_t(stage.view)].camera;
            const View view = make_view(camera, double(size.x) / size.y, scene.convention, size);
            return raster::explain_gbuffer(geometry, surfaces, view, size, pixel, settings.layout,
                                           peeled_depth(scene, settings, frame, stage.view));
        }
        if (stage.name == "rsm")
            return explain_texel(lights[l], pixel);
        if (stage.name == "shadow.blur") return explain_blur(stage, lights[l], pixel);
        if (stage.name == "shadow")
            return with_stored(direct::explain(settings.shadow, shadow_inputs(settings, frame, l, g), pixel), "visibility",
                               settings.layout.visibility, settings.layout);
        if (stage.name == "direct")
            return direct::explain(settings.direct,
                                   direct::DirectInputs{&g.position, &g.normal, &lights, &frame.visibility, nullptr,
                                                        compose::reads_density(settings.compose)},
                                   pixel);
        if (is_gather(stage.name)) {
            const rsm::Pattern pattern = rsm::pattern_of(settings.rsm, lights[l].rsm_size, settings.seed);
            std::unique_ptr<RayQuery> rays;
            if (stage.name == "rsm.all_rays") rays = reference::build_ray_query(geometry, surfaces, settings.rsm.rays);
            const rsm::GatherInputs in = gather_inputs(scene, settings, frame, l, geometry, pattern, rays.get());
            return with_stored(rsm::explain_maps(settings.rsm, in, frame.rsms[l], pixel), "irradiance",
                               settings.layout.indirect, settings.layout);
        }
        if (stage.name == "filter.reduce") return filter::explain(settings.indirect, filter::ReduceInputs{&reduce_input(frame, stage)}, pixel);
        if (stage.name == "filter.upsample") return filter::explain(settings.indirect, upsample_inputs(frame), pixel);
        if (stage.name == "filter.blur")
            return filter::explain(settings.indirect, blur_inputs(settings, frame, stage), pixel);
        if (stage.name == "compose")
            return compose::explain(settings.compose,
                                    compose::ComposeInputs{&g.normal, &g.albedo, &g.emission, &frame.direct,
                                                           &frame.indirect, scene.environment.radiance},
                                    pixel);
        return compose::explain(settings.tonemap, compose::TonemapInputs{&frame.radiance}, pixel);
    }
};

}  // namespace

std::vector<Explanation> explain(const Scene& scene, const Settings& settings, const Plan& plan, const Frame& frame,
                                 const std::string& stage, int light, glm::ivec2 pixel) {
    // Find the stages that are asked for.
    std::vector<std::string> names;
    for (const StageInfo& info : all_stages()) names.push_back(info.name);
    if (!stage.empty() && std::find(names.begin(), names.end(), stage) == names.end())
        throw InputError(fmt::format("explain: unknown stage '{}'; the nearest known one is '{}'", stage,
                                     nearest_name(stage, names)));
    if (!stage.empty() && !in_a_frame(stage))
        throw InputError(fmt::format("explain: the stage {} is not part of a frame: no method runs it", stage));
    if (stage == "reference")
        throw InputError("explain: the stage reference is a mean over paths; it has no values to list");
    std::vector<const PlannedStage*> chosen;
    std::string left_out;
    const Plan ran = as_it_ran(plan, frame);
    for (const PlannedStage& s : ran.stages) {
        if (stage.empty() ? s.name == "rsm" || s.name == "shadow.blur" || s.name == "reference" : s.name != stage) continue;
        const bool of_frame = s.view == 0 || is_isr(s.name);
        if (!of_frame && stage != "gbuffer.layer") continue;
        if (light >= 0 && s.light >= 0 && s.light != light) continue;
        if (!s.needed) {
            left_out = s.reason;
            continue;
        }
        chosen.push_back(&s);
        if (stage == "shadow.blur" && s.form == "horizontal") {
            light = s.light;  // and its other pass
            continue;
        }
        if (!stage.empty() && !is_filter(stage) && !is_isr(stage) && stage != "gbuffer.layer") break;
    }
    if (chosen.empty())
        throw InputError(fmt::format("explain: {} does not run for this scene{}", stage.empty() ? "any stage" : stage,
                                     left_out.empty() ? ": its method does not use it" : ": " + left_out));

    Explainer explainer{scene, settings, frame, flatten(scene), {}, {}};
    explainer.surfaces = raster::prepare(scene, explainer.geometry);
    bounds(explainer.geometry, explainer.low, explainer.high);
    for (Light l : scene.lights) {
        if (!l.on) l.intensity = glm::vec3(0);
        explainer.lights.push_back(l);
    }
    std::vector<Explanation> explanations;
    for (const PlannedStage* s : chosen) {
        const bool map = s->name == "rsm" || s->name == "shadow.blur";
        const glm::ivec2 size = map ? map_size(scene.lights[std::size_t(s->light)])
                               : s->name == "gbuffer.layer" ? frame.views[std::size_t(s->view)].size
                               : is_isr(s->name) ? isr_size(scene, settings, *s)
                                                 : stage_size(settings, *s, scene.frame_size);
        // Of all stages at a pixel those of half size are asked for the one that stands for it.
        if (stage.empty()) require_inside("the frame", pixel, scene.frame_size);
        const glm::ivec2 at = stage.empty() && size != scene.frame_size ? pixel / 2 : pixel;
        require_inside(s->label, at, size);
        explanations.push_back({s->label, at, explainer.values(*s, at)});
    }
    return explanations;
}

}  // namespace plumb::frame
