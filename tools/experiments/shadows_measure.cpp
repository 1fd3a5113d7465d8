// plumb experiment shadows: traces the truth and counts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/frame/kept.h"
#include "gi/frame/keys.h"
#include "gi/reference/light_kernel.h"
#include "gi/reference/ray_query.h"
#include "raster/light_view.h"
#include "tools/experiments/shadows.h"
#include "tools/shared/scene_command.h"

namespace plumb::cli {

namespace {

constexpr float unsure = 1 / 16.0f;  // of visibility: what is counted as wrong

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// origin + t direction, 0 < t <= 1.
RayPacket<1> segment(const glm::dvec3& origin, const glm::dvec3& direction) {
    RayPacket<1> ray{};
    ray.origin_x[0] = float(origin.x), ray.origin_y[0] = float(origin.y), ray.origin_z[0] = float(origin.z);
    ray.direction_x[0] = float(direction.x), ray.direction_y[0] = float(direction.y), ray.direction_z[0] = float(direction.z);
    ray.t_far[0] = 1;
    return ray;
}

// The nearest surface on a segment.
struct Met {
    bool found;
    double t;
    glm::dvec3 normal;  // of any length
};
Met meet(const RayQuery& query, const glm::dvec3& origin, const glm::dvec3& direction) {
    RayPacket<1> ray = segment(origin, direction);
    const std::int32_t active = -1;
    query.nearest(&active, ray);
    return {ray.triangle[0] != no_hit, ray.t_far[0], {ray.normal_x[0], ray.normal_y[0], ray.normal_z[0]}};
}
bool is_hidden(const RayQuery& query, const glm::dvec3& origin, const glm::dvec3& direction) {
    RayPacket<1> ray = segment(origin, direction);
    const std::int32_t active = -1;
    query.occluded(&active, ray);
    return ray.t_far[0] < 0;
}

struct Point {
    glm::dvec3 x, n;
    double unshadowed;  // irradiance, mean of the channels, W/m2; 0: faces away, or lies outside of the cone
    bool lit;
};

// What rays know of one light.
class LitByRays {
  public:
    LitByRays(const RayQuery& query, const Light& light, const glm::vec3& low, const glm::vec3& high)
        : query_(query), light_(light), args_(raster::light_args(light)), views_(raster::light_views(light, low, high)) {
        const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
        diagonal_ = std::sqrt(dot(size, size));
        for (int c = 0; c < 3; ++c) extent_ = std::max({extent_, std::abs(double(low[c])), std::abs(double(high[c]))});
    }

    Point at(const glm::vec4& position, const glm::vec4& normal) const {
        Point p{glm::dvec3(position), glm::dvec3(normal), 0, false};
        if (normal.w == 0) return p;
        const glm::dvec3 to_light = from(p.x), w = to_light / std::sqrt(dot(to_light, to_light));
        const double cosine = dot(p.n, w);
        if (!(cosine > 0)) return p;
        p.unshadowed = cosine * sent(to_light, w);
        if (p.unshadowed > 0) p.lit = !is_hidden(query_, p.x + p.n * offset(), to_light);
        return p;
    }

    // Whether a point of the plane of x that falls within `reach` texels of x is lit where x is not, or hidden where x is lit by what
    // has x under its plane: what has not, hides nothing near x.
    bool at_edge(const Point& p, double reach) const {
        const View& view = views_[views_.size() == 1 ? 0 : std::size_t(raster::face_of<float>(glm::vec3(-from(p.x))))];
        const glm::dmat4& m = view.world_to_view;
        const glm::dvec3 right(m[0][0], m[1][0], m[2][0]), up(m[0][1], m[1][1], m[2][1]);
        const double side = 2 / (std::abs(view.view_to_clip[0][0]) * light_.rsm_size);
        const double texel = view.orthographic ? side : side * dot(view.forward, p.x - view.eye);
        for (const double r : {reach, reach / 2})
            for (int k = 0; k < 9; ++k) {
                if (k == 4) continue;
                const glm::dvec3 beside = p.x + (right * double(k % 3 - 1) + up * double(k / 3 - 1)) * (r * texel);
                if (differs(p, beside)) return true;
            }
        return false;
    }

  private:
    double offset() const { return double(reference::ray_offset(float(extent_))); }
    glm::dvec3 from(const glm::dvec3& x) const {
        return is_sun() ? glm::dvec3(light_.direction) * (-2 * diagonal_) : glm::dvec3(light_.position) - x;
    }
    bool is_sun() const { return light_.type == LightType::directional; }
    double sent(const glm::dvec3& to_light, const glm::dvec3& w) const {
        if (is_sun()) return (double(light_.intensity.x) + light_.intensity.y + light_.intensity.z) / 3;
        const double d2 = dot(to_light, to_light);
        const glm::vec3 axis(args_.direction[0], args_.direction[1], args_.direction[2]);
        const vec3<float> i = raster::light_intensity<float>(args_, float(-dot(w, glm::dvec3(axis))), float(d2));
        return (double(i.x) + i.y + i.z) / 3 / d2;
    }
    bool differs(const Point& p, const glm::dvec3& beside) const {
        // Along the light's ray into the plane of x.
        const glm::dvec3 ray = -from(beside), along = is_sun() ? ray : ray / std::sqrt(dot(ray, ray));
        const double slope = dot(p.n, along);
        if (!(std::abs(slope) > 1e-9)) return false;
        const glm::dvec3 y = beside - along * (dot(p.n, beside - p.x) / slope), to_y = -from(y);
        if (dot(to_y, ray) <= 0) return false;
        const Met met = meet(query_, y - to_y, to_y);
        const double length = std::sqrt(dot(to_y, to_y)), slack = 4 * offset();
        const bool hidden = met.found && (1 - met.t) * length > slack;
        if (!p.lit) return !hidden;
        if (!hidden) return false;
        const glm::dvec3 q = y - to_y * (1 - met.t), n = met.normal / std::sqrt(dot(met.normal, met.normal));
        return dot(n, q - p.x) * (dot(n, to_y) < 0 ? 1 : -1) > slack;
    }

    const RayQuery& query_;
    Light light_;
    raster::LightArgs args_;
    std::vector<View> views_;
    double diagonal_ = 0, extent_ = 0;
};

struct Truth {
    std::vector<std::size_t> lights;          // that shine
    std::vector<LitByRays> rays;
    std::vector<std::vector<Point>> points;   // [light][pixel]
};

ShadowErrors compare(const Truth& truth, const Buffer<float>& visibility, double reach, const RunOptions& options, glm::ivec2 size, Image4& where) {
    const std::size_t pixels = std::size_t(size.x) * std::size_t(size.y);
    std::vector<ShadowErrors> rows(std::size_t(size.y));
    std::vector<double> lit_light(rows.size());
    where = Image4(size.x, size.y, glm::vec4(0, 0, 0, 1));
    parallel_bands(size.y, 1, options, [&](int first, int last) {
        for (int y = first; y < last; ++y) {
            ShadowErrors& e = rows[std::size_t(y)];
            for (std::size_t k = 0; k < truth.lights.size(); ++k)
                for (int x = 0; x < size.x; ++x) {
                    const std::size_t i = std::size_t(y) * std::size_t(size.x) + std::size_t(x);
                    const Point& p = truth.points[k][i];
                    if (!(p.unshadowed > 0)) continue;
                    const float v = visibility[truth.lights[k] * pixels + i], off = std::abs(v - (p.lit ? 1.0f : 0.0f));
                    ++(p.lit ? e.lit : e.dark);
                    if (p.lit) lit_light[std::size_t(y)] += p.unshadowed;
                    e.light += off * p.unshadowed;
                    glm::vec4& shown = where(x, y);
                    if (shown.x == shown.y && shown.y == shown.z) shown = glm::vec4(glm::vec3(0.1f + 0.4f * v), 1);
                    if (!(off <= unsure)) {
                        const bool edge = truth.rays[k].at_edge(p, reach);
                        ++(edge ? e.edge : p.lit ? e.acne : e.leak);
                        if (!edge) e.beside += off * p.unshadowed;
                        shown = edge ? glm::vec4(0, 0.6f, 0, 1) : p.lit ? glm::vec4(1, 0, 0, 1) : glm::vec4(0.2f, 0.4f, 1, 1);
                    }
                }
        }
    });
    ShadowErrors all;
    double light = 0;
    for (std::size_t y = 0; y < rows.size(); ++y) {
        const ShadowErrors& e = rows[y];
        all.lit += e.lit, all.dark += e.dark, all.acne += e.acne, all.leak += e.leak, all.edge += e.edge;
        all.light += e.light, all.beside += e.beside, light += lit_light[y];
    }
    if (!(light > 0)) throw InputError("shadows: no light reaches any pixel");
    all.light /= light, all.beside /= light;
    return all;
}

}  // namespace

std::vector<ShadowWay> shadow_ways() {
    // Texels of a kernel from -n/2 on, about the one that holds the projection; a square of n that is centred there; exponentials of
    // four texels, each a blur of 3 to every side.
    return {{"hard, depth", {"shadow.mode=hard", "shadow.test=depth"}, 1},
            {"hard, plane", {"shadow.mode=hard", "shadow.test=plane"}, 1},
            {"hard", {"shadow.mode=hard", "shadow.test=planes"}, 1},
            {"density 4, depth", {"shadow.mode=density", "shadow.kernel=4", "shadow.test=depth"}, 3},
            {"density 4", {"shadow.mode=density", "shadow.kernel=4", "shadow.test=planes"}, 3},
            {"pcf 1, depth", {"shadow.mode=pcf", "shadow.pcf_kernel=1", "shadow.test=depth"}, 1},
            {"pcf 1", {"shadow.mode=pcf", "shadow.pcf_kernel=1", "shadow.test=planes"}, 1},
            {"pcf 2", {"shadow.mode=pcf", "shadow.pcf_kernel=2", "shadow.test=planes"}, 1.5},
            {"pcf 3", {"shadow.mode=pcf", "shadow.pcf_kernel=3", "shadow.test=planes"}, 2},
            {"pcf 4", {"shadow.mode=pcf", "shadow.pcf_kernel=4", "shadow.test=planes"}, 2.5},
            {"esm", {"shadow.mode=esm"}, 4}};
}

std::vector<ShadowRow> measure_shadows(const Scene& given, const SceneOptions& set, const std::vector<ShadowWay>& ways,
                                       int size, int map, const RunOptions& options, const ShadowTell& tell) {
    Scene scene = given;
    scene.frame_size = {size, size};
    if (map > 0)
        for (Light& light : scene.lights) light.rsm_size = map;
    const Geometry geometry = flatten(scene);
    const raster::Surfaces surfaces = raster::prepare(scene, geometry);
    const auto query = reference::build_ray_query(geometry, surfaces, Rays::exact);
    glm::vec3 low, high;
    if (!bounds(geometry, low, high)) throw InputError(scene.name + ": the scene is empty");
    Truth truth;
    frame::KeptStages kept;
    std::vector<ShadowRow> rows;
    for (const ShadowWay& way : ways) {
        SceneOptions words = set;
        words.method = "direct";
        words.sets.insert(words.sets.end(), way.sets.begin(), way.sets.end());
        const frame::Settings settings = settings_of(scene, words);
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), options, kept);
        if (truth.lights.empty()) {
            tell("rays");
            for (std::size_t l = 0; l < scene.lights.size(); ++l) {
                const Light light = frame::shining(scene.lights[l]);
                if (!light.on || light.intensity == glm::vec3(0)) continue;
                truth.lights.push_back(l), truth.rays.emplace_back(*query, light, low, high);
                truth.points.emplace_back(f.gbuffer.position.size());
                std::vector<Point>& points = truth.points.back();
                parallel_bands(size, 1, options, [&](int first, int last) {
                    for (std::size_t i = std::size_t(first) * std::size_t(size); i < std::size_t(last) * std::size_t(size); ++i)
                        points[i] = truth.rays.back().at(f.gbuffer.position.texels[i], f.gbuffer.normal.texels[i]);
                });
            }
            if (truth.lights.empty()) throw InputError(scene.name + ": no light shines");
        }
        tell(way.name);
        ShadowRow row;
        row.scene = scene.name, row.way = way.name, row.size = size, row.map = scene.lights[truth.lights[0]].rsm_size;
        for (const frame::StageRun& s : f.stages)
            if (s.label.starts_with("shadow") && s.needed && !s.kept) row.ms += s.ms;
        row.errors = compare(truth, f.visibility, way.reach, options, f.gbuffer.position.empty() ? glm::ivec2(0) : glm::ivec2(size), row.where);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace plumb::cli
