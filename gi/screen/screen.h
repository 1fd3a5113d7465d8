// Ambient occlusion and reflections by what the camera and the lights see (LRA, Haragas 2023). See gi/screen/README.md.
//
//     G-buffer --screen.ssao--> of the camera --screen.ssao--> and of each light's maps --screen.blur--> open share
//     G-buffer --screen.horizon--> of the camera --screen.blur--> open share
//     open share, indirect light --screen.occlude--> what compose reads
//     gathered light, the last frame --screen.reuse--> mean of frames
//
// And reflections:
//
//     G-buffer --screen.reflect--> hits in it --screen.reflect--> and in each light's maps
//     hits, the picture, what is known of them in the maps --screen.mirror--> the picture with them
#pragma once

#include "gi/lend.h"
#include "gi/screen/blur.h"
#include "gi/screen/cells.h"
#include "gi/screen/horizon.h"
#include "gi/screen/lobe.h"
#include "gi/screen/mirror.h"
#include "gi/screen/nearest.h"
#include "gi/screen/occlude.h"
#include "gi/screen/reflect.h"
#include "gi/screen/reuse.h"
#include "gi/screen/ssao.h"

namespace plumb::screen {

using plumb::explain;
using plumb::run;

}  // namespace plumb::screen
