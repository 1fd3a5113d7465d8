// How far a device may be from an input that its shader or its sampler decodes. The files' own numbers were decoded in
// double (io/dump_encoding.h).
#pragma once

#include <cstdint>
#include <unordered_map>

#include "core/bounded.h"
#include "io/manifest.h"

namespace plumb::cli {

// The curve of sRGB is slow, and most images have few codes.
using SrgbBounds = std::unordered_map<std::uint32_t, double>;

class InputDecoding {
  public:
    InputDecoding(const io::DumpSpec& spec, const io::DumpedImage& dump);

    // Whether anything is decoded at all.
    bool any() const { return vectors_ || srgb_ || depth_ >= 0 || shared_exponent_ || fixed_point_; }
    // v: four components, exact as they were read.
    void decode(Bounded* v, SrgbBounds& known) const;

  private:
    void decode_vector(Bounded* v) const;
    Bounded decoded_depth(double metres) const;

    const io::DumpSpec& spec_;
    bool vectors_, srgb_, shared_exponent_, fixed_point_;
    bool integer_depth_ = false;  // its code is converted to a float first
    int depth_ = -1;              // the component that an encoding of depth decodes
};

}  // namespace plumb::cli
