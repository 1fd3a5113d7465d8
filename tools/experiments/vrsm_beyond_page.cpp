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
        std::vector<std::vector<Cell>> rows{{{"setting, paths x samples"},
                                             head("largest relative time, %"),
                                             head("largest relative rms, %"),
                                             {"winner"}}};
        for (const VrsmBeyond& b : result.scenes.front().beyond) {
            const std::string row = vrsm_row(b);
            const VrsmNumber& rms = find("beyond all", "", row, "largest relative rms");
            rows.push_back({name(b), ours(find("beyond all", "", row, "largest relative time")),
                            ours(rms, heat_of(rms)), winner(find("beyond all", "", row, "winner"))});
        }
        page_.table(rows,
                    "On the scene where it is worst. ●: the least time of those that have at most VRSM's error on "
                    "every scene.");
    }

    void add_scene(const VrsmScene& scene) {
        page_.chart(chart_of(scene));
        std::vector<std::vector<Cell>> rows{{{"setting, paths x samples"},
                                             head("samples of a point"),
                                             head("time, ms"),
                                             head("relative time, %"),
                                             head("rms, %"),
                                             head("relative rms, %"),
                                             head("mean error, %"),
                                             head("wrongly removed, % of energy"),
                                             head("leaked, % of energy"),
                                             {"VRSM's error, least time"},
                                             {"VRSM's time, least error"}}};
        for (const VrsmBeyond& b : scene.beyond) {
            const std::string row = vrsm_row(b);
            auto n = [&](const char* quantity) { return find("beyond", scene.name, row, quantity); };
            rows.push_back({name(b), ours(n("samples")), ours(n("time")), ours(n("relative time")), ours(n("rms")),
                            ours(n("relative rms"), heat_of(n("relative rms"))), ours(n("mean error")),
                            ours(n("removed")), ours(n("leaked")), winner(n("winner")), winner(n("least rms"))});
        }
        page_.table(rows, scene.name + ": all settings. Green: less than VRSM's error.");
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

    static ChartPoint point_of(const VrsmBeyond& b, const VrsmBeyond& thesis) {
        const std::optional<double> rms = relative_rms(b, thesis);
        return {median(b.ms),
                b.errors.rms ? 100 * *b.errors.rms : std::numeric_limits<double>::quiet_NaN(),
                {{"setting", vrsm_row(b)},
                 {"samples of a point", fmt::format("{} x {}", b.samples.x, b.samples.y)},
                 {"relative time", fmt::format("{:.1f} %", 100 * b.relative_time)},
                 {"relative rms", rms ? fmt::format("{:.1f} %", 100 * *rms) : "undefined"}}};
    }

    static Chart chart_of(const VrsmScene& scene) {
        Chart chart{scene.name + ": error over time", "sampling and filters (ms)", "rms, % of the truth's mean", false,
                    false};
        const VrsmBeyond& thesis = scene.beyond.front();
        // The first is drawn on top.
        const ChartPoint mark = point_of(thesis, thesis);
        chart.lines.push_back({"VRSM's setting", {mark}, Line::points});
        for (const VrsmBeyond& b : scene.beyond) {
            if (b.winner) chart.lines.push_back({"VRSM's error, least time", {point_of(b, thesis)}, Line::points});
            if (b.least_rms) chart.lines.push_back({"VRSM's time, least error", {point_of(b, thesis)}, Line::points});
        }
        double fastest = median(thesis.ms), slowest = fastest;
        for (const VrsmBeyond& b : scene.beyond) {
            if (chart.lines.back().name != b.family) chart.lines.push_back({b.family});
            chart.lines.back().points.push_back(point_of(b, thesis));
            fastest = std::min(fastest, median(b.ms)), slowest = std::max(slowest, median(b.ms));
        }
        chart.lines.push_back({"VRSM's error (dashed)", {{fastest, mark.y}, {slowest, mark.y}}, Line::dashed});
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
        "Settings that reach VRSM's error in less time, or less error in its time: at half resolution, the whole chain "
        "up to the blur. Time is that of the stages in which they differ, from positions to irradiance: reduction, "
        "sampling, upsampling, blur. Relative: beside VRSM's setting, 15 paths of 10 samples turned by a hash, 5 slots "
        "of equal angle with Algorithm 6, a blur of 17 x 17; of times the median over the repetitions.");
    BeyondPage beyond(page, numbers);
    beyond.add_families(result.scenes.front().beyond);
    beyond.add_summary(result);
    for (const VrsmScene& scene : result.scenes) beyond.add_scene(scene);
}

}  // namespace plumb::cli
