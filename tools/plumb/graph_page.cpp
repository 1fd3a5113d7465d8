#include "tools/plumb/graph_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tools/page/markup.h"
#include "tools/page/page.h"
#include "tools/plumb/explain_pictures.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

using page::escaped;

constexpr int box_width = 256, box_height = 40, column_step = 300, row_step = 54, margin = 20;  // px
constexpr int most_texels = 384;  // a side of a picture on the page

std::string id_of(std::size_t node) { return fmt::format("stage-{}", node); }

// Columns by the longest way from what reads no stage; rows in the order in which stages ran.
struct Layout {
    std::vector<int> column, row;
    int columns = 0, rows = 0;
};

std::map<std::string, std::size_t> indices(const std::vector<GraphNode>& nodes) {
    std::map<std::string, std::size_t> index;
    for (std::size_t i = 0; i < nodes.size(); ++i) index[nodes[i].run.label] = i;
    return index;
}

Layout layout_of(const std::vector<GraphNode>& nodes) {
    const std::map<std::string, std::size_t> index = indices(nodes);
    Layout layout;
    std::map<int, int> filled;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        int column = 0;
        for (const std::string& read : nodes[i].run.reads)
            if (const auto at = index.find(read); at != index.end() && at->second < i)
                column = std::max(column, layout.column[at->second] + 1);
        layout.column.push_back(column);
        layout.row.push_back(filled[column]++);
        layout.columns = std::max(layout.columns, column + 1), layout.rows = std::max(layout.rows, filled[column]);
    }
    return layout;
}

glm::ivec2 corner(const Layout& layout, std::size_t i) {
    return {margin + layout.column[i] * column_step, margin + layout.row[i] * row_step};
}

std::string edge(glm::ivec2 from, glm::ivec2 to) {
    const glm::ivec2 a = from + glm::ivec2(box_width, box_height / 2), b = to + glm::ivec2(0, box_height / 2);
    const int bend = std::max((b.x - a.x) / 2, 20);
    return fmt::format("<path d=\"M{} {} C{} {} {} {} {} {}\" fill=\"none\" stroke=\"#8a93a5\" stroke-width=\"1.2\"/>", a.x, a.y,
                       a.x + bend, a.y, b.x - bend, b.y, b.x, b.y);
}

std::string box(const GraphNode& n, glm::ivec2 at, std::size_t i) {
    const char* fill = n.run.needed ? "#e8f0fb" : "#f2f2f2";
    const std::string second = n.run.needed ? fmt::format("{} ms, {} MB", milliseconds_text(n.run.ms), megabytes_text(n.run.bytes))
                                            : "left out: " + n.run.rule;
    return fmt::format("<a href=\"#{}\"><title>{}</title><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"5\" fill=\"{}\" "
                       "stroke=\"#5b6b85\"{}/><text x=\"{}\" y=\"{}\" font-size=\"12\" fill=\"#1b2330\">{}</text>"
                       "<text x=\"{}\" y=\"{}\" font-size=\"11\" fill=\"#4a566b\">{}</text></a>",
                       id_of(i), escaped(n.run.label + ": " + n.run.reason), at.x, at.y, box_width, box_height, fill,
                       n.run.needed ? "" : " stroke-dasharray=\"4 3\"", at.x + 8, at.y + 17, escaped(n.run.label), at.x + 8,
                       at.y + 32, escaped(second));
}

std::string drawing(const std::vector<GraphNode>& nodes) {
    const Layout layout = layout_of(nodes);
    const std::map<std::string, std::size_t> index = indices(nodes);
    std::string svg = fmt::format("<div style=\"overflow-x:auto\"><svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" "
                                  "height=\"{}\" font-family=\"sans-serif\">",
                                  2 * margin + (layout.columns - 1) * column_step + box_width,
                                  2 * margin + layout.rows * row_step);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        for (const std::string& read : nodes[i].run.reads)
            if (const auto at = index.find(read); at != index.end() && at->second < i)
                svg += edge(corner(layout, at->second), corner(layout, i));
    for (std::size_t i = 0; i < nodes.size(); ++i) svg += box(nodes[i], corner(layout, i), i);
    return svg + "</svg></div>";
}

// What the stage made, as pictures.
void add_pictures(page::Page& page, const GraphNode& n) {
    for (const GraphNode::Figure& f : n.figures) page.figure(page.picture(f.picture, f.caption));
    for (const Array& array : n.outputs.arrays) {
        const bool image = array.shape.size() == 2 || (array.shape.size() == 3 && (array.shape[2] == 4 || array.shape[2] == 2));
        if (array.bytes.empty() || !image || (array.dtype != DType::f32 && array.dtype != DType::i32)) continue;
        Slot slot;
        slot.name = array.name, slot.kind = SlotKind::storage_image, slot.dtype = array.dtype;
        slot.channels = array.shape.size() == 3 ? int(array.shape[2]) : 1;
        const SlotPicture picture = slot_picture(slot, array, 0);
        page.figure(page.picture(reduced(picture.texels, reduction(picture.texels, most_texels)),
                                 picture.name + ": " + picture.mapping));
    }
}

}  // namespace

std::string graph_page(const std::string& title, const std::vector<GraphNode>& nodes) {
    page::Page page(title);
    page.paragraph("Every stage that ran or was left out, in the order from left to right in which one reads what another made. "
                   "A click shows what it made.");
    page.raw(drawing(nodes));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const GraphNode& n = nodes[i];
        page.heading(n.run.label, id_of(i));
        page.paragraph((n.run.needed ? fmt::format("{} ms, {} MB. ", milliseconds_text(n.run.ms), megabytes_text(n.run.bytes))
                                     : "Left out. ") +
                       n.run.reason + ".");
        if (!n.run.reads.empty()) page.paragraph(fmt::format("Reads {}.", fmt::join(n.run.reads, ", ")));
        if (!n.read_until.empty()) page.paragraph("Is read until " + n.read_until + ".");
        if (n.run.needed) add_pictures(page, n);
    }
    return page.html();
}

}  // namespace plumb::cli
