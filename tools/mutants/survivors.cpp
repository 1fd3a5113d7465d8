#include "tools/mutants/survivors.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "io/document.h"

namespace plumb::mutants {
namespace {

const std::vector<std::string> sort_names{"equivalent", "unreached", "missed"};

std::string required(io::DocumentReader& reader, const std::string& key) {
    if (!reader.has(key)) throw InputError(reader.place() + ": a survivor needs " + key);
    return reader.filled(key, "");
}

Survivor read_survivor(const io::DocumentValue& table, const std::string& path) {
    io::DocumentReader reader(table, path, "survivor");
    Survivor s;
    s.place = reader.place();
    s.file = reader.filled("file", "");
    s.function = required(reader, "function");
    s.text = reader.filled("text", "");
    std::istringstream words(reader.filled("change", ""));
    for (std::string word; words >> word;) s.changes.push_back(find_change(word, s.place));
    const std::string sort = required(reader, "sort");
    const auto known = std::find(sort_names.begin(), sort_names.end(), sort);
    if (known == sort_names.end()) reader.fail("sort", "must be equivalent, unreached or missed");
    s.sort = Sort(known - sort_names.begin());
    s.reason = required(reader, "reason");
    reader.finish();
    return s;
}

}  // namespace

const char* sort_name(Sort sort) { return sort_names[std::size_t(sort)].c_str(); }

bool Survivor::matches(const Site& site) const {
    return (file.empty() || site.place.file == file) && site.place.function == function && (text.empty() || site.place.text == text) &&
           (changes.empty() || std::find(changes.begin(), changes.end(), site.change) != changes.end());
}

std::vector<Survivor> read_survivors(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file + ": cannot be read");
    std::ostringstream text;
    text << in.rdbuf();
    const std::string path = std::filesystem::path(file).filename().string();
    const io::DocumentValue document = io::parse_document(path, text.str());
    io::DocumentReader reader(document, path, "");
    std::vector<Survivor> out;
    for (const io::DocumentValue* table : reader.tables("survivor")) out.push_back(read_survivor(*table, path));
    reader.finish();
    return out;
}

}  // namespace plumb::mutants
