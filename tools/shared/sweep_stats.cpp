// Takes medians, marks the Pareto front, picks a setting, and compares two sweeps beyond noise.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

// Below them a difference is no news: of a median, and of an error against the same truth, which only rounding moves.
constexpr double least_slowdown = 0.05, rounding = 1e-6;
// A median has moved if it did by more than this many standard deviations of a run.
constexpr double sigmas = 3;

bool finite(const SweepPoint& p) { return std::isfinite(p.median_ms) && std::isfinite(p.full.rmse); }

bool beats(const SweepPoint& a, const SweepPoint& b) {
    return a.median_ms <= b.median_ms && a.full.rmse <= b.full.rmse &&
           (a.median_ms < b.median_ms || a.full.rmse < b.full.rmse);
}

// The standard deviation of a run by the median of the absolute deviations from the median: one slow run counts little.
double spread(const SweepPoint& p) {
    std::vector<double> deviations;
    for (double ms : p.frame_ms) deviations.push_back(std::abs(ms - p.median_ms));
    return 1.4826 * quantile(deviations, 0.5);
}

// Whether `slow` takes longer than `fast` beyond noise: by more than a share of the median, by more than the spread of
// both explains, and with quartiles that do not meet. Fails closed: a time that is no number is slower.
bool slower(const SweepPoint& slow, const SweepPoint& fast) {
    if (!std::isfinite(slow.median_ms)) return std::isfinite(fast.median_ms);
    const double rise = slow.median_ms - fast.median_ms;
    return rise > least_slowdown * fast.median_ms && rise > sigmas * std::sqrt(spread(slow) * spread(slow) + spread(fast) * spread(fast)) &&
           slow.low_ms > fast.high_ms;
}

// Whether `far` is farther from its truth than `near`. Of the same truth every difference counts that rounding does not
// make; else it has to be more than the noise of both truths.
bool farther(const SweepError& far, const SweepError& near, bool same_truth) {
    if (!std::isfinite(far.rmse)) return std::isfinite(near.rmse);
    const double noise = same_truth ? rounding * near.rmse : far.standard_error + near.standard_error;
    return far.rmse - near.rmse > noise;
}

std::string name_of(const SweepPoint& p) {
    return p.scene + ": " + p.method + (p.settings.empty() ? "" : ", " + p.settings);
}

const SweptScene* find_scene(const Sweep& sweep, const std::string& name) {
    for (const SweptScene& s : sweep.scenes)
        if (s.name == name) return &s;
    return nullptr;
}
const SweepPoint* find_point(const Sweep& sweep, const SweepPoint& like) {
    for (const SweepPoint& p : sweep.points)
        if (p.scene == like.scene && p.method == like.method && p.settings == like.settings) return &p;
    return nullptr;
}

std::string slower_text(const SweepPoint& before, const SweepPoint& now) {
    return fmt::format("{}: {} ms was {} ms, {:+.1f} %", name_of(now), milliseconds_text(now.median_ms),
                       milliseconds_text(before.median_ms), 100 * (now.median_ms / before.median_ms - 1));
}
std::string error_text(const SweepPoint& now, const char* of, const SweepError& before, const SweepError& after) {
    return fmt::format("{}: RMSE against {} {:.6g} was {:.6g}", name_of(now), of, after.rmse, before.rmse);
}

void compare_errors(const SweepPoint& before, const SweepPoint& now, bool same_truth, SweepComparison& c) {
    const struct {
        const char* name;
        const SweepError &before, &now;
    } errors[] = {{"full illumination", before.full, now.full}, {"its own transport", before.own, now.own}};
    for (const auto& e : errors) {
        if (farther(e.now, e.before, same_truth))
            c.worse.push_back({&before, &now, error_text(now, e.name, e.before, e.now)});
        if (farther(e.before, e.now, same_truth))
            c.better.push_back({&before, &now, error_text(now, e.name, e.before, e.now)});
    }
}

// A point that was measured before and is not now. Left out it is worse: it got too long, or is refused. Times of
// another machine, and other scenes, say nothing; what was not asked for is no news.
void compare_missing(const Sweep& before, const Sweep& now, const SweepPoint& was, bool same_machine,
                     SweepComparison& c) {
    const auto left_out = std::find_if(now.left_out.begin(), now.left_out.end(), [&](const LeftOut& l) {
        return l.scene == was.scene && l.method == was.method && l.settings == was.settings;
    });
    if (left_out == now.left_out.end()) {
        c.notes.push_back(name_of(was) + ": not measured this time");
        return;
    }
    const std::string what = fmt::format("{}: left out, was {} ms: {}", name_of(was), milliseconds_text(was.median_ms),
                                         left_out->reason);
    const SweptScene *scene = find_scene(now, was.scene), *old = find_scene(before, was.scene);
    const bool comparable = scene && old && scene->content == old->content && (same_machine || !left_out->too_long);
    if (comparable)
        c.worse.push_back({&was, nullptr, what});
    else
        c.notes.push_back(what);
}

// Why times of the two sweeps say nothing about each other; empty where they do.
std::string other_machine(const Sweep& before, const Sweep& now) {
    auto differ = [](const std::string& what, const std::string& a, const std::string& b) {
        return a == b ? "" : fmt::format("{} {} was {}", what, b, a);
    };
    for (const std::string& why : {differ("the processor", before.processor, now.processor),
                                   differ("the instruction set", before.isa, now.isa),
                                   differ("the number of threads", std::to_string(before.threads),
                                          std::to_string(now.threads))})
        if (!why.empty()) return why;
    return "";
}

}  // namespace

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(values.begin(), values.end());
    const double at = share * double(values.size() - 1);
    const std::size_t below = std::size_t(at);
    const double upper = values[std::min(below + 1, values.size() - 1)];
    return values[below] + (at - double(below)) * (upper - values[below]);
}

void summarise(SweepPoint& p, const std::vector<double>& stage_ms) {
    p.median_ms = quantile(p.frame_ms, 0.5);
    p.low_ms = quantile(p.frame_ms, 0.25);
    p.high_ms = quantile(p.frame_ms, 0.75);
    p.stage_ms = quantile(stage_ms, 0.5);
}

void mark_pareto(std::vector<SweepPoint>& points) {
    for (SweepPoint& p : points)
        p.pareto = finite(p) && std::none_of(points.begin(), points.end(), [&](const SweepPoint& other) {
                       return other.scene == p.scene && finite(other) && beats(other, p);
                   });
}

const SweepPoint* best_within(const Sweep& sweep, const std::string& scene, double budget_ms) {
    const SweepPoint* best = nullptr;
    for (const SweepPoint& p : sweep.points) {
        if (p.scene != scene || !finite(p) || !(p.median_ms <= budget_ms)) continue;
        const bool nearer = best && (p.full.rmse < best->full.rmse ||
                                     (p.full.rmse == best->full.rmse && p.median_ms < best->median_ms));
        if (!best || nearer) best = &p;
    }
    return best;
}

const SweepPoint* fastest_with(const Sweep& sweep, const std::string& scene, double error) {
    const SweepPoint* best = nullptr;
    for (const SweepPoint& p : sweep.points) {
        if (p.scene != scene || !finite(p) || !(p.full.rmse <= error)) continue;
        if (!best || p.median_ms < best->median_ms) best = &p;
    }
    return best;
}

const SweepPoint* fastest(const Sweep& sweep, const std::string& scene) {
    return fastest_with(sweep, scene, std::numeric_limits<double>::max());
}

SweepComparison compare_sweeps(const Sweep& before, const Sweep& now) {
    SweepComparison c;
    const std::string machine = other_machine(before, now);
    if (!machine.empty()) c.notes.push_back("times are not compared: " + machine);
    for (const SweptScene& scene : now.scenes) {
        const SweptScene* old = find_scene(before, scene.name);
        if (!old)
            c.notes.push_back(scene.name + ": new, nothing to compare it with");
        else if (old->content != scene.content)
            c.notes.push_back(scene.name + ": another scene or size than before, not compared");
        else if (old->truth != scene.truth)
            c.notes.push_back(scene.name + ": another truth than before: errors are compared by the noise of both");
    }
    for (const SweepPoint& p : now.points) {
        const SweptScene *scene = find_scene(now, p.scene), *old = find_scene(before, p.scene);
        if (!scene || !old || scene->content != old->content) continue;
        const SweepPoint* was = find_point(before, p);
        if (!was) {
            c.notes.push_back(name_of(p) + ": new, nothing to compare it with");
            continue;
        }
        ++c.compared;
        if (machine.empty()) {
            if (slower(p, *was)) c.worse.push_back({was, &p, slower_text(*was, p)});
            if (slower(*was, p)) c.better.push_back({was, &p, slower_text(*was, p)});
        }
        compare_errors(*was, p, scene->truth == old->truth, c);
    }
    for (const SweepPoint& p : before.points)
        if (!find_point(now, p)) compare_missing(before, now, p, machine.empty(), c);
    return c;
}

}  // namespace plumb::cli
