// What the numbers of a dumped image stand for: packed normals, depth, shared exponents. Private to io/.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/fields.h"
#include "io/manifest.h"
#include "io/texel_format.h"

namespace plumb::io {

enum class Encoding {
    // Component by component.
    plain,
    integer,
    biased,
    srgb,
    // Vectors and colours.
    octahedral,
    octahedral_unorm,
    hemi_xy,
    hemi_xy_unorm,
    rgbe,
    // Depth to linear eye depth.
    depth,
    reversed_depth,
    depth_gl,
    linear_depth,
};

const std::vector<std::string>& encoding_names();  // in the enumeration's order
Encoding parse_encoding(const std::string& name);  // one of the names

// How many components it takes, always from x on; 0: as many as there are.
int encoded_components(Encoding encoding);
// What it makes of them: bit c for component c; 0: as they were. A depth goes where `channels` has put it.
unsigned decoded_mask(Encoding encoding);
bool is_depth(Encoding encoding);

// Where a component of the result comes from: a component of the file, a constant, or nowhere.
struct Pick {
    int from = 0;
    static constexpr int zero = 4, one = 5, absent = 6;
};
std::vector<Pick> parse_channels(const std::string& channels);  // of a string that fault_of() has passed

// Decodes one record of four in place. `picks` of component-wise encodings leave constants alone.
void decode_record(Encoding encoding, const std::vector<Pick>& picks, const std::vector<double>& near_far, double* v);

// At least the slope of the sRGB curve at an encoded x.
double srgb_slope(double x);

// How the device rounded what it wrote, seen through the decoding: a format that says so, or, where none does, one that
// is at least as coarse, and that the rounding is to be told value by value.
struct StoredAs {
    Format format = Format::rgba32f;
    bool by_value = false;
    double lowest = -unbounded, highest = unbounded;  // to which it was clamped before
};
StoredAs stored_as(TexelKind kind, bool is_depth, Encoding encoding, const std::vector<Pick>& picks);

// What is wrong with a description by itself.
struct SpecFault {
    std::string key, cause;
};
std::optional<SpecFault> fault_of(const DumpSpec& spec);

}  // namespace plumb::io
