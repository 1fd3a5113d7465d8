// plumb experiment ipr: one setting, from its bake to what its picture is off by.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/content_hasher.h"
#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lit_hits.h"
#include "gi/probes/sky_probe.h"
#include "tools/experiments/ipr.h"
#include "tools/experiments/ipr_pictures.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::string key_of(probes::BakeParams params) {
    std::string key;
    for (const Field& f : probes::fields(params)) key += f.name + "=" + value_text(f) + ";";
    return key;
}

std::size_t bytes_of_update(const frame::ProbeBuffers& p) {
    const auto texels = [](const Image4& image) { return image.size() * sizeof(glm::vec4); };
    return (p.data.matrix.size() + p.data.u.size()) * sizeof(float) + texels(p.lambda) + texels(p.basis) +
           std::size_t(p.data.count()) * sizeof(glm::vec4) + texels(p.lightmap);
}

compare::Plane shown_at(const frame::ProbeBuffers& p, const std::vector<int>& receivers) {
    Image4 row(int(receivers.size()), 1);
    for (std::size_t i = 0; i < receivers.size(); ++i)
        row.texels[i] = p.irradiance.texels[std::size_t(p.data.place_of[std::size_t(receivers[i])])];
    return compare::luminances(row);
}

}  // namespace

probes::UpdateBuffers update_buffers(frame::ProbeBuffers& p, const Image4& direct, const probes::RunParams& run) {
    probes::UpdateBuffers b;
    b.data = &p.data, b.harmonics = &p.harmonics, b.weights = &p.weights;
    b.probe_level = &p.probe_level, b.cluster_level = &p.cluster_level;
    b.counts = {p.lod.levels, p.lod.rays, p.lod.coefficients};
    b.feedback = run.feedback, b.constant = run.reflection;
    b.surface = &p.surface, b.emitted = &p.emitted, b.place = &p.place, b.direct = &direct;
    b.last_lightmap = &p.before, b.read_lambda = &p.lambda, b.read_basis = &p.basis;
    b.radiance = &p.radiance, b.lambda = &p.lambda, b.basis = &p.basis, b.irradiance = &p.irradiance, b.lightmap = &p.lightmap;
    return b;
}

IprErrors ipr_errors(const compare::Plane& own, const compare::Plane& truth, const compare::Plane& error, const Image<std::uint8_t>& compared) {
    const compare::SignedErrors e = compare::signed_errors(own, truth, error, compared);
    if (!e.mean_truth || !(*e.mean_truth > 0)) throw InputError("experiment ipr: no light reaches what is compared but straight from lamps");
    if (!e.rms || !e.mean_error || e.nonfinite > 0) throw InputError("experiment ipr: an irradiance is not finite");
    IprErrors r;
    r.count = int(e.pixels), r.truth = *e.mean_truth, r.noise = *e.noise, r.bias = *e.mean_error;
    // The truth's error bounds that of a luminance from above, so that too much of it may be taken out; a bias stays.
    r.rms = std::max(*e.rms, std::fabs(r.bias));
    for (std::size_t i = 0; i < own.size(); ++i)
        if (compared.empty() || compared.texels[i] != 0) r.mean += std::fabs(own.texels[i] - truth.texels[i]) / r.truth / r.count;
    return r;
}

IprBench::IprBench(const Scene& scene, const frame::Settings& settings, const IprRequest& request, const RunOptions& options)
    : scene_(scene), settings_(settings), request_(request), options_(options) {
    settings_.method = frame::Method::probes, settings_.bake = nullptr, settings_.truth = false;
    settings_.lod = {};
}
IprBench::~IprBench() = default;

const probes::Bake& IprBench::bake(const probes::BakeParams& params) {
    const std::string key = key_of(params);
    if (key != bake_key_) {
        bake_ = nullptr, bake_key_.clear();
        const Clock::time_point start = Clock::now();
        probes::BakeGraph graph(scene_, params);
        graph::RunWith with;
        with.options = options_;
        graph::run(graph.nodes(), with);
        bake_ = std::make_shared<const probes::Bake>(graph.release());
        bake_key_ = key, bake_seconds_ = seconds_since(start);
    }
    return *bake_;
}

const IprTruth& IprBench::truth_of(const probes::Receivers& receivers) {
    ContentHasher h;
    h.add_all(receivers.position), h.add_all(receivers.normal);
    const auto known = truths_.find(h.hash);
    if (known != truths_.end()) return known->second;
    return truths_.emplace(h.hash, trace_receivers(scene_, receivers, request_, settings_.probes.rays, options_)).first->second;
}

frame::Frame IprBench::frame_of(const Scene& scene, const IprVariant& v) {
    frame::Settings settings = settings_;
    settings.probes = v.bake, settings.probe_run = v.run;
    settings.probe_run.loop = probes::Loop::converged;
    settings.bake = bake_, settings.truth = v.traced;
    settings.reference.samples = ipr_pixel_samples(request_), settings.reference.rays = settings_.probes.rays;
    return frame::execute(scene, settings, frame::plan(scene, settings), options_);
}

IprRow IprBench::row(const IprVariant& v) {
    IprRow r;
    r.name = v.name, r.settings = v.settings, r.thesis = v.thesis;
    const probes::Bake& b = bake(v.bake);
    r.receivers = b.receivers.count(), r.probes = probes::standing_probes(b.placement.probes), r.clusters = b.flat.count();
    r.lightmap = b.atlas.size.x, r.bake_seconds = bake_seconds_;
    Scene scene = scene_;
    scene.frame_size = request_.size;
    for (Light& light : scene.lights) light.rsm_size *= v.shadow_scale;
    frame::Frame f;
    try {
        f = frame_of(scene, v);
    } catch (const InputError& e) {
        r.refused = e.what();  // light that grows from round to round
        return r;
    }
    frame::ProbeBuffers& p = f.probes;
    Image4 direct = f.views[1].direct;
    const bool other_light = v.shadow_rays || v.reflectance != 1;
    if (v.shadow_rays) {
        const auto lit = probes::lit_scene(scene, v.bake.rays);
        direct = probes::lamp_irradiance(*lit, f.views[1].gbuffer.position, f.views[1].gbuffer.normal, options_);
    }
    for (glm::vec4& s : p.surface.texels) s = glm::vec4(glm::vec3(s) * v.reflectance, s.w);
    const probes::UpdateBuffers buffers = update_buffers(p, direct, v.run);
    r.rounds = text_of(p.converged);
    if (other_light) {
        Image4 before;
        r.rounds = text_of(probes::converge(buffers, v.run, options_, before));
        p.before = std::move(before);
    }
    r.bytes = bytes_of_update(p);
    for (int i = 0; i <= request_.updates; ++i) {
        const Clock::time_point start = Clock::now();
        probes::update(buffers, options_);
        if (i > 0) r.ms.push_back(1000 * seconds_since(start));  // the first one warms caches
    }
    std::sort(r.ms.begin(), r.ms.end());
    const IprTruth& truth = truth_of(b.receivers);
    r.at_receivers = ipr_errors(shown_at(p, truth.index), truth.mean, truth.error);
    if (!other_light) judge_pixels(f, v.contacts, r);
    if (v.dots && !r.display.empty()) {
        glm::vec3 low(0), high(0);
        bounds(b.atlas.geometry, low, high);
        r.dots = r.display;
        const View view = make_view(scene.camera, double(request_.size.x) / request_.size.y, scene.convention, request_.size);
        std::vector<glm::dvec3> centres;
        for (const glm::vec4& probe : b.placement.probes)
            if (!probes::is_sky(probe)) centres.emplace_back(glm::vec3(probe));
        const double radius = 0.012 * double(glm::length(high - low));
        draw_balls(r.dots, {}, view, centres, radius, {0.1f, 0.15f, 0.5f});  // hidden ones are darker
        draw_balls(r.dots, f.gbuffer.position, view, centres, radius, {0.25f, 0.5f, 1});
    }
    return r;
}

namespace {

// Which pixels have something else so near that a quarter of what they could see is hidden: within a fiftieth of the diagonal.
Image<std::uint8_t> contacts_of(const Scene& scene, const raster::GBuffer& seen, const Image<std::uint8_t>& compared, Rays rays, const RunOptions& options) {
    glm::vec3 low(0), high(0);
    bounds(flatten(scene), low, high);
    reference::PathParams p;
    p.mode = reference::Mode::ambient_occlusion, p.samples = 64, p.rays = rays, p.ao_distance = 0.02f * glm::length(high - low);
    const Image4 open = reference::trace_irradiance(p, *reference::prepare(scene, rays), {&seen.position, &seen.normal}, 5, options).mean;
    Image<std::uint8_t> contacts(open.width, open.height);
    for (std::size_t i = 0; i < contacts.size(); ++i) contacts.texels[i] = compared.texels[i] && open.texels[i].x < 0.75f ? 1 : 0;
    return contacts;
}

}  // namespace

void IprBench::judge_pixels(const frame::Frame& f, bool contacts, IprRow& row) {
    if (pixel_truth_.empty()) {
        Image4 error;
        trace_points(scene_, {&f.gbuffer.position, &f.gbuffer.normal}, ipr_pixel_samples(request_), settings_.probes.rays, options_, pixel_truth_, error);
        pixel_mean_ = compare::luminances(pixel_truth_), pixel_error_ = compare::luminance_errors(error);
        pixel_compared_ = Image<std::uint8_t>(pixel_truth_.width, pixel_truth_.height);
        // What moves is lit where a bake has spatial receivers: a part of its own (ipr_spatial.cpp).
        for (std::size_t i = 0; i < pixel_compared_.size(); ++i) {
            const int object = f.gbuffer.id.texels[i].x;
            pixel_compared_.texels[i] = object >= 0 && !scene_.meshes[std::size_t(object)].dynamic ? 1 : 0;
        }
        // The picture with the traced light in place of the probes'.
        Image4 radiance = f.radiance;
        for (std::size_t i = 0; i < radiance.size(); ++i)
            if (pixel_compared_.texels[i])
                for (int c = 0; c < 3; ++c)
                    radiance.texels[i][c] += float(double(f.gbuffer.albedo.texels[i][c]) / host::pi *
                                                   (double(pixel_truth_.texels[i][c]) - double(f.indirect.texels[i][c])));
        white_ = white_of(radiance), truth_display_ = displayed(radiance, white_);
    }
    const compare::Plane own = compare::luminances(f.indirect);
    row.at_pixels = ipr_errors(own, pixel_mean_, pixel_error_, pixel_compared_);
    row.radiance = f.radiance, row.display = displayed(f.radiance, white_);
    row.ssim_truth = ssim_of(row.display, truth_display_);
    row.error = error_picture(own, pixel_mean_, pixel_error_, pixel_compared_, 0.1 * row.at_pixels->truth);
    if (!contacts) return;
    if (pixel_contacts_.empty()) pixel_contacts_ = contacts_of(scene_, f.gbuffer, pixel_compared_, settings_.probes.rays, options_);
    if (std::count(pixel_contacts_.texels.begin(), pixel_contacts_.texels.end(), 1) > 0)
        row.at_contacts = ipr_errors(own, pixel_mean_, pixel_error_, pixel_contacts_);
}

void against(const IprRow& reference, std::vector<IprRow>& rows) {
    const Image4 display = reference.display;
    for (IprRow& r : rows)
        if (!r.display.empty() && !display.empty()) r.ssim = ssim_of(r.display, display);
}

}  // namespace plumb::cli
