// EXR files before OpenEXR sees them: it takes memory for what a header says before it has looked whether the file holds
// it. Private to io/.
#pragma once

#include <string>
#include <vector>

namespace plumb::io {

// The header of `file`, which begins as an EXR does: each attribute is within the file and of the size of its type, and
// what the file declares (tables, blocks of lines, tiles) is no more than its bytes can hold. Throws InputError. Values
// that only make a picture a wrong one are left to OpenEXR.
void check_exr(const std::string& path, const std::vector<unsigned char>& file);

}  // namespace plumb::io
