#include "tools/plumb/export_merge.h"

#include <algorithm>
#include <set>

#include "core/content_hash.h"
#include "core/error.h"
#include "io/file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

// Files that a stage names, as ExportRecord::files has them: its outputs, and all others.
struct StageFiles {
    std::set<std::string> outputs, others;
};

StageFiles files_of(const io::Manifest& manifest, const io::ManifestStage& stage) {
    StageFiles files;
    auto add = [&](std::set<std::string>& to, const fs::path& file) {
        const std::string name = file.empty() ? "" : io::name_in(manifest, file);
        if (manifest.exported.files.count(name)) to.insert(name);
    };
    for (const fs::path& file : {stage.block, stage.uniforms_file}) add(files.others, file);
    for (const auto& [name, spec] : stage.inputs) add(files.others, spec.file);
    for (const auto& [name, spec] : stage.outputs) add(files.others, spec.expected), add(files.outputs, spec.file);
    add(files.outputs, stage.choices.file);
    return files;
}

// Of one scene, settings and device, and by one program: what both wrote has the same bytes. Outputs may be filled anew.
bool same_export(const io::Manifest& earlier, const io::Manifest& manifest) {
    if (earlier.exported.id != manifest.exported.id) return false;
    std::set<std::string> filled;
    for (const io::ManifestStage& stage : manifest.stages) filled.merge(files_of(manifest, stage).outputs);
    return std::all_of(manifest.exported.files.begin(), manifest.exported.files.end(), [&](const auto& file) {
        const auto old = earlier.exported.files.find(file.first);
        return old == earlier.exported.files.end() || old->second == file.second || filled.count(file.first);
    });
}

bool holds(const io::Manifest& manifest, const io::ManifestStage& stage) {
    return std::any_of(manifest.stages.begin(), manifest.stages.end(),
                       [&](const io::ManifestStage& s) { return s.block == stage.block; });
}

// Not through links, which may lead out of the folder.
bool lies_inside(const fs::path& folder, const fs::path& file) {
    std::error_code error;
    const fs::path real = fs::canonical(file.parent_path(), error);
    const fs::path base = fs::canonical(folder.empty() ? "." : folder, error);
    return !error && std::mismatch(base.begin(), base.end(), real.begin(), real.end()).first == base.end() &&
           fs::symlink_status(file, error).type() == fs::file_type::regular;
}

std::string hash_of(const fs::path& file) {
    const std::vector<unsigned char> bytes = io::read_bytes(file.string());
    return hash_text(content_hash(bytes.data(), bytes.size()));
}

void remove_empty_folders(const fs::path& folder, fs::path at) {
    std::error_code error;
    for (; at != folder && !at.empty() && fs::is_empty(at, error) && !error; at = at.parent_path())
        if (!fs::remove(at, error)) return;
}

}  // namespace

std::optional<io::Manifest> earlier_export(const std::string& folder) {
    const fs::path file = fs::path(folder) / "manifest.toml";
    std::error_code error;
    if (!fs::exists(fs::symlink_status(file, error))) return std::nullopt;
    io::Manifest manifest = io::read_manifest(file);
    if (manifest.exported.id.empty())
        throw InputError(io::shown(file.string()), "",
                         "is there already, and has no [export] that says what an export wrote: it is kept; expected "
                         "another folder");
    return manifest;
}

Merge merge_exports(const io::Manifest& earlier, io::Manifest& manifest) {
    Merge merge;
    std::set<std::string> named, outputs;
    std::vector<io::ManifestStage> stages;
    const bool same = same_export(earlier, manifest);
    for (const io::ManifestStage& stage : earlier.stages) {
        const StageFiles files = files_of(earlier, stage);
        outputs.insert(files.outputs.begin(), files.outputs.end());
        const bool again = holds(manifest, stage);
        const std::string& label = stage.label.empty() ? stage.stage : stage.label;
        if (!again) (same ? merge.kept : merge.removed).push_back(label);
        if (again || !same) continue;
        named.insert(files.outputs.begin(), files.outputs.end());
        named.insert(files.others.begin(), files.others.end());
        stages.push_back(stage);
    }
    for (const auto& [name, hash] : earlier.exported.files) {
        if (manifest.exported.files.count(name)) continue;
        if (named.count(name)) {
            manifest.exported.files.emplace(name, hash);
            continue;
        }
        const fs::path file = earlier.file.parent_path() / name;
        merge.stale.push_back(file);
        if (outputs.count(name)) merge.outputs.push_back(file);
    }
    manifest.stages.insert(manifest.stages.begin(), stages.begin(), stages.end());
    return merge;
}

std::vector<std::string> remove_stale(const io::Manifest& earlier, const Merge& merge) {
    std::vector<std::string> changed;
    const fs::path folder = earlier.file.parent_path();
    for (const fs::path& file : merge.stale) {
        if (!lies_inside(folder, file)) continue;
        const bool output = std::find(merge.outputs.begin(), merge.outputs.end(), file) != merge.outputs.end();
        if (!output && hash_of(file) != earlier.exported.files.at(file.lexically_relative(folder).string())) {
            changed.push_back(file.string());
            continue;
        }
        std::error_code error;
        fs::remove(file, error);
        if (error) throw InputError(io::shown(file.string()), "", "of an earlier export; cannot be removed: " + error.message());
        remove_empty_folders(folder, file.parent_path());
    }
    return changed;
}

}  // namespace plumb::cli
