#include "tools/shared/reference_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <new>

#include "core/content_hash.h"
#include "core/error.h"
#include "io/bundle_file.h"
#include "io/file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* extension = ".reference";
constexpr std::uint64_t max_header = 1 << 16;  // of a bundle, its counts and its checksum; it has some hundred bytes

std::uint64_t picture_bytes(glm::ivec2 size) {
    return 2 * sizeof(glm::vec4) * std::uint64_t(size.x) * std::uint64_t(size.y);
}

// Words of 64 bits as the bundle's words of 32, low half first.
void add_words(Bundle& bundle, const char* name, const std::vector<std::uint64_t>& values) {
    std::vector<std::uint32_t> words;
    for (std::uint64_t v : values) {
        words.push_back(std::uint32_t(v));
        words.push_back(std::uint32_t(v >> 32));
    }
    add(bundle, name, {std::int64_t(values.size()), 2}, words.data());
}
std::vector<std::uint64_t> read_words(const Bundle& bundle, const char* name, std::int64_t count) {
    const std::span<const std::uint32_t> words = elements<std::uint32_t>(bundle, name, {count, 2});
    std::vector<std::uint64_t> values;
    for (std::size_t i = 0; i < words.size(); i += 2) values.push_back(words[i] | std::uint64_t(words[i + 1]) << 32);
    return values;
}

Image4 read_image(const Bundle& bundle, const char* name, glm::ivec2 size) {
    require(at(bundle, name), DType::f32, {size.y, size.x, 4});
    return image4(at(bundle, name));
}

Bundle bundle_of(std::uint64_t key, const reference::Kept& kept) {
    const reference::Estimate& e = kept.estimate;
    Bundle bundle;
    add_words(bundle, "key", {key});
    add_words(bundle, "counts", {std::uint64_t(e.samples), std::uint64_t(e.rounds), e.rays, e.nonfinite});
    const double numbers[] = {e.relative_error, kept.ms};
    add(bundle, "numbers", {2}, numbers);
    add(bundle, "mean", e.mean);
    add(bundle, "error", e.error);
    return bundle;
}

// Throws InputError where the bundle is not what bundle_of() makes.
reference::Kept kept_of(const Bundle& bundle, std::uint64_t key, glm::ivec2 size) {
    if (read_words(bundle, "key", 1)[0] != key) throw InputError("it is kept for another key");
    const std::vector<std::uint64_t> counts = read_words(bundle, "counts", 4);
    const std::span<const double> numbers = elements<double>(bundle, "numbers", {2});
    reference::Kept kept;
    kept.estimate = {read_image(bundle, "mean", size), read_image(bundle, "error", size), int(counts[0]),
                     int(counts[1]), counts[2], std::size_t(counts[3]), numbers[0]};
    kept.ms = numbers[1];
    return kept;
}

// Says in words what failed.
std::string cause_of(const std::exception& e) {
    return dynamic_cast<const std::bad_alloc*>(&e) ? "out of memory" : e.what();
}

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

}  // namespace

std::string cache_folder() {
    if (const std::string own = environment("PLUMB_CACHE"); !own.empty()) return own;
    if (const std::string xdg = environment("XDG_CACHE_HOME"); !xdg.empty()) return xdg + "/plumbline";
    if (const std::string home = environment("HOME"); !home.empty()) return home + "/.cache/plumbline";
    return "";
}

ReferenceFiles::ReferenceFiles(std::string folder, std::uint64_t max_bytes, std::uint64_t program)
    : folder_(std::move(folder)), max_bytes_(max_bytes), program_(program) {}

std::uint64_t ReferenceFiles::own_key(std::uint64_t key) {
    if (program_ == 0) {
        const std::vector<unsigned char> bytes = io::read_bytes("/proc/self/exe");
        program_ = content_hash(bytes.data(), bytes.size());
    }
    return content_hash(&key, sizeof key, program_);
}

std::string ReferenceFiles::path_of(std::uint64_t own_key) const {
    return folder_ + "/" + hash_text(own_key) + extension;
}

std::optional<reference::Kept> ReferenceFiles::find(std::uint64_t key, glm::ivec2 size) {
    std::string path;
    try {
        const std::uint64_t own = own_key(key);
        path = path_of(own);
        std::error_code error;
        if (!fs::exists(path, error)) return std::nullopt;
        // One that cannot be right is not even read.
        const std::uint64_t bytes = fs::file_size(path, error);
        const std::uint64_t most = std::min(picture_bytes(size), max_bytes_) + max_header;
        if (!error && bytes > most) throw InputError(fmt::format("{} bytes: expected at most {}", bytes, most));
        reference::Kept kept = kept_of(io::read_bundle(path), own, size);
        fs::last_write_time(path, fs::file_time_type::clock::now(), error);
        return kept;
    } catch (const std::exception& e) {
        const std::string cause = cause_of(e);
        notes_.push_back((cause.find(path) == 0 ? cause : path + ": " + cause) + "; traced anew");
        return std::nullopt;
    }
}

void ReferenceFiles::keep(std::uint64_t key, const reference::Kept& kept) {
    try {
        const std::uint64_t own = own_key(key);
        if (picture_bytes({kept.estimate.mean.width, kept.estimate.mean.height}) > max_bytes_) return;
        io::make_folder(folder_);
        io::write_bundle(path_of(own), bundle_of(own, kept));
        remove_oldest();
    } catch (const std::exception& e) {
        notes_.push_back(cause_of(e) + "; the reference is not kept");
    }
}

void ReferenceFiles::remove_oldest() const {
    struct File {
        fs::file_time_type used;
        fs::path path;
        std::uint64_t bytes;
    };
    std::vector<File> files;
    const fs::file_time_type yesterday = fs::file_time_type::clock::now() - std::chrono::hours(24);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        const std::string name = entry.path().filename().string();
        // Another run may have removed it since.
        std::error_code no_time, no_size;
        const File file{entry.last_write_time(no_time), entry.path(), entry.file_size(no_size)};
        if (no_time || no_size) continue;
        if (entry.path().extension() == extension) files.push_back(file);
        // What a run that was killed has left while it wrote.
        const bool part = name.find(std::string(extension) + ".") != std::string::npos && name.front() == '.';
        if (part && file.used < yesterday) fs::remove(file.path, no_time);
    }
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used > b.used; });
    std::uint64_t bytes = 0;
    std::error_code error;
    for (const File& file : files) {
        bytes += file.bytes;
        if (bytes > max_bytes_) fs::remove(file.path, error);
    }
}

}  // namespace plumb::cli
