// Text from files, made safe inside XML and HTML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plumb::page {

// Markup characters as entities; control characters, which XML 1.0 cannot hold, and bytes that are no UTF-8 as '?'.
// Tabs and line ends stay.
std::string escaped(std::string_view text);

std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace plumb::page
