#include "io/text_scan.h"

#include <charconv>
#include <limits>

namespace plumb::io {
namespace {

bool blank(char c) { return c == ' ' || c == '\t'; }

// from_chars() takes no sign but minus.
std::string_view without_plus(std::string_view word) {
    return word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
}

}  // namespace

bool LineScanner::next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
    line = text_.substr(at_, end - at_);
    at_ = end + (text_.substr(end, 2) == "\r\n" ? 2 : 1);
    ++number_;
    return true;
}

std::string_view next_word(std::string_view& line) {
    std::size_t first = 0;
    while (first < line.size() && blank(line[first])) ++first;
    std::size_t last = first;
    while (last < line.size() && !blank(line[last])) ++last;
    const std::string_view word = line.substr(first, last - first);
    line.remove_prefix(last);
    return word;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

std::optional<float> parse_float(std::string_view word) {
    word = without_plus(word);
    float value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size()) return {};
    if (error == std::errc()) return value;
    if (error != std::errc::result_out_of_range) return {};

    // Out of range is either end of it: 1 is far from both, so the number's distance from 1 tells which.
    double wide = 0;
    const bool in_double = std::from_chars(word.data(), word.data() + word.size(), wide).ec == std::errc();
    const bool tiny = in_double ? wide > -1 && wide < 1 : word.find("e-") != word.npos || word.find("E-") != word.npos;
    const bool negative = word[0] == '-';
    const float size = tiny ? 0.0f : std::numeric_limits<float>::infinity();
    return negative ? -size : size;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
    word = without_plus(word);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || error == std::errc::invalid_argument) return {};
    // Too many digits are an index that no list has.
    if (error != std::errc()) return std::numeric_limits<std::int64_t>::max() * (word[0] == '-' ? -1 : 1);
    return value;
}

}  // namespace plumb::io
