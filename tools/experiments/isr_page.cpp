// plumb experiment isr as one page of HTML: ISR's figures and table, ours beside its numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/compare_pictures.h"
#include "gi/isr/isr.h"
#include "tools/experiments/isr.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"
#include "tools/shared/sweep_subject.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Page;

constexpr std::size_t shown_cases = 3;
constexpr double negative_gain = 4;  // of the difference, so that it is seen on paper

double gain_of(const IsrViewResult& v, const IsrK& k) { return isr_gain(v, isr_measure_of(v, k)); }
double correlation_gain(const IsrViewResult& v, const IsrK& k) {
    return isr_measure_of(v, k).pearson.value_or(0) - v.direct.pearson.value_or(0);
}

IsrPictures pictures_of(const IsrCommon& common, const BatchView& view, const IsrViewResult& result, const IsrK& best) {
    const RunOptions& options = common.options;
    const reference::KeptEstimate truth = common.truths.of(common.scenes, view, common.request.size, options);
    const Scene& scene = common.scenes.scene(view, common.request.size);
    IsrPictures p;
    p.name = view.name;
    p.truth = isr_display(truth.estimate.mean, result.exposure, options);
    p.direct =
        isr_display(isr_frame(scene, isr_settings(scene, "direct", {}), options).radiance, result.exposure, options);
    p.isr = isr_display(isr_frame(scene, isr_settings(scene, "isr", isr_sets(best)), options).radiance, result.exposure,
                        options);
    const compare::Picture negative =
        compare::difference(isr_rgb(p.isr), isr_rgb(p.direct), compare::Difference::negative, negative_gain);
    p.negative = p.isr;
    for (std::size_t i = 0; i < p.negative.size(); ++i)
        p.negative.texels[i] = {negative.data[3 * i], negative.data[3 * i + 1], negative.data[3 * i + 2], 1};
    const IsrMeasure& m = isr_measure_of(result, best);
    p.caption = fmt::format("mean error {:.4f} -> {:.4f}, gain {:.2f} %, correlation {:.4f} -> {:.4f}",
                            result.direct.mean_error, m.mean_error, 100 * isr_gain(result, m),
                            result.direct.pearson.value_or(0), m.pearson.value_or(0));
    return p;
}

class IsrPage {
  public:
    IsrPage(const IsrResult& result, const std::vector<IsrNumber>& numbers, const IsrGallery& gallery)
        : result_(result),
          numbers_(numbers),
          gallery_(gallery),
          page_("ISR's evaluation, repeated: plumb experiment isr") {}

    std::string html(const std::string& command) {
        introduce();
        add_summary();
        add_times();
        add_charts();
        add_cases();
        add_modes();
        add_pov();
        add_beyond();
        add_turning();
        add_views();
        tell_how(command);
        return page_.html();
    }

  private:
    static Cell ours(const IsrNumber& n, double heat = -1) {
        return {isr_value_text(n),         true, heat,
                n.row + ": " + n.quantity, "",   n.value ? *n.value : std::numeric_limits<double>::quiet_NaN()};
    }
    static Cell theirs(const IsrNumber& n) {
        return {n.thesis ? fmt::format("{:g}", *n.thesis) : "", true, -1, "as printed"};
    }
    static Cell head(const std::string& text, const std::string& hint = "") { return {text, true, -1, hint}; }

    std::vector<const IsrNumber*> of(const std::string& table) const {
        std::vector<const IsrNumber*> found;
        for (const IsrNumber& n : numbers_)
            if (n.table == table) found.push_back(&n);
        return found;
    }
    double value(const std::string& table, const std::string& scene, const std::string& row,
                 const std::string& quantity) const {
        for (const IsrNumber& n : numbers_)
            if (n.table == table && n.scene == scene && n.row == row && n.quantity == quantity && n.value)
                return *n.value;
        return std::numeric_limits<double>::quiet_NaN();
    }

    // One row each for what has the same scene and row; columns are the quantities of the first.
    void table_of(const std::string& table, const std::string& first, const std::string& second,
                  const std::string& caption) {
        std::vector<std::vector<Cell>> rows;
        const IsrNumber* before = nullptr;
        std::vector<Cell> heads{{first}, {second}};
        bool first_row = true;
        for (const IsrNumber* n : of(table)) {
            if (!before || before->scene != n->scene || before->row != n->row) {
                if (before) first_row = false;
                rows.push_back({{n->scene}, {n->row}});
            }
            if (first_row) heads.push_back(head(n->quantity + (n->unit.empty() ? "" : ", " + n->unit)));
            rows.back().push_back(ours(*n));
            before = n;
        }
        if (rows.empty()) return page_.paragraph("Nothing was measured.");
        rows.insert(rows.begin(), heads);
        for (std::vector<Cell>& row : rows) row.resize(heads.size(), Cell{""});
        page_.table(rows, caption);
    }

    void introduce() {
        const IsrRequest& r = result_.request;
        page_.paragraph(fmt::format(
            "After Rohleder 2010, chapter 5, who rendered 80 views of simple scenes (up to 25 thousand triangles) and "
            "147 "
            "of complex ones at 1024 x 768 on a Radeon HD 4870, with direct light alone (DL) and with image-space "
            "radiosity (ISR), against model images by POV-Ray. Here: {} views at {} x {} pixels against a path tracer "
            "with all bounces and {} paths a pixel, each shown at the exposure that makes the truth's logarithmic mean "
            "a middle grey.",
            result_.views.size(), r.size.x, r.size.y, r.samples));
        page_.paragraph(fmt::format(
            "The samples lie in {} rings of growing radius, out to {:.1f} % of the frame's height: the same share of a "
            "frame of any size.",
            result_.reach.rings, 100 * result_.reach.of_height));
        page_.raw(
            "<p><a href=\"#summary\">Summary</a>, <a href=\"#times\">times</a>, <a href=\"#figures\">figures 5.8 to "
            "5.10</a>, <a href=\"#cases\">best and worst cases</a>, <a href=\"#modes\">modes</a>, <a "
            "href=\"#pov\">POV-Ray</a>, <a href=\"#beyond\">beyond the thesis</a>, <a href=\"#turning\">view "
            "dependency</a>, <a href=\"#views\">all views</a>, <a href=\"#how\">how it was measured</a>.</p>\n");
    }

    void add_summary() {
        page_.heading("Summary", "summary");
        const std::vector<const IsrNumber*> all = of("summary");
        std::vector<std::string> groups, settings;
        auto remember = [](std::vector<std::string>& known, const std::string& name) {
            if (std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
        };
        for (const IsrNumber* n : all) remember(groups, n->scene), remember(settings, n->row);
        for (const std::string& group : groups) {
            std::vector<std::vector<Cell>> rows{{{"quantity"}, {"unit"}}};
            for (const std::string& setting : settings) rows[0].push_back(head(setting));
            rows[0].push_back(head("ISR", "as printed"));
            for (const IsrNumber* n : all) {
                if (n->scene != group) continue;
                auto row = std::find_if(rows.begin() + 1, rows.end(),
                                        [&](const std::vector<Cell>& r) { return r[0].text == n->quantity; });
                if (row == rows.end()) row = rows.insert(rows.end(), {{n->quantity}, {n->unit}});
                row->push_back(ours(*n));
            }
            // What the thesis prints is of its own setting, the first.
            for (const IsrNumber* n : all)
                if (n->scene == group && n->row == settings.front())
                    std::find_if(rows.begin() + 1, rows.end(), [&](const std::vector<Cell>& r) {
                        return r[0].text == n->quantity;
                    })->push_back(theirs(*n));
            page_.raw("<h3>" + page::escaped(group == "all" ? "All views" : "Views of " + group) + "</h3>\n");
            page_.table(rows);
        }
        page_.paragraph(
            "Errors are of the display, 0..1, sRGB-encoded, what Imalyzer compares; linear errors are of radiance, "
            "over the "
            "truth's mean. A pixel is improved where its luminance (17) comes nearer to the truth's than direct "
            "light's, "
            "and made worse where it moves away from it.");
        std::string plain = "Said plainly: ";
        for (const std::string& row : settings)
            plain += fmt::format(
                "{}: {:.2f} % of the pixels come nearer to the truth, {:.2f} % are made worse, the rest "
                "stays, and {:.1f} % of the views gain; ",
                row, value("summary", "all", row, "pixels improved"), value("summary", "all", row, "pixels made worse"),
                value("summary", "all", row, "views with gain"));
        page_.paragraph(plain + "the thesis states 99.05 % and all views.");
        page_.paragraph(
            "Gains depend on the size of the pictures: the grid of the printed form reaches a number of pixels, not a share of the frame, and "
            "what lies nearer than a pixel is not there to be sampled. Compare figures of one size.");
        page_.paragraph(
            "Against one bounce: the truth is what ISR means to compute, one bounce of the lamps' light and what surfaces emit, without "
            "the environment, further bounces and what is glossy. A view or a pixel that is neither better nor worse is a tie: not worse counts it.");
        page_.paragraph(
            "ambient = environment lets the sky shine on every surface by its accessibility alone, which sees no "
            "farther than its few samples: indoors it leaks. ambient = none leaves the sky's light out, as direct "
            "light "
            "does.");
    }

    void add_times() {
        page_.heading("Figure 5.7 and table 2: times", "times");
        table_of("5.7", "view", "setting",
                 fmt::format("Figure 5.7: {} with {} triangles at {} x {} pixels; medians of a frame's stages, and of "
                             "those that are ISR's own.",
                             result_.time_view, result_.time_triangles, result_.request.time_size.x,
                             result_.request.time_size.y));
        const IsrRequest& request = result_.request;
        if (!result_.times.empty())
            page_.paragraph(fmt::format(
                "Fewer rings reach as far. Table 2 is of the views themselves, at {} x {} pixels.", request.size.x, request.size.y));
        page::Chart chart{"Figure 5.7: time by the number of samples", "samples", "ms", false, false, {}};
        page::ChartLine frame{"frame"}, own{"stages of ISR"};
        for (const IsrTime& t : result_.times)
            frame.points.push_back({double(t.samples), t.frame_ms}),
                own.points.push_back({double(t.samples), t.isr_ms});
        chart.lines = {frame, own};
        page_.chart(chart);
        std::vector<std::vector<Cell>> rows{{{"what"}, {"quantity"}, head("ours"), {"unit"}, head("ISR")}};
        for (const IsrNumber* n : of("2")) rows.push_back({{n->row}, {n->quantity}, ours(*n), {n->unit}, theirs(*n)});
        page_.table(
            rows, fmt::format("Table 2. ISR's times are a GPU's of 2009 at 1024 x 768 pixels, ours a CPU's at {} x {}; "
                              "its rate of ISR, 112.48761 FPS, is an erratum: 227 / 2.02 is 112.38.",
                              request.size.x, request.size.y));
    }

    void view_chart(const std::string& title, const std::string& y, const std::vector<std::string>& names,
                    const std::vector<std::string>& quantities) {
        page::Chart chart{title, "view", y, false, false, {}};
        for (std::size_t q = 0; q < names.size(); ++q) {
            page::ChartLine line{names[q], {}, page::Line::points};
            for (std::size_t i = 0; i < result_.views.size(); ++i) {
                const IsrViewResult& v = result_.views[i];
                const double n = value("views", v.group, v.name, quantities[q]);
                line.points.push_back({double(i + 1), n, {{"view", v.name}, {y, fmt::format("{:.4g}", n)}}});
            }
            chart.lines.push_back(line);
        }
        page_.chart(chart);
    }

    void add_charts() {
        page_.heading("Figures 5.8 to 5.10", "figures");
        page_.paragraph("Views by their number, the simple scenes first.");
        view_chart("Figure 5.8: mean error", "mean error",
                   {"DL", "ISR, published", "ISR, corrected", "ISR, without ambient", "ISR, best"},
                   {"mean error of DL", "mean error of ISR, published", "mean error of ISR, corrected",
                    "mean error of ISR, without ambient", "mean error of ISR, best"});
        view_chart("Figure 5.9: gain in quality", "gain, %", {"published", "corrected", "without ambient", "best"},
                   {"gain, published", "gain, corrected", "gain, without ambient", "gain, best"});
        page::Chart chart{"Figure 5.10: gain of correlation", "view", "correlation of ISR - of DL", false, false, {}};
        for (const char* kind : {"published", "corrected", "without ambient", "best"}) {
            page::ChartLine line{kind, {}, page::Line::points};
            for (std::size_t i = 0; i < result_.views.size(); ++i) {
                const IsrViewResult& v = result_.views[i];
                const double g = value("views", v.group, v.name, std::string("correlation of ISR, ") + kind) -
                                 value("views", v.group, v.name, "correlation of DL");
                line.points.push_back({double(i + 1), g, {{"view", v.name}, {"gain", fmt::format("{:+.4f}", g)}}});
            }
            chart.lines.push_back(line);
        }
        page_.chart(chart);
    }

    void show(const std::vector<IsrPictures>& all) {
        for (const IsrPictures& p : all) {
            page_.raw("<h4>" + page::escaped(p.name) + "</h4>\n");
            page_.paragraph(p.caption);
            page_.figure(page_.picture(p.truth, "truth"));
            page_.figure(page_.picture(p.direct, "(a) DL"));
            page_.figure(page_.picture(p.isr, "(b) ISR at its best"));
            page_.figure(page_.picture(p.negative, fmt::format("(c) 1 - {:g} |ISR - DL|", negative_gain)));
        }
    }

    void add_cases() {
        page_.heading("Figures 5.5, 5.11, 5.12: best and worst cases", "cases");
        page_.raw("<h3>The largest gains</h3>\n"), show(gallery_.best);
        page_.raw("<h3>The smallest gains</h3>\n"), show(gallery_.worst);
        page_.raw("<h3>Figure 5.11: the largest gain of correlation</h3>\n"), show(gallery_.correlated);
        page_.raw("<h3>Figure 5.12: the least</h3>\n"), show(gallery_.uncorrelated);
    }

    void add_modes() {
        page_.heading("The modes F2 to F5", "modes");
        page_.paragraph(gallery_.modes_name +
                        ": F2 indirect light and shadows, F3 without shadows, F4 direct light alone "
                        "with shadows, F5 without.");
        for (const auto& [name, picture] : gallery_.modes) page_.figure(page_.picture(picture, name));
    }

    void add_pov() {
        page_.heading("Against POV-Ray", "pov");
        page_.paragraph(
            "Both of scenes as POV-Ray can show them: a texture is its mean. The model is the preset "
            "`physical` (brightness 1); `published` is the block of ISR's table 1, whose brightness of 2.4 "
            "multiplies light at every gather: its time alone is taken.");
        table_of("pov", "", "view", "Errors of the display against POV-Ray's picture.");
        for (const IsrPov& p : result_.pov)
            if (!p.failed.empty()) page_.paragraph(p.name + ": " + p.failed);
    }

    void add_beyond() {
        page_.heading("Beyond the thesis", "beyond");
        page_.paragraph(
            fmt::format("Settings of [isr] in place of the corrected defaults, in turns on {}; errors of "
                        "radiance against the path tracer, times of the stages that are ISR's own. Geometric "
                        "means of the ratios to ISR's. ●: on the front, no other is as good in both.",
                        fmt::join(result_.beyond_names, ", ")));
        std::vector<std::vector<Cell>> rows{
            {{"setting"}, head("time, % of ISR's"), head("error, % of ISR's"), {"front"}}};
        page::Chart chart{"Error against time", "time, % of ISR's", "error, % of ISR's", true, false, {}};
        std::vector<page::ChartPoint> front;
        for (const IsrBeyond& b : result_.beyond) {
            const std::string name = b.sets.empty() ? "ISR" : fmt::format("{}", fmt::join(b.sets, " "));
            if (!b.refused.empty()) {
                page_.paragraph("Left out: " + name + ": " + b.refused);
                continue;
            }
            const double t = 100 * b.relative_time, e = 100 * b.relative_error;
            rows.push_back(
                {{name}, {fmt::format("{:.1f}", t), true}, {fmt::format("{:.2f}", e), true}, {b.front ? "●" : ""}});
            if (chart.lines.empty() || chart.lines.back().name != b.family) chart.lines.push_back({b.family, {}});
            chart.lines.back().points.push_back({t, e, {{"setting", name}}});
            if (b.front) front.push_back({t, e, {{"setting", name}}});
        }
        std::sort(front.begin(), front.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
        chart.lines.push_back({"front", front, page::Line::dashed});
        if (result_.beyond.empty()) return page_.paragraph("Nothing was measured.");
        page_.table(rows);
        page_.chart(chart);
    }

    void add_turning() {
        page_.heading("View dependency", "turning");
        page_.paragraph(
            "The irradiance that ISR finds at the same points of the world, as the camera turns about its up "
            "axis until they leave the frame; only where they are seen. The truth is one bounce of the "
            "lamps' light and what surfaces emit, traced. The curves are sums of irradiance over the points that are seen at that yaw, over "
            "the sums of these points' truths; the mean is the same over all yaws. Standard deviation and range are "
            "each point's own over the yaw, of the points that are seen from two yaws at least, summed and over the "
            "sum of these points' truths. The standard deviation over the mean is each point's own over its own mean "
            "irradiance: the mean over these points, weighted by their truths.");
        table_of("turning", "view", "setting", "Mean, standard deviation and range over the yaw.");
        for (const IsrTurningView& v : result_.turning) {
            page::Chart chart{
                v.name + ": irradiance of the points", "yaw, degrees", "irradiance, % of the truth", false, false, {}};
            for (const IsrTurning& t : v.settings) {
                if (!t.refused.empty()) {
                    page_.paragraph(t.setting + ": " + t.refused);
                    continue;
                }
                page::ChartLine line{t.setting};
                for (const IsrYaw& y : isr_turning_curve(t, v.truth))
                    line.points.push_back({y.yaw_deg, 100 * y.mean, {{"points seen", std::to_string(y.points)}}});
                chart.lines.push_back(line);
            }
            chart.lines.push_back({"truth", {{0, 100}}, page::Line::level});
            page_.chart(chart);
        }
    }

    void add_views() {
        page_.heading("All views", "views");
        table_of("views", "list", "view", "Columns sort by a click.");
    }

    void tell_how(const std::string& command) {
        page_.heading("How it was measured", "how");
        page_.raw(fmt::format("<p><code>{}</code></p>\n", page::escaped(command)));
        page_.paragraph(
            fmt::format("On {}, instruction set {}, {} thread{}; load of the machine {:.1f} before and {:.1f} after. "
                        "The truth holds "
                        "what ISR does not mean to compute as well: every bounce, the sky's light with its shadows, "
                        "and what glossy "
                        "surfaces reflect. Its own noise, as the column of that name says, is part of every error; a "
                        "picture without "
                        "any error would have it.",
                        result_.processor, result_.isa, result_.threads, result_.threads == 1 ? "" : "s",
                        result_.load_before, result_.load_after));
    }

    const IsrResult& result_;
    const std::vector<IsrNumber>& numbers_;
    const IsrGallery& gallery_;
    Page page_;
};

}  // namespace

IsrGallery isr_gallery(const IsrCommon& common, const std::vector<BatchView>& views, const IsrResult& result) {
    IsrGallery gallery;
    auto cases = [&](bool by_correlation, bool best) {
        std::vector<std::size_t> order(result.views.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
        auto worth = [&](std::size_t i) {
            const double w =
                by_correlation ? correlation_gain(result.views[i], result.best) : gain_of(result.views[i], result.best);
            return best ? -w : w;
        };
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return worth(a) < worth(b); });
        std::vector<IsrPictures> all;
        for (std::size_t i = 0; i < std::min(order.size(), by_correlation ? 1 : shown_cases); ++i)
            all.push_back(pictures_of(common, views.at(order[i]), result.views[order[i]], result.best));
        return all;
    };
    show_progress("pictures");
    gallery.best = cases(false, true), gallery.worst = cases(false, false);
    gallery.correlated = cases(true, true), gallery.uncorrelated = cases(true, false);
    // Of the view with the largest gain: there is most to see.
    const auto first = std::find_if(views.begin(), views.end(), [&](const BatchView& v) {
        return !gallery.best.empty() && v.name == gallery.best.front().name;
    });
    if (first == views.end()) return gallery;
    gallery.modes_name = first->name;
    const Scene& scene = common.scenes.scene(*first, common.request.size);
    const double exposure = result.views.at(std::size_t(first - views.begin())).exposure;
    for (const char* mode : {"F2", "F3", "F4", "F5"})
        gallery.modes.push_back(
            {mode,
             isr_display(
                 isr_frame(scene, isr_settings(scene, "isr", {std::string("isr.mode=") + mode, "isr.ambient=none"}),
                           common.options)
                     .radiance,
                 exposure, common.options)});
    return gallery;
}

std::string isr_html(const IsrResult& result, const std::vector<IsrNumber>& numbers, const IsrGallery& gallery,
                     const std::string& command) {
    return IsrPage(result, numbers, gallery).html(command);
}

}  // namespace plumb::cli
