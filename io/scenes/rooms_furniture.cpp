// Tables, chairs, shelves with books, sofas, beds, lamps, plants, rugs and pictures: placed along free walls.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "io/scenes/rooms_parts.h"

namespace plumb::io::scenes::flat {
namespace {

struct Tools {
    Builder& b;
    const Finish& f;
    double detail;
    int cells(double length) const { return std::clamp(int(length * detail * 0.35), 1, 200); }
    int around() const { return std::clamp(int(5 + detail * 0.9), 6, 96); }
};

// A box with its edges rounded by `soft` and its faces bulging by `bulge`: cushions.
void cushion(const Tools& t, int material, const Place& place, const Point& low, const Point& high, double bulge) {
    const Point middle = 0.5 * (low + high), half = 0.5 * (high - low);
    const int n = std::clamp(int(2 + t.detail * 0.5), 2, 40);
    for (int axis = 0; axis < 3; ++axis)
        for (int side = -1; side <= 1; side += 2) {
            const int a = (axis + 1) % 3, c = (axis + 2) % 3;
            Grid g;
            g.columns = g.rows = n;
            t.b.grid(material, place, g, [&](double u, double v) {
                Point q;
                // Exact opposites, so that faces share their edges.
                const int i = int(u * n + 0.5), j = int(v * n + 0.5);
                q[axis] = side, q[a] = side * (2.0 * i - n) / n, q[c] = (2.0 * j - n) / n;
                // Towards the ball inside the box, a little: rounds edges and corners without opening them.
                const double out = std::sqrt(glm::dot(q, q));
                const Point r = q * (1 - bulge) + q / out * bulge * 1.15;
                return middle + half * r;
            });
        }
}

void table(const Tools& t, const Place& place, double w, double d, double h, int wood) {
    t.b.box(wood, place, {-w / 2, h - 0.04, -d / 2}, {w / 2, h, d / 2}, 1, {t.cells(w), 1, t.cells(d)});
    for (int k = 0; k < 4; ++k) {
        const double x = (k % 2 ? 1 : -1) * (w / 2 - 0.09), z = (k / 2 ? 1 : -1) * (d / 2 - 0.09);
        t.b.lathe(wood, place * move({x, 0, z}), {{0.025, 0}, {0.032, 0.4 * h}, {0.035, h - 0.1}, {0.05, h - 0.04}},
                  t.around(), 0.5);
    }
    t.b.box(wood, place, {-w / 2 + 0.1, h - 0.12, -d / 2 + 0.08}, {w / 2 - 0.1, h - 0.04, -d / 2 + 0.1});
    t.b.box(wood, place, {-w / 2 + 0.1, h - 0.12, d / 2 - 0.1}, {w / 2 - 0.1, h - 0.04, d / 2 - 0.08});
}

// Looks towards +z.
void chair(const Tools& t, const Place& place, int wood, int cloth) {
    t.b.box(wood, place, {-0.21, 0.42, -0.21}, {0.21, 0.45, 0.21}, 1);
    cushion(t, cloth, place, {-0.2, 0.45, -0.2}, {0.2, 0.49, 0.2}, 0.25);
    for (int k = 0; k < 4; ++k) {
        const double x = k % 2 ? 0.18 : -0.18, z = k / 2 ? 0.18 : -0.19;
        t.b.lathe(wood, place * move({x, 0, z}), {{0.018, 0}, {0.022, 0.42}}, t.around(), 0.5);
        if (z < 0) t.b.lathe(wood, place * move({x, 0.45, z}), {{0.02, 0}, {0.016, 0.5}, {0, 0.51}}, t.around(), 0.5);
    }
    for (int k = 0; k < 3; ++k)
        t.b.box(wood, place, {-0.18, 0.6 + 0.13 * k, -0.205}, {0.18, 0.67 + 0.13 * k, -0.185}, 1, {t.cells(0.4), 1, 1});
}

void books(const Tools& t, const Place& place, double from, double to, double y, double room, Dice& dice) {
    double x = from + 0.01;
    while (true) {
        const double thick = dice.between(0.018, 0.05), h = room * dice.between(0.62, 0.92),
                     d = dice.between(0.15, 0.22);
        if (x + thick > to - 0.01) return;
        if (dice.chance(0.06)) {
            x += dice.between(0.05, 0.2);  // a gap
            continue;
        }
        t.b.box(t.f.paper[dice.pick(6)], place, {x, y, 0.03}, {x + thick - 0.002, y + h, 0.03 + d}, 1);
        x += thick;
    }
}

void shelf(const Tools& t, const Place& place, double w, double h, int wood, Dice& dice) {
    const double d = 0.3;
    t.b.box(wood, place, {-w / 2, 0, 0.005}, {-w / 2 + 0.03, h, d}, 1);
    t.b.box(wood, place, {w / 2 - 0.03, 0, 0.005}, {w / 2, h, d}, 1);
    t.b.box(wood, place, {-w / 2 + 0.03, 0, 0.005}, {w / 2 - 0.03, h, 0.02}, 1, {t.cells(w), t.cells(h), 1});
    const int boards = std::max(2, int(h / 0.36));
    for (int k = 0; k <= boards; ++k) {
        const double y = 0.04 + (h - 0.07) * k / boards;
        t.b.box(wood, place, {-w / 2 + 0.03, y, 0.02}, {w / 2 - 0.03, y + 0.025, d}, 1);
        if (k < boards && !dice.chance(0.15)) books(t, place, -w / 2 + 0.04, w / 2 - 0.04, y + 0.025, 0.33, dice);
    }
}

void sofa(const Tools& t, const Place& place, double w, int cloth) {
    const double d = 0.85;
    t.b.box(cloth, place, {-w / 2, 0.08, 0.02}, {w / 2, 0.25, d}, 1);
    cushion(t, cloth, place, {-w / 2, 0.25, 0.02}, {w / 2, 0.8, 0.24}, 0.12);
    for (int k = -1; k <= 1; k += 2) {
        cushion(t, cloth, place, {k * w / 2 - 0.1, 0.08, 0.03}, {k * w / 2 + 0.1, 0.58, d}, 0.15);
        for (double z : {0.1, d - 0.1})
            t.b.box(t.f.metal, place, {k * (w / 2 - 0.1) - 0.02, 0, z}, {k * (w / 2 - 0.1) + 0.02, 0.08, z + 0.04});
    }
    const int seats = w > 1.7 ? 3 : 2;
    for (int k = 0; k < seats; ++k) {
        const double s = (w - 0.2) / seats, x = -w / 2 + 0.1 + k * s;
        cushion(t, cloth, place, {x + 0.01, 0.25, 0.22}, {x + s - 0.01, 0.44, d}, 0.2);
    }
    cushion(t, t.f.cloth[3], place * move({w / 2 - 0.4, 0.45, 0.28}) * turn_y(20), {-0.2, 0, -0.06}, {0.2, 0.38, 0.1},
            0.5);
}

void bed(const Tools& t, const Place& place, double w, int wood, int cloth) {
    const double d = 2.05;
    t.b.box(wood, place, {-w / 2, 0.1, 0.05}, {w / 2, 0.32, d}, 1);
    t.b.box(wood, place, {-w / 2 - 0.04, 0, 0.005}, {w / 2 + 0.04, 0.95, 0.05}, 1, {t.cells(w), 1, 1});
    cushion(t, t.f.white, place, {-w / 2 + 0.02, 0.32, 0.06}, {w / 2 - 0.02, 0.5, d - 0.02}, 0.08);
    const int n = t.cells(3);
    Grid g;
    g.columns = 2 * n, g.rows = 2 * n, g.texture = {2, 2};
    t.b.grid(cloth, place, g, [&](double u, double v) {  // a blanket with folds that hangs over both sides
        const double x = (2 * u - 1) * (w / 2 + 0.25), over = std::max(0.0, std::abs(x) - w / 2 - 0.02);
        const double fold = 0.012 * host::sin(23 * x + 9 * v) + 0.03 * over * host::sin(40 * v);
        const double side = (x < 0 ? -1 : 1) * std::min(std::abs(x), w / 2 + 0.02);
        return Point(side + (over > 0 ? (x < 0 ? -1 : 1) * std::abs(fold) : 0), 0.535 + (over > 0 ? -1.3 * over : fold),
                     d - 1.4 * v);
    });
    for (int k = 0; k < (w > 1.2 ? 2 : 1); ++k) {
        const double x = w > 1.2 ? (k ? w / 4 : -w / 4) : 0;
        cushion(t, t.f.white, place * move({x, 0.5, 0.33}), {-0.3, 0, -0.2}, {0.3, 0.15, 0.2}, 0.5);
    }
}

void wardrobe(const Tools& t, const Place& place, double w, double h, int wood) {
    t.b.box(wood, place, {-w / 2, 0.06, 0.005}, {w / 2, h, 0.55}, 1, {t.cells(w), t.cells(h), 1});
    t.b.box(t.f.metal, place, {-w / 2 + 0.03, 0, 0.03}, {w / 2 - 0.03, 0.06, 0.5});
    const int doors = std::max(2, int(w / 0.5));
    for (int k = 0; k < doors; ++k) {
        const double x = -w / 2 + w * k / doors;
        t.b.box(wood, place, {x + 0.01, 0.08, 0.55}, {x + w / doors - 0.01, h - 0.02, 0.57}, 1, {1, t.cells(h), 1});
        t.b.box(t.f.metal, place, {x + (k % 2 ? 0.04 : w / doors - 0.06), 0.45 * h, 0.57},
                {x + (k % 2 ? 0.06 : w / doors - 0.04), 0.45 * h + 0.14, 0.6});
    }
}

void floor_lamp(const Tools& t, const Place& place, double h) {
    t.b.lathe(t.f.metal, place, {{0.15, 0}, {0.15, 0.02}, {0.02, 0.04}, {0.012, 0.1}, {0.012, h - 0.1}, {0, h - 0.09}},
              t.around(), 1);
    const Place at = place * move({0, h - 0.32, 0});
    t.b.lathe(t.f.shade, at, {{0.2, 0}, {0.13, 0.3}}, 2 * t.around(), 1);
    t.b.lathe(t.f.shade, at, {{0.12, 0.295}, {0.19, 0.005}}, 2 * t.around(), 1);
}

void vase(const Tools& t, const Place& place, int material, double s) {
    t.b.lathe(material, place * scale({s, s, s}),
              {{0, 0},
               {0.06, 0},
               {0.09, 0.08},
               {0.1, 0.14},
               {0.06, 0.24},
               {0.04, 0.28},
               {0.055, 0.32},
               {0.04, 0.315},
               {0.03, 0.27},
               {0, 0.26}},
              t.around(), 0.5);
}

void plant(const Tools& t, const Place& place, Dice& dice) {
    t.b.lathe(t.f.cloth[1], place, {{0, 0}, {0.13, 0}, {0.17, 0.3}, {0.15, 0.3}, {0.14, 0.26}, {0, 0.26}}, t.around(),
              1);
    const int leaves = 14;
    for (int k = 0; k < leaves; ++k) {
        const double l = dice.between(0.4, 0.8), arch = dice.between(0.5, 1.1),
                     turn = 360.0 * k / leaves + dice.between(-15, 15);
        Grid g;
        g.columns = 2, g.rows = std::clamp(int(2 + t.detail * 0.3), 3, 24), g.smooth = false;
        for (int side = 0; side < 2; ++side)
            t.b.grid(t.f.leaf, place * move({0, 0.26, 0}) * turn_y(turn), g, [&](double u, double v) {
                // A lens, closed along its edge and pointed at both ends.
                const double s = side ? 1 - u : u, bulge = 4 * v * (1 - v), edge = std::abs(2 * s - 1);
                const double lift = bulge * (0.02 * edge - (side ? 0 : 0.003) * (1 - edge));
                return Point(0.09 * bulge * (s - 0.5), l * (v * 1.3 - arch * 0.8 * v * v) + lift,
                             l * 0.75 * v * (0.3 + 0.7 * v));
            });
    }
}

void rug(const Tools& t, const Place& place, double w, double d) {
    const int c = t.cells(2 * w), r = t.cells(2 * d);
    const Point top[4] = {
        {-w / 2, 0.012, d / 2}, {w / 2, 0.012, d / 2}, {w / 2, 0.012, -d / 2}, {-w / 2, 0.012, -d / 2}};
    t.b.quad(t.f.rug, place, top, c, r, std::max(w, d));
    for (int k = 0; k < 4; ++k) {
        const Point side[4] = {top[k] - Point(0, 0.012, 0), top[(k + 1) % 4] - Point(0, 0.012, 0), top[(k + 1) % 4],
                               top[k]};
        t.b.quad(t.f.cloth[0], place, side);
    }
}

void picture(const Tools& t, const Place& place, double w, double h, int which) {
    const double bar = 0.035;
    t.b.box(t.f.picture[which], place, {-w / 2, -h / 2, 0.003}, {w / 2, h / 2, 0.012}, std::max(w, h));
    t.b.box(t.f.wood[which], place, {-w / 2 - bar, -h / 2 - bar, 0.003}, {w / 2 + bar, -h / 2, 0.03});
    t.b.box(t.f.wood[which], place, {-w / 2 - bar, h / 2, 0.003}, {w / 2 + bar, h / 2 + bar, 0.03});
    t.b.box(t.f.wood[which], place, {-w / 2 - bar, -h / 2, 0.003}, {-w / 2, h / 2, 0.03});
    t.b.box(t.f.wood[which], place, {w / 2, -h / 2, 0.003}, {w / 2 + bar, h / 2, 0.03});
}

// ---- Placing ----

bool overlaps(const Box& a, const Box& b) { return a.x0 < b.x1 && b.x0 < a.x1 && a.z0 < b.z1 && b.z0 < a.z1; }

Box covered(const Place& place, double x0, double z0, double x1, double z1) {
    Box box{1e9, 1e9, -1e9, -1e9};
    for (int k = 0; k < 4; ++k) {
        const glm::dvec4 p = place * glm::dvec4(k % 2 ? x1 : x0, 0, k / 2 ? z1 : z0, 1);
        box = {std::min(box.x0, p.x), std::min(box.z0, p.z), std::max(box.x1, p.x), std::max(box.z1, p.z)};
    }
    return box;
}

// A stretch w long and d deep along a wall: clear of what stands, of doors, and of windows lower than h.
bool along_wall(Room& room, double w, double d, double h, Dice& dice, Place& place) {
    for (int attempt = 0; attempt < 24; ++attempt) {
        const int side = dice.pick(4);
        const double length = side_length(room, side), at = dice.between(w / 2 + 0.05, length - w / 2 - 0.05);
        if (length < w + 0.1) continue;
        bool clear = true;
        for (const Opening& o : room.openings[std::size_t(side)])
            clear &= o.to < at - w / 2 - 0.05 || o.from > at + w / 2 + 0.05 || (o.window && o.low >= h + 0.05);
        const Place frame = side_frame(room, side) * move({at, 0, 0});
        const Box box = covered(frame, -w / 2 - 0.04, 0, w / 2 + 0.04, d + 0.35);
        clear &= box.x0 > room.floor.x0 - 0.01 && box.x1 < room.floor.x1 + 0.01 && box.z0 > room.floor.z0 - 0.01 &&
                 box.z1 < room.floor.z1 + 0.01;
        for (const Box& other : room.taken) clear &= !overlaps(box, other);
        if (!clear) continue;
        room.taken.push_back(covered(frame, -w / 2 - 0.04, 0, w / 2 + 0.04, d));
        place = frame;
        return true;
    }
    return false;
}

// A place w x d away from the walls, nearest the middle.
bool in_the_middle(Room& room, double w, double d, Dice& dice, Place& place) {
    const Box& f = room.floor;
    for (int attempt = 0; attempt < 24; ++attempt) {
        const double spread = attempt / 24.0;
        const double aside = spread * (dice() - 0.5), ahead = spread * (dice() - 0.5);
        const Point at((f.x0 + f.x1) / 2 + aside * (room.width() - w), 0,
                       (f.z0 + f.z1) / 2 + ahead * (room.depth() - d));
        const Box box{at.x - w / 2, at.z - d / 2, at.x + w / 2, at.z + d / 2};
        bool clear = box.x0 > f.x0 + 0.3 && box.x1 < f.x1 - 0.3 && box.z0 > f.z0 + 0.3 && box.z1 < f.z1 - 0.3;
        for (const Box& other : room.taken) clear &= !overlaps(box, other);
        if (!clear) continue;
        room.taken.push_back(box);
        place = move(at);
        return true;
    }
    return false;
}

void dining(const Tools& t, Room& room, Dice& dice) {
    const double w = dice.between(1.3, 2.0), d = dice.between(0.8, 1.0);
    const int wood = t.f.wood[dice.pick(3)], cloth = t.f.cloth[dice.pick(4)];
    Place at;
    if (!in_the_middle(room, w + 1.2, d + 1.3, dice, at)) return;
    table(t, at, w, d, 0.75, wood);
    vase(t, at * move({0.2 * w, 0.75, 0}), cloth, dice.between(0.6, 1));
    const int places = w > 1.6 ? 3 : 2;
    for (int k = 0; k < places; ++k)
        for (int side = 0; side < 2; ++side) {
            const double x = (k - (places - 1) / 2.0) * (w / places),
                         z = (side ? 1 : -1) * (d / 2 + dice.between(0.0, 0.25));
            chair(t, at * move({x, 0, z}) * turn_y((side ? 180 : 0) + dice.between(-14, 14)), wood, cloth);
        }
}

void living(const Tools& t, Room& room, Dice& dice) {
    Place at;
    const int cloth = t.f.cloth[dice.pick(3)];
    const double w = dice.between(1.6, 2.3);
    if (along_wall(room, w + 0.2, 1.0, 0.8, dice, at)) {
        sofa(t, at, w, cloth);
        const Place front = at * move({0, 0, 1.45});
        const Box box = covered(front, -0.5, -0.3, 0.5, 0.3);
        bool clear = true;
        for (const Box& other : room.taken) clear &= !overlaps(box, other);
        rug(t, front, 2.2, 1.3);
        if (clear && box.x0 > room.floor.x0 + 0.2 && box.x1 < room.floor.x1 - 0.2 && box.z0 > room.floor.z0 + 0.2 &&
            box.z1 < room.floor.z1 - 0.2) {
            table(t, front, 0.95, 0.55, 0.4, t.f.wood[dice.pick(3)]);
            vase(t, front * move({0.2, 0.4, 0.05}), t.f.cloth[dice.pick(4)], 0.6);
            room.taken.push_back(box);
        }
    }
    if (along_wall(room, 0.45, 0.45, 1.6, dice, at)) floor_lamp(t, at * move({0, 0, 0.22}), dice.between(1.4, 1.7));
}

}  // namespace

void furnish(Builder& b, const Finish& f, const Flat& flat, Room room, double detail, std::uint32_t seed) {
    Dice dice{seed, dice_row};
    const Tools t{b, f, detail};
    Place at;
    if (room.kind == 0) living(t, room, dice);
    if (room.kind == 1) dining(t, room, dice);
    if (room.kind == 2) {
        const double w = dice.chance(0.6) ? 1.6 : 1.0;
        const int wood = f.wood[dice.pick(3)];
        if (along_wall(room, w + 0.1, 2.1, 1.0, dice, at)) bed(t, at, w, wood, f.cloth[dice.pick(4)]);
        if (along_wall(room, 1.5, 0.6, 2.1, dice, at)) wardrobe(t, at, 1.5, 2.1, wood);
        if (along_wall(room, 0.5, 0.4, 0.6, dice, at)) table(t, at * move({0, 0, 0.22}), 0.45, 0.38, 0.5, wood);
    }
    if (room.kind == 3 && along_wall(room, 1.4, 1.2, 0.8, dice, at)) {
        const int wood = f.wood[dice.pick(3)], cloth = f.cloth[dice.pick(4)];
        table(t, at * move({0, 0, 0.36}), 1.35, 0.65, 0.74, wood);
        chair(t, at * move({0.1, 0, 0.95}) * turn_y(180 + dice.between(-25, 25)), wood, cloth);
        books(t, at * move({-0.6, 0.74, 0.05}), 0, 0.4, 0, 0.3, dice);
    }
    // What any room may hold: shelves, a sideboard, lamps, plants, pictures.
    const int shelves = 1 + dice.pick(room.width() * room.depth() > 16 ? 3 : 2);
    for (int k = 0; k < shelves; ++k) {
        const double w = dice.between(0.8, 1.6), h = dice.between(1.1, 2.1);
        if (along_wall(room, w, 0.32, h, dice, at)) shelf(t, at, w, h, f.wood[dice.pick(3)], dice);
    }
    if (dice.chance(0.6) && along_wall(room, 0.6, 0.6, 0.9, dice, at)) plant(t, at * move({0, 0, 0.32}), dice);
    if (dice.chance(0.4) && along_wall(room, 0.5, 0.5, 1.6, dice, at)) floor_lamp(t, at * move({0, 0, 0.25}), 1.5);
    const int pictures = 1 + dice.pick(4);
    for (int k = 0; k < pictures; ++k) {
        const int side = dice.pick(4);
        const double w = dice.between(0.35, 0.9), h = dice.between(0.3, 0.7), length = side_length(room, side);
        const double x = dice.between(0.6, std::max(0.7, length - 0.6));
        bool clear = length > w + 0.4;
        for (const Opening& o : room.openings[std::size_t(side)])
            clear &= o.to < x - w / 2 - 0.1 || o.from > x + w / 2 + 0.1;
        const Box box = covered(side_frame(room, side) * move({x, 0, 0}), -w / 2 - 0.1, 0, w / 2 + 0.1, 0.3);
        for (const Box& other : room.taken) clear &= !overlaps(box, other);
        if (!clear) continue;
        picture(t, side_frame(room, side) * move({x, 1.6, 0}), w, h, dice.pick(3));
        room.taken.push_back(box);
    }
    // A lamp that hangs from the ceiling: a cord and a shade, open below.
    const Place lamp =
        move({(room.floor.x0 + room.floor.x1) / 2, flat.height - 0.65, (room.floor.z0 + room.floor.z1) / 2});
    b.box(f.metal, lamp, {-0.006, 0.2, -0.006}, {0.006, 0.65, 0.006});
    b.lathe(f.shade, lamp, {{0.26, 0}, {0.22, 0.1}, {0.1, 0.19}, {0, 0.2}}, 2 * t.around(), 1);
    b.lathe(f.shade, lamp, {{0, 0.19}, {0.09, 0.18}, {0.21, 0.095}, {0.25, 0}}, 2 * t.around(), 1);
}

}  // namespace plumb::io::scenes::flat
