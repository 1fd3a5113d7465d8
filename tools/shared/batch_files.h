// Keeps results and files of long commands, so that one that is cut goes on where it was.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/shared/reports.h"

namespace plumb::cli {

// Hash of the program's own bytes: no build believes what another has measured.
std::uint64_t program_hash();

// Results as JSON, a file each, with the key of what they were made from. One that is broken or has another key counts
// as not there. Files are complete or not there at all.
class BatchResults {
  public:
    explicit BatchResults(std::string folder) : folder_(std::move(folder)) {}
    std::optional<Json> find(const std::string& name, std::uint64_t key) const;
    void keep(const std::string& name, std::uint64_t key, const Json& value) const;

  private:
    std::string path_of(const std::string& name) const { return folder_ + "/" + name + ".json"; }
    std::string folder_;
};

// Files of a step that lie in `folder`: made from the same key and unchanged since. The record is written last.
class BatchRecords {
  public:
    explicit BatchRecords(std::string folder) : folder_(std::move(folder)), results_(folder_ + "/made") {}
    // Whatever the step wrote down beside, where all files are there and hash as they did; none otherwise.
    std::optional<Json> find(const std::string& name, std::uint64_t key) const;
    void keep(const std::string& name, std::uint64_t key, const std::vector<std::string>& files,
              const Json& more = Json::object()) const;
    // For keys of steps that read what another made.
    std::uint64_t hash_of(const std::string& file) const;

  private:
    std::string folder_;
    BatchResults results_;
};

}  // namespace plumb::cli
