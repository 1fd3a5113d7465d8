#include "io/scenes/generate.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/scene_model.h"

namespace plumb::io {

const std::vector<GeneratedScene>& generated_scenes() {
    static const std::vector<GeneratedScene> scenes = {
        {"box", "an empty box with a lamp in its ceiling (HEM plate C.9); 12 n^2 triangles", 1200, 12, 10'000'000,
         scenes::box},
        {"shapes", "a box with a sphere and a torus (HEM plate C.10)", 8'000, 38, 10'000'000, scenes::shapes},
        {"hemicube_box", "HEM 5.8's box with its counts of vertices and triangles; its lamp alone lights it", 1'200, 108,
         10'000'000, scenes::hemicube_box},
        {"hemicube_shapes", "HEM plate C.10 as radiosity has it: that box, a sphere and a torus", 4'980, 448, 10'000'000,
         scenes::hemicube_shapes},
        {"furnace", "a closed sphere that emits and reflects: B = M / (1 - rho) everywhere", 5'120, 20, 10'000'000,
         scenes::furnace},
        {"furnace_cube", "a closed cube that emits and reflects: B = M / (1 - rho) everywhere", 1'200, 12, 10'000'000,
         scenes::furnace_cube},
        {"atrium", "a courtyard with arcades, curtains and a fountain: the kind of place that VRSM calls Sponza",
         262'000, 7'000, 4'000'000, scenes::atrium},
        {"hall", "a vaulted hall open to the sun, after IPR's Open Hall", 150'000, 14'000, 4'000'000, scenes::hall},
        {"city", "a historic city by a river, 600 m wide (LRA 7.1's Rome); a second light stands for the sky",
         4'000'000, 1'000, 20'000'000, scenes::city},
        {"rooms", "a furnished flat, another one for every seed", 60'000, 20'000, 4'000'000, scenes::rooms},
        {"stress", "degenerate and extreme triangles, a case a cell", 20'000, 2'000, 4'000'000, scenes::stress},
        {"container", "a cargo container to be moved through other scenes (IPR figure 5.20)", 2'400, 600, 400'000,
         scenes::container},
        {"character", "a figure in mid-stride to be moved through other scenes", 4'800, 1'600, 400'000, scenes::character},
        {"alcove", "a room of squared stone lit from one side, its joints a normal map (IPR figure 5.23)", 1'200, 60, 400'000, scenes::alcove},
    };
    return scenes;
}

Scene generate_scene(const std::string& name, const GenerateOptions& options, const std::string& place) {
    // A name of the command line has no file around it.
    const std::string at = place.empty() ? "" : place + ": ";
    std::vector<std::string> names;
    for (const GeneratedScene& scene : generated_scenes()) {
        names.push_back(scene.name);
        if (name != scene.name) continue;
        GenerateOptions wanted = options;
        if (wanted.triangles == 0) wanted.triangles = scene.triangles;
        if (wanted.triangles < scene.least_triangles || wanted.triangles > scene.most_triangles)
            throw InputError(fmt::format("{}triangles = {}: \"{}\" is built from {} to {}", at, options.triangles, name,
                                         scene.least_triangles, scene.most_triangles));
        Scene made = scene.generate(wanted);
        complete_tangents(made);
        return made;
    }
    throw InputError(fmt::format("{}unknown scene \"{}\"{}", at, name, nearest_known(name, names, "\"\"")));
}

}  // namespace plumb::io
