#include "gi/frame/isr.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/hash.h"

namespace plumb::frame {

namespace {

// Angle of view of the frame with `guard` pixels more on each side, of the same size as the frame's.
double guarded_fov_deg(double fov_y_deg, int height, int guard) {
    const double to_radians = host::pi / 180;
    const double half = fov_y_deg * to_radians / 2;
    return 2 * host::atan(host::tan(half) * (height + 2.0 * guard) / height) / to_radians;
}

// Views whose surfaces send light, in the order in which they are gathered: the wider view takes the frame's place.
std::vector<int> sources_of(const std::vector<IsrView>& views) {
    std::vector<int> sources;
    for (int v = 0; v < int(views.size()); ++v)
        if (v > 0 || views.size() < 2 || views[1].kind != ViewKind::guard) sources.push_back(v);
    return sources;
}

const Image4& surface_of(const Frame& frame, int view) {
    return view == 0 ? frame.isr.surface : frame.views[std::size_t(view)].surface;
}

std::string bounce_form(int bounce) { return bounce == 1 ? "" : fmt::format("bounce {}", bounce); }
int bounce_of(const PlannedStage& stage) {
    return stage.form.empty() ? 1 : std::stoi(stage.form.substr(stage.form.find(' ') + 1));
}

}  // namespace

bool is_isr(const std::string& stage) { return stage.rfind("isr.", 0) == 0; }

std::string isr_work(const PlannedStage& stage) {
    if (stage.name == "isr.compose") return "compose";
    if (stage.name == "isr.ssao") return "isr.ssao";
    const bool lit = stage.name == "isr.blur" || stage.name == "isr.upsample" || stage.form == "surface";
    return lit ? "isr.lit" : "isr";
}

bool gathers_isr(const Settings& settings) {
    return settings.method == Method::isr && (settings.isr.mode == isr::Mode::f2 || settings.isr.mode == isr::Mode::f3);
}

bool casts_shadows(const Settings& settings) {
    return settings.method != Method::isr || settings.isr.mode == isr::Mode::f2 || settings.isr.mode == isr::Mode::f4;
}

std::vector<IsrView> isr_views(const Scene& scene, const Settings& settings) {
    std::vector<IsrView> views{{ViewKind::own, "", scene.camera, scene.frame_size}};
    if (!gathers_isr(settings)) return views;
    const int guard = settings.isr.guard;
    if (guard > 0) {
        IsrView wide{ViewKind::guard, "guard", scene.camera, scene.frame_size + 2 * guard, guard / 2};
        wide.camera.fov_y_deg = guarded_fov_deg(scene.camera.fov_y_deg, scene.frame_size.y, guard);
        views.push_back(wide);
    }
    return views;
}

std::vector<IsrStage> isr_stages(const Scene& scene, const Settings& settings) {
    std::vector<IsrStage> stages;
    if (!gathers_isr(settings)) return stages;
    const std::vector<IsrView> views = isr_views(scene, settings);
    const std::vector<int> sources = sources_of(views);
    const isr::IsrParams& p = settings.isr;
    for (int v = 0; v < int(views.size()); ++v) {
        stages.push_back({"isr.downsample", "surface", v});
        if (v > 0 || sources.front() == 0) stages.push_back({"isr.downsample", "radiosity", v});
    }
    if (p.bounces > 1) stages.push_back({"isr.downsample", "reflectance"});
    int pass = 0;
    for (int bounce = 1; bounce <= p.bounces; ++bounce) {
        if (bounce > 1) stages.push_back({"isr.bounce", bounce_form(bounce), sources.front(), bounce - 2});
        for (const int view : sources) stages.push_back({"isr.gather", bounce_form(bounce), view, pass++});
    }
    stages.push_back({"isr.ssao", ""});
    if (p.blur != isr::Blur::none) {
        stages.push_back({"isr.blur", "horizontal"});
        stages.push_back({"isr.blur", "vertical"});
    }
    stages.push_back({"isr.upsample", ""});
    return stages;
}

glm::ivec2 isr_size(const Scene& scene, const Settings& settings, const PlannedStage& stage) {
    if (stage.name == "isr.upsample" || stage.name == "isr.compose") return scene.frame_size;
    const bool of_source = stage.name == "isr.downsample" || stage.name == "isr.bounce";
    if (!of_source) return isr::coarse_size(scene.frame_size);
    return isr::coarse_size(isr_views(scene, settings)[std::size_t(stage.view)].size);
}

std::string isr_place(const PlannedStage& stage) {
    if (stage.name == "isr.upsample") return "indirect";
    if (stage.name == "isr.compose") return "radiance";
    if (stage.name == "isr.gather" || stage.name == "isr.bounce") return fmt::format("{} {}", stage.name, stage.pass);
    return fmt::format("{} {} {}", stage.name, stage.form, stage.view);
}

Image4& isr_result(Frame& frame, const PlannedStage& stage) {
    IsrBuffers& b = frame.isr;
    if (stage.name == "isr.upsample") return frame.indirect;
    if (stage.name == "isr.compose") return frame.radiance;
    if (stage.name == "isr.ssao") return b.lit;
    if (stage.name == "isr.blur") return stage.form == "horizontal" ? b.blurred_across : b.blurred;
    if (stage.name == "isr.gather" || stage.name == "isr.bounce") {
        std::vector<Image4>& passes = stage.name == "isr.gather" ? b.gathered : b.radiosities;
        if (passes.size() <= std::size_t(stage.pass)) passes.resize(std::size_t(stage.pass) + 1);
        return passes[std::size_t(stage.pass)];
    }
    if (stage.view > 0) {
        SourceView& view = frame.views[std::size_t(stage.view)];
        return stage.form == "surface" ? view.surface : view.radiosity;
    }
    return stage.form == "surface" ? b.surface : stage.form == "radiosity" ? b.radiosity : b.reflectance;
}

const Image4& isr_result(const Frame& frame, const PlannedStage& stage) {
    return isr_result(const_cast<Frame&>(frame), stage);
}

isr::Coarse coarse_of(const std::string& form) {
    return form == "surface" ? isr::Coarse::surface
                             : form == "radiosity" ? isr::Coarse::radiosity : isr::Coarse::reflectance;
}

isr::DownsampleInputs downsample_inputs(const Scene& scene, const Frame& frame, const PlannedStage& stage) {
    const SourceView* view = stage.view > 0 ? &frame.views[std::size_t(stage.view)] : nullptr;
    const raster::GBuffer& g = view ? view->gbuffer : frame.gbuffer;
    isr::DownsampleInputs in{&g.position, &g.normal, &g.albedo, &g.emission, view ? &view->direct : &frame.direct};
    in.near = scene.camera.near, in.far = scene.camera.far;
    return in;
}

isr::GatherInputs gather_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                const PlannedStage& stage, const isr::Pattern& pattern) {
    const std::vector<IsrView> views = isr_views(scene, settings);
    const std::vector<int> sources = sources_of(views);
    const int bounce = bounce_of(stage);
    const bool first = stage.view == sources.front();
    isr::GatherInputs in;
    in.surface = &frame.isr.surface;
    in.source_surface = &surface_of(frame, stage.view);
    in.source_radiosity = stage.view == 0 ? &frame.isr.radiosity : &frame.views[std::size_t(stage.view)].radiosity;
    if (bounce > 1 && first) in.source_radiosity = &frame.isr.radiosities[std::size_t(bounce - 2)];
    if (!first) in.before = &frame.isr.gathered[std::size_t(stage.pass - 1)];
    in.camera = isr::coarse_camera(scene.camera, scene.frame_size);
    in.margin = views[std::size_t(stage.view)].margin;
    in.pattern = &pattern;
    in.seed = settings.seed;
    return in;
}

isr::SsaoInputs ssao_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                            const isr::Pattern& pattern) {
    const std::vector<IsrView> views = isr_views(scene, settings);
    const int source = sources_of(views).front();
    isr::SsaoInputs in;
    in.surface = &frame.isr.surface;
    in.source_surface = &surface_of(frame, source);
    in.gathered = frame.isr.gathered.empty() ? nullptr : &frame.isr.gathered.back();
    in.camera = isr::coarse_camera(scene.camera, scene.frame_size);
    in.margin = views[std::size_t(source)].margin;
    in.pattern = &pattern;
    // Rotations of their own.
    in.seed = std::uint32_t(pcg(std::int32_t(settings.seed)));
    return in;
}

isr::BounceInputs bounce_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                const PlannedStage& stage) {
    const std::vector<IsrView> views = isr_views(scene, settings);
    const int sources = int(sources_of(views).size()), bounce = bounce_of(stage);
    isr::BounceInputs in;
    in.radiosity = stage.view == 0 ? &frame.isr.radiosity : &frame.views[std::size_t(stage.view)].radiosity;
    in.reflectance = &frame.isr.reflectance;
    in.gathered = &frame.isr.gathered[std::size_t((bounce - 1) * sources - 1)];
    in.margin = views[std::size_t(stage.view)].margin;
    return in;
}

isr::BlurInputs isr_blur_inputs(const Settings&, const Frame& frame, const PlannedStage& stage) {
    const bool across = stage.form == "horizontal";
    isr::BlurInputs in{across ? &frame.isr.lit : &frame.isr.blurred_across, &frame.isr.surface};
    in.direction = across ? isr::Direction::horizontal : isr::Direction::vertical;
    return in;
}

isr::UpsampleInputs upsample_inputs(const Scene& scene, const Settings& settings, const Frame& frame) {
    isr::UpsampleInputs in{settings.isr.blur == isr::Blur::none ? &frame.isr.lit : &frame.isr.blurred,
                           &frame.isr.surface, &frame.gbuffer.position, &frame.gbuffer.normal};
    in.near = scene.camera.near, in.far = scene.camera.far;
    return in;
}

isr::ComposeInputs compose_inputs(const Scene& scene, const Frame& frame) {
    const raster::GBuffer& g = frame.gbuffer;
    return {&g.normal, &g.albedo, &g.emission, &frame.direct, &frame.indirect, scene.environment.radiance};
}

void begin_views(const Scene& scene, const Settings& settings, Frame& frame) {
    std::size_t gathers = 0, bounces = 0;
    for (const IsrStage& stage : isr_stages(scene, settings)) {
        if (stage.name == "isr.gather") ++gathers;
        if (stage.name == "isr.bounce") ++bounces;
    }
    frame.isr.gathered.resize(gathers), frame.isr.radiosities.resize(bounces);
    const std::vector<IsrView> views = isr_views(scene, settings);
    if (views.size() < 2) {
        frame.views.clear();
        return;
    }
    frame.views.resize(views.size());
    for (std::size_t v = 1; v < views.size(); ++v) {
        SourceView& view = frame.views[v];
        view.name = views[v].name, view.camera = views[v].camera, view.size = views[v].size;
        view.visibility.resize(scene.lights.size() * std::size_t(view.size.x) * std::size_t(view.size.y));
    }
}

void check_isr(const Scene& scene, const Settings& settings) {
    if (settings.method != Method::isr) return;
    try {
        isr::validate(settings.isr);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", scene.name, error.what()));
    }
    if (!gathers_isr(settings)) return;
    const bool reads_far = settings.isr.variant == isr::Variant::published ||
                           settings.isr.position == isr::Position::inverse_matrix;
    if (reads_far && !std::isfinite(scene.camera.far))
        throw InputError(fmt::format("{}: [isr] {}: depths over the far plane are asked for, and the camera's far is "
                                     "infinite: expected a finite one", scene.name,
                                     settings.isr.variant == isr::Variant::published ? "variant = published"
                                                                                     : "position = inverse_matrix"));
    for (const IsrView& view : isr_views(scene, settings))
        if (view.size.x > 32767 || view.size.y > 32767)
            throw InputError(fmt::format("{}: [isr] guard = {}: {} x {} pixels with it: expected at most 32767 a side",
                                         scene.name, settings.isr.guard, view.size.x, view.size.y));
}

}  // namespace plumb::frame
