// Points on which a legal device may decide otherwise: half of a picture's.
#pragma once

#include "core/binding.h"

namespace plumb::mutants {

// Moves points of a dispatch of shadow, rsm.disc or rsm.paths: a quarter of them to where they project on to the border of
// two texels of the map, and others to where another comparison is a tie: a quarter with the map's depth (shadow), a
// sixteenth of a sample's elevation with an edge of two slots (rsm.paths); all to within a few roundings.
void plant_ties(StageData& data);

}  // namespace plumb::mutants
