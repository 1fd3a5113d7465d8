// Reads words of the command line: settings, pixels, lights.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/fields.h"
#include "core/scene.h"
#include "gi/frame/settings.h"

namespace plumb::cli {

// "table.key=value": [1, 2, 3] or 1,2,3 is a vector, true and false are truth values, what reads as a number is one,
// all else is a word, with or without quotes.
struct Assignment {
    std::string table, key;
    FieldValue value;
    std::string place;  // "--set rsm.samples"
};
Assignment parse_assignment(const std::string& text);
FieldValue parse_value(const std::string& text);

// "X,Y", both whole and at least 0.
glm::ivec2 parse_pixel(const std::string& text);

// "WxH" in pixels, 1024x768 say: each side `least` to 32767, and at most 2^28 pixels, as the rasterizer draws them. Throws
// InputError that names the option.
glm::ivec2 parse_size(const std::string& option, const std::string& text, int least = 1);

// The scene of a command that renders, and what is set in place of its file's settings.
struct SceneOptions {
    std::string file, method;
    std::string preset;  // frame::presets(); empty: none
    std::string size;  // "WxH" in place of the scene's own; empty: its own
    std::vector<std::string> sets;
    bool no_pruning = false;
    bool strict = false;  // refuse what io::LoadOptions says

    // Of what is path traced; words in place of [reference]: samples, until_error, rays. Empty: as it stands there.
    bool truth = false, no_cache = false;
    std::string samples, until_error, rays;
};

// The scene file's settings, then those of --preset, then --method, then every --set in its order, then what --truth goes with.
frame::Settings settings_of(const Scene& scene, const SceneOptions& options);

// Index of the light; throws InputError that names the nearest.
int find_light(const Scene& scene, const std::string& name);

// Each light's name as a part of a file's name: letters, digits, '-' and '_', and no two alike.
std::vector<std::string> light_file_names(const Scene& scene);
std::string file_name(const std::string& text);

}  // namespace plumb::cli
