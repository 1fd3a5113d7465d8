// Renders defaults and their alternatives in turns, and holds them against their path traced truth.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "core/error.h"
#include "gi/frame/truth.h"
#include "tools/experiments/defaults.h"
#include "tools/shared/file_store.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/reference_files.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/sweep.h"
#include "tools/shared/sweep_subject.h"
#include "tools/shared/truth.h"

namespace plumb::cli {

namespace {

using Clock = std::chrono::steady_clock;

// A setting on its way.
struct Run {
    DefaultsRow row;
    frame::Settings settings;
    std::shared_ptr<const Scene> scene;  // as the method draws it
    frame::Plan plan;
    double made = 0;  // ms: what is made before a frame, a bake or the light of all vertices
    std::vector<double> ms, errors;
};

const Image4& layer_of(const frame::Frame& frame, const std::string& layer) {
    if (layer == "direct") return frame.direct;
    if (layer == "indirect") return frame.indirect;
    return layer == "ao" ? frame.ao.open : frame.radiance;
}

double mean_of(const Image4& image) {
    double sum = 0;
    for (const glm::vec4& t : image.texels) sum += double(t.x) + double(t.y) + double(t.z);
    return sum / (3 * double(image.size()));
}

class OfScene {
  public:
    OfScene(const std::string& file, int size, const DefaultsRequest& request, const RunOptions& options)
        : request_(request), options_(options), kept_(request.no_cache ? "" : cache_folder()) {
        words_.file = file, words_.size = fmt::format("{}x{}", size, size);
        words_.preset = request.preset, words_.sets = request.sets;
        scene_ = std::make_shared<const Scene>(load(words_));
    }

    std::vector<DefaultsRow> measure(const ChoiceGroup& group, const std::function<void(const std::string&)>& say) {
        std::vector<Run> runs = runs_of(group);
        for (Run& run : runs) prepare(run);
        Run& own = runs.front();
        if (own.row.refused) return {own.row};
        const std::optional<reference::Estimate> truth = truth_of(group, own);
        // Nothing of that layer is in the scene.
        if (!truth) return {};
        for (int i = 0; i <= request_.runs; ++i)
            for (Run& run : runs) {
                if (run.row.refused) continue;
                show_progress(fmt::format("{}, {} of {}: {}", run.row.scene, i, request_.runs, run.row.setting));
                try {
                    time(run, i, group.layer, *truth);
                } catch (const InputError& error) {
                    run.row.refused = true, run.row.why = error.what();
                }
            }
        show_progress("");
        say(fmt::format("{} {}x{}: {}", own.row.scene, own.row.size.x, own.row.size.y, group.name));
        std::vector<DefaultsRow> rows;
        for (Run& run : runs) rows.push_back(finished(run));
        return rows;
    }

  private:
    // The default, then all that may stand in its place and is another.
    std::vector<Run> runs_of(const ChoiceGroup& group) const {
        std::vector<Run> runs;
        const auto add = [&](const std::string& choice, const std::string& setting, const std::vector<std::string>& sets) {
            SceneOptions words = words_;
            words.method = group.method;
            words.sets = group.sets;
            words.sets.insert(words.sets.end(), request_.sets.begin(), request_.sets.end());
            words.sets.insert(words.sets.end(), sets.begin(), sets.end());
            Run run;
            run.row = {words_.file, group.name, choice, setting, scene_->frame_size};
            run.settings = settings_of(*scene_, words);
            const auto same = [&](const Run& other) {
                return (other.row.choice.empty() || other.row.choice == choice) &&
                       json_text(settings_json(other.settings)) == json_text(settings_json(run.settings));
            };
            if (std::none_of(runs.begin(), runs.end(), same)) runs.push_back(std::move(run));
        };
        add("", "default", {});
        for (const DefaultChoice& choice : group.choices)
            for (const Alternative& other : choice.others) add(choice.name, other.name, other.sets);
        return runs;
    }

    void prepare(Run& run) const {
        try {
            run.scene = scene_;
            const auto start = Clock::now();
            // Not one that is kept: its time counts.
            if (run.settings.method == frame::Method::probes) add_bake(*scene_, run.settings, {options_, ""});
            if (run.settings.method == frame::Method::radiosity)
                run.scene = std::make_shared<const Scene>(drawn(*scene_, run.settings, options_));
            if (run.settings.method == frame::Method::probes || run.settings.method == frame::Method::radiosity)
                run.made = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
            run.plan = frame::plan(*run.scene, run.settings);
        } catch (const InputError& error) {
            run.row.refused = true, run.row.why = error.what();
        }
    }

    std::optional<reference::Estimate> truth_of(const ChoiceGroup& group, const Run& own) {
        const frame::Frame frame = frame::execute(*own.scene, own.settings, own.plan, options_);
        if (layer_of(frame, group.layer).size() == 0) return std::nullopt;
        frame::Settings settings = own.settings;
        settings.reference.samples = request_.samples, settings.reference.until_error = 0;
        settings.seed = own.settings.seed + 0x10000;  // not the numbers of what is held against it
        const Geometry geometry = flatten(*scene_);
        frame::Tracer tracer(*scene_, settings, geometry, request_.no_cache ? nullptr : &kept_);
        const std::string layer = group.layer == "color" ? "truth" : "truth." + group.layer;
        reference::Estimate truth = tracer.trace(layer, frame.gbuffer, options_).estimate;
        if (!(mean_of(truth.mean) > 0)) return std::nullopt;
        return truth;
    }

    // The first run warms up.
    void time(Run& run, int round, const std::string& layer, const reference::Estimate& truth) const {
        frame::Settings settings = run.settings;
        settings.seed += std::uint32_t(round);
        const frame::Plan plan = frame::plan(*run.scene, settings);
        const auto start = Clock::now();
        const frame::Frame frame = frame::execute(*run.scene, settings, plan, options_);
        if (round == 0) return;
        run.ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
        const TruthComparison c = compare_with_truth(layer_of(frame, layer), {}, truth, options_.threads);
        const double rmse = c.report.rmse.value_or(NAN);
        run.errors.push_back(std::sqrt(std::max(0.0, rmse * rmse - c.noise * c.noise)) / mean_of(truth.mean));
        if (std::isnan(rmse)) run.errors.back() = NAN;
    }

    static DefaultsRow finished(const Run& run) {
        DefaultsRow row = run.row;
        if (row.refused) return row;
        row.ms = run.made + quantile(run.ms, 0.5);
        const double n = double(run.errors.size());
        double squares = 0;
        for (const double e : run.errors) row.error += e / n;
        for (const double e : run.errors) squares += (e - row.error) * (e - row.error);
        row.spread = n > 1 ? std::sqrt(squares / (n * (n - 1))) : 0;
        return row;
    }

    const DefaultsRequest& request_;
    RunOptions options_;
    ReferenceFiles kept_;
    SceneOptions words_;
    std::shared_ptr<const Scene> scene_;
};

}  // namespace

std::vector<DefaultsRow> measure_defaults(const DefaultsRequest& request, const RunOptions& options,
                                          const std::function<void(const std::string&)>& say) {
    std::vector<DefaultsRow> rows;
    for (const std::string& file : request.scenes)
        for (const int size : request.sizes) {
            OfScene scene(file, size, request, options);
            for (const ChoiceGroup& group : default_choices()) {
                if (!request.groups.empty() && std::find(request.groups.begin(), request.groups.end(), group.name) == request.groups.end())
                    continue;
                const std::vector<DefaultsRow> more = scene.measure(group, say);
                rows.insert(rows.end(), more.begin(), more.end());
            }
        }
    return rows;
}

std::vector<DefaultVerdict> judge_defaults(const std::vector<DefaultsRow>& rows) {
    std::vector<DefaultVerdict> verdicts;
    const DefaultsRow* own = nullptr;
    for (const DefaultsRow& row : rows) {
        if (row.choice.empty()) {
            own = &row;
            continue;
        }
        if (verdicts.empty() || verdicts.back().own != own || verdicts.back().choice != row.choice)
            verdicts.push_back({row.scene, row.group, row.choice, row.size, own});
        DefaultVerdict& verdict = verdicts.back();
        if (row.refused || !(row.ms <= slack * own->ms) || std::isnan(row.error)) continue;
        if (!verdict.best || row.error < verdict.best->error) verdict.best = &row;
    }
    for (DefaultVerdict& v : verdicts) {
        using Is = DefaultVerdict::Is;
        if (std::isnan(v.own->error)) {
            v.is = Is::off;
        } else if (!v.best || v.own->error <= v.best->error) {
            v.is = Is::on_front;
        } else if (v.own->error <= within * v.best->error) {
            v.is = Is::near_front;
        } else {
            const double apart = v.own->error - v.best->error, a = v.own->spread, b = v.best->spread, error = std::sqrt(a * a + b * b);
            v.is = apart <= 2 * error ? Is::not_told_apart : Is::off;
        }
    }
    return verdicts;
}

}  // namespace plumb::cli
