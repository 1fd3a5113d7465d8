// A house between its neighbours: facades with windows, a tiled roof or a terrace, chimneys.
#include <algorithm>
#include <cmath>

#include "io/scenes/city_parts.h"

namespace plumb::io::scenes::town {
namespace {

double length(const glm::dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }
Point raise(const glm::dvec2& p, double y) { return {p.x, y, p.y}; }

struct Facade {
    double width, eaves;  // m
    int bays, storeys;
    bool palace, street;
};

// How far a facade goes: 0 a painted wall, 1 recessed windows, 2 sills and shutters, 3 frames and surrounds, 4 slats,
// 5 finer slats and bars. Triangles of one window at each.
constexpr int finest = 5;
constexpr int window_cost[finest + 1] = {0, 18, 48, 110, 190, 270};

int facade_cost(const Facade& f, int level) {
    return level == 0 ? 2 : 4 + f.bays * f.storeys * window_cost[level] + (level >= 2 ? 24 : 0);
}

void shutters(Builder& b, const Place& place, int material, double x, double y, double w, double h, int level) {
    // Each wing stands open beside the window; slats are a saw-tooth of its front.
    for (int side = 0; side < 2; ++side) {
        const double left = side ? x + w + 0.04 : x - 0.04 - w / 2, right = left + w / 2;
        slab(b, material, place, {left, y, 0}, {right, y + h, 0.05});
        if (level < 4) continue;
        Grid g;
        g.rows = level == 4 ? 20 : 36, g.smooth = false;
        b.grid(material, place, g, [&](double u, double v) {
            const int row = int(v * g.rows + 0.5);
            return Point(left + 0.05 + u * (w / 2 - 0.1), y + 0.06 + v * (h - 0.12), row % 2 ? 0.085 : 0.055);
        });
    }
}

struct Opening {
    double x, y, w, h;
    bool door;
};

void window(Builder& b, const Palette& p, const Place& place, const Facade& f, const Opening& o, int wall, int shutter,
            int level) {
    const double x = o.x, y = o.y, w = o.w, h = o.h, deep = f.palace ? 0.35 : 0.22;
    const Point reveal[4][4] = {{{x, y, -deep}, {x + w, y, -deep}, {x + w, y, 0}, {x, y, 0}},
                                {{x, y + h, 0}, {x + w, y + h, 0}, {x + w, y + h, -deep}, {x, y + h, -deep}},
                                {{x, y, -deep}, {x, y, 0}, {x, y + h, 0}, {x, y + h, -deep}},
                                {{x + w, y, 0}, {x + w, y, -deep}, {x + w, y + h, -deep}, {x + w, y + h, 0}}};
    // Their fronts look into the opening.
    const int order[4] = {3, 2, 1, 0};
    for (int k = 0; k < 4; ++k) {
        const bool horizontal = k < 2;
        Point side[4];
        for (int c = 0; c < 4; ++c) side[c] = reveal[k][horizontal ? order[c] : c];
        b.quad(wall, place, side, 1, 1, 4);
    }
    const Point pane[4] = {{x, y, -deep}, {x + w, y, -deep}, {x + w, y + h, -deep}, {x, y + h, -deep}};
    b.quad(o.door ? p.wood : p.glass, place, pane);
    if (level < 2) return;
    if (!o.door) slab(b, p.travertine, place, {x - 0.1, y - 0.12, 0}, {x + w + 0.1, y, 0.16});
    if (!f.palace && !o.door) shutters(b, place, shutter, x, y, w, h, level);
    if (level < 3) return;

    // The frame's bars, and a surround of stone.
    const double bar = 0.035, front = -deep + 0.05;
    slab(b, p.wood, place, {x + w / 2 - bar, y, -deep}, {x + w / 2 + bar, y + h, front});
    if (!o.door) {
        const int across = level >= 5 ? 3 : 1;
        for (int k = 1; k <= across; ++k) {
            const double at = y + h * (across == 1 ? 0.68 : k / (across + 1.0));
            slab(b, p.wood, place, {x, at - bar, -deep}, {x + w, at + bar, front});
        }
    }
    if (!f.palace) return;
    slab(b, p.travertine, place, {x - 0.2, y, 0}, {x, y + h, 0.1});
    slab(b, p.travertine, place, {x + w, y, 0}, {x + w + 0.2, y + h, 0.1});
    slab(b, p.travertine, place, {x - 0.35, y + h, 0}, {x + w + 0.35, y + h + 0.22, 0.25});
}

void facade(Builder& b, const Palette& p, const Place& place, const Facade& f, int tint, int level, Dice& dice) {
    const double foot = -1.5;
    if (level == 0 || f.bays == 0) {
        const Point corners[4] = {{0, 0, 0}, {f.width, 0, 0}, {f.width, f.eaves, 0}, {0, f.eaves, 0}};
        Grid g;
        g.texture = {std::max(1, f.bays), f.storeys};
        const int material = f.bays == 0 || level > 0 ? p.plaster[tint] : p.painted[tint];
        b.grid(material, place, g, [&](double u, double v) {
            return (1 - v) * ((1 - u) * corners[0] + u * corners[1]) + v * ((1 - u) * corners[3] + u * corners[2]);
        });
        return;
    }

    // The wall with its openings: ground floor, then storeys of one height.
    const double bay = f.width / f.bays, w = f.palace ? std::min(1.25, 0.5 * bay) : std::min(1.0, 0.42 * bay);
    const double ground = f.storeys == 1 ? f.eaves : 4.2, storey = (f.eaves - ground) / std::max(1, f.storeys - 1);
    std::vector<double> across{0}, up{foot, 0, 1.1, 3.0};
    for (int i = 0; i < f.bays; ++i) {
        across.push_back(bay * (i + 0.5) - w / 2);
        across.push_back(bay * (i + 0.5) + w / 2);
    }
    across.push_back(f.width);
    for (int k = 1; k < f.storeys; ++k) {
        const double floor = ground + (k - 1) * storey, top = k + 1 == f.storeys && !f.palace ? 0.7 : 0.76;
        up.push_back(floor + 0.26 * storey);
        up.push_back(floor + top * storey);
    }
    up.push_back(f.eaves);
    std::vector<bool> door(std::size_t(f.bays), false);
    door[std::size_t(dice.pick(f.bays))] = true;
    const bool shop = f.street && !f.palace && dice.chance(0.5);
    if (shop) door.assign(door.size(), true);
    b.sheet(p.plaster[tint], place, across, up, [&](int i, int j) {
        return i % 2 == 1 && j % 2 == 0 && j >= 2 ? true : i % 2 == 1 && j == 1 && door[std::size_t(i / 2)];
    }, 4);

    const int shutter = p.shutter[dice.pick(4)];
    for (int i = 0; i < f.bays; ++i)
        for (int k = 0; k < f.storeys; ++k) {
            Opening o{across[std::size_t(2 * i + 1)], up[std::size_t(2 + 2 * k)], w, 0, k == 0 && door[std::size_t(i)]};
            o.h = up[std::size_t(3 + 2 * k)] - o.y;
            if (o.door) o.h += o.y, o.y = 0;
            window(b, p, place, f, o, p.plaster[tint], shutter, level);
        }
    if (level < 2 || !f.street) return;

    // A plinth-high band of stone, a string course, awnings over shops.
    slab(b, p.travertine, place, {0, 3.75, 0}, {f.width, 4.0, 0.12});
    if (!shop || level < 3) return;
    const int cloth = p.shutter[dice.pick(4)];
    const Point awning[4] = {{0.3, 2.7, 1.5}, {f.width - 0.3, 2.7, 1.5}, {f.width - 0.3, 3.5, 0.02}, {0.3, 3.5, 0.02}};
    const Point under[4] = {awning[3], awning[2], awning[1], awning[0]};
    b.quad(cloth, place, awning);
    b.quad(cloth, place, under);
}

// The corner's place moved out of the wall by `by`, along the edge's normal.
glm::dvec2 outwards(const glm::dvec2& from, const glm::dvec2& to, double by) {
    const glm::dvec2 along = (to - from) / std::max(1e-9, length(to - from));
    return glm::dvec2(-along.y, along.x) * by;
}

// A strip of a wall without openings, following the ground below.
void plain_wall(Builder& b, int material, const glm::dvec2& from, const glm::dvec2& to, double low, double high) {
    const Point corners[4] = {raise(from, low), raise(to, low), raise(to, high), raise(from, high)};
    b.quad(material, Place(1), corners, 1, 1, 4);
}

void chimney(Builder& b, const Palette& p, const Lot& lot, double ridge, Dice& dice) {
    const double s = dice.between(0.2, 0.8), t = dice.between(0.3, 0.7);
    const Ring& r = lot.ring;
    const glm::dvec2 at = (1 - t) * ((1 - s) * r[0] + s * r[1]) + t * ((1 - s) * r[3] + s * r[2]);
    const Place place = move(raise(at, 0)) * turn_y(dice.between(0, 90));
    const double w = dice.between(0.3, 0.5), top = ridge + dice.between(0.5, 1.3);
    b.box(p.brick, place, {-w, lot.eaves, -0.35}, {w, top, 0.35}, 2);
    b.box(p.tiles, place, {-w - 0.08, top, -0.43}, {w + 0.08, top + 0.15, 0.43}, 4);
}

// Eaves to ridge over a ring: the ridge runs from the middle of edge 3-0 to the middle of edge 1-2.
void pitched_roof(Builder& b, const Palette& p, const Lot& lot, double allowance) {
    const Ring& r = lot.ring;
    const double deep = std::min(length(r[3] - r[0]), length(r[2] - r[1])), rise = 0.5 * deep * 0.52;
    const bool eaves = allowance > 30;
    const double out = eaves ? 0.55 : 0.0, drop = eaves ? 0.55 * 0.52 : 0.0, top = lot.eaves + rise;
    const glm::dvec2 left = 0.5 * (r[0] + r[3]), right = 0.5 * (r[1] + r[2]);
    const glm::dvec2 along = (right - left) / std::max(1e-9, length(right - left)) * (eaves ? 0.12 : 0.0);
    for (int side = 0; side < 2; ++side) {
        const glm::dvec2 from = r[side ? 2 : 0], to = r[side ? 3 : 1], turn = side ? -along : along;
        const glm::dvec2 o = outwards(from, to, out), ridge_from = side ? right : left, ridge_to = side ? left : right;
        const Point slope[4] = {raise(from + o - turn, lot.eaves - drop), raise(to + o + turn, lot.eaves - drop),
                                raise(ridge_to + turn, top), raise(ridge_from - turn, top)};
        roof_slope(b, p, slope, (allowance - (eaves ? 24 : 2)) / 2);
        if (eaves) {
            // The board under the tiles and the soffit.
            const double low = lot.eaves - drop - 0.14;
            const Point board[4] = {raise(from + o, low), raise(to + o, low), slope[1], slope[0]};
            const Point soffit[4] = {raise(from, low), raise(to, low), board[1], board[0]};
            b.quad(p.wood, Place(1), board);
            b.quad(p.plaster[lot.tint], Place(1), soffit, 1, 1, 4);
        }
        // The gable over the wall between neighbours.
        const glm::dvec2 g0 = r[side ? 3 : 1], g1 = r[side ? 0 : 2], peak = side ? left : right;
        b.triangle(p.plaster[lot.tint], Place(1), raise(g0, lot.eaves), raise(g1, lot.eaves), raise(peak, top));
    }
    if (eaves) {
        const Place place = wall_frame(left, right, top);
        const double l = length(right - left);
        const Point cap[3][2] = {{{-0.1, -0.1, 0.2}, {-0.1, 0.09, 0}}, {{-0.1, 0.09, 0}, {-0.1, -0.1, -0.2}}};
        for (int k = 0; k < 2; ++k) {
            const Point strip[4] = {cap[k][0], {l + 0.1, cap[k][0].y, cap[k][0].z}, {l + 0.1, cap[k][1].y, cap[k][1].z},
                                    cap[k][1]};
            b.quad(p.terracotta, place, strip, 1, 1, 6);
        }
    }
}

// A flat roof behind a parapet, with a hut over the stairs and a pergola.
void terrace(Builder& b, const Palette& p, const Lot& lot, double allowance) {
    const Ring& r = lot.ring;
    const double parapet = lot.eaves + 1.0, thick = 0.3;
    Ring in;
    const glm::dvec2 centre = 0.25 * (r[0] + r[1] + r[2] + r[3]);
    for (int k = 0; k < 4; ++k) in[k] = r[k] + (centre - r[k]) * (thick * 1.4 / std::max(1.0, length(centre - r[k])));
    for (int k = 0; k < 4; ++k) {
        const int n = (k + 1) % 4;
        const Point top[4] = {raise(r[k], parapet), raise(r[n], parapet), raise(in[n], parapet), raise(in[k], parapet)};
        b.quad(p.travertine, Place(1), top, 1, 1, 3);
        plain_wall(b, p.plaster[lot.tint], in[n], in[k], lot.eaves, parapet);
    }
    const Point floor[4] = {raise(in[0], lot.eaves), raise(in[1], lot.eaves), raise(in[2], lot.eaves),
                            raise(in[3], lot.eaves)};
    const std::int64_t before = b.triangles();
    if (allowance > 90) {
        // The hut over the stairs, its door, and a trellis.
        const glm::dvec2 along = (r[1] - r[0]) / std::max(1e-9, length(r[1] - r[0]));
        const double side = length(r[1] - r[0]);
        const Place place = wall_frame(r[0] + along * 0.6, r[1], lot.eaves);
        const double w = std::min(3.2, 0.4 * side);
        b.box(p.plaster[lot.tint], place, {0.2, 0, -6.4}, {0.2 + w, 2.6, -3.6}, 4);
        b.box(p.tiles, place, {0, 2.6, -6.6}, {0.4 + w, 2.75, -3.4}, 4);
        slab(b, p.wood, place, {0.7, 0, -3.6}, {1.5, 2, -3.55});
        const double from = w + 1.0, to = side - 1.8;
        if (to > from + 1.5 && allowance > 260) {
            for (int k = 0; k < 4; ++k) {
                const double x = k % 2 ? to : from, z = k / 2 ? -2 : -5;
                b.box(p.wood, place, {x, 0, z}, {x + 0.12, 2.3, z + 0.12});
            }
            const int beams = std::clamp(int(allowance / 60), 4, 14);
            for (int k = 0; k < beams; ++k) {
                const double x = from + (to - from) * k / (beams - 1);
                b.box(p.wood, place, {x, 2.3, -5.3}, {x + 0.1, 2.4, -1.6});
            }
        }
    }
    const double rest = allowance - 16 - double(b.triangles() - before);
    const int cells = std::max(1, int(std::sqrt(std::max(0.0, rest) / 2)));
    b.quad(p.paving, Place(1), floor, std::clamp(int(rest / 2 / cells), 1, 400), cells, 4);
}

}  // namespace

void roof_slope(Builder& b, const Palette& p, const Point c[4], double allowance) {
    const Point across = c[1] - c[0], up = 0.5 * (c[3] + c[2] - c[0] - c[1]);
    const double width = std::sqrt(glm::dot(across, across)), height = std::sqrt(glm::dot(up, up));
    const double quads = std::max(1.0, std::floor(allowance / 2 + 0.5));
    Point normal = glm::cross(across, up);
    normal /= std::max(1e-9, std::sqrt(glm::dot(normal, normal)));

    // Waves of 0.44 m, or up to 0.75 m where there is little to spend: 2 to 8 columns each, then rows of tiles.
    const double wave = std::max(0.44, 2 * width / quads);
    Grid g;
    if (wave > 0.75) {
        g.columns = int(std::min(quads, 4.0)), g.rows = std::max(1, int(quads / g.columns + 0.5));
        g.texture = {width / 7, height / 7};
        b.grid(p.tiles, Place(1), g, [&](double u, double v) {
            return (1 - v) * ((1 - u) * c[0] + u * c[1]) + v * ((1 - u) * c[3] + u * c[2]);
        });
        return;
    }
    const int waves = std::max(1, int(width / wave + 0.5)), most_rows = 2 * std::max(1, int(height / 0.42 + 0.5));
    int each = 2;
    while (each < 12 && quads > double(waves) * each * most_rows * (each == 2 ? 0.5 : 1)) each += 2;
    g.columns = waves * each;
    g.rows = std::clamp(int(quads / g.columns + 0.5), 1, 2 * most_rows);
    const bool steps = 3 * g.rows >= 2 * most_rows;
    g.texture = {waves / 16.0, (steps ? g.rows : height / 0.42) / 16.0};
    const double amplitude = 0.09;
    b.grid(p.terracotta, Place(1), g, [&](double u, double v) {
        const int i = int(u * g.columns + 0.5) % each, j = int(v * g.rows + 0.5);
        const double t = double(i) / each, hump = each == 2 ? i : std::min(1.0, 5.2 * t * (1 - t));
        // A tile lies on the next lower one: its lower end is raised.
        const double s = steps ? (j % 2 ? double(j + 1) / g.rows - 0.15 / g.rows : double(j) / g.rows) : v;
        const double end = steps && j % 2 == 0 && j < g.rows ? 0.05 : 0.0, w = std::min(1.0, s);
        const Point flat = (1 - w) * ((1 - u) * c[0] + u * c[1]) + w * ((1 - u) * c[3] + u * c[2]);
        return flat + (amplitude * hump + end) * normal;
    });
}

void house(Builder& b, const Palette& p, const Lot& lot, double allowance) {
    const std::int64_t before = b.triangles();
    Dice dice{lot.seed};
    const Ring& r = lot.ring;
    const double storey_bay = lot.palace ? 3.1 : 2.5;
    const auto side = [&](int k, bool street) {
        const double width = length(r[(k + 1) % 4] - r[k]);
        return Facade{width, lot.eaves, width < 2.6 ? 0 : std::max(1, int(width / storey_bay + 0.3)), lot.storeys,
                      lot.palace, street};
    };
    const Facade front = side(0, true), back = side(2, false);
    const bool flat = !lot.palace && !lot.detached && allowance > 24 && dice.chance(0.16);

    // The finest facades that leave three tenths to the roof; the court's side stays simple.
    int level = finest, rear = 0;
    for (; level > 0; --level) {
        rear = std::min(level, 2);
        if (facade_cost(front, level) + facade_cost(back, rear) < 0.72 * (allowance - 20)) break;
        rear = 0;
        if (level == 1 && facade_cost(front, 1) + 2 < 0.72 * (allowance - 20)) break;
    }
    facade(b, p, wall_frame(r[0], r[1], 0), front, lot.tint, level, dice);
    facade(b, p, wall_frame(r[2], r[3], 0), back, lot.tint, level == 0 ? 0 : rear, dice);
    const double walls = flat ? lot.eaves + 1.0 : lot.eaves;
    for (int k = 1; k < 4; k += 2) {
        if (lot.detached)
            facade(b, p, wall_frame(r[k], r[(k + 1) % 4], 0), side(k, true), lot.tint, 0, dice);
        else
            plain_wall(b, p.plaster[lot.tint], r[k], r[(k + 1) % 4], 0, walls);
    }
    if (flat)
        for (int k = 0; k < 4; k += 2)
            plain_wall(b, p.plaster[lot.tint], r[k], r[k + 1], lot.eaves, walls);
    if (level >= 2) {
        // The cornice under the roof.
        const Place place = wall_frame(r[0], r[1], lot.eaves);
        const double deep = lot.palace ? 0.5 : 0.25;
        slab(b, p.travertine, place, {0, -0.75, 0}, {front.width, -0.55, 0.6 * deep});
        slab(b, p.travertine, place, {0, -0.55, 0}, {front.width, -0.3, deep});
    }
    const double deep = std::min(length(r[3] - r[0]), length(r[2] - r[1]));
    const int chimneys = !flat && allowance > 120 ? 1 + dice.pick(3) : 0;
    for (int k = 0; k < chimneys; ++k) chimney(b, p, lot, lot.eaves + 0.26 * deep, dice);
    const double rest = allowance - double(b.triangles() - before);
    if (flat)
        terrace(b, p, lot, rest);
    else
        pitched_roof(b, p, lot, rest);
}

}  // namespace plumb::io::scenes::town
