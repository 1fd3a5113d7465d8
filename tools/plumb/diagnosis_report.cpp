#include "tools/plumb/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/page/markup.h"
#include "tools/plumb/verdict_picture.h"
#include "tools/plumb/verdict_report.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using page::Cell;
using parity::Cause;
using parity::ClusterCause;
using parity::Diagnosis;
using parity::LargeError;
using parity::Ratios;
using parity::WrongPixels;

// The rows of a table, of which the first is its head; columns that hold numbers stand on the right.
struct Rows {
    std::vector<Column> columns;
    std::vector<std::vector<std::string>> rows;

    std::string text() const { return rows.empty() ? "" : format_table(columns, rows, 2); }
    std::vector<std::vector<Cell>> cells() const {
        std::vector<std::vector<Cell>> all(1);
        for (const Column& c : columns) all[0].push_back({c.head, c.align == Align::right});
        for (const std::vector<std::string>& row : rows) {
            all.emplace_back();
            for (std::size_t i = 0; i < row.size(); ++i)
                all.back().push_back({row[i], columns[i].align == Align::right});
        }
        return all;
    }
};

std::string number_text(double x) { return std::isfinite(x) ? fmt::format("{:.5g}", x) : "none"; }

std::string component(const std::string& output, int channel) { return fmt::format("{}.{}", output, "xyzw"[channel]); }

// "3,0 to 60,42".
std::string box_text(glm::ivec2 low, glm::ivec2 high) {
    return fmt::format("{},{} to {},{}", low.x, low.y, high.x, high.y);
}

Rows causes(const Diagnosis& d) {
    Rows rows{
        {{"with"}, {"agree", Align::right}, {"without", Align::right}, {"pixels", Align::right}, {"as well with"}}, {}};
    for (const Cause& c : d.causes)
        rows.rows.push_back({c.text, share_text(c.agree, c.pixels), share_text(c.without, c.pixels),
                             fmt::format("{}", c.pixels), fmt::format("{}", fmt::join(c.alike, "; "))});
    return rows;
}

Rows ratios(const WrongPixels& wrong) {
    Rows rows{{{"got / expected"},
               {"differ", Align::right},
               {"quartile", Align::right},
               {"median", Align::right},
               {"quartile", Align::right},
               {"got 0", Align::right}},
              {}};
    for (const Ratios& r : wrong.ratios) {
        const bool any = r.counted > 0;
        rows.rows.push_back({component(r.output, r.channel), fmt::format("{}", r.differing),
                             any ? number_text(r.quartiles[0]) : "none", any ? number_text(r.quartiles[1]) : "none",
                             any ? number_text(r.quartiles[2]) : "none", fmt::format("{}", r.got_zero)});
    }
    return rows;
}

// The median of the component that differs at the most pixels.
std::string median_text(const std::vector<Ratios>& all) {
    const Ratios* most = nullptr;
    for (const Ratios& r : all)
        if (r.counted > 0 && (!most || r.counted > most->counted)) most = &r;
    return most ? number_text(most->quartiles[1]) : "none";
}

// `in_colour`: with the colours that the places have in the picture.
Rows clusters(const Diagnosis& d, bool in_colour) {
    Rows rows{{{"place"},
               {"wrong pixels together"},
               {"pixels", Align::right},
               {"got / expected", Align::right},
               {"agree", Align::right},
               {"with"}},
              {}};
    if (!in_colour) rows.columns.erase(rows.columns.begin());
    for (std::size_t i = 0; i < d.clusters.size(); ++i) {
        const ClusterCause& c = d.clusters[i];
        rows.rows.push_back({place_colour(i), box_text(c.low, c.high), fmt::format("{}", c.pixels), median_text(c.ratios),
                             c.text.empty() ? "" : share_text(c.agree, c.looked_at),
                             c.text.empty() ? "no guess" : c.text});
    }
    if (!in_colour)
        for (std::vector<std::string>& row : rows.rows) row.erase(row.begin());
    return rows;
}

Rows errors(const std::vector<LargeError>& all, const std::string& head) {
    Rows rows{{{head}, {"output"}, {"expected", Align::right}, {"got", Align::right}, {"difference", Align::right}},
              {}};
    for (const LargeError& e : all)
        rows.rows.push_back({fmt::format("{},{}", e.pixel.x, e.pixel.y), component(e.output, e.channel),
                             exact_text(e.expected), exact_text(e.got), number_text(std::abs(e.got - e.expected))});
    return rows;
}

std::string tried_text(const Diagnosis& d) {
    if (!d.causes.empty()) return fmt::format("Diagnosis, of {} guesses:", d.tried);
    const bool in_places =
        std::any_of(d.clusters.begin(), d.clusters.end(), [](const ClusterCause& c) { return !c.text.empty(); });
    return fmt::format("Diagnosis: none of {} guesses makes half of the wrong pixels agree{}", d.tried,
                       in_places ? "; places have causes of their own" : "");
}

std::string where_text(const Diagnosis& d) {
    const std::size_t n = d.wrong.clusters.size();
    return fmt::format("{} wrong pixels, {}{}", d.wrong.pixels, box_text(d.wrong.low, d.wrong.high),
                       n > d.clusters.size() && n > 1 ? fmt::format(", in {} places; the largest:", n)
                       : n > 1                        ? ":"
                                                      : "");
}

std::string unexpected_text(const Diagnosis& d) {
    return fmt::format("{} of the wrong pixels expect 0", d.wrong.unexpected);
}

Json number_json(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
Json pixel_json(glm::ivec2 p) { return {p.x, p.y}; }

Json ratios_json(const std::vector<Ratios>& all) {
    Json json = Json::array();
    for (const Ratios& r : all) {
        Json quartiles = Json::array();
        for (const double q : r.quartiles) quartiles.push_back(r.counted > 0 ? number_json(q) : Json(nullptr));
        json.push_back({{"output", r.output},
                        {"channel", r.channel},
                        {"differing", r.differing},
                        {"counted", r.counted},
                        {"got_zero", r.got_zero},
                        {"quartiles", quartiles},
                        {"constant", r.constant()}});
    }
    return json;
}

Json errors_json(const std::vector<LargeError>& all) {
    Json json = Json::array();
    for (const LargeError& e : all)
        json.push_back({{"pixel", pixel_json(e.pixel)},
                        {"output", e.output},
                        {"channel", e.channel},
                        {"expected", number_json(e.expected)},
                        {"got", number_json(e.got)}});
    return json;
}

void table(page::Page& page, const Rows& rows) {
    if (!rows.rows.empty()) page.table(rows.cells());
}

}  // namespace

std::string cause_text(const Diagnosis& d) {
    if (d.causes.empty()) return "";
    const Cause& c = d.causes.front();
    return fmt::format("with {}, {} of the pixels agree", c.text, share_text(c.agree, c.pixels));
}

std::string diagnosis_text(const Diagnosis& d) {
    if (d.wrong.pixels == 0) return "";
    std::string text = "\n" + tried_text(d) + "\n" + causes(d).text();
    text += "\n" + where_text(d) + "\n" + clusters(d, false).text() + ratios(d.wrong).text();
    text += errors(d.wrong.largest, "largest errors").text();
    if (d.wrong.unexpected > 0)
        text += unexpected_text(d) + "\n" + errors(d.wrong.unexpected_largest, "where 0 is expected").text();
    return text;
}

Json diagnosis_json(const Diagnosis& d) {
    if (d.wrong.pixels == 0) return nullptr;
    Json causes = Json::array(), clusters = Json::array();
    for (const Cause& c : d.causes)
        causes.push_back({{"with", c.text},
                          {"pixels", c.pixels},
                          {"agree", c.agree},
                          {"without", c.without},
                          {"aside", c.aside},
                          {"fitted", c.fitted},
                          {"alike", c.alike}});
    for (const ClusterCause& c : d.clusters)
        clusters.push_back({{"pixels", c.pixels},
                            {"low", pixel_json(c.low)},
                            {"high", pixel_json(c.high)},
                            {"ratios", ratios_json(c.ratios)},
                            {"with", c.text.empty() ? Json(nullptr) : Json(c.text)},
                            {"looked_at", c.looked_at},
                            {"agree", c.agree}});
    return {{"tried", d.tried},
            {"ms", d.ms},
            {"causes", causes},
            {"wrong", d.wrong.pixels},
            {"low", pixel_json(d.wrong.low)},
            {"high", pixel_json(d.wrong.high)},
            {"ratios", ratios_json(d.wrong.ratios)},
            {"largest", errors_json(d.wrong.largest)},
            {"places", d.wrong.clusters.size()},
            {"clusters", clusters},
            {"unexpected", d.wrong.unexpected},
            {"unexpected_largest", errors_json(d.wrong.unexpected_largest)}};
}

void diagnosis_part(page::Page& page, const Diagnosis& d) {
    if (d.wrong.pixels == 0) return;
    page.raw("<h3>Diagnosis</h3>\n");
    page.paragraph(tried_text(d));
    table(page, causes(d));
    page.paragraph(where_text(d));
    table(page, clusters(d, true));
    table(page, ratios(d.wrong));
    table(page, errors(d.wrong.largest, "largest errors"));
    if (d.wrong.unexpected == 0) return;
    page.paragraph(unexpected_text(d));
    table(page, errors(d.wrong.unexpected_largest, "where 0 is expected"));
}

}  // namespace plumb::cli
