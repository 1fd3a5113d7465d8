// Which triangle each pixel sees on a device of a given profile, and where in it: id, depth and barycentric coordinates
// to the bit (README.md, "Devices"). visibility.h is what exact arithmetic makes of the same positions.
#pragma once

#include "core/device_profile.h"
#include "core/isa.h"
#include "core/scene.h"
#include "raster/surfaces.h"
#include "raster/visibility.h"

namespace plumb::raster {

// As draw_visibility() with the same arguments, but as the device draws it: with clip positions, one a vertex, from
// pull_triangle.glsl, a viewport of the whole frame with depth 0 to 1, both faces, depth test "less" (reversed z:
// "greater") on a D32 buffer, and, with surfaces, a fragment stage that discards where a material's alpha is below its
// cutoff; with `behind` (visibility.h) it discards too what does not lie strictly farther. With Interpolation::ideal it is draw_visibility() itself. Throws InputError for a size outside
// 1..max_frame_side and for positions that are not finite.
void draw_device_visibility(const Geometry& geometry, const Surfaces* surfaces,
                            const Buffer<glm::vec4>& clip_positions, bool reversed_z, glm::ivec2 size,
                            const DeviceProfile& profile, const RunOptions& options, VisibilityBuffer& out,
                            const Image1* behind = nullptr);

}  // namespace plumb::raster
