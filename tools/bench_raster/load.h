// Scenes as both sides draw them: resident, without what only one of them would draw.
#pragma once

#include <string>

#include "core/scene.h"
#include "core/view.h"
#include "raster/surfaces.h"

namespace plumb::bench {

struct Resident {
    std::string name;
    Scene scene;  // materials, textures and camera; its meshes are gone
    Geometry geometry;
    raster::Surfaces surfaces;

    std::size_t triangles() const { return geometry.triangles.size(); }
    View view(glm::ivec2 size) const { return make_view(scene.camera, double(size.x) / size.y); }
    // Of geometry, materials and textures.
    std::size_t bytes() const;
};

// A generated scene with about so many triangles (0: its own number), world space, normal maps left out.
Resident load(const std::string& name, std::int64_t triangles);

// True where the scene can be built from about so many.
bool can_build(const std::string& name, std::int64_t triangles);

}  // namespace plumb::bench
