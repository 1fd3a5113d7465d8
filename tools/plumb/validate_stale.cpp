#include "tools/plumb/validate_stale.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "core/content_hash.h"
#include "io/file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

// Files that are copied or checked out one after the other get times some seconds apart.
constexpr std::chrono::minutes older_by{1};

class StaleFinder {
  public:
    StaleFinder(const io::Manifest& manifest, std::vector<std::string>& notes) : manifest_(manifest), notes_(notes) {}

    std::string look(const io::ManifestStage& stage) {
        std::vector<std::string> changed;
        auto look_at = [&](const fs::path& file) {
            if (!file.empty() && is_there(file) && has_changed(file)) changed.push_back(io::shown(file.string()));
        };
        look_at(stage.block);
        for (const auto& [name, spec] : stage.inputs) look_at(spec.file);
        std::vector<std::string> answers;
        for (const auto& [name, spec] : stage.outputs) {
            look_at_output(spec);
            if (is_answer(spec)) answers.push_back(io::shown(spec.file.string()));
        }
        if (!answers.empty())
            return fmt::format("{} {} the expected output itself: nothing of a renderer's was judged", fmt::join(answers, ", "),
                               answers.size() == 1 ? "is" : "are");
        if (changed.empty()) return "";
        return fmt::format("not what was exported: {} {} changed since: export anew, or, where that is meant, take {} out "
                           "of [export.files]", fmt::join(changed, ", "), changed.size() == 1 ? "has" : "have",
                           changed.size() == 1 ? "it" : "them");
    }

  private:
    static bool is_there(const fs::path& file) {
        std::error_code error;
        return fs::is_regular_file(file, error);
    }

    // The hash of the file as it was exported; "" of a file that was not.
    std::string exported_hash(const fs::path& file) const {
        const auto at = manifest_.exported.files.find(io::name_in(manifest_, file));
        return at == manifest_.exported.files.end() ? "" : at->second;
    }
    bool has_changed(const fs::path& file) const {
        const std::string hash = exported_hash(file);
        return !hash.empty() && hash != hash_of(file);
    }
    static std::string hash_of(const fs::path& file) {
        const std::vector<unsigned char> bytes = io::read_bytes(file.string());
        return hash_text(content_hash(bytes.data(), bytes.size()));
    }

    void look_at_output(const io::DumpSpec& spec) {
        if (spec.expected.empty() || !is_there(spec.file)) return;
        if (is_there(spec.expected) && has_changed(spec.expected))
            notes_.push_back(io::shown(spec.expected.string()) +
                             " has changed since the export; what is expected is computed anew from the inputs");
        if (!spec.filling && exported_hash(spec.file) == hash_of(spec.file))
            notes_.push_back(io::shown(spec.file.string()) + " is as `plumb export --device` left it");
        if (is_there(spec.expected)) note_time(spec);
    }

    // One file under both names: not written by any renderer.
    static bool is_answer(const io::DumpSpec& spec) {
        std::error_code error;
        return !spec.expected.empty() && fs::equivalent(spec.file, spec.expected, error) && !error;
    }

    void note_time(const io::DumpSpec& spec) {
        std::error_code error, other;
        const auto dumped = fs::last_write_time(spec.file, error), exported = fs::last_write_time(spec.expected, other);
        if (error || other || !(exported - dumped > older_by)) return;
        notes_.push_back(io::shown(spec.file.string()) +
                         " is older than its export: the output of an earlier run, or a copy that has kept its time");
    }

    const io::Manifest& manifest_;
    std::vector<std::string>& notes_;
};

}  // namespace

std::string find_stale(const io::Manifest& manifest, const io::ManifestStage& stage, std::vector<std::string>& notes) {
    return manifest.exported.id.empty() ? "" : StaleFinder(manifest, notes).look(stage);
}

}  // namespace plumb::cli
