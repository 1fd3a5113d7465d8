#include "tools/plumb/init_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "io/file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_files = 2000;

// Other words for the words of slots' names.
const std::vector<std::pair<std::string, std::vector<std::string>>> synonyms = {
    {"position", {"pos", "wpos", "worldpos", "world"}},
    {"normal", {"norm", "nrm", "nml"}},
    {"albedo", {"diffuse", "basecolor", "base", "reflectance"}},
    {"emission", {"emissive"}},
    {"irradiance", {"gi", "gather", "bounce", "lighting"}},
    {"visibility", {"shadow", "shadows", "lit"}},
    {"radiance", {"hdr", "color", "colour", "scene"}},
    {"display", {"ldr", "tonemapped", "final", "backbuffer"}},
    {"indirect", {"gi", "bounce"}},
    {"depth", {"zbuffer"}},
    {"map", {"rsm", "light"}},
    {"rsm", {"map"}},
    {"id", {"ids", "object", "objects"}},
};

// Textures and captures that no reader here knows.
const std::set<std::string> foreign = {"ktx", "ktx2", "jpg", "jpeg", "bmp", "tga", "webp", "gif", "rdc", "npz", "csv"};

// The same word, a plural, or the start of one: "pos" of "position".
bool alike(const std::string& word, const std::string& term) {
    return word == term || (term.size() >= 3 && word.starts_with(term)) || (word.size() >= 3 && term.starts_with(word));
}

bool means(const std::string& word, const std::string& term) {
    if (alike(word, term)) return true;
    for (const auto& [name, others] : synonyms)
        if (name == term && std::find(others.begin(), others.end(), word) != others.end()) return true;
    return false;
}

}  // namespace

std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words(1);
    bool lower = false;
    for (char c : text) {
        const bool upper = c >= 'A' && c <= 'Z';
        const bool letter = upper || (c >= 'a' && c <= 'z');
        if (!letter || (upper && lower)) words.emplace_back();
        if (letter) words.back() += upper ? char(c - 'A' + 'a') : c;
        lower = letter && !upper;
    }
    std::erase_if(words, [](const std::string& w) { return w.empty(); });
    return words;
}

double likeness(const std::vector<std::string>& words, const std::string& name) {
    const std::vector<std::string> terms = words_of(name);
    double score = 0;
    for (const std::string& term : terms) {
        double best = 0;
        for (const std::string& word : words)
            best = std::max(best, word == term ? 1.0 : means(word, term) ? 0.75 : 0.0);
        if (best == 0) return 0;
        score += best;
    }
    return score - 0.01 * double(words.size());
}

std::vector<DumpFile> find_files(const fs::path& folder, std::map<std::string, std::string>& unread) {
    const std::set<std::string> pictures = {"exr", "pfm", "hdr", "tif", "tiff", "dds", "png", "npy"};
    const std::set<std::string> raws = {"bin", "raw", "dat"};
    std::vector<DumpFile> files;
    std::error_code error;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
    for (; !error && at != end; at.increment(error)) {
        // Nor is anything dumped in expected/, where an export keeps the answer.
        if (at.depth() > 2 || at->path().filename() == "expected") at.disable_recursion_pending();
        const std::string extension = io::extension_of(at->path().string());
        std::error_code ignored;
        if (!at->is_regular_file(ignored)) continue;
        if (foreign.count(extension))
            unread[at->path().lexically_relative(folder).string()] =
                "." + extension + " is not read; expected .exr .pfm .hdr .tif .dds .png .npy, or raw texels as .bin .raw .dat";
        if (!pictures.count(extension) && !raws.count(extension)) continue;
        if (files.size() == most_files)
            throw InputError(io::shown(folder.string()), "", fmt::format("holds more than {} dumps", most_files));
        DumpFile file;
        file.path = at->path().lexically_relative(folder);
        file.words = words_of(file.path.stem().string());
        file.raw = raws.count(extension) > 0;
        file.bytes = std::size_t(at->file_size(ignored));
        std::vector<std::string> folders;
        for (const fs::path& part : file.path.parent_path()) folders.push_back(part.string());
        if (!folders.empty()) file.group = folders.front();
        for (const std::string& name : folders) {
            file.in |= name == "in" || name == "input" || name == "inputs";
            file.out |= name == "out" || name == "output" || name == "outputs";
        }
        files.push_back(std::move(file));
    }
    if (error) throw InputError(io::shown(folder.string()), "", "cannot be read: " + error.message());
    std::sort(files.begin(), files.end(), [](const DumpFile& a, const DumpFile& b) { return a.path < b.path; });
    return files;
}

}  // namespace plumb::cli
