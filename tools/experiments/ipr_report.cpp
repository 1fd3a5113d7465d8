// plumb experiment ipr: what was measured as text, JSON and CSV.
#include <fmt/format.h>

#include <algorithm>

#include "tools/experiments/ipr.h"
#include "tools/experiments/ipr_cells.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

std::string percent(double share, const char* sign = "") { return fmt::format(fmt::runtime(std::string("{:") + sign + ".2f}"), 100 * share); }
std::string optional(const std::optional<double>& x) { return x ? fmt::format("{:.4f}", *x) : "-"; }
std::string printed(double x, const char* format = "{:g}") { return x > 0 ? fmt::format(fmt::runtime(format), x) : "-"; }

}  // namespace

const std::vector<std::string>& ipr_heads() {
    static const std::vector<std::string> all = {
        "setting",  "of",          "receivers",     "probes",        "clusters",       "MB",          "ms",           "spread %",    "SSIM",
        "SSIM truth", "mean %",    "bias %",        "rms %",         "truth +- %",     "pixels: mean %", "bias %",    "rms %",        "thesis: receivers",
        "clusters", "ms"};
    return all;
}

std::vector<std::string> ipr_cells(const IprRow& r) {
    std::vector<std::string> cells = {r.name, r.settings};
    if (!r.refused.empty()) {
        cells.resize(ipr_heads().size(), "-");
        return cells;
    }
    const IprErrors& e = r.at_receivers;
    cells.insert(cells.end(), {fmt::format("{}", r.receivers), fmt::format("{}", r.probes), fmt::format("{}", r.clusters),
                               fmt::format("{:.2f}", double(r.bytes) / 1e6), fmt::format("{:.3f}", r.median_ms()), fmt::format("{:.0f}", 100 * r.spread()),
                               optional(r.ssim), optional(r.ssim_truth), percent(e.mean), percent(e.bias, "+"), percent(e.rms), percent(e.noise)});
    for (const bool signed_one : {false, true}) cells.push_back(r.at_pixels ? percent(signed_one ? r.at_pixels->bias : r.at_pixels->mean, signed_one ? "+" : "") : "-");
    cells.push_back(r.at_pixels ? percent(r.at_pixels->rms) : "-");
    cells.insert(cells.end(), {printed(r.thesis.receivers), printed(r.thesis.clusters), printed(r.thesis.ms, "{:.2f}")});
    return cells;
}

std::string goal_text(const IprGoal& g) {
    std::string text = g.most > 0 ? fmt::format("mean |error| {:.2f} %, goal {:g} %: {}", 100 * g.reached, 100 * g.most, g.reached < g.most ? "reached" : (1 - g.lowered) * g.reached < g.most ? "missed, but reached" : "missed")
                                  : fmt::format("mean |error| {:.2f} %", 100 * g.reached);
    return text + (g.limit.empty() ? "; no change of a resource lowers it"
                                   : fmt::format("; what lowers it most, by {:.0f} % to {:.2f} %, is {}", 100 * g.lowered, 100 * (1 - g.lowered) * g.reached, g.limit));
}

std::string quads_text(const IprQuads& q) {
    return fmt::format("Small emissive quads: {:.1f} of {} rays of a probe meet what emits; rms {:.2f} % through clusters in float, {:.2f} % "
                       "by un-truncated transport in double: {:.3f} times, at most {:g} asked: {}",
                       q.hits, q.relight_rays, 100 * q.chain.rms, 100 * q.whole.rms, q.ratio(), most_quad_ratio,
                       q.ratio() <= most_quad_ratio ? "reached" : "missed");
}

std::string lightmap_text(const IprLightmap& l) {
    return fmt::format("Lightmap of {} receivers on {} texels a side, {} paths each: mean |error| {:.2f} %, bias {:+.2f} %, rms {:.2f} %, truth +- {:.2f} %; "
                       "{} leaks of {} texels ({} where no path finds light); {:.1f} % of the receivers told from noise ({:.1f} % by chance)",
                       l.receivers, l.side, l.samples, 100 * l.errors.mean, 100 * l.errors.bias, 100 * l.errors.rms, 100 * l.errors.noise, l.leaks, l.leaking,
                       l.black_leaking, 100 * l.told, 100 * l.told_by_chance);
}

const char* ipr_legend() {
    return "mean, bias, rms: of the irradiance's luminance against path tracing, of the truth's mean, all light but what lamps send straight to a\n"
           "receiver (pixels: of the picture); mean: of |error|, the truth's noise in it; rms: the noise taken out; truth +-: its standard error.\n"
           "MB: matrices, U, lambda, basis, irradiance and lightmap, each once. SSIM: against the largest column of a table, the first row of a\n"
           "figure; SSIM truth: against the picture with traced indirect light. ms: an update, median; only an idle machine's say something.\n"
           "The thesis' ms are a GeForce GT 630M's, of scenes of its own; its SSIM are in pictures alone.\n";
}

const LodTable* thesis_table(const IprLodTable& t) {
    const auto at = std::find_if(thesis_lod_tables().begin(), thesis_lod_tables().end(), [&](const LodTable& x) { return x.number == t.number; });
    return at == thesis_lod_tables().end() ? nullptr : &*at;
}

// Level of detail with its truth, the thesis beside it.
IprSheet lod_sheet(const IprLodTable& t) {
    const std::size_t colon = t.title.find(": ");
    IprSheet sheet{t.title.substr(0, colon), colon == t.title.npos ? "" : t.title.substr(colon + 2), t.notes, {}, {}, {}, {}};
    sheet.heads = {{"receivers"}, {"share %", 1}, {"ms", 3}, {"its map: ms", 3}, {"speed-up", 2}, {"SSIM", 4}, {"SSIM truth", 4}, {"change %", 2}, {"worst change %", 2}};
    add_error_heads(sheet.heads, "pixels");
    add_error_heads(sheet.heads, "receivers");
    const bool moves = std::any_of(t.rows.begin(), t.rows.end(), [](const LodMeasured& m) { return m.air.has_value(); });
    if (moves) sheet.heads.insert(sheet.heads.end(), {{"air: places"}, {"air: MB", 3}, {"air: ms", 3}, {"air: change %", 2}, {"air: worst change %", 2}});
    const LodTable* thesis = thesis_table(t);
    if (thesis) sheet.heads.insert(sheet.heads.end(), {{"thesis: receivers"}, {"thesis: ms", 2}, {"thesis: speed-up", 2}, {"thesis: SSIM", 3}});
    for (const LodMeasured& m : t.rows) {
        IprSheetRow row{m.setup, "", {}, {}};
        row.values = {double(m.receivers), 100 * double(m.receivers) / double(t.rows[0].receivers), m.ms, m.stages.lightmap, m.speed_up, m.ssim, m.ssim_truth, 100 * m.error, 100 * m.worst};
        add_error_values(row.values, m.at_pixels), add_error_values(row.values, m.at_receivers);
        if (moves)
            for (const double x : {double(m.air->computed), 1e-6 * double(m.air->counts.bytes), m.air->ms, 100 * m.air->error, 100 * m.air->worst}) row.values.push_back(x);
        if (thesis) {
            const auto f = std::find_if(thesis->rows.begin(), thesis->rows.end(), [&](const LodFigures& x) { return x.setup == m.setup; });
            const auto put = [&](double x) { row.values.push_back(x > 0 ? std::optional(x) : std::nullopt); };
            if (f == thesis->rows.end())
                row.values.resize(sheet.heads.size());
            else
                put(double(f->receivers)), put(f->ms), put(f->ms > 0 ? f->speed_up : 0), row.values.push_back(f->ssim);
        }
        row.pictures = {{m.ssim ? fmt::format("SSIM {:.4f}", *m.ssim) : "", m.picture}, {"SSIM, pixel by pixel", m.ssim && *m.ssim < 1 ? m.ssim_picture : Image4()}, {"error of the indirect light", m.error_picture},
                        {"levels 0, 1, 2, 3 red, green, blue, yellow", m.levels}, {"lightmaps of the levels; black: not computed", m.lightmap}};
        if (!m.notes.empty()) sheet.lines.push_back(fmt::format("{}: {}", m.setup, fmt::join(m.notes, "; ")));
        sheet.rows.push_back(std::move(row));
    }
    return sheet;
}

std::string ipr_text(const std::vector<IprResult>& results) {
    std::string text;
    for (const IprResult& r : results) {
        text += "==== " + r.scene + "\n";
        for (const IprTable& t : r.tables) {
            text += fmt::format("\n{}: {} ({})\n\n", t.id, t.title, t.notes);
            std::vector<Column> columns;
            for (const std::string& head : ipr_heads()) columns.push_back({head, columns.size() < 2 ? Align::left : Align::right});
            std::vector<std::vector<std::string>> rows;
            for (const IprRow& row : t.rows) rows.push_back(ipr_cells(row));
            text += format_table(columns, rows);
            for (const IprRow& row : t.rows)
                if (!row.refused.empty()) text += fmt::format("{}: {}\n", row.name, row.refused);
            for (const std::string& line : t.left_out) text += line + "\n";
        }
        text += "\n";
        if (r.goal) text += goal_text(*r.goal) + "\n";
        if (r.quads) text += quads_text(*r.quads) + "\n";
        if (r.lightmap) text += lightmap_text(*r.lightmap) + "\n";
        for (const IprSheet& sheet : r.sheets) text += sheet_text(sheet);
        for (const IprLodTable& t : r.lod) text += "\n" + lod_text(t.title + (t.notes.empty() ? "" : ", " + t.notes), t.rows, thesis_table(t));
        if (r.seams) text += "\n" + seams_text(*r.seams);
        for (const std::string& line : r.left_out) text += line + "\n";
        text += "\n";
    }
    return text + ipr_legend();
}

// ---- JSON ---------------------------------------------------------------------------------------------------------------

namespace {

Json errors_json(const IprErrors& e) {
    return {{"count", e.count}, {"truth", e.truth}, {"noise", e.noise}, {"mean", e.mean}, {"bias", e.bias}, {"rms", e.rms}};
}
Json optional_json(const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); }

Json row_json(const IprRow& r) {
    if (!r.refused.empty()) return {{"name", r.name}, {"settings", r.settings}, {"refused", r.refused}};
    return {{"name", r.name}, {"settings", r.settings}, {"lightmap", r.lightmap}, {"receivers", r.receivers}, {"probes", r.probes}, {"clusters", r.clusters},
            {"bytes", r.bytes}, {"ms", r.median_ms()}, {"spread", r.spread()}, {"seconds_of_bake", r.bake_seconds}, {"rounds", r.rounds},
            {"ssim", optional_json(r.ssim)}, {"ssim_truth", optional_json(r.ssim_truth)}, {"at_receivers", errors_json(r.at_receivers)},
            {"at_pixels", r.at_pixels ? errors_json(*r.at_pixels) : Json(nullptr)}, {"at_contacts", r.at_contacts ? errors_json(*r.at_contacts) : Json(nullptr)},
            {"thesis", {{"receivers", r.thesis.receivers}, {"clusters", r.thesis.clusters}, {"ms", r.thesis.ms}, {"minutes", r.thesis.minutes}}}};
}

}  // namespace

Json ipr_json(const std::vector<IprResult>& results) {
    Json scenes = Json::array();
    for (const IprResult& r : results) {
        Json scene = {{"scene", r.scene}, {"tables", Json::array()}};
        for (const IprTable& t : r.tables) {
            Json rows = Json::array();
            for (const IprRow& row : t.rows) rows.push_back(row_json(row));
            scene["tables"].push_back({{"id", t.id}, {"title", t.title}, {"rows", rows}, {"left_out", t.left_out}});
        }
        if (r.goal) scene["goal"] = {{"most", r.goal->most}, {"mean", r.goal->reached}, {"limit", r.goal->limit}, {"lowered", r.goal->lowered}};
        if (r.quads)
            scene["quads"] = {{"hits", r.quads->hits}, {"relight_rays", r.quads->relight_rays}, {"chain", errors_json(r.quads->chain)},
                              {"whole", errors_json(r.quads->whole)}, {"ratio", r.quads->ratio()}};
        if (r.lightmap)
            scene["lightmap"] = {{"receivers", r.lightmap->receivers}, {"side", r.lightmap->side}, {"samples", r.lightmap->samples},
                                 {"errors", errors_json(r.lightmap->errors)}, {"leaks", r.lightmap->leaks}, {"leaking", r.lightmap->leaking},
                                 {"black_leaking", r.lightmap->black_leaking}, {"told", r.lightmap->told}, {"told_by_chance", r.lightmap->told_by_chance}};
        scene["sheets"] = Json::array();
        for (const IprSheet& sheet : r.sheets) scene["sheets"].push_back(sheet_json(sheet));
        Json lod = Json::array();
        for (const IprLodTable& t : r.lod) lod.push_back({{"title", t.title}, {"thesis", t.number}, {"notes", t.notes}, {"rows", lod_json(t.rows)}});
        if (!r.lod.empty()) scene["lod"] = lod;
        if (r.seams) scene["seams"] = seams_json(*r.seams);
        scene["left_out"] = r.left_out;
        scenes.push_back(scene);
    }
    return {{"version", 1}, {"scenes", scenes}};
}

std::string ipr_csv(const std::vector<IprResult>& results) {
    std::string text = "scene,table,setting,of,lightmap,receivers,probes,clusters,bytes,ms,spread,ssim,ssim_truth,mean,bias,rms,noise,"
                       "pixels_mean,pixels_bias,pixels_rms,thesis_receivers,thesis_clusters,thesis_ms\n";
    const auto word = [](std::string s) {
        std::replace(s.begin(), s.end(), ',', ';');
        return s;
    };
    const auto maybe = [](const std::optional<double>& x) { return x ? fmt::format("{:.6g}", *x) : ""; };
    for (const IprResult& r : results)
        for (const IprTable& t : r.tables)
            for (const IprRow& row : t.rows) {
                text += fmt::format("{},{},{},{}", word(r.scene), word(t.id), word(row.name), word(row.settings));
                if (!row.refused.empty()) {
                    text.append(19, ',') += "\n";
                    continue;
                }
                const IprErrors& e = row.at_receivers;
                text += fmt::format(",{},{},{},{},{},{:.6g},{:.3g},{},{},{:.6g},{:.6g},{:.6g},{:.6g}", row.lightmap, row.receivers, row.probes, row.clusters,
                                    row.bytes, row.median_ms(), row.spread(), maybe(row.ssim), maybe(row.ssim_truth), e.mean, e.bias, e.rms, e.noise);
                text += row.at_pixels ? fmt::format(",{:.6g},{:.6g},{:.6g}", row.at_pixels->mean, row.at_pixels->bias, row.at_pixels->rms) : ",,,";
                text += fmt::format(",{},{},{}\n", row.thesis.receivers, row.thesis.clusters, row.thesis.ms);
            }
    return text;
}

std::string ipr_parts_csv(const std::vector<IprResult>& results) {
    std::string text = "scene,table,setting,of,quantity,value\n";
    for (const IprResult& r : results) {
        for (const IprSheet& sheet : r.sheets) text += sheet_csv(r.scene, sheet);
        for (const IprLodTable& t : r.lod) {
            IprSheet sheet = lod_sheet(t);
            sheet.id = t.title;
            text += sheet_csv(r.scene, sheet);
        }
        if (r.seams) {
            text += fmt::format("{},seams,from any degree,,largest gap,{}\n", r.scene, r.seams->largest_gap);
            text += fmt::format("{},seams,from the bake's degree,,largest gap,{}\n", r.scene, r.seams->largest_gap_from_top);
        }
    }
    return text;
}

}  // namespace plumb::cli
