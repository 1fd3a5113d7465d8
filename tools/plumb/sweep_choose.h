// The setting that fits a time: what `plumb render --budget` renders with.
#pragma once

#include <string>
#include <vector>

#include "tools/shared/sweep.h"

namespace plumb::cli {

// "100ms", "100", "0.1s": milliseconds, above 0. Throws InputError that names the option.
double parse_milliseconds(const std::string& option, const std::string& text);
// An RMSE: finite, at least 0.
double parse_error(const std::string& option, const std::string& text);

// "rsm.disc, rsm.samples = 100: 84 ms, RMSE 0.0123 against full illumination".
std::string point_text(const SweepPoint& point);

// Sweeps that were measured before: one file each in the cache folder, named after all that times and errors depend on.
// A file that is broken, or belongs to another key, is never believed. Whatever fails is a note.
class SweepFiles {
  public:
    static constexpr std::size_t most_files = 256;  // those that were used last
    explicit SweepFiles(std::string folder) : folder_(std::move(folder)) {}

    std::optional<Sweep> find(std::uint64_t key);
    void keep(std::uint64_t key, const Sweep& sweep);
    const std::vector<std::string>& notes() const { return notes_; }

  private:
    std::string path_of(std::uint64_t key) const;
    void remove_oldest() const;

    std::string folder_;
    std::vector<std::string> notes_;
};

struct Choice {
    frame::Settings settings;        // what to render with
    bool fits = false;               // whether that is within the budget
    Json json;                       // run.json: "chosen"
    std::string text, warning;       // lines for people; a warning where it does not fit
};

// Sweeps the scene's method at the scene's size, unless that was done before, and picks the point with the least error
// within the budget. Where none is, the fastest, which does not fit.
Choice choose_by_budget(const Scene& scene, const SceneOptions& options, const frame::Settings& settings,
                        double budget_ms, const RunOptions& run);

}  // namespace plumb::cli
