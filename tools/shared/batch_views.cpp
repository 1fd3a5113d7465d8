#include "tools/shared/batch_views.h"

#include <fmt/format.h>

#include <chrono>
#include <set>

#include "core/content_hasher.h"
#include "core/error.h"
#include "gi/frame/settings.h"
#include "io/file.h"
#include "tools/shared/options.h"

namespace plumb::cli {

BatchScenes::BatchScenes(const std::vector<std::string>& lists) {
    std::set<std::string> groups, names;
    for (std::size_t l = 0; l < lists.size(); ++l) {
        lists_.push_back(io::read_camera_list(lists[l]));
        const std::string group = file_name(io::stem_of(lists[l]));
        if (!groups.insert(group).second)
            throw InputError(fmt::format("{}: another list has the name \"{}\"", io::shown(lists[l]), group));
        for (std::size_t i = 0; i < lists_.back().cameras.size(); ++i)
            views_.push_back({l, i, group + "_" + lists_.back().cameras[i].name, group});
        // "a" with a view "b_c", and "a_b" with a view "c".
        for (const BatchView& v : views_)
            if (v.list == l && !names.insert(v.name).second)
                throw InputError(fmt::format("{}: another view's files have the name {}", io::shown(lists[l]), v.name));
    }
}

const io::ListedCamera& BatchScenes::listed(const BatchView& view) const {
    return lists_.at(view.list).cameras.at(view.index);
}

void BatchScenes::open(const BatchView& view) {
    const io::CameraList& list = lists_.at(view.list);
    const std::string& word = listed(view).scene;
    // The same file may be called otherwise from another list.
    const std::string key = io::is_scene_file(word) ? io::beside(list.path, word) : word;
    if (key == word_) return;
    word_.clear();
    loaded_ = io::load_listed_scene(list.path, word, frame::method_tables());
    loaded_content_ = light_hash(loaded_);
    triangles_ = flatten(loaded_).triangles.size();
    word_ = key;
}

const Scene& BatchScenes::scene(const BatchView& view, glm::ivec2 size) {
    open(view);
    posed_ = io::scene_of(lists_.at(view.list), listed(view), loaded_);
    posed_.frame_size = size;
    return posed_;
}

std::uint64_t BatchScenes::content(const BatchView& view, glm::ivec2 size) {
    const Scene& posed = scene(view, size);
    ContentHasher h;
    h.add(listed(view).frame ? light_hash(posed) : loaded_content_);
    const Camera& c = posed.camera;
    h.add(c.position, c.look_at, c.up, c.fov_y_deg, c.near, c.far, std::int32_t(size.x), std::int32_t(size.y));
    return h.hash;
}

std::uint64_t light_hash(const Scene& scene) {
    ContentHasher h;
    const Geometry g = flatten(scene);
    h.add_all(g.vertices), h.add_all(g.tangents), h.add_all(g.triangles), h.add_all(g.material);
    for (const Material& m : scene.materials)
        h.add(m.reflectance, m.emission, m.texture, m.emission_texture, m.normal_texture, m.normal_scale, m.alpha,
              m.alpha_cutoff, m.specular, m.exponent, m.mirror, m.microfacet, m.metalness, m.roughness, m.surface_texture);
    for (const Texture& t : scene.textures) {
        h.add_image(t.texels);
        h.add(std::int32_t(t.srgb), std::int32_t(t.filter), std::int32_t(t.wrap_u), std::int32_t(t.wrap_v),
              std::int32_t(t.mips));
    }
    for (const Light& l : scene.lights) {
        h.add(std::int32_t(l.type), l.position, l.direction, l.cone_inner_deg, l.cone_outer_deg, l.intensity,
              std::int32_t(l.on));
        if (l.radius > 0) h.add(l.radius);
    }
    h.add(scene.environment.radiance);
    h.add_image(scene.environment.map);
    if (!scene.environment.map.empty() && scene.environment.filter == Filter::bilinear) h.add(std::int32_t(1));
    h.add(scene.seed);
    return h.hash;
}

reference::KeptEstimate BatchTruths::of(BatchScenes& scenes, const BatchView& view, glm::ivec2 size,
                                const RunOptions& options) {
    reference::PathParams params;
    params.samples = samples_;
    ContentHasher key;
    key.add(scenes.content(view, size), std::int32_t(params.samples), std::int32_t(params.rounds));
    if (std::optional<reference::KeptEstimate> kept = files_.find(key.hash, size)) return *kept;
    const Scene& scene = scenes.scene(view, size);
    const std::unique_ptr<reference::PathScene> paths = reference::prepare(scene, params.rays);
    const auto start = std::chrono::steady_clock::now();
    reference::KeptEstimate kept;
    kept.estimate = reference::trace(params, *paths, scene.camera, size, scene.seed, options);
    kept.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    files_.keep(key.hash, kept);
    ++traced_;
    return kept;
}

}  // namespace plumb::cli
