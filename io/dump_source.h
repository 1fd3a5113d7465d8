// Dumped files as texels of up to four numbers, whatever they are stored as. Private to io/.
#pragma once

#include <memory>

#include "io/manifest.h"
#include "io/texel_format.h"

namespace plumb::io {

// Throws InputError "a.raw: <cause>".
[[noreturn]] void fail_dump(const DumpSpec& spec, const std::string& cause);

class DumpSource {
  public:
    virtual ~DumpSource() = default;

    int width = 0, height = 0;
    int channels = 0;                     // 1 to 4
    TexelKind kind = TexelKind::float32;  // how numbers are stored; of mixed ones the coarsest
    bool is_depth = false;
    bool keeps_shape = false;  // a .npy that is no image: one row of numbers, to be shaped as
    Shape shape;

    // n texels from (x, y) on, within the row: records of four numbers, those that are not there 0, 0, 0, 1. May be
    // called by several threads.
    virtual void read(int x, int y, int n, double* to) const = 0;

    // Of a file with a filling, as DumpedImage::unwritten: marks of n texels from (x, y) on. Nothing of the others is
    // marked.
    virtual void mark_unwritten(int, int, int, std::uint8_t*) const {}
    std::string absent;
};

// By `vk_format`, or else by the name's extension. Throws InputError; the sizes are those of the file, and those of raw
// files are checked.
std::unique_ptr<DumpSource> open_dump(const DumpSpec& spec);

// Its parts. A DDS that holds texels in one of our formats is a raw file with a header; null for the others.
std::unique_ptr<DumpSource> open_raw(const DumpSpec& spec);
std::unique_ptr<DumpSource> open_dds(const DumpSpec& spec);
std::unique_ptr<DumpSource> open_picture(const DumpSpec& spec);
std::unique_ptr<DumpSource> open_npy(const DumpSpec& spec);

}  // namespace plumb::io
