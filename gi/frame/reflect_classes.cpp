#include "gi/frame/reflect_classes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel.h"
#include "core/ray_query.h"
#include "gi/frame/isr.h"
#include "gi/probes/receivers.h"
#include "gi/reference/ray_query.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// What a true ray meets.
struct Truth {
    int triangle = -1;  // none
    glm::dvec3 at{0};   // m
};

enum class Kind { camera, layer, map };

// A view in which rays were followed.
struct Followed {
    Kind kind = Kind::map;
    View view;
    glm::ivec2 size{0};
    const Image<glm::ivec2>* id = nullptr;
    const Image4* normal = nullptr;

    // The texel of a point; false: the view has none.
    bool texel_of(const glm::dvec3& at, glm::dvec2& texel) const {
        const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(at, 1);
        if (!(clip.w > 0)) return false;
        texel = {(clip.x / clip.w + 1) * 0.5 * size.x, (clip.y / clip.w + 1) * 0.5 * size.y};
        return texel.x >= 0 && texel.y >= 0 && texel.x < size.x && texel.y < size.y;
    }
    bool shows(glm::ivec2 texel, const Truth& truth, const glm::dvec3& r) const {
        return (*id)(texel.x, texel.y).y == truth.triangle && dot(glm::dvec3((*normal)(texel.x, texel.y)), r) < 0;
    }
    bool sees(const Truth& truth, const glm::dvec3& r) const {
        glm::dvec2 texel;
        return truth.triangle >= 0 && texel_of(truth.at, texel) && shows(glm::ivec2(texel), truth, r);
    }
    bool is_right(const glm::vec4& hit, const Truth& truth, const glm::dvec3& r) const {
        const glm::ivec2 met(int(hit.x), int(hit.y));
        glm::dvec2 texel;
        if (truth.triangle < 0 || !texel_of(truth.at, texel) || !shows(met, truth, r)) return false;
        return std::abs(std::floor(texel.x) - met.x) <= 1 && std::abs(std::floor(texel.y) - met.y) <= 1;
    }
};

// The camera's, its layers, then the lights' maps as hits number them.
std::vector<Followed> followed_views(const Scene& scene, const Settings& settings, const Frame& frame) {
    const glm::ivec2 size = scene.frame_size;
    const View camera = make_view(scene.camera, double(size.x) / size.y, scene.convention, size);
    std::vector<Followed> views{{Kind::camera, camera, size, &frame.gbuffer.id, &frame.gbuffer.normal}};
    const std::vector<IsrView> drawn = isr_views(scene, settings);
    for (std::size_t v = 0; v < drawn.size(); ++v)
        if (drawn[v].kind == ViewKind::mirror_layer)
            views.push_back({Kind::layer, camera, size, &frame.views[v].gbuffer.id, &frame.views[v].gbuffer.normal});
    if (!reflects_maps(settings)) return views;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const Light& light = scene.lights[l];
        if (!light.on || light.intensity == glm::vec3(0)) continue;
        for (int m = 0; m < raster::map_count(light); ++m) {
            Followed& view = views.emplace_back();
            const std::vector<raster::Rsm>& maps = frame.rsms[l];
            const std::vector<raster::GBuffer>& seen = frame.reflect.seen[l];
            if (maps.size() <= std::size_t(m) || maps[std::size_t(m)].size == 0 || seen.size() <= std::size_t(m)) continue;
            const raster::Rsm& map = maps[std::size_t(m)];
            view = {Kind::map, map.view, glm::ivec2(map.size), &seen[std::size_t(m)].id, &seen[std::size_t(m)].normal};
        }
    }
    return views;
}

MirrorClass class_of(const std::vector<Followed>& views, const glm::vec4& hit, const Truth& truth, const glm::dvec3& r) {
    const std::size_t number = std::size_t(hit.w);
    if (number > 0) {
        const bool right = views[number - 1].is_right(hit, truth, r);
        switch (views[number - 1].kind) {
            case Kind::camera: return right ? MirrorClass::right : MirrorClass::wrong;
            case Kind::layer: return right ? MirrorClass::right_in_layer : MirrorClass::wrong_in_layer;
            case Kind::map: return right ? MirrorClass::right_in_map : MirrorClass::wrong_in_map;
        }
    }
    if (truth.triangle < 0) return MirrorClass::open;
    const auto by = std::find_if(views.begin(), views.end(), [&](const Followed& v) { return v.id && v.sees(truth, r); });
    if (by == views.end()) return MirrorClass::unseen;
    return by->kind == Kind::camera ? MirrorClass::missed
                                    : by->kind == Kind::layer ? MirrorClass::missed_in_layer : MirrorClass::missed_in_map;
}

}  // namespace

const char* name_of(MirrorClass of) {
    static constexpr const char* names[mirror_classes] = {"none",         "right",         "wrong",          "missed",
                                                          "right_in_map", "wrong_in_map",  "missed_in_map",  "unseen",
                                                          "open",         "right_in_layer", "wrong_in_layer", "missed_in_layer"};
    return names[int(of)];
}

std::int64_t MirrorClasses::mirrors() const { return std::accumulate(count.begin() + 1, count.end(), std::int64_t(0)); }

MirrorClasses classify_mirrors(const Scene& scene, const Settings& settings, const Frame& frame, const RunOptions& options) {
    const glm::ivec2 size = scene.frame_size;
    MirrorClasses made;
    made.of_pixel = Image1(size.x, size.y);
    const Geometry geometry = flatten(scene);
    if (frame.reflect.hits.empty() || geometry.triangles.empty()) {
        made.count[0] = std::int64_t(size.x) * size.y;
        return made;
    }
    const raster::Surfaces surfaces = raster::prepare(scene, geometry);
    const auto query = reference::build_ray_query(geometry, surfaces, settings.reference.rays);
    const double offset = double(probes::offset_of(probes::extent_of(geometry)));
    const std::vector<Followed> views = followed_views(scene, settings, frame);
    parallel_bands(size.y, 8, options.threads, [&](int first, int last) {
        for (int y = first; y < last; ++y)
            for (int x = 0; x < size.x; ++x) {
                if (frame.reflect.mirror(x, y).w == 0) continue;
                const glm::dvec3 p(frame.gbuffer.position(x, y)), n(frame.gbuffer.normal(x, y));
                const glm::dvec3 w = p - scene.camera.position, v = w / std::sqrt(dot(w, w)), r = v - n * (2 * dot(n, v));
                RayPacket<1> ray{};
                const glm::dvec3 from = p + n * offset;
                ray.origin_x[0] = float(from.x), ray.origin_y[0] = float(from.y), ray.origin_z[0] = float(from.z);
                ray.direction_x[0] = float(r.x), ray.direction_y[0] = float(r.y), ray.direction_z[0] = float(r.z);
                ray.t_far[0] = std::numeric_limits<float>::infinity();
                const std::int32_t active = -1;
                query->nearest(&active, ray);
                Truth truth;
                if (ray.triangle[0] != no_hit) truth = {int(ray.triangle[0]), from + r * double(ray.t_far[0])};
                made.of_pixel(x, y) = float(int(class_of(views, frame.reflect.hits.back()(x, y), truth, r)));
            }
    });
    for (const float of : made.of_pixel.texels) ++made.count[std::size_t(of)];
    return made;
}

}  // namespace plumb::frame
