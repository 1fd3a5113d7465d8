// embed_files <source> {<name> <file>}...
//
// Writes the C++ source that holds the files as text: what tools/page/embedded.h declares. A program of the build.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace {

// Three octal digits are the one escape that cannot run on into the character behind it.
void write_text(std::ostream& out, const std::string& text) {
    int column = 0;
    for (const char c : text) {
        if (column++ % 110 == 0) out << (column > 1 ? "\"\n    \"" : "\n    \"");
        char octal[5];
        std::snprintf(octal, sizeof octal, "\\%03o", static_cast<unsigned char>(c));
        const bool plain = c >= ' ' && c <= '~' && c != '"' && c != '\\' && c != '?';
        if (plain)
            out << c;
        else
            out << octal;
    }
    out << '"';
}

std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.empty()) throw std::runtime_error(path + ": cannot be read, or is empty");
    // It would end the element that holds it.
    for (const char* end : {"</script", "</style"})
        if (text.find(end) != text.npos) throw std::runtime_error(path + ": holds " + end);
    return text;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc % 2) {
        std::cerr << "usage: embed_files <source> {<name> <file>}...\n";
        return 2;
    }
    try {
        std::ofstream out(argv[1]);
        out << "#include \"tools/page/embedded.h\"\n\nnamespace plumb::page {\n\n";
        for (int i = 2; i < argc; i += 2) {
            const std::string text = read(argv[i + 1]);
            out << "const std::string_view " << argv[i] << "{";
            write_text(out, text);
            out << ", " << text.size() << "};\n\n";
        }
        out << "}  // namespace plumb::page\n";
        if (!out.flush()) throw std::runtime_error(std::string(argv[1]) + ": cannot be written");
    } catch (const std::exception& e) {
        std::cerr << e.what() << '\n';
        return 1;
    }
}
