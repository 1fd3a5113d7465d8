// plumb experiment ipr: the page, with the pictures of every row.
#include <fmt/format.h>

#include <map>

#include "tools/experiments/ipr_cells.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"

namespace plumb::cli {

namespace {

using page::Cell;
using page::Chart;
using page::ChartLine;
using page::Page;

void add_table(Page& page, const IprTable& t) {
    std::vector<std::vector<Cell>> rows(1);
    for (const std::string& head : ipr_heads()) rows[0].push_back({head, rows[0].size() > 1});
    for (const IprRow& r : t.rows) {
        std::vector<Cell> cells;
        for (const std::string& text : ipr_cells(r)) cells.push_back({text, cells.size() > 1});
        rows.push_back(std::move(cells));
    }
    page.table(rows, t.notes);
    for (const IprRow& r : t.rows)
        if (!r.refused.empty()) page.paragraph(r.name + ": " + r.refused);
    for (const std::string& line : t.left_out) page.paragraph(line);
}

// Time and error along a table of the thesis, its time beside ours.
void add_chart(Page& page, const IprTable& t) {
    const bool probes = t.title == "number of probes";
    Chart chart{t.id + ": an update", t.title, "ms", true, true, {{"ours", {}}, {"thesis (GT 630M)", {}}}};
    Chart error{t.id + ": error", t.title, "% of the truth's mean", true, true, {{"mean |error|", {}}, {"rms", {}}}};
    for (const IprRow& r : t.rows) {
        if (!r.refused.empty()) continue;
        const double x = probes ? r.probes : r.receivers;
        chart.lines[0].points.push_back({x, r.median_ms(), {{"setting", r.name}}});
        if (r.thesis.ms > 0) chart.lines[1].points.push_back({probes ? x : double(r.thesis.receivers), r.thesis.ms, {{"setting", r.name}}});
        error.lines[0].points.push_back({x, 100 * r.at_receivers.mean, {{"setting", r.name}}});
        error.lines[1].points.push_back({x, 100 * r.at_receivers.rms, {{"setting", r.name}}});
    }
    Chart bake{t.id + ": precomputation", t.title, "s", true, true, {{"ours", {}}, {"thesis (one thread of an i5-3210M)", {}}}};
    for (const IprRow& r : t.rows) {
        const double x = probes ? r.probes : r.receivers;
        bake.lines[0].points.push_back({x, r.bake_seconds, {{"setting", r.name}}});
        if (r.thesis.minutes > 0) bake.lines[1].points.push_back({probes ? x : double(r.thesis.receivers), 60 * r.thesis.minutes, {{"setting", r.name}}});
    }
    page.chart(bake);
    page.chart(chart);
    page.chart(error);
}

// Figures 5.5 and 5.8: a curve for each number of receivers, and for each number of probes.
void add_graphs(Page& page, const IprTable& t) {
    struct What {
        const char *title, *unit;
        double (*value)(const IprRow&);
    };
    const What whats[] = {{"precomputation", "s", [](const IprRow& r) { return r.bake_seconds; }},
                          {"an update", "ms", [](const IprRow& r) { return r.median_ms(); }},
                          {"error", "% of the truth's mean", [](const IprRow& r) { return 100 * r.at_receivers.mean; }}};
    for (const bool by_probes : {true, false})
        for (const What& what : whats) {
            std::map<int, ChartLine> lines;
            for (const IprRow& r : t.rows) {
                if (!r.refused.empty()) continue;
                const int line = by_probes ? r.receivers : r.probes, x = by_probes ? r.probes : r.receivers;
                lines[line].name = fmt::format("{} {}", line, by_probes ? "receivers" : "probes");
                lines[line].points.push_back({double(x), what.value(r), {{"setting", r.name}}});
            }
            Chart chart{fmt::format("{}: {}", by_probes ? "figure 5.5" : "figure 5.8", what.title), by_probes ? "number of probes" : "number of receivers", what.unit};
            for (auto& [line, points] : lines) chart.lines.push_back(std::move(points));
            page.chart(chart);
        }
}

void add_pictures(Page& page, const IprTable& t) {
    for (const IprRow& r : t.rows) {
        if (r.display.empty()) continue;
        const std::string ssim = r.ssim ? fmt::format(", SSIM {:.4f}", *r.ssim) : "";
        page.figure(page.picture(r.display, t.id + ", " + r.name + ssim));
        if (!r.dots.empty()) page.figure(page.picture(r.dots, "figure 5.3, " + r.name + ": probes"));
        page.figure(page.picture(r.error, fmt::format("{}, {}: error of the indirect light, mean |error| {:.2f} %; blue too dark, red too bright, full at 50 %, three "
                                                      "standard errors taken off",
                                                      t.id, r.name, 100 * r.at_pixels->mean)));
    }
}

void add_lod(Page& page, const IprResult& r) {
    if (r.lod.empty()) return;
    page.heading(r.scene + ": level of detail");
    for (const IprLodTable& t : r.lod) show_sheet(page, r.scene, lod_sheet(t));
    if (r.seams) page.raw("<pre>" + page::escaped(seams_text(*r.seams)) + "</pre>");
}

}  // namespace

std::string ipr_html(const std::vector<IprResult>& results, const std::string& command) {
    Page page("IPR chapter 5 again");
    page.paragraph("Tables and figures of Sedláček 2019, \"Real-time Global Illumination using Irradiance Probes\", chapter 5, on scenes of our own, and the error of "
                   "each row against path tracing, which the thesis does not have.");
    page.paragraph(ipr_legend());
    for (const IprResult& r : results) {
        page.heading(r.scene);
        for (const IprTable& t : r.tables) {
            page.heading(r.scene + ", " + t.id + ": " + t.title);
            add_table(page, t);
            if (t.id.rfind("table", 0) == 0) add_chart(page, t);
            if (t.title == "probes by receivers") add_graphs(page, t);
            if (t.id == "goal" && r.goal) page.paragraph(goal_text(*r.goal));
            add_pictures(page, t);
        }
        if (r.quads) page.paragraph(quads_text(*r.quads));
        if (r.lightmap) {
            page.heading(r.scene + ": the lightmap, receiver by receiver");
            page.paragraph(lightmap_text(*r.lightmap));
            for (const probes::DebugLayer& layer : r.lightmap->pictures) page.figure(page.picture(layer.picture, layer.name + ": " + layer.meaning));
        }
        for (const IprSheet& sheet : r.sheets) show_sheet(page, r.scene, sheet);
        add_lod(page, r);
        for (const std::string& line : r.left_out) page.paragraph(line);
    }
    page.paragraph("Made by: " + command);
    return page.html();
}

}  // namespace plumb::cli
