// Image-space radiosity (ISR, Rohleder 2010): one bounce or more of diffuse light, and ambient occlusion, from what the
// camera sees alone. See gi/isr/README.md.
//
//     G-buffer, direct --isr.downsample--> surface, radiosity, reflectance      a quarter of the pixels
//     surface, radiosity --isr.gather--> irradiance --isr.bounce--> radiosity --isr.gather--> ...
//     surface, irradiance --isr.ssao--> irradiance and accessibility --isr.blur (horizontal, vertical)-->
//     --isr.upsample--> every pixel --isr.compose--> radiance
//
// A coarse pixel (x, y) stands for the full pixels (2 x, 2 y) .. (2 x + 1, 2 y + 1); its centre is their common corner.
// The buffer that goes through the chain is ISR_4 of Listing 6: xyz irradiance, w accessibility.
#pragma once

#include "gi/isr/blur.h"
#include "gi/isr/bounce.h"
#include "gi/isr/compose.h"
#include "gi/isr/downsample.h"
#include "gi/isr/gather.h"
#include "gi/isr/gather_camera.h"
#include "gi/isr/ssao.h"
#include "gi/isr/unseen.h"
#include "gi/isr/upsample.h"
#include "gi/lend.h"

namespace plumb::isr {

using plumb::explain;
using plumb::run;

// Where form factors sum to more than 1.
struct Excess {
    double share = 0;    // of the pixels with a surface
    double largest = 0;  // sum F
};
Excess excess_of(const Image4& surface, const Image4& gathered);

}  // namespace plumb::isr
