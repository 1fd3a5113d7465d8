// Gathers one pixel from a map of one texel. A light of flux Phi that faces the pixel from d above sends Phi / (pi d^2),
// VRSM (3.2): with Phi = 8 pi W and d = 2 m that is 2 W/m2.
#include <cstdio>

#include "gi/rsm/gather.h"

int main() {
    const plumb::Image4 position(1, 1, {0, 0, 0, 0}), normal(1, 1, {0, 1, 0, 0});
    plumb::raster::Rsm map;
    map.size = 1;
    map.records = {0, 2, 0, 0, /* normal */ 0, -1, 0, 1, /* flux */ 25.1327412f, 25.1327412f, 25.1327412f, 0, 0, 0, 0, 0};
    plumb::Image4 irradiance;
    plumb::rsm::run({.gather = plumb::rsm::Gather::all}, {.position = &position, .normal = &normal, .rsm = &map}, {},
                    irradiance);
    std::printf("%.6f\n", irradiance(0, 0).x);
}
