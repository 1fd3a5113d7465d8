#include "io/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {
namespace {

// Eight digits of what this start of this machine is called; processes of one machine can tell each other's locks.
const std::string& machine() {
    static const std::string name = [] {
        std::string id;
        std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
        return id.substr(0, 8);
    }();
    return name;
}

struct Descriptor {
    int fd = -1;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
};

}  // namespace

std::string part_name(const std::string& path) {
    static std::atomic<unsigned> counter{0};
    const std::string name = std::filesystem::path(path).filename().string();
    if (name.empty()) throw InputError(shown(path), "", "cannot be written: it names no file");
    return beside(path, fmt::format(".{}.{}-{}-{}.part", name, machine(), ::getpid(), counter++));
}

bool remove_abandoned(const std::string& part) noexcept try {
    const Descriptor file{::open(part.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)};
    struct stat status;
    if (file.fd < 0 || ::fstat(file.fd, &status) != 0 || !S_ISREG(status.st_mode)) return false;
    const bool locks = ::flock(file.fd, LOCK_EX | LOCK_NB) == 0;
    if (!locks && errno == EWOULDBLOCK) return false;  // it is being written
    const std::string name = std::filesystem::path(part).stem().string();
    const bool own = locks && !machine().empty() && name.find("." + machine() + "-") != std::string::npos;
    const auto day = std::chrono::hours(24);
    std::error_code error;
    if (!own && std::filesystem::last_write_time(part, error) > std::filesystem::file_time_type::clock::now() - day) return false;
    return !error && ::unlink(part.c_str()) == 0;
} catch (const std::exception&) {
    return false;
}

}  // namespace plumb::io
