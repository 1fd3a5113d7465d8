#include "io/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/error.h"
#include "io/part_file.h"

namespace plumb::io {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
    throw InputError(shown(path), "", what + ": " + std::strerror(error));
}

// A file descriptor that closes itself.
struct Descriptor {
    int fd = -1;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
};

// The names of files that are being written, where a handler of signals finds them.
std::array<std::atomic<const char*>, 64> unfinished{};

// Lists a temporary file until it has its final name; removes it if that never happens.
class Unfinished {
  public:
    explicit Unfinished(std::string name) : name_(std::move(name)) {
        for (std::atomic<const char*>& slot : unfinished) {
            const char* none = nullptr;
            if (slot.compare_exchange_strong(none, name_.c_str())) {
                slot_ = &slot;
                break;
            }
        }
    }
    Unfinished(const Unfinished&) = delete;
    Unfinished& operator=(const Unfinished&) = delete;
    ~Unfinished() {
        if (!renamed_) ::unlink(name_.c_str());
        if (slot_) *slot_ = nullptr;
    }
    const std::string& name() const { return name_; }
    void rename_to(const std::string& path) {
        if (::rename(name_.c_str(), path.c_str()) != 0) fail(path, "cannot be written", errno);
        renamed_ = true;
    }

  private:
    std::string name_;
    std::atomic<const char*>* slot_ = nullptr;
    bool renamed_ = false;
};

void write_all(int fd, std::string_view bytes, const std::string& path) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), 1 << 30));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(path, "cannot be written", errno);
        bytes.remove_prefix(std::size_t(n));
    }
}

// Into a device, a pipe or what a link names: a rename would put a file in their place. What is this process's standard
// output goes behind what is there: opened anew, both would write from the start.
void write_through(const std::string& path, const std::vector<std::string_view>& parts) {
    Descriptor file{::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666)};
    struct stat opened, output;
    if (file.fd < 0 || ::fstat(file.fd, &opened) != 0) fail(path, "cannot be written", errno);
    const bool is_output = ::fstat(STDOUT_FILENO, &output) == 0 && output.st_dev == opened.st_dev &&
                           output.st_ino == opened.st_ino;
    if (!is_output && S_ISREG(opened.st_mode) && ::ftruncate(file.fd, 0) != 0) fail(path, "cannot be written", errno);
    for (std::string_view part : parts) write_all(is_output ? STDOUT_FILENO : file.fd, part, path);
    const int status = ::close(file.fd);
    file.fd = -1;
    if (status != 0) fail(path, "cannot be written", errno);
}

// A new file beside `path` that is locked: remove_abandoned() tells it from one whose writer has ended.
class PartFile {
  public:
    explicit PartFile(const std::string& path) : path_(path), unfinished_(part_name(path)) {
        file_.fd = ::open(name().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file_.fd < 0) fail(path, "cannot be written", errno);
        // A file system without locks has nobody who could remove it for the want of one.
        const bool taken = ::flock(file_.fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        struct stat status;
        removed_ = taken || (::fstat(file_.fd, &status) == 0 && status.st_nlink == 0);
    }
    // Somebody who cleaned up was faster than the lock.
    bool removed() const { return removed_; }
    void write(std::string_view bytes) { write_all(file_.fd, bytes, path_); }
    // The lock is kept until the file has its name; what close() has to say comes before.
    void finish() {
        const Descriptor lock{::fcntl(file_.fd, F_DUPFD_CLOEXEC, 0)};
        const int status = ::close(file_.fd);
        file_.fd = -1;
        if (status != 0) fail(path_, "cannot be written", errno);
        unfinished_.rename_to(path_);
    }

  private:
    const std::string& name() const { return unfinished_.name(); }
    const std::string& path_;
    Unfinished unfinished_;
    Descriptor file_;
    bool removed_ = false;
};

template <class Bytes>
Bytes read_whole(const std::string& path, std::size_t limit) {
    if (path.find('\0') != std::string::npos) throw InputError(shown(path), "", "the name holds a NUL");
    const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file.fd < 0) fail(path, "cannot be read", errno);
    struct stat status;
    if (::fstat(file.fd, &status) != 0) fail(path, "cannot be read", errno);
    if (!S_ISREG(status.st_mode)) throw InputError(shown(path), "", "cannot be read: it is not a regular file");
    if (std::size_t(status.st_size) > limit)
        throw InputError(shown(path), "", fmt::format("has {} bytes; the limit is {}", status.st_size, limit));

    // A file that shrinks while it is read ends early; one that grows is read to its first size.
    Bytes bytes(std::size_t(status.st_size), 0);
    std::size_t have = 0;
    while (have < bytes.size()) {
        const ssize_t n = ::read(file.fd, bytes.data() + have, std::min<std::size_t>(bytes.size() - have, 1 << 30));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(path, "cannot be read", errno);
        if (n == 0) break;
        have += std::size_t(n);
    }
    bytes.resize(have);
    return bytes;
}

}  // namespace

std::vector<unsigned char> read_bytes(const std::string& path, std::size_t limit) {
    return read_whole<std::vector<unsigned char>>(path, limit);
}

std::string read_text(const std::string& path, std::size_t limit) { return read_whole<std::string>(path, limit); }

void write_file(const std::string& path, const std::vector<std::string_view>& parts) {
    struct stat there;
    if (::lstat(path.c_str(), &there) == 0 && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode))
        return write_through(path, parts);

    // Same folder, hence same file system: a rename replaces the old file in one step.
    for (int attempt = 0;; ++attempt) {
        PartFile part(path);
        if (part.removed() && attempt < 16) continue;
        for (std::string_view bytes : parts) part.write(bytes);
        return part.finish();
    }
}

void write_text(const std::string& path, const std::string& text) { write_file(path, {text}); }

void make_folder(const std::string& path) {
    std::error_code error;
    if (!path.empty()) std::filesystem::create_directories(path, error);
    if (error) throw InputError(shown(path), "", "the folder cannot be made: " + error.message());
    // create_directories() is content with a file of that name.
    if (!path.empty() && !std::filesystem::is_directory(path, error))
        throw InputError(shown(path), "", "the folder cannot be made: a file has its name");
}

void remove_unfinished_files() noexcept {
    for (std::atomic<const char*>& slot : unfinished)
        if (const char* name = slot) ::unlink(name);
}

std::string folder_of(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

std::string beside(const std::string& path, const std::string& name) {
    return (std::filesystem::path(path).parent_path() / name).string();
}

std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return extension;
}

std::string stem_of(const std::string& path) { return std::filesystem::path(path).stem().string(); }

std::string printable(std::string_view text, std::size_t limit) {
    std::string out;
    for (char c : text.substr(0, limit)) {
        const unsigned char byte = static_cast<unsigned char>(c);
        if (byte < 32 || byte == 127)
            out += fmt::format("\\x{:02x}", byte);
        else
            out += c;
    }
    return text.size() > limit ? out + "..." : out;
}

std::string shown(const std::string& path) { return printable(path, std::string::npos); }

}  // namespace plumb::io
