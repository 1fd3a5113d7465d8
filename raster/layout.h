// How the passes store what they draw.
#pragma once

namespace plumb::raster {

enum class Layout : int {
    fp32,     // nothing is rounded
    rgba16f,  // VRSM fig. 4.2-4.4: every colour target is RGBA16F, rounded to nearest even when it is written
};

}  // namespace plumb::raster
