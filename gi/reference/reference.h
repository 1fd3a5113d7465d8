// The truth: radiance and irradiance by path tracing, with their standard errors. See gi/reference/README.md.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/fields.h"
#include "core/image.h"
#include "core/isa.h"
#include "core/ray_query.h"
#include "core/scene.h"
#include "core/stage.h"
#include "gi/reference/environment.h"
#include "gi/reference/lights.h"
#include "gi/reference/mirrors.h"
#include "raster/surfaces.h"

namespace plumb::reference {

// Which light is counted, by how often it was reflected before it reached the surface that is asked about:
// direct: never; one_bounce: exactly once; indirect: once or more often; all: everything. Of a camera's pixel, `direct`
// and `all` also hold what the surface emits. ambient_occlusion: not light, but the share of the cosine-weighted
// hemisphere that is open (1: nothing near, 0: closed).
enum class Mode : int { all, direct, one_bounce, indirect, ambient_occlusion };
// Where in its pixel a camera ray starts: at the centre, as the rasterizer's sample, or anywhere (box filter).
enum class Filter : int { centre, box };
// Light that meets several of a rough surface's facets: multiple: counts; single: is lost, as in glTF's appendix B.
enum class Microfacets : int { multiple, single };

struct PathParams {
    Mode mode = Mode::all;
    int samples = 256;          // a pixel; rounded up to whole rounds
    int rounds = 16;            // independent estimates of that number of samples, at least
    float until_error = 0;      // above 0: rounds until the relative standard error of the picture is at most this
    int max_samples = 65536;    // where until_error gives up
    int max_bounces = 0;        // 0: no limit but Russian roulette
    float roulette = 0.5f;      // throughput below which chance may end a path
    Rays rays = Rays::native;
    Filter filter = Filter::centre;
    float ao_distance = 0;      // m: what is farther does not occlude; 0: no limit
    Microfacets microfacets = Microfacets::multiple;
};
std::vector<Field> fields(PathParams& params);

// A scene as rays need it. Holds pointers into itself: it is made once, in place, and does not move.
struct PathScene {
    glm::vec3 anchor{0};            // m: the point of the world that is the origin of all that follows
    Geometry geometry;
    raster::Surfaces surfaces;
    Buffer<float> reflection;       // [material][8]: specular, exponent; mirror, padding
    bool any_glossy = false;        // whether any material has a specular or a mirror part
    Buffer<float> microfacets;      // MicrofacetArgs::materials
    bool any_microfacets = false;
    LightTable lights;              // lamps, emitting triangles and the environment, and how to choose among them
    MirrorTable mirrors;
    EnvironmentTable environment;
    std::unique_ptr<RayQuery> rays;

    PathScene() = default;
    PathScene(const PathScene&) = delete;
    PathScene& operator=(const PathScene&) = delete;
};

// A scene that lies farther from the origin than eight times its size is moved there, which rounds nothing: rays then keep
// off its surfaces by a share of its own size (README.md, "Where a ray starts"). Throws InputError that names the material
// where reflectance + specular + mirror is above 1 in some channel, or metalness or roughness not within 0..1.
std::unique_ptr<PathScene> prepare(const Scene& scene, Rays rays);

// What a run found, one value a pixel or point.
struct Estimate {
    Image4 mean;                 // radiance, W/(m2 sr), or irradiance, W/m2; w = 0
    Image4 error;                // standard error of the mean, by channel, from independent rounds; w = 0
    int samples = 0;             // a pixel
    int rounds = 0;              // independent estimates that the standard error stands on
    std::uint64_t rays = 0;      // traced
    std::size_t nonfinite = 0;   // values that are not finite: nothing is clamped and nothing is hidden
    double relative_error = 0;   // sqrt(mean of error^2) / mean of mean, over all pixels and channels
};

// Radiance towards the camera through every pixel of a frame of `size` pixels.
Estimate trace(const PathParams& params, const PathScene& scene, const Camera& camera, glm::ivec2 size,
               std::uint32_t seed, const RunOptions& options);

// Irradiance (ambient_occlusion: openness) at given points: the truth of the layers `direct` and `indirect`. Where the
// normal is 0 there is no point, and the result is 0. Emission of the points' own surface is not part of it. Throws
// InputError where points as floats are not known well enough: where 2^-19 of the scene's largest coordinate, by which
// their rays keep off surfaces, is more than 1/64 of its size.
struct PointInputs {
    const Image4* position = nullptr;  // xyz world, m
    const Image4* normal = nullptr;    // xyz unit
};
Estimate trace_irradiance(const PathParams& params, const PathScene& scene, const PointInputs& points,
                          std::uint32_t seed, const RunOptions& options);

// Radiance that arrives at given points along the rays of which a perfect mirror there makes rays to the eye.
Estimate trace_reflection(const PathParams& params, const PathScene& scene, const PointInputs& points,
                          const glm::dvec3& eye, std::uint32_t seed, const RunOptions& options);

StageInfo info();

}  // namespace plumb::reference
