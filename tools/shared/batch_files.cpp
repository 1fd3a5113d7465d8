#include "tools/shared/batch_files.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/content_hash.h"
#include "core/error.h"
#include "io/file.h"

namespace plumb::cli {

namespace {

std::uint64_t file_hash(const std::string& path) {
    const std::vector<unsigned char> bytes = io::read_bytes(path);
    return content_hash(bytes.data(), bytes.size());
}

}  // namespace

std::uint64_t program_hash() {
    static const std::uint64_t hash = file_hash("/proc/self/exe");
    return hash;
}

std::optional<Json> BatchResults::find(const std::string& name, std::uint64_t key) const {
    std::error_code error;
    if (!std::filesystem::exists(path_of(name), error)) return std::nullopt;
    try {
        const Json json = Json::parse(io::read_text(path_of(name)));
        if (json.at("key") != hash_text(key)) return std::nullopt;
        return json.at("value");
    } catch (const std::exception&) {
        return std::nullopt;  // it is made anew and written over
    }
}

void BatchResults::keep(const std::string& name, std::uint64_t key, const Json& value) const {
    io::make_folder(folder_);
    io::write_text(path_of(name), json_text({{"key", hash_text(key)}, {"value", value}}));
}

std::optional<Json> BatchRecords::find(const std::string& name, std::uint64_t key) const {
    const std::optional<Json> made = results_.find(name, key);
    if (!made) return std::nullopt;
    try {
        for (const auto& [file, hash] : made->at("files").items())
            if (hash_text(hash_of(file)) != hash) return std::nullopt;
        return made->at("more");
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

void BatchRecords::keep(const std::string& name, std::uint64_t key, const std::vector<std::string>& files,
                        const Json& more) const {
    Json hashes = Json::object();
    for (const std::string& file : files) hashes[file] = hash_text(hash_of(file));
    results_.keep(name, key, {{"files", hashes}, {"more", more}});
}

std::uint64_t BatchRecords::hash_of(const std::string& file) const { return file_hash(folder_ + "/" + file); }

}  // namespace plumb::cli
