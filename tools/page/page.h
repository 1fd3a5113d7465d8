// Pages that open without a network: one HTML file with its text, tables, pictures and charts inside. See README.md.
//
// Charts are drawn by Chart.js (Debian's libjs-chart.js), which is put into the program when it is built.
#pragma once

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/image.h"

namespace plumb::page {

using Json = nlohmann::ordered_json;

// One point of a chart. What is not finite, and on a logarithmic axis what is negative, is left out of the chart and
// counted under it; 0 on a logarithmic axis lies on the chart's edge, marked as exact.
struct ChartPoint {
    double x = 0, y = 0;
    std::vector<std::pair<std::string, std::string>> values = {};  // shown while the mouse is over it: name, value
    std::vector<int> pictures = {};                                // shown at a click: numbers from Page::picture()
    std::string id = "";  // a link "#id" shows the point's pictures; unique in its chart, the same in another chart
};

enum class Line {
    joined,  // points and a line through them
    dashed,  // a dashed line alone, as the Pareto front
    level,   // one height across the whole chart, shaded below it, as noise: of its points the first one's y
    points,  // points alone
};

struct ChartLine {
    std::string name;
    std::vector<ChartPoint> points = {};
    Line line = Line::joined;
};
struct Chart {
    std::string title, x_name, y_name;  // names with units
    bool log_x = true, log_y = true;
    std::vector<ChartLine> lines = {};
};

// A cell of a table: text, and where it has one a colour and what the mouse shows over it.
struct Cell {
    std::string text;
    bool number = false;  // aligned right
    double heat = -1;     // 0 good (green) .. 1 bad (red); below 0: none; NaN: black, never good
    std::string hint = "";
    std::string link = "";  // "#id" of another part of the page
    // What its column is sorted by; NaN: by the number that the text starts with, else by the text.
    double order = std::numeric_limits<double>::quiet_NaN();
    std::string badge = "";  // a kind of badge() that the text is shown as
    std::string key = "";    // of a row's first cell: what else has this data-key is pointed out with the row
};

// Marks over a picture, in its texels: (0, 0) is the top left corner of the first one, whose centre is at 0.5.
struct Overlay {
    glm::dvec2 size{0};         // texels that the picture stands for; it may be kept smaller
    glm::dvec4 view{0};         // x, y, width, height of what is shown, texels; it may reach beyond the picture
    int width = 512;            // on the page, px
    std::string marks = "";     // SVG that is trusted, with everything foreign escaped(); data-key="..." as in Cell
};

// Text on a label, as markup; the kinds are "plain", "good", "doubt", "bad" and "none", in colours that all can tell
// apart.
std::string badge(const std::string& text, const std::string& kind);

class Page {
  public:
    explicit Page(std::string title);

    void heading(const std::string& text, const std::string& id = "");
    void paragraph(const std::string& text);
    // Markup that is trusted: ours, with everything foreign escaped().
    void raw(const std::string& html);
    // The first row is the head. Columns are sorted by a click on their head.
    void table(const std::vector<std::vector<Cell>>& rows, const std::string& caption = "");
    void chart(const Chart& chart);
    // Keeps a picture for charts' clicks and returns its number; figure() shows one in the page itself. The file of
    // equal pictures is kept once.
    int picture(const Image4& srgb, const std::string& caption);  // xyz 0..1, sRGB-encoded; what is no number is 0
    int picture(const Image<std::uint32_t>& rgba, const std::string& caption);  // 8 bits each, red lowest
    void figure(int picture);
    // The picture with marks over it. A file that several figures show is held once.
    void figure(int picture, const Overlay& overlay);

    std::string html() const;

  private:
    std::string source_of(int file) const;  // its data: URI

    std::string title_, body_;
    Json charts_ = Json::array(), pictures_ = Json::array(), files_ = Json::array();
    std::map<std::string, int> file_of_;  // the number in files_ of a data: URI
    std::set<int> drawn_;                 // numbers in files_ of those that an overlay's figure holds
    bool scripted_ = false;               // has tables, charts or overlays
};

}  // namespace plumb::page
