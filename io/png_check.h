// PNG files before OpenImageIO sees them: libpng prints there what it finds amiss. Private to io/.
#pragma once

#include <string>
#include <vector>

namespace plumb::io {

// Reads `file`, a whole PNG, once to its end with libpng; throws InputError with libpng's words for what it refuses.
void read_png_through(const std::string& path, const std::vector<unsigned char>& file);

}  // namespace plumb::io
