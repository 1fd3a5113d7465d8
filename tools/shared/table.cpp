#include "tools/shared/table.h"

#include <fmt/format.h>

#include <algorithm>

namespace plumb::cli {

namespace {

// Columns that a terminal needs: bytes of UTF-8 that do not continue a character.
std::size_t width_of(const std::string& text) {
    return std::count_if(text.begin(), text.end(),
                         [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; });
}

}  // namespace

std::string format_table(const std::vector<Column>& columns, const std::vector<std::vector<std::string>>& rows,
                         int indent) {
    std::vector<std::string> heads;
    bool headed = false;
    for (const Column& c : columns) {
        heads.push_back(c.head);
        headed |= !c.head.empty();
    }
    std::vector<std::size_t> widths(columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
        widths[c] = width_of(heads[c]);
        for (const auto& row : rows) widths[c] = std::max(widths[c], width_of(row[c]));
    }

    std::string text;
    auto add_line = [&](const std::vector<std::string>& cells) {
        std::string line(indent, ' ');
        for (std::size_t c = 0; c < columns.size(); ++c) {
            if (c > 0) line += "  ";
            const std::string padding(widths[c] - width_of(cells[c]), ' ');
            line += columns[c].align == Align::left ? cells[c] + padding : padding + cells[c];
        }
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    };
    if (headed) add_line(heads);
    for (const auto& row : rows) add_line(row);
    return text;
}

std::string exact_text(double value) { return fmt::format("{:.9g}", value); }

std::string exact_text(const std::vector<double>& values) {
    std::string text;
    for (double v : values) text += (text.empty() ? "" : "  ") + exact_text(v);
    return text;
}

std::string megabytes_text(std::size_t bytes) { return fmt::format("{:.1f}", double(bytes) * 1e-6); }

std::string milliseconds_text(double ms) { return fmt::format("{:.{}f}", ms, ms < 99.95 ? 1 : 0); }

}  // namespace plumb::cli
