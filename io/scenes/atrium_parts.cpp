#include "io/scenes/atrium_parts.h"

#include <algorithm>
#include <cmath>

#include "core/host_math.h"

namespace plumb::io::scenes::parts {
namespace {

using host::pi;

double smoothstep(double low, double high, double x) {
    const double t = std::min(std::max((x - low) / (high - low), 0.0), 1.0);
    return t * t * (3 - 2 * t);
}

// A bulge from (r, y0) to (r, y1) that stands out by half its height, as `cuts` chords; appended without its first
// point where the profile ends there already.
void torus(std::vector<glm::dvec2>& profile, double r, double y0, double y1, int cuts) {
    const double half = (y1 - y0) / 2;
    for (int k = profile.empty() || profile.back() != glm::dvec2(r, y0) ? 0 : 1; k <= cuts; ++k) {
        const double angle = pi * k / cuts;
        const double out = k == 0 || k == cuts ? 0 : half * host::sin(angle);
        profile.push_back({r + out, y0 + half - half * host::cos(angle)});
    }
    profile.back().y = y1;
}

// Height of the point at the angle that u stands for: u = 0 left, 1 right.
glm::dvec2 on_arch(double u) {
    if (u == 0.5) return {0, 1};
    const double angle = pi * (1 - u);
    return u == 0 ? glm::dvec2(-1, 0) : u == 1 ? glm::dvec2(1, 0) : glm::dvec2(host::cos(angle), host::sin(angle));
}

}  // namespace

int cut(double detail, double base, int least) { return std::max(least, int(base * detail + 0.5)); }

void column(Builder& b, const Surface& s, const Place& place, const Column& c, double detail) {
    const int around = cut(detail, 24, 5), chords = cut(detail, 5, 2);
    const double r = c.radius, plinth = 0.3 * c.plinth, base = plinth + 0.75 * r;
    const double abacus = c.height - 0.3 * c.abacus, capital = abacus - 2.1 * r;
    b.box(s.material, place, {-c.plinth, 0, -c.plinth}, {c.plinth, plinth, c.plinth}, s.size);
    b.box(s.material, place, {-c.abacus, abacus, -c.abacus}, {c.abacus, c.height, c.abacus}, s.size);

    if (detail < 0.15) {
        b.lathe(s.material, place, {{r, plinth}, {0.9 * r, capital}, {1.3 * r, abacus}}, around, s.size, 91);
        return;
    }
    // The base: a thick torus, a hollow, a thin torus.
    std::vector<glm::dvec2> foot;
    torus(foot, 1.22 * r, plinth, plinth + 0.36 * r, chords);
    foot.push_back({1.14 * r, plinth + 0.4 * r});
    foot.push_back({1.1 * r, plinth + 0.5 * r});
    torus(foot, 1.1 * r, plinth + 0.54 * r, base, std::max(2, chords - 1));
    foot.push_back({0.95 * r, base});
    b.lathe(s.material, place, foot, around, s.size, 50);

    // The shaft swells below its middle and ends in a ring.
    std::vector<glm::dvec2> shaft;
    const int drums = cut(detail, 8, 1);
    for (int k = 0; k <= drums; ++k) {
        const double t = double(k) / drums;
        shaft.push_back({r * (1 + 0.06 * t * (1 - t) * 2 - 0.12 * t * t), base + t * (capital - base)});
    }
    torus(shaft, 0.88 * r, capital, capital + 0.16 * r, std::max(2, chords - 1));
    shaft.push_back({0.8 * r, capital + 0.16 * r});
    b.lathe(s.material, place, shaft, around, s.size, 50);

    // The capital: a bell with two rows of leaves that curl outwards.
    Grid g;
    g.columns = 2 * around, g.rows = cut(detail, 14, 3);
    g.texture = {std::max(1.0, std::floor(2 * pi * r / s.size + 0.5)), 2 * r / s.size};
    g.closed_u = true;
    const double low = capital + 0.16 * r, height = abacus - low;
    b.grid(s.material, place, g, [&](double u, double v) {
        const double angle = u == 1 ? 0 : 2 * pi * u;
        auto leaf = [&](double from, double to, double phase) {
            const double t = (v - from) / (to - from);
            if (t < 0 || t > 1) return 0.0;
            const double lobe = std::max(0.0, host::cos(8 * angle + phase));
            return (0.04 + 0.26 * t * t * t) * std::sqrt(lobe) * (1 - smoothstep(0.9, 1.0, t));
        };
        const double bell = 0.86 + 0.5 * v * v * v;
        const double at = r * (bell + std::max(leaf(0, 0.5, 0), leaf(0.3, 0.86, pi)));
        return Point(at * host::sin(angle), low + v * height, at * host::cos(angle));
    });
}

void arch_wall(Builder& b, const Surface& s, const Place& place, const ArchWall& w, double detail) {
    // The face is cut along rays to the upper corners, so that they are corners of triangles.
    const double corner = host::atan2(w.height, w.half_width) / pi;
    const double cuts[] = {0, corner, 1 - corner, 1};
    const int columns[] = {cut(detail, 6, 1), cut(detail, 12, 2), cut(detail, 6, 1)};
    Grid g;
    g.rows = cut(detail, 2, 1);
    g.projection = [&](const Point& p) { return glm::dvec2(p.x, -p.y) / s.size; };
    for (int side = 0; side < 2; ++side)
        for (int k = 0; k < 3; ++k) {
            g.columns = columns[k];
            b.grid(s.material, side == 0 ? place : place * turn_y(180), g, [&](double u, double v) {
                const double at = u == 1 ? cuts[k + 1] : cuts[k] + u * (cuts[k + 1] - cuts[k]);
                const glm::dvec2 inner = w.radius * on_arch(at);
                const glm::dvec2 outer = k == 0   ? glm::dvec2(-w.half_width, u * w.height)
                                         : k == 1 ? glm::dvec2(w.half_width * (2 * u - 1), w.height)
                                                  : glm::dvec2(w.half_width, (1 - u) * w.height);
                const glm::dvec2 p = inner + v * (outer - inner);
                return Point(p.x, p.y, w.thickness / 2);
            });
        }
    for (int k = 0; k < 3; ++k) {
        g.columns = columns[k], g.rows = 1;
        g.projection = nullptr;
        g.texture = {pi * w.radius * (cuts[k + 1] - cuts[k]) / s.size, w.thickness / s.size};
        b.grid(s.material, place, g, [&](double u, double v) {
            const glm::dvec2 p = w.radius * on_arch(u == 1 ? cuts[k + 1] : cuts[k] + u * (cuts[k + 1] - cuts[k]));
            return Point(p.x, p.y, w.thickness * (v - 0.5));
        });
    }
}

void arch_moulding(Builder& b, const Surface& s, const Place& place, double radius, const Profile& profile,
                   double detail) {
    b.sweep(s.material, place, profile, cut(detail, 24, 6), pi * radius, s.size,
            [&](double u, const glm::dvec2& p) {
                const glm::dvec2 a = (radius + p.x) * on_arch(u);
                return Point(a.x, a.y, p.y);
            });
}

void groin_vault(Builder& b, const Surface& s, const Place& place, double half, double detail) {
    Grid g;
    g.columns = cut(detail, 12, 4), g.rows = cut(detail, 6, 1);
    g.pole = true;
    g.projection = [&](const Point& p) { return glm::dvec2(p.x, p.z) / s.size; };
    for (int web = 0; web < 4; ++web)
        b.grid(s.material, place * turn_y(90 * web), g, [&](double u, double v) {
            const glm::dvec2 a = on_arch(u);
            const double x = half * v * a.x;
            return Point(x, std::sqrt(std::max(half * half - x * x, 0.0)), half * v);
        });
}

void curtain(Builder& b, const Surface& s, const Surface& metal, const Place& place, const Curtain& c,
             double detail) {
    const double phase = 2 * pi * white_noise(int(c.seed), 0, 7), lean = 0.3 * (white_noise(int(c.seed), 1, 7) - 0.5);
    const int halves = c.drawn ? 2 : 1;
    Grid g;
    g.columns = cut(detail, c.drawn ? 44 : 72, 4), g.rows = cut(detail, 36, 2);
    const double cloth_width = 2.6 * c.half_width / halves;
    g.texture = {cloth_width / s.size, -c.height / s.size};
    for (int half = 0; half < halves; ++half)
        b.cloth(s.material, place, g, {0, 0, 0.012}, [&](double u, double v) {
            // How wide it hangs: tied to the side at two fifths of its height.
            const double full = 2 * c.half_width / halves, tie = 0.42;
            double width = full;
            if (c.drawn) {
                const double above = smoothstep(tie, 1, v), below = smoothstep(tie, 0, v);
                width = full * (v > tie ? 0.2 + 0.8 * above * std::sqrt(above) : 0.2 + 0.22 * below);
            }
            // Narrow cloth folds deeper; folds open downwards.
            const double depth = c.drawn ? 0.035 + 0.05 * (1 - width / full) : 0.035 + 0.055 * (1 - v);
            const double warp = u + 0.012 * host::sin(2 * pi * (2 * v + u) + phase);
            const double folds = c.drawn ? 5 : 8;
            double z = depth * (host::sin(2 * pi * folds * warp + phase) +
                                0.3 * host::sin(2 * pi * (1.7 * folds * warp + lean * v) + 2 * phase));
            z += 0.06 * host::sin(pi * u) * host::sin(pi * (1 - v) * 0.9 + phase) * (1 - v);
            const double x = half == 0 ? -c.half_width + width * u : c.half_width - width * (1 - u);
            const double sag = c.drawn ? 0.12 * smoothstep(tie, 1, v) * (1 - smoothstep(0.9, 1.0, v)) : 0.0;
            const double inner = half == 0 ? u : 1 - u;
            return Point(x, -c.height * (1 - v) - sag * inner + 0.02 * (1 - v) * z / depth, z);
        });

    // The rod; the ties.
    if (detail < 0.15) return;
    const Place rod = place * move({-c.half_width - 0.05, 0.02, 0}) * turn_y(90) * turn_x(90);
    const double length = 2 * c.half_width + 0.1;
    b.lathe(metal.material, rod, {{0, 0}, {0.022, 0}, {0.022, length}, {0, length}}, cut(detail, 10, 4), metal.size);
    if (!c.drawn) return;
    for (int half = 0; half < 2; ++half) {
        const double x = (half == 0 ? -1 : 1) * 0.9 * c.half_width;
        const Place at = place * move({x, -0.58 * c.height, 0}) * scale({1.15, 1, 1.1});
        b.lathe(metal.material, at, {{0.1, -0.05}, {0.125, -0.03}, {0.125, 0.03}, {0.1, 0.05}, {0.1, -0.05}},
                cut(detail, 16, 5), metal.size);
    }
}

void baluster(Builder& b, const Surface& s, const Place& place, double height, double radius, double detail) {
    // Radii along its height, as a turner reads them off a template.
    static const glm::dvec2 shape[] = {{0.85, 0},   {0.85, 0.06}, {0.5, 0.1},   {0.62, 0.16}, {0.95, 0.26},
                                       {1, 0.33},   {0.86, 0.43}, {0.55, 0.56}, {0.4, 0.7},   {0.38, 0.8},
                                       {0.6, 0.84}, {0.6, 0.88},  {0.48, 0.9},  {0.85, 0.94}, {0.85, 1}};
    static const int coarse[] = {0, 5, 9, 14}, middle[] = {0, 1, 2, 4, 5, 6, 8, 10, 12, 13, 14};
    std::vector<glm::dvec2> profile = {{0, 0}};
    auto add = [&](int k) { profile.push_back({shape[k].x * radius, shape[k].y * height}); };
    if (detail < 0.4)
        for (int k : coarse) add(k);
    else if (detail < 1.2)
        for (int k : middle) add(k);
    else
        for (int k = 0; k < 15; ++k) add(k);
    profile.push_back({0, height});
    b.lathe(s.material, place, profile, cut(detail, 10, 4), s.size, 50);
}

void door(Builder& b, const Surface& frame, const Surface& leaf, const Surface& metal, const Place& place, double width,
          double height) {
    const double h = width / 2;
    b.box(frame.material, place, {-h - 0.2, 0, 0}, {-h, height, 0.12}, frame.size);
    b.box(frame.material, place, {h, 0, 0}, {h + 0.2, height, 0.12}, frame.size);
    b.box(frame.material, place, {-h - 0.28, height, 0}, {h + 0.28, height + 0.22, 0.16}, frame.size);
    b.box(frame.material, place, {-h - 0.36, height + 0.22, 0}, {h + 0.36, height + 0.32, 0.24}, frame.size);
    for (int side = -1; side <= 1; side += 2) {
        const double x0 = side < 0 ? -h : 0.01, x1 = side < 0 ? -0.01 : h;
        b.box(leaf.material, place, {x0, 0, 0}, {x1, height, 0.05}, leaf.size);
        for (int panel = 0; panel < 3; ++panel) {
            const double y0 = height * (0.05 + 0.32 * panel), y1 = y0 + height * 0.27;
            b.box(leaf.material, place, {x0 + 0.12 * h, y0, 0}, {x1 - 0.12 * h, y1, 0.075}, leaf.size);
        }
        const Place knob = place * move({side * 0.09, 0.45 * height, 0.05}) * turn_x(90);
        b.lathe(metal.material, knob, {{0, 0}, {0.02, 0}, {0.02, 0.03}, {0.045, 0.05}, {0.03, 0.085}, {0, 0.09}}, 8,
                metal.size);
    }
}

void lantern(Builder& b, const Surface& metal, const Surface& glass, const Place& place, double chain, double detail) {
    const int around = cut(detail, 8, 6);
    b.lathe(metal.material, place, {{0, -chain}, {0.012, -chain}, {0.012, 0}, {0, 0}}, 4, metal.size);
    const Place at = place * move({0, -chain, 0});
    b.lathe(metal.material, at, {{0, -0.13}, {0.2, -0.12}, {0.19, -0.08}, {0.06, 0.02}, {0.02, 0.06}, {0, 0.06}},
            around, metal.size);
    b.lathe(glass.material, at, {{0, -0.5}, {0.09, -0.5}, {0.15, -0.121}, {0, -0.121}}, around, glass.size);
    b.lathe(metal.material, at, {{0, -0.6}, {0.02, -0.58}, {0.12, -0.52}, {0.11, -0.49}, {0, -0.49}}, around,
            metal.size);
    // Bars over the panes.
    for (int k = 0; k < 4; ++k) {
        const Place bar = at * turn_y(90 * k + 45);
        const Point corners[] = {
            {-0.012, -0.5, 0.1}, {0.012, -0.5, 0.1}, {0.012, -0.12, 0.165}, {-0.012, -0.12, 0.165}};
        b.quad(metal.material, bar, corners, 1, 1, metal.size);
    }
}

void urn(Builder& b, const Surface& s, const Surface& leaves, const Place& place, std::uint32_t seed, double detail) {
    b.box(s.material, place, {-0.32, 0, -0.32}, {0.32, 0.08, 0.32}, s.size);
    b.box(s.material, place, {-0.27, 0.08, -0.27}, {0.27, 0.5, 0.27}, s.size);
    b.box(s.material, place, {-0.32, 0.5, -0.32}, {0.32, 0.57, 0.32}, s.size);
    std::vector<glm::dvec2> profile = {{0, 0.57}, {0.2, 0.57}, {0.2, 0.6}, {0.09, 0.66}, {0.09, 0.7}};
    const int cuts = cut(detail, 8, 2);
    for (int k = 1; k <= cuts; ++k) {
        const double t = double(k) / cuts;
        profile.push_back({0.09 + 0.27 * host::sin(0.62 * pi * t) / host::sin(0.62 * pi), 0.7 + 0.42 * t});
    }
    profile.insert(profile.end(), {{0.4, 1.16}, {0.4, 1.2}, {0.34, 1.2}, {0.3, 1.1}, {0, 1.1}});
    b.lathe(s.material, place, profile, cut(detail, 24, 6), s.size, 40);

    // Leaves rise from the rim and fall over it.
    const int fronds = 9;
    Grid g;
    g.columns = cut(detail, 3, 1), g.rows = cut(detail, 8, 2);
    g.texture = {0.5, 1.1};
    for (int k = 0; k < fronds; ++k) {
        const double reach = 0.42 + 0.25 * white_noise(k, int(seed), 11);
        const double rise = 0.25 + 0.3 * white_noise(k, int(seed), 12);
        b.grid(leaves.material, place * turn_y(360.0 * k / fronds + 30 * white_noise(k, int(seed), 13)), g,
               [&](double u, double v) {
                   const double t = 1 - v, width = 0.24 * (1 - 0.4 * t);
                   return Point((2 * u - 1) * width, 1.1 + rise * 4 * t * (1 - t) - 0.55 * t * t, 0.05 + reach * t);
               });
    }
}

void hanging_leaves(Builder& b, const Surface& leaves, const Place& place, double width, double height,
                    std::uint32_t seed, double detail) {
    Grid g;
    g.columns = cut(detail, 8, 2), g.rows = cut(detail, 10, 2);
    g.texture = {width / leaves.size, -height / leaves.size};
    // Three layers; each ends in strands of its own length.
    for (int layer = 0; layer < 3; ++layer)
        b.grid(leaves.material, place, g, [&](double u, double v) {
            const double ragged = 0.45 + 0.55 * smooth_noise(u, 0.37 + 0.21 * layer, 5, seed + std::uint32_t(layer));
            const double bulge = 0.1 * smooth_noise(u, v, 4, seed + 9 + std::uint32_t(layer));
            const double x = width * (u - 0.5) * (0.85 + 0.15 * v);
            return Point(x + 0.05 * layer, -(1 - v) * height * ragged, 0.03 + 0.05 * layer + bulge * (1 - 0.5 * v));
        });
}

void dentils(Builder& b, const Surface& s, const Place& place, double length, double spacing, const Point& size) {
    const int count = std::max(1, int(length / spacing));
    for (int k = 0; k < count; ++k) {
        const double x = length * ((k + 0.5) / count - 0.5);
        b.box(s.material, place, {x - size.x / 2, 0, 0}, {x + size.x / 2, size.y, size.z}, s.size);
    }
}

}  // namespace plumb::io::scenes::parts
