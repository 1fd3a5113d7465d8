// What render, plan and explain have in common: a scene and its settings.
#pragma once

#include "tools/shared/command.h"
#include "tools/shared/options.h"

namespace plumb::cli {

void add_scene_options(CLI::App& command, SceneOptions& options);

void add_size_option(CLI::App& command, SceneOptions& options);

// --truth and what goes with it.
void add_truth_options(CLI::App& command, SceneOptions& options);

// The scene file's scene, of the size that is asked for.
Scene load(const SceneOptions& options);

// Says what was chosen for the user.
void print_notes(const Scene& scene);

}  // namespace plumb::cli
