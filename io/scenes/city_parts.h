// The parts of the scene `city`: its plan, and what stands on it.
//
// A part is built to an allowance of triangles: it drops what it cannot afford, finest things first. Seen from above,
// rings of corners run counter-clockwise: the edge from corner k to k + 1 has the outside on its right.
#pragma once

#include <array>
#include <vector>

#include "io/scenes/builder.h"

namespace plumb::io::scenes::town {

constexpr int tints = 8;

// Indices of materials. A plaster has a painted twin with one bay of one storey to a texture, for distant houses.
struct Palette {
    int plaster[tints], painted[tints], shutter[4];
    int tiles, terracotta;  // roof tiles as a picture; as material of modelled ones
    int stone, travertine, brick, arches, lead, glass, wood, metal, lamp;
    int cobbles, paving, grass, earth, water, bark, leaf[3];
};
Palette make_palette(Builder& b);

// How much the scene may cost, and how fine that makes it: log10(triangles / 1000), 0 to 4.
struct Grade {
    double triangles = 4e6, fine = 3.6;
    int count(double coarse, double finest) const {  // geometric between fine = 0 and 4
        return int(coarse * power(finest / coarse) + 0.5);
    }
    double power(double ratio) const;  // ratio^(fine / 4)
};

// ---- Plan (city_plan.cpp) ----

constexpr double half_extent = 300;  // m
constexpr glm::dvec2 piazza{55, -55}, church{55, -150}, arena{165, 115}, hill{205, -205};  // x, z of the centres
constexpr double hill_radius = 95, hill_height = 34;

double ground_height(const glm::dvec2& p);
// x of the river's middle; its half width.
double river_x(double z);
constexpr double river_half = 18;

using Ring = std::array<glm::dvec2, 4>;

struct Lot {
    Ring ring;                // 0-1: the street; 2-3: the courtyard
    double eaves = 12;        // m above the ground
    int tint = 0, storeys = 3;
    bool palace = false;      // tall storeys, stone surrounds, no shutters
    bool detached = false;    // a whole block: no party walls
    std::uint32_t seed = 1;
};
struct Block {
    Ring street, yard;        // outline of the houses and of the court behind them
    bool court = false;
    bool whole = false;       // no house is missing
};
struct Plan {
    std::vector<Block> blocks;
    std::vector<Lot> lots;
    std::vector<glm::dvec2> lamps, trees, pines;
};
Plan make_plan(const Grade& grade, std::uint32_t seed);

// ---- Buildings ----

// One house that takes about `allowance` triangles.
void house(Builder& b, const Palette& p, const Lot& lot, double allowance);

// A slope of a roof: the eaves from corner 0 to 1, the ridge from 3 to 2.
void roof_slope(Builder& b, const Palette& p, const Point corners[4], double allowance);

void amphitheatre(Builder& b, const Palette& p, const Grade& grade);
void domed_church(Builder& b, const Palette& p, const Grade& grade);
void colonnade(Builder& b, const Palette& p, const Grade& grade);  // with obelisk and fountains
void bridges(Builder& b, const Palette& p, const Grade& grade);

void ground(Builder& b, const Palette& p, const Grade& grade);
void pavements(Builder& b, const Palette& p, const Grade& grade, const std::vector<Block>& blocks);
enum class TreeKind { broad, pine, cypress };
void tree(Builder& b, const Palette& p, TreeKind kind, const glm::dvec2& at, double allowance, std::uint32_t seed);
void street_lamp(Builder& b, const Palette& p, const glm::dvec2& at, double allowance);

// ---- Shared shapes (city_shapes.cpp) ----

// A box without its back (-z): what is stuck to a wall.
void slab(Builder& b, int material, const Place& place, const Point& low, const Point& high);

// Where local (x along, y up, z outward) goes: the frame of the wall from `from` to `to` above `base`.
Place wall_frame(const glm::dvec2& from, const glm::dvec2& to, double base);

// Bends a point of a wall (x along, y up, z outward) into the world.
using Bend = std::function<Point(double x, double y, double z)>;

// The stretch [x0, x1] x [y0, y1] of a wall `depth` thick with a round-arched opening in its middle; `arc` segments, a
// multiple of 4. With its back where `back` is set.
struct Arch {
    double x0, x1, y0, y1, half_width, springing, depth;
    int arc = 8;
    bool back = false;
    double texture_size = 4;
};
void arch(Builder& b, int material, const Arch& a, const Bend& bend);

// A band along a wall, x0 to x1 in `columns`: a profile of (z, y) from its lower to its upper edge.
void moulding(Builder& b, int material, double x0, double x1, int columns, const std::vector<glm::dvec2>& profile,
              const Bend& bend, double texture_length);

// A column with base and capital, 1 high and of radius 1 at its foot, scaled by the place.
void column(Builder& b, int material, const Place& place, double height, double radius, int segments);

}  // namespace plumb::io::scenes::town
