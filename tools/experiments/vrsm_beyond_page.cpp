// plumb experiment vrsm's page: the settings beyond the thesis', error over time.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "tools/experiments/vrsm.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Chart;
using page::ChartLine;
using page::ChartPoint;
using page::Line;

class BeyondPage {
  public:
    BeyondPage(page::Page& page, const std::vector<VrsmNumber>& numbers) : page_(page), numbers_(numbers) {}

    void add_families(const std::vector<VrsmBeyond>& beyond) {
        std::vector<std::vector<Cell>> rows{{{"setting"}, {"in place of VRSM's"}}};
        for (std::size_t i = 0; i < beyond.size(); ++i)
            if (i == 0 || beyond[i - 1].family != beyond[i].family)
                rows.push_back({{beyond[i].family}, {fmt::format("{}", fmt::join(beyond[i].sets, " "))}});
        page_.table(rows, "What the settings set, beside rsm.directions and rsm.steps.");
    }

    void add_summary(const Vrsm& result) {
        const bool timed = result.request.times;
        std::vector<std::vector<Cell>> rows{{{"setting, paths x samples"}}};
        if (timed) rows[0].push_back(head("largest relative time, %"));
        for (const char* column : {"largest relative rms, %", "±"}) rows[0].push_back(head(column));
        rows[0].push_back({"winner"});
        for (const VrsmBeyond& b : result.scenes.front().beyond) {
            const std::string row = vrsm_row(b);
            auto n = [&](const char* quantity) { return find("beyond all", "", row, quantity); };
            const VrsmNumber rms = n("largest relative rms");
            rows.push_back({name(b)});
            if (timed) rows.back().push_back(ours(n("largest relative time")));
            rows.back().insert(rows.back().end(), {ours(rms, heat_of(rms)), ours(n("largest relative rms, standard error")),
                                                   winner(n("winner"))});
        }
        page_.table(rows, fmt::format("On the scene where it is worst. ●: the least {} of those that have at most VRSM's error on "
                                      "every scene, by two standard errors; VRSM's own where there is none.",
                                      timed ? "time" : "number of samples"));
    }

    void add_scene(const VrsmScene& scene) {
        const bool timed = !scene.beyond.front().ms.empty();
        page_.chart(chart_of(scene, timed));
        const std::vector<std::pair<std::string, std::string>> estimates = {{"rms", "rms, %"}, {"relative rms", "relative rms, %"},
                                                                            {"mean error", "mean error, %"},
                                                                            {"removed", "wrongly removed, % of energy"},
                                                                            {"leaked", "leaked, % of energy"}};
        std::vector<std::vector<Cell>> rows{{{"setting, paths x samples"}, head("samples of a point")}};
        if (timed) rows[0].push_back(head("time, ms")), rows[0].push_back(head("relative time, %"));
        for (const auto& [quantity, title] : estimates) rows[0].push_back(head(title)), rows[0].push_back(head("±"));
        const std::string cost = timed ? "time" : "samples";
        rows[0].push_back({"VRSM's error, least " + cost}), rows[0].push_back({"VRSM's " + cost + ", least error"});
        for (const VrsmBeyond& b : scene.beyond) {
            const std::string row = vrsm_row(b);
            auto n = [&](const std::string& quantity) { return find("beyond", scene.name, row, quantity); };
            rows.push_back({name(b), ours(n("samples"))});
            if (timed) rows.back().push_back(ours(n("time"))), rows.back().push_back(ours(n("relative time")));
            for (const auto& [quantity, title] : estimates) {
                rows.back().push_back(ours(n(quantity), quantity == "relative rms" ? heat_of(n(quantity)) : -1));
                rows.back().push_back(ours(n(quantity + ", standard error")));
            }
            rows.back().push_back(winner(n("winner"))), rows.back().push_back(winner(n("least rms")));
        }
        page_.table(rows, scene.name + ": all settings. Green: less than VRSM's error. ±: standard error of the mean over the seeds.");
    }

  private:
    const VrsmNumber& find(const std::string& table, const std::string& scene, const std::string& row,
                           const std::string& quantity) const {
        return find_number(numbers_, table, scene, row, quantity);
    }

    static Cell name(const VrsmBeyond& b) {
        return {fmt::format("{}, {} x {}", b.family, b.samples.x, b.samples.y), false, -1, vrsm_row(b)};
    }
    static Cell head(const std::string& text) { return {text, true}; }
    static Cell ours(const VrsmNumber& n, double heat = -1) {
        return {value_text(n.value, n.unit), true, heat,
                n.row + ": " + n.quantity,   "",   n.value ? *n.value : std::numeric_limits<double>::quiet_NaN()};
    }
    static Cell winner(const VrsmNumber& n) { return {n.value == 1 ? "●" : ""}; }
    // Green at half of VRSM's error, red at half as much again.
    static double heat_of(const VrsmNumber& relative) {
        return relative.value ? std::clamp(*relative.value / 100 - 0.5, 0.0, 1.0)
                              : std::numeric_limits<double>::quiet_NaN();
    }

    // Over time, or where there is none over the samples of a point.
    static double place(const VrsmBeyond& b, bool timed) { return timed ? median(b.ms) : b.samples.x * b.samples.y; }

    static ChartPoint point_of(const VrsmBeyond& b, const VrsmBeyond& thesis, bool timed) {
        const VrsmEstimate rms = b.estimate(&compare::SignedErrors::rms);
        ChartPoint point{place(b, timed), rms.mean ? 100 * *rms.mean : std::numeric_limits<double>::quiet_NaN(),
                         {{"setting", vrsm_row(b)},
                          {"samples of a point", fmt::format("{} x {}", b.samples.x, b.samples.y)},
                          {"rms", estimate_text(rms) + " %"},
                          {"relative rms", estimate_text(relative_rms(b, thesis)) + " %"}}};
        if (timed) point.values.push_back({"relative time", fmt::format("{:.1f} %", 100 * b.relative_time)});
        return point;
    }

    static Chart chart_of(const VrsmScene& scene, bool timed) {
        const std::string cost = timed ? "time" : "samples";
        Chart chart{scene.name + ": error over " + cost, timed ? "sampling and filters (ms)" : "samples of a point",
                    "rms, % of the truth's mean", false, false};
        const VrsmBeyond& thesis = scene.beyond.front();
        // The first is drawn on top.
        const ChartPoint mark = point_of(thesis, thesis, timed);
        chart.lines.push_back({"VRSM's setting", {mark}, Line::points});
        for (const VrsmBeyond& b : scene.beyond) {
            const ChartPoint point = point_of(b, thesis, timed);
            if (b.winner) chart.lines.push_back({"VRSM's error, least " + cost, {point}, Line::points});
            if (b.least_rms) chart.lines.push_back({"VRSM's " + cost + ", least error", {point}, Line::points});
        }
        double least = place(thesis, timed), most = least;
        for (const VrsmBeyond& b : scene.beyond) {
            if (chart.lines.back().name != b.family) chart.lines.push_back({b.family});
            chart.lines.back().points.push_back(point_of(b, thesis, timed));
            least = std::min(least, place(b, timed)), most = std::max(most, place(b, timed));
        }
        chart.lines.push_back({"VRSM's error (dashed)", {{least, mark.y}, {most, mark.y}}, Line::dashed});
        return chart;
    }

    page::Page& page_;
    const std::vector<VrsmNumber>& numbers_;
};

}  // namespace

const VrsmNumber& find_number(const std::vector<VrsmNumber>& numbers, const std::string& table, const std::string& scene,
                              const std::string& row, const std::string& quantity) {
    const auto n = std::find_if(numbers.begin(), numbers.end(), [&](const VrsmNumber& v) {
        return v.table == table && v.scene == scene && v.row == row && v.quantity == quantity;
    });
    if (n == numbers.end()) throw std::logic_error("experiment vrsm: no number " + table + " " + quantity);
    return *n;
}

void add_beyond(page::Page& page, const Vrsm& result, const std::vector<VrsmNumber>& numbers) {
    if (!result.request.beyond) return;
    page.heading("Beyond the thesis", "beyond");
    page.paragraph(
        std::string("Settings that reach VRSM's error for less, or less error for as much: at half resolution, the whole chain up "
                    "to the blur. ") +
        (result.request.times ? "Time is that of the stages in which they differ, from positions to irradiance: reduction, "
                                "sampling, upsampling, blur; relative times are medians over the repetitions. "
                              : "Times were not measured (--times): what a setting costs is its samples of a point. ") +
        "Relative: beside VRSM's setting, 15 paths of 10 samples turned by a hash, 5 slots of equal angle with Algorithm 6, a blur "
        "of 17 x 17, seed by seed.");
    BeyondPage beyond(page, numbers);
    beyond.add_families(result.scenes.front().beyond);
    beyond.add_summary(result);
    for (const VrsmScene& scene : result.scenes) beyond.add_scene(scene);
}

}  // namespace plumb::cli
