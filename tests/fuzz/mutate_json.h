// Changes of a JSON document that is one before and after.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace plumb::fuzz {

// None where the text is no JSON.
std::optional<std::string> mutate_json(const std::string& text, std::uint32_t seed);

}  // namespace plumb::fuzz
