// The stiff and extreme cases (verification.md 4 has the list): each makes inputs that are hard in one way. See
// cases.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/binding.h"
#include "core/scene.h"
#include "gi/frame/settings.h"

namespace plumb::stability {

// The scene runs through a frame, and every stage of it is looked at. `edit` then changes a dispatch's data to what no
// rasterizer would hand over (points at distance 0, denormals); it returns false where that means nothing to the stage.
struct Case {
    std::string name;     // "scale 1e-4", "light ratio 1e8": as a column's head
    std::string group;    // "scale", "light": columns of a group stand together
    std::string meaning;  // one sentence
    std::function<Scene()> scene;
    std::function<void(frame::Settings&)> settings = nullptr;  // none: the defaults
    std::function<bool(StageData&)> edit = nullptr;            // none: the frame's own data
};

const std::vector<Case>& cases();

// The parameters of every stage in that case: the scene's own, with 50 samples a pixel where nothing else is asked.
frame::Settings case_settings(const Case& c, const Scene& scene);

}  // namespace plumb::stability
