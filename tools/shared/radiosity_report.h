// What is said of the method radiosity: before a frame, what its rows and its solution are expected to take; after it, how it was
// solved and where its power goes.
#pragma once

#include <memory>
#include <string>

#include "gi/radiosity/kept_rows.h"
#include "tools/shared/file_store.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// Rows between runs, in files of the user's cache folder; null where nothing is to be kept.
std::unique_ptr<FileStore> row_files(const frame::Settings& settings, bool no_cache);

// What a frame of that method and scene will do. Throws InputError that names the scene where its rows cannot be served.
struct RadiosityPlan {
    int elements = 0, triangles = 0;
    radiosity::RowPlan rows;
    double row_seconds = 0;    // on one core, where they are not kept
    std::uint64_t memory = 0;  // bytes that rows may take there
    radiosity::Recommendation solver;
    double mesh_seconds = 0;   // that splitting, cutting and refining the mesh has just taken; a frame takes them again
};
RadiosityPlan plan_radiosity(const Scene& scene, const frame::Settings& settings, const RunOptions& options);
Json radiosity_plan_json(const RadiosityPlan& plan);
std::string radiosity_plan_text(const RadiosityPlan& plan);

// Null where the frame has solved nothing. `rows`: as row_files() made it.
Json radiosity_json(const frame::Frame& frame, const frame::Settings& settings, const RunOptions& options, const FileStore* rows);
// Lines for people, of radiosity_json(); nothing of null.
std::string radiosity_text(const Json& json);

}  // namespace plumb::cli
