// The memory of this process, where the system tells: what it takes, and what it may still take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace plumb::cli {

// Measures the growth between its making and peak_bytes(). Memory that was freed before is given back first, so that it
// is not used again unseen.
class MemoryPeak {
  public:
    MemoryPeak();
    // The most that was resident since, above what was resident then; nothing where the system does not tell.
    std::optional<std::size_t> peak_bytes() const;

  private:
    std::optional<std::size_t> before_;
};

inline constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();

// Bytes that may still be taken: the least of what the machine has (MemAvailable), what ulimit leaves (RLIMIT_AS, RLIMIT_DATA)
// and what the control groups of the process leave. no_limit where the system tells of none.
std::uint64_t memory_there();

// What a control group leaves, version 2 or 1, by its folder below /sys/fs/cgroup: its limit less what is used, but for files
// that are kept in memory, which give way. Nothing where it has no limit.
std::optional<std::uint64_t> left_by_group(const std::string& folder);

// Says on standard error, from 1 GB on, how much memory `what` needs, and throws InputError where less is there:
// "WHAT needs about 21.3 GB of memory; there are 6.0 GB: EXPECTED".
void require_memory(const std::string& what, std::uint64_t needed, std::uint64_t there, const std::string& expected);

}  // namespace plumb::cli
