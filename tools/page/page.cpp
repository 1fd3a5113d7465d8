#include "tools/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/image_file.h"
#include "tools/page/embedded.h"
#include "tools/page/markup.h"

namespace plumb::page {

namespace {

// Good is a light green, bad a red, so far apart in lightness, too, that colour is not needed to tell them; dark text
// can be read on all of it.
std::string heat_style(double heat) {
    constexpr glm::dvec3 good{166, 219, 181}, middle{250, 236, 178}, bad{226, 114, 91};
    if (std::isnan(heat)) return " class=\"nan\"";
    if (heat < 0) return "";
    const double t = std::min(heat, 1.0) * 2;
    const glm::dvec3 c = t < 1 ? good + (middle - good) * t : middle + (bad - middle) * (t - 1);
    return fmt::format(" class=\"heat\" style=\"background:rgb({:.0f},{:.0f},{:.0f})\"", c.x, c.y, c.z);
}

std::string table_cell(const Cell& cell) {
    std::string text = cell.badge.empty() ? escaped(cell.text) : badge(cell.text, cell.badge);
    if (!cell.link.empty()) text = fmt::format("<a href=\"{}\">{}</a>", escaped(cell.link), text);
    std::string attributes = heat_style(cell.heat);
    if (cell.number) attributes += " data-number";
    if (!cell.hint.empty()) attributes += fmt::format(" title=\"{}\"", escaped(cell.hint));
    if (!std::isnan(cell.order)) attributes += fmt::format(" data-order=\"{}\"", cell.order);
    return fmt::format("<td{}>{}</td>", attributes, text);
}

std::string head_cell(const Cell& cell) {
    return fmt::format("<th scope=\"col\"{}{}><button type=\"button\">{}</button></th>",
                       cell.number ? " data-number" : "",
                       cell.hint.empty() ? "" : fmt::format(" title=\"{}\"", escaped(cell.hint)), escaped(cell.text));
}

// Null where the chart cannot show it.
Json coordinate(double value, bool logarithmic) {
    return std::isfinite(value) && !(logarithmic && value < 0) ? Json(value) : Json(nullptr);
}

Json point_json(const ChartPoint& point, const Chart& chart) {
    Json json = {{"x", coordinate(point.x, chart.log_x)}, {"y", coordinate(point.y, chart.log_y)}};
    json["values"] = Json::array();
    for (const auto& [name, value] : point.values) json["values"].push_back(Json::array({name, value}));
    json["pictures"] = point.pictures;
    json["id"] = point.id;
    return json;
}

constexpr const char* line_name(Line line) {
    switch (line) {
        case Line::joined:
            return "joined";
        case Line::dashed:
            return "dashed";
        case Line::level:
            return "level";
        case Line::points:
            return "points";
    }
    return "";
}

Json chart_json(const Chart& chart) {
    Json json = {{"title", chart.title}, {"x", chart.x_name},    {"y", chart.y_name},
                 {"log_x", chart.log_x}, {"log_y", chart.log_y}, {"lines", Json::array()}};
    for (const ChartLine& line : chart.lines) {
        Json points = Json::array();
        for (const ChartPoint& point : line.points) points.push_back(point_json(point, chart));
        json["lines"].push_back({{"name", line.name}, {"line", line_name(line.line)}, {"points", points}});
    }
    return json;
}

// Names, under the chart, what it does not show as it is.
std::string notes(const Chart& chart) {
    int left_out = 0, at_edge = 0;
    for (const ChartLine& line : chart.lines)
        for (const ChartPoint& point : line.points) {
            const bool shown =
                !coordinate(point.x, chart.log_x).is_null() && !coordinate(point.y, chart.log_y).is_null();
            const bool zero = (chart.log_x && point.x == 0) || (chart.log_y && point.y == 0);
            left_out += !shown;
            at_edge += shown && zero && line.line != Line::dashed && line.line != Line::level;
        }
    std::string text;
    if (at_edge > 0)
        text += fmt::format(" {} of the points {} 0, which has no place on a logarithmic axis: on the edge, as ▽.",
                            at_edge, at_edge == 1 ? "is" : "are");
    if (left_out > 0)
        text += fmt::format(" {} of the points {} left out: no number that the axes can show.", left_out,
                            left_out == 1 ? "is" : "are");
    return text.empty() ? "" : fmt::format("<p class=\"note\">{}</p>\n", text.substr(1));
}

std::uint32_t byte(float value) { return value > 0 ? std::uint32_t(std::min(value, 1.0f) * 255.0f + 0.5f) : 0u; }

Image<std::uint32_t> bytes(const Image4& srgb) {
    Image<std::uint32_t> rgba(srgb.width, srgb.height);
    std::transform(srgb.texels.begin(), srgb.texels.end(), rgba.texels.begin(),
                   [](const glm::vec4& c) { return byte(c.x) | byte(c.y) << 8 | byte(c.z) << 16 | 0xff000000u; });
    return rgba;
}

// JSON that no text in it can end the element of: '<' stands in strings alone.
std::string script_json(const Json& json) {
    std::string out;
    for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
        if (c == '<')
            out += "\\u003c";
        else
            out += c;
    }
    return out;
}

// Nothing may be loaded, whatever the page holds: what it needs is inside.
constexpr const char* policy =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

}  // namespace

std::string badge(const std::string& text, const std::string& kind) {
    return fmt::format("<span class=\"badge {}\">{}</span>", escaped(kind), escaped(text));
}

Page::Page(std::string title) : title_(std::move(title)) {}

void Page::heading(const std::string& text, const std::string& id) {
    body_ += fmt::format("<h2{}>{}</h2>\n", id.empty() ? "" : fmt::format(" id=\"{}\"", escaped(id)), escaped(text));
}

void Page::paragraph(const std::string& text) { body_ += fmt::format("<p>{}</p>\n", escaped(text)); }

void Page::raw(const std::string& html) { body_ += html; }

void Page::table(const std::vector<std::vector<Cell>>& rows, const std::string& caption) {
    if (rows.empty()) return;
    scripted_ = true;
    body_ += "<div class=\"scroll\" tabindex=\"0\"><table>\n";
    if (!caption.empty()) body_ += fmt::format("<caption>{}</caption>\n", escaped(caption));
    body_ += "<thead><tr>";
    for (const Cell& cell : rows.front()) body_ += head_cell(cell);
    body_ += "</tr></thead>\n<tbody>\n";
    for (auto row = rows.begin() + 1; row != rows.end(); ++row) {
        const bool keyed = !row->empty() && !row->front().key.empty();
        body_ += keyed ? fmt::format("<tr data-key=\"{}\">", escaped(row->front().key)) : "<tr>";
        for (const Cell& cell : *row) body_ += table_cell(cell);
        body_ += "</tr>\n";
    }
    body_ += "</tbody></table></div>\n";
}

void Page::chart(const Chart& chart) {
    scripted_ = true;
    body_ += fmt::format(
        "<section class=\"chart\">\n<h3>{0}</h3>\n<div class=\"drawn\"><canvas role=\"img\" aria-label=\"{0}: {1} over "
        "{2}; all values are in the table\" data-chart=\"{3}\"></canvas></div>\n{4}<div class=\"chosen\" "
        "aria-live=\"polite\"></div>\n</section>\n",
        escaped(chart.title), escaped(chart.y_name), escaped(chart.x_name), charts_.size(), notes(chart));
    charts_.push_back(chart_json(chart));
}

int Page::picture(const Image4& srgb, const std::string& caption) { return picture(bytes(srgb), caption); }

int Page::picture(const Image<std::uint32_t>& rgba, const std::string& caption) {
    const std::string file = "data:image/png;base64," + base64(io::encode_png(caption, rgba));
    const auto [place, is_new] = file_of_.try_emplace(file, int(files_.size()));
    if (is_new) files_.push_back(file);
    pictures_.push_back({{"file", place->second}, {"width", rgba.width}, {"caption", caption}});
    return int(pictures_.size()) - 1;
}

// The page's first figure of a file holds it for charts, too.
void Page::figure(int picture) {
    const Json& shown = pictures_.at(std::size_t(picture));
    const int number = shown["file"];
    Json& file = files_.at(std::size_t(number));
    const std::string source = source_of(number);
    body_ += fmt::format("<figure><img{} alt=\"{}\" width=\"{}\" src=\"{}\"><figcaption>{}</figcaption></figure>\n",
                         file.is_string() ? fmt::format(" id=\"file{}\"", number) : "",
                         escaped(shown["caption"].get<std::string>()), std::max(shown["width"].get<int>(), 256), source,
                         escaped(shown["caption"].get<std::string>()));
    file = nullptr;
}

// A file is drawn one unit wide and high, and scaled to each figure; later figures refer to the first one's image.
void Page::figure(int picture, const Overlay& overlay) {
    const Json& shown = pictures_.at(std::size_t(picture));
    const int number = shown["file"];
    const std::string caption = escaped(shown["caption"].get<std::string>());
    const glm::dvec4 v = overlay.view;
    const std::string image =
        drawn_.insert(number).second
            ? fmt::format("<image id=\"drawn{}\" width=\"1\" height=\"1\" preserveAspectRatio=\"none\" href=\"{}\"/>",
                          number, source_of(number))
            : fmt::format("<use href=\"#drawn{}\"/>", number);
    body_ += fmt::format(
        "<figure><svg role=\"img\" aria-label=\"{}\" viewBox=\"{} {} {} {}\" width=\"{}\" height=\"{}\">\n"
        "<g transform=\"scale({} {})\">{}</g>\n{}</svg><figcaption style=\"max-width:{}px\">{}</figcaption></figure>\n",
        caption, v.x, v.y, v.z, v.w, overlay.width, std::round(overlay.width * v.w / v.z), overlay.size.x,
        overlay.size.y, image, overlay.marks, overlay.width, caption);
    scripted_ = true;
}

std::string Page::source_of(int file) const {
    for (const auto& [text, of] : file_of_)
        if (of == file) return text;
    return "";
}

std::string Page::html() const {
    std::string out = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta "
        "http-equiv=\"Content-Security-Policy\" "
        "content=\"{}\">\n<meta name=\"viewport\" "
        "content=\"width=device-width\">\n<title>{}</title>\n<style>\n{}</style>\n"
        "</head><body>\n<h1>{}</h1>\n",
        policy, escaped(title_), page_css, escaped(title_));
    if (!charts_.empty())
        out += "<noscript><p class=\"note\">Charts need JavaScript; their values are in the tables.</p></noscript>\n";
    out += body_;
    if (!charts_.empty()) {
        const Json data = {{"charts", charts_}, {"pictures", pictures_}, {"files", files_}};
        out += fmt::format("<script type=\"application/json\" id=\"data\">{}</script>\n", script_json(data));
        out += fmt::format(
            "<script type=\"text/plain\">Chart.js, which draws the charts:\n{}</script>\n<script>{}</script>\n",
            chart_licence, chart_js);
    }
    if (scripted_) out += fmt::format("<script>\n{}</script>\n", page_js);
    return out + "</body></html>\n";
}

}  // namespace plumb::page
