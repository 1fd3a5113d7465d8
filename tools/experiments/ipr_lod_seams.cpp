// plumb experiment ipr: seams between levels of detail that differ in degree alone.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "tools/experiments/ipr_lod_world.h"

namespace plumb::cli {

bool LodSeam::visible() const { return seen > visible_step; }

namespace {

// What a share `visible_length` of the values exceeds.
double exceeded(std::vector<double> values) {
    const auto at = values.begin() + std::ptrdiff_t(double(values.size()) * (1 - visible_length));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// The largest relative change of each place's irradiance to a texel beside it; of one that has none 0.
std::vector<double> own_changes(const probes::RunData& data, const std::vector<double>& light) {
    std::vector<double> changes(light.size(), 0.0);
    const Image<std::int32_t>& cover = data.cover;
    for (int y = 0; y < cover.height; ++y)
        for (int x = 0; x < cover.width; ++x) {
            if (cover(x, y) < 0) continue;
            const std::size_t a = std::size_t(cover(x, y));
            for (const glm::ivec2& step : probes::border_steps) {
                const int bx = x + step.x, by = y + step.y;
                if (bx < 0 || by < 0 || bx >= cover.width || by >= cover.height || cover(bx, by) < 0 || !(light[a] > 0)) continue;
                changes[a] = std::max(changes[a], std::fabs(light[std::size_t(cover(bx, by))] - light[a]) / light[a]);
            }
        }
    return changes;
}

LodSeam seam_of(int near, int far, const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& own, double least) {
    LodSeam s{near, far};
    std::vector<double> steps, seen, texels;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!(a[i] > least)) continue;
        const double step = std::fabs(b[i] - a[i]) / a[i];
        s.mean += step;
        steps.push_back(step), seen.push_back(step > own[i] ? step : 0);
        texels.push_back(step / std::max(own[i], visible_step));
    }
    if (steps.empty()) throw InputError("level of detail: no receiver is lit");
    s.mean /= double(steps.size());
    s.tenth = exceeded(std::move(steps)), s.seen = exceeded(std::move(seen)), s.texels = exceeded(std::move(texels));
    return s;
}

}  // namespace

LodSeams largest_gaps(std::vector<LodSeam> pairs) {
    if (pairs.empty()) throw InputError("level of detail: no pairs of degrees");
    LodSeams seams;
    int top = 0;
    for (const LodSeam& p : pairs) top = std::max(top, p.near);
    const auto largest = [&](auto counts) {
        for (int gap = 1; gap <= top; ++gap)
            if (std::any_of(pairs.begin(), pairs.end(), [&](const LodSeam& p) { return p.gap() == gap && counts(p) && p.visible(); })) return gap - 1;
        return top;
    };
    seams.largest_gap = largest([](const LodSeam&) { return true; });
    seams.largest_gap_from_top = largest([&](const LodSeam& p) { return p.near == top; });
    seams.pairs = std::move(pairs);
    return seams;
}

LodSeams LodBench::seams() const {
    const World& w = *world_;
    LodRun run = w.run_of({});
    w.take_levels(run, Camera{});
    Image4 before;
    probes::converge(w.buffers(run), probes::RunParams{}, w.options, before);
    run.before = before;
    // Levels of one light that differ in degree alone: the same radiance for all.
    const int top = w.bake.params.degree;
    std::vector<std::vector<double>> light;
    std::vector<std::vector<double>> own;
    double mean = 0;
    for (int degree = 0; degree <= top; ++degree) {
        run.lod.coefficients.fill((degree + 1) * (degree + 1));
        probes::update(w.buffers(run), w.options);
        std::vector<double> l;
        for (int i = 0; i < run.data.count(); ++i) l.push_back(lod_luminance(run.irradiance.texels[std::size_t(i)]));
        own.push_back(own_changes(run.data, l));
        light.push_back(std::move(l));
    }
    for (const double l : light.back()) mean += l / double(light.back().size());
    std::vector<LodSeam> pairs;
    for (int near = top; near >= 0; --near)
        for (int far = near; far >= 0; --far)
            pairs.push_back(seam_of(near, far, light[std::size_t(near)], light[std::size_t(far)], own[std::size_t(near)], 0.05 * mean));
    return largest_gaps(std::move(pairs));
}

}  // namespace plumb::cli
