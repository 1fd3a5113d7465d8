// Adds to a command the options that name a scene and its settings, and loads what they name: for render, plan, explain
// and export.
#pragma once

#include "tools/shared/command.h"
#include "tools/shared/options.h"

namespace plumb::cli {

void add_scene_options(CLI::App& command, SceneOptions& options);

void add_preset_option(CLI::App& command, std::string& preset);

void add_size_option(CLI::App& command, SceneOptions& options);

// --truth and what goes with it.
void add_truth_options(CLI::App& command, SceneOptions& options);

// The scene file's scene, of the size that is asked for, its lights switched as --set says.
Scene load(const SceneOptions& options);

// Adds to the scene's notes what --set sets that changes nothing beside the other settings.
void note_idle(const SceneOptions& options, const frame::Settings& settings, Scene& scene);
// Notes what of the scene's materials the method does not show.
void note_lobes(const frame::Settings& settings, Scene& scene);

// Says what was chosen for the user.
void print_notes(const Scene& scene);

}  // namespace plumb::cli
