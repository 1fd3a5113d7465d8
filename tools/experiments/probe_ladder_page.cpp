// plumb experiment probe-ladder: the page of curves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/file.h"
#include "tools/experiments/probe_ladder.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Chart;
using page::ChartLine;
using page::ChartPoint;
using page::Line;

struct Axis {
    const char* name;
    const char* title;
    const char* x;
    bool log_x;
    const char* about;
};
constexpr Axis axes[] = {
    {"probes", "Probes", "probes", true, "More probes see more of what receivers see. The radius follows from their number."},
    {"overlaps", "Probes of a receiver", "probes of a receiver", true,
     "How many of the nearest probes a receiver gathers from."},
    {"degree", "Degree of the harmonics", "degree", false, "(degree + 1)² coefficients tell what a probe sees."},
    {"relight", "Relight rays", "rays of a probe", true,
     "How often a probe looks, whenever light changes. Other sets: the same directions, turned as one."},
    {"rays", "Rays of a receiver", "rays of a receiver", true,
     "Paid once, when the bake is made. Other sets: the same directions, turned about each normal."},
    {"clusters", "Singular values", "singular values kept", true,
     "Of each cluster. A lower threshold makes more and smaller clusters; by size alone they have up to 1023 receivers."},
    {"receivers", "Receivers", "receivers of the lightmap", true,
     "A bilinear lookup of each lightmap where the finest has its receivers. Lookup: what interpolating adds to the finest "
     "one's error."},
};

std::string title_of(const std::string& axis) {
    for (const Axis& a : axes)
        if (axis == a.name) return a.title;
    return "Several at once";
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

std::vector<std::pair<std::string, std::string>> values_of(const LadderRung& r) {
    std::vector<std::pair<std::string, std::string>> values = {{"setting", r.is_default ? "default" : r.settings},
                                                               {"error, local", percent(r.errors.local)},
                                                               {"rms of the mean", percent(r.errors.rms)},
                                                               {"bias", percent(r.errors.bias)},
                                                               {"black though lit", percent(r.errors.black)}};
    if (r.axis != "receivers")
        for (std::size_t s = 0; s < ladder_steps; ++s)
            values.push_back({ladder_step_names[s], percent(r.errors.step_local[s])});
    if (r.bytes == 0) return values;
    values.push_back({"bake", fmt::format("{:.3g} s, {:.3g} M rays", r.seconds, double(r.rays) / 1e6)});
    values.push_back({"file", fmt::format("{:.3g} MB", double(r.bytes) / 1e6)});
    values.push_back({"relighting", fmt::format("{:.3g} M products", r.products / 1e6)});
    return values;
}

constexpr double least_drawn = 1e-4;  // steps below it would stretch the axes: rounding is 1e-6

using Figure = double (*)(const LadderRung&);

class LadderPage {
  public:
    explicit LadderPage(const Ladder& ladder)
        : ladder_(ladder), page_(fmt::format("What each number of a bake buys: {}", io::stem_of(ladder.scene))) {}

    std::string html(const std::string& command) {
        introduce();
        add_fronts();
        add_flats();
        for (const Axis& axis : axes) add_axis(axis);
        page_.heading("How it was measured", "how");
        page_.raw(fmt::format("<p><code>{}</code></p>\n", page::escaped(command)));
        page_.paragraph(
            fmt::format("{} receivers of {} are held against {} rays each ({} more see more of the sky than was allowed), "
                        "which know their irradiance to {}; the harmonics' coefficients of the step "
                        "degree are known to {}. The radiance that leaves a surface is direct light with shadow rays, the same "
                        "for all. Seconds are of "
                        "one run, on a machine that may have been busy.",
                        ladder_.checked, ladder_.receivers, ladder_.request.check.truth_rays, ladder_.before_sky,
                        percent(ladder_.uncertainty), percent(ladder_.many_uncertainty)));
        for (const std::string& left : ladder_.left_out) page_.paragraph("Left out: " + left + ".");
        return page_.html();
    }

  private:
    void introduce() {
        const LadderRung& d = ladder_.rungs.front();
        page_.paragraph(fmt::format(
            "Errors of the irradiance that probes bring, against a sum over rays that knows no probes: root mean square over "
            "receivers of "
            "the error over the receiver's own truth plus the mean, so that a few that are very bright do not stand for all. "
            "The default has {} probes, {} clusters, {:.3g} MB, and errs by {}; {} of what is lit is black.",
            d.probes, d.clusters, double(d.bytes) / 1e6, percent(d.errors.local), percent(d.errors.black)));
        std::vector<std::vector<Cell>> rows = {{{"step"}, {"what it leaves out"}, {"what it adds", true}, {"bias", true}}};
        const char* about[ladder_steps] = {
            "all directions but those of the receiver's rays", "what no supporting probe sees",
            "what harmonics of this degree do not show",       "what a probe's relight rays do not meet",
            "singular values beyond those that are kept",      "digits beyond those of a float"};
        double most = 0;
        for (const double rms : d.errors.step_local) most = std::max(most, rms);
        for (std::size_t s = 0; s < ladder_steps; ++s)
            rows.push_back({{ladder_step_names[s]},
                            {about[s]},
                            {percent(d.errors.step_local[s]), true, most > 0 ? d.errors.step_local[s] / most : -1},
                            {percent(d.errors.step_bias[s]), true}});
        page_.table(
            rows,
            "The default's error by its steps. They add up with their signs, receiver by receiver. Steps below 0.01 % are not "
            "drawn in the charts below.");
    }

    static ChartPoint point(const LadderRung& r, double x, double share) { return {x, 100 * share, values_of(r)}; }

    // The default stands out in every chart, on top.
    static void add_default(Chart& chart, const std::vector<const LadderRung*>& rungs, Figure x) {
        for (const LadderRung* r : rungs)
            if (r->is_default) {
                chart.lines.insert(chart.lines.begin(), {"default", {point(*r, x(*r), r->errors.local)}, Line::points});
                return;
            }
    }

    void add_fronts() {
        struct Front {
            const char *title, *x;
            Figure cost;
        };
        const Front fronts[] = {
            {"Error against the file's size", "MB", [](const LadderRung& r) { return double(r.bytes) / 1e6; }},
            {"Error against the rays of the bake", "million rays", [](const LadderRung& r) { return double(r.rays) / 1e6; }},
            {"Error against the bake's time", "s, one run", [](const LadderRung& r) { return r.seconds; }},
            {"Error against the cost of a relighting", "million multiply-adds, a channel",
             [](const LadderRung& r) { return r.products / 1e6; }}};
        page_.heading("Is the default on the front?", "fronts");
        page_.paragraph(
            "Every setting that was measured, by what it costs. The dashed line is the front: no setting below it was found. "
            "What lies in the "
            "shaded part and left of the default is better and cheaper.");
        for (const Front& front : fronts) {
            Chart chart{front.title, front.x, "error, % of local truth + mean", true, true, {}};
            std::vector<std::pair<double, double>> points;
            std::vector<const LadderRung*> whole;
            for (const LadderRung& r : ladder_.rungs) {
                if (r.bytes == 0 || r.axis == "receivers" || r.axis == "default" ||
                    (r.axis == "relight" && r.line != "quadrature weights"))
                    continue;
                whole.push_back(&r), points.push_back({front.cost(r), r.errors.local});
            }
            const LadderRung& d = ladder_.rungs.front();
            chart.lines.push_back({"default", {point(d, front.cost(d), d.errors.local)}, Line::points});
            for (const LadderRung* r : whole) {
                if (r->is_default) continue;
                const std::string name = title_of(r->axis);
                auto line =
                    std::find_if(chart.lines.begin(), chart.lines.end(), [&](const ChartLine& l) { return l.name == name; });
                if (line == chart.lines.end()) line = chart.lines.insert(line, {name, {}, Line::points});
                line->points.push_back(point(*r, front.cost(*r), r->errors.local));
            }
            whole.push_back(&d), points.push_back({front.cost(d), d.errors.local});
            chart.lines.push_back(front_line(points));
            chart.lines.push_back({"the default's error", {{front.cost(d), 100 * d.errors.local}}, Line::level});
            page_.chart(chart);
        }
    }

    void add_flats() {
        page_.heading("Where each curve flattens", "flat");
        std::vector<std::vector<Cell>> rows = {{{"number"},
                                                {"default", true},
                                                {"by bytes", true},
                                                {"by rays", true},
                                                {"by seconds", true},
                                                {"by relighting", true},
                                                {"its own step", true}}};
        for (const LadderFlat& f : flats_of(ladder_)) {
            std::string own;
            for (const LadderRung& r : ladder_.rungs)
                if (r.axis == f.axis && r.line == f.line && r.is_default) own = fmt::format("{:g}", r.value);
            rows.push_back({{f.axis + (f.line == f.axis ? "" : ", " + f.line), false, -1, "", "#" + f.axis},
                            {own, true},
                            {f.bytes, true},
                            {f.rays, true},
                            {f.seconds, true},
                            {f.products, true},
                            {f.settled, true}});
        }
        page_.table(rows,
                    "From which rung on no other halves the whole error for at most twice the cost. Its own step: from which "
                    "rung on what "
                    "the number governs makes less than 5 % of the whole error.");
    }

    static ChartLine front_line(const std::vector<std::pair<double, double>>& points) {
        const std::vector<bool> front = on_front(points);
        std::vector<std::pair<double, double>> kept;
        for (std::size_t i = 0; i < points.size(); ++i)
            if (front[i]) kept.push_back(points[i]);
        std::sort(kept.begin(), kept.end());
        ChartLine line{"front (dashed)", {}, Line::dashed};
        for (const auto& [x, y] : kept) line.points.push_back({x, 100 * y});
        return line;
    }

    void add_axis(const Axis& axis) {
        const auto lines = lines_of(ladder_, axis.name);
        if (lines.empty()) return;
        page_.heading(axis.title, axis.name);
        page_.paragraph(axis.about);
        for (const auto& [name, rungs] : lines) {
            if (std::string(axis.name) == "receivers") {
                add_receivers(axis, rungs);
                continue;
            }
            const std::string more = name == axis.name ? "" : ", " + name;
            Chart chart{axis.title + more, axis.x, "error, % of local truth + mean", axis.log_x, true, {}};
            add_default(chart, rungs, [](const LadderRung& r) { return r.value; });
            ChartLine whole{"whole error"};
            for (const LadderRung* r : rungs) whole.points.push_back(point(*r, r->value, r->errors.local));
            chart.lines.push_back(whole);
            for (std::size_t s = 0; s < ladder_steps; ++s) {
                ChartLine step{ladder_step_names[s]};
                for (const LadderRung* r : rungs)
                    if (r->errors.step_local[s] >= least_drawn)
                        step.points.push_back(point(*r, r->value, r->errors.step_local[s]));
                if (!step.points.empty()) chart.lines.push_back(step);
            }
            ChartLine others{"other sets", {}, Line::points};
            for (const LadderRung* r : rungs)
                for (const double rms : r->others) others.points.push_back(point(*r, r->value, rms));
            if (!others.points.empty()) chart.lines.push_back(others);
            chart.lines.push_back({"truth's uncertainty", {{rungs.front()->value, 100 * ladder_.uncertainty}}, Line::level});
            page_.chart(chart);
        }
        if (std::string(axis.name) == "probes") add_placement();
        if (std::string(axis.name) == "degree") add_windows();
        if (std::string(axis.name) == "overlaps") add_black(axis.title, axis.x, lines);
    }

    void add_windows() {
        const auto lines = lines_of(ladder_, "window");
        if (lines.empty()) return;
        page_.paragraph("What a window over the degrees would bring, before clusters: factors sinc(l / (degree + 1)) or "
                        "(1 + cos(pi l / (degree + 1))) / 2 on the coefficients of degree l. The run time has none.");
        Chart chart{"Degree, with a window", "degree", "error, % of local truth + mean", false, true, {}};
        for (const auto& [name, rungs] : lines) {
            ChartLine line{"window: " + name};
            for (const LadderRung* r : rungs) line.points.push_back(point(*r, r->value, r->errors.local));
            chart.lines.push_back(line);
        }
        page_.chart(chart);
    }

    // What is black, and the same of probes that were chosen by what they see.
    void add_placement() {
        const auto chosen = lines_of(ladder_, "placement");
        if (chosen.empty()) return add_black("Probes", "probes", lines_of(ladder_, "probes"));
        page_.paragraph(
            "As placed: evenly, as the bake does it. Chosen: of a dense placement, one after the other, whichever sees most of "
            "what "
            "receivers see and no other does. Both before clusters.");
        add_black("Probes", "probes", chosen);
        Chart chart{"Probes: unseen, and the whole error", "probes", "error, % of local truth + mean", true, true, {}};
        for (const auto& [name, rungs] : chosen) {
            ChartLine whole{name + ": whole error"}, unseen{name + ": unseen"};
            for (const LadderRung* r : rungs) {
                whole.points.push_back(point(*r, r->value, r->errors.local));
                unseen.points.push_back(point(*r, r->value, r->errors.step_local[step_unseen]));
            }
            chart.lines.push_back(whole), chart.lines.push_back(unseen);
        }
        page_.chart(chart);
    }

    void add_black(const std::string& title, const std::string& x,
                   const std::vector<std::pair<std::string, std::vector<const LadderRung*>>>& lines) {
        Chart chart{title + ": black though lit", x, "% of lit receivers", true, true, {}};
        for (const auto& [name, rungs] : lines) {
            ChartLine line{lines.size() == 1 ? "black" : name};
            for (const LadderRung* r : rungs) line.points.push_back(point(*r, r->value, r->errors.black));
            chart.lines.push_back(line);
        }
        page_.chart(chart);
    }

    void add_receivers(const Axis& axis, const std::vector<const LadderRung*>& rungs) {
        Chart chart{axis.title, axis.x, "error, % of local truth + mean", true, true, {}};
        add_default(chart, rungs, [](const LadderRung& r) { return r.value; });
        ChartLine whole{"whole error"}, lookup{"lookup"};
        for (const LadderRung* r : rungs) {
            whole.points.push_back(point(*r, r->value, r->errors.local));
            lookup.points.push_back(point(*r, r->value, r->lookup));
        }
        chart.lines.push_back(whole), chart.lines.push_back(lookup);
        page_.chart(chart);
    }

    const Ladder& ladder_;
    page::Page page_;
};

}  // namespace

std::string ladder_html(const Ladder& ladder, const std::string& command) { return LadderPage(ladder).html(command); }

}  // namespace plumb::cli
