// The temporary files of write_file() (file.h), and what a writer that was killed has left of them.
#pragma once

#include <string>

namespace plumb::io {

// Where a file of that name is written before it is renamed: hidden beside it; it ends in ".part". It says on which machine, and
// is locked as long as its writer lives.
std::string part_name(const std::string& path);
// Removes what a writer that was killed has left under such a name: at once where it wrote on this machine, else when it is a day
// old. True where it did. A file that is being written stays.
bool remove_abandoned(const std::string& part) noexcept;

}  // namespace plumb::io
