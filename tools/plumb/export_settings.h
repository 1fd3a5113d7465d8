// plumb export: what may not be changed in silence so that the stage asked for runs.
#pragma once

#include <string>
#include <vector>

#include "gi/frame/settings.h"
#include "tools/shared/options.h"

namespace plumb::cli {

// `asked` are the scene's settings and those of the command line, `running` those with which `stage` runs
// (frame::settings_running). Throws InputError where the latter replace one that the command line gives, and names the
// stage that runs with it; returns a note for each of the scene's that they replace.
std::vector<std::string> replaced_settings(const frame::Settings& asked, const frame::Settings& running,
                                           const std::string& stage, const SceneOptions& given);

// A sample pattern of a user's own that lies between texels is refused where its samples are whole texels away (rsm.texels
// = "whole"), in the words of `plumb validate`: a picture takes the nearest texels, a device is to be given what was asked.
void require_whole_rows(const frame::Settings& settings);

}  // namespace plumb::cli
