// A struct that is not its twin's block does not compile, and the compiler names the member.
#include "twins/raster.gbuffer.h"

struct Moved {
    float viewer[4], forward[3], pixel_area, eye[3], padding;
};
static_assert(plumb::twins::raster_gbuffer::fits<Moved>());
