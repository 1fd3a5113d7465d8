#include "io/scenes/generate.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/fields.h"

namespace plumb::io {

const std::vector<GeneratedScene>& generated_scenes() {
    static const std::vector<GeneratedScene> scenes = {
    };
    return scenes;
}

Scene generate_scene(const std::string& name, const GenerateOptions& options, const std::string& place) {
    std::vector<std::string> names;
    for (const GeneratedScene& scene : generated_scenes()) {
        names.push_back(scene.name);
        if (name != scene.name) continue;
        GenerateOptions wanted = options;
        if (wanted.triangles == 0) wanted.triangles = scene.triangles;
        if (wanted.triangles < scene.least_triangles || wanted.triangles > scene.most_triangles)
            throw InputError(fmt::format("{}: triangles = {}: \"{}\" is built from {} to {}", place, options.triangles,
                                         name, scene.least_triangles, scene.most_triangles));
        return scene.generate(wanted);
    }
    throw InputError(fmt::format("{}: unknown scene \"{}\"; the nearest known one is \"{}\"", place, name,
                                 nearest_name(name, names)));
}

}  // namespace plumb::io
