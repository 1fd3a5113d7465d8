// Arrays in NumPy's own file format (.npy, versions 1 to 3): little-endian, C order, the types of core/bundle.h.
#pragma once

#include <string>

#include "core/bundle.h"

namespace plumb::io {

// Named after the file's stem. Throws InputError that names file, place and cause.
Array read_npy(const std::string& path);
void write_npy(const std::string& path, const Array& array);
// The same from where the numbers lie: `data` holds as many as `shape` has.
void write_npy(const std::string& path, DType dtype, const Shape& shape, const void* data);

}  // namespace plumb::io
