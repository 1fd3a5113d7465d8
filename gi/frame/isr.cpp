#include "gi/frame/isr.h"

#include <fmt/format.h>

#include <algorithm>
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

// A camera turned about the point that it looks at: to the right, to the left, upwards, downwards.
Camera turned(const Camera& camera, int which, double angle_deg) {
    const CameraAxes a = axes(camera);
    const glm::dvec3 axis = which < 2 ? a.up : a.right;
    const double angle = (which % 2 == 0 ? 1 : -1) * (which < 2 ? 1 : -1) * angle_deg * (host::pi / 180);
    const double cosine = host::cos(angle), sine = host::sin(angle);
    auto rotate = [&](const glm::dvec3& v) {
        const double along = axis.x * v.x + axis.y * v.y + axis.z * v.z;
        const glm::dvec3 across(axis.y * v.z - axis.z * v.y, axis.z * v.x - axis.x * v.z, axis.x * v.y - axis.y * v.x);
        return v * cosine + across * sine + axis * (along * (1 - cosine));
    };
    Camera other = camera;
    other.position = camera.look_at + rotate(camera.position - camera.look_at);
    other.up = rotate(a.up);
    return other;
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

std::string place_of_view(const IsrView& view) { return view.kind == ViewKind::own ? "frame" : view.name; }

std::string bounce_form(int bounce) { return bounce == 1 ? "" : fmt::format("bounce {}", bounce); }
int bounce_of(const PlannedStage& stage) {
    return stage.form.empty() ? 1 : std::stoi(stage.form.substr(stage.form.find(' ') + 1));
}

}  // namespace

bool is_isr_gather(const std::string& stage) { return stage == "isr.gather" || stage == "isr.gather_camera"; }

bool draws_view(const std::string& stage) { return stage == "gbuffer" || stage == "gbuffer.layer"; }

const Image1* peeled_depth(const Scene& scene, const Settings& settings, const Frame& frame, int view) {
    const IsrView layer = isr_views(scene, settings)[std::size_t(view)];
    if (layer.kind != ViewKind::layer) return nullptr;
    return &raster::peeled_depth(layer.behind == 0 ? frame.gbuffer : frame.views[std::size_t(layer.behind)].gbuffer);
}

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
    // Layers lie behind the widest view, each behind the one before.
    for (int layer = 2; layer <= settings.isr.layers; ++layer) {
        IsrView next = views.back();
        next.kind = ViewKind::layer, next.name = fmt::format("layer {}", layer);
        next.behind = int(views.size()) - 1;
        views.push_back(next);
    }
    // Half the frame's resolution: what they add is seen at grazing angles, or not at all (ISR chapter 6).
    for (int i = 0; i < settings.isr.cameras; ++i)
        views.push_back({ViewKind::camera, fmt::format("camera {}", i + 1),
                         turned(scene.camera, i, double(settings.isr.camera_angle)), (scene.frame_size + 1) / 2});
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
    // Of a camera's surfaces those remain that no view before it sees.
    int unseen = 0;
    for (int v = 0; v < int(views.size()); ++v)
        for (const int other : sources)
            if (views[std::size_t(v)].kind == ViewKind::camera && other < v)
                stages.push_back({"isr.unseen", place_of_view(views[std::size_t(other)]), v, unseen++, other});
    if (p.bounces > 1) stages.push_back({"isr.downsample", "reflectance"});
    int pass = 0;
    for (int bounce = 1; bounce <= p.bounces; ++bounce) {
        if (bounce > 1) stages.push_back({"isr.bounce", bounce_form(bounce), sources.front(), bounce - 2});
        for (const int view : sources) {
            const bool camera = views[std::size_t(view)].kind == ViewKind::camera;
            stages.push_back({camera ? "isr.gather_camera" : "isr.gather", bounce_form(bounce), view, pass++});
        }
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
    const bool of_source =
        stage.name == "isr.downsample" || stage.name == "isr.bounce" || stage.name == "isr.unseen";
    if (!of_source) return isr::coarse_size(scene.frame_size);
    return isr::coarse_size(isr_views(scene, settings)[std::size_t(stage.view)].size);
}

std::string isr_place(const PlannedStage& stage) {
    if (stage.name == "isr.upsample") return "indirect";
    if (stage.name == "isr.compose") return "radiance";
    if (is_isr_gather(stage.name) || stage.name == "isr.bounce" || stage.name == "isr.unseen") return fmt::format("{} {}", stage.name, stage.pass);
    return fmt::format("{} {} {}", stage.name, stage.form, stage.view);
}

Image4& isr_result(Frame& frame, const PlannedStage& stage) {
    IsrBuffers& b = frame.isr;
    if (stage.name == "isr.upsample") return frame.indirect;
    if (stage.name == "isr.compose") return frame.radiance;
    if (stage.name == "isr.ssao") return b.lit;
    if (stage.name == "isr.blur") return stage.form == "horizontal" ? b.blurred_across : b.blurred;
    if (is_isr_gather(stage.name) || stage.name == "isr.bounce" || stage.name == "isr.unseen") {
        std::vector<Image4>& passes = is_isr_gather(stage.name)     ? b.gathered
                                      : stage.name == "isr.bounce" ? b.radiosities
                                                                   : b.unseen;
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
    isr::DownsampleInputs in{coarse_of(stage.form), &g.position, &g.normal, &g.albedo, &g.emission,
                             view ? &view->direct : &frame.direct};
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

isr::UnseenInputs unseen_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                const PlannedStage& stage) {
    const std::vector<IsrView> views = isr_views(scene, settings);
    const auto stages = isr_stages(scene, settings);
    const auto same = [&](const IsrStage& s) { return s.name == stage.name && s.pass == stage.pass; };
    const int other = std::find_if(stages.begin(), stages.end(), same)->other;
    const IsrView& camera = views[std::size_t(stage.view)];
    const IsrView& view = views[std::size_t(other)];
    // The first pass of a camera reads its surface, the next what is left of it.
    const bool first = stage.pass == 0 || other == sources_of(views).front();
    isr::UnseenInputs in;
    in.surface = first ? &surface_of(frame, stage.view) : &frame.isr.unseen[std::size_t(stage.pass - 1)];
    in.camera = isr::coarse_camera(camera.camera, camera.size);
    in.view_surface = &surface_of(frame, other);
    in.view = view.kind == ViewKind::camera ? isr::coarse_camera(view.camera, view.size)
                                            : isr::coarse_camera(scene.camera, scene.frame_size);
    in.margin = view.margin;
    return in;
}

isr::CameraGatherInputs camera_gather_inputs(const Scene& scene, const Settings& settings, const Frame& frame,
                                             const PlannedStage& stage, const isr::Pattern& pattern) {
    const IsrView camera = isr_views(scene, settings)[std::size_t(stage.view)];
    int unseen = -1;  // the last pass of isr.unseen for this camera
    for (const IsrStage& s : isr_stages(scene, settings))
        if (s.name == "isr.unseen" && s.view == stage.view) unseen = s.pass;
    isr::CameraGatherInputs in;
    in.surface = &frame.isr.surface;
    in.camera = isr::coarse_camera(scene.camera, scene.frame_size);
    in.source_surface = &frame.isr.unseen[std::size_t(unseen)];
    in.source_radiosity = &frame.views[std::size_t(stage.view)].radiosity;
    in.source_camera = isr::coarse_camera(camera.camera, camera.size);
    in.before = &frame.isr.gathered[std::size_t(stage.pass - 1)];
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

void make_isr(const Scene& scene, const Settings& settings, const Frame& frame, const PlannedStage& stage,
              const RunOptions& options, Image4& result, const raster::Covered* tiles) {
    const isr::IsrParams& params = settings.isr;
    auto run = [&](auto in) {
        if constexpr (requires { in.tiles; }) in.tiles = tiles;
        isr::run(params, in, options, result);
    };
    if (stage.name == "isr.downsample")
        return run(downsample_inputs(scene, frame, stage));
    if (stage.name == "isr.unseen") return run(unseen_inputs(scene, settings, frame, stage));
    if (stage.name == "isr.bounce") return run(bounce_inputs(scene, settings, frame, stage));
    if (stage.name == "isr.blur") return run(isr_blur_inputs(settings, frame, stage));
    if (stage.name == "isr.upsample") return run(upsample_inputs(scene, settings, frame));
    if (stage.name == "isr.compose") return run(compose_inputs(scene, frame));
    const isr::Pattern pattern = stage.name == "isr.ssao" ? isr::ssao_pattern(params) : isr::gather_pattern(params);
    if (stage.name == "isr.gather") return run(gather_inputs(scene, settings, frame, stage, pattern));
    if (stage.name == "isr.gather_camera") return run(camera_gather_inputs(scene, settings, frame, stage, pattern));
    run(ssao_inputs(scene, settings, frame, pattern));
}

void begin_views(const Scene& scene, const Settings& settings, Frame& frame) {
    std::size_t gathers = 0, bounces = 0, unseen = 0;
    for (const IsrStage& stage : isr_stages(scene, settings)) {
        if (is_isr_gather(stage.name)) ++gathers;
        if (stage.name == "isr.bounce") ++bounces;
        if (stage.name == "isr.unseen") ++unseen;
    }
    frame.isr.gathered.resize(gathers), frame.isr.radiosities.resize(bounces), frame.isr.unseen.resize(unseen);
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
    const bool beside = settings.isr.layers > 1 || settings.isr.cameras > 0;
    if (settings.isr.variant == isr::Variant::published && beside)
        throw InputError(fmt::format("{}: [isr] variant = published with layers = {}, cameras = {}: ISR prints no equation "
                                     "for them: expected 1 and 0", scene.name, settings.isr.layers, settings.isr.cameras));
    for (const IsrView& view : isr_views(scene, settings))
        if (view.size.x > 32767 || view.size.y > 32767)
            throw InputError(fmt::format("{}: [isr] guard = {}: {} x {} pixels with it: expected at most 32767 a side",
                                         scene.name, settings.isr.guard, view.size.x, view.size.y));
}

}  // namespace plumb::frame
