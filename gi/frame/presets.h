// Set-ups that a document describes, whole: what its author rendered with, as settings by name.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::frame {

struct Preset {
    std::string name;
    std::string meaning;            // one line
    std::vector<Setting> settings;  // every setting that its chain reads, be it a default or not; [render] method and layout first
};
const std::vector<Preset>& presets();

// Throws InputError at `place` that names the nearest.
const Preset& find_preset(const std::string& name, const std::string& place);

}  // namespace plumb::frame
