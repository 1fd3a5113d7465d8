// Random views of plumb cameras.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/reference/reference.h"
#include "tools/plumb/cameras.h"

namespace plumb::cli {

namespace {

constexpr glm::ivec2 grid{24, 18};               // rays of a view: 4:3, as ISR's pictures
constexpr int feelers = 48;                      // rays that ask what is around a position
constexpr double most_backs = 0.1;               // of what feelers meet: surfaces seen from behind
constexpr double steepest = 0.5;                 // sine of the line of sight's elevation
constexpr double least_fov = 45, most_fov = 75;  // degrees

struct Hit {
    bool any = false, front = false;
    double distance = 0;
    glm::dvec3 point{0}, normal{0};  // unit, towards the ray
};

// The scene's surfaces and lamps for rays in double, one at a time.
class Probe {
  public:
    explicit Probe(const Scene& scene) : scene_(scene), paths_(reference::prepare(scene, Rays::exact)) {
        glm::vec3 low(0), high(0);
        if (!plumb::bounds(paths_->geometry, low, high)) throw InputError(scene.name + ": no triangles to look at");
        low_ = glm::dvec3(low) + glm::dvec3(paths_->anchor), high_ = glm::dvec3(high) + glm::dvec3(paths_->anchor);
    }
    const glm::dvec3& low() const { return low_; }
    const glm::dvec3& high() const { return high_; }
    double diagonal() const { return glm::length(high_ - low_); }

    Hit nearest(const glm::dvec3& origin, const glm::dvec3& direction) const {
        RayPacket<1> ray = packet(origin, direction, std::numeric_limits<float>::infinity());
        const std::int32_t active = -1;
        paths_->rays->nearest(&active, ray);
        Hit hit;
        if (ray.triangle[0] == no_hit) return hit;
        const glm::dvec3 normal(ray.normal_x[0], ray.normal_y[0], ray.normal_z[0]);
        const double length = glm::length(normal), facing = dot3(normal, direction);
        hit.any = true, hit.distance = ray.t_far[0], hit.front = facing < 0;
        hit.point = origin + hit.distance * direction;
        hit.normal = length > 0 ? (facing < 0 ? normal : -normal) / length : -direction;
        return hit;
    }

    // Whether any lamp sends light to the point.
    bool lit(const Hit& hit) const {
        for (const Light& light : scene_.lights)
            if (light.on && reaches(light, hit)) return true;
        return false;
    }

  private:
    static double dot3(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

    RayPacket<1> packet(const glm::dvec3& origin, const glm::dvec3& direction, float end) const {
        RayPacket<1> ray{};
        const glm::vec3 o(origin - glm::dvec3(paths_->anchor)), d(direction);
        ray.origin_x[0] = o.x, ray.origin_y[0] = o.y, ray.origin_z[0] = o.z;
        ray.direction_x[0] = d.x, ray.direction_y[0] = d.y, ray.direction_z[0] = d.z;
        ray.t_near[0] = 0, ray.t_far[0] = end;
        return ray;
    }

    bool reaches(const Light& light, const Hit& hit) const {
        const bool sun = light.type == LightType::directional;
        const glm::dvec3 way =
            sun ? -glm::dvec3(light.direction) * (2 * diagonal()) : glm::dvec3(light.position) - hit.point;
        const double distance = glm::length(way);
        if (!(distance > 0)) return false;
        const glm::dvec3 to = way / distance;
        if (dot3(hit.normal, to) <= 0) return false;
        if (!sun && light.radius > 0 && distance >= light.radius) return false;
        if (light.type == LightType::spot &&
            dot3(-to, glm::dvec3(light.direction)) < host::cos(light.cone_outer_deg * host::pi / 180))
            return false;
        // Off its own surface, and not into what the lamp hangs from.
        const double margin = 1e-4 * diagonal();
        RayPacket<1> ray = packet(hit.point + margin * hit.normal, to, float(distance - (sun ? 0 : margin)));
        const std::int32_t active = -1;
        paths_->rays->occluded(&active, ray);
        return !(ray.t_far[0] < 0);
    }

    const Scene& scene_;
    std::unique_ptr<reference::PathScene> paths_;
    glm::dvec3 low_{0}, high_{0};
};

double clearance(const Scene& scene, double diagonal) {
    return std::max(2 * scene.camera.near, std::min(0.25, 0.04 * diagonal));
}

ViewReport report_of(const Probe& probe, const Camera& camera) {
    ViewReport report;
    report.nearest = std::numeric_limits<double>::infinity();
    int surface = 0, lit = 0;
    for (int y = 0; y < grid.y; ++y)
        for (int x = 0; x < grid.x; ++x) {
            const Ray ray = ray_through_pixel(camera, grid, {x, y});
            const Hit hit = probe.nearest(ray.origin, ray.direction);
            if (!hit.any) continue;
            report.nearest = std::min(report.nearest, hit.distance);
            // What is seen from behind is drawn as well, but it is no view of the scene.
            if (!hit.front) continue;
            ++surface;
            lit += probe.lit(hit);
        }
    report.surface = double(surface) / (grid.x * grid.y), report.lit = double(lit) / (grid.x * grid.y);
    return report;
}

// Not inside a solid, and `free` metres from all that feelers meet.
bool is_free(const Probe& probe, const glm::dvec3& position, double free) {
    int hits = 0, backs = 0;
    for (int i = 0; i < feelers; ++i) {
        const glm::dvec2 u = hammersley(std::uint64_t(i), feelers);
        const double z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0, 1 - z * z)), angle = 2 * host::pi * u.y;
        const Hit hit = probe.nearest(position, {r * host::cos(angle), z, r * host::sin(angle)});
        if (!hit.any) continue;
        if (hit.distance < free) return false;
        ++hits, backs += !hit.front;
    }
    return hits > 0 && backs <= most_backs * hits;
}

// Random numbers of one attempt, by its number.
struct Draws {
    std::uint32_t view, attempt, seed;
    double operator()(std::uint32_t which) const {
        const Hash3<std::int32_t> h =
            pixel_hash(std::int32_t(view), std::int32_t(attempt), std::int32_t(which), std::int32_t(seed));
        return double(std::uint32_t(h.x)) * 0x1p-32;
    }
};

// A number that six decimals hold, so that a list is easy to read and says what was judged.
double rounded(double v) { return std::nearbyint(v * 1e6) / 1e6; }
glm::dvec3 rounded(const glm::dvec3& v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }

std::optional<Camera> draw(const Probe& probe, const Scene& scene, const Draws& draws, const RandomViews& wanted) {
    const glm::dvec3 u(draws(0), draws(1), draws(2));
    const double free = clearance(scene, probe.diagonal());
    Camera camera = scene.camera;
    camera.position = rounded(probe.low() + u * (probe.high() - probe.low()));
    if (!is_free(probe, camera.position, free)) return std::nullopt;
    const double bearing = 2 * host::pi * draws(3), rise = steepest * (2 * draws(4) - 1);
    const double level = std::sqrt(1 - rise * rise);
    camera.look_at =
        rounded(camera.position + glm::dvec3(level * host::sin(bearing), rise, level * host::cos(bearing)));
    camera.up = {0, 1, 0};
    camera.fov_y_deg = rounded(least_fov + (most_fov - least_fov) * draws(5));
    const ViewReport report = report_of(probe, camera);
    if (report.surface < wanted.surface || report.lit < wanted.lit || report.nearest < free) return std::nullopt;
    return camera;
}

}  // namespace

double view_clearance(const Scene& scene) { return clearance(scene, Probe(scene).diagonal()); }

ViewReport report_of_view(const Scene& scene) { return report_of(Probe(scene), scene.camera); }

std::vector<io::ListedCamera> random_views(const Scene& scene, const std::string& scene_word, const std::string& prefix,
                                           const RandomViews& wanted) {
    const Probe probe(scene);
    std::vector<io::ListedCamera> views;
    for (int v = 0; v < wanted.count; ++v) {
        std::optional<Camera> camera;
        for (int a = 0; a < wanted.attempts && !camera; ++a)
            camera = draw(probe, scene, {std::uint32_t(v), std::uint32_t(a), wanted.seed}, wanted);
        if (!camera)
            throw InputError(
                fmt::format("{}: no view in {} attempts: expected a scene with {:g} % surface and {:g} % "
                            "lamplight somewhere in its bounds",
                            scene_word, wanted.attempts, 100 * wanted.surface, 100 * wanted.lit));
        io::ListedCamera listed;
        listed.scene = scene_word, listed.name = fmt::format("{}_{:02}", prefix, v + 1);
        listed.position = camera->position, listed.look_at = camera->look_at, listed.up = camera->up;
        listed.fov_y_deg = camera->fov_y_deg;
        views.push_back(listed);
    }
    return views;
}

}  // namespace plumb::cli
