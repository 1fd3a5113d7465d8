// Verdicts as files: JUnit XML for CI, and a page (tools/page).
#include <fmt/format.h>

#include <cmath>

#include "io/file.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"
#include "tools/plumb/diagnosis_report.h"
#include "tools/plumb/verdict_report.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::escaped;
using page::Page;
using parity::StageVerdict;
using parity::Verdict;
using parity::WorstPixel;

Cell verdict_cell(Verdict verdict) {
    constexpr const char* kinds[] = {"plain", "good", "doubt", "bad"};  // in the order of Verdict
    Cell cell{verdict == Verdict::within_bound ? "within bound" : parity::verdict_name(verdict)};
    cell.badge = kinds[int(verdict)];
    return cell;
}

Cell nothing_cell() { return {.text = "nothing to judge", .badge = "none"}; }

Cell verdict_cell(const StageReport& stage) {
    const StageVerdict& v = stage.verdict;
    const bool named = verdict_text(stage) == parity::verdict_name(v.verdict);
    if (named) return verdict_cell(v.verdict);
    return stage.decided() ? Cell{.text = verdict_text(stage), .badge = "bad"} : nothing_cell();
}

std::string badge(const Cell& cell) { return page::badge(cell.text, cell.badge); }

Cell number(const std::string& text) { return {text, true}; }

// Texts first, then numbers.
std::vector<Cell> head(const std::vector<std::string>& texts, const std::vector<std::string>& numbers) {
    std::vector<Cell> cells;
    for (const std::string& text : texts) cells.push_back({text});
    for (const std::string& text : numbers) cells.push_back(number(text));
    return cells;
}

// Infinity: nothing is known.
std::string bound_text(double bound) {
    return std::isfinite(bound) ? fmt::format("{:.4g}", bound) : std::isinf(bound) ? "anything" : "none";
}

void table_of_stages(Page& page, const ValidationReport& report) {
    std::vector<std::vector<Cell>> rows{
        head({"stage", "verdict"}, {"equal", "within bound", "ambiguous", "wrong", "pixels", "not 0", "ms"})};
    for (std::size_t i = 0; i < report.stages.size(); ++i) {
        const StageVerdict& v = report.stages[i].verdict;
        rows.push_back({{v.label, false, -1, "", fmt::format("#stage{}", i)}, verdict_cell(report.stages[i])});
        for (std::int64_t count : v.count) rows.back().push_back(number(share_text(count, v.pixels)));
        rows.back().push_back(number(fmt::format("{}", v.pixels)));
        rows.back().push_back(number(fmt::format("{}", v.nonzero)));
        rows.back().push_back(number(milliseconds_text(v.ms)));
    }
    page.table(rows);
}

void figure(Page& page, const Image<std::uint32_t>& image, const std::string& caption) {
    if (!image.empty()) page.figure(page.picture(image, caption));
}

void table_of_worst(Page& page, const StageVerdict& v) {
    std::vector<std::vector<Cell>> rows{
        head({"pixel", "verdict", "output"}, {"expected", "got", "difference", "allowed"})};
    for (const WorstPixel& w : v.worst)
        if (w.verdict != Verdict::equal)
            rows.push_back({{fmt::format("{}, {}", w.pixel.x, w.pixel.y)},
                            verdict_cell(w.verdict),
                            {component_text(w)},
                            number(exact_text(w.expected)),
                            number(exact_text(w.got)),
                            number(bound_text(std::abs(w.got - w.expected))),
                            number(bound_text(w.bound))});
    if (rows.size() == 1) return;
    page.raw("<h3>Worst pixels</h3>\n");
    page.table(rows);
}

void table_of_taps(Page& page, const StageReport& stage) {
    if (stage.explanation.empty() || stage.verdict.worst.empty()) return;
    const glm::ivec2 pixel = stage.verdict.worst.front().pixel;
    std::vector<std::vector<Cell>> rows{{number("sample"), {"name"}, {"value"}, {"equation"}}};
    for (const TapValue& tap : stage.explanation)
        rows.push_back({number(tap.sample >= 0 ? fmt::format("{}", tap.sample) : ""),
                        {tap.name},
                        {exact_text(tap.value)},
                        {tap.equation}});
    page.raw(fmt::format("<h3>How our kernel comes to its value at {}, {}</h3>\n<div class=\"values\">\n", pixel.x,
                         pixel.y));
    page.table(rows);
    page.raw("</div>\n");
}

std::string worst_lines(const StageVerdict& v) {
    std::string text;
    for (const WorstPixel& w : v.worst)
        if (w.verdict != Verdict::equal)
            text += fmt::format("pixel {},{}: {}: {}: expected {}, got {}, may differ by {}\n", w.pixel.x, w.pixel.y,
                                parity::verdict_name(w.verdict), component_text(w), exact_text(w.expected),
                                exact_text(w.got), bound_text(w.bound));
    return text;
}

// "2623 pixels: equal 100 %, ...; 1200 not 0: equal 100 %, ...".
std::string shares_line(const StageVerdict& v) {
    std::string text;
    for (const bool nonzero : {false, true}) {
        const std::int64_t pixels = nonzero ? v.nonzero : v.pixels;
        text += fmt::format("{}{} {}", nonzero ? "; " : "", pixels, nonzero ? "not 0" : "pixels");
        for (int i = 0; i < parity::verdicts && pixels > 0; ++i)
            text += fmt::format("{} {} {}", i == 0 ? ":" : ",", parity::verdict_name(Verdict(i)),
                                share_text((nonzero ? v.nonzero_count : v.count)[std::size_t(i)], pixels));
    }
    return text;
}

void section(Page& page, const StageReport& stage, std::size_t index) {
    const StageVerdict& v = stage.verdict;
    page.raw(fmt::format("<h2 id=\"stage{}\">{} {}</h2>\n", index, escaped(v.label), badge(verdict_cell(stage))));
    if (!stage.reason().empty()) page.paragraph(stage.reason());
    page.paragraph(shares_line(v));
    for (const std::string& note : stage.notes) page.raw(fmt::format("<p class=\"note\">{}</p>\n", escaped(note)));
    table_of_worst(page, v);
    diagnosis_part(page, stage.diagnosis);
    for (const DrawnPicture& p : stage.outputs) figure(page, p.texels, p.caption);
    figure(page, stage.map,
           fmt::format("The verdict of each pixel: grey equal, blue within bound, yellow ambiguous, orange wrong{}, black not "
                       "judged. White frames: the worst pixels.",
                       stage.diagnosis.clusters.empty() ? "" : " (other places purple, sky blue and green)"));
    figure(
        page, stage.error,
        "The largest |got - expected| of a pixel's components, of the largest value expected: black 0, then from 1e-8 "
        "of it to white, all of it, by the logarithm; NaN red.");
    for (const DrawnPicture& p : stage.samples)
        page.figure(page.picture(p.texels, fmt::format("The samples of the worst pixel, {}, {}. {}", v.worst.front().pixel.x,
                                                       v.worst.front().pixel.y, p.caption)),
                    p.overlay);
    table_of_taps(page, stage);
}

}  // namespace

std::string validation_junit(const ValidationReport& report) {
    std::size_t failures = 0, skipped = 0;
    double seconds = 0;
    std::string cases;
    const std::string suite = "plumb." + io::stem_of(report.manifest.file.string());
    for (const StageReport& s : report.stages) {
        const StageVerdict& v = s.verdict;
        seconds += v.ms * 1e-3;
        cases += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", escaped(suite),
                             escaped(v.label), v.ms * 1e-3);
        if (!s.decided()) {
            const bool any = report.judged();
            ++(any ? skipped : failures);
            cases += fmt::format(">\n    <{} message=\"{}\"/>\n", any ? "skipped" : "failure",
                                 escaped(any ? s.reason() : none_judged(report)));
        } else if (s.failed()) {
            ++failures;
            cases += fmt::format(">\n    <failure type=\"{}\" message=\"{}\">{}</failure>\n", escaped(verdict_text(s)),
                                 escaped(s.reason()), escaped(worst_lines(v)));
        } else {
            cases += ">\n";
        }
        cases += fmt::format("    <system-out>{}</system-out>\n  </testcase>\n", escaped(shares_line(v)));
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
        "errors=\"0\" skipped=\"{}\" time=\"{:.3f}\">\n{}</testsuite>\n</testsuites>\n",
        escaped(suite), report.stages.size(), failures, skipped, seconds, cases);
}

std::string validation_html(const ValidationReport& report) {
    Page page("plumb validate " + io::shown(report.manifest.file.filename().string()));
    const std::string device = report.manifest.device.empty() ? "a device" : report.manifest.device;
    page.raw(
        fmt::format("<p>{} {}, held against the profile {}. "
                    "At most {:g} % of a stage's pixels may be ambiguous.</p>\n",
                    badge(report.judged() ? verdict_cell(report.verdict()) : nothing_cell()), escaped(device),
                    escaped(profile_text(report)), 100 * report.max_ambiguous));
    if (!report.judged()) page.raw(fmt::format("<p><b>Failed: {}.</b></p>\n", escaped(none_judged(report))));
    if (const StageReport* failed = report.first_failed())
        page.raw(
            fmt::format("<p>The first stage that fails: <b>{}</b>. "
                        "Each stage was judged from its own dumped inputs.</p>\n",
                        escaped(failed->verdict.label)));
    table_of_stages(page, report);
    for (std::size_t i = 0; i < report.stages.size(); ++i) section(page, report.stages[i], i);
    return page.html();
}

}  // namespace plumb::cli
