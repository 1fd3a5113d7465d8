#include "gi/probes/static_light.h"

#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "raster/light_view.h"

namespace plumb::probes {

namespace {

// What a lamp sends to a point, were nothing between: irradiance across its rays, W/m2, and the unit direction to it; distance: m, of
// a directional one infinite.
struct Sent {
    glm::dvec3 irradiance{0}, towards{0};
    double distance = HUGE_VAL;
};
Sent sent_to(const glm::dvec3& x, const raster::LightArgs& lamp) {
    const glm::dvec3 axis(lamp.direction[0], lamp.direction[1], lamp.direction[2]);
    if (lamp.directional > 0) return {glm::dvec3(lamp.intensity[0], lamp.intensity[1], lamp.intensity[2]), -axis};
    const glm::dvec3 d = glm::dvec3(lamp.position[0], lamp.position[1], lamp.position[2]) - x;
    const double d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    if (!(d2 > 0)) return {};  // in the lamp
    const double distance = std::sqrt(d2);
    const glm::dvec3 w = d / distance;
    const double cosine = -(w.x * axis.x + w.y * axis.y + w.z * axis.z);
    const vec3<float> intensity = raster::light_intensity<float>(lamp, float(cosine), float(d2));
    return {glm::dvec3(intensity.x, intensity.y, intensity.z) / d2, w, distance};
}

bool is_shadowed(const glm::dvec3& x, const Sent& sent, const RayQuery& query, float offset) {
    RayPacket<1> ray{};
    const glm::vec3 from(x), to(sent.towards);
    ray.origin_x[0] = from.x, ray.origin_y[0] = from.y, ray.origin_z[0] = from.z;
    ray.direction_x[0] = to.x, ray.direction_y[0] = to.y, ray.direction_z[0] = to.z;
    ray.t_far[0] = std::min(float(sent.distance) - offset, 1e18f);
    if (!(ray.t_far[0] > 0)) return false;
    const std::int32_t active = -1;
    query.occluded(&active, ray);
    return ray.t_far[0] < 0;
}

}  // namespace

Buffer<glm::vec4> static_light(const Spatial& s, SpatialWeight weight, const std::vector<Light>& lamps, const RayQuery& query, float offset) {
    const std::size_t places = std::size_t(s.grid.places());
    Buffer<glm::vec4> light(places * spatial_directions, glm::vec4(0));
    std::vector<raster::LightArgs> args;
    for (const Light& lamp : lamps) args.push_back(raster::light_args(lamp));
    for (std::size_t i = 0; i < places; ++i) {
        glm::dvec3 sum[spatial_directions] = {};
        const glm::dvec3 x(s.receivers.position[i]);
        for (const raster::LightArgs& lamp : args) {
            const Sent sent = sent_to(x, lamp);
            if (sent.irradiance == glm::dvec3(0) || is_shadowed(x, sent, query, offset)) continue;
            for (int d = 0; d < spatial_directions; ++d) {
                const glm::dvec3 along(spatial_direction(d));
                const double cosine = std::min(1.0, along.x * sent.towards.x + along.y * sent.towards.y + along.z * sent.towards.z);
                if (!(cosine > 0)) continue;
                sum[d] += sent.irradiance * (weight == SpatialWeight::corrected ? cosine : host::asin(cosine) * 2 / host::pi);
            }
        }
        for (int d = 0; d < spatial_directions; ++d) light[i * spatial_directions + std::size_t(d)] = glm::vec4(glm::vec3(sum[d]), 0);
    }
    return light;
}

}  // namespace plumb::probes
