// Times and errors of plumb experiment vrsm.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "gi/frame/kept.h"
#include "tools/experiments/vrsm.h"
#include "tools/shared/options.h"
#include "tools/shared/sweep.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

using rsm::Visibility;

// A setting whose stages all run, again and again, in the memory of the run before: a frame of an animation in which
// everything moves. What a scene's loading takes, the thesis does not count either.
class TimedFrame {
  public:
    TimedFrame(const Scene& scene, frame::Settings settings, bool half, bool visibility)
        : scene_(scene),
          settings_(std::move(settings)),
          plan_(frame::plan(scene, settings_)),
          kept_([this](const graph::Node&, graph::Key) { return ++run_; }) {
        times.half = half, times.visibility = visibility;
    }

    void run(const RunOptions& options, bool counts) {
        const frame::Frame& f = frame::execute(scene_, settings_, plan_, options, kept_);
        if (!counts) return;
        std::array<double, vrsm_passes.size()> passes{};
        for (std::size_t i = 0; i < plan_.stages.size(); ++i)
            if (f.stages[i].needed) passes[vrsm_pass(plan_.stages[i].name)] += f.stages[i].ms;
        double sum = 0;
        for (std::size_t p = 0; p < passes.size(); ++p) times.pass_ms[p].push_back(passes[p]), sum += passes[p];
        times.frame_ms.push_back(sum);
    }

    VrsmTimes times;

  private:
    const Scene& scene_;
    frame::Settings settings_;
    frame::Plan plan_;
    std::uint64_t run_ = 0;
    frame::KeptStages kept_;
};

Image<std::uint8_t> surfaces(const Image4& normal) {
    Image<std::uint8_t> mask(normal.width, normal.height);
    for (std::size_t i = 0; i < normal.size(); ++i) mask.texels[i] = normal.texels[i].w != 0;
    return mask;
}

VrsmTruth cast_truth(const VrsmSubject& subject, const VrsmRequest& request, const RunOptions& options,
                     frame::KeptStages& kept, VrsmScene& scene) {
    frame::Settings settings = vrsm_settings(subject, false, Visibility::none, 0);
    settings.indirect.blur = filter::Blur::none;
    settings.rsm.gather = rsm::Gather::all_rays;
    settings.rsm.rays = request.rays;
    settings.rsm.max_rays = float(request.truth_rays);
    const frame::Plan plan = frame::plan(subject.scene, settings);
    const frame::Frame& f = frame::execute(subject.scene, settings, plan, options, kept);
    for (std::size_t i = 0; i < plan.stages.size(); ++i)
        if (f.stages[i].needed && vrsm_is_gather(plan.stages[i].name)) {
            scene.truth += (scene.truth.empty() ? "" : "; ") + f.stages[i].label + ": " + f.stages[i].reason;
            scene.truth_seconds += f.stages[i].ms * 1e-3;
        }
    VrsmTruth truth{f.indirect, compare::luminances(f.indirect), {}, surfaces(f.gbuffer.normal)};
    if (!f.indirect_error.empty()) truth.error = compare::luminance_errors(f.indirect_error);
    return truth;
}

// The settings whose errors are measured, of one kind; without visibility first.
std::vector<VrsmErrors> settings_to_judge(const VrsmRequest& request, bool chain) {
    std::vector<VrsmErrors> rows{{chain, Visibility::none, 0}};
    for (const Visibility visibility : {Visibility::algorithm_2, Visibility::algorithm_6})
        for (const int slots : request.slots) rows.push_back({chain, visibility, slots});
    return rows;
}
std::vector<VrsmErrors> spacings_to_judge(bool chain) {
    std::vector<VrsmErrors> rows;
    for (const rsm::Spacing spacing : {rsm::Spacing::uniform, rsm::Spacing::quadratic, rsm::Spacing::geometric})
        for (const Visibility visibility : {Visibility::none, Visibility::algorithm_2, Visibility::algorithm_6})
            rows.push_back({chain, visibility, visibility == Visibility::none ? 0 : 5, spacing});
    return rows;
}

frame::Settings settings_of_row(const VrsmSubject& subject, const VrsmErrors& row, int seed) {
    frame::Settings settings = vrsm_settings(subject, row.chain, row.visibility, row.slots);
    if (!row.chain) settings.indirect.blur = filter::Blur::none;
    if (row.spacing) settings.rsm.spacing = *row.spacing, settings.rsm.growth = vrsm_growth;
    settings.seed += std::uint32_t(seed);
    return settings;
}

// Of the rows behind one without visibility, up to the next, how much less leaks.
void add_leak_stopped(std::vector<VrsmErrors>& rows) {
    const VrsmErrors* none = nullptr;
    for (VrsmErrors& row : rows) {
        if (row.visibility == Visibility::none) none = &row;
        for (std::size_t s = 0; s < row.seeds.size(); ++s) {
            const std::optional<double> all = none->seeds[s].leaked, left = row.seeds[s].leaked;
            row.leak_stopped.push_back(all && left && *all > 0 ? std::optional(1 - *left / *all) : std::nullopt);
        }
    }
}

std::vector<VrsmErrors*> pointers(std::vector<VrsmErrors>& rows, auto of_kind) {
    std::vector<VrsmErrors*> some;
    for (VrsmErrors& row : rows)
        if (of_kind(row)) some.push_back(&row);
    return some;
}

template <class Quantity>
VrsmEstimate estimate_of(const std::vector<compare::SignedErrors>& seeds, Quantity quantity) {
    std::vector<std::optional<double>> values;
    for (const compare::SignedErrors& e : seeds) values.push_back(e.*quantity);
    return vrsm_estimate(values);
}

}  // namespace

VrsmEstimate VrsmErrors::estimate(std::optional<double> compare::SignedErrors::* quantity) const {
    return estimate_of(seeds, quantity);
}
VrsmEstimate VrsmErrors::estimate(double compare::SignedErrors::* quantity) const { return estimate_of(seeds, quantity); }
VrsmEstimate VrsmBeyond::estimate(std::optional<double> compare::SignedErrors::* quantity) const {
    return estimate_of(seeds, quantity);
}

bool VrsmErrors::noisy() const {
    const std::optional<double> noise = estimate(&compare::SignedErrors::noise).mean, rms = this->rms().mean;
    return !noise || !rms || *rms < 2 * *noise;
}

VrsmErrors* vrsm_mark_best(const std::vector<VrsmErrors*>& rows) {
    VrsmErrors* least = nullptr;
    for (VrsmErrors* row : rows)
        if (row->rms().mean && (!least || *row->rms().mean < *least->rms().mean)) least = row;
    if (!least) return nullptr;
    bool alone = true;
    for (VrsmErrors* row : rows) {
        if (row == least || !row->rms().mean) continue;
        row->tied = row->noisy() || least->noisy() || !told_apart(row->rms(), least->rms());
        alone = alone && !row->tied;
    }
    least->best = alone, least->tied = !alone;
    return least;
}

std::size_t vrsm_pass(const std::string& stage) {
    if (stage == "rsm") return 0;
    if (stage == "gbuffer" || stage == "shadow") return 1;
    if (stage == "filter.reduce" || vrsm_is_gather(stage)) return 2;
    return 3;
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

frame::Settings vrsm_settings(const VrsmSubject& subject, bool half, Visibility visibility, int slots) {
    SceneOptions options;
    options.sets = subject.sets;
    frame::Settings settings = settings_of(subject.scene, options);
    settings.rsm.visibility = visibility;
    if (slots > 0) settings.rsm.slots = slots;
    settings.indirect.resolution = half ? filter::Resolution::half : filter::Resolution::full;
    return settings;
}

VrsmSubject vrsm_subject(Scene scene, const VrsmRequest& request) {
    // The experiment varies these itself.
    for (const std::string& text : request.sets) {
        const Assignment a = parse_assignment(text);
        for (const char* key : {"rsm.gather", "rsm.visibility", "rsm.slots", "rsm.rays", "rsm.max_rays",
                                "indirect.resolution", "render.method"})
            if (a.table + "." + a.key == key)
                throw InputError(a.place + ": the experiment chooses it: expected another parameter");
    }
    scene.frame_size = {request.size, request.size};
    for (Light& light : scene.lights) light.rsm_size = request.size;

    // The thesis' setting (VRSM 3.3, 4.2-4.5, 5.1); radius, projection and floor stay the scene's.
    scene.method = "rsm", scene.layout = "vrsm";
    std::erase_if(scene.settings, [](const Setting& s) { return s.table == "layout"; });
    auto set = [&](const char* table, const char* key, const FieldValue& value) {
        scene.settings.push_back({table, key, value, "vrsm"});
    };
    using std::string;
    set("rsm", "gather", string("paths")), set("rsm", "directions", 15.0), set("rsm", "steps", 10.0);
    set("rsm", "slots", 5.0), set("rsm", "slot_edges", string("angle")), set("rsm", "turn", string("hash"));
    set("rsm", "fade", 0.0), set("rsm", "thickness", 0.0);
    set("indirect", "blur", string("full")), set("indirect", "kernel", 17.0);
    set("shadow", "mode", string("density")), set("shadow", "test", string("depth"));
    VrsmSubject subject{std::move(scene), "", request.sets};

    const frame::Plan plan = frame::plan(subject.scene, vrsm_settings(subject, true, Visibility::algorithm_6, 5));
    if (std::none_of(plan.stages.begin(), plan.stages.end(),
                     [](const frame::PlannedStage& s) { return s.needed && vrsm_is_gather(s.name); }))
        throw InputError(subject.scene.name + ": no light of it is gathered: expected one that sends indirect light");
    if (!request.beyond) return subject;
    if (!vrsm_settings(subject, true, Visibility::algorithm_6, 5).rsm.pattern.empty())
        throw InputError(subject.scene.name +
                         ": [rsm] pattern: it has one number of samples, expected --no-beyond with it");
    for (const VrsmBeyond& candidate : vrsm_candidates()) frame::plan(subject.scene, vrsm_settings(subject, candidate));
    return subject;
}

std::vector<VrsmTimes> vrsm_times(const VrsmSubject& subject, const VrsmRequest& request, bool full,
                                  const RunOptions& options) {
    std::vector<std::unique_ptr<TimedFrame>> frames;
    for (const bool half : {true, false})
        for (const bool visibility : {false, true})
            if (half || full)
                frames.push_back(std::make_unique<TimedFrame>(
                    subject.scene,
                    vrsm_settings(subject, half, visibility ? Visibility::algorithm_6 : Visibility::none, 5), half,
                    visibility));
    // Once to warm up, then in turns, every other time backwards, so that what slows the machine slows all of them.
    for (int r = -1; r < request.repeats; ++r)
        for (std::size_t i = 0; i < frames.size(); ++i) {
            show_progress(fmt::format("{}: times, {} of {}", subject.scene.name, r + 1, request.repeats));
            frames[r % 2 == 0 ? i : frames.size() - 1 - i]->run(options, r >= 0);
        }
    std::vector<VrsmTimes> times;
    for (auto& f : frames) times.push_back(std::move(f->times));
    return times;
}

void vrsm_look(const VrsmSubject& subject, const VrsmRequest& request, const RunOptions& options, VrsmScene& scene) {
    frame::KeptStages kept;
    show_progress(subject.scene.name + ": truth");
    const VrsmTruth truth = cast_truth(subject, request, options, kept, scene);
    // Of what the stages made before, the truth's maps and G-buffer are kept: all read the same.
    auto render = [&](const VrsmErrors& row, int seed) -> const frame::Frame& {
        const frame::Settings settings = settings_of_row(subject, row, seed);
        return frame::execute(subject.scene, settings, frame::plan(subject.scene, settings), options, kept);
    };
    auto judge = [&](std::vector<VrsmErrors> rows) {
        for (VrsmErrors& row : rows) {
            show_progress(subject.scene.name + ": " + vrsm_row(row));
            for (int seed = 0; seed < request.seeds; ++seed)
                row.seeds.push_back(compare::signed_errors(compare::luminances(render(row, seed).indirect), truth.luminance,
                                                           truth.error, truth.surface, vrsm_judgement));
        }
        add_leak_stopped(rows);
        return rows;
    };
    VrsmErrors best_chain{true, Visibility::none, 0};
    for (const bool chain : {false, true}) {
        std::vector<VrsmErrors> rows = judge(settings_to_judge(request, chain));
        const compare::SignedErrors& first = rows.front().seeds.front();
        if (first.pixels == 0 || (first.mean_truth && !(*first.mean_truth > 0)))
            throw InputError(subject.scene.name + ": no indirect light reaches any point that is seen");
        const VrsmErrors* least = vrsm_mark_best(pointers(rows, [](const VrsmErrors&) { return true; }));
        if (least && chain) best_chain = *least;
        scene.errors.insert(scene.errors.end(), rows.begin(), rows.end());

        std::vector<VrsmErrors> spacing = judge(spacings_to_judge(chain));
        for (const Visibility visibility : {Visibility::none, Visibility::algorithm_2, Visibility::algorithm_6})
            vrsm_mark_best(pointers(spacing, [=](const VrsmErrors& row) { return row.visibility == visibility; }));
        scene.spacing.insert(scene.spacing.end(), spacing.begin(), spacing.end());
    }

    // The thesis' pictures are those of the whole chain.
    const Image4 best = render(best_chain, 0).indirect, without_check = render({true, Visibility::algorithm_2, 5}, 0).indirect;
    frame::Settings unblurred = settings_of_row(subject, {true, Visibility::algorithm_6, 5}, 0);
    unblurred.indirect.blur = filter::Blur::none;
    const Image4 noised =
        frame::execute(subject.scene, unblurred, frame::plan(subject.scene, unblurred), options, kept).indirect;
    const frame::Frame& first = render({true, Visibility::none, 0}, 0);
    const Image4 without = first.indirect, global_without = first.display;
    const frame::Frame& second = render({true, Visibility::algorithm_6, 5}, 0);
    scene.pictures = vrsm_pictures(
        {&second.gbuffer, &truth.irradiance, &without, &second.indirect, &best, &noised, &without_check, &truth.error},
        request.crops, options);
    scene.pictures.global_without = global_without, scene.pictures.global_with = second.display;
    vrsm_paths(subject, options, kept, scene);
    if (request.beyond) scene.beyond = vrsm_beyond(subject, request, truth, options);
    show_progress("");
}

}  // namespace plumb::cli
