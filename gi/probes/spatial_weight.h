#pragma once

namespace plumb::probes {

// By which a spatial receiver weighs radiance from an angle theta to its direction.
enum class SpatialWeight : int {
    corrected,  // cos(theta): irradiance, as any receiver's
    published,  // 1 - 2 theta / pi (IPR 4.1); of a radiance of 1 from everywhere it makes 2 pi - 4 = 2.283, not pi
};

}  // namespace plumb::probes
