// A file that is read in pieces, from any thread. Private to io/.
//
// Dumps have gigabytes, of which a row is needed at a time. They are not mapped into memory: a mapping would fault the
// process when the file is cut while it is read, and pread() costs one copy of a row that is in the cache anyway. What
// io/ publishes by renaming nobody cuts: that can be mapped.
#pragma once

#include <cstdint>
#include <string>

namespace plumb::io {

class RandomFile {
  public:
    // Throws InputError: missing, not a regular file, unreadable.
    explicit RandomFile(const std::string& path);
    RandomFile(const RandomFile&) = delete;
    RandomFile& operator=(const RandomFile&) = delete;
    ~RandomFile();

    std::int64_t size() const { return size_; }  // when it was opened
    // Throws InputError where the file ends before offset + bytes.
    void read(std::int64_t offset, std::size_t bytes, void* to) const;
    // All bytes, to be read while this object lives. Throws InputError.
    const unsigned char* map();

  private:
    std::string path_;
    int fd_ = -1;
    std::int64_t size_ = 0;
    void* mapped_ = nullptr;
};

}  // namespace plumb::io
