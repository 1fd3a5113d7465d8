// Tables as a terminal shows them.
#pragma once

#include <string>
#include <vector>

namespace plumb::cli {

enum class Align { left, right };

struct Column {
    std::string head;
    Align align = Align::left;
};

// Columns are as wide as their widest cell and two spaces apart; no line ends in a space. Heads that are all empty make
// no line. `indent` spaces stand before each line.
std::string format_table(const std::vector<Column>& columns, const std::vector<std::vector<std::string>>& rows,
                         int indent = 0);

// Enough digits to read a value back exactly: 9 for what was a float.
std::string exact_text(double value);
// Components side by side; each exact.
std::string exact_text(const std::vector<double>& values);

std::string megabytes_text(std::size_t bytes);
std::string milliseconds_text(double ms);

}  // namespace plumb::cli
