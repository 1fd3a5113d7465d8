// Whether two G-buffers show the same picture.
#pragma once

#include <string>

#include "raster/gbuffer.h"

namespace plumb::bench {

// Shares of all pixels.
struct Agreement {
    double covered = 0;   // by ours
    double coverage = 0;  // covered by one side alone
    double position = 0;  // further apart than 1 cm plus two units in the last place of a half
    double normal = 0;    // more than 5 degrees apart
    double albedo = 0;    // a channel more than 0.03 apart

    // A picture of the same scene differs at silhouettes alone; thin and small triangles have many.
    bool plausible() const;
    std::string text() const;  // one line
};

Agreement compare(const raster::GBuffer& ours, const raster::GBuffer& theirs);

}  // namespace plumb::bench
