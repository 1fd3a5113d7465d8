// embed_twins <source> {<name> <SPIR-V> <tapped SPIR-V> <names of taps> <choosing SPIR-V>}...
//
// A choosing twin "-" is none.
// Writes the C++ source that holds every twin: the table of tools/vulkan/embedded_twins.h. A program of the build.
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

std::vector<std::uint32_t> read_words(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    std::vector<std::uint32_t> words(bytes.size() / 4);
    if (words.empty() || bytes.size() % 4) throw std::runtime_error(path + ": not SPIR-V");
    std::memcpy(words.data(), bytes.data(), bytes.size());
    return words;
}

void write_words(std::ostream& out, const std::string& name, const std::string& path) {
    out << "constexpr std::uint32_t " << name << "[] = {";
    int column = 0;
    for (const std::uint32_t word : read_words(path)) out << (column++ % 8 ? "" : "\n   ") << ' ' << word << "u,";
    out << "\n};\n";
}

// Ends with a null, so that a twin without taps has an array, too.
void write_names(std::ostream& out, const std::string& name, const std::string& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path + ": cannot be read");
    out << "constexpr const char* " << name << "[] = {";
    for (std::string line; std::getline(file, line);) out << '"' << line << "\", ";
    out << "nullptr};\n";
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2 || (argc - 2) % 5) {
        std::cerr << "usage: embed_twins <source> "
                     "{<name> <SPIR-V> <tapped SPIR-V> <names of taps> <choosing SPIR-V>}...\n";
        return 2;
    }
    try {
        std::ofstream out(argv[1]);
        out << "#include \"tools/vulkan/embedded_twins.h\"\n\nnamespace plumb::vulkan {\nnamespace {\n\n";
        std::string table;
        for (int i = 2; i < argc; i += 5) {
            const std::string k = std::to_string((i - 2) / 5), choosing = argv[i + 4];
            write_words(out, "spirv" + k, argv[i + 1]);
            write_words(out, "tapped" + k, argv[i + 2]);
            write_names(out, "taps" + k, argv[i + 3]);
            if (choosing != "-") write_words(out, "choosing" + k, choosing);
            table += "    {\"" + std::string(argv[i]) + "\", spirv" + k + ", tapped" + k + ", " +
                     (choosing != "-" ? "choosing" + k : "{}") + ", taps" + k + "},\n";
        }
        out << "\nconstexpr EmbeddedTwin table[] = {\n" << table << "};\n\n}  // namespace\n\n"
            << "std::span<const EmbeddedTwin> embedded_twins() { return table; }\n\n}  // namespace plumb::vulkan\n";
        if (!out.flush()) throw std::runtime_error(std::string(argv[1]) + ": cannot be written");
    } catch (const std::exception& e) {
        std::cerr << e.what() << '\n';
        return 1;
    }
}
