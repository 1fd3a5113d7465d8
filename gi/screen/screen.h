// Ambient occlusion by what the camera and the lights see (LRA, Haragas 2023). See gi/screen/README.md.
//
//     G-buffer --screen.ssao--> of the camera --screen.ssao--> and of each light's maps --screen.blur--> open share
//     G-buffer --screen.horizon--> of the camera --screen.blur--> open share
//     open share, indirect light --screen.occlude--> what compose reads
//     gathered light, the last frame --screen.reuse--> mean of frames
#pragma once

#include "gi/lend.h"
#include "gi/screen/blur.h"
#include "gi/screen/horizon.h"
#include "gi/screen/occlude.h"
#include "gi/screen/reuse.h"
#include "gi/screen/ssao.h"

namespace plumb::screen {

using plumb::explain;
using plumb::run;

}  // namespace plumb::screen
