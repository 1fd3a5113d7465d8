// DDS and BMP before OpenImageIO sees them: its readers believe these headers, or fail at what they allow. Private to io/.
#pragma once

#include <string>
#include <vector>

namespace plumb::io {

// Throw InputError. What is cut off or wrong otherwise is left to OpenImageIO.
void check_dds(const std::string& path, const std::vector<unsigned char>& file);
void check_bmp(const std::string& path, const std::vector<unsigned char>& file);

}  // namespace plumb::io
