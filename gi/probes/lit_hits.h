// What rays from probes find to shine: of each ray the surface that it meets, what that emits and reflects, and the light that
// reaches it from lamps. Relight rays (relight.h) tell the same places without light; DDGI's probes ask here, too.
//
// Lamps are points and suns; light of emitting surfaces and of the sky arrives along rays that meet them.
#pragma once

#include <memory>

#include "core/image.h"
#include "core/isa.h"
#include "core/ray_query.h"
#include "core/scene.h"
#include "gi/reference/lights.h"
#include "raster/surfaces.h"

namespace plumb::probes {

// A scene as such rays need it. Holds pointers into itself: made once, in place.
struct LitScene {
    Geometry geometry;
    raster::Surfaces surfaces;
    reference::EnvironmentTable environment;
    reference::LightTable lights;
    std::unique_ptr<RayQuery> query;
    float offset = 0;  // m, off surfaces: offset_of()

    LitScene() = default;
    LitScene(const LitScene&) = delete;
    LitScene& operator=(const LitScene&) = delete;
};
std::unique_ptr<LitScene> lit_scene(const Scene& scene, Rays rays);

// Rows: probes; columns: rays of each.
struct LitHits {
    Image4 position;  // xyz m; w: 1 a front, -1 a back, 0 nothing was met
    Image4 normal;    // unit, shading, towards the probe; 0 but for fronts
    Image4 towards;   // unit, back along the ray; w: distance m, 0 where nothing was met
    Image4 albedo;    // diffuse; 0 but for fronts
    Image4 emitted;   // radiance that the surface emits, or the sky's, W/(m2 sr); 0 of backs
    Image4 direct;    // irradiance by lamps, W/m2; 0 but for fronts
    std::uint64_t rays = 0;  // traced, those to lamps included
};

// origins: xyz m; directions: unit, the same for all. Throws InputError where there are more than 32767 of either.
LitHits lit_hits(const LitScene& scene, const Buffer<glm::vec4>& origins, const Buffer<glm::vec4>& directions,
                 const RunOptions& options);

// Irradiance by lamps at points: rows and columns as given; 0 where the normal is 0. Counts its rays.
Image4 lamp_irradiance(const LitScene& scene, const Image4& position, const Image4& normal, const RunOptions& options,
                       std::uint64_t* rays = nullptr);

}  // namespace plumb::probes
