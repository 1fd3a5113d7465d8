// What mutants run on: small frames that between them take every branch of every twin.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb::mutants {

struct Dispatch {
    std::string name;  // "cornell: rsm.disc.key"
    StageData data;
};

// Of every stage that has a twin, in the order in which a mutant runs on them. `source` is the project's root.
//
//     frames    every stage of the frames of tests/parity/panels.toml
//     by hand   twin_data.h of the parity tests, every variant
//     values    for compose and tonemap: images that span thirty powers of two, with zeros and negative numbers
//     surfaces  for the filters: pixels at two depths, up to the borders of an odd frame, and holes
std::vector<Dispatch> dispatches(const std::filesystem::path& source);

}  // namespace plumb::mutants
