// plumb_mutants --generic: runs generic mutants, and says which survive and why.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumb::mutants {

struct GenericOptions {
    std::string source, glslang, device, profile;
    std::string survivors = PLUMB_SOURCE_DIR "/tests/parity/mutants/generic/survivors.toml";
    std::vector<std::string> stages;  // empty: all
    std::string seed = "0";
    int sample = 0, threads = 0;
    bool list = false, json = false;
};

// What --seed says: a number, or "commit" for that of the commit that `source` is checked out at (0 where it is none).
// Throws InputError for another word.
std::uint64_t seed_of(const std::string& seed, const std::string& source);

// Exit code: 1 where a mutant survives that the list does not name, and, unless it is a sample or some stages alone, where
// an entry of the list fits no survivor or less than 95 % of what can be found is.
int run_generic(const GenericOptions& options);

}  // namespace plumb::mutants
