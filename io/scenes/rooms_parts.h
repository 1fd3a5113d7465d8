// The parts of the scene `rooms`: a flat's plan, and what stands in it.
//
// Sides of a room: 0 at its lowest z, 1 at its highest x, 2 at its highest z, 3 at its lowest x. Along a side one walks
// with the room on the right: x grows on side 0, z on side 1, and back.
#pragma once

#include <array>
#include <vector>

#include "io/scenes/builder.h"

namespace plumb::io::scenes::flat {

constexpr int dice_row = 7;

struct Opening {
    double from, to, low, high;  // m along the side, m above the floor
    bool window;
};
struct Box {
    double x0, z0, x1, z1;
};
struct Room {
    Box floor;
    std::array<std::vector<Opening>, 4> openings;
    std::array<bool, 4> outside{};  // the side is an outer wall
    std::vector<Box> taken;         // floor that furniture may not use
    int kind = 0;                   // 0 living, 1 dining, 2 sleeping, 3 study
    double width() const { return floor.x1 - floor.x0; }
    double depth() const { return floor.z1 - floor.z0; }
};
struct Flat {
    std::vector<Room> rooms;
    Box floor;                      // inside of the outer walls
    double height = 2.7;
    int main = 0;                   // the largest room: with the camera
    glm::dvec2 camera;              // x, z; kept free
};
constexpr double outer_wall = 0.32, inner_wall = 0.14;

Flat plan_flat(Dice& dice);

// The frame of a side: x along it, y up, z into the room; and its length.
Place side_frame(const Room& room, int side);
double side_length(const Room& room, int side);

struct Finish {
    int wall[4], ceiling, floor, white, wood[3], cloth[4], metal, paper[6], shade, picture[3], rug, leaf, sill;
};
Finish make_finish(Builder& b, Dice& dice);

// Furnishes a room; `detail`: 1 is plain, 30 very fine. Takes the same places for every detail.
void furnish(Builder& b, const Finish& f, const Flat& flat, Room room, double detail, std::uint32_t seed);

}  // namespace plumb::io::scenes::flat
