// Changes of a file that keep what would else refuse it at once: checksums, lengths, the syntax of JSON.
#pragma once

#include <cstddef>
#include <cstdint>

#include "targets.h"

namespace plumb::fuzz {

// libFuzzer's own changes of bytes, in place; returns the new size.
using ChangeBytes = std::size_t (*)(std::uint8_t* data, std::size_t size, std::size_t limit);

// Changes a file of the target's format in place, in a way that the seed chooses; returns the new size, at most `limit`.
std::size_t mutate(Target target, ChangeBytes change, std::uint8_t* data, std::size_t size, std::size_t limit,
                   unsigned seed);

}  // namespace plumb::fuzz
