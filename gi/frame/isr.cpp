#include "gi/frame/isr.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/bake.h"
#include "gi/screen/lobe.h"
#include "raster/gbuffer.h"

namespace plumb::frame {

namespace {

// Angle of view of the frame with `guard` pixels more on each side, of the same size as the frame's.
double guarded_fov_deg(double fov_y_deg, int height, int guard) {
    const double to_radians = host::pi / 180;
    const double half = fov_y_deg * to_radians / 2;
    return 2 * host::atan(host::tan(half) * (height + 2.0 * guard) / height) / to_radians;
}

// The median of the linear depths that the frame shows, of a picture of few pixels; where it shows nothing, the distance of the
// point that the camera looks at. `look_at` itself says a direction: how far along it lies is nothing that anyone sees.
double median_depth(const Scene& scene) {
    constexpr glm::ivec2 few(64, 48);
    const Geometry geometry = flatten(scene);
    const View view = make_view(scene.camera, double(scene.frame_size.x) / scene.frame_size.y);
    raster::GBuffer g;
    RunOptions options;
    options.threads = 1;
    raster::draw_gbuffer(geometry, raster::prepare(scene, geometry), view, few, raster::Layout::fp32, options, g);
    std::vector<float> depths;
    for (std::size_t i = 0; i < g.normal.size(); ++i)
        if (g.normal.texels[i].w > 0) depths.push_back(g.position.texels[i].w);
    const glm::dvec3 to = scene.camera.look_at - scene.camera.position;
    if (depths.empty()) return std::sqrt(to.x * to.x + to.y * to.y + to.z * to.z);
    const auto middle = depths.begin() + std::ptrdiff_t(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return double(*middle);
}

// A camera turned about the point in the middle of its picture at that depth: to the right, to the left, upwards, downwards.
Camera turned(const Camera& camera, double depth, int which, double angle_deg) {
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
    other.look_at = camera.position + a.forward * depth;
    other.position = other.look_at + rotate(a.forward * -depth);
    other.up = rotate(a.up);
    return other;
}

}  // namespace

bool gathers_isr(const Settings& settings) {
    return settings.method == Method::isr && (settings.isr.mode == isr::Mode::f2 || settings.isr.mode == isr::Mode::f3);
}

bool lights_probes(const Settings& settings) { return settings.method == Method::probes; }

bool solves_radiosity(const Settings& settings) { return settings.method == Method::radiosity; }

bool filters_shadows(const Settings& settings) {
    return settings.shadow.filter != direct::VisibilityFilter::none && casts_shadows(settings);
}

bool casts_shadows(const Settings& settings) {
    if (settings.method == Method::zbuffer) return false;
    return settings.method != Method::isr || settings.isr.mode == isr::Mode::f2 || settings.isr.mode == isr::Mode::f4;
}

bool reflects_maps(const Settings& settings) {
    return reflects(settings) && settings.reflect.views == screen::ReflectViews::lights && casts_shadows(settings);
}

int views_before_mirrors(const std::vector<IsrView>& views) {
    return int(std::count_if(views.begin(), views.end(), [](const IsrView& v) {
        return v.kind != ViewKind::mirror_layer && v.kind != ViewKind::mirrored;
    }));
}

std::vector<IsrView> isr_views(const Scene& scene, const Settings& settings) {
    std::vector<IsrView> views{{ViewKind::own, "", scene.camera, scene.frame_size}};
    if (lights_probes(settings)) {
        const probes::BakeParams& p = settings.probes;
        const glm::ivec2 size = settings.bake ? glm::ivec2(settings.bake->relight.rays, settings.bake->relight.probes)
                                              : glm::ivec2(p.relight_rays, p.placement.count > 0 ? p.placement.count : p.placement.least);
        views.push_back({ViewKind::probe_rays, "probe rays", scene.camera, size});
    }
    // The layers in which mirrored rays are followed, each behind the one before; and what rays meet there and in maps: last.
    const auto with_mirrored = [&] {
        const int layers = reflects(settings) ? settings.reflect.layers : 0;
        for (int layer = 2; layer <= layers + 1; ++layer)
            views.push_back({ViewKind::mirror_layer, fmt::format("mirrored layer {}", layer), scene.camera, scene.frame_size, 0,
                             layer == 2 ? 0 : int(views.size()) - 1});
        if (layers > 0 || reflects_maps(settings)) {
            const glm::ivec2 sheet = screen::sheet_of(scene.frame_size, screen::lobe_blocks(settings.reflect));
            views.push_back({ViewKind::mirrored, "mirrored", scene.camera, sheet});
        }
        return views;
    };
    if (!gathers_isr(settings)) return with_mirrored();
    const int guard = settings.isr.guard;
    if (guard > 0) {
        IsrView wide{ViewKind::guard, "guard", scene.camera, scene.frame_size + 2 * guard,
                     guard / isr::coarse_side(settings.isr)};
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
    const double pivot = settings.isr.cameras > 0 ? median_depth(scene) : 0;
    for (int i = 0; i < settings.isr.cameras; ++i)
        views.push_back({ViewKind::camera, fmt::format("camera {}", i + 1),
                         turned(scene.camera, pivot, i, double(settings.isr.camera_angle)), (scene.frame_size + 1) / 2});
    return with_mirrored();
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
