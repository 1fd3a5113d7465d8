// Procedural scenes by name: complete, with camera, lights and settings.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

struct GenerateOptions {
    std::int64_t triangles = 0;  // about so many; 0: what the scene is meant to have
    std::uint32_t seed = 1;      // of scenes that have variants
};

struct GeneratedScene {
    const char* name;
    const char* summary;          // one line: what it shows and where it comes from
    std::int64_t triangles;       // by default
    std::int64_t least_triangles; // below which it cannot be built
    std::int64_t most_triangles;
    Scene (*generate)(const GenerateOptions& options);
};

// Every scene, in the order of the list that `plumb make-scene` prints.
const std::vector<GeneratedScene>& generated_scenes();

// Throws InputError at `place` for an unknown name (naming the nearest) and for a number of triangles out of its range.
Scene generate_scene(const std::string& name, const GenerateOptions& options, const std::string& place);

namespace scenes {
Scene box(const GenerateOptions& options);
Scene shapes(const GenerateOptions& options);
Scene hemicube_box(const GenerateOptions& options);
Scene hemicube_shapes(const GenerateOptions& options);
Scene furnace(const GenerateOptions& options);
Scene furnace_cube(const GenerateOptions& options);
Scene atrium(const GenerateOptions& options);
Scene hall(const GenerateOptions& options);
Scene city(const GenerateOptions& options);
Scene rooms(const GenerateOptions& options);
Scene stress(const GenerateOptions& options);
Scene container(const GenerateOptions& options);
Scene character(const GenerateOptions& options);
Scene alcove(const GenerateOptions& options);
}  // namespace scenes

}  // namespace plumb::io
