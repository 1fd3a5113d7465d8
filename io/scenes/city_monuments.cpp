// The amphitheatre, the domed church, its colonnade with an obelisk, and the bridges.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "io/scenes/city_parts.h"

namespace plumb::io::scenes::town {
namespace {

// A wall along an ellipse about `centre`: x is the angle (radians, from +x towards -z), z metres outwards.
Bend around(const glm::dvec2& centre, double a, double b) {
    return [=](double turn, double y, double z) {
        return Point(centre.x + (a + z) * host::cos(turn), y, centre.y - (b + z) * host::sin(turn));
    };
}
// The same wall seen from its other side, `thick` behind the front.
Bend behind(const Bend& bend, double from, double to, double thick) {
    return [=](double x, double y, double z) { return bend(from + to - x, y, -thick - z); };
}

constexpr double full = 2 * host::pi;

// The outer ring of the amphitheatre has fallen where it looks to the south-west: from there one sees into it.
bool has_fallen(double turn) {
    const double t = turn - full * std::floor(turn / full);
    return t > 3.3 && t < 5.6;
}

// One ring of arcades: storeys of arches between engaged columns, a cornice over each.
void arcade_ring(Builder& b, const Palette& p, const Bend& bend, int bays, int arc, const std::vector<double>& floors,
                 bool outer, int column_segments, double radius) {
    const double step = full / bays;
    for (int i = 0; i < bays; ++i) {
        const double t0 = i * step, t1 = t0 + step;
        const bool fallen = outer && has_fallen(t0 + step / 2);
        for (std::size_t k = 0; k + 1 < floors.size(); ++k) {
            const double y0 = floors[k], y1 = floors[k + 1];
            if (fallen) continue;
            // Half widths and depths are metres; along the wall x is an angle.
            const double metres = radius, half = 0.29 * step;
            Arch a{t0, t1, y0, y1, half, y0 + 0.45 * (y1 - y0), 2.6, arc, true, 5};
            // The arch is round in metres: the bend squeezes its height.
            const double rise = half * metres, crown = a.springing;
            const Bend round = [&](double x, double y, double z) {
                if (y > crown + 1e-9 && y < y1 - 1e-9) {
                    const double over = (y - crown) / half;
                    if (over <= 1.0 + 1e-9) y = crown + std::min(rise * over, 0.85 * (y1 - crown));
                }
                return bend(x, y, z);
            };
            Arch local = a;
            local.y1 = y1;
            arch(b, p.travertine, local, round);
            if (column_segments > 0) {
                const Point foot = bend(t0, y0, 0.1);
                column(b, p.travertine, move(foot), y1 - y0 - 0.8, 0.6, column_segments);
            }
        }
    }
    // Cornices and the top, in one piece for each stretch that stands.
    for (int i = 0; i < bays;) {
        int end = i;
        while (end < bays && outer == false) end = bays;
        while (end < bays && !has_fallen((end + 0.5) * step)) ++end;
        if (end > i) {
            for (std::size_t k = 1; k < floors.size(); ++k) {
                const double y = floors[k];
                const std::vector<glm::dvec2> profile = {
                    {0, y - 0.9}, {0.45, y - 0.7}, {0.9, y - 0.2}, {0.9, y}, {0, y + 0.15}};
                moulding(b, p.travertine, i * step, end * step, end - i, profile, bend, 3.0 * (end - i));
            }
            const double y = floors.back();
            moulding(b, p.travertine, i * step, end * step, end - i, {{0, y}, {-2.6, y}}, bend, 1.5 * (end - i));
            for (int cut = 0; cut < 2; ++cut)
                if (outer) {  // where the ring breaks off
                    const double t = (cut ? end : i) * step;
                    Point c[4] = {bend(t, 0, cut ? 0 : -2.6), bend(t, 0, cut ? -2.6 : 0), bend(t, y, cut ? -2.6 : 0),
                                  bend(t, y, cut ? 0 : -2.6)};
                    b.quad(p.brick, Place(1), c, 1, 4, 5);
                }
        }
        i = std::max(end, i + 1);
        while (i < bays && outer && has_fallen((i + 0.5) * step)) ++i;
    }
}

}  // namespace

void amphitheatre(Builder& b, const Palette& p, const Grade& grade) {
    const double a = 56, c = 47;
    const Bend outer = around(arena, a, c), inner = around(arena, a - 7, c - 7);
    const int bays = grade.fine < 1 ? 12 : std::max(20, 4 * (grade.count(10, 80) / 4));
    if (grade.fine < 1.3) {
        Grid g;
        g.columns = bays, g.texture = {40, 1}, g.closed_u = true;
        b.grid(p.arches, Place(1), g, [&](double u, double v) { return outer(full * u, 36 * v, 0); });
    } else {
        const int arc = grade.fine < 2.4 ? 4 : grade.fine < 3.3 ? 8 : 16;
        const int segments = grade.fine < 2.4 ? 0 : grade.fine < 3.3 ? 5 : grade.fine < 3.8 ? 8 : 12;
        arcade_ring(b, p, outer, bays, arc, {0, 10.5, 20.5, 30}, true, segments, 0.92 * (a + c) / 2);
        arcade_ring(b, p, inner, bays, arc, {0, 10.5, 20.5}, false, segments, 0.92 * (a + c) / 2 - 7);
        // The attic: a closed storey with small windows.
        const double step = full / bays;
        for (int i = 0; i < bays; ++i) {
            const double t0 = i * step, t1 = t0 + step, m = (t0 + t1) / 2, w = 0.09 * step;
            if (has_fallen(m)) continue;
            const double xs[4] = {t0, m - w, m + w, t1}, ys[4] = {30, 33.5, 35.6, 39};
            for (int x = 0; x < 3; ++x)
                for (int y = 0; y < 3; ++y) {
                    const double z = x == 1 && y == 1 ? -0.8 : 0;
                    const Point q[4] = {outer(xs[x], ys[y], z), outer(xs[x + 1], ys[y], z),
                                        outer(xs[x + 1], ys[y + 1], z), outer(xs[x], ys[y + 1], z)};
                    b.quad(z < 0 ? p.glass : p.travertine, Place(1), q, 1, 1, 5);
                }
            moulding(b, p.travertine, t0, t1, 1,
                     {{0, 38.2}, {0.5, 38.3}, {1.0, 38.9}, {1.0, 39.2}, {-1.6, 39.2}, {-1.6, 30}}, outer, 3);
        }
    }
    // The seats: wedges of steps, worn in places; then the sand and the walls below it.
    const int around_count = std::max(bays, 16), steps = grade.fine < 1.3 ? 1 : grade.count(3, 34);
    const double top = grade.fine < 1.3 ? 30 : 20.5, out = grade.fine < 1.3 ? 0 : -9.6;
    for (int k = 0; k < steps; ++k) {
        const double s = double(k) / steps, t = double(k + 1) / steps;
        const double z0 = -28 + s * (28 + out), z1 = -28 + t * (28 + out);
        const double y0 = 3 + s * (top - 3), y1 = 3 + t * (top - 3);
        // A riser begins where the tread before it ends, worn or not.
        const Bend worn = [&](double turn, double y, double z) {
            const int i = int(turn / full * around_count + 0.5) % around_count, tread = y > y0 + 1e-9 ? k : k - 1;
            const bool lower = grade.fine >= 2 && tread >= 0 && tread + 1 < steps && white_noise(i, tread, 91) > 0.8;
            return outer(turn, y - (lower ? 0.7 * (y1 - y0) : 0), z);
        };
        // Seen from the middle: the riser, then the tread.
        moulding(b, k % 9 == 8 ? p.brick : p.stone, 0, full, around_count, {{z1, y1}, {z0, y1}, {z0, y0}}, worn, 60);
    }
    if (grade.fine >= 1.3)
        moulding(b, p.brick, 0, full, around_count, {{-9.6, 20.5}, {-7, 20.5}}, [&](double t, double y, double z) {
            return outer(full - t, y, z);
        }, 60);
    Grid wall;
    wall.columns = around_count, wall.texture = {40, 0.6}, wall.closed_u = true;
    b.grid(p.brick, Place(1), wall, [&](double u, double v) { return outer(-full * u, 0.05 + 2.95 * v, -28); });
    Grid sand;
    sand.columns = around_count, sand.texture = {1, 1};
    b.grid(p.earth, Place(1), sand, [&](double u, double v) {
        const Point edge = outer(full * u, 0.06, -28);
        return edge + v * (Point(arena.x, 0.06, arena.y) - edge);
    });
    const int walls = grade.fine < 2 ? 0 : 9;
    for (int k = 0; k < walls; ++k) {
        const double z = arena.y + (k - 4) * 3.6, half = 26 * std::sqrt(std::max(0.0, 1 - (k - 4) * (k - 4) / 30.0));
        for (double x = -half; x < half - 3; x += 7)
            b.box(p.brick, Place(1), {arena.x + x, 0, z},
                  {arena.x + x + 5.4, 1.2 + 1.3 * white_noise(k, int(x) + 90, 17), z + 0.8}, 3);
    }
}

namespace {

void dome(Builder& b, const Palette& p, const Grade& grade, const Place& place, double radius, int ribs) {
    const int segments = std::max(8, 2 * (grade.count(4, 64) / 2)), rows = grade.count(3, 28);
    std::vector<glm::dvec2> profile;
    for (int k = 0; k <= rows; ++k) {
        const double t = 0.5 * host::pi * 0.93 * k / rows;
        profile.push_back({radius * host::cos(t), 1.18 * radius * host::sin(t)});
    }
    b.lathe(p.lead, place, profile, segments, 4);
    if (grade.fine >= 1.5)
        for (int k = 0; k < ribs; ++k) {
            const Place at = place * turn_y(360.0 * k / ribs);
            Grid g;
            g.columns = 3, g.rows = rows, g.smooth = false;
            b.grid(p.travertine, at, g, [&](double u, double v) {
                const glm::dvec2 q = profile[std::size_t(v * rows + 0.5)];
                const int i = int(u * 3 + 0.5);
                const double lift = i == 1 || i == 2 ? 1.025 : 0.99,
                             w = (i < 2 ? -1 : 1) * 0.035 * (q.x + 0.25 * radius);
                return Point(w, q.y * (i == 1 || i == 2 ? 1.02 : 1), q.x * lift);
            });
        }
    // The lantern with its own small dome, ball and cross.
    const Place up = place * move({0, profile.back().y - 0.2, 0});
    const double r = 0.17 * radius;
    const int few = std::max(6, segments / 2);
    b.lathe(p.travertine, up,
            {{1.3 * r, 0}, {1.3 * r, 0.3 * r}, {r, 0.35 * r}, {r, 2.2 * r}, {1.3 * r, 2.3 * r}, {1.3 * r, 2.5 * r}},
            few, 2);
    b.lathe(p.lead, up * move({0, 2.5 * r, 0}),
            {{1.2 * r, 0}, {0.9 * r, 0.7 * r}, {0.3 * r, 1.2 * r}, {0.12 * r, 1.9 * r}, {0, 2.0 * r}}, few, 2);
    b.box(p.metal, up, {-0.07, 4.4 * r, -0.07}, {0.07, 4.4 * r + 2.2, 0.07});
    b.box(p.metal, up, {-0.6, 4.4 * r + 1.4, -0.07}, {0.6, 4.4 * r + 1.55, 0.07});
}

void drum(Builder& b, const Palette& p, const Grade& grade, const Place& place, double radius, double height) {
    const int bays = grade.fine < 1.5 ? 0 : 16;
    if (bays == 0) {
        b.lathe(p.travertine, place, {{radius, 0}, {radius, height}}, std::max(8, 2 * (grade.count(4, 64) / 2)), 4);
        return;
    }
    const Bend bend = [&](double turn, double y, double z) {
        return Point(place * glm::dvec4((radius + z) * host::sin(turn), y, (radius + z) * host::cos(turn), 1));
    };
    const double step = full / bays;
    const int arc = grade.fine < 3 ? 4 : 8;
    for (int k = 0; k < bays; ++k) {
        const double t0 = k * step, t1 = t0 + step, half = 0.2 * step;
        const double spring = 0.58 * height;
        const Bend round = [&](double x, double y, double z) {
            if (y > spring && y < spring + half + 1e-9) y = spring + (y - spring) * radius;
            return bend(x, y, z);
        };
        arch(b, p.travertine, {t0, t1, 0.15 * height, 0.9 * height, half, spring, 1, arc, false, 4}, round);
        moulding(b, p.travertine, t0, t1, 1, {{0, 0}, {0, 0.15 * height}}, bend, 1);
        moulding(b, p.glass, t0, t1, 1, {{-1, 0.15 * height}, {-1, 0.9 * height}}, bend, 1);
        const Point foot = bend(t0, 0, 0.7);
        column(b, p.travertine, move(foot), 0.88 * height, 0.55, grade.fine < 2.4 ? 5 : grade.count(5, 20));
    }
    moulding(b, p.travertine, 0, full, 2 * bays,
             {{0, 0.88 * height}, {1.4, 0.9 * height}, {1.6, 0.97 * height}, {1.6, height}, {-0.5, 1.02 * height}},
             bend, 30);
}

}  // namespace

void domed_church(Builder& b, const Palette& p, const Grade& grade) {
    const Place at = move({church.x, 0, church.y});
    const double allowance = grade.count(3, 900);
    // The nave along z, its front to the square; the transept across.
    const auto wing = [&](double x0, double x1, double z0, double z1, double h, double rise, bool along_z) {
        b.box(p.travertine, at, {x0, 0, z0}, {x1, h, z1}, 6);
        const double mx = (x0 + x1) / 2, mz = (z0 + z1) / 2, o = 0.8, d = 0.35;
        for (int side = 0; side < 2; ++side) {
            Point s[4];
            if (along_z) {
                const double x = side ? x0 - o : x1 + o, from = side ? z0 : z1, to = side ? z1 : z0;
                s[0] = {x, h - d, from}, s[1] = {x, h - d, to}, s[2] = {mx, h + rise, to}, s[3] = {mx, h + rise, from};
                b.triangle(p.travertine, at, {x0, h, side ? z0 : z1}, {x1, h, side ? z0 : z1},
                           {mx, h + rise, side ? z0 : z1});
            } else {
                const double z = side ? z0 - o : z1 + o, from = side ? x1 : x0, to = side ? x0 : x1;
                s[0] = {from, h - d, z}, s[1] = {to, h - d, z}, s[2] = {to, h + rise, mz}, s[3] = {from, h + rise, mz};
                b.triangle(p.travertine, at, {side ? x0 : x1, h, z1}, {side ? x0 : x1, h, z0},
                           {side ? x0 : x1, h + rise, mz});
            }
            for (Point& q : s) q += Point(church.x, 0, church.y);
            roof_slope(b, p, s, allowance);
        }
    };
    wing(-13, 13, -42, 44, 24, 7, true);
    wing(-30, 30, -24, 4, 24, 7, false);
    if (grade.fine >= 1) {
        wing(-21, -13, 4, 42, 14, 2.5, true);
        wing(13, 21, 4, 42, 14, 2.5, true);
    }
    // The crossing: a square, the drum, the dome.
    const Place crossing = at * move({0, 0, -10});
    b.box(p.travertine, crossing, {-14.5, 20, -14.5}, {14.5, 33, 14.5}, 6);
    drum(b, p, grade, crossing * move({0, 33, 0}), 13, 12);
    dome(b, p, grade, crossing * move({0, 45, 0}), 13.2, 16);
    if (grade.fine < 1.3) return;
    for (int k = 0; k < 4; ++k) {  // small domes at the corners
        const Place corner = crossing * move({k % 2 ? 20.0 : -20.0, 24, k / 2 ? 20.0 : -20.0});
        b.lathe(p.travertine, corner * move({0, -10, 0}), {{4.4, 0}, {4.4, 13}, {4.9, 13.2}, {4.9, 13.8}},
                grade.count(6, 40), 4);
        b.lathe(p.lead, corner * move({0, 3.8, 0}),
                {{4.6, 0}, {4.2, 1.9}, {3.1, 3.7}, {1.4, 4.9}, {0.4, 5.3}, {0.3, 7}, {0, 7.4}}, grade.count(6, 40), 4);
    }

    // The front: steps, a porch of columns under an entablature and a pediment, windows and doors between.
    const double z = 44;
    for (int k = 0; k < 6; ++k)
        slab(b, p.travertine, at, {-24.0 - k, 0.9 - 0.18 * k - 0.18, z}, {24.0 + k, 0.9 - 0.18 * k, z + 7 + 0.8 * k});
    const int segments = grade.count(5, 28);
    for (int k = 0; k < 8; ++k) {
        const double x = -21 + 6 * k;
        column(b, p.travertine, at * move({x, 0.9, z + 4}), 17, 1.15, segments);
    }
    slab(b, p.travertine, at, {-23, 17.9, z}, {23, 20.6, z + 5.6});
    slab(b, p.travertine, at, {-23.8, 20.6, z}, {23.8, 21.3, z + 6.4});
    slab(b, p.travertine, at, {-20.9, 0, z - 0.1}, {20.9, 20.6, z + 0.4});
    const Point tympanum[3] = {{-23.8, 21.3, z + 5.6}, {23.8, 21.3, z + 5.6}, {0, 29, z + 5.6}};
    b.triangle(p.travertine, at, tympanum[0], tympanum[1], tympanum[2]);
    for (int side = 0; side < 2; ++side) {
        const double s = side ? 1 : -1;
        const Point top[4] = {{s * 24.2, 21.2, z + 6.6}, {s * 24.2, 21.2, z}, {0, 29.4, z}, {0, 29.4, z + 6.6}};
        const Point mirrored[4] = {top[1], top[0], top[3], top[2]};
        b.quad(p.lead, at, side ? top : mirrored, 1, 1, 4);
        const Point rim[4] = {
            {s * 24.2, 20.9, z + 6.6}, {s * 24.2, 21.2, z + 6.6}, {0, 29.4, z + 6.6}, {0, 28.6, z + 6.6}};
        const Point rim_mirrored[4] = {rim[3], rim[2], rim[1], rim[0]};
        b.quad(p.travertine, at, side ? rim : rim_mirrored, 1, 1, 4);
    }
    for (int k = 0; k < 7; ++k) {
        const double x = -18 + 6 * k, w = k == 3 ? 1.7 : 1.1;
        slab(b, k % 2 ? p.wood : p.glass, at, {x - w, k % 2 ? 0.9 : 8.5, z + 0.4},
             {x + w, k % 2 ? 7.2 : 12.5, z + 0.5});
    }
    // Windows along nave and transept.
    for (int side = 0; side < 2; ++side)
        for (int k = 0; k < 5; ++k) {
            const glm::dvec2 o = church + glm::dvec2(side ? 13 : -13, side ? 40.0 - 7 * k : 12.0 + 7 * k);
            const glm::dvec2 to = o + glm::dvec2(0, side ? -1 : 1);
            slab(b, p.travertine, wall_frame(o, to, 17.2), {-1.5, -0.3, 0}, {1.5, 4.6, 0.15});
            slab(b, p.glass, wall_frame(o, to, 17.2), {-1.1, 0, 0.1}, {1.1, 4.2, 0.2});
        }
}

void colonnade(Builder& b, const Palette& p, const Grade& grade) {
    const Bend bend = around(piazza, 58, 42);
    const int columns = grade.fine < 1 ? 5 : grade.count(5, 44), segments = grade.count(4, 20);
    const double half = 1.02;  // radians to each side of the x axis
    for (int side = 0; side < 2; ++side) {
        const double middle = side ? host::pi : 0, from = middle - half, to = middle + half;
        for (int k = 0; k < (grade.fine < 0.8 ? 0 : columns); ++k)
            for (int row = 0; row < (grade.fine < 1.5 ? 1 : 3); ++row) {
                const double turn = from + (to - from) * (k + 0.5) / columns;
                column(b, p.travertine, move(bend(turn, 0.3, 5.2 * row)), 11.2, 0.75, segments);
            }
        // Floor, entablature, roof and balustrade.
        const int pieces = grade.fine < 1.5 ? columns : 2 * columns;
        const double outer = 11.8;
        if (grade.fine < 0.8) {  // a closed passage in place of columns
            moulding(b, p.arches, from, to, pieces, {{outer, 0}, {outer, 13}, {-1.4, 13}}, bend, 24);
            moulding(b, p.arches, from, to, pieces, {{1.4, 0}, {1.4, 13}}, behind(bend, from, to, 0), 24);
            continue;
        }
        moulding(b, p.travertine, from, to, pieces,
                 {{1.4, 11.5}, {1.4, 12.9}, {2.1, 13.2}, {2.1, 13.8}, {1.4, 13.8}, {-outer, 14}},
                 behind(bend, from, to, 0), 30);
        moulding(b, p.travertine, from, to, pieces, {{outer, 11.5}, {outer, 13.9}, {outer - 0.5, 14.0}}, bend, 30);
        moulding(b, p.travertine, from, to, pieces, {{-1.4, 11.5}, {outer, 11.5}}, bend, 30);
        moulding(b, p.travertine, from, to, pieces, {{outer + 1, 0}, {outer + 1, 0.3}, {-2.5, 0.3}, {-2.5, 0}}, bend,
                 30);
        if (grade.fine < 2.2) continue;
        for (int k = 0; k < columns; ++k) {  // statues
            const double turn = from + (to - from) * (k + 0.5) / columns;
            const double lean = 0.1 * (white_noise(k, side, 5) - 0.5);
            b.box(p.travertine, move(bend(turn, 13.8, 0.2)), {-0.5, 0, -0.5}, {0.5, 0.9, 0.5}, 2);
            b.lathe(p.travertine, move(bend(turn, 14.7, 0.2)) * scale({1 + lean, 1, 1 - lean}),
                    {{0.55, 0},
                     {0.42, 0.8},
                     {0.34, 1.2},
                     {0.5, 1.7},
                     {0.38, 2.05},
                     {0.14, 2.15},
                     {0.2, 2.4},
                     {0.12, 2.65},
                     {0, 2.7}},
                    std::max(5, segments - 6), 2);
        }
    }
    // The obelisk on its steps, and two fountains.
    const Place centre = move({piazza.x, 0, piazza.y});
    for (int k = 0; k < (grade.fine < 0.8 ? 0 : 3); ++k)
        b.box(p.travertine, centre, {-4.0 + k, 0.35 * k, -4.0 + k}, {4.0 - k, 0.35 * (k + 1), 4.0 - k}, 3);
    b.box(p.travertine, centre, {-1.7, 1.05, -1.7}, {1.7, 6, 1.7}, 4);
    b.box(p.stone, centre, {-2.0, 6, -2.0}, {2.0, 6.5, 2.0}, 4);
    const auto taper = [&](double w0, double y0, double w1, double y1) {
        for (int k = 0; k < 4; ++k) {
            const Point q[4] = {{-w0, y0, w0}, {w0, y0, w0}, {w1, y1, w1}, {-w1, y1, w1}};
            b.quad(p.brick, centre * turn_y(90.0 * k), q, 1, 1, 9);
        }
    };
    taper(1.35, 6.5, 0.85, 29);
    taper(0.85, 29, 0, 31.5);
    if (grade.fine < 1) return;
    for (int side = -1; side <= 1; side += 2) {
        const Place at = centre * move({side * 27.0, 0, 0});
        const int around_count = grade.count(8, 64);
        b.lathe(p.travertine, at, {{5, 0}, {5, 0.8}, {4.6, 0.8}, {4.6, 0.4}}, around_count, 3);
        b.lathe(p.water, at, {{4.7, 0.6}, {0, 0.62}}, around_count, 3);
        b.lathe(p.travertine, at,
                {{0.9, 0.4},
                 {0.6, 1.4},
                 {0.7, 2.4},
                 {2.4, 3.0},
                 {2.5, 3.2},
                 {2.2, 3.2},
                 {0.6, 2.9},
                 {0.4, 4},
                 {1.2, 4.4},
                 {1.1, 4.5},
                 {0, 4.4}},
                around_count, 3);
    }
}

void bridges(Builder& b, const Palette& p, const Grade& grade) {
    for (const double z : {-120.0, 95.0}) {
        if (grade.fine < 1) {
            const double at = river_x(z);
            b.box(p.travertine, Place(1), {at - river_half - 4, -1.5, z - 5.5}, {at + river_half + 4, 0.4, z + 5.5}, 5);
            continue;
        }
        const double x = river_x(z), half = river_half + 5, width = 6.5;
        const int arcs = 3, arc = grade.fine < 1.5 ? 4 : grade.fine < 3 ? 8 : 16;
        const double step = 2 * half / arcs;
        // The road rises a little to the middle.
        const auto deck = [&](double along) { return 0.15 + 1.5 * (1 - along * along); };
        for (int side = 0; side < 2; ++side) {
            const Bend bend = [&](double along, double y, double out) {
                const double s = side ? -along : along;
                const double lift = y > -0.01 ? deck(s / half) : 0;
                return Point(x + s, y + lift, z + (side ? -1 : 1) * (width - 1.0 + out));
            };
            for (int k = 0; k < arcs; ++k) {
                const double x0 = -half + k * step;
                arch(b, p.travertine, {x0, x0 + step, -7, 0, 0.4 * step, -6.6, width - 1, arc, false, 5},
                     [&](double along, double y, double out) {
                         const double low = y > -6.6 + 1e-9 && y < -1e-9 ? -6.6 + (y + 6.6) * 0.9 : y;
                         return bend(along, std::min(low, 0.0), out);
                     });
            }
            moulding(b, p.travertine, -half, half, 12, {{0, 0}, {0.3, 0}, {0.3, 1.1}, {-0.3, 1.1}, {-0.3, 0}}, bend,
                     12);
        }
        Grid road;
        road.columns = 12, road.texture = {2 * half / 4, 2 * width / 4};
        b.grid(p.paving, Place(1), road, [&](double u, double v) {
            const double s = -half + 2 * half * u;
            return Point(x + s, deck(s / half), z + (width - 1) * (1 - 2 * v));
        });
    }
}

}  // namespace plumb::io::scenes::town
