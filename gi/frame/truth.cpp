#include "gi/frame/truth.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "gi/frame/mirrors.h"
#include "gi/reference/lobes.h"
#include "gi/reference/mirrors.h"

namespace plumb::frame {

namespace {

// Whether that part of some material is not 0.
bool any_material(const Scene& scene, glm::vec3 Material::* part) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [&](const Material& m) { return m.*part != glm::vec3(0); });
}

bool of_mirrors(const std::string& layer) { return layer == "truth.reflection"; }

// The normals of mirrors; 0 elsewhere: nothing is asked there.
Image4 normals_of(const Image4& mirrors, Image4 normal) {
    for (std::size_t i = 0; i < normal.size(); ++i)
        if (mirrors.texels[i].w == 0) normal.texels[i] = glm::vec4(0);
    return normal;
}

// The normals of lobes, with their exponents; 0 elsewhere.
Image4 normals_of_lobes(const Image4& lobes, Image4 normal) {
    for (std::size_t i = 0; i < normal.size(); ++i) {
        const glm::vec4 lobe = lobes.texels[i];
        normal.texels[i] = glm::vec3(lobe) != glm::vec3(0) ? glm::vec4(glm::vec3(normal.texels[i]), lobe.w) : glm::vec4(0);
    }
    return normal;
}

Image4 times(Image4 a, const Image4& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a.texels[i] = a.texels[i] * b.texels[i];
    return a;
}

// Adds an estimate that is independent of the sum.
void add(const reference::Estimate& part, reference::Estimate& sum) {
    for (std::size_t i = 0; i < sum.mean.size(); ++i) {
        sum.mean.texels[i] += part.mean.texels[i];
        glm::vec4& error = sum.error.texels[i];
        for (int c = 0; c < 3; ++c) error[c] = float(std::sqrt(double(error[c]) * error[c] + double(part.error.texels[i][c]) * part.error.texels[i][c]));
    }
    sum.rays += part.rays, sum.nonfinite += part.nonfinite;
    double errors = 0, means = 0;
    for (std::size_t i = 0; i < sum.mean.size(); ++i)
        for (int c = 0; c < 3; ++c) errors += double(sum.error.texels[i][c]) * sum.error.texels[i][c], means += sum.mean.texels[i][c];
    const double values = 3.0 * double(sum.mean.size());
    sum.relative_error = means > 0 ? std::sqrt(errors / values) / (means / values) : 0;
}

// What `trace` estimates, or has estimated: then it is found by its key.
template <class Trace>
reference::Estimate find_or_trace(reference::Store* store, std::uint64_t key, glm::ivec2 size, Trace trace, Traced& traced) {
    if (store)
        if (std::optional<reference::KeptEstimate> kept = store->find(key, size)) {
            traced.ms += kept->ms;
            return std::move(kept->estimate);
        }
    const auto start = std::chrono::steady_clock::now();
    reference::Estimate made = trace();
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    traced.ms += ms, traced.cached = false;
    if (store) store->keep(key, {made, ms});
    return made;
}

// What the methods for diffuse light of lamps leave out of a scene.
std::vector<std::string> beyond_lamps(const Scene& scene) {
    std::vector<std::string> names;
    if (any_material(scene, &Material::emission)) names.push_back("emission");
    if (any_material(scene, &Material::specular)) names.push_back("specular");
    if (any_material(scene, &Material::mirror)) names.push_back("mirror");
    if (std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.microfacet; }))
        names.push_back("microfacets");
    if (scene.environment.radiance != glm::vec3(0)) names.push_back("environment");
    return names;
}

}  // namespace

bool own_transport(const std::string& layer) { return layer == "truth.direct" || layer == "truth.indirect" || layer == "truth.ao"; }

Scene lamps_only(Scene scene) {
    for (Material& m : scene.materials) m.emission = m.specular = m.mirror = glm::vec3(0), m.microfacet = false;
    scene.environment = {};
    return scene;
}

Tracer::Tracer(const Scene& scene, const Settings& settings, const Geometry& geometry, reference::Store* store,
               PathScenes* paths)
    : scene_(scene), settings_(settings), geometry_(geometry), store_(store), without_(beyond_lamps(scene)),
      whole_{&scene, (paths ? *paths : mine_).whole}, own_{&scene, (paths ? *paths : mine_).own} {
    if (!settings.truth || without_.empty()) return;
    lamps_ = lamps_only(scene);
    own_.scene = &lamps_;
}

const reference::PathScene& Tracer::paths(View& view) const {
    if (!view.paths) view.paths = reference::prepare(*view.scene, settings_.reference.rays);
    return *view.paths;
}

Traced Tracer::begin(const std::string& layer) const {
    Traced traced;
    traced.layer = layer;
    traced.params = settings_.reference;
    if (layer == "truth.ao") {
        traced.params.mode = reference::Mode::ambient_occlusion;
        traced.params.ao_distance = settings_.ao.radius;
    } else if (of_mirrors(layer)) {
        traced.params.mode = reference::Mode::all;
        traced.without = reference::lamp_light_unseen(scene_, geometry_);
    } else if (own_transport(layer)) {
        traced.params.mode = layer == "truth.direct" ? reference::Mode::direct : reference::Mode::one_bounce;
        traced.without = without_;
    } else if (traced.params.mode != reference::Mode::direct && traced.params.mode != reference::Mode::ambient_occlusion) {
        traced.without = reference::lamp_light_unseen(scene_, geometry_);
    }
    return traced;
}

Traced Tracer::dark(const std::string& layer) const {
    Traced traced = begin(layer);
    traced.estimate.mean = traced.estimate.error = Image4(scene_.frame_size.x, scene_.frame_size.y);
    return traced;
}

Traced Tracer::trace(const std::string& layer, const raster::GBuffer& gbuffer, const RunOptions& options) {
    Traced traced = begin(layer);
    const bool own = own_transport(layer), mirrored = of_mirrors(layer);
    // Without anything to leave out, both views are of the same scene.
    View& view = own && !without_.empty() ? own_ : whole_;
    const std::uint32_t seed = settings_.seed;
    const glm::dvec3 eye = scene_.camera.position;
    const reference::PathParams& p = traced.params;
    const glm::ivec2 size = scene_.frame_size;
    traced.cached = true;
    if (mirrored) {
        const Image4 mirrors = mirrors_of(scene_, geometry_, gbuffer.id), normal = normals_of(mirrors, gbuffer.normal);
        const reference::PointInputs points{&gbuffer.position, &normal};
        traced.estimate = find_or_trace(
            store_, store_ ? reference::cache_key(p, *view.scene, geometry_, points, eye, seed, options.isa) : 0, size,
            [&] { return reference::trace_reflection(p, paths(view), points, eye, seed, options); }, traced);
        for (Image4* image : {&traced.estimate.mean, &traced.estimate.error}) *image = times(std::move(*image), mirrors);
        if (settings_.reflect.lobe == screen::Lobe::off || !any_lobe(scene_)) return traced;
        const Image4 lobes = lobes_of(scene_, geometry_, gbuffer.id), of_lobes = normals_of_lobes(lobes, gbuffer.normal);
        const reference::PointInputs rough{&gbuffer.position, &of_lobes};
        reference::Estimate part = find_or_trace(
            store_, store_ ? reference::cache_key_of_lobes(p, *view.scene, geometry_, rough, eye, seed, options.isa) : 0, size,
            [&] { return reference::trace_lobes(p, paths(view), rough, eye, seed, options); }, traced);
        for (Image4* image : {&part.mean, &part.error}) *image = times(std::move(*image), lobes);
        add(part, traced.estimate);
        return traced;
    }
    const reference::PointInputs points{&gbuffer.position, &gbuffer.normal};
    const auto key = [&] {
        return own ? reference::cache_key(p, *view.scene, geometry_, points, seed, options.isa)
                   : reference::cache_key(p, *view.scene, geometry_, seed, options.isa);
    };
    traced.estimate = find_or_trace(
        store_, store_ ? key() : 0, size,
        [&] {
            return own ? reference::trace_irradiance(p, paths(view), points, seed, options)
                       : reference::trace(p, paths(view), scene_.camera, size, seed, options);
        },
        traced);
    return traced;
}

}  // namespace plumb::frame
