// plumb experiment isr: figure 5.7, and the views that POV-Ray renders.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/content_hasher.h"
#include "core/error.h"
#include "gi/isr/isr.h"
#include "tools/experiments/isr.h"
#include "tools/shared/batch_pov.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

Json pov_json(const IsrPov& p) {
    auto optional = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
    return {p.name,
            p.failed,
            p.published_s,
            p.physical_s,
            p.direct_error,
            p.isr_error,
            p.truth_error,
            optional(p.direct_pearson),
            optional(p.isr_pearson),
            p.improved,
            p.worse};
}
IsrPov pov_of(const Json& j) {
    auto optional = [](const Json& v) { return v.is_null() ? std::nullopt : std::optional(v.get<double>()); };
    return {j.at(0), j.at(1),           j.at(2),           j.at(3), j.at(4), j.at(5),
            j.at(6), optional(j.at(7)), optional(j.at(8)), j.at(9), j.at(10)};
}

IsrPov render_pov(const IsrCommon& common, const BatchView& view) {
    const RunOptions& options = common.options;
    const glm::ivec2 size = common.request.size;
    IsrPov pov;
    pov.name = view.name;
    // What POV-Ray cannot show is left out of all pictures.
    const Scene scene = io::pov_scene(common.scenes.scene(view, size));
    const PovPicture published = pov_picture(scene, size, io::PovPreset::published);
    const PovPicture physical = pov_picture(scene, size, io::PovPreset::physical);
    pov.published_s = published.seconds, pov.physical_s = physical.seconds;
    const IsrModel model = isr_model(physical.radiance, isr_exposure(physical.radiance), options);
    const Image4 direct = isr_frame(scene, isr_settings(scene, "direct", {}), options).radiance;
    const Image4 direct_display = isr_display(direct, model.exposure, options);
    const Image4 isr = isr_frame(scene, isr_settings(scene, "isr", {}), options).radiance;
    const IsrMeasure a = isr_compare(model, direct_display, direct, {0, 0}, options),
                     b = isr_compare(model, direct_display, isr, {0, 1}, options);
    reference::PathParams params;
    params.samples = common.request.samples;
    const std::unique_ptr<reference::PathScene> paths = reference::prepare(scene, params.rays);
    const Image4 truth = reference::trace(params, *paths, scene.camera, size, scene.seed, options).mean;
    const IsrMeasure c = isr_compare(model, direct_display, truth, {0, 1}, options);
    pov.direct_error = a.mean_error, pov.isr_error = b.mean_error, pov.truth_error = c.mean_error;
    pov.direct_pearson = a.pearson, pov.isr_pearson = b.pearson;
    pov.improved = b.improved, pov.worse = b.worse;
    return pov;
}

}  // namespace

void isr_times(const IsrCommon& common, const std::vector<BatchView>& views, IsrResult& result) {
    // A medium complex scene of about 20 thousand triangles, as ISR 5.3.1's.
    const BatchView* chosen = &views.front();
    for (const BatchView& v : views) {
        common.scenes.scene(v, common.request.time_size);
        const std::size_t n = common.scenes.triangles();
        if (n > 15'000 && n < 25'000) {
            chosen = &v;
            break;
        }
    }
    const Scene scene = common.scenes.scene(*chosen, common.request.time_size);
    result.time_view = chosen->name, result.time_triangles = common.scenes.triangles();
    const isr::IsrParams params = isr_settings(scene, "isr", {}).isr;
    result.reach = {params.rings, double(params.reach)};
    ContentHasher key;
    key.add(program_hash(), common.scenes.content(*chosen, common.request.time_size), common.request.repeats,
            std::int32_t(common.options.threads));
    if (const std::optional<Json> found = common.results.find("times", key.hash)) {
        for (const Json& t : *found) result.times.push_back({t.at(0), t.at(1), t.at(2), {t.at(3), t.at(4)}});
        return;
    }
    std::vector<std::unique_ptr<IsrTimedFrame>> frames;
    frames.push_back(std::make_unique<IsrTimedFrame>(scene, isr_settings(scene, "direct", {})));
    for (const int rings : {2, 3, 4})
        frames.push_back(std::make_unique<IsrTimedFrame>(scene, isr_settings(scene, "isr", {fmt::format("isr.rings={}", rings)})));
    // Once to warm up, then in turns.
    for (int r = -1; r < std::max(3, common.request.repeats); ++r)
        for (auto& f : frames) {
            f->run(common.options);
            if (r < 0) f->frame_ms.clear(), f->isr_ms.clear();
        }
    Json json = Json::array();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const IsrReach reach = i == 0 ? IsrReach{} : IsrReach{int(i) + 1, double(params.reach)};
        result.times.push_back(
            {isr::sample_count(reach.rings), median(frames[i]->frame_ms), median(frames[i]->isr_ms), reach});
        const IsrTime& t = result.times[i];
        json.push_back({t.samples, t.frame_ms, t.isr_ms, t.reach.rings, t.reach.of_height});
    }
    common.results.keep("times", key.hash, json);
}

std::vector<IsrPov> isr_pov(const IsrCommon& common, const std::vector<BatchView>& views) {
    std::vector<IsrPov> all;
    const std::size_t n = std::min(views.size(), std::size_t(common.request.pov));
    for (std::size_t i = 0; i < n; ++i) {
        const BatchView& view = views[(2 * i + 1) * views.size() / (2 * n)];
        ContentHasher key;
        key.add(program_hash(), common.scenes.content(view, common.request.size), std::int32_t(common.request.samples));
        const std::string name = "pov_" + view.name;
        if (const std::optional<Json> found = common.results.find(name, key.hash)) {
            all.push_back(pov_of(*found));
            continue;
        }
        show_progress(fmt::format("POV-Ray: {} of {}", i + 1, n));
        try {
            all.push_back(render_pov(common, view));
            common.results.keep(name, key.hash, pov_json(all.back()));
        } catch (const InputError& e) {
            all.push_back({view.name, e.what()});
        }
    }
    return all;
}

}  // namespace plumb::cli
