// What became of each mirrored ray of a frame, held against rays that meet the scene itself.
#pragma once

#include <array>

#include "gi/frame/frame.h"

namespace plumb::frame {

// Right: the triangle that the true ray meets, on the side that it meets, and at most a texel off where that point lies in
// the view. Visible: the view's texel there shows that triangle from that side.
enum class MirrorClass : int {
    none,           // no mirror
    right,          // met in the camera's picture
    wrong,          // something else was met there
    missed,         // visible there, and not met
    right_in_map,   // not visible there; met in a light's map
    wrong_in_map,   // something else was met in a map
    missed_in_map,  // visible in a map alone, and not met
    unseen,         // visible nowhere, and nothing was met
    open,           // there is nothing to meet, and nothing was met
    right_in_layer,   // not met in the picture; met in a layer behind it
    wrong_in_layer,   // something else was met in a layer
    missed_in_layer,  // not visible in the picture but in a layer, and not met
};
inline constexpr int mirror_classes = 12;
// Of each: "right", "missed_in_map".
const char* name_of(MirrorClass of);

struct MirrorClasses {
    Image1 of_pixel;  // as the enumeration counts them
    std::array<std::int64_t, mirror_classes> count{};
    std::int64_t mirrors() const;  // pixels that are one
};

// Of a frame with reflections that was executed; a ray a mirror's pixel, exact or native as settings.reference has it. A
// hit in a layer or a map where the camera missed what it sees is right or wrong there.
MirrorClasses classify_mirrors(const Scene& scene, const Settings& settings, const Frame& frame, const RunOptions& options);

}  // namespace plumb::frame
