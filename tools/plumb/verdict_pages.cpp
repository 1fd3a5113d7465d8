// Verdicts as files: JUnit XML for CI, and a page of HTML that needs nothing but itself.
#include <fmt/format.h>

#include <cmath>

#include "io/file.h"
#include "io/image_file.h"
#include "tools/plumb/markup.h"
#include "tools/plumb/table.h"
#include "tools/plumb/verdict_report.h"

namespace plumb::cli {

namespace {

using parity::StageVerdict;
using parity::Verdict;
using parity::WorstPixel;

constexpr const char* style = R"(<style>
:root { color-scheme: light dark; --line: #8884; --soft: #8881; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 78rem; padding: 0 1rem; }
h1 { font-size: 1.5rem; }
h2 { font-size: 1.15rem; margin-top: 2.5rem; border-top: 1px solid var(--line); padding-top: 1rem; }
table { border-collapse: collapse; }
th, td { padding: .2rem .7rem; text-align: left; border-bottom: 1px solid var(--line); }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.scroll { overflow-x: auto; } .taps { max-height: 32rem; overflow: auto; font: 13px/1.4 ui-monospace, monospace; }
.v { font-weight: 600; padding: .1rem .5rem; border-radius: .3rem; white-space: nowrap; }
.equal { background: #4d565c; color: #fff; } .within_bound { background: #0072b2; color: #fff; }
.ambiguous { background: #f0e442; color: #222; } .wrong { background: #d55e00; color: #fff; }
.none { background: #000; color: #fff; }
figure { display: inline-block; margin: 1rem 1rem 0 0; vertical-align: top; max-width: min(100%, 37rem); }
img { max-width: 100%; min-width: 16rem; image-rendering: pixelated; border: 1px solid var(--line); }
figcaption { font-size: .85rem; } .note { background: var(--soft); padding: .2rem .7rem; }
</style>
)";

std::string badge(Verdict verdict) {
    const std::string name = parity::verdict_name(verdict);
    return fmt::format("<span class=\"v {}\">{}</span>", name,
                       verdict == Verdict::within_bound ? "within bound" : name);
}

std::string badge(const StageVerdict& v) {
    return v.pixels > 0 ? badge(v.verdict) : fmt::format("<span class=\"v none\">{}</span>", verdict_text(v));
}

std::string cell(const std::string& text, bool number = false) {
    return fmt::format("<td{}>{}</td>", number ? " class=\"n\"" : "", escaped(text));
}

std::string bound_text(double bound) { return std::isfinite(bound) ? fmt::format("{:.4g}", bound) : "none"; }

std::string table_of_stages(const ValidationReport& report) {
    std::string html =
        "<div class=\"scroll\"><table><tr><th>stage</th><th>verdict</th><th class=\"n\">equal</th><th class=\"n\">"
        "within bound</th><th class=\"n\">ambiguous</th><th class=\"n\">wrong</th><th class=\"n\">pixels</th><th "
        "class=\"n\">ms</th></tr>\n";
    for (std::size_t i = 0; i < report.stages.size(); ++i) {
        const StageVerdict& v = report.stages[i].verdict;
        html += fmt::format("<tr><td><a href=\"#stage{}\">{}</a></td><td>{}</td>", i, escaped(v.label), badge(v));
        for (std::int64_t count : v.count) html += cell(share_text(count, v.pixels), true);
        html += cell(fmt::format("{}", v.pixels), true) + cell(milliseconds_text(v.ms), true) + "</tr>\n";
    }
    return html + "</table></div>\n";
}

std::string picture(const Image<std::uint32_t>& image, const std::string& name, const std::string& caption) {
    if (image.empty()) return "";
    return fmt::format(
        "<figure><img alt=\"{}\" width=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
        escaped(name), std::max(image.width, 256), base64(io::encode_png(name, image)), escaped(caption));
}

std::string table_of_worst(const StageVerdict& v) {
    std::string rows;
    for (const WorstPixel& w : v.worst) {
        if (w.verdict == Verdict::equal) continue;
        rows += fmt::format("<tr>{}<td>{}</td>{}{}{}{}{}</tr>\n", cell(fmt::format("{}, {}", w.pixel.x, w.pixel.y)),
                            badge(w.verdict), cell(component_text(w)), cell(exact_text(w.expected), true),
                            cell(exact_text(w.got), true), cell(bound_text(std::abs(w.got - w.expected)), true),
                            cell(bound_text(w.bound), true));
    }
    if (rows.empty()) return "";
    return "<h3>Worst pixels</h3><div class=\"scroll\"><table><tr><th>pixel</th><th>verdict</th><th>output</th><th "
           "class=\"n\">expected</th><th class=\"n\">got</th><th class=\"n\">difference</th><th "
           "class=\"n\">allowed</th></tr>\n" +
           rows + "</table></div>\n";
}

std::string table_of_taps(const StageReport& stage) {
    if (stage.explanation.empty() || stage.verdict.worst.empty()) return "";
    const glm::ivec2 pixel = stage.verdict.worst.front().pixel;
    std::string html = fmt::format(
        "<h3>How our kernel comes to its value at {}, {}</h3><div class=\"taps\"><table><tr><th class=\"n\">sample</th>"
        "<th>name</th><th>value</th><th>equation</th></tr>\n",
        pixel.x, pixel.y);
    for (const TapValue& tap : stage.explanation)
        html += fmt::format("<tr>{}{}{}{}</tr>\n", cell(tap.sample >= 0 ? fmt::format("{}", tap.sample) : "", true),
                            cell(tap.name), cell(exact_text(tap.value)), cell(tap.equation));
    return html + "</table></div>\n";
}

std::string section(const StageReport& stage, std::size_t index) {
    const StageVerdict& v = stage.verdict;
    std::string html = fmt::format("<h2 id=\"stage{}\">{} {}</h2>\n", index, escaped(v.label), badge(v));
    if (!v.reason.empty()) html += fmt::format("<p>{}</p>\n", escaped(v.reason));
    for (const std::string& note : stage.notes) html += fmt::format("<p class=\"note\">{}</p>\n", escaped(note));
    html += table_of_worst(v);
    html += picture(stage.map, v.id + ".verdict",
                    "The verdict of each pixel: grey equal, blue within bound, yellow ambiguous, orange wrong, black "
                    "not judged. White frames: the worst pixels.");
    html += picture(stage.error, v.id + ".error",
                    "The largest |got - expected| of a pixel's components, of the largest value expected: black 0, "
                    "then from 1e-8 of it to white, all of it, by the logarithm; NaN red.");
    return html + table_of_taps(stage);
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
        if (v.pixels == 0) {
            const bool any = report.judged();
            ++(any ? skipped : failures);
            cases += fmt::format(">\n    <{} message=\"{}\"/>\n  </testcase>\n", any ? "skipped" : "failure",
                                 any ? verdict_text(v) : none_judged);
            continue;
        }
        if (v.passed) {
            cases += "/>\n";
            continue;
        }
        ++failures;
        std::string text;
        for (const WorstPixel& w : v.worst)
            if (w.verdict != Verdict::equal)
                text += fmt::format("pixel {},{}: {}: {}: expected {}, got {}, may differ by {}\n", w.pixel.x,
                                    w.pixel.y, parity::verdict_name(w.verdict), component_text(w),
                                    exact_text(w.expected), exact_text(w.got), bound_text(w.bound));
        cases += fmt::format(">\n    <failure type=\"{}\" message=\"{}\">{}</failure>\n  </testcase>\n",
                             parity::verdict_name(v.verdict), escaped(v.reason), escaped(text));
    }
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
        "errors=\"0\" skipped=\"{}\" time=\"{:.3f}\">\n{}</testsuite>\n</testsuites>\n",
        escaped(suite), report.stages.size(), failures, skipped, seconds, cases);
}

std::string validation_html(const ValidationReport& report) {
    const std::string title = "plumb validate " + io::shown(report.manifest.file.filename().string());
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width\">\n<title>{}</title>\n{}</head><body>\n<h1>{} {}</h1>\n",
        escaped(title), style, escaped(title), badge(report.verdict()));
    const std::string device = report.manifest.device.empty() ? "a device" : report.manifest.device;
    html += fmt::format("<p>{}, held against the profile {}. "
                        "At most {:g} % of a stage's pixels may be ambiguous.</p>\n",
                        escaped(device), escaped(profile_text(report)), 100 * report.max_ambiguous);
    if (!report.judged()) html += fmt::format("<p><b>Failed: {}.</b></p>\n", none_judged);
    if (const StageReport* failed = report.first_failed())
        html += fmt::format("<p>The first stage that fails: <b>{}</b>. "
                            "Each stage was judged from its own dumped inputs.</p>\n",
                            escaped(failed->verdict.label));
    html += table_of_stages(report);
    for (std::size_t i = 0; i < report.stages.size(); ++i) html += section(report.stages[i], i);
    return html + "</body></html>\n";
}

}  // namespace plumb::cli
