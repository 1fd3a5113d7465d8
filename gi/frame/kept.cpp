#include "gi/frame/kept.h"

#include "core/content_hasher.h"
#include "gi/frame/kept_memory.h"
#include "gi/frame/relief_use.h"
#include "gi/probes/run_stages.h"
#include "gi/probes/static_scene.h"

namespace plumb::frame {

namespace {

template <class... T>
std::uint64_t hash_of(const T&... values) {
    ContentHasher h;
    h.add(values...);
    return h.hash;
}

// True where `key` is another than before, or nobody knows.
bool changed(std::optional<std::uint64_t>& before, const SceneKeys* keys, std::uint64_t key) {
    const bool same = keys && before == key;
    before = keys ? std::optional(key) : std::nullopt;
    return !same;
}

}  // namespace

KeptStages::KeptStages(OtherKey other) : memory_(std::make_unique<KeptMemory>()), other_key_(std::move(other)) {}
KeptStages::~KeptStages() = default;

std::uint64_t BakeKey::of(const std::shared_ptr<const probes::Bake>& bake) {
    const std::shared_ptr<const probes::Bake> before = bake_.lock();
    if (bake && before != bake) key_ = probes::bake_key(*bake);
    bake_ = bake;
    return bake ? key_ : 0;
}

void World::update(const Scene& scene, const Settings& settings, const SceneKeys* keys) {
    const SceneKeys k = keys ? *keys : SceneKeys{};
    const bool moved = changed(geometry_key, keys, k.geometry);
    if (moved) {
        geometry = flatten(scene);
        low = high = glm::vec3(0);
        bounds(geometry, low, high);
    }
    const bool repainted = changed(surfaces_key, keys, hash_of(k.surfaces, k.emission, geometry.tangents.empty()));
    if (repainted) surfaces = raster::prepare(scene, geometry, keys ? &surfaces : nullptr);
    if (repainted && drops_normal_maps(settings)) probes::drop_normal_maps(surfaces);
    // Which materials are drawn the geometry says.
    if (moved && !repainted) surfaces.brightest = raster::brightest_of(scene, geometry);
    if (!relief_use(scene, settings).draws_plain())
        plain = {};
    else if (moved || repainted || plain.materials.empty())
        probes::drop_normal_maps(plain = surfaces);
    if (static_lamps(scene, settings).empty())
        fixed = {}, fixed_key.reset();
    else if (changed(fixed_key, keys, k.fixed)) {
        fixed = probes::flatten_static(scene);
        if (fixed.tangents.empty() && !geometry.tangents.empty()) fixed.tangents.assign(fixed.vertices.size(), glm::vec4(0));
        bounds(fixed, fixed_low, fixed_high);
    }
    if (moved || repainted || kind != settings.rsm.rays) rays.reset();
    if (changed(paths_key, keys, k.paths) || paths_kind != settings.reference.rays) paths = {};
    kind = settings.rsm.rays, paths_kind = settings.reference.rays;
}

}  // namespace plumb::frame
