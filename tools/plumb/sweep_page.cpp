#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/page/markup.h"
#include "tools/page/page.h"
#include "tools/plumb/sweep_page.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Chart;
using page::ChartLine;
using page::ChartPoint;
using page::Line;
using page::Page;

// What an error is held against: the two charts of a scene.
enum class Against { full, own };

const SweepError& error_of(const SweepPoint& p, Against against) { return against == Against::full ? p.full : p.own; }

// Numbers of pictures on the page.
struct PointFiles {
    std::vector<int> full, own;
};

std::string number_text(double v) { return std::isfinite(v) ? fmt::format("{:.4g}", v) : "undefined"; }

// Three digits: on a logarithmic axis a stage of 0.04 ms has its place.
std::string ms_text(double ms) { return ms < 100 ? fmt::format("{:.3g}", ms) : fmt::format("{:.0f}", ms); }

std::string error_text(const SweepError& e) {
    return number_text(e.rmse) + (e.below_noise ? ", within the noise" : "");
}

std::string point_link(std::size_t point) { return fmt::format("point={}", point); }

// A browser still scrolls through a page of this many pixels, some 40 MB.
constexpr double most_pixels = 24e6;

// Pixels of a picture that one of the page's stands for, along a side: as few as the page can hold.
int reduction(const Sweep& sweep) {
    double pixels = 0;
    for (const SweepPoint& p : sweep.points)
        for (const SweptScene& s : sweep.scenes)
            if (p.scene == s.name) pixels += 3.0 * s.width * s.height;
    int side = 1;
    while (pixels > most_pixels * side * side) ++side;
    return side;
}

// Means of side x side pixels; what is left over on the right and at the bottom is left out.
Image<std::uint32_t> image(const Rgb8& rgb, const SweptScene& scene, int side) {
    if (rgb.size() != std::size_t(scene.width) * std::size_t(scene.height) * 3)
        throw std::logic_error("sweep_page: a picture of another size");
    side = std::min({side, scene.width, scene.height});
    Image<std::uint32_t> rgba(scene.width / side, scene.height / side, 0xff000000u);
    for (int y = 0; y < rgba.height; ++y)
        for (int x = 0; x < rgba.width; ++x)
            for (int c = 0; c < 3; ++c) {
                int sum = side * side / 2;
                for (int i = 0; i < side * side; ++i)
                    sum += rgb[3 * (std::size_t(y * side + i / side) * scene.width + x * side + i % side) + c];
                rgba(x, y) |= std::uint32_t(sum / (side * side)) << (8 * c);
            }
    return rgba;
}

std::string difference_caption(const std::string& from) {
    return fmt::format(
        "Picture minus {0}: middle grey is equal, brighter too bright, darker too dark; black and white at "
        "-{1:g} and +{1:g} of the display's range",
        from, difference_swing);
}

std::vector<PointFiles> add_pictures(Page& page, const Sweep& sweep, const SweepPictures& pictures) {
    const int side = reduction(sweep);
    std::vector<PointFiles> files(sweep.points.size());
    for (std::size_t s = 0; s < sweep.scenes.size(); ++s) {
        const SweptScene& scene = sweep.scenes[s];
        const ScenePictures& truths = pictures.scenes.at(s);
        const int truth =
            page.picture(image(truths.truth, scene, side), "Truth: full global illumination, path traced");
        std::map<frame::Method, int> own;
        for (const auto& [method, picture] : truths.own)
            own[method] =
                page.picture(image(picture, scene, side),
                             fmt::format("Truth of {}'s own transport, path traced", frame::method_name(method)));
        for (std::size_t i = 0; i < sweep.points.size(); ++i) {
            const SweepPoint& p = sweep.points[i];
            if (p.scene != scene.name) continue;
            const PointPictures& of = pictures.points.at(i);
            const int color =
                page.picture(image(of.color, scene, side), p.method + (p.settings.empty() ? "" : ", ") + p.settings);
            files[i].full = {color, page.picture(image(of.against_full, scene, side), difference_caption("truth")),
                             truth};
            files[i].own = {color, page.picture(image(of.against_own, scene, side), difference_caption("own truth")),
                            own.at(p.base)};
        }
    }
    return files;
}

std::vector<std::pair<std::string, std::string>> values_of(const SweepPoint& p) {
    std::vector<std::pair<std::string, std::string>> values;
    if (!p.settings.empty()) values.push_back({"settings", p.settings});
    values.push_back({"frame", fmt::format("{} ms (quartiles {} to {})", ms_text(p.median_ms),
                                           ms_text(p.low_ms), ms_text(p.high_ms))});
    values.push_back({"its stages", ms_text(p.stage_ms) + " ms"});
    values.push_back({"memory", megabytes_text(p.peak_bytes) + " MB"});
    values.push_back({"RMSE against full", error_text(p.full)});
    values.push_back({"RMSE against own", error_text(p.own)});
    return values;
}

// The points of a scene by curve, in the sweep's order.
std::vector<ChartLine> curves(const Sweep& sweep, const std::string& scene, const std::vector<PointFiles>& files,
                              Against against) {
    std::vector<ChartLine> lines;
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
        const SweepPoint& p = sweep.points[i];
        if (p.scene != scene) continue;
        auto line = std::find_if(lines.begin(), lines.end(), [&](const ChartLine& l) { return l.name == p.method; });
        if (line == lines.end()) line = lines.insert(lines.end(), ChartLine{p.method, {}, Line::joined});
        ChartPoint point{against == Against::full ? p.median_ms : p.stage_ms,
                         error_of(p, against).rmse,
                         values_of(p),
                         {},
                         point_link(i)};
        if (!files.empty()) point.pictures = against == Against::full ? files[i].full : files[i].own;
        line->points.push_back(std::move(point));
    }
    return lines;
}

ChartLine front(const Sweep& sweep, const std::string& scene) {
    ChartLine line{"Pareto front (dashed)", {}, Line::dashed};
    for (const SweepPoint& p : sweep.points)
        if (p.scene == scene && p.pareto) line.points.push_back({p.median_ms, p.full.rmse, {}, {}});
    std::sort(line.points.begin(), line.points.end(),
              [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
    return line;
}

// Below it no point can be told from the truth. Methods of their own truths have their own noise, a line each.
std::vector<ChartLine> noise(const Sweep& sweep, const std::string& scene, Against against) {
    std::vector<ChartLine> lines;
    std::vector<frame::Method> done;
    for (const SweepPoint& p : sweep.points) {
        const double height = error_of(p, against).truth_error;
        if (p.scene != scene || !std::isfinite(height) || height <= 0) continue;
        if (std::find(done.begin(), done.end(), p.base) != done.end()) continue;
        if (against == Against::full && !lines.empty()) break;
        done.push_back(p.base);
        const std::string whose = against == Against::own ? fmt::format("{}'s own truth", frame::method_name(p.base))
                                                          : "the truth";
        lines.push_back({fmt::format("standard error of {}, {} (dotted)", whose, number_text(height)),
                         {{1, height, {}, {}}},
                         Line::level});
    }
    return lines;
}

void add_line(Chart& chart, ChartLine line) {
    if (!line.points.empty()) chart.lines.push_back(std::move(line));
}

void add_charts(Page& page, const Sweep& sweep, const SweptScene& scene, const std::vector<PointFiles>& files) {
    Chart full{"Error against full global illumination, over the time of a frame", "median frame time (ms)",
               "RMSE, W/(m² sr)"};
    full.lines = curves(sweep, scene.name, files, Against::full);
    add_line(full, front(sweep, scene.name));
    for (ChartLine& line : noise(sweep, scene.name, Against::full)) add_line(full, std::move(line));
    page.chart(full);
    Chart own{"Error against the transport that a method means to compute, over the time of its own stages",
              "median time of the method's stages (ms)", "RMSE, W/(m² sr)"};
    own.lines = curves(sweep, scene.name, files, Against::own);
    for (ChartLine& line : noise(sweep, scene.name, Against::own)) add_line(own, std::move(line));
    page.chart(own);
}

Cell number_cell(const std::string& text, double order, const std::string& hint = "") {
    return {text, true, -1, hint, "", order};
}

Cell error_cell(const SweepError& e) {
    if (!e.below_noise) return number_cell(number_text(e.rmse), e.rmse);
    return number_cell(number_text(e.rmse) + " ≤ σ", e.rmse,
                       fmt::format("within the noise: the standard error of the truth and of the picture is {}",
                                   number_text(e.standard_error)));
}

void add_table(Page& page, const Sweep& sweep, const SweptScene& scene) {
    std::vector<std::vector<Cell>> rows{
        {{"curve"},
         {"settings"},
         {"frame, ms", true, -1, "median of the runs"},
         {"quartiles", true},
         {"its stages, ms", true, -1, "median of the sum of the stages that are named after the method"},
         {"memory, MB", true},
         {"RMSE, full", true, -1, "against full global illumination, W/(m² sr)"},
         {"rel. MSE, full", true, -1, "relative mean squared error against full global illumination"},
         {"RMSE, own", true, -1, "against the transport that the method means to compute, W/(m² sr)"},
         {"front", false, -1, "no other point is both faster and nearer to full global illumination"}}};
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
        const SweepPoint& p = sweep.points[i];
        if (p.scene != scene.name) continue;
        rows.push_back({{p.method, false, -1, "", "#" + point_link(i)},
                        {p.settings},
                        number_cell(ms_text(p.median_ms), p.median_ms),
                        number_cell(ms_text(p.low_ms) + " – " + ms_text(p.high_ms), p.low_ms),
                        number_cell(ms_text(p.stage_ms), p.stage_ms),
                        number_cell(megabytes_text(p.peak_bytes), double(p.peak_bytes)),
                        error_cell(p.full),
                        number_cell(number_text(p.full.rel_mse), p.full.rel_mse),
                        error_cell(p.own),
                        {p.pareto ? "●" : ""}});
    }
    page.table(rows, "All points. A click on a head sorts; a click on a curve's name shows the point in the chart.");
}

void add_scene(Page& page, const Sweep& sweep, std::size_t index, const std::vector<PointFiles>& files) {
    const SweptScene& scene = sweep.scenes[index];
    page.heading(scene.name, fmt::format("scene{}", index));
    page.paragraph(fmt::format("{} x {} pixels. The truth: {} samples a pixel, standard error {:.3g} % of the mean.",
                               scene.width, scene.height, scene.samples, 100 * scene.relative_error));
    add_charts(page, sweep, scene, files);
    add_table(page, sweep, scene);
}

void add_left_out(Page& page, const Sweep& sweep) {
    if (sweep.left_out.empty()) return;
    page.heading("Not measured");
    std::vector<std::vector<Cell>> rows{{{"scene"}, {"curve"}, {"settings"}, {"why"}}};
    for (const LeftOut& l : sweep.left_out) rows.push_back({{l.scene}, {l.method}, {l.settings}, {l.reason}});
    page.table(rows);
}

void add_how(Page& page, const Sweep& sweep, const std::string& command) {
    page.heading("How it was measured", "how");
    page.raw(fmt::format("<p><code>{}</code></p>\n", page::escaped(command)));
    page.paragraph(
        fmt::format("On {}, instruction set {}, {} thread{}. Every point ran once to warm up and then {} time{}, "
                    "all points of all scenes in turns, so that what slows the machine slows all of them. Times "
                    "are medians; quartiles show their spread.",
                    sweep.processor, sweep.isa, sweep.threads, sweep.threads == 1 ? "" : "s", sweep.runs,
                    sweep.runs == 1 ? "" : "s"));
    page.paragraph(
        "Errors are of outgoing radiance before the tone curve, held against path traced truths: full global "
        "illumination, and the part of it that the method means to compute. Within the standard error (σ) of truth "
        "and picture an error cannot be told from noise.");
    page.paragraph(sweep.memory == "resident" ? "Memory is the growth of the program's resident memory over the point."
                                              : "Memory is the sum of what the stages made.");
    for (const std::string& note : sweep.notes) page.paragraph(note);
}

}  // namespace

std::string sweep_html(const Sweep& sweep, const SweepPictures* pictures, const std::string& command) {
    Page page("plumb sweep: error against run time");
    std::string scenes;
    for (std::size_t s = 0; s < sweep.scenes.size(); ++s)
        scenes +=
            fmt::format("{}<a href=\"#scene{}\">{}</a>", s == 0 ? "" : ", ", s, page::escaped(sweep.scenes[s].name));
    page.raw(
        fmt::format("<p>{} points on {}. <a href=\"#how\">How it was measured</a>. The mouse over a point shows its "
                    "values, a click its pictures; a click in the legend hides a curve. Lower and further left is "
                    "better.</p>\n",
                    sweep.points.size(), scenes));
    std::vector<PointFiles> files;
    if (pictures) files = add_pictures(page, sweep, *pictures);
    if (const int side = reduction(sweep); pictures && side > 1)
        page.paragraph(
            fmt::format("A pixel of the pictures is the mean of {0} x {0}, so that a browser can hold them all; "
                        "errors are of all pixels.",
                        side));
    for (std::size_t s = 0; s < sweep.scenes.size(); ++s) add_scene(page, sweep, s, files);
    add_left_out(page, sweep);
    add_how(page, sweep, command);
    return page.html();
}

}  // namespace plumb::cli
