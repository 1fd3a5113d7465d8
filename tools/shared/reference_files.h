// Kept references: one file each in the user's cache folder, named after their key.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gi/reference/cache.h"

namespace plumb::cli {

// $PLUMB_CACHE, else $XDG_CACHE_HOME/plumbline, else ~/.cache/plumbline; empty where none of the three is set.
std::string cache_folder();

// A file is a bundle with a checksum (io/bundle_file.h) that holds its key again. One that is broken or belongs to
// another key is never believed, one larger than its picture not even read: it counts as not there, is written anew,
// and notes() says so. Whatever fails is a note. The key includes the bytes of the program itself, so that no build
// believes what another has traced.
class ReferenceFiles : public reference::Store {
  public:
    // Of all files at most `max_bytes` are kept, those that were used last. `program`: what stands for the program in
    // the key; 0: its own bytes. Another is for who keeps estimates in a folder of his own and says for how long.
    explicit ReferenceFiles(std::string folder, std::uint64_t max_bytes = std::uint64_t(4) << 30,
                            std::uint64_t program = 0);

    std::optional<reference::Kept> find(std::uint64_t key, glm::ivec2 size) override;
    void keep(std::uint64_t key, const reference::Kept& kept) override;

    // What its user has to know: one line each.
    const std::vector<std::string>& notes() const { return notes_; }

  private:
    std::uint64_t own_key(std::uint64_t key);
    std::string path_of(std::uint64_t own_key) const;
    void remove_oldest() const;

    std::string folder_;
    std::uint64_t max_bytes_, program_ = 0;
    std::vector<std::string> notes_;
};

}  // namespace plumb::cli
