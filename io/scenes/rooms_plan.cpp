// A flat's plan: a rectangle cut into one to four rooms, doors in the walls between them, windows in the outer walls.
#include <algorithm>

#include "io/scenes/rooms_parts.h"

namespace plumb::io::scenes::flat {
namespace {

constexpr double door_width = 0.9, door_height = 2.05;

struct Wall {
    bool across_x;      // the wall stands at one x
    double low, high;   // its two faces
};

// Cuts the rectangle until every room is small enough or `rooms` are there; remembers the walls.
void cut(std::vector<Box>& boxes, std::vector<Wall>& walls, int rooms, Dice& dice) {
    while (int(boxes.size()) < rooms) {
        // The largest one, across its longer side.
        std::size_t largest = 0;
        for (std::size_t k = 1; k < boxes.size(); ++k) {
            const auto area = [&](const Box& b) { return (b.x1 - b.x0) * (b.z1 - b.z0); };
            if (area(boxes[k]) > area(boxes[largest])) largest = k;
        }
        const Box box = boxes[largest];
        const bool across_x = box.x1 - box.x0 > box.z1 - box.z0;
        const double low = across_x ? box.x0 : box.z0, high = across_x ? box.x1 : box.z1;
        if (high - low < 6.4) return;
        const double at = low + (high - low) * dice.between(0.45, 0.55);
        Box first = box, second = box;
        (across_x ? first.x1 : first.z1) = at - inner_wall / 2;
        (across_x ? second.x0 : second.z0) = at + inner_wall / 2;
        boxes[largest] = first;
        boxes.push_back(second);
        walls.push_back({across_x, at - inner_wall / 2, at + inner_wall / 2});
    }
}

// Coordinates of a room along a side, from its beginning.
double along(const Room& room, int side, double x, double z) {
    const double at[4] = {x - room.floor.x0, z - room.floor.z0, room.floor.x1 - x, room.floor.z1 - z};
    return at[side];
}

// A door between the two rooms that share the longest stretch of the wall.
void add_door(std::vector<Room>& rooms, const Wall& wall, Dice& dice) {
    double longest = 0, from = 0;
    std::size_t first = 0, second = 0;
    for (std::size_t i = 0; i < rooms.size(); ++i)
        for (std::size_t j = 0; j < rooms.size(); ++j) {
            const Box &a = rooms[i].floor, &b = rooms[j].floor;
            if ((wall.across_x ? a.x1 : a.z1) != wall.low || (wall.across_x ? b.x0 : b.z0) != wall.high) continue;
            const double low = std::max(wall.across_x ? a.z0 : a.x0, wall.across_x ? b.z0 : b.x0);
            const double high = std::min(wall.across_x ? a.z1 : a.x1, wall.across_x ? b.z1 : b.x1);
            if (high - low > longest) longest = high - low, from = low, first = i, second = j;
        }
    if (longest < door_width + 0.4) return;
    const double at = from + dice.between(0.2, longest - door_width - 0.2);
    const auto put = [&](Room& room, int side) {
        const double x = wall.across_x ? 0 : at, z = wall.across_x ? at : 0;
        const double s = along(room, side, x, z), t = side < 2 ? s + door_width : s - door_width;
        room.openings[std::size_t(side)].push_back({std::min(s, t), std::max(s, t), 0, door_height, false});
        // Nobody stands in a door.
        const Box& f = room.floor;
        const double reach = 0.8;
        if (wall.across_x)
            room.taken.push_back(side == 1 ? Box{f.x1 - reach, at, f.x1, at + door_width}
                                           : Box{f.x0, at, f.x0 + reach, at + door_width});
        else
            room.taken.push_back(side == 2 ? Box{at, f.z1 - reach, at + door_width, f.z1}
                                           : Box{at, f.z0, at + door_width, f.z0 + reach});
    };
    put(rooms[first], wall.across_x ? 1 : 2);
    put(rooms[second], wall.across_x ? 3 : 0);
}

void add_windows(Room& room, double height, Dice& dice) {
    for (int side = 0; side < 4; ++side) {
        if (!room.outside[std::size_t(side)] || !dice.chance(0.75)) continue;
        const double length = side_length(room, side), wide = dice.between(0.9, 1.6);
        const int count = std::max(1, int(length / (wide + 1.4)));
        const bool low = dice.chance(0.2);
        for (int k = 0; k < count; ++k) {
            const double middle = length * (k + 0.5) / count;
            if (length < wide + 0.5) continue;
            room.openings[std::size_t(side)].push_back(
                {middle - wide / 2, middle + wide / 2, low ? 0.3 : 0.9, height - 0.35, true});
        }
    }
}

}  // namespace

Place side_frame(const Room& room, int side) {
    const Box& f = room.floor;
    const Point corner[4] = {{f.x0, 0, f.z0}, {f.x1, 0, f.z0}, {f.x1, 0, f.z1}, {f.x0, 0, f.z1}};
    return move(corner[side]) * turn_y(-90.0 * side);
}

double side_length(const Room& room, int side) { return side % 2 ? room.depth() : room.width(); }

Flat plan_flat(Dice& dice) {
    Flat flat;
    const int wanted = 1 + dice.pick(4);
    const double grow = 1 + 0.42 * (wanted - 1), width = dice.between(5.2, 7.0) * grow,
                 depth = dice.between(4.2, 5.6) * (1 + 0.2 * (wanted - 1));
    flat.floor = {-width / 2, -depth / 2, width / 2, depth / 2};
    flat.height = dice.between(2.5, 3.2);

    std::vector<Box> boxes{flat.floor};
    std::vector<Wall> walls;
    cut(boxes, walls, wanted, dice);
    for (const Box& box : boxes) {
        Room room;
        room.floor = box;
        room.outside = {box.z0 == flat.floor.z0, box.x1 == flat.floor.x1, box.z1 == flat.floor.z1,
                        box.x0 == flat.floor.x0};
        flat.rooms.push_back(room);
    }
    for (const Wall& wall : walls) add_door(flat.rooms, wall, dice);
    for (Room& room : flat.rooms) add_windows(room, flat.height, dice);

    for (std::size_t k = 0; k < flat.rooms.size(); ++k) {
        const auto area = [&](std::size_t i) { return flat.rooms[i].width() * flat.rooms[i].depth(); };
        if (area(k) > area(std::size_t(flat.main))) flat.main = int(k);
        flat.rooms[k].kind = dice.pick(4);
    }
    // A corner of the main room belongs to the camera.
    Room& main = flat.rooms[std::size_t(flat.main)];
    main.kind = dice.pick(2);
    const int corner = dice.pick(4);
    const Box& f = main.floor;
    const double clear = 1.0, x = corner % 2 ? f.x1 : f.x0, z = corner / 2 ? f.z1 : f.z0;
    main.taken.push_back(
        {std::min(x, corner % 2 ? x - clear : x + clear), std::min(z, corner / 2 ? z - clear : z + clear),
         std::max(x, corner % 2 ? x - clear : x + clear), std::max(z, corner / 2 ? z - clear : z + clear)});
    flat.camera = {x + (corner % 2 ? -0.4 : 0.4), z + (corner / 2 ? -0.4 : 0.4)};
    return flat;
}

}  // namespace plumb::io::scenes::flat
