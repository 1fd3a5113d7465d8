// Whether a file that takes hours to compute could be written.
#pragma once

#include <string>

namespace plumb::cli {

// Throws InputError that names the file where its folder takes no new file of a name as long as io::write_file() has for it. Asks
// nothing of devices and links. Removes what runs that were killed while they wrote this file have left (io/part_file.h).
void require_place(const std::string& file);

}  // namespace plumb::cli
