// The model, camera, lights and settings of plumb experiment lra.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/camera.h"
#include "core/host_math.h"
#include "io/scenes/generate.h"
#include "tools/experiments/lra.h"
#include "tools/shared/options.h"

namespace plumb::cli {

namespace {

constexpr double spot_distance = 50;    // m: a cone of 90 degrees then holds a sphere of 35 m
constexpr float mirror = 0.1f;          // reflectance of all that there is
constexpr double fov_y_deg = 45;        // of the camera; the thesis does not say

glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Moves the model's bounds to the origin and scales them to the radius; returns half their extent.
glm::dvec3 fit_model(Scene& scene) {
    glm::vec3 low{0}, high{0};
    bounds(flatten(scene), low, high);
    const glm::dvec3 middle = (glm::dvec3(low) + glm::dvec3(high)) * 0.5, half = (glm::dvec3(high) - glm::dvec3(low)) * 0.5;
    const double scale = lra_half_width / std::sqrt(dot(half, half));
    glm::dmat4 fit(1);
    for (int i = 0; i < 3; ++i) fit[i][i] = scale, fit[3][i] = -scale * middle[i];
    for (Mesh& mesh : scene.meshes) mesh.transform = fit * mesh.transform;
    return half * scale;
}

// Sees all of a box around the origin in a square frame, from above one of its edges.
Camera camera_for(const glm::dvec3& half) {
    Camera camera;
    const glm::dvec3 forward = unit({0.35, -0.62, -0.7});
    const CameraAxes a = axes(forward, {0, 1, 0});
    const double t = host::tan(fov_y_deg * host::pi / 360);
    double distance = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z);
        const double side = std::max(std::abs(dot(corner, a.right)), std::abs(dot(corner, a.up)));
        distance = std::max(distance, side / t - dot(corner, forward));
    }
    camera.position = forward * -distance, camera.look_at = glm::dvec3(0), camera.fov_y_deg = fov_y_deg;
    camera.near = 0.1, camera.far = 400;
    return camera;
}

}  // namespace

// Ambient occlusion is the thesis' own of several views (LRA 4.3.2), with a constant for light from everywhere.
const std::vector<LraAlgorithm>& lra_algorithms() {
    static const std::vector<LraAlgorithm> all = {
        {"IS", {"reflect.march=steps", "reflect.views=lights"}},
        {"AO", {"ao.method=ssao", "ao.views=lights", "ao.ambient=0.1,0.1,0.1"}},
        {"ID", {"render.method=rsm"}},
    };
    return all;
}

std::vector<std::string> lra_all() {
    std::vector<std::string> names;
    for (const LraAlgorithm& a : lra_algorithms())
        if (!a.sets.empty()) names.push_back(a.name);
    return names;
}

bool lra_runs(const LraCase& row) {
    return std::all_of(row.algorithms.begin(), row.algorithms.end(), [](const std::string& name) {
        return std::any_of(lra_algorithms().begin(), lra_algorithms().end(),
                           [&](const LraAlgorithm& a) { return a.name == name && !a.sets.empty(); });
    });
}

LraWorld::LraWorld(const LraRequest& request) : request_(request), scene_(io::generate_scene("city", {request.triangles, 1}, "city")) {
    scene_.camera = camera_for(fit_model(scene_));
    scene_.lights.clear(), scene_.settings.clear();
    // What is covered mirrors a tenth: the thesis follows a ray from each fragment.
    for (Material& m : scene_.materials) m.reflectance *= 0.9f, m.specular = glm::vec3(0), m.mirror = glm::vec3(mirror);
    scene_.method = "direct", scene_.layout = "lra";
}

Light LraWorld::light(LraLight kind, int index, double turned_deg) const {
    // All around the model, above it: by the golden angle, so that any number of them is spread.
    const double around = 0.6 + 2.399963229728653 * index, turned = turned_deg * host::pi / 180;
    const double height = 0.7 + 0.05 * (index % 5);
    const glm::dvec3 from = unit({host::cos(around), height, host::sin(around)});
    Light light;
    light.name = fmt::format("{}{}", kind == LraLight::direct ? "direct" : kind == LraLight::spot ? "spot" : "point", index + 1);
    light.rsm_size = request_.map;
    // A turn about the vertical axis.
    const glm::dvec3 way(-(from.x * host::cos(turned) - from.z * host::sin(turned)), -from.y, -(from.x * host::sin(turned) + from.z * host::cos(turned)));
    light.direction = glm::vec3(way);
    const glm::vec3 tint(1.0f, 0.93f - 0.02f * float(index % 4), 0.8f + 0.05f * float(index % 3));
    if (kind == LraLight::direct) {
        light.type = LightType::directional, light.intensity = tint * 3.0f;
    } else {
        light.type = kind == LraLight::spot ? LightType::spot : LightType::point, light.cone_inner_deg = 40, light.cone_outer_deg = 45;
        light.position = glm::vec3(from * spot_distance);
        light.intensity = tint * float(3 * spot_distance * spot_distance);
    }
    return light;
}

Scene& LraWorld::scene(const LraCase& row) {
    for (Mesh& mesh : scene_.meshes) mesh.share = row.share;
    scene_.frame_size = size(row);
    scene_.lights.clear();
    for (std::size_t i = 0; i < row.lights.size(); ++i) scene_.lights.push_back(light(row.lights[i], int(i)));
    return scene_;
}

frame::Settings LraWorld::settings(const LraCase& row) const {
    SceneOptions options;
    // City's own disc, 60 m of its 600, and its floor, at the model's scale.
    options.sets = {"render.method=direct", "rsm.radius=0.08", "rsm.min_distance=0.15", "tonemap.operator=filmic",
                    fmt::format("rsm.samples={}", request_.samples), fmt::format("tonemap.exposure={}", 1.5 / double(std::max<std::size_t>(1, row.lights.size())))};
    for (const std::string& name : row.algorithms)
        for (const LraAlgorithm& a : lra_algorithms())
            if (a.name == name) options.sets.insert(options.sets.end(), a.sets.begin(), a.sets.end());
    return settings_of(scene_, options);
}

LraFragments LraWorld::fragments(const LraCase& row) {
    const Scene& s = scene(row);
    return count_fragments(flatten(s), make_view(s.camera, double(s.frame_size.x) / s.frame_size.y), s.frame_size);
}

}  // namespace plumb::cli
