#include "tools/shared/sweep_subject.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>

#include "core/content_hash.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/compose/compose.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/truth.h"

namespace plumb::cli {

namespace {

// Hashes a subject but for what a sweep varies and how well the truth is traced.
std::uint64_t content_of(const Subject& subject) {
    frame::Settings settings = subject.settings;
    settings.reference = {};
    return content_hash(json_text(settings_json(settings)), scene_hash(subject.scene));
}

// The picture of a method without an error: the layers of its own transport, composed as it composes.
reference::Estimate compose_truth(const Scene& scene, const frame::Frame& frame, const std::vector<std::string>& layers,
                                  const RunOptions& options) {
    reference::Estimate result;
    const raster::GBuffer& g = frame.gbuffer;
    Image4 irradiance(scene.frame_size.x, scene.frame_size.y);
    const Image4 none = irradiance;
    result.error = none;
    for (const std::string& layer : layers) {
        const reference::Estimate& of = frame::find_traced(frame, layer)->estimate;
        for (std::size_t i = 0; i < none.size(); ++i) {
            irradiance.texels[i] += of.mean.texels[i];
            for (int c = 0; c < 3; ++c) {
                const double a = result.error.texels[i][c], b = of.error.texels[i][c];
                result.error.texels[i][c] = float(std::sqrt(a * a + b * b));  // of irradiance, until all are added
            }
        }
    }
    // A truth has no shadow colour: what one adds is an error.
    compose::run(compose::ComposeParams{},
                 compose::ComposeInputs{&g.normal, &g.albedo, &g.emission, &irradiance, &none, scene.environment.radiance},
                 options, result.mean);
    for (std::size_t i = 0; i < none.size(); ++i)
        for (int c = 0; c < 3; ++c)
            result.error.texels[i][c] = float(double(g.albedo.texels[i][c]) * result.error.texels[i][c] / host::pi);
    return result;
}

}  // namespace

Subject load_subject(const SweepRequest& request, SceneOptions options) {
    Subject subject{request.loaded ? *request.loaded : load(options), {}, {}, {}, {}};
    subject.settings = settings_of(subject.scene, options);
    if (request.size) subject.scene.frame_size = *request.size;
    // As render --method direct --truth reads them.
    options.method = frame::method_name(frame::Method::direct);
    options.truth = true;
    options.samples = request.samples, options.until_error = request.until_error;
    subject.truth = settings_of(subject.scene, options);
    // One frame traces all layers that any method's transport is made of: this is the cheapest that has all of them.
    subject.truth.method = frame::Method::rsm;
    subject.truth.rsm = {};
    subject.truth.rsm.samples = 1;
    // Nobody looks at its maps: whether they fit the scene's targets is a matter of the points that read their own.
    raster::Layout& layout = subject.truth.layout;
    layout.name = "custom";
    layout.rsm_position = layout.rsm_normal = layout.rsm_flux = Format::rgba32f, layout.rsm_depth = Format::r32f;
    layout.indirect = Format::rgba32f, layout.visibility = Format::r32f;
    // Other random numbers than the points': the method reference must not be held against its own paths.
    subject.truth.seed = std::uint32_t(pcg(std::int32_t(subject.settings.seed) + pcg(1)));
    frame::plan(subject.scene, subject.truth);  // throws for what no path traced truth can serve
    return subject;
}

void trace_truths(const RunOptions& options, reference::Store* store, Subject& subject, SweptScene& scene,
                  std::vector<std::string>& notes, ScenePictures* pictures) {
    const frame::Plan plan = frame::plan(subject.scene, subject.truth);
    const frame::Frame frame = frame::execute(
        subject.scene, subject.truth, plan, options,
        [&](const std::string& label, double) { show_progress(scene.name + ": " + label); }, store);
    const frame::Traced& full = *frame::find_traced(frame, "truth");
    subject.full = full.estimate;
    for (const frame::MethodInfo& method : frame::methods())
        if (!method.transport.empty())
            subject.own[method.method] = compose_truth(subject.scene, frame, method.transport, options);

    for (const std::string& warning : truth_warnings(frame)) notes.push_back(scene.name + ": " + warning);
    scene.width = subject.scene.frame_size.x, scene.height = subject.scene.frame_size.y;
    scene.content = content_of(subject);
    scene.truth = content_hash(full.estimate.mean);
    for (const auto& [method, estimate] : subject.own) scene.truth = content_hash(estimate.mean, scene.truth);
    scene.samples = full.estimate.samples, scene.relative_error = full.estimate.relative_error;
    if (!pictures) return;
    auto shown = [&](const Image4& radiance) {
        Image4 display;
        compose::run(subject.truth.tonemap, compose::TonemapInputs{&radiance}, options, display);
        return compose::to_bytes(display);
    };
    pictures->truth = shown(subject.full.mean);
    for (const auto& [method, estimate] : subject.own) pictures->own[method] = shown(estimate.mean);
    for (const frame::MethodInfo& method : frame::methods()) pictures->own.try_emplace(method.method, pictures->truth);
}

std::uint64_t scene_hash(const Scene& scene) {
    reference::PathParams exact;
    exact.rays = Rays::exact;  // the hash does not depend on the processor then
    std::string rest = fmt::format("{} {}", int(scene.convention), scene.camera.reversed_z);
    for (const Light& light : scene.lights) rest += fmt::format(" {}", light.rsm_size);
    return content_hash(rest, reference::cache_key(exact, scene, flatten(scene), scene.seed, Isa::scalar));
}

void show_progress(const std::string& text) {
    if (isatty(STDERR_FILENO)) std::fputs(("\r\033[K" + text).c_str(), stderr);
}

}  // namespace plumb::cli
