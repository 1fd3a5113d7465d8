// The bake that the method probes needs: read from the file that [probes] file names, or taken from the store, or made and
// kept there.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/isa.h"
#include "gi/frame/settings.h"
#include "gi/probes/bake.h"

namespace plumb::cli {

// A bake as its file has it, without the un-truncated transport. Throws InputError that names the file: damaged, of another scene,
// or baked for another sky.
std::shared_ptr<const probes::Bake> read_bake(const std::string& file, const Scene& scene);

struct BakeWith {
    RunOptions options;
    std::string store;      // folder; empty: nothing is kept
    bool progress = false;  // a line on standard error while it is made
    bool with_alpha = false;
};
std::shared_ptr<const probes::Bake> make_bake(const Scene& scene, const probes::BakeParams& params, const BakeWith& with);

// Throws InputError for the first --set that a command which bakes would not read: of another table, or of the run time's part of
// [probes]. command: "plumb bake".
void require_baked(const std::vector<std::string>& sets, const std::vector<std::string>& tables, const std::string& command);

// Runs the nodes of a bake; what they refuse names the scene.
std::vector<graph::NodeRun> run_bake(const probes::BakeGraph& graph, const Scene& scene, const graph::RunWith& with);

// Sets settings.bake for the method probes where it is missing; of other methods nothing happens.
void add_bake(const Scene& scene, frame::Settings& settings, const BakeWith& with);

// A scene as the settings' method draws it: of radiosity with its triangles split.
Scene drawn(Scene scene, const frame::Settings& settings, const RunOptions& options = {});

}  // namespace plumb::cli
