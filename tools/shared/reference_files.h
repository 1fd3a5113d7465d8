// Kept references: one file each in the user's cache folder, named after their key.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gi/reference/cache.h"
#include "tools/shared/file_store.h"

namespace plumb::cli {

// Estimates of the path tracer in a FileStore: one larger than its picture is not even read.
class ReferenceFiles : public reference::Store {
  public:
    // As FileStore::Limits has them.
    explicit ReferenceFiles(std::string folder, std::uint64_t max_bytes = std::uint64_t(4) << 30,
                            std::uint64_t program = 0);

    std::optional<reference::KeptEstimate> find(std::uint64_t key, glm::ivec2 size) override;
    void keep(std::uint64_t key, const reference::KeptEstimate& kept) override;

    // What its user has to know: one line each.
    const std::vector<std::string>& notes() const { return files_.notes(); }

  private:
    FileStore files_;
    std::uint64_t max_bytes_;
};

}  // namespace plumb::cli
