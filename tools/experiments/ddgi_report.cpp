// plumb experiment ddgi: its tables as text and as JSON, its pictures and its page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gi/compose/compose.h"
#include "tools/experiments/ddgi.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"
#include "tools/shared/sweep.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Chart;
using page::ChartLine;
using page::ChartPoint;
using page::Page;

double number(const std::optional<double>& x) { return x ? *x : std::numeric_limits<double>::quiet_NaN(); }
std::string percent(const std::optional<double>& x, const char* sign = "") {
    return x ? fmt::format(fmt::runtime(std::string("{:") + sign + ".2f}"), 100 * *x) : "-";
}

std::vector<std::string> cells_of(const DdgiRow& r) {
    return {r.variant ? "  " + r.setting : r.method + " " + r.setting,
            fmt::format("{}", r.probes), fmt::format("{}", r.rays), percent(r.errors.rms), percent(r.errors.mean_error, "+"),
            percent(r.errors.leaked), percent(r.leaking), percent(r.black), fmt::format("{}", r.places()),
            fmt::format("{:.2f}", double(r.traced) / 1e6), r.baked > 0 ? fmt::format("{:.1f}", double(r.baked) / 1e6) : "-",
            fmt::format("{:.2f}", double(r.bytes) / 1e6), fmt::format("{}", r.rounds), fmt::format("{:.2f}", r.seconds),
            r.baked > 0 ? fmt::format("{:.2f}", r.bake_seconds) : "-"};
}
const std::vector<std::string>& heads() {
    static const std::vector<std::string> all = {"method",     "probes",   "rays of each", "rms %", "bias %",  "leaked %", "leaking %", "black %",
                                                 "places",     "M rays",   "M rays baked", "MB",    "rounds",  "s",        "s of the bake"};
    return all;
}

std::string introduction(const DdgiResult& r) {
    const std::string left_out = r.left_out > 0 ? fmt::format(" ({} more are left out: open to the sky)", r.left_out) : "";
    return fmt::format("{}: {} receivers{} on a lightmap of {} texels a side; truth: {} paths each, mean {:.4g} W/m2, noise {:.2f} %, "
                       "{:.2f} % of the receivers dark (below {:g} % of the mean)",
                       r.scene, r.receivers, left_out, r.lightmap, r.truth_samples, r.truth_mean, 100 * r.truth_noise, 100 * r.dark_receivers,
                       100 * ddgi_dark);
}

}  // namespace

std::string ddgi_text(const DdgiResult& result) {
    std::vector<Column> columns;
    for (const std::string& head : heads()) columns.push_back({head, columns.empty() ? Align::left : Align::right});
    std::vector<std::vector<std::string>> table, variants;
    for (const DdgiRow& r : result.rows) (r.variant ? variants : table).push_back(cells_of(r));
    std::string text = introduction(result) + "\n\n" + format_table(columns, table);
    if (!variants.empty()) {
        const auto first = std::find_if(result.rows.begin(), result.rows.end(), [](const DdgiRow& r) { return r.variant; });
        text += fmt::format("\nDDGI with {} probes and {} rays, but\n\n", first->probes, first->rays) + format_table(columns, variants);
    }
    return text + fmt::format("\nrms, bias, leaked: of the truth's mean, the truth's noise taken off the rms; leaking: receivers that are dark in "
                              "truth and above {:g} %;\nblack: the other way; places: surfaces whose radiance an update of the light asks "
                              "for; M rays: until light has settled, those to lamps included\n",
                              100 * ddgi_bright);
}

Json ddgi_json(const DdgiResult& result) {
    const auto value = [](const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); };
    Json rows = Json::array();
    for (const DdgiRow& r : result.rows)
        rows.push_back({{"method", r.method}, {"setting", r.setting}, {"variant", r.variant}, {"probes", r.probes}, {"rays", r.rays},
                        {"rms", value(r.errors.rms)}, {"bias", value(r.errors.mean_error)}, {"leaked", value(r.errors.leaked)},
                        {"leaking", r.leaking}, {"black", r.black}, {"places", r.places()}, {"rays_traced", r.traced},
                        {"rays_baked", r.baked}, {"bytes", r.bytes}, {"rounds", r.rounds}, {"seconds", r.seconds},
                        {"seconds_of_bake", r.bake_seconds}});
    return {{"version", 1}, {"scene", result.scene}, {"receivers", result.receivers}, {"left_out", result.left_out}, {"lightmap", result.lightmap},
            {"truth", {{"samples", result.truth_samples}, {"rays", result.truth_rays}, {"mean", result.truth_mean},
                       {"noise", result.truth_noise}, {"dark", result.dark_receivers}}},
            {"rows", rows}};
}

DdgiPictures ddgi_pictures(const DdgiResult& result, const RunOptions& options) {
    const compare::Plane truth = compare::luminances(result.truth);
    std::vector<double> seen;
    for (std::size_t i = 0; i < truth.size(); ++i)
        if (result.receiver_texels.texels[i]) seen.push_back(truth.texels[i]);
    const double white = std::max(quantile(std::move(seen), 0.98), 1e-30);
    const auto shown = [&](const Image4& irradiance) {
        Image4 display;
        compose::run(compose::TonemapParams{compose::Operator::clamp, float(1 / white)}, compose::TonemapInputs{&irradiance}, options, display);
        return display;
    };
    DdgiPictures p;
    p.truth = shown(result.truth);
    for (const DdgiRow& r : result.rows) {
        p.shown.push_back(shown(r.lightmap));
        const compare::Plane errors = compare::relative_errors(compare::luminances(r.lightmap), truth, 0.1 * result.truth_mean);
        Image4 error(truth.width, truth.height, glm::vec4(0.25f));
        for (std::size_t i = 0; i < errors.size(); ++i)
            if (result.receiver_texels.texels[i]) error.texels[i] = glm::vec4(compare::signed_color(errors.texels[i], 1), 1);
        p.error.push_back(std::move(error));
    }
    return p;
}

namespace {

class DdgiPage {
  public:
    DdgiPage(const DdgiResult& result, const RunOptions& options)
        : result_(result), page_("DDGI and clustered transport: " + result.scene), pictures_(ddgi_pictures(result, options)) {
        truth_ = page_.picture(pictures_.truth, "path tracing");
        for (std::size_t i = 0; i < result.rows.size(); ++i) {
            shown_.push_back(page_.picture(pictures_.shown[i], result.rows[i].name()));
            error_.push_back(page_.picture(pictures_.error[i], "signed error: blue too dark, red too bright, full at 100 %"));
        }
    }

    std::string html(const std::string& command) {
        page_.paragraph(introduction(result_) + ".");
        page_.paragraph("Irradiance of a lightmap's receivers but what lamps send straight to them: by DDGI's probes (Majercik, Guertin, "
                        "Nowrouzezahrai and McGuire 2019), octahedral irradiance and moments of distance on a regular grid; by ours, with "
                        "clustered transport (Sedláček 2019); both in rounds until the light has settled. Path tracing is the truth. A click "
                        "on a point shows its lightmap and its signed error.");
        page_.heading("Error against probes, surfaces asked, memory", "curves");
        add_chart("probes", [](const DdgiRow& r) { return double(r.probes); }, true);
        add_chart("surfaces whose radiance an update of the light asks for: probes x rays", [](const DdgiRow& r) { return double(r.places()); }, false);
        add_chart("MB at run time", [](const DdgiRow& r) { return double(r.bytes) / 1e6; }, true);
        page_.heading("All settings", "table");
        add_table(false, "");
        if (std::any_of(result_.rows.begin(), result_.rows.end(), [](const DdgiRow& r) { return r.variant; })) {
            page_.heading("What each part of DDGI is worth", "variants");
            add_table(true, "");
        }
        page_.heading("Lightmaps", "pictures");
        page_.figure(truth_);
        for (const std::size_t i : best_of_each()) page_.figure(shown_[i]), page_.figure(error_[i]);
        page_.raw("<p><code>" + page::escaped(command) + "</code></p>\n");
        return page_.html();
    }

  private:
    // A line a method and setting; most_rays: those with the most rays alone, over the probes.
    void add_chart(const std::string& x, double (*value)(const DdgiRow&), bool most_rays) {
        Chart chart{"error over " + x, x, "rms, % of the truth's mean", true, true};
        int rays = 0;
        for (const DdgiRow& r : result_.rows) rays = std::max(rays, r.variant ? 0 : r.rays);
        for (std::size_t i = 0; i < result_.rows.size(); ++i) {
            const DdgiRow& r = result_.rows[i];
            if (r.variant || (most_rays && r.rays != rays)) continue;
            const std::string of = r.method == "DDGI" ? r.setting.substr(r.setting.find(", ") + 2) : "";
            const std::string name = most_rays ? (r.method + " " + of) : (r.method + " " + r.setting);
            auto line = std::find_if(chart.lines.begin(), chart.lines.end(), [&](const ChartLine& l) { return l.name == name; });
            if (line == chart.lines.end()) line = chart.lines.insert(chart.lines.end(), ChartLine{name});
            line->points.push_back({value(r), 100 * number(r.errors.rms),
                                    {{"setting", r.name()}, {"bias", percent(r.errors.mean_error, "+") + " %"},
                                     {"leaking receivers", percent(r.leaking) + " %"}},
                                    {truth_, shown_[i], error_[i]},
                                    fmt::format("row={}", i)});
        }
        page_.chart(chart);
    }

    void add_table(bool variants, const std::string& caption) {
        std::vector<std::vector<Cell>> rows(1);
        for (const std::string& head : heads()) rows[0].push_back({head, !rows[0].empty()});
        for (const DdgiRow& r : result_.rows) {
            if (r.variant != variants) continue;
            std::vector<Cell> cells;
            for (const std::string& text : cells_of(r)) cells.push_back({text, !cells.empty()});
            rows.push_back(std::move(cells));
        }
        page_.table(rows, caption);
    }

    // Of each method and grid or number of probes the setting with the least error.
    std::vector<std::size_t> best_of_each() const {
        std::vector<std::size_t> best;
        for (std::size_t i = 0; i < result_.rows.size(); ++i) {
            const DdgiRow& r = result_.rows[i];
            if (r.variant || r.method == "whole transport") continue;
            const auto same = std::find_if(best.begin(), best.end(), [&](std::size_t k) {
                return result_.rows[k].method == r.method && result_.rows[k].probes == r.probes;
            });
            if (same == best.end())
                best.push_back(i);
            else if (number(r.errors.rms) < number(result_.rows[*same].errors.rms))
                *same = i;
        }
        return best;
    }

    const DdgiResult& result_;
    Page page_;
    DdgiPictures pictures_;
    int truth_ = 0;
    std::vector<int> shown_, error_;
};

}  // namespace

std::string ddgi_html(const DdgiResult& result, const std::string& command, const RunOptions& options) {
    return DdgiPage(result, options).html(command);
}

}  // namespace plumb::cli
