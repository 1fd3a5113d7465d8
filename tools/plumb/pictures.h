// A frame's buffers as the layers of files, by the names that scripts rely on.
#pragma once

#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "gi/frame/reflect_classes.h"
#include "io/image_file.h"
#include "tools/shared/outputs.h"

namespace plumb::cli {

// What a scene's pictures are named after: "cornell" for scenes/cornell.toml.
std::string picture_name(const Scene& scene);

// Writes <name>.exr, a <name>.rsm.<light>.exr for each map that was drawn (it has a size of its own), and <name>.png. A shadow.<light> or an RSM is there where its stage ran; truth (and <name>.truth.png), truth.direct and
// truth.indirect, each with its standard error, where they were traced; direct and indirect unless the picture itself is
// path traced; glossy where probes.relief ran, and the layers diffuse, normals and specular, each with a <name>.<layer>.png, with
// probes.layers; sent of the method zbuffer (emission and pi times highlights, W/m2), and <name>.vertex_normals.png with
// zbuffer.normals; reflection where mirrors reflect, and reflection.class with `classes` (the number of a MirrorClass); every
// other layer always.
void write_pictures(const Scene& scene, const frame::Plan& plan, const frame::Frame& frame, const std::string& name,
                    Outputs& outputs, const frame::MirrorClasses* classes = nullptr);

// Writes every buffer that a stage reads or writes into dump/, once each and named after the stage that made it, and
// dump/dump.json, which binds them to the stages' ports.
void write_dump(const Scene& scene, const frame::Settings& settings, const frame::Plan& plan, const frame::Frame& frame,
                const RunOptions& options, Outputs& outputs);

// Object and triangle as floats: exact up to 2^24.
Buffer<float> id_floats(const Image<glm::ivec2>& id);

// What the files of a light's map are named after: "rsm.<light>", of a point light "rsm.<light>.px" and so on.
std::string map_name(const frame::Frame& frame, const std::vector<std::string>& lights, int light, int map);

// True if the plan needs a stage of that name for the light.
bool runs(const frame::Plan& plan, const std::string& stage, int light);

}  // namespace plumb::cli
