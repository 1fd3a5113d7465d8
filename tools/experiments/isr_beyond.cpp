// plumb experiment isr: settings beyond the thesis', error against time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/content_hasher.h"
#include "core/error.h"
#include "core/host_math.h"
#include "tools/experiments/isr.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

constexpr int least_repeats = 7;  // stages of a millisecond are disturbed easily

// The environment's light, which is no part of what these settings change, would hide it.
std::vector<std::string> with_ambient_off(std::vector<std::string> sets) {
    sets.push_back("isr.ambient=none");
    return sets;
}

// Times and errors of all candidates on one view.
Json measure(const IsrCommon& common, const BatchView& view, const std::vector<IsrBeyond>& candidates) {
    const RunOptions& options = common.options;
    const reference::KeptEstimate truth = common.truths.of(common.scenes, view, common.request.size, options);
    const Scene& scene = common.scenes.scene(view, common.request.size);
    const IsrModel model = isr_model(truth.estimate.mean, isr_exposure(truth.estimate.mean), options);
    const Image4 direct = isr_frame(scene, isr_settings(scene, "direct", {}), options).radiance;
    const Image4 direct_display = isr_display(direct, model.exposure, options);

    std::vector<std::unique_ptr<IsrTimedFrame>> frames;
    std::vector<std::string> refused;
    for (const IsrBeyond& c : candidates) {
        frames.push_back(nullptr), refused.emplace_back();
        try {
            frames.back() =
                std::make_unique<IsrTimedFrame>(scene, isr_settings(scene, "isr", with_ambient_off(c.sets)));
        } catch (const InputError& e) {
            refused.back() = e.what();
        }
    }
    // Once to warm up, then in turns, every other time backwards.
    std::vector<IsrMeasure> errors(candidates.size());
    for (int r = -1; r < std::max(least_repeats, common.request.repeats); ++r)
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const std::size_t c = r % 2 == 0 ? i : frames.size() - 1 - i;
            if (!frames[c]) continue;
            try {
                const frame::Frame& f = frames[c]->run(options);
                if (r < 0) {
                    errors[c] = isr_compare(model, direct_display, f.radiance, {}, options);
                    frames[c]->frame_ms.clear(), frames[c]->isr_ms.clear();
                }
            } catch (const InputError& e) {
                refused[c] = e.what();
                frames[c].reset();
            }
        }
    Json rows = Json::array();
    for (std::size_t c = 0; c < candidates.size(); ++c)
        rows.push_back(frames[c] ? Json{"", median(frames[c]->isr_ms), errors[c].linear_error, errors[c].mean_error}
                                 : Json{refused[c], 0, 0, 0});
    return rows;
}

double mean_ratio(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += host::log(a[i] / b.at(i));
    return host::exp(sum / double(a.size()));
}

void mark_front(std::vector<IsrBeyond>& all) {
    for (IsrBeyond& a : all)
        a.front = a.refused.empty() && std::none_of(all.begin(), all.end(), [&](const IsrBeyond& b) {
                      return b.refused.empty() && b.relative_time <= a.relative_time &&
                             b.relative_error <= a.relative_error &&
                             (b.relative_time < a.relative_time || b.relative_error < a.relative_error);
                  });
}

}  // namespace

std::vector<IsrBeyond> isr_candidates() {
    std::vector<IsrBeyond> all{{"ISR", {}}};
    auto add = [&](const char* family, std::vector<std::string> sets) { all.push_back({family, std::move(sets)}); };
    for (const int rings : {2, 3, 6, 8}) add("rings", {fmt::format("isr.rings={}", rings)});
    for (const char* reach : {"0.25", "0.5", "1"}) add("reach", {fmt::format("isr.reach={}", reach)});
    for (const int spacing : {8, 16}) add("grid", {fmt::format("isr.spacing={}", spacing)});
    add("grid", {"isr.pattern=grid", "isr.rotations=64"});
    for (const int rotations : {1, 16, 256}) add("rotations", {fmt::format("isr.rotations={}", rotations)});
    for (const int bounces : {2, 3}) add("bounces", {fmt::format("isr.bounces={}", bounces)});
    for (const int depth : {2, 4, 8})
        add("samples by depth", {"isr.far_rings=1", fmt::format("isr.full_depth={}", depth)});
    for (const int guard : {16, 32, 64}) add("guard band", {fmt::format("isr.guard={}", guard)});
    for (const int layers : {2, 3}) add("layers", {fmt::format("isr.layers={}", layers)});
    for (const int cameras : {1, 2}) add("cameras", {fmt::format("isr.cameras={}", cameras)});
    add("together", {"isr.bounces=2", "isr.guard=32", "isr.layers=2"});
    add("together", {"isr.bounces=2", "isr.guard=32", "isr.layers=2", "isr.rings=8"});
    add("together", {"isr.bounces=3", "isr.guard=64", "isr.layers=3", "isr.rings=8", "isr.cameras=2"});
    return all;
}

void isr_beyond(const IsrCommon& common, const std::vector<BatchView>& views, IsrResult& result) {
    std::vector<IsrBeyond> all = isr_candidates();
    std::string texts;
    for (const IsrBeyond& b : all) texts += fmt::format("{}\n", fmt::join(b.sets, " "));
    const std::size_t n = std::min(views.size(), std::size_t(common.request.beyond_views));
    for (std::size_t i = 0; i < n; ++i) {
        const BatchView& view = views[(2 * i + 1) * views.size() / (2 * n)];
        show_progress(fmt::format("beyond: {} of {}", i + 1, n));
        ContentHasher key;
        key.add(program_hash(), common.scenes.content(view, common.request.size), std::int32_t(common.request.samples),
                std::int32_t(common.request.repeats), std::int32_t(common.options.threads));
        key.add(texts);
        const std::string name = "beyond_" + view.name;
        std::optional<Json> rows = common.results.find(name, key.hash);
        if (!rows) {
            rows = measure(common, view, all);
            common.results.keep(name, key.hash, *rows);
        }
        result.beyond_names.push_back(view.name);
        for (std::size_t c = 0; c < all.size(); ++c) {
            const Json& row = rows->at(c);
            if (const std::string why = row.at(0); !why.empty() && all[c].refused.empty()) all[c].refused = why;
            all[c].ms.push_back(row.at(1)), all[c].error.push_back(row.at(2)),
                all[c].display_error.push_back(row.at(3));
        }
    }
    for (IsrBeyond& b : all)
        if (b.refused.empty() && all.front().refused.empty())
            b.relative_time = mean_ratio(b.ms, all.front().ms),
            b.relative_error = mean_ratio(b.error, all.front().error);
    mark_front(all);
    result.beyond = std::move(all);
}

}  // namespace plumb::cli
