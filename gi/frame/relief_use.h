// What normal maps, highlights and static lamps ask of a frame of the method probes (gi/probes/README.md, "Relief").
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"
#include "gi/frame/settings.h"

namespace plumb::frame {

// What the settings ask for and the scene has.
struct ReliefUse {
    bool volume = false;      // there are spatial receivers to ask
    bool dynamic = false;     // something moves that they light
    bool maps = false;        // a static surface with a normal map
    bool fixed = false;       // a static surface with a normal map or a highlight
    bool highlights = false;  // any surface with a highlight
    bool layers = false;      // of figure 5.20
    // Something that probes.relief changes.
    bool any() const { return highlights || (volume && maps); }
    // A G-buffer without normal maps is drawn.
    bool draws_plain() const { return layers || (fixed && maps); }
};
ReliefUse relief_use(const Scene& scene, const Settings& settings);

// Whether everything is drawn as if no material had a normal map.
bool drops_normal_maps(const Settings& settings);

// [light]: whether it is one of `static_lamps`. Empty: none is.
std::vector<bool> static_lamps(const Scene& scene, const Settings& settings);
// Throws InputError for a name that no lamp has, and where what moves would be dark: without spatial receivers.
void check_static_lamps(const Scene& scene, const Settings& settings);

}  // namespace plumb::frame
