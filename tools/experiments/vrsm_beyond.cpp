// plumb experiment vrsm: settings beyond the thesis', its error for less.
#include <fmt/format.h>

#include <algorithm>

#include "gi/frame/kept.h"
#include "tools/experiments/vrsm.h"
#include "tools/shared/options.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

struct Family {
    const char* name;
    std::vector<std::string> sets;
    std::vector<glm::ivec2> samples;  // directions, steps
};

// The thesis' setting is the first of the first. What was tried beside these and lost is in data/bench/vrsm.md.
const std::vector<Family>& families() {
    const std::string tile = "rsm.turn=tile", sixteen = "rsm.rotations=16", wide = "indirect.sigma_distance=6",
                      solid = "rsm.slot_edges=solid_angle", rows = "indirect.blur=separable",
                      two = "rsm.visibility=algorithm_2";
    static const std::vector<Family> all = {
        {"VRSM", {}, {{15, 10}, {8, 10}, {4, 16}, {8, 5}}},
        {"rotations over 4 x 4", {tile, sixteen}, {{15, 10}, {8, 10}, {4, 16}, {8, 5}}},
        {"and wider blur", {tile, sixteen, wide}, {{15, 10}, {8, 10}, {4, 16}, {3, 16}}},
        {"and slots of equal solid angle", {tile, sixteen, wide, solid}, {{15, 10}, {8, 10}, {4, 16}}},
        {"wider blur in rows and columns", {tile, sixteen, wide, rows}, {{15, 10}, {6, 16}, {8, 10}, {4, 16}, {3, 16}}},
        {"wider blur, Algorithm 2", {tile, sixteen, wide, two, "rsm.slots=9"}, {{15, 10}, {8, 10}, {4, 16}}},
        {"Algorithm 2, shorter paths, floor of 1 m",
         {tile, sixteen, wide, two, "rsm.slots=7", "rsm.radius=0.5", "rsm.min_distance=1"},
         {{15, 10}, {8, 10}, {4, 16}}},
    };
    return all;
}

// From positions to irradiance: what the settings differ in.
bool is_timed(const std::string& stage) { return vrsm_is_gather(stage) || stage.starts_with("filter."); }

// Maps and G-buffer are the same for all settings and stay; what is timed has a new key whenever it runs.
frame::KeptStages keep_what_is_shared() {
    return frame::KeptStages([run = graph::Key(0)](const graph::Node& node, graph::Key key) mutable {
        return is_timed(node.plan.name) || !node.listed ? ++run : key;
    });
}

// By repetition: what slows the machine for longer than all settings take slows the thesis', too.
double relative_time(const VrsmBeyond& candidate, const VrsmBeyond& thesis) {
    if (candidate.ms.empty()) return 1;
    std::vector<double> ratios;
    for (std::size_t i = 0; i < candidate.ms.size(); ++i) ratios.push_back(candidate.ms[i] / thesis.ms.at(i));
    return median(std::move(ratios));
}

// The thesis' own does, whatever the seeds say of it.
bool holds(const VrsmBeyond& candidate, const VrsmBeyond& thesis) {
    return candidate.sets.empty() || told_at_most(relative_rms(candidate, thesis), 1);
}

void mark(std::vector<VrsmBeyond>& all) {
    const VrsmBeyond& thesis = all.front();
    VrsmBeyond *cheapest = nullptr, *least = nullptr;
    auto rms = [](const VrsmBeyond& b) { return b.estimate(&compare::SignedErrors::rms); };
    for (VrsmBeyond& b : all) {
        if (!rms(b).mean) continue;
        if (holds(b, thesis) && (!cheapest || b.cost(thesis) < cheapest->cost(thesis))) cheapest = &b;
        if (b.cost(thesis) <= 1 && (!least || *rms(b).mean < *rms(*least).mean)) least = &b;
    }
    if (cheapest) cheapest->winner = true;
    const bool alone = least && std::all_of(all.begin(), all.end(), [&](const VrsmBeyond& b) {
        return &b == least || b.cost(thesis) > 1 || told_apart(rms(b), rms(*least));
    });
    if (alone) least->least_rms = true;
}

}  // namespace

std::vector<VrsmBeyond> vrsm_candidates() {
    std::vector<VrsmBeyond> all;
    for (const Family& family : families())
        for (const glm::ivec2& samples : family.samples) {
            VrsmBeyond candidate{family.name, family.sets, samples};
            if (samples.x != 15) candidate.sets.push_back(fmt::format("rsm.directions={}", samples.x));
            if (samples.y != 10) candidate.sets.push_back(fmt::format("rsm.steps={}", samples.y));
            all.push_back(std::move(candidate));
        }
    return all;
}

frame::Settings vrsm_settings(const VrsmSubject& subject, const VrsmBeyond& candidate) {
    SceneOptions options;
    options.sets = subject.sets;
    for (const char* set : {"rsm.visibility=algorithm_6", "rsm.slots=5", "indirect.resolution=half"})
        options.sets.push_back(set);
    options.sets.insert(options.sets.end(), candidate.sets.begin(), candidate.sets.end());
    return settings_of(subject.scene, options);
}

VrsmEstimate relative_rms(const VrsmBeyond& candidate, const VrsmBeyond& thesis) {
    std::vector<std::optional<double>> ratios;
    for (std::size_t s = 0; s < candidate.seeds.size(); ++s) {
        const std::optional<double> ours = candidate.seeds[s].rms, theirs = thesis.seeds.at(s).rms;
        ratios.push_back(ours && theirs && *theirs > 0 ? std::optional(*ours / *theirs) : std::nullopt);
    }
    return vrsm_estimate(ratios);
}

double VrsmBeyond::cost(const VrsmBeyond& thesis) const {
    if (!ms.empty()) return relative_time;
    return double(samples.x * samples.y) / double(thesis.samples.x * thesis.samples.y);
}

std::vector<VrsmBeyond> vrsm_beyond(const VrsmSubject& subject, const VrsmRequest& request, const VrsmTruth& truth,
                                    const RunOptions& options) {
    std::vector<VrsmBeyond> all = vrsm_candidates();
    frame::KeptStages kept = keep_what_is_shared();
    // Once a seed for the errors, which warms up, then in turns, every other time backwards.
    const int seeds = request.seeds, repeats = request.times ? request.repeats : 0;
    for (int r = -seeds; r < repeats; ++r)
        for (std::size_t i = 0; i < all.size(); ++i) {
            show_progress(fmt::format("{}: beyond the thesis, {} of {}", subject.scene.name, r + seeds, seeds + repeats));
            VrsmBeyond& b = all[r % 2 == 0 ? i : all.size() - 1 - i];
            frame::Settings settings = vrsm_settings(subject, b);
            if (r < 0) settings.seed += std::uint32_t(r + seeds);
            const frame::Plan plan = frame::plan(subject.scene, settings);
            const frame::Frame& f = frame::execute(subject.scene, settings, plan, options, kept);
            if (r < 0) {
                b.samples = {settings.rsm.directions, settings.rsm.steps};
                b.seeds.push_back(compare::signed_errors(compare::luminances(f.indirect), truth.luminance, truth.error,
                                                         truth.surface, vrsm_judgement));
                continue;
            }
            double ms = 0;
            for (std::size_t s = 0; s < plan.stages.size(); ++s)
                if (f.stages[s].needed && is_timed(plan.stages[s].name)) ms += f.stages[s].ms;
            b.ms.push_back(ms);
        }
    for (VrsmBeyond& b : all) b.relative_time = relative_time(b, all.front());
    mark(all);
    return all;
}

std::optional<std::size_t> vrsm_winner(const Vrsm& result) {
    std::optional<std::size_t> winner;
    double least = 0;
    if (result.scenes.empty()) return winner;
    for (std::size_t i = 0; i < result.scenes.front().beyond.size(); ++i) {
        double cost = 0;
        bool all_hold = true;
        for (const VrsmScene& scene : result.scenes) {
            const VrsmBeyond& b = scene.beyond.at(i);
            all_hold = all_hold && holds(b, scene.beyond.front());
            cost = std::max(cost, b.cost(scene.beyond.front()));
        }
        if (all_hold && (!winner || cost < least)) winner = i, least = cost;
    }
    return winner;
}

}  // namespace plumb::cli
