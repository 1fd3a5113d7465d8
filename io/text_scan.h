// Lines, words and numbers of text files, with the place of each for messages. Private to io/.
//
// Numbers are read by std::from_chars: correctly rounded, the same on every machine, in no locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plumb::io {

// Walks through a text line by line. A line ends at \n, \r\n or \r.
class LineScanner {
  public:
    explicit LineScanner(std::string_view text) : text_(text) {}
    bool next(std::string_view& line);               // false after the last one
    std::int64_t number() const { return number_; }  // of the line last read, from 1

  private:
    std::string_view text_;
    std::size_t at_ = 0;
    std::int64_t number_ = 0;
};

// Takes the next word off the front of `line`; words are separated by blanks and tabs. Empty at the end.
std::string_view next_word(std::string_view& line);
std::string_view trimmed(std::string_view text);

// The whole word as a number: decimal, an optional exponent, nan and inf as such. What is too small becomes 0, what is
// too large infinite. None where it is not a number.
std::optional<float> parse_float(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace plumb::io
