// Parameters that change nothing of a scene's frame, as its other parameters are.
#pragma once

#include <string>

#include "core/scene.h"
#include "gi/frame/settings.h"

namespace plumb::frame {

// Why that parameter changes nothing: "reflect.lobe is off"; empty where it does, or where nobody knows.
std::string idle(const Settings& settings, const Scene& scene, const std::string& table, const std::string& key);

}  // namespace plumb::frame
