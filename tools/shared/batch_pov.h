// Model pictures by POV-Ray.
#pragma once

#include <string>

#include "core/image.h"
#include "core/scene.h"
#include "io/pov.h"

namespace plumb::cli {

// Runs povray on `script`, writing `picture`; its words go to `log`. Returns the seconds that it took. Throws
// InputError with its last line where it fails or is not installed.
double run_povray(const std::string& script, const std::string& picture, glm::ivec2 size, const std::string& log);

// The scene through a script in a temporary folder.
struct PovPicture {
    Image4 radiance;  // W/(m2 sr)
    double seconds = 0;
};
PovPicture pov_picture(const Scene& scene, glm::ivec2 size, io::PovPreset preset);

// The colours of a picture in a file, w = 1. Throws InputError for another size.
Image4 read_radiance(const std::string& path, glm::ivec2 size);

}  // namespace plumb::cli
