#include "gi/frame/truth.h"

#include <algorithm>
#include <chrono>

#include "gi/frame/mirrors.h"

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

Image4 times(Image4 a, const Image4& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a.texels[i] = a.texels[i] * b.texels[i];
    return a;
}

// What the methods for diffuse light of lamps leave out of a scene.
std::vector<std::string> beyond_lamps(const Scene& scene) {
    std::vector<std::string> names;
    if (any_material(scene, &Material::emission)) names.push_back("emission");
    if (any_material(scene, &Material::specular)) names.push_back("specular");
    if (any_material(scene, &Material::mirror)) names.push_back("mirror");
    if (scene.environment.radiance != glm::vec3(0)) names.push_back("environment");
    return names;
}

}  // namespace

bool own_transport(const std::string& layer) { return layer == "truth.direct" || layer == "truth.indirect" || layer == "truth.ao"; }

Scene lamps_only(Scene scene) {
    for (Material& m : scene.materials) m.emission = m.specular = m.mirror = glm::vec3(0);
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
    } else if (own_transport(layer)) {
        traced.params.mode = layer == "truth.direct" ? reference::Mode::direct : reference::Mode::one_bounce;
        traced.without = without_;
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
    reference::PointInputs points{&gbuffer.position, &gbuffer.normal};
    Image4 mirrors, mirror_normal;
    if (mirrored) {
        mirrors = mirrors_of(scene_, geometry_, gbuffer.id);
        mirror_normal = normals_of(mirrors, gbuffer.normal);
        points.normal = &mirror_normal;
    }

    // Look for a kept one.
    std::uint64_t key = 0;
    if (store_) {
        using reference::cache_key;
        const reference::PathParams& p = traced.params;
        key = mirrored ? cache_key(p, *view.scene, geometry_, points, eye, seed, options.isa)
              : own    ? cache_key(p, *view.scene, geometry_, points, seed, options.isa)
                       : cache_key(p, *view.scene, geometry_, seed, options.isa);
        if (std::optional<reference::KeptEstimate> kept = store_->find(key, scene_.frame_size)) {
            traced.estimate = std::move(kept->estimate);
            traced.ms = kept->ms;
            traced.cached = true;
        }
    }
    if (!traced.cached) {
        const reference::PathScene& paths = this->paths(view);
        const auto start = std::chrono::steady_clock::now();
        traced.estimate = mirrored ? reference::trace_reflection(traced.params, paths, points, eye, seed, options)
                          : own    ? reference::trace_irradiance(traced.params, paths, points, seed, options)
                                   : reference::trace(traced.params, paths, scene_.camera, scene_.frame_size, seed, options);
        traced.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        if (store_) store_->keep(key, {traced.estimate, traced.ms});
    }
    if (mirrored)
        for (Image4* image : {&traced.estimate.mean, &traced.estimate.error}) *image = times(std::move(*image), mirrors);
    return traced;
}

}  // namespace plumb::frame
