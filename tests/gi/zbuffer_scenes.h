// Points on a plane, lamps and vertices made by hand, for the stages of gi/zbuffer.
#pragma once

#include <vector>

#include "core/host_math.h"
#include "gi/zbuffer/zbuffer.h"

namespace plumb::test {

inline double radians(double degrees) { return degrees * host::pi / 180; }
inline glm::vec3 at_angle(double degrees) { return {float(host::sin(radians(degrees))), 0, float(host::cos(radians(degrees)))}; }

inline Light sun_from(const glm::vec3& towards, const glm::vec3& irradiance = glm::vec3(3)) {
    Light light;
    light.type = LightType::directional, light.direction = -towards, light.intensity = irradiance;
    return light;
}

// Pixels of the plane z = 0 that a triangle covers, from (-4, -4) to (12, -4) to (-4, 12), all at the origin until they are moved.
struct PlanePixels {
    Image4 position, normal, albedo, emission;
    Image<glm::ivec2> id;
    zbuffer::VertexTable table;
    std::vector<Light> lights;

    explicit PlanePixels(int n, const glm::vec4& specular = {0.25f, 0.5f, 1, 10})
        : position(n, 1, glm::vec4(0)), normal(n, 1, glm::vec4(0, 0, 1, 1)), albedo(n, 1, glm::vec4(0.5f, 0.25f, 1, 0)),
          emission(n, 1, glm::vec4(0)), id(n, 1, glm::ivec2(0)) {
        table.vertices = {{-4, -4, 0, 0}, {0, 0, 1, 0}, {12, -4, 0, 0}, {0, 0, 1, 0}, {-4, 12, 0, 0}, {0, 0, 1, 0}};
        table.kinds = {{0, 0}, {0, 0}, {0, 0}};
        table.corners = {{0, 1, 2, 0}};
        table.materials = {{0.5f, 0.25f, 1, 0}, specular};
        table.objects = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    }
    zbuffer::PixelsInputs inputs(const glm::vec3& eye) const { return {&position, &normal, &albedo, &emission, &id, &table, &lights, eye}; }
};

inline zbuffer::PixelLight lit_pixels(const zbuffer::ZbufferParams& params, const PlanePixels& p, const glm::vec3& eye, const RunOptions& options = {}) {
    zbuffer::PixelLight out;
    zbuffer::run(params, p.inputs(eye), options, out);
    return out;
}
inline zbuffer::VertexLight lit_vertices(const zbuffer::ZbufferParams& params, const zbuffer::VertexTable& table, const std::vector<Light>& lights,
                                         const glm::vec3& eye, const RunOptions& options = {}) {
    zbuffer::VertexLight out;
    zbuffer::run(params, zbuffer::VerticesInputs{&table, &lights, eye}, options, out);
    return out;
}
// Vertices, then pixels.
inline zbuffer::PixelLight interpolated(const zbuffer::ZbufferParams& params, const PlanePixels& p, const glm::vec3& eye, const RunOptions& options = {}) {
    const zbuffer::VertexLight light = lit_vertices(params, p.table, p.lights, eye, options);
    zbuffer::PixelLight out;
    zbuffer::run(params, zbuffer::InterpolateInputs{&p.position, &p.id, &p.emission, &p.table, &light, eye}, options, out);
    return out;
}

inline zbuffer::ZbufferParams params_of(zbuffer::Technique technique, const glm::vec3& ambient = glm::vec3(0)) {
    zbuffer::ZbufferParams p;
    p.technique = technique, p.ambient = ambient;
    return p;
}

}  // namespace plumb::test
