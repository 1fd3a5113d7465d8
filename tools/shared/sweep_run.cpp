// Measures a sweep: truths first, then every point once to warm up, then all points in turns.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "gi/compose/compose.h"
#include "tools/shared/file_store.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/process_memory.h"
#include "tools/shared/reference_files.h"
#include "tools/shared/sweep_subject.h"
#include "tools/shared/truth.h"

namespace plumb::cli {

namespace {

using Clock = std::chrono::steady_clock;

// A plan's expectation is an order of magnitude.
constexpr double expectation_slack = 10, warm_up_slack = 2;

// A point, and how it is rendered.
struct Job {
    SweepPoint point;
    std::size_t subject = 0;
    std::shared_ptr<const Scene> scene;  // as the method draws it
    frame::Settings settings;
    frame::Plan plan;
    double warm_up_ms = 0, expected_ms = 0;
    std::vector<double> stage_ms;
    PointPictures pictures;
};

// Signed, channel by channel, of what is shown.
Rgb8 difference(const Rgb8& picture, const Rgb8& truth) {
    Rgb8 bytes(picture.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const double d = (double(picture[i]) - double(truth[i])) / (255 * difference_swing);
        bytes[i] = static_cast<unsigned char>(std::lround(127.5 + 127.5 * std::clamp(d, -1.0, 1.0)));
    }
    return bytes;
}

// Root of the mean of the squared standard errors, as TruthComparison::noise of a picture without its own.
double error_of_truth(const reference::Estimate& truth) {
    double squares = 0;
    for (const glm::vec4& error : truth.error.texels)
        for (int c = 0; c < 3; ++c) squares += double(error[c]) * error[c];
    return std::sqrt(squares / (3 * double(truth.error.size())));
}

SweepError error_of(const Image4& color, const Image4& own_error, const reference::Estimate& truth, int threads) {
    const TruthComparison c = compare_with_truth(color, own_error, truth, threads);
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {c.report.rmse.value_or(none), c.report.rel_mse.value_or(none), c.report.mean_error.value_or(none), c.noise,
            c.below_noise, error_of_truth(truth)};
}

// The standard error of the picture, by channel; empty where it has none.
Image4 own_error(const frame::Frame& frame) {
    const frame::Traced* traced = frame::find_traced(frame, "color");
    return traced ? traced->estimate.error : color_error(frame);
}

bool of_method(const std::string& label, const std::string& method) {
    return label.rfind(method, 0) == 0 && (label.size() == method.size() || label[method.size()] == '.' ||
                                           label[method.size()] == ' ');
}

frame::Frame run_once(Job& job, const RunOptions& options, double& ms, double& stage_ms) {
    const auto start = Clock::now();
    frame::Frame frame = frame::execute(*job.scene, job.settings, job.plan, options);
    ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    stage_ms = 0;
    for (const frame::StageRun& s : frame.stages)
        if (s.needed && of_method(s.label, frame::method_name(job.settings.method))) stage_ms += s.ms;
    return frame;
}

void warm_up(const Subject& subject, Job& job, const RunOptions& options, const Sweep& sweep,
             const ScenePictures* truths) {
    const MemoryPeak memory;
    double stage_ms = 0;
    const frame::Frame frame = run_once(job, options, job.warm_up_ms, stage_ms);
    if (sweep.memory == "resident")
        job.point.peak_bytes = memory.peak_bytes().value_or(0);
    else
        for (const frame::StageRun& s : frame.stages) job.point.peak_bytes += s.bytes;

    job.point.picture_hash = content_hash(frame.radiance);
    const Image4 error = own_error(frame);
    const auto own = subject.own.find(job.settings.method);
    job.point.full = error_of(frame.radiance, error, subject.full, options.threads);
    job.point.own = own == subject.own.end() ? job.point.full
                                             : error_of(frame.radiance, error, own->second, options.threads);
    if (!truths) return;
    job.pictures.color = compose::to_bytes(frame.display);
    job.pictures.against_full = difference(job.pictures.color, truths->truth);
    const auto own_truth = truths->own.find(job.settings.method);
    job.pictures.against_own = own_truth == truths->own.end() ? job.pictures.against_full : difference(job.pictures.color, own_truth->second);
}

// Points that cannot be rendered are left out, unless none of a scene's can.
std::vector<Job> jobs_of(const SweepRequest& request, const std::vector<Subject>& subjects, const RunOptions& options, Sweep& sweep) {
    std::vector<Job> jobs;
    const BakeWith with{options, request.no_cache ? "" : cache_folder()};
    for (std::size_t s = 0; s < subjects.size(); ++s) {
        const std::size_t before = jobs.size();
        std::map<std::string, std::shared_ptr<const probes::Bake>> bakes;  // by the parameters that they have
        std::map<std::string, std::shared_ptr<const Scene>> scenes;        // of radiosity, by the same
        const std::shared_ptr<const Scene> as_it_is(std::shared_ptr<void>(), &subjects[s].scene);
        std::string refused;
        for (const SweptMethod& curve : swept_methods(subjects[s].settings, request.methods, request.vary))
            for (const SweptSettings& point : points_of(curve)) {
                Job job;
                job.subject = s;
                job.point.scene = sweep.scenes[s].name;
                job.point.method = curve.name, job.point.base = curve.method;
                job.point.settings = point.text, job.point.changed = point.changed;
                job.settings = apply(subjects[s].settings, curve.method, point.changed);
                try {
                    if (curve.method == frame::Method::probes) {
                        std::shared_ptr<const probes::Bake>& bake = bakes[json_text(settings_json(job.settings).at("probes"))];
                        job.settings.bake = bake;
                        add_bake(subjects[s].scene, job.settings, with);
                        bake = job.settings.bake;
                    }
                    job.scene = as_it_is;
                    if (curve.method == frame::Method::radiosity) {
                        std::shared_ptr<const Scene>& scene = scenes[json_text(settings_json(job.settings).at("radiosity"))];
                        if (!scene) scene = std::make_shared<const Scene>(drawn(subjects[s].scene, job.settings, options));
                        job.scene = scene;
                    }
                    job.plan = frame::plan(*job.scene, job.settings);
                } catch (const InputError& error) {
                    if (refused.empty()) refused = error.what();
                    sweep.left_out.push_back({job.point.scene, curve.name, point.text, error.what()});
                    continue;
                }
                for (const frame::PlannedStage& stage : job.plan.stages) job.expected_ms += stage.expected_ms;
                jobs.push_back(std::move(job));
            }
        if (jobs.size() == before) throw InputError(refused);
    }
    return jobs;
}

// Runs every job once, and leaves out what only the run can refuse.
void warm_up_all(const std::vector<Subject>& subjects, std::vector<Job>& jobs, const RunOptions& options, Sweep& sweep,
                 const SweepPictures* pictures) {
    std::vector<std::string> refused(subjects.size());
    std::vector<Job> warm;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        Job& job = jobs[i];
        const SweepPoint& p = job.point;
        show_progress(fmt::format("warming up, {} of {}: {} {}", i + 1, jobs.size(), p.method, p.settings));
        try {
            warm_up(subjects[job.subject], job, options, sweep, pictures ? &pictures->scenes[job.subject] : nullptr);
            warm.push_back(std::move(job));
        } catch (const InputError& error) {
            refused[job.subject] = error.what();
            sweep.left_out.push_back({p.scene, p.method, p.settings, error.what()});
        }
    }
    jobs = std::move(warm);
    for (std::size_t s = 0; s < subjects.size(); ++s)
        if (std::none_of(jobs.begin(), jobs.end(), [&](const Job& job) { return job.subject == s; }))
            throw InputError(refused[s]);
}

// Removes what takes too long, but never the one of a scene that takes least.
void leave_out(std::vector<Job>& jobs, double Job::* ms, double longest_ms, const char* what, Sweep& sweep) {
    std::map<std::size_t, double> least;
    for (const Job& job : jobs) {
        const auto [at, first] = least.insert({job.subject, job.*ms});
        if (!first) at->second = std::min(at->second, job.*ms);
    }
    std::erase_if(jobs, [&](const Job& job) {
        if (job.*ms <= longest_ms || job.*ms <= least[job.subject]) return false;
        sweep.left_out.push_back({job.point.scene, job.point.method, job.point.settings,
                                  fmt::format("{} {:.0f} ms", what, job.*ms), true});
        return true;
    });
}

// The same order for every run of the program, another one in every round: what disturbs a machine for a while does not
// meet the same points each time.
std::vector<std::size_t> order_of(std::size_t count, int round) {
    std::vector<std::size_t> order(count);
    for (std::size_t i = 0; i < count; ++i) order[i] = i;
    for (std::size_t i = count; i > 1; --i) {
        const std::uint32_t random = std::uint32_t(pcg(std::int32_t(i) + pcg(round)));
        std::swap(order[i - 1], order[std::size_t(std::uint64_t(random) * i >> 32)]);
    }
    return order;
}

void run_in_turns(std::vector<Job>& jobs, int runs, const RunOptions& options) {
    for (int round = 0; round < runs; ++round)
        for (const std::size_t i : order_of(jobs.size(), round)) {
            Job& job = jobs[i];
            show_progress(fmt::format("run {} of {}: {} {}", round + 1, runs, job.point.method, job.point.settings));
            double ms = 0, stage_ms = 0;
            const frame::Frame frame = run_once(job, options, ms, stage_ms);
            if (content_hash(frame.radiance) != job.point.picture_hash)
                throw std::runtime_error(fmt::format("{}: {}, {}: two runs gave different pictures", job.point.scene,
                                                     job.point.method, job.point.settings));
            job.point.frame_ms.push_back(ms);
            job.stage_ms.push_back(stage_ms);
        }
}

}  // namespace

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        const std::size_t colon = line.find(": ");
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
    }
    return "unknown";
}

Sweep run_sweep(const SweepRequest& request, const RunOptions& options, SweepPictures* pictures) {
    Sweep sweep;
    sweep.isa = isa_name(options.isa), sweep.processor = processor_name();
    sweep.threads = thread_count(options.threads), sweep.runs = request.runs;
    sweep.memory = MemoryPeak().peak_bytes() ? "resident" : "stages";

    // All that can be wrong with the request is found before anything is traced.
    std::vector<Subject> subjects;
    for (const SceneOptions& scene : request.scenes) {
        for (const SweptScene& before : sweep.scenes)
            if (before.name == scene.file) throw InputError(fmt::format("{}: the scene is given twice", scene.file));
        subjects.push_back(load_subject(request, scene));
        sweep.scenes.emplace_back().name = scene.file;
    }
    std::vector<Job> jobs = jobs_of(request, subjects, options, sweep);
    leave_out(jobs, &Job::expected_ms, expectation_slack * request.longest_ms, "expected to take", sweep);

    const std::string cache = request.no_cache ? "" : cache_folder();
    ReferenceFiles kept(cache);
    if (pictures) pictures->scenes.resize(subjects.size());
    for (std::size_t s = 0; s < subjects.size(); ++s)
        trace_truths(options, cache.empty() ? nullptr : &kept, subjects[s], sweep.scenes[s], sweep.notes,
                     pictures ? &pictures->scenes[s] : nullptr);
    for (const std::string& note : kept.notes()) sweep.notes.push_back(note);

    warm_up_all(subjects, jobs, options, sweep, pictures);
    leave_out(jobs, &Job::warm_up_ms, warm_up_slack * request.longest_ms, "took", sweep);
    run_in_turns(jobs, request.runs, options);
    show_progress("");
    for (Job& job : jobs) {
        summarise(job.point, job.stage_ms);
        sweep.points.push_back(std::move(job.point));
        if (pictures) pictures->points.push_back(std::move(job.pictures));
    }
    mark_pareto(sweep.points);
    return sweep;
}

}  // namespace plumb::cli
