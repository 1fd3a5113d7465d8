// An export into a folder that holds an earlier one: stages of the same scene and settings stand side by side in one
// manifest, what is of another goes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/manifest.h"

namespace plumb::cli {

// The manifest of the export that is in the folder; none where there is no manifest. Throws InputError for one that says
// of no file that an export wrote it: a dump's own is not written over.
std::optional<io::Manifest> earlier_export(const std::string& folder);

// What becomes of an earlier export.
struct Merge {
    std::vector<std::string> kept;     // labels of stages that stay beside the new ones
    std::vector<std::string> removed;  // labels of stages that go, with their files
    std::vector<std::filesystem::path> stale;  // files that it wrote and that nothing names any more
    std::vector<std::filesystem::path> outputs;  // of these those that a renderer was to write over
};

// Adds the earlier stages and their files to `manifest`, which holds those of the new export, where both are of one
// scene, settings and device, and no file that they share has changed. A stage that is exported again takes the place of
// the earlier one.
Merge merge_exports(const io::Manifest& earlier, io::Manifest& manifest);

// Removes the stale files as they were exported, and outputs whatever was written to them; then folders that are empty.
// Returns those that stay since somebody has changed them.
std::vector<std::string> remove_stale(const io::Manifest& earlier, const Merge& merge);

}  // namespace plumb::cli
