#include "gi/frame/kept.h"

#include "core/content_hasher.h"
#include "gi/frame/kept_memory.h"
#include "gi/probes/run_stages.h"

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
    // Which materials are drawn the geometry says.
    if (moved && !repainted) surfaces.brightest = raster::brightest_of(scene, geometry);
    if (moved || repainted || kind != settings.rsm.rays) rays.reset();
    if (changed(paths_key, keys, k.paths) || paths_kind != settings.reference.rays) paths = {};
    kind = settings.rsm.rays, paths_kind = settings.reference.rays;
}

}  // namespace plumb::frame
