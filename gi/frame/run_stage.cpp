#include "gi/frame/run_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "gi/frame/at_run.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/reference/ray_query.h"
#include "gi/rsm/all_rays.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

template <class T>
std::size_t bytes_of(const Image<T>& image) {
    return image.size() * sizeof(T);
}
std::size_t bytes_of(const raster::GBuffer& g) {
    return bytes_of(g.position) + bytes_of(g.normal) + bytes_of(g.albedo) + bytes_of(g.emission) + bytes_of(g.depth) +
           bytes_of(g.id);
}
std::size_t bytes_of(const raster::Rsm& r) {
    return bytes_of(r.position) + bytes_of(r.normal) + bytes_of(r.flux) + r.records.size() * sizeof(float) +
           r.half_records.size() * sizeof(Half);
}

void add(Image4& sum, const Image4& term) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum.texels[i] += term.texels[i];
}

// Adds a light's standard error to those of others: independent errors add by their squares.
void add_errors(Image4& sum, const Image4& term) {
    if (sum.empty()) sum = Image4(term.width, term.height);
    for (std::size_t i = 0; i < sum.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double a = sum.texels[i][c], b = term.texels[i][c];
            sum.texels[i][c] = float(std::sqrt(a * a + b * b));
        }
}

void nothing(Context&, const PlannedStage&, StageRun&) {}

// The frame, or a view beside it.
glm::ivec2 view_size(const Context& c, const PlannedStage& stage) {
    return stage.view == 0 ? c.size : c.frame.views[std::size_t(stage.view)].size;
}
raster::GBuffer& gbuffer_of(Context& c, const PlannedStage& stage) {
    return stage.view == 0 ? c.frame.gbuffer : c.frame.views[std::size_t(stage.view)].gbuffer;
}
float* visibility_of(Context& c, const PlannedStage& stage) {
    if (stage.view == 0) return c.visibility(stage.light);
    SourceView& view = c.frame.views[std::size_t(stage.view)];
    return view.visibility.data() + std::size_t(stage.light) * std::size_t(view.size.x) * std::size_t(view.size.y);
}

void draw_gbuffer(Context& c, const PlannedStage& stage, StageRun& run) {
    const glm::ivec2 size = view_size(c, stage);
    const Camera& camera = stage.view == 0 ? c.scene.camera : c.frame.views[std::size_t(stage.view)].camera;
    const View view = make_view(camera, double(size.x) / size.y, c.scene.convention, size);
    raster::GBuffer& g = gbuffer_of(c, stage);
    raster::draw_gbuffer(c.world.geometry, c.world.surfaces, view, size, c.settings.layout, c.options, g,
                         c.plan.gbuffer, &c.memory.workspace, peeled_depth(c.scene, c.settings, c.frame, stage.view));
    // Buffers that were not wanted are 0 where others read them.
    for (Image4* image : {&g.position, &g.normal, &g.albedo, &g.emission})
        if (image->empty()) *image = Image4(size.x, size.y);
    run.bytes = bytes_of(g);
}

// A G-buffer that sees nothing: what the pass would write for an empty scene.
void see_nothing(Context& c, const PlannedStage& stage, StageRun&) {
    const glm::ivec2 size = view_size(c, stage);
    raster::GBuffer& g = gbuffer_of(c, stage) = {};
    g.position = g.normal = g.albedo = g.emission = Image4(size.x, size.y);
    g.depth = Image1(size.x, size.y, c.scene.camera.reversed_z ? 0.0f : 1.0f);
    g.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
    g.covered = raster::Covered(size);
}

// All maps of a light that the plan wants.
void draw_maps(Context& c, const PlannedStage& stage, StageRun& run) {
    const Light& light = c.lights[std::size_t(stage.light)];
    std::vector<raster::Rsm>& maps = c.frame.rsms[std::size_t(stage.light)];
    const std::vector<View> views = raster::light_views(light, c.world.low, c.world.high);
    maps.resize(views.size());
    for (std::size_t m = 0; m < views.size(); ++m) {
        const PlannedMaps& planned = c.plan.maps[std::size_t(stage.light)];
        if (!(planned.faces >> m & 1)) {
            maps[m] = {};
            maps[m].view = views[m];
            continue;
        }
        RunOptions part = c.options;
        if (part.progress)
            part.progress = [&, m](double done) { c.options.progress((double(m) + done) / double(views.size())); };
        raster::draw_rsm(c.world.geometry, c.world.surfaces, light, views[m], c.settings.layout, part, maps[m],
                         &c.memory.workspace, planned.wants);
    }
    for (const raster::Rsm& map : maps) run.bytes += bytes_of(map);
}

void draw_no_map(Context& c, const PlannedStage& stage, StageRun&) {
    const std::size_t l = std::size_t(stage.light);
    c.frame.rsms[l].assign(std::size_t(raster::map_count(c.scene.lights[l])), {});
}

// One pass over all maps of a light (ISR 4.6).
void blur_maps(Context& c, const PlannedStage& stage, StageRun& run) {
    const std::size_t l = std::size_t(stage.light);
    const std::vector<raster::Rsm>& maps = c.frame.rsms[l];
    std::vector<Image4>& blurred = map_blur_result(c.frame, stage)[l];
    blurred.resize(maps.size());
    for (std::size_t m = 0; m < maps.size(); ++m) {
        if (maps[m].size == 0)
            blurred[m] = {};
        else
            direct::run(c.settings.shadow, map_blur_inputs(c.frame, stage, m), c.options, blurred[m]);
        run.bytes += bytes_of(blurred[m]);
    }
}

void blur_no_map(Context& c, const PlannedStage& stage, StageRun&) {
    map_blur_result(c.frame, stage)[std::size_t(stage.light)].clear();
}

void cast_shadows(Context& c, const PlannedStage& stage, StageRun& run) {
    const raster::GBuffer& g = gbuffer_of(c, stage);
    const glm::ivec2 size = view_size(c, stage);
    const raster::Covered tiles = tiles_to_shade(c.plan, c.frame, stage, run, &g.covered);
    float* visibility = visibility_of(c, stage);
    direct::ShadowInputs in = shadow_inputs(c.settings, c.frame, stage.light, g);
    in.tiles = or_all(tiles);
    direct::run(c.settings.shadow, in, c.options, visibility);
    raster::quantise(c.settings.layout.visibility, visibility, size, c.options.threads);
    run.bytes = std::size_t(size.x) * std::size_t(size.y) * sizeof(float);
}

void cast_no_shadow(Context& c, const PlannedStage& stage, StageRun&) {
    const glm::ivec2 size = view_size(c, stage);
    std::fill_n(visibility_of(c, stage), std::size_t(size.x) * std::size_t(size.y), 1.0f);
}

Image4& direct_of(Context& c, const PlannedStage& stage) {
    return stage.view == 0 ? c.frame.direct : c.frame.views[std::size_t(stage.view)].direct;
}

void light_directly(Context& c, const PlannedStage& stage, StageRun& run) {
    const raster::GBuffer& g = gbuffer_of(c, stage);
    Buffer<float>& visibility = stage.view == 0 ? c.frame.visibility : c.frame.views[std::size_t(stage.view)].visibility;
    if (!casts_shadows(c.settings)) std::fill(visibility.begin(), visibility.end(), 1.0f);
    const raster::Covered tiles = tiles_to_shade(c.plan, c.frame, stage, run, &g.covered);
    direct::run(c.settings.direct,
                direct::DirectInputs{&g.position, &g.normal, &c.lights, &visibility, or_all(tiles),
                                     compose::reads_density(c.settings.compose)},
                c.options, direct_of(c, stage));
    run.bytes = bytes_of(direct_of(c, stage));
}

void light_nothing(Context& c, const PlannedStage& stage, StageRun&) {
    const glm::ivec2 size = view_size(c, stage);
    direct_of(c, stage) = Image4(size.x, size.y);
}

// VRSM fig. 4.4: each gather has a target of its own. No bound of what may be gathered at a point is of use, since points
// may touch texels: what does not fit is refused when it is found.
void store_irradiance(const Context& c, const PlannedStage& stage, Image4& irradiance) {
    const raster::Layout& layout = c.settings.layout;
    const std::optional<raster::Overflow> overflow = raster::quantise(layout.indirect, irradiance, c.options.threads);
    if (!overflow) return;
    throw InputError(
        fmt::format("{}: light \"{}\": pixel {},{}: indirect irradiance of {:.4g} W/m2 does not fit {} ({:g}), which "
                    "layout \"{}\" stores it in: use fp32, a larger min_distance or a weaker light",
                    stage.name, c.scene.lights[std::size_t(stage.light)].name, overflow->pixel.x, overflow->pixel.y,
                    overflow->value, info(layout.indirect).name, raster::range_of(layout.indirect).largest.x,
                    layout.name));
}

void gather(Context& c, const PlannedStage& stage, StageRun& run) {
    const std::size_t l = std::size_t(stage.light);
    const rsm::GatherParams& params = c.settings.rsm;
    const rsm::Pattern pattern = rsm::pattern_of(params, c.lights[l].rsm_size, c.settings.seed);
    const bool traces = stage.name == "rsm.all_rays";
    if (traces && !c.world.rays)
        c.world.rays = reference::build_ray_query(c.world.geometry, c.world.surfaces, params.rays);
    Image4 irradiance;
    rsm::RaysReport report;
    rsm::GatherInputs in = gather_inputs(c.scene, c.settings, c.frame, stage.light, c.world.geometry, pattern,
                                         c.world.rays.get());
    raster::Covered tiles, half;
    if (halves_indirect(c.settings)) half = covered_by(c.frame.half_normal);
    if (!traces) tiles = tiles_to_shade(c.plan, c.frame, stage, run, or_all(half));
    in.tiles = or_all(tiles);
    rsm::run_maps(params, in, c.frame.rsms[l], c.options, irradiance, &report);
    store_irradiance(c, stage, irradiance);
    add_gather(c, irradiance, report.standard_error);
    run.bytes = bytes_of(irradiance) + bytes_of(report.standard_error);
    // What was asked takes the place of what the plan could tell.
    if (traces) run.reason = run.reason.substr(0, run.reason.find("; subset of ")) + "; " + rsm::summary(report);
    if (!c.keeps) return;
    c.memory.irradiance[l] = std::move(irradiance);
    c.memory.irradiance_error[l] = std::move(report.standard_error);
}

// Before the first filter reads it, the sum gets the depth of its points (VRSM fig. 4.4).
void copy_depth(Context& c) {
    Image4& sum = c.frame.gathered;
    const Image4& position = halves_indirect(c.settings) ? c.frame.half_position : c.frame.gbuffer.position;
    for (std::size_t i = 0; i < sum.size(); ++i) sum.texels[i].w = position.texels[i].w;
}

void filter_indirect(Context& c, const PlannedStage& stage, StageRun& run) {
    Frame& f = c.frame;
    Image4& result = filter_result(f, c.settings, stage);
    if (stage.name == "filter.reduce") {
        filter::run(c.settings.indirect, filter::ReduceInputs{&reduce_input(f, stage)}, c.options, result);
    } else {
        copy_depth(c);
        const raster::Covered tiles = tiles_to_shade(c.plan, f, stage, run);
        filter::UpsampleInputs coarse = upsample_inputs(f);
        filter::BlurInputs sharp = blur_inputs(c.settings, f, stage);
        coarse.tiles = sharp.tiles = or_all(tiles);
        if (stage.name == "filter.upsample")
            filter::run(c.settings.indirect, coarse, c.options, result);
        else
            filter::run(c.settings.indirect, sharp, c.options, result);
    }
    run.bytes = bytes_of(result);
}

void filter_nothing(Context& c, const PlannedStage& stage, StageRun&) {
    const glm::ivec2 size = stage_size(c.settings, stage, c.size);
    Image4& result = filter_result(c.frame, c.settings, stage);
    result = Image4(size.x, size.y);
    if (stage.name == "filter.reduce") return;
    for (std::size_t i = 0; i < result.size(); ++i) result.texels[i].w = c.frame.gbuffer.position.texels[i].w;
}

// Squares of coarse pixels that a stage of gi/isr computes; isr.upsample's are the frame's.
raster::Covered isr_tiles(Context& c, const PlannedStage& stage, StageRun& run) {
    if (stage.name == "isr.upsample") return tiles_to_shade(c.plan, c.frame, stage, run);
    const raster::Covered coarse = covered_by(c.frame.isr.surface);
    return tiles_to_shade(c.plan, c.frame, stage, run, &coarse);
}

void note_excess(const Context& c, const Image4& gathered, StageRun& run) {
    const isr::Excess excess = isr::excess_of(c.frame.isr.surface, gathered);
    if (excess.share > 0)
        run.reason += fmt::format("; form factors sum to more than 1, at most {:.4g}, at {:.3g} % of the pixels", excess.largest,
                                  100 * excess.share);
}

void run_isr(Context& c, const PlannedStage& stage, StageRun& run) {
    const bool coarse = is_isr_gather(stage.name) || stage.name == "isr.ssao" || stage.name == "isr.blur";
    raster::Covered tiles;
    if (coarse || stage.name == "isr.upsample") tiles = isr_tiles(c, stage, run);
    Image4& result = isr_result(c.frame, stage);
    make_isr(c.scene, c.settings, c.frame, stage, c.options, result, or_all(tiles));
    if (is_isr_gather(stage.name)) note_excess(c, result, run);
    run.bytes = bytes_of(result);
}

// No light, and nothing occluded. What goes through isr.ssao goes on without it.
void run_no_isr(Context& c, const PlannedStage& stage, StageRun&) {
    const glm::ivec2 size = isr_size(c.scene, c.settings, stage);
    Image4& result = isr_result(c.frame, stage);
    if (stage.name == "isr.ssao" && !c.frame.isr.gathered.empty()) {
        result = c.frame.isr.gathered.back();
        return;
    }
    const bool open = stage.name == "isr.blur" || stage.name == "isr.upsample" || stage.name == "isr.ssao";
    result = Image4(size.x, size.y, glm::vec4(0, 0, 0, open ? 1 : 0));
}

void compose_radiance(Context& c, const PlannedStage&, StageRun& run) {
    const Frame& f = c.frame;
    compose::run(c.settings.compose,
                 compose::ComposeInputs{&f.gbuffer.normal, &f.gbuffer.albedo, &f.gbuffer.emission, &f.direct,
                                        &f.indirect, c.scene.environment.radiance},
                 c.options, c.frame.radiance);
    run.bytes = bytes_of(f.radiance);
}

void trace_paths(Context& c, const PlannedStage& stage, StageRun& run) {
    c.frame.traced.push_back(c.tracer.trace(stage.layer, c.frame.gbuffer, c.options));
    const Image4& mean = c.frame.traced.back().estimate.mean;
    if (stage.layer == "color") c.frame.radiance = mean;
    run.bytes = 2 * bytes_of(mean);
}

void trace_nothing(Context& c, const PlannedStage& stage, StageRun&) {
    c.frame.traced.push_back(c.tracer.dark(stage.layer));
}

void map_tones(Context& c, const PlannedStage&, StageRun& run) {
    compose::run(c.settings.tonemap, compose::TonemapInputs{&c.frame.radiance}, c.options, c.frame.display);
    run.bytes = bytes_of(c.frame.display);
}

}  // namespace

void add_gather(Context& c, const Image4& irradiance, const Image4& error) {
    if (c.sum_is_kept) return;
    add(filters_indirect(c.settings) ? c.frame.gathered : c.frame.indirect, irradiance);
    if (!error.empty()) add_errors(c.frame.indirect_error, error);
}

Kind kind_of(const PlannedStage& stage) {
    if (draws_view(stage.name)) return {draw_gbuffer, see_nothing};
    if (stage.name == "rsm") return {draw_maps, draw_no_map};
    if (stage.name == "shadow.blur") return {blur_maps, blur_no_map};
    if (stage.name == "shadow") return {cast_shadows, cast_no_shadow};
    if (stage.name == "direct") return {light_directly, light_nothing};
    if (is_gather(stage.name)) return {gather, nothing};
    if (is_filter(stage.name)) return {filter_indirect, filter_nothing};
    if (is_isr(stage.name)) return {run_isr, stage.name == "isr.compose" ? nothing : run_no_isr};
    if (stage.name == "compose") return {compose_radiance, nothing};
    if (stage.name == "reference") return {trace_paths, trace_nothing};
    return {map_tones, nothing};
}

std::vector<std::vector<Image4>>& map_blur_result(Frame& frame, const PlannedStage& stage) {
    return stage.form == "horizontal" ? frame.maps_blurred_across : frame.maps_blurred;
}

direct::LogBlurInputs map_blur_inputs(const Frame& frame, const PlannedStage& stage, std::size_t map) {
    const std::size_t l = std::size_t(stage.light);
    const bool first = stage.form == "horizontal";
    return {first ? &frame.rsms[l][map].position : &frame.maps_blurred_across[l][map],
            first ? direct::Direction::horizontal : direct::Direction::vertical, direct::depth_range(frame.rsms[l])};
}

direct::ShadowInputs shadow_inputs(const Settings& settings, const Frame& frame, int light,
                                   const raster::GBuffer& gbuffer) {
    const std::size_t l = std::size_t(light);
    direct::ShadowInputs in{&gbuffer.position, &gbuffer.normal, frame.rsms[l]};
    if (direct::blurs_maps(settings.shadow)) in.blurred = frame.maps_blurred[l];
    return in;
}

rsm::GatherInputs gather_inputs(const Scene& scene, const Settings& settings, const raster::GBuffer& gbuffer, int light,
                                const Geometry& geometry, const rsm::Pattern& pattern, const RayQuery* rays) {
    rsm::GatherInputs in{&gbuffer.position, &gbuffer.normal, nullptr, &pattern, settings.seed};
    if (settings.rsm.gather != rsm::Gather::all_rays) return in;
    glm::vec3 low(0), high(0);
    bounds(geometry, low, high);
    in.rays = rays;
    const glm::ivec2 size = scene.frame_size;
    const View view = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);
    in.offsets = rsm::ray_offsets(settings.layout, low, high, view, size);
    // Each light chooses for itself: their errors are independent.
    in.seed = std::uint32_t(pcg(std::int32_t(settings.seed) + pcg(std::int32_t(light))));
    return in;
}

rsm::GatherInputs gather_inputs(const Scene& scene, const Settings& settings, const Frame& frame, int light,
                                const Geometry& geometry, const rsm::Pattern& pattern, const RayQuery* rays) {
    rsm::GatherInputs in = gather_inputs(scene, settings, frame.gbuffer, light, geometry, pattern, rays);
    if (halves_indirect(settings)) in.position = &frame.half_position, in.normal = &frame.half_normal;
    return in;
}

}  // namespace plumb::frame
