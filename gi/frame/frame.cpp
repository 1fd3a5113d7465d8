#include "gi/frame/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/hash.h"
#include "gi/reference/ray_query.h"
#include "gi/rsm/all_rays.h"
#include "raster/hemicube.h"
#include "raster/light_view.h"
#include "raster/texture_space.h"
#include "raster/workspace.h"

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

// A G-buffer that sees nothing: what the pass would write for an empty scene.
raster::GBuffer nothing_seen(glm::ivec2 size, bool reversed_z) {
    raster::GBuffer g;
    g.position = g.normal = g.albedo = g.emission = Image4(size.x, size.y);
    g.depth = Image1(size.x, size.y, reversed_z ? 0.0f : 1.0f);
    g.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
    return g;
}

// A light that does not shine has no intensity: running its stages adds zeros.
Light shining(Light light) {
    if (!light.on) light.intensity = glm::vec3(0);
    return light;
}

// All maps of a light; a face that can see nothing is left out.
void draw_maps(const Geometry& geometry, const raster::Surfaces& surfaces, const Light& light, const glm::vec3& low,
               const glm::vec3& high, const raster::Layout& layout, const RunOptions& options,
               std::vector<raster::Rsm>& maps, raster::Workspace& workspace) {
    const std::vector<View> views = raster::light_views(light, low, high);
    for (std::size_t m = 0; m < views.size(); ++m) {
        if (views.size() > 1 && !raster::may_see(views[m], low, high)) continue;
        RunOptions part = options;
        if (options.progress)
            part.progress = [&, m](double done) { options.progress((double(m) + done) / double(views.size())); };
        raster::draw_rsm(geometry, surfaces, light, views[m], layout, part, maps[m], &workspace);
    }
}

// Buffers that were not wanted are 0 where others read them.
void fill_unwanted(glm::ivec2 size, raster::GBuffer& g) {
    for (Image4* image : {&g.position, &g.normal, &g.albedo, &g.emission})
        if (image->empty()) *image = Image4(size.x, size.y);
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

std::vector<StageInfo> frame_stages() {
    return {raster::info_gbuffer(), raster::info_rsm(),    direct::shadow_info(),   rsm::info_disc(),
            rsm::info_all(),        rsm::info_all_rays(),  direct::direct_info(),   compose::compose_info(),
            reference::info(),      compose::tonemap_info()};
}

}  // namespace

Frame execute(const Scene& scene, const Settings& settings, const Plan& plan, const RunOptions& given,
              const Progress& progress, reference::Store* store) {
    FpEnvironment environment;
    const Geometry geometry = flatten(scene);
    const raster::Surfaces surfaces = raster::prepare(scene, geometry);
    const glm::ivec2 size = scene.frame_size;
    const std::size_t pixels = std::size_t(size.x) * size.y;
    glm::vec3 low(0), high(0);
    bounds(geometry, low, high);

    raster::Workspace workspace;
    std::unique_ptr<RayQuery> rays;  // built for the first stage that traces
    Frame f;
    f.gbuffer = nothing_seen(size, scene.camera.reversed_z);
    for (const Light& light : scene.lights) f.rsms.emplace_back(raster::map_count(light));
    f.visibility.assign(scene.lights.size() * pixels, 1.0f);
    f.direct = f.indirect = Image4(size.x, size.y);
    std::vector<Light> lights;
    for (const Light& light : scene.lights) lights.push_back(shining(light));

    Tracer tracer(scene, settings, geometry, store);
    for (const PlannedStage& stage : plan.stages) {
        StageRun run{stage.label, stage.needed, stage.reason};
        if (!stage.needed) {
            if (stage.name == "reference") f.traced.push_back(tracer.dark(stage.layer));
            f.stages.push_back(run);
            continue;
        }
        RunOptions options = given;
        if (progress) {
            progress(stage.label, 0);
            options.progress = [&](double done) { progress(stage.label, done); };
        }
        const auto start = std::chrono::steady_clock::now();
        const int l = stage.light;
        if (stage.name == "gbuffer") {
            const View view = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);
            raster::draw_gbuffer(geometry, surfaces, view, size, settings.layout, options, f.gbuffer, plan.gbuffer,
                                 &workspace);
            fill_unwanted(size, f.gbuffer);
            run.bytes = bytes_of(f.gbuffer);
        } else if (stage.name == "rsm") {
            draw_maps(geometry, surfaces, lights[l], low, high, settings.layout, options, f.rsms[l], workspace);
            for (const raster::Rsm& map : f.rsms[l]) run.bytes += bytes_of(map);
        } else if (stage.name == "shadow") {
            direct::run(settings.shadow, {&f.gbuffer.position, &f.gbuffer.normal, f.rsms[l]}, options,
                        f.visibility.data() + l * pixels);
            run.bytes = pixels * sizeof(float);
        } else if (stage.name == "direct") {
            direct::run({&f.gbuffer.position, &f.gbuffer.normal, &lights, &f.visibility}, options, f.direct);
            run.bytes = bytes_of(f.direct);
        } else if (is_gather(stage.name)) {
            rsm::Pattern pattern;  // only rsm.disc reads one
            if (stage.name == "rsm.disc") pattern = rsm::disc_pattern(settings.rsm, lights[l].rsm_size, settings.seed);
            const bool traces = stage.name == "rsm.all_rays";
            if (traces && !rays) rays = reference::build_ray_query(geometry, surfaces, settings.rsm.rays);
            Image4 irradiance;
            rsm::RaysReport report;
            rsm::run_maps(settings.rsm, gather_inputs(scene, settings, f.gbuffer, l, geometry, pattern, rays.get()),
                          f.rsms[l], options, irradiance, &report);
            add(f.indirect, irradiance);
            run.bytes = bytes_of(irradiance) + bytes_of(report.standard_error);
            if (traces) {
                add_errors(f.indirect_error, report.standard_error);
                // What was asked takes the place of what the plan could tell.
                run.reason = run.reason.substr(0, run.reason.find("; subset of ")) + "; " + rsm::summary(report);
            }
        } else if (stage.name == "compose") {
            compose::run({&f.gbuffer.normal, &f.gbuffer.albedo, &f.gbuffer.emission, &f.direct, &f.indirect,
                          scene.environment.radiance},
                         options, f.radiance);
            run.bytes = bytes_of(f.radiance);
        } else if (stage.name == "reference") {
            f.traced.push_back(tracer.trace(stage.layer, f.gbuffer, options));
            const Image4& mean = f.traced.back().estimate.mean;
            if (stage.layer == "color") f.radiance = mean;
            if (stage.layer == "truth") compose::run(settings.tonemap, mean, given, f.truth_display);
            run.bytes = 2 * bytes_of(mean);
        } else {
            compose::run(settings.tonemap, f.radiance, options, f.display);
            run.bytes = bytes_of(f.display);
        }
        run.isa = last_dispatched_isa();
        run.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        f.stages.push_back(run);
    }
    return f;
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

bool is_gather(const std::string& stage) {
    for (auto gather : {rsm::Gather::disc, rsm::Gather::all, rsm::Gather::all_rays})
        if (stage == rsm::stage_name(gather)) return true;
    return false;
}

const Traced* find_traced(const Frame& frame, const std::string& layer) {
    for (const Traced& traced : frame.traced)
        if (traced.layer == layer) return &traced;
    return nullptr;
}

std::vector<StageInfo> all_stages() {
    std::vector<StageInfo> all = frame_stages();
    all.push_back(raster::info_hemicube());
    all.push_back(raster::info_texture_space());
    return all;
}

bool in_a_frame(const std::string& stage) {
    const std::vector<StageInfo> stages = frame_stages();
    return std::any_of(stages.begin(), stages.end(), [&](const StageInfo& s) { return s.name == stage; });
}

}  // namespace plumb::frame
