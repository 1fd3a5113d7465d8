// The resident memory of this process, where the system tells.
#pragma once

#include <cstddef>
#include <optional>

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

}  // namespace plumb::cli
