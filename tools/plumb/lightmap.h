// What the two halves of plumb lightmap share: which texels there are, and what is traced at them.
#pragma once

#include "gi/frame/settings.h"
#include "gi/probes/lightmap_check.h"
#include "tools/shared/command.h"
#include "tools/shared/options.h"

namespace plumb::cli {

struct LightmapOptions {
    SceneOptions scene;
    Common common;
    std::string output, error_file, part = "all", uv, size, samples, until_error;
    std::vector<std::string> meshes;
    // Of --check.
    std::string checked, layer, checked_error, scale = "1", html;
    std::optional<double> max_error, max_seam;
    std::optional<int> max_leaks;
};

// A scene with the coordinates that a lightmap may have.
struct LightmapScene {
    Scene scene;
    std::vector<std::vector<glm::vec2>> second;  // of each mesh
    frame::Settings settings;
    reference::PathParams path;                  // as the options and [reference] have it
};
LightmapScene load_lightmap_scene(const LightmapOptions& given);

// "atlas", "0" or "1": what --uv says, or what suits the scene.
std::string layout_of(const LightmapOptions& given, const LightmapScene& scene);

// Receivers of a map of that size (0: what the atlas takes); `what` is the file or option that messages begin with.
probes::Lightmap lightmap_of(const LightmapOptions& given, const LightmapScene& scene, const std::string& layout, glm::ivec2 size,
                             const std::string& what);

// Traces them, with a bar of progress.
probes::ReceiverIrradiance trace_lightmap(const LightmapOptions& given, const LightmapScene& scene, const probes::Lightmap& lightmap);

// lightmap_check.cpp: --check.
int check_user_lightmap(const LightmapOptions& given);

}  // namespace plumb::cli
