// Dumps in a folder, and what their names say, for `plumb validate --init`.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace plumb::cli {

struct DumpFile {
    std::filesystem::path path;                   // in the folder
    std::string group;               // its first subfolder, or ""
    std::vector<std::string> words;  // of its name
    bool in = false, out = false;    // lies in a folder of that name
    bool raw = false;
    std::size_t bytes = 0;
};

// "GBuffer_worldPos0" is gbuffer, world, pos.
std::vector<std::string> words_of(const std::string& text);

// How well a file's words name something: 0 where a word of the name is not among them, more for longer names, less for
// words that are left over.
double likeness(const std::vector<std::string>& words, const std::string& name);

// Sorted by their paths. `unread`: what looks like a dump and cannot be read, and why. Throws InputError.
std::vector<DumpFile> find_files(const std::filesystem::path& folder, std::map<std::string, std::string>& unread);

}  // namespace plumb::cli
