// How bundles and described files lie in a file: one header, one alignment, one checksum. Private to io/.
//
//     0   "PLUMBNDL"
//     8   u32 version of this layout
//     12  u32 start: where the arrays begin, a multiple of 64
//     16  u64 bytes of the file
//     24  header: JSON, blanks behind it
//     start - 8    u64 XXH64 of all before it
//     start        arrays, each followed by zeros up to a multiple of 64
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/described_file.h"
#include "io/random_file.h"

namespace plumb::io::bundle_layout {

// Where an array lies and what it has to be.
struct Extent {
    std::size_t offset = 0, bytes = 0, padded_bytes = 0;  // offset from the beginning of the file
    std::uint64_t checksum = 0;
};
struct Head {
    DescribedFile file;  // kind is empty for a bundle; arrays without bytes
    std::vector<Extent> extents;
};

// What stands before the arrays.
std::string head_bytes(const std::string& path, const DescribedFile& file);

// Reads and checks it; takes memory for nothing else. Throws InputError also where `kind` is not the file's; an empty
// one is that of a bundle.
Head read_head(const std::string& path, const RandomFile& bytes, const Kind& kind);

// Throws InputError unless the array and the zeros behind it are what was written: padded_bytes from `data` on.
void verify(const std::string& path, const Array& array, const Extent& extent, const unsigned char* data);

std::size_t aligned(std::size_t n);

}  // namespace plumb::io::bundle_layout
