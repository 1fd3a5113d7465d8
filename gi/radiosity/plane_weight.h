// What a plane in front of a patch weighs: the integral that texels of hemicubes' tops and of single pictures are differences of.
#pragma once

namespace plumb::radiosity {

// Over [0, x] x [0, y] of the plane at distance 1: T of README.md, Texels.
double plane_weight(double x, double y);

}  // namespace plumb::radiosity
