// Runs of the program that end before it does.
#pragma once

#include <cstdint>
#include <functional>

#include "tests/program/program.h"

namespace plumb::program {

// Kills it (SIGKILL) so many seconds after `reached` first says true, if it has not ended by itself: exit is 137 then.
Result run_and_kill(const std::vector<std::string>& arguments, double seconds, const std::function<bool()>& reached);

// On a disk that is full after `bytes` of any one file.
Result run_on_full_disk(const std::vector<std::string>& arguments, std::uint64_t bytes);

// With so many bytes of address space (ulimit -v).
Result run_within(const std::vector<std::string>& arguments, std::uint64_t bytes);

}  // namespace plumb::program
