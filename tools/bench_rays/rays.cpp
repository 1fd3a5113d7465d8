#include "tools/bench_rays/rays.h"

#include <cmath>

#include "core/camera.h"
#include "core/hash.h"
#include "gi/reference/ray_query.h"
#include "io/scene_file.h"
#include "io/scenes/generate.h"

namespace plumb::bench {
namespace {

// Uniform in the cube of +-1.
glm::vec3 random_in_cube(std::int32_t i, std::int32_t stream) {
    const auto h = pcg3d<std::int32_t>(i, stream, 7);
    const auto unit = [](std::int32_t x) { return float(std::uint32_t(x) >> 8) * 0x1p-23f - 1; };
    return {unit(h.x), unit(h.y), unit(h.z)};
}

// Cosine-weighted about n: a point of the unit sphere, moved by n.
glm::vec3 random_about(const glm::vec3& n, std::int32_t i) {
    for (std::int32_t attempt = 0;; ++attempt) {
        const glm::vec3 p = random_in_cube(i, 100 + attempt);
        const float length2 = glm::dot(p, p);
        if (length2 <= 1 && length2 > 1e-4f) return n * 1.0001f + p / std::sqrt(length2);
    }
}

}  // namespace

World load_world(const std::string& name, const std::string& root) {
    World world;
    world.name = name;
    const bool masks = name == "atrium+masks";
    world.scene = name == "cornell"
                      ? io::load_scene(root + "/data/scenes/cornell/cornell.toml", {"rsm", "shadow", "reference"})
                      : io::generate_scene(masks ? "atrium" : name, {}, "bench");
    if (!masks)
        for (Material& m : world.scene.materials) m.alpha_cutoff = 0;
    world.geometry = flatten(world.scene);
    world.surfaces = raster::prepare(world.scene, world.geometry);
    return world;
}

RaySet make_rays(const World& world, glm::ivec2 size) {
    RaySet rays;
    for (int block = 0; block < size.x / 4 * (size.y / 4); ++block)
        for (int k = 0; k < 16; ++k) {
            const glm::ivec2 pixel(block % (size.x / 4) * 4 + k % 4, block / (size.x / 4) * 4 + k / 4);
            const Ray ray = ray_through_pixel(world.scene.camera, size, pixel);
            rays.primary.push_back({ray.origin, ray.direction});
        }

    glm::vec3 low(0), high(0);
    bounds(world.geometry, low, high);
    const glm::vec3 middle = (low + high) * 0.5f, half = (high - low) * 0.5f;
    const float step = 1e-5f * std::sqrt(glm::dot(half, half));
    const auto query = reference::build_ray_query(world.geometry, world.surfaces, Rays::exact);
    for (std::int32_t i = 0; i < std::int32_t(rays.primary.size()); ++i) {
        const BenchRay& r = rays.primary[std::size_t(i)];
        RayPacket<1> p{};
        p.origin_x[0] = r.origin.x, p.origin_y[0] = r.origin.y, p.origin_z[0] = r.origin.z;
        p.direction_x[0] = r.direction.x, p.direction_y[0] = r.direction.y, p.direction_z[0] = r.direction.z;
        p.t_far[0] = r.t_far;
        const std::int32_t active = -1;
        query->nearest(&active, p);
        if (p.triangle[0] == no_hit) continue;
        glm::vec3 n(p.normal_x[0], p.normal_y[0], p.normal_z[0]);
        n = n / std::sqrt(glm::dot(n, n)) * (glm::dot(n, r.direction) > 0 ? -1.0f : 1.0f);
        const glm::vec3 point = r.origin + r.direction * p.t_far[0] + n * step;
        rays.bounce.push_back({point, random_about(n, i)});
        rays.shadow.push_back({point, middle + half * random_in_cube(i, 1) - point, 0, 0.9999f});
    }
    return rays;
}

}  // namespace plumb::bench
