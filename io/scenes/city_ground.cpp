// What the city stands on, and what grows between its houses: ground with river and hill, pavements, trees, lamps.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "io/scenes/city_parts.h"

namespace plumb::io::scenes::town {
namespace {

constexpr double edge = half_extent + 8, water_level = -4.2, bed = -7;

Point lifted(double x, double z) { return {x, ground_height({x, z}), z}; }

// A closed, uneven ball: what leaves look like in clumps.
void clump(Builder& b, int material, const Place& place, const Point& radii, int columns, int rows, double rough,
           std::uint32_t seed) {
    Grid g;
    g.columns = columns, g.rows = rows, g.closed_u = true;
    g.texture = {2, 1};
    b.grid(material, place, g, [&](double u, double v) {
        const int i = int(u * columns + 0.5) % columns, j = int(v * rows + 0.5);
        const bool pole = j == 0 || j == rows;
        const double reach = 1 - rough + 2 * rough * white_noise(pole ? 0 : i, j, seed);
        const double turn = 2 * host::pi * i / columns, tilt = host::pi * j / rows, ring = pole ? 0 : host::sin(tilt);
        // Uneven in its width alone: steep rows must not fold over each other.
        return radii * Point(reach * ring * host::sin(turn), -host::cos(tilt), reach * ring * host::cos(turn));
    });
}

}  // namespace

void ground(Builder& b, const Palette& p, const Grade& grade) {
    const int rows = grade.count(5, 256), columns = grade.count(3, 160);
    // West bank, river, east bank: they share the banks' points.
    const auto strip = [&](int material, int count, double texture, auto&& left, auto&& right, auto&& point) {
        Grid g;
        g.columns = count, g.rows = rows;
        g.texture = {2 * edge * count / columns / texture, 2 * edge / texture};
        b.grid(material, Place(1), g, [&](double u, double v) {
            const double z = edge - 2 * edge * v, x = left(z) + u * (right(z) - left(z));
            return point(x, z);
        });
    };
    const auto west = [](double) { return -edge; };
    const auto east = [](double) { return edge; };
    const auto bank_w = [](double z) { return river_x(z) - river_half; };
    const auto bank_e = [](double z) { return river_x(z) + river_half; };
    strip(p.cobbles, std::max(1, columns / 5), 5, west, bank_w, lifted);
    strip(p.cobbles, columns - columns / 5, 5, bank_e, east, lifted);
    strip(p.water, std::max(1, columns / 12), 40, bank_w, bank_e, [](double x, double z) {
        return Point(x, water_level, z);
    });
    for (int side = 0; side < 2; ++side) {
        Grid g;
        g.columns = rows, g.rows = 3, g.texture = {2 * edge / 5, 1.6};
        b.grid(p.stone, Place(1), g, [&](double u, double v) {
            // A wall with a parapet: its face, its top, its back.
            const double z = side ? edge - 2 * edge * u : 2 * edge * u - edge, out = side ? 1 : -1;
            const double y = v < 0.1 ? bed : v > 0.9 ? 0 : 0.95, back = v < 0.5 ? 0 : 0.5;
            return Point(river_x(z) + out * (river_half + back), y, z);
        });
    }
    // The cut sides of the model.
    const glm::dvec2 corner[4] = {{-edge, edge}, {edge, edge}, {edge, -edge}, {-edge, -edge}};
    for (int k = 0; k < 4; ++k) {
        Grid g;
        const glm::dvec2 from = corner[k], to = corner[(k + 1) % 4];
        const bool cut = k % 2 == 0;
        g.columns = k % 2 ? rows : std::max(8, columns), g.texture = {20, 1};
        b.grid(p.earth, Place(1), g, [&](double u, double v) {
            const glm::dvec2 q = from + u * (to - from);
            const double top = cut && std::abs(q.x - river_x(q.y)) < river_half ? water_level : ground_height(q);
            return Point(q.x, v < 0.5 ? -14 : top, q.y);
        });
    }
    // Grass over the hill: the ground's own height and a little more.
    Grid g;
    g.columns = grade.count(6, 160), g.rows = grade.count(2, 60), g.closed_u = true, g.texture = {24, 12};
    b.grid(p.grass, Place(1), g, [&](double u, double v) {
        const double turn = 2 * host::pi * u, far = 0.985 * hill_radius * (1 - v);
        const glm::dvec2 q = hill + far * glm::dvec2(host::sin(turn), host::cos(turn));
        return Point(q.x, ground_height(q) + 0.25, q.y);
    });
}

void pavements(Builder& b, const Palette& p, const Grade& grade, const std::vector<Block>& blocks) {
    if (grade.fine < 1.2) return;
    for (const Block& block : blocks) {
        if (!block.whole) continue;
        // A slab under the block, 1.2 m wider than its houses, and the court's ground.
        const glm::dvec2 centre = 0.25 * (block.street[0] + block.street[1] + block.street[2] + block.street[3]);
        Ring wide;
        for (int k = 0; k < 4; ++k) {
            const glm::dvec2 d = block.street[k] - centre;
            wide[k] = block.street[k] + d * (1.6 / std::sqrt(glm::dot(d, d)));
        }
        const auto layer = [&](int material, const Ring& ring, double low, double high) {
            Point top[4];
            for (int k = 0; k < 4; ++k) top[k] = {ring[k].x, high, ring[k].y};
            b.quad(material, Place(1), top, 1, 1, 4);
            for (int k = 0; k < 4; ++k) {
                const int n = (k + 1) % 4;
                const Point side[4] = {{ring[k].x, low, ring[k].y}, {ring[n].x, low, ring[n].y}, top[n], top[k]};
                b.quad(p.stone, Place(1), side, 1, 1, 4);
            }
        };
        layer(p.paving, wide, 0, 0.16);
        if (block.court)
            layer(white_noise(int(centre.x), int(centre.y), 3) < 0.6 ? p.grass : p.cobbles, block.yard, 0.16, 0.4);
    }
}

void tree(Builder& b, const Palette& p, TreeKind kind, const glm::dvec2& at, double allowance, std::uint32_t seed) {
    Dice dice{seed};
    const Place place = move({at.x, ground_height(at), at.y}) * turn_y(360 * dice());
    const bool pine = kind == TreeKind::pine;
    if (kind == TreeKind::cypress) {
        const double h = dice.between(9, 15), r = dice.between(0.9, 1.4);
        const int rows = std::clamp(int(std::sqrt(allowance / 1.4)), 3, 40),
                  columns = std::clamp(int(allowance / 2 / rows), 4, 40);
        clump(b, p.leaf[2], place * move({0, 0.5 * h + 0.4, 0}), {r, 0.5 * h, r}, columns, rows, 0.12, seed);
        return;
    }
    // A trunk that leans and thins out, then crowns of several clumps; an umbrella pine's lie flat and high.
    const double h = pine ? dice.between(10, 15) : dice.between(6, 9), lean = dice.between(-0.8, 0.8);
    const int sides = allowance < 60 ? 3 : allowance < 400 ? 5 : 8;
    const double reach = pine ? dice.between(3.5, 5) : dice.between(2.4, 3.4);
    const auto limb = [&](const Point& from, const Point& to, double r0, double r1) {
        Grid g;
        g.columns = sides, g.rows = 1, g.closed_u = true, g.texture = {1, 3};
        b.grid(p.bark, place, g, [&](double u, double v) {
            const double turn = 2 * host::pi * u, r = r0 + v * (r1 - r0);
            return from + v * (to - from) + r * Point(host::sin(turn), 0, host::cos(turn));
        });
    };
    const double fork = pine ? 0.8 * h : 0.45 * h;
    const Point top{lean, fork, 0.4 * lean};
    limb({0, -1, 0}, top, pine ? 0.4 : 0.32, 0.2);
    const int clumps = allowance < 60 ? 1 : allowance < 200 ? 3 : allowance < 900 ? 6 : 9;
    const double each = (allowance - 2 * sides * (clumps > 1 ? clumps + 1 : 1)) / clumps;
    const int rows = std::clamp(int(std::sqrt(each / 4)), 3, 24),
              columns = std::clamp(int(each / 2 / (rows - 1)), 4, 48);
    for (int k = 0; k < clumps; ++k) {
        const double turn = 2 * host::pi * (k * 0.381966 + 0.1 * dice()),
                     far = clumps == 1 ? 0 : reach * dice.between(0.45, 0.75);
        const double size = clumps == 1 ? reach : reach * dice.between(0.45, 0.62);
        const double low = pine ? 0.5 * dice() : dice.between(-0.6, 2.2);
        const Point centre(top.x + far * host::sin(turn), h - low, top.z + far * host::cos(turn));
        if (clumps > 1) limb(top, centre, 0.16, 0.05);
        clump(b, p.leaf[pine ? 1 : 0], place * move(centre), {size, (pine ? 0.42 : 0.85) * size, size}, columns, rows,
              columns > 10 ? 0.14 : 0.1, seed * 31 + std::uint32_t(k));
    }
}

void street_lamp(Builder& b, const Palette& p, const glm::dvec2& at, double allowance) {
    const Place place = move({at.x, 0, at.y});
    const int sides = std::clamp(int(allowance / 14), 4, 16);
    b.lathe(p.metal, place, {{0.22, 0}, {0.22, 0.5}, {0.09, 0.7}, {0.06, 3.6}, {0.14, 3.7}}, sides, 2);
    b.lathe(p.lamp, place, {{0.14, 3.7}, {0.24, 4.2}}, sides, 2);
    b.lathe(p.metal, place, {{0.27, 4.2}, {0.16, 4.42}, {0, 4.5}}, sides, 2);
}

}  // namespace plumb::io::scenes::town
