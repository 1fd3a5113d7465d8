#include "tools/shared/process_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "core/error.h"
#include "gi/probes/memory.h"

namespace plumb::cli {

namespace {

// A line of /proc/self/status, in kB: "VmHWM", the most that was resident; "VmRSS", what is; "VmSize", what is mapped.
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

// The number behind `name` in a file of words; without a name the first one. Nothing where there is none.
std::optional<std::uint64_t> number_in(const std::string& path, const std::string& name = "") {
    std::ifstream file(path);
    std::uint64_t number = 0;
    for (std::string word; name.empty() || file >> word;)
        if (name.empty() || word == name) return file >> number ? std::optional(number) : std::nullopt;
    return {};
}

std::uint64_t left_of(const rlimit& limit, const char* taken) {
    if (limit.rlim_cur == RLIM_INFINITY) return no_limit;
    const std::uint64_t used = status_bytes(taken).value_or(0);
    return limit.rlim_cur > used ? limit.rlim_cur - used : 0;
}
std::uint64_t left_by_ulimit() {
    rlimit space{RLIM_INFINITY, RLIM_INFINITY}, data = space;
    getrlimit(RLIMIT_AS, &space), getrlimit(RLIMIT_DATA, &data);
    return std::min(left_of(space, "VmSize"), left_of(data, "VmData"));
}

// Of every group from the process' own up to the root: a line "0::/a/b", or of version 1 "5:memory:/a/b".
std::uint64_t left_by_groups() {
    std::uint64_t least = no_limit;
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string kinds = "," + line.substr(first + 1, second - first - 1) + ",";
        if (kinds != ",," && kinds.find(",memory,") == std::string::npos) continue;
        const std::string root = kinds == ",," ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        for (std::string path = line.substr(second + 1);; path.erase(path.rfind('/'))) {
            least = std::min(least, left_by_group(root + path).value_or(no_limit));
            if (path.find('/') == std::string::npos) break;
        }
    }
    return least;
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

std::optional<std::uint64_t> left_by_group(const std::string& folder) {
    struct Names {
        const char *limit, *used, *files;
    };
    for (const Names& names : {Names{"memory.max", "memory.current", "file"},
                               Names{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_cache"}}) {
        const std::optional<std::uint64_t> limit = number_in(folder + "/" + names.limit), used = number_in(folder + "/" + names.used);
        // Version 2 says "max" where there is none, version 1 a number of some 2^63.
        if (!limit || !used || *limit >= std::uint64_t(1) << 60) continue;
        const std::uint64_t files = std::min(number_in(folder + "/memory.stat", names.files).value_or(0), *used);
        return *limit - std::min(*limit, *used - files);
    }
    return {};
}

std::uint64_t memory_there() {
    const std::optional<std::uint64_t> kilobytes = number_in("/proc/meminfo", "MemAvailable:");
    return std::min({kilobytes ? *kilobytes * 1024 : no_limit, left_by_ulimit(), left_by_groups()});
}

void require_memory(const std::string& what, std::uint64_t needed, std::uint64_t there, const std::string& expected) {
    using probes::size_text;
    if (needed > there)
        throw InputError(fmt::format("{} needs about {} of memory; there are {}: {}", what, size_text(needed), size_text(there), expected));
    if (needed >= 1000000000) fmt::print(stderr, "{} needs about {} of memory\n", what, size_text(needed));
}

}  // namespace plumb::cli
