#include "tools/shared/file_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <utility>

#include "core/content_hash.h"
#include "core/error.h"
#include "io/bundle_file.h"
#include "io/file.h"
#include "io/part_file.h"

namespace plumb::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t max_header = 1 << 16;  // of a bundle, its names and its checksum
constexpr const char* key_name = ".key";       // of the array that holds it: two words of 32 bits, the low half first

Array key_array(graph::Key key) {
    Bundle one;
    const std::uint32_t words[] = {std::uint32_t(key), std::uint32_t(key >> 32)};
    return add(one, key_name, {1, 2}, words);
}

std::uint64_t bytes_of(const Bundle& bundle) {
    std::uint64_t bytes = 0;
    for (const Array& array : bundle.arrays) bytes += array.bytes.size();
    return bytes;
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

FileStore::FileStore(std::string folder, std::string kind, Limits limits)
    : folder_(std::move(folder)), kind_(std::move(kind)), limits_(std::move(limits)) {}

graph::Key FileStore::own_key(graph::Key key) {
    if (limits_.program == 0) {
        const std::vector<unsigned char> bytes = io::read_bytes("/proc/self/exe");
        limits_.program = content_hash(bytes.data(), bytes.size());
    }
    return content_hash(&key, sizeof key, limits_.program);
}

std::string FileStore::path_of(graph::Key key) { return folder_ + "/" + hash_text(own_key(key)) + "." + kind_; }

std::optional<Bundle> FileStore::find(graph::Key key, std::uint64_t most) {
    std::string path;
    try {
        remove_abandoned();
        path = path_of(key);
        std::error_code error;
        if (!fs::exists(path, error)) return std::nullopt;
        // One that cannot be right is not even read.
        const std::uint64_t bytes = fs::file_size(path, error);
        most = std::min(most, limits_.max_bytes) + max_header;
        if (!error && bytes > most) throw InputError(fmt::format("{} bytes: expected at most {}", bytes, most));
        Bundle bundle = io::read_bundle(path);
        const Array own = key_array(own_key(key));
        const Array* held = plumb::find(bundle, key_name);
        if (!held || held->shape != own.shape || held->dtype != own.dtype || !(held->bytes == own.bytes))
            throw InputError("it is kept for another key");
        std::erase_if(bundle.arrays, [](const Array& array) { return array.name == key_name; });
        fs::last_write_time(path, fs::file_time_type::clock::now(), error);
        used_.insert(path);
        return bundle;
    } catch (const std::exception& e) {
        const std::string cause = cause_of(e);
        notes_.push_back((cause.find(path) == 0 ? cause : path + ": " + cause) + "; " + limits_.made + " anew");
        return std::nullopt;
    }
}

void FileStore::keep(graph::Key key, const Bundle& bundle, const std::string& what) {
    try {
        if (bytes_of(bundle) > limits_.max_bytes)
            throw InputError(fmt::format("{} bytes are more than the limit of {}", bytes_of(bundle), limits_.max_bytes));
        Bundle file = bundle;
        file.arrays.push_back(key_array(own_key(key)));
        io::make_folder(folder_);
        remove_abandoned();
        const std::string path = path_of(key);
        io::write_bundle(path, file);
        used_.insert(path);
        make_room(fs::file_size(path));
    } catch (const std::exception& e) {
        notes_.push_back(cause_of(e) + fmt::format("; {} is not kept", what));
    }
}

bool FileStore::is_part(const fs::path& path) const {
    const std::string name = path.filename().string();
    return name.front() == '.' && name.ends_with(".part") && name.find("." + kind_ + ".") != std::string::npos;
}

void FileStore::remove_abandoned() {
    if (std::exchange(cleaned_, true)) return;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error))
        if (is_part(entry.path())) io::remove_abandoned(entry.path().string());
}

// To look through a folder of thousands of files takes as long as many a file that is kept there.
void FileStore::make_room(std::uint64_t written) {
    constexpr int most_unseen = 256;  // other programs write there as well
    if (written <= room_ && ++unseen_ < most_unseen)
        room_ -= written;
    else
        room_ = remove_oldest(), unseen_ = 0;
}

std::uint64_t FileStore::remove_oldest() const {
    struct File {
        fs::file_time_type used;
        fs::path path;
        std::uint64_t bytes;
        bool pinned;
    };
    std::vector<File> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        // Another run may have removed it since.
        std::error_code no_time, no_size;
        const File file{entry.last_write_time(no_time), entry.path(), entry.file_size(no_size),
                        pins_ && used_.contains(entry.path().string())};
        if (is_part(file.path)) io::remove_abandoned(file.path.string());
        if (no_time || no_size) continue;
        if (entry.path().extension() == "." + kind_) files.push_back(file);
    }
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) {
        return a.pinned != b.pinned ? a.pinned : a.used > b.used;
    });
    std::uint64_t bytes = 0;
    std::error_code error;
    for (const File& file : files) {
        bytes += file.bytes;
        if (bytes > limits_.max_bytes && !file.pinned) fs::remove(file.path, error);
    }
    return limits_.max_bytes - std::min(bytes, limits_.max_bytes);
}

}  // namespace plumb::cli
