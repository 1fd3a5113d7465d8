#include "io/random_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {

RandomFile::RandomFile(const std::string& path) : path_(path) {
    if (path.find('\0') != std::string::npos) throw InputError(shown(path), "", "the name holds a NUL");
    fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat status = {};
    const bool known = fd_ >= 0 && ::fstat(fd_, &status) == 0;
    const std::string cause = !known                     ? std::strerror(errno)
                              : !S_ISREG(status.st_mode) ? "it is not a regular file"
                                                         : "";
    size_ = status.st_size;
    if (cause.empty()) return;
    if (fd_ >= 0) ::close(fd_);
    throw InputError(shown(path), "", "cannot be read: " + cause);
}

RandomFile::~RandomFile() {
    if (mapped_) ::munmap(mapped_, std::size_t(size_));
    ::close(fd_);
}

void RandomFile::read(std::int64_t offset, std::size_t bytes, void* to) const {
    char* next = static_cast<char*>(to);
    while (bytes > 0) {
        const ssize_t n = ::pread(fd_, next, std::min<std::size_t>(bytes, 1 << 30), offset);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            throw InputError(shown(path_), fmt::format("byte {}", offset),
                             std::string("cannot be read: ") + std::strerror(errno));
        if (n == 0)
            throw InputError(shown(path_), fmt::format("byte {}", offset), "the file was cut while it was read");
        next += n, offset += n, bytes -= std::size_t(n);
    }
}

const unsigned char* RandomFile::map() {
    if (!mapped_ && size_ > 0) {
        void* mapped = ::mmap(nullptr, std::size_t(size_), PROT_READ, MAP_SHARED, fd_, 0);
        if (mapped == MAP_FAILED)
            throw InputError(shown(path_), "", std::string("cannot be mapped into memory: ") + std::strerror(errno));
        mapped_ = mapped;
    }
    return static_cast<const unsigned char*>(mapped_);
}

}  // namespace plumb::io
