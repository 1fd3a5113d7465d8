// How the passes store what they draw: a format for each buffer. A layout is data; kernels see fp32 or half records.
#pragma once

#include <string>

#include "core/formats.h"

namespace plumb::raster {

struct Layout {
    std::string name = "fp32";

    // The G-buffer. `depth` is linear eye depth, position's w.
    Format position = Format::rgba32f;
    Format normal = Format::rgba32f;
    Format albedo = Format::rgba32f;
    Format emission = Format::rgba32f;
    Format depth = Format::r32f;
    // ISR 4.3: positions are rebuilt from the stored depth instead of being stored.
    bool position_from_depth = false;

    // Reflective shadow maps.
    Format rsm_position = Format::rgba32f;
    Format rsm_normal = Format::rgba32f;
    Format rsm_flux = Format::rgba32f;
    Format rsm_depth = Format::r32f;

    // True where a texel record of the map fits halves without loss: a gather then reads 32 bytes a texel, not 64.
    bool half_records() const {
        return rsm_position == Format::rgba16f && rsm_normal == Format::rgba16f && rsm_flux == Format::rgba16f;
    }

    bool operator==(const Layout&) const = default;

    static const Layout fp32;     // nothing is rounded
    static const Layout rgba16f;  // VRSM fig. 4.2-4.4: every colour target is RGBA16F, rounded to nearest even
};

inline const Layout Layout::fp32{};
inline const Layout Layout::rgba16f{"rgba16f",       Format::rgba16f, Format::rgba16f, Format::rgba16f,
                                    Format::rgba16f, Format::r16f,    false,           Format::rgba16f,
                                    Format::rgba16f, Format::rgba16f, Format::r16f};

}  // namespace plumb::raster
