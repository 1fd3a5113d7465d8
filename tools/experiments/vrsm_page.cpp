// plumb experiment vrsm as one page of HTML: the thesis' tables and figures, ours beside its numbers.
#include <fmt/format.h>

#include <algorithm>

#include "tools/experiments/vrsm.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Page;

constexpr int picture_width = 512, crop_width = 256;  // on the page, px

class VrsmPage {
  public:
    VrsmPage(const Vrsm& result, const std::vector<VrsmNumber>& numbers)
        : result_(result), numbers_(numbers), page_("VRSM's evaluation, repeated: plumb experiment vrsm") {}

    std::string html(const std::string& command) {
        introduce();
        add_pattern_figure(page_, result_);
        if (result_.request.times) add_times(), add_passes();
        add_beyond(page_, result_, numbers_);
        for (std::size_t i = 0; i < result_.scenes.size(); ++i) add_scene(i);
        add_differences();
        tell_how(command);
        return page_.html();
    }

  private:
    const VrsmNumber& find(const std::string& table, const std::string& scene, const std::string& row,
                           const std::string& quantity) const {
        return find_number(numbers_, table, scene, row, quantity);
    }

    // The number as it is in CSV and JSON is what its column is sorted by.
    static Cell ours(const VrsmNumber& n, double heat = -1) {
        return {value_text(n.value, n.unit), true, heat,
                n.row + ": " + n.quantity,   "",   n.value ? *n.value : std::numeric_limits<double>::quiet_NaN()};
    }
    static Cell theirs(const VrsmNumber& n) {
        return {n.thesis ? fmt::format("{:g}", *n.thesis) : "", true, -1, "as printed"};
    }
    static Cell head(const std::string& text, const std::string& hint = "") { return {text, true, -1, hint}; }

    // Scenes and rows of a table, in order.
    std::vector<std::pair<std::string, std::string>> rows_of(const std::string& table) const {
        std::vector<std::pair<std::string, std::string>> rows;
        for (const VrsmNumber& n : numbers_)
            if (n.table == table && (rows.empty() || rows.back() != std::pair(n.scene, n.row)))
                rows.push_back({n.scene, n.row});
        return rows;
    }

    void introduce() {
        const VrsmScene& s = result_.scenes.front();
        page_.paragraph(
            fmt::format("After Bang 2011, chapter 5, who rendered Crytek's Sponza of 262 thousand triangles (252 "
                        "thousand in its 5.3) on a GeForce GTX 260 at 512 x 512 pixels with maps as large, indirect "
                        "light at 256 x 256 points from 15 paths of 10 samples with 5 slots of the micro linear "
                        "buffer, RGBA16F targets, upsampling and an edge-aware blur of 17. Here: {0} with {1} "
                        "triangles, {2} x {2} pixels and texels, indirect light at {3} x {3} points; all else as the "
                        "thesis, but for what the command below sets. Every error is the mean of {4} seed{5} of the "
                        "patterns and of the pixels' rotations, ± its standard error. Where two differ by less than two "
                        "standard errors of their difference they are not told apart (○), and none is marked as the "
                        "least (●).",
                        s.name, s.triangles, s.size.x, (s.size.x + 1) / 2, result_.request.seeds,
                        result_.request.seeds == 1 ? "" : "s"));
        std::string links;
        for (std::size_t i = 0; i < result_.scenes.size(); ++i)
            links += fmt::format("<a href=\"#scene{}\">{}</a>, ", i, page::escaped(result_.scenes[i].name));
        page_.raw("<p>Figures and errors: " + links + "<a href=\"#differences\">differences</a>. " +
                  "<a href=\"#pattern\">The pattern</a>. " +
                  (result_.request.beyond ? "<a href=\"#beyond\">Beyond the thesis</a>. " : "") +
                  "<a href=\"#how\">How it was measured</a>.</p>\n");
    }

    void add_pairs(const std::string& table, const std::string& caption) {
        std::vector<std::vector<Cell>> rows{{{"scene"},
                                             {"indirect light"},
                                             head("without, ms", "ours, median"),
                                             head("VRSM"),
                                             head("with, ms", "ours, median"),
                                             head("VRSM"),
                                             head("overhead, %", "of the medians"),
                                             head("VRSM"),
                                             head("by pairs, %", "median of the overheads of each repetition"),
                                             head("lower quartile"),
                                             head("upper quartile"),
                                             head("fastest without, ms"),
                                             head("fastest with, ms"),
                                             head("overhead, %", "of the fastest"),
                                             head("RSM sampling without, ms"),
                                             head("with, ms"),
                                             head("overhead, %")}};
        const bool resolutions = table == "5.2";
        if (resolutions)
            for (const char* which : {"without", "with"})
                rows[0].push_back(head(fmt::format("over half, {}", which))), rows[0].push_back(head("VRSM"));
        for (const auto& [scene, row] : rows_of(table)) {
            auto n = [&, s = scene, r = row](const char* quantity) { return find(table, s, r, quantity); };
            rows.push_back({{scene},
                            {row},
                            ours(n("without")),
                            theirs(n("without")),
                            ours(n("with")),
                            theirs(n("with")),
                            ours(n("overhead")),
                            theirs(n("overhead")),
                            ours(n("overhead by pairs")),
                            ours(n("overhead by pairs, lower quartile")),
                            ours(n("overhead by pairs, upper quartile")),
                            ours(n("fastest without")),
                            ours(n("fastest with")),
                            ours(n("overhead of the fastest")),
                            ours(n("sampling without")),
                            ours(n("sampling with")),
                            ours(n("sampling overhead"))});
            if (resolutions)
                for (const char* over : {"over half, without", "over half, with"})
                    rows.back().push_back(ours(n(over))), rows.back().push_back(theirs(n(over)));
        }
        page_.table(rows, caption);
    }

    void add_times() {
        page_.heading("Table 5.1: frames without and with visibility", "table51");
        add_pairs("5.1", "Time of a frame. VRSM's columns are a GPU's of 2009.");
        page_.heading("Table 5.2: by resolution of the indirect light", "table52");
        add_pairs("5.2",
                  "half: a quarter of the points. VRSM's text states 13 % for half resolution, its table 5.1 14 % "
                  "for the same two times. over half: the time over that of half resolution; VRSM 4.4 has \"nearly three "
                  "times\" of it and of deferred shading together.");
    }

    void add_passes() {
        page_.heading("Table 5.3: by pass", "table53");
        std::vector<std::vector<Cell>> rows{{{"pass"}, head("time, ms"), head("VRSM"), head("share, %"), head("VRSM")}};
        for (const auto& [scene, row] : rows_of("5.3")) {
            const VrsmNumber &time = find("5.3", scene, row, "time"), &share = find("5.3", scene, row, "share");
            rows.push_back({{row}, ours(time), theirs(time), ours(share), theirs(share)});
        }
        page_.table(rows, result_.scenes.front().name +
                              ", half resolution, with visibility; medians, and their sum. Shadow densities are of "
                              "the G-buffer's pass, direct light, upsampling, blur, synthesis and tone curve of "
                              "post processing.");
    }

    const std::vector<std::pair<std::string, std::string>> quantities_ = {
        {"mean error, %", "of the truth's mean"},
        {"rms, %", "of the truth's mean, without the truth's noise"},
        {"too dark, % of points", "darker by more than 10 % of the local truth and 3 standard errors"},
        {"too bright, % of points", "brighter by more than 10 % of the local truth and 3 standard errors"},
        {"removed, % of energy", "wrongly, less 3 standard errors at each point"},
        {"leaked, % of energy", "less 3 standard errors at each point"},
        {"leak stopped, %", "of the energy that leaks without visibility"}};

    // The whole picture, with the enlarged regions framed where there are any.
    void show(const Image4& image, const std::string& caption, const std::vector<glm::ivec4>& framed = {}) {
        std::string marks;
        for (const glm::ivec4& c : framed)
            for (const char* kind : {"under", "line"})
                marks += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>", kind, c.x,
                                     c.y, c.z, c.w);
        page_.figure(
            page_.picture(image, caption),
            {glm::dvec2(image.width, image.height), glm::dvec4(0, 0, image.width, image.height), picture_width, marks});
    }
    void enlarge(const Image4& image, const glm::ivec4& c, const std::string& caption) {
        page_.figure(page_.picture(image, caption),
                     {glm::dvec2(image.width, image.height), glm::dvec4(c.x, c.y, c.z, c.w), crop_width, ""});
    }

    void add_errors(const VrsmScene& scene, const std::string& table, const std::vector<VrsmErrors>& all,
                    const std::string& caption) {
        std::vector<std::vector<Cell>> rows{{{"what, visibility"}}};
        for (const auto& [name, hint] : quantities_) {
            rows[0].push_back(head(name, hint));
            rows[0].push_back(head("±", "standard error of the mean over the seeds"));
        }
        rows[0].push_back(head("truth's noise, %", "root mean square of its standard errors"));
        rows[0].push_back(head("no number, points", "of all seeds"));
        rows[0].push_back({"least rms"});
        double least = 1e300, most = 0;
        for (const VrsmErrors& e : all)
            if (const std::optional<double> rms = e.rms().mean) least = std::min(least, *rms), most = std::max(most, *rms);
        for (const VrsmErrors& e : all) {
            const std::string row = vrsm_row(e);
            auto n = [&](const std::string& quantity) { return find(table, scene.name, row, quantity); };
            const std::optional<double> rms = e.rms().mean;
            const double heat = !rms           ? std::numeric_limits<double>::quiet_NaN()
                                : most > least ? (*rms - least) / (most - least)
                                               : -1;
            rows.push_back({{row}});
            for (const auto& [name, hint] : quantities_) {
                const std::string quantity = name.substr(0, name.find(", "));
                rows.back().push_back(ours(n(quantity), quantity == "rms" ? heat : -1));
                rows.back().push_back(ours(n(quantity + ", standard error")));
            }
            rows.back().push_back(ours(n("noise")));
            rows.back().push_back(ours(n("no number")));
            rows.back().push_back({e.best ? "●" : e.tied ? "○" : ""});
        }
        page_.table(rows, caption);
    }

    const VrsmErrors* best_of(const VrsmScene& scene) const {
        const VrsmErrors* best = nullptr;
        for (const VrsmErrors& e : scene.errors)
            if (e.chain && e.rms().mean && (!best || *e.rms().mean < *best->rms().mean)) best = &e;
        return best;
    }

    void add_scene(std::size_t index) {
        const VrsmScene& s = result_.scenes[index];
        const VrsmPictures& p = s.pictures;
        page_.heading(s.name + (s.test_case.empty() ? "" : ", in place of test case " + s.test_case),
                      fmt::format("scene{}", index));
        page_.raw("<h3>Figure 5.1: indirect irradiance</h3>\n");
        page_.paragraph(fmt::format("White is {:.4g} W/m² in all of them. The truth: {}.", p.white, s.truth));
        show(p.indirect_without, "(a) Without visibility");
        show(p.indirect_with, "(b) With visibility by Algorithm 6, 5 slots");
        show(p.difference, fmt::format("(c) Difference of luminance of (a) and (b), times {:g}", vrsm_difference_gain));
        show(p.truth, "(d) Truth: texels of the map with a shadow ray each");
        page_.raw("<h3>Signed errors against (d)</h3>\n");
        page_.paragraph(
            fmt::format("Blue is too dark, red too bright, white neither; full colour at {:g} % of the local truth "
                        "(plus {:g} % of its mean), beyond 3 standard errors of the truth. Green would be no number; "
                        "grey is no surface.",
                        100 * vrsm_error_swing, 100 * vrsm_error_floor));
        show(p.error_without, "(a) against (d): red is light that leaks");
        show(p.error_with, "(b) against (d): blue is what visibility should not have darkened");
        if (const VrsmErrors* best = best_of(s))
            show(p.error_best, "The least rms, " + vrsm_row(*best) + ", against (d)");
        add_errors(s, "errors", s.errors,
                   "Luminance of the indirect irradiance against the truth. gather: at full resolution, without blur. "
                   "frame: at half resolution, upsampled and blurred. S: slots of the micro linear buffer; VRSM has 5. ●: "
                   "the least rms of its kind. ○: not told apart from it.");
        add_errors(s, "spacing", s.spacing,
                   fmt::format("By spacing of the steps along a path: of one length, growing with the root of the distance, or "
                               "with the distance (growth {:g}). ●, ○: of the same kind and visibility.", vrsm_growth));
        add_noise_figure(page_, s);
        add_buffer_figure(page_, s);
        page_.raw(fmt::format("<h3>Figure {}: global illumination and indirect light</h3>\n",
                              s.test_case.empty() ? "as 5.2" : fmt::format("5.{}", s.test_case[0] - 'A' + 2)));
        show(p.global_without, "(a) Global illumination without indirect shadows", p.crops);
        show(p.global_with, "(b) Global illumination with them", p.crops);
        show(p.indirect_without, "(c) Indirect light alone, without", p.crops);
        show(p.indirect_with, "(d) Indirect light alone, with", p.crops);
        if (p.crops.empty()) page_.paragraph("No regions are enlarged: visibility changes nothing.");
        for (std::size_t i = 0; i < p.crops.size(); ++i) {
            page_.raw(fmt::format("<h4>({}) Enlarged where they differ most</h4>\n", char('e' + i)));
            enlarge(p.indirect_without, p.crops[i], "Without");
            enlarge(p.indirect_with, p.crops[i], "With");
            enlarge(p.truth, p.crops[i], "Truth");
            enlarge(p.error_with, p.crops[i], "With, against the truth");
        }
    }

    void add_differences() {
        page_.heading("Figure 5.5: amplified differences", "differences");
        for (const VrsmScene& s : result_.scenes)
            show(s.pictures.difference, fmt::format("{}: luminance without less that with visibility, times {:g}",
                                                    s.name, vrsm_difference_gain));
    }

    void tell_how(const std::string& command) {
        page_.heading("How it was measured", "how");
        page_.raw(fmt::format("<p><code>{}</code></p>\n", page::escaped(command)));
        const std::string times =
            result_.request.times
                ? fmt::format("Times are medians of {} repetition{} of all settings of a scene in turns, sums of all stages of a "
                              "frame in which everything is drawn anew; loading the scene is not counted.",
                              result_.request.repeats, result_.request.repeats == 1 ? "" : "s")
                : "No times were measured: errors do not depend on the load.";
        page_.paragraph(fmt::format(
            "On {}, instruction set {}, {} thread{}; load of the machine {:.1f} before and {:.1f} after (its "
            "processes that ran or wanted to, mean of a minute). {}",
            result_.processor, result_.isa, result_.threads, result_.threads == 1 ? "" : "s", result_.load_before,
            result_.load_after, times));
        page_.paragraph(
            "Errors are of the luminance of indirect irradiance at every pixel with a surface, against the sum over "
            "the same map's texels with a shadow ray each: what the map's own resolution and one bounce leave out "
            "is no error here. Where the truth asks a subset, its standard error (of luminance: an upper bound, as "
            "if the channels erred together) is taken off.");
        for (const VrsmScene& s : result_.scenes)
            page_.paragraph(fmt::format("{}: {} triangles; truth in {:.3g} s.", s.name, s.triangles, s.truth_seconds));
    }

    const Vrsm& result_;
    const std::vector<VrsmNumber>& numbers_;
    Page page_;
};

}  // namespace

std::string vrsm_html(const Vrsm& result, const std::vector<VrsmNumber>& numbers, const std::string& command) {
    return VrsmPage(result, numbers).html(command);
}

}  // namespace plumb::cli
