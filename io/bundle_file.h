// Bundles of named arrays in one file with a checksum. io/README.md has the layout.
#pragma once

#include <string>

#include "core/bundle.h"

namespace plumb::io {

// The same bundle is the same bytes. Throws InputError.
void write_bundle(const std::string& path, const Bundle& bundle);

// Throws InputError that names file, place and cause; a byte that was cut off, added or changed is always seen.
Bundle read_bundle(const std::string& path);

}  // namespace plumb::io
