#include "tools/shared/process_memory.h"

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>

namespace plumb::cli {

namespace {

// A line of /proc/self/status, in kB: "VmHWM", the most that was resident; "VmRSS", what is.
std::optional<std::size_t> status_bytes(const char* name) {
    std::FILE* file = std::fopen("/proc/self/status", "r");
    if (!file) return std::nullopt;
    char line[256];
    std::optional<std::size_t> bytes;
    const std::size_t length = std::strlen(name);
    while (std::fgets(line, sizeof line, file)) {
        std::size_t kilobytes = 0;
        if (std::strncmp(line, name, length) == 0 && line[length] == ':' &&
            std::sscanf(line + length + 1, "%zu", &kilobytes) == 1)
            bytes = kilobytes * 1024;
    }
    std::fclose(file);
    return bytes;
}

// "5" to clear_refs sets the most that was resident to what is (proc(5)); kernels without CONFIG_PROC_PAGE_MONITOR have
// no such file.
bool reset_peak() {
    const int file = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    if (file < 0) return false;
    const bool done = write(file, "5", 1) == 1;
    close(file);
    return done;
}

}  // namespace

MemoryPeak::MemoryPeak() {
    malloc_trim(0);
    if (reset_peak()) before_ = status_bytes("VmRSS");
}

std::optional<std::size_t> MemoryPeak::peak_bytes() const {
    const std::optional<std::size_t> peak = status_bytes("VmHWM");
    if (!before_ || !peak) return std::nullopt;
    return *peak > *before_ ? *peak - *before_ : 0;
}

}  // namespace plumb::cli
