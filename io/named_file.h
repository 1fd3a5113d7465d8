// Files that an OBJ or an MTL names, as other programs and systems write names. Private to io/.
#pragma once

#include <string>
#include <string_view>

#include "io/findings.h"

namespace plumb::io {

// The path of the file that the file `path` names: beside it, else in `second_folder`; as it stands or with \ for /. "" where
// there is none.
std::string find_named(const std::string& path, std::string_view name, const std::string& second_folder);

// As above, else by the name's last part alone, else by that in letters of another case, which goes to `findings` with the
// line that has the name.
std::string find_similar(const std::string& path, std::int64_t line, std::string_view name, const std::string& second_folder,
                         Findings& findings);

// Text as UTF-8: a byte order mark goes, UTF-16 is turned. Throws InputError for UTF-16 that is cut off or malformed.
std::string as_utf8(const std::string& path, std::string text);

}  // namespace plumb::io
