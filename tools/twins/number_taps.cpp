// number_taps <preprocessed twin> <numbered twin> <names>
//
// Numbers the sites of TAP(name, value) in a twin's preprocessed text: the k-th becomes tap_value(k, value), as
// core/tap.glsl declares it, and the k-th line of <names> its name. A program of the build: the host reads names, a
// device writes numbers.
#include <cctype>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace {

bool in_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\n"), last = text.find_last_not_of(" \t\n");
    return first == text.npos ? "" : text.substr(first, last - first + 1);
}

// Where the parenthesis that opens at `open` is closed; `comma`: the first comma directly within it.
std::size_t closing(const std::string& text, std::size_t open, std::size_t& comma) {
    int depth = 0;
    comma = text.npos;
    for (std::size_t i = open; i < text.size(); ++i) {
        if (text[i] == '(') ++depth;
        if (text[i] == ',' && depth == 1 && comma == text.npos) comma = i;
        if (text[i] == ')' && --depth == 0) return i;
    }
    throw std::runtime_error("TAP( is not closed");
}

std::string numbered(const std::string& text, std::ostream& names) {
    std::string out;
    std::size_t copied = 0;
    int sites = 0;
    for (std::size_t at = text.find("TAP"); at != text.npos; at = text.find("TAP", at + 3)) {
        const std::size_t open = text.find_first_not_of(" \t\n", at + 3);
        if ((at > 0 && in_word(text[at - 1])) || open == text.npos || text[open] != '(') continue;
        std::size_t comma;
        const std::size_t close = closing(text, open, comma);
        if (comma == text.npos) throw std::runtime_error("TAP() takes a name and a value");
        names << trimmed(text.substr(open + 1, comma - open - 1)) << '\n';
        out += text.substr(copied, at - copied) + "tap_value(" + std::to_string(sites++) + "," +
               text.substr(comma + 1, close - comma);
        copied = at = close + 1;
    }
    return out + text.substr(copied);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "usage: number_taps <preprocessed twin> <numbered twin> <names>\n";
        return 2;
    }
    try {
        std::stringstream text;
        text << std::ifstream(argv[1]).rdbuf();
        if (!text) throw std::runtime_error("cannot be read, or is empty");
        std::ofstream out(argv[2]), names(argv[3]);
        out << numbered(text.str(), names);
        if (!out.flush() || !names.flush()) throw std::runtime_error("cannot write");
    } catch (const std::exception& e) {
        std::cerr << argv[1] << ": " << e.what() << '\n';
        return 1;
    }
}
