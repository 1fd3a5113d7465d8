// Parts of a scene file that stand alone. Private to io/.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "io/toml_reader.h"

namespace plumb::io {

// [[mesh]]: matrix, or scale, rotate_deg and translate.
glm::dmat4 read_transform(TomlReader& mesh);

// scale: a number or three, none of them 0; 1 where it is not there.
glm::dvec3 read_scale(TomlReader& mesh);

// cone_deg: inner and outer half angle; none where it is not there.
std::optional<glm::dvec2> read_cone(TomlReader& light);

// `key`: an angle in degrees and an axis of any length; none where it is not there.
struct Turn {
    double angle_deg;
    glm::dvec3 axis;  // unit
};
std::optional<Turn> read_turn(TomlReader& reader, const char* key);

// yaw_deg, pitch_deg: where one looks who turns from -z by yaw, counter-clockwise seen from above, and looks up by pitch;
// unit; none where neither is there.
std::optional<glm::dvec3> read_yaw_pitch(TomlReader& reader);

// [[light]]; its name must be none of the others'.
Light read_light(TomlReader& reader, const std::vector<Light>& others);

// [[material]]: its numbers; what is not given stays. `m` reflects no more than it receives, or InputError says where.
void read_surface(TomlReader& reader, Material& m);

// [environment]: radiance, and a map beside the scene file `path`.
void read_environment(TomlReader& reader, const std::string& path, Scene& scene);

// Names of lights become names of layers: 1 to 64 letters, digits, _ or -, each once.
bool is_layer_name(const std::string& name);
// `name`, changed where it is not one or is another light's.
std::string layer_name(std::string name, const std::vector<Light>& others);

}  // namespace plumb::io
