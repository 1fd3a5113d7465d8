// A scene as a script of POV-Ray 3.7, for a second opinion on its light.
//
// What POV-Ray writes for it to an EXR is radiance in W/(m2 sr): see README.md, "POV-Ray", for the units, for what each
// part of the scene becomes, and for what POV-Ray cannot show.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io {

// published: the radiosity block of ISR table 1. Its brightness of 2.4 multiplies light at every gather: not physical.
// physical: brightness 1, and finer. direct: no radiosity, so neither what emits nor the environment lights anything.
enum class PovPreset : int { published, physical, direct };

struct PovOptions {
    PovPreset preset = PovPreset::physical;
    glm::ivec2 size{0, 0};  // pixels, for the camera's aspect; 0: the scene's frame
    int bounces = 8;        // of preset physical: reflections before the light reaches the surface that is seen, 1 to 20
    int samples = 400;      // of preset physical: rays a gather, 1 to 1600
    double brightness = 2.4;  // of preset published: table 1's, and Listing 9's
    bool shadowless = false;  // no lamp casts a shadow, as in ISR's modes F3 and F5 and in Listing 9
};

// Throws InputError, naming what it is, for numbers that are not finite and for
// options out of range. The script of one scene is the same on every machine.
std::string pov_text(const Scene& scene, const PovOptions& options = {});
// What the script leaves out or replaces of this scene, a line each; the script begins with them.
std::vector<std::string> pov_notes(const Scene& scene, const PovOptions& options = {});
// The script is complete at that path, or what was there before. Throws InputError.
void write_pov(const std::string& path, const Scene& scene, const PovOptions& options = {});

// The program and its arguments that render the script to an EXR of radiance: one work thread, because several are not
// repeatable; no antialiasing. Throws InputError for a path that holds both kinds of quotes.
std::vector<std::string> povray_command(const std::string& script, const std::string& picture, glm::ivec2 size);
// The same for a POSIX shell, quoted.
std::string povray_command_line(const std::string& script, const std::string& picture, glm::ivec2 size);

// The scene that the script shows: textures and an environment map replaced by their means, and what pov_notes() names
// left out. Compare POV-Ray's picture with one of this.
Scene pov_scene(const Scene& scene);

}  // namespace plumb::io
