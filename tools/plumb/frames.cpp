#include "tools/plumb/frames.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/parallel.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct Reuse {
    int kept = 0, needed = 0;
    double saved_ms = 0;
    std::string labels;
};

Reuse reuse_of(const std::vector<frame::StageRun>& stages) {
    Reuse r;
    for (const frame::StageRun& s : stages) {
        r.needed += s.needed, r.kept += s.kept;
        if (!s.kept) continue;
        r.saved_ms += s.saved_ms - s.ms;
        r.labels += (r.labels.empty() ? "" : ", ") + s.label;
    }
    return r;
}

Reuse reuse_of(const std::vector<FrameRun>& frames) {
    Reuse sum;
    for (const FrameRun& f : frames) {
        const Reuse r = reuse_of(f.stages);
        sum.kept += r.kept, sum.needed += r.needed, sum.saved_ms += r.saved_ms;
    }
    return sum;
}

}  // namespace

std::string frame_name(const std::string& name, int frame) { return fmt::format("{}.{:04}", name, frame); }

Json frames_json(const FramesReport& report) {
    Json frames = Json::array();
    for (const FrameRun& f : report.frames) {
        Json json = {{"frame", f.frame},
                     {"stages", stage_runs_json(f.stages)},
                     {"lights", f.lights},
                     {"total_ms", f.ms},
                     {"write_ms", f.write_ms},
                     {"saved_ms", reuse_of(f.stages).saved_ms}};
        if (!f.truth.is_null()) json["truth"] = f.truth;
        if (!f.radiosity.is_null()) json["radiosity"] = f.radiosity;
        frames.push_back(std::move(json));
    }
    const Reuse all = reuse_of(report.frames);
    Json json = {{"version", run_version}, {"scene", report.scene.name},
                 {"settings", settings_json(report.settings)},
                 {"isa", isa_name(report.options.isa)},
                 {"threads", thread_count(report.options.threads)},
                 {"frames", frames},
                 {"needed_stages", all.needed},
                 {"kept_stages", all.kept}};
    add_left_out(report.scene, report.settings, json);
    add_times(report.times, json);
    json["saved_ms"] = all.saved_ms, json["peak_bytes"] = report.peak_bytes;
    return json;
}

std::string frames_text(const FramesReport& report) {
    std::vector<std::vector<std::string>> rows;
    for (const FrameRun& f : report.frames) {
        const Reuse r = reuse_of(f.stages);
        const std::string what = r.kept == 0 ? "-" : r.kept == r.needed ? "everything" : r.labels;
        rows.push_back({fmt::format("{}", f.frame), milliseconds_text(f.ms), milliseconds_text(f.write_ms),
                        milliseconds_text(r.saved_ms), fmt::format("{} of {}", r.kept, r.needed), what});
    }
    const Reuse all = reuse_of(report.frames);
    const int threads = thread_count(report.options.threads);
    return format_table({{"frame", Align::right}, {"ms", Align::right}, {"write", Align::right}, {"saved", Align::right},
                         {"kept", Align::right}, {""}},
                        rows) +
           fmt::format("\nkept {} of {} stages, {} ms saved\n{} frames of {} x {} pixels {}; by {} on {} thread{}, "
                       "at most {} MB of memory\n",
                       all.kept, all.needed, milliseconds_text(all.saved_ms), report.frames.size(),
                       report.scene.frame_size.x, report.scene.frame_size.y, times_text(report.times),
                       isa_name(report.options.isa), threads, threads == 1 ? "" : "s", megabytes_text(report.peak_bytes));
}

}  // namespace plumb::cli
