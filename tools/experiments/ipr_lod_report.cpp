// plumb experiment ipr: level of detail as text and JSON.
#include <fmt/format.h>

#include <algorithm>

#include "tools/experiments/ipr_lod.h"

namespace plumb::cli {

namespace {

std::string ssim_text(const std::optional<double>& ssim) { return ssim ? fmt::format("{:.4f}", *ssim) : "-"; }

const LodFigures* find(const LodTable* table, const std::string& setup) {
    if (!table) return nullptr;
    const auto at = std::find_if(table->rows.begin(), table->rows.end(), [&](const LodFigures& f) { return f.setup == setup; });
    return at == table->rows.end() ? nullptr : &*at;
}

// What moves, a row each setup.
std::string air_text(const std::vector<LodMeasured>& ours) {
    std::string text;
    for (const LodMeasured& m : ours) {
        if (!m.air) continue;
        const LodAir& a = *m.air;
        if (text.empty())
            text = fmt::format("what moves: {} places in the air are read\n{:<16} {:>7} {:>20} {:>9} {:>9} {:>9} {:>9} {:>9}\n", a.read, "setup", "places",
                               "clusters of levels", "MB", "ms", "change", "worst", "least");
        text += fmt::format("{:<16} {:>7} {:>20} {:>9.3f} {:>9.3f} {:>8.2f}% {:>8.2f}% {:>8.2f}%\n", m.setup, a.computed, fmt::format("{}", fmt::join(a.counts.clusters, " ")),
                            1e-6 * double(a.counts.bytes), a.ms, 100 * a.error, 100 * a.worst, 100 * a.least);
    }
    return text;
}

Json air_json(const LodAir& a) {
    return {{"places_read", a.read}, {"places", a.computed}, {"clusters", a.counts.clusters}, {"bytes", a.counts.bytes}, {"ms", a.ms},
            {"error", a.error}, {"worst", a.worst}, {"least", a.least}};
}

Json errors_json(const IprErrors& e) {
    return {{"count", e.count}, {"truth", e.truth}, {"noise", e.noise}, {"mean", e.mean}, {"bias", e.bias}, {"rms", e.rms}};
}

}  // namespace

std::string lod_text(const std::string& title, const std::vector<LodMeasured>& ours, const LodTable* thesis) {
    std::string text = title + (thesis ? fmt::format(" (thesis: {}{}, {})", thesis->number[0] == 'f' ? "" : "table ", thesis->number, thesis->title) : "") + "\n";
    text += fmt::format("{:<16} {:>9} {:>6} {:>9} {:>27} {:>8} {:>8} {:>8} {:>8} {:>10} {:>9} {:>8} {:>8} {:>9}   {}\n", "setup", "receivers", "share", "ms",
                        "levels basis irrad. its map", "speed-up", "SSIM", "change", "worst", "SSIM truth", "pixels", "bias", "rms", "receivers", "thesis: receivers, share, speed-up, SSIM");
    const auto percent = [](const std::optional<IprErrors>& e, double IprErrors::* part) { return e ? fmt::format("{:.2f}%", 100 * (*e).*part) : "-"; };
    for (const LodMeasured& m : ours) {
        const auto share = [](std::int64_t n, std::int64_t of) { return of > 0 ? 100 * double(n) / double(of) : 0.0; };
        text += fmt::format("{:<16} {:>9} {:>5.1f}% {:>9.3f} {:>6.2f} {:>5.2f} {:>6.2f} {:>7.2f} {:>8.2f} {:>8} {:>7.2f}% {:>7.2f}% {:>10} {:>9} {:>8} {:>8} {:>9}", m.setup, m.receivers,
                            share(m.receivers, ours[0].receivers), m.ms, m.stages.levels, m.stages.basis, m.stages.irradiance, m.stages.lightmap, m.speed_up, ssim_text(m.ssim), 100 * m.error, 100 * m.worst, ssim_text(m.ssim_truth),
                            percent(m.at_pixels, &IprErrors::mean), percent(m.at_pixels, &IprErrors::bias), percent(m.at_pixels, &IprErrors::rms),
                            percent(m.at_receivers, &IprErrors::mean));
        if (const LodFigures* f = find(thesis, m.setup))
            text += fmt::format("   {:>7} {:>5.1f}% {:>5.2f} {}", f->receivers, share(f->receivers, thesis->rows[0].receivers), f->speed_up, ssim_text(f->ssim));
        text += "\n";
        if (!m.notes.empty()) text += fmt::format("    {}\n", fmt::join(m.notes, "; "));
    }
    return text + air_text(ours);
}

std::string seams_text(const LodSeams& seams) {
    std::string text = fmt::format("Seams between levels that differ in degree alone: what a tenth of a seam's length exceeds, of the irradiance; "
                                   "visible above {:g} %\n", 100 * visible_step);
    text += "near, far   gap     mean    tenth     seen   hidden by smoothing over\n";
    for (const LodSeam& s : seams.pairs)
        if (s.gap() > 0)
            text += fmt::format("{:>4}, {:>3} {:>5} {:>7.2f}% {:>7.2f}% {:>7.2f}% {:>8.1f} texels{}\n", s.near, s.far, s.gap(), 100 * s.mean, 100 * s.tenth,
                                100 * s.seen, s.texels, s.visible() ? "  visible" : "");
    return text + fmt::format("largest gap without a visible seam: {} from the bake's degree, {} from any (thesis: 2)\n", seams.largest_gap_from_top,
                              seams.largest_gap);
}

Json lod_json(const std::vector<LodMeasured>& ours) {
    Json rows = Json::array();
    for (const LodMeasured& m : ours)
        rows.push_back({{"setup", m.setup},
                        {"receivers", m.receivers},
                        {"clusters", m.counts.clusters},
                        {"probes", m.counts.probes},
                        {"rays", m.counts.rays},
                        {"bytes", m.counts.bytes},
                        {"ms", m.ms},
                        {"levels_ms", m.stages.levels},
                        {"radiance_ms", m.stages.radiance},
                        {"lambda_ms", m.stages.lambda},
                        {"basis_ms", m.stages.basis},
                        {"irradiance_ms", m.stages.irradiance},
                        {"map_ms", m.stages.lightmap},
                        {"speed_up", m.speed_up},
                        {"ssim", m.ssim ? Json(*m.ssim) : Json(nullptr)},
                        {"error", m.error},
                        {"worst", m.worst},
                        {"ssim_truth", m.ssim_truth ? Json(*m.ssim_truth) : Json(nullptr)},
                        {"air", m.air ? air_json(*m.air) : Json(nullptr)},
                        {"at_pixels", m.at_pixels ? errors_json(*m.at_pixels) : Json(nullptr)},
                        {"at_receivers", m.at_receivers ? errors_json(*m.at_receivers) : Json(nullptr)},
                        {"notes", m.notes}});
    return rows;
}

Json seams_json(const LodSeams& seams) {
    Json pairs = Json::array();
    for (const LodSeam& s : seams.pairs)
        pairs.push_back({{"near", s.near}, {"far", s.far}, {"mean", s.mean}, {"tenth", s.tenth}, {"seen", s.seen}, {"texels", s.texels}, {"visible", s.visible()}});
    return {{"largest_gap", seams.largest_gap}, {"largest_gap_from_top", seams.largest_gap_from_top}, {"pairs", pairs}};
}

}  // namespace plumb::cli
