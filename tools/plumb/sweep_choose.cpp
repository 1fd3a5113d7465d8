#include "tools/plumb/sweep_choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/content_hash.h"
#include "core/host_math.h"
#include "core/error.h"
#include "core/parallel.h"
#include "io/file.h"
#include "tools/shared/reference_files.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* extension = ".sweep";
constexpr const char* choosing_samples = "32";  // paths a pixel
constexpr std::size_t most_bytes = std::size_t(1) << 24;

bool read_number(const std::string& text, double& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() && !text.empty() && std::isfinite(number);
}

std::string header(std::uint64_t key, const std::string& body) {
    return fmt::format("plumb sweep {} {}", hash_text(key), hash_text(content_hash(body, key)));
}

// Scene, settings, machine and program: another of them, other times.
std::uint64_t key_of(const Scene& scene, const frame::Settings& settings, const SweepRequest& request,
                     const RunOptions& run) {
    const std::vector<unsigned char> program = io::read_bytes("/proc/self/exe");
    return content_hash(fmt::format("{} {} {} {} {} {} {}", json_text(settings_json(settings)), isa_name(run.isa),
                                    thread_count(run.threads), processor_name(), request.longest_ms, request.runs,
                                    request.samples),
                        content_hash(program.data(), program.size(), scene_hash(scene)));
}

}  // namespace

double parse_milliseconds(const std::string& option, const std::string& text) {
    std::string number = text;
    double scale = 1, value = 0;
    auto ends_in = [&](const std::string& unit) {
        const bool does = number.size() > unit.size() && number.compare(number.size() - unit.size(), unit.size(), unit) == 0;
        if (does) number.resize(number.size() - unit.size());
        return does;
    };
    if (!ends_in("ms") && ends_in("s")) scale = 1000;
    if (!read_number(number, value) || !(value * scale > 0) || !std::isfinite(value * scale))
        throw InputError(fmt::format("{} {}: expected a time above 0, as in 100ms, 100 or 0.1s", option, text));
    return value * scale;
}

double parse_error(const std::string& option, const std::string& text) {
    double value = 0;
    if (!read_number(text, value) || value < 0)
        throw InputError(fmt::format("{} {}: expected a number of at least 0", option, text));
    return value;
}

std::string point_text(const SweepPoint& p) {
    return fmt::format("{}{}{}: {} ms, RMSE {:.4g} against full illumination", p.method, p.settings.empty() ? "" : ", ",
                       p.settings, milliseconds_text(p.median_ms), p.full.rmse);
}

std::string SweepFiles::path_of(std::uint64_t key) const { return folder_ + "/" + hash_text(key) + extension; }

// A file is one line with its key and a checksum of the rest, then the sweep's JSON.
std::optional<Sweep> SweepFiles::find(std::uint64_t key) {
    const std::string path = path_of(key);
    std::error_code error;
    if (folder_.empty() || !fs::exists(path, error)) return std::nullopt;
    try {
        const std::string text = io::read_text(path, most_bytes);
        const std::size_t end = text.find('\n');
        const std::string body = end == std::string::npos ? "" : text.substr(end + 1);
        if (text.substr(0, end) != header(key, body)) throw InputError(path + ": broken, or kept for another key");
        Sweep sweep = sweep_of(body, path);
        fs::last_write_time(path, fs::file_time_type::clock::now(), error);
        return sweep;
    } catch (const std::exception& e) {
        notes_.push_back(std::string(e.what()) + "; measured anew");
        return std::nullopt;
    }
}

void SweepFiles::keep(std::uint64_t key, const Sweep& sweep) {
    if (folder_.empty()) return;
    try {
        io::make_folder(folder_);
        const std::string body = json_text(sweep_json(sweep));
        io::write_text(path_of(key), header(key, body) + "\n" + body);
        remove_oldest();
    } catch (const std::exception& e) {
        notes_.push_back(std::string(e.what()) + "; the sweep is not kept");
    }
}

void SweepFiles::remove_oldest() const {
    std::vector<std::pair<fs::file_time_type, fs::path>> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        std::error_code gone;  // another run may have removed it since
        const fs::file_time_type used = entry.last_write_time(gone);
        if (!gone && entry.path().extension() == extension) files.emplace_back(used, entry.path());
    }
    std::sort(files.begin(), files.end(), std::greater<>());
    std::error_code error;
    for (std::size_t i = most_files; i < files.size(); ++i) fs::remove(files[i].second, error);
}

Choice choose_by_budget(const Scene& scene, const SceneOptions& options, const frame::Settings& settings,
                        double budget_ms, const RunOptions& run) {
    SweepRequest request;
    request.scenes = {options};
    request.loaded = &scene;
    SceneOptions& swept = request.scenes.front();
    swept.truth = false;
    swept.samples = swept.until_error = swept.rays = "";
    request.methods = {frame::method_name(settings.method)};
    // Few paths: every point's error holds the same noise, so that their order stays.
    request.samples = choosing_samples;
    request.no_cache = options.no_cache;
    // Budgets that lie near each other share what was measured.
    request.longest_ms = host::exp2(std::ceil(host::log2(budget_ms)));

    SweepFiles files(options.no_cache ? "" : cache_folder());
    const std::uint64_t key = key_of(scene, settings, request, run);
    std::optional<Sweep> sweep = files.find(key);
    const bool kept = sweep.has_value();
    if (!kept) {
        sweep = run_sweep(request, run);
        files.keep(key, *sweep);
    }
    // One kept sweep serves every name of the same file.
    const std::string name = sweep->scenes.at(0).name;
    const SweepPoint* best = best_within(*sweep, name, budget_ms);
    Choice choice;
    choice.fits = best != nullptr;
    if (!best) best = fastest(*sweep, name);
    if (!best) throw InputError(scene.name + ": --budget: no setting has an error that is a number");
    choice.settings = apply(settings, best->base, best->changed);
    choice.json = {{"budget_ms", budget_ms},  {"fits", choice.fits},
                   {"curve", best->method},   {"settings", best->settings},
                   {"median_ms", best->median_ms}, {"rmse", best->full.rmse},
                   {"points", sweep->points.size()}, {"cached", kept}};
    choice.text = choice.fits ? fmt::format("budget: within {} ms, the least error of {} settings: {}\n", budget_ms,
                                            sweep->points.size(), point_text(*best))
                              : fmt::format("budget: the fastest of all settings: {}\n", point_text(*best));
    if (!choice.fits)
        choice.warning = fmt::format("plumb: warning: --budget: no setting fits within {} ms: rendered with the fastest\n",
                                     budget_ms);
    for (const std::string& note : files.notes()) choice.text += "note: " + note + "\n";
    if (!kept)
        for (const std::string& note : sweep->notes) choice.text += "note: " + note + "\n";
    choice.text += "\n";
    return choice;
}

}  // namespace plumb::cli
