// plumb bake --export-sh: probes in the spherical harmonics of engines, as JSON.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "gi/probes/bake.h"

namespace plumb::cli {

struct ShOptions {
    std::string file, order;
};
void add_sh_options(CLI::App& command, ShOptions& options);
// What is asked for must be possible before anything is computed: InputError otherwise. part: of a bake.
void check_sh(const ShOptions& options, bool part);
void check_sh_degree(const ShOptions& options, int degree);
// Writes the file if one is asked for, with the light that probes see in the scene as it stands.
void write_sh(const ShOptions& options, const probes::Bake& bake, const Scene& scene, const RunOptions& run);

}  // namespace plumb::cli
