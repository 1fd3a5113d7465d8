// A courtyard with arcades on two storeys and curtains between the columns of the lower one: the kind of place that the
// Crytek Sponza is, which VRSM renders with 262 thousand triangles. Nothing of that model is in it.
//
//        z = -8 +-----------------------------+       y = 13.3  parapet
//               |  gallery, vaulted below      |           11.2  eaves, 0.75 m into the court
//      z = -4.5 |   +---------------------+    |            8.9  upper arches spring; 1.5 m apart
//               |   |  court, open above  |    |            6.0  upper floor
//       z = 4.5 |   +---------------------+    |            3.7  lower arches spring; 3 m apart
//               |                              |            0    court; galleries lie a step of 0.15 m higher
//           z = 8 +----------------------------+
//            x = -15.5  -12             12   15.5
//
// Seeds 1, 2 and 3 (and all others as 1) are three views for verification: along the court, from the upper gallery,
// and across the court from its other end. The geometry is the same in all of them.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/host_math.h"

#include "io/scenes/atrium_parts.h"
#include "io/scenes/builder.h"
#include "io/scenes/generate.h"
#include "io/scenes/textures.h"

namespace plumb::io::scenes {
namespace {

using parts::cut;
using parts::Surface;

constexpr double court_x = 12, court_z = 4.5;  // half distances between the axes of opposite arcades
constexpr double wall_x = 15, wall_z = 7.5;    // inner faces of the outer walls
constexpr double step = 0.15, spring = 3.7, floor_2 = 6, spring_2 = 8.9, ceiling_2 = 10.7, eaves = 11.2;
constexpr double parapet = 13.3;

struct Palette {
    Surface blocks, limestone, plaster, court, gallery, wood, clay, metal, gold, glass, water, leaves;
    std::array<Surface, 3> cloth;
};

// Painting takes most of the time, so it is left out while triangles are counted.
Palette make_palette(Builder& b) {
    using namespace textures;
    auto textured = [&](const std::string& name, Texture texture, double size, float alpha_cutoff = 0,
                        int normals = -1) {
        texture.mips = true;
        Material m;
        m.name = name;
        m.reflectance = glm::vec3(1);
        m.alpha_cutoff = alpha_cutoff;
        m.normal_texture = normals;
        m.texture = b.texture(texture);
        return Surface{b.material(m), size};
    };
    auto plain = [&](const std::string& name, const glm::vec3& reflectance, const glm::vec3& emission = glm::vec3(0)) {
        Material m;
        m.name = name;
        m.reflectance = reflectance;
        m.emission = emission;
        return Surface{b.material(m), 1};
    };
    Palette p;
    Blocks masonry;
    masonry.stone = {0.72, 0.61, 0.47};
    masonry.mortar = {0.55, 0.49, 0.41};
    const int relief = b.texture([&] {
        Texture t = blocks_normals("blocks_normals", masonry);
        t.mips = true;
        return t;
    }());
    p.blocks = textured("blocks", blocks("blocks", masonry), 3, 0, relief);
    p.limestone = textured("limestone", stone("limestone", {0.72, 0.63, 0.5}, 0.5, 2), 1.5);
    p.plaster = textured("plaster", stone("plaster", {0.74, 0.62, 0.45}, 0.35, 3), 3);
    p.court = textured("court", marble("court", 4, {0.62, 0.55, 0.45}, {0.42, 0.33, 0.25}, 4), 3);
    p.gallery = textured("gallery", marble("gallery", 4, {0.6, 0.55, 0.48}, {0.42, 0.24, 0.18}, 5), 2);
    p.wood = textured("wood", wood("wood", 6, {0.3, 0.17, 0.09}, 6), 1.2);
    p.clay = textured("clay", clay("clay", {0.55, 0.27, 0.15}, 7), 1.5);
    p.metal = plain("metal", {0.12, 0.11, 0.1});
    p.gold = plain("gold", {0.6, 0.44, 0.18});
    p.glass = plain("glass", {0.5, 0.45, 0.3}, {900, 560, 210});
    p.water = plain("water", {0.1, 0.2, 0.2});
    p.leaves = textured("leaves", leaves("leaves", 8), 1, 0.5f);
    Texture weave = fabric("fabric", 9);
    weave.mips = true;
    const int index = b.texture(weave);
    const glm::vec3 colours[] = {{0.72, 0.08, 0.05}, {0.1, 0.42, 0.1}, {0.08, 0.16, 0.55}};
    const char* const names[] = {"cloth_red", "cloth_green", "cloth_blue"};
    for (int k = 0; k < 3; ++k) {
        Material m;
        m.name = names[k];
        m.reflectance = colours[k];
        m.texture = index;
        p.cloth[std::size_t(k)] = {b.material(m), 1.3};
    }
    return p;
}

// On the arcade's axis along side k (0: z = -4.5, then clockwise seen from above); the front faces the court.
Place on_side(int k, double along, double y, double depth = 0) {
    return turn_y(90 * k) * move({along, y, -((k % 2 == 0 ? court_z : court_x) + depth)});
}
double half_side(int k) { return k % 2 == 0 ? court_x : court_z; }

// Floors, outer walls, roof: what goes around all four sides.
void shell(Builder& b, const Palette& p, double d) {
    const glm::ivec2 cells(cut(d, 20, 1), cut(d, 10, 1));
    const glm::dvec2 outer(wall_x, wall_z), axis(court_x, court_z);
    auto ring = [&](const Surface& s, const std::vector<glm::dvec2>& points, const glm::dvec2& half) {
        b.frame(s.material, Place(1), {points, 40}, half, cells, s.size);
    };
    b.object("floors");
    const Point corners[] = {{-11.6, 0, 4.1}, {11.6, 0, 4.1}, {11.6, 0, -4.1}, {-11.6, 0, -4.1}};
    b.quad(p.court.material, Place(1), corners, cells.x, cells.y, p.court.size);
    ring(p.limestone, {{3.45, 0}, {3.45, step}, {3.1, step}}, outer);
    ring(p.gallery, {{3.1, step}, {0, step}}, outer);
    ring(p.gallery, {{3.3, floor_2}, {0, floor_2}}, outer);

    b.object("outer_walls");
    ring(p.plaster, {{0, step}, {0, floor_2 - 0.4}}, outer);
    ring(p.plaster, {{0, floor_2}, {0, parapet}}, outer);
    ring(p.limestone, {{0, step}, {0.08, step}, {0.08, step + 0.35}, {0.05, step + 0.4}, {0, step + 0.4}}, outer);
    ring(p.limestone, {{0, floor_2}, {0.06, floor_2}, {0.06, floor_2 + 0.25}, {0, floor_2 + 0.3}}, outer);
    ring(p.blocks, {{0, parapet}, {0, 0}}, outer + 0.5);
    ring(p.limestone,
         {{0.62, parapet}, {0.66, parapet + 0.05}, {0.66, parapet + 0.12}, {-0.16, parapet + 0.12},
          {-0.16, parapet + 0.05}, {-0.12, parapet}, {0.62, parapet}},
         outer + 0.5);

    // Mouldings of the court: the cornice under the balustrade, and the one under the eaves.
    b.object("cornices");
    const glm::dvec2 face = axis - 0.3, face_2 = axis - 0.2;
    ring(p.limestone,
         {{0, 5.42}, {0.05, 5.44}, {0.05, 5.55}, {0.09, 5.58}, {0.09, 5.74}, {0.13, 5.78}, {0.2, 5.83}, {0.28, 5.86},
          {0.34, 5.87}, {0.34, 5.99}, {0.3, 6.03}, {-0.1, 6.05}},
         face);
    ring(p.limestone, {{0.45, floor_2}, {0.45, floor_2 + 0.15}, {0.15, floor_2 + 0.15}, {0.15, floor_2}}, axis + 0.3);
    ring(p.limestone,
         {{0.44, 6.93}, {0.49, 6.97}, {0.49, 7.05}, {0.11, 7.05}, {0.11, 6.97}, {0.16, 6.93}, {0.44, 6.93}},
         axis + 0.3);
    ring(p.limestone,
         {{0, 10.3}, {0.05, 10.32}, {0.05, 10.42}, {0.1, 10.46}, {0.1, 10.62}, {0.16, 10.68}, {0.26, 10.74},
          {0.3, 10.75}, {0.3, 10.88}, {0, 10.92}},
         face_2);

    b.object("roof");
    ring(p.wood, {{-0.4, 11.05}, {0.75, 11.05}}, face_2);
    ring(p.clay, {{0.75, 11.05}, {0.75, eaves}, {-3.2, 12.9}}, face_2);
    ring(p.wood, {{0, ceiling_2}, {3.3, ceiling_2}}, outer);
}

// The lower storey: columns, arches, the vaults behind them.
void lower_storey(Builder& b, const Palette& p, double d) {
    const parts::Column shape{spring - step, 0.3, 0.42, 0.42};
    b.object("lower_columns");
    for (int k = 0; k < 4; ++k) {
        for (double x = -half_side(k) + 3; x < half_side(k) - 1; x += 3)
            parts::column(b, p.limestone, on_side(k, x, step), shape, d);
        // The corner piers carry the walls of both sides.
        const Place corner = on_side(k, -half_side(k), 0);
        b.box(p.blocks.material, corner, {-0.37, step, -0.37}, {0.37, floor_2, 0.37}, p.blocks.size);
        b.box(p.limestone.material, corner, {-0.45, step, -0.45}, {0.45, step + 0.3, 0.45}, p.limestone.size);
        b.box(p.limestone.material, corner, {-0.45, spring - 0.15, -0.45}, {0.45, spring, 0.45}, p.limestone.size);
    }

    b.object("lower_arcade");
    const parts::ArchWall wall{1.5, 1.15, floor_2 - spring, 0.6};
    const Profile archivolt{{{0, 0}, {0, 0.05}, {0.1, 0.05}, {0.11, 0.07}, {0.2, 0.07}, {0.22, 0.11},
                             {0.27, 0.11}, {0.27, 0}}};
    for (int k = 0; k < 4; ++k)
        for (double x = -half_side(k) + 1.5; x < half_side(k); x += 3) {
            const Place place = on_side(k, x, spring);
            parts::arch_wall(b, p.blocks, place, wall, d);
            if (d < 0.25) continue;
            parts::arch_moulding(b, p.limestone, place * move({0, 0, 0.3}), wall.radius, archivolt, d);
            const Point key[] = {{-0.09, 1.1, 0.4}, {0.09, 1.1, 0.4}, {0.14, 1.55, 0.46}, {-0.14, 1.55, 0.46}};
            b.quad(p.limestone.material, place, key, 1, 1, p.limestone.size);
            for (int side = 0; side < 4; ++side) {  // the keystone's edges
                const Point &a = key[side], &c = key[(side + 1) % 4];
                const Point edge[] = {c, a, {a.x, a.y, 0.3}, {c.x, c.y, 0.3}};
                b.quad(p.limestone.material, place, edge, 1, 1, p.limestone.size);
            }
        }
    b.object("medallions");
    if (d >= 0.25)
        for (int k = 0; k < 4; ++k)
            for (double x = -half_side(k) + 3; x < half_side(k) - 1; x += 3)
                b.lathe(p.limestone.material, on_side(k, x, 4.95, -0.3) * turn_x(90),
                        {{0.26, 0}, {0.26, 0.05}, {0.21, 0.07}, {0.18, 0.03}, {0.11, 0.04}, {0.07, 0.09}, {0, 0.11}},
                        cut(d, 24, 8), p.limestone.size);

    // A vault a bay, ribs between them that end on pilasters.
    b.object("vaults");
    const Profile rib{{{0.03, -0.2}, {-0.12, -0.2}, {-0.12, 0.2}, {0.03, 0.2}}};
    for (int k = 0; k < 4; ++k) {
        for (double x = -half_side(k) - 1.5; x < half_side(k); x += 3)
            parts::groin_vault(b, p.plaster, on_side(k, x, spring, 1.5), 1.5, d);
        for (double x = -half_side(k); x < half_side(k) + 1 && d >= 0.15; x += 3) {
            parts::arch_moulding(b, p.limestone, on_side(k, x, spring, 1.5) * turn_y(90), 1.5, rib, 0.7 * d);
            const Place pilaster = on_side(k, x, 0, 3);
            b.box(p.limestone.material, pilaster, {-0.22, step, -0.1}, {0.22, spring - 0.2, 0.14}, p.limestone.size);
            b.box(p.limestone.material, pilaster, {-0.28, spring - 0.2, -0.1}, {0.28, spring, 0.2}, p.limestone.size);
            b.box(p.limestone.material, pilaster, {-0.28, step, -0.1}, {0.28, step + 0.45, 0.19}, p.limestone.size);
        }
    }
    b.object("lower_dentils");
    if (d >= 0.3)
        for (int k = 0; k < 4; ++k)
            parts::dentils(b, p.limestone, on_side(k, 0, 5.6, -0.37), 2 * half_side(k) - 0.8, 0.22, {0.11, 0.13, 0.09});
}

// The upper storey: balustrade, slender columns, arches, a ceiling of boards on beams.
void upper_storey(Builder& b, const Palette& p, double d) {
    const parts::Column shape{spring_2 - 7.05, 0.12, 0.17, 0.2};
    const parts::ArchWall wall{0.75, 0.55, 11.05 - spring_2, 0.4};
    const Profile archivolt{{{0, 0}, {0, 0.04}, {0.08, 0.04}, {0.1, 0.07}, {0.14, 0.07}, {0.14, 0}}};
    b.object("upper_columns");
    for (int k = 0; k < 4; ++k)
        for (double x = -half_side(k); x < half_side(k) - 1; x += 1.5) {
            const bool corner = x == -half_side(k);
            const double half = corner ? 0.22 : 0.17, top = corner ? 11.0 : 7.06;
            b.box(p.limestone.material, on_side(k, x, 0), {-half, floor_2 + 0.1, -half}, {half, top, half},
                  p.limestone.size);
            if (corner) continue;
            if (d < 0.15)
                b.box(p.limestone.material, on_side(k, x, 0), {-0.12, 7.05, -0.12}, {0.12, spring_2, 0.12},
                      p.limestone.size);
            else
                parts::column(b, p.limestone, on_side(k, x, 7.05), shape, 0.75 * d);
        }
    b.object("balustrade");
    const int balusters = std::min(cut(d, 5, 1), 5);
    for (int k = 0; k < 4; ++k)
        for (double x = -half_side(k); x < half_side(k) - 1; x += 1.5) {
            if (d < 0.25) {
                if (x == -half_side(k))
                    b.box(p.limestone.material, on_side(k, 0, 0), {x, floor_2 + 0.1, -0.08}, {-x, 6.95, 0.08},
                          p.limestone.size);
                continue;
            }
            for (int i = 0; i < balusters; ++i)
                parts::baluster(b, p.limestone, on_side(k, x + 0.17 + 1.16 * (i + 0.5) / balusters, 6.15), 0.79,
                                0.085, d);
        }
    b.object("upper_arcade");
    for (int k = 0; k < 4; ++k)
        for (double x = -half_side(k) + 0.75; x < half_side(k); x += 1.5) {
            parts::arch_wall(b, p.blocks, on_side(k, x, spring_2), wall, 0.7 * d);
            if (d >= 0.3)
                parts::arch_moulding(b, p.limestone, on_side(k, x, spring_2, -0.2), wall.radius, archivolt, 0.7 * d);
        }
    b.object("beams");
    for (int k = 0; k < 4; ++k)
        for (double x = -half_side(k) - 1.5; x < half_side(k) + 1 && d >= 0.15; x += 1.5)
            b.box(p.wood.material, on_side(k, x, 0), {-0.1, ceiling_2 - 0.24, -3.05}, {0.1, ceiling_2 + 0.02, -0.1},
                  p.wood.size);
    b.object("upper_dentils");
    if (d >= 0.3)
        for (int k = 0; k < 4; ++k)
            parts::dentils(b, p.limestone, on_side(k, 0, 10.48, -0.28), 2 * half_side(k) - 0.8, 0.2, {0.1, 0.12, 0.08});
}

// Barrel tiles in strips up the slope. Their undersides lie on the roof.
void tiles(Builder& b, const Palette& p, double d) {
    b.object("roof_tiles");
    if (d < 0.15) return;
    const double spacing = std::max(0.3, 0.3 / std::min(4 * d, 1.0)), course = 0.45, length = 3.9, rise = 1.7 / 3.95;
    for (int k = 0; k < 4; ++k) {
        const double lower = half_side(k) - 0.95, upper = lower + length;  // half lengths of eaves and top
        const int strips = int(2 * upper / spacing);
        for (int i = 0; i < strips; ++i) {
            const double x = (i + 0.5 - 0.5 * strips) * spacing, start = std::max(0.0, std::abs(x) - lower);
            const int courses = int((length - start) / course);
            if (courses < 1) continue;
            const Place at = on_side(k, x, eaves - 0.02, -0.95);
            Grid g;
            g.columns = cut(d, 6, 2), g.rows = 2 * courses;
            g.texture = {0.3 / p.clay.size, (length - start) / p.clay.size};
            // Each course starts wide over the end of the one below.
            b.grid(p.clay.material, at, g, [&](double u, double v) {
                const int row = int(v * g.rows + 0.5);
                const double up = start + (row / 2) * course + (row % 2) * 0.93 * course;
                const double r = (row % 2 == 0 ? 0.5 : 0.38) * 0.92 * spacing, half_turn = host::pi * (1 - u);
                const double across = u == 0 ? -1 : u == 1 ? 1 : host::cos(half_turn);
                return Point(r * across, up * rise + 0.5 * r * (u == 0 || u == 1 ? 0 : host::sin(half_turn)) +
                                             (row % 2 == 0 ? 0.03 : 0.0),
                             -up);
            });
        }
    }
}

// What people brought: doors, lanterns, a fountain, urns, ivy.
void furnish(Builder& b, const Palette& p, double d) {
    b.object("doors");
    for (int k = 0; k < 4; ++k) {
        const double depth = 3;
        for (double x = -half_side(k) + 1.5; x < half_side(k); x += 3) {
            const bool middle = k % 2 == 1 && x == 0;
            if (middle || (d >= 0.2 && k % 2 == 0 && int(x + 100) % 2 == 0))
                parts::door(b, p.limestone, p.wood, p.gold, on_side(k, x, step, depth), 1.3, 2.5);
            if (d >= 0.2) parts::door(b, p.limestone, p.wood, p.gold, on_side(k, x, floor_2, depth), 1.0, 2.3);
        }
    }
    b.object("lanterns");
    for (int k = 0; k < 4; ++k)
        for (double x = -half_side(k) + 1.5; x < half_side(k) && d >= 0.15; x += 3)
            parts::lantern(b, p.metal, p.glass, on_side(k, x, 5.19, 1.5), 1.3, d);

    b.object("fountain");
    const int around = cut(d, 48, 8);
    b.lathe(p.limestone.material, Place(1),
            {{1.75, 0}, {1.75, 0.14}, {1.5, 0.14}, {1.42, 0.2}, {1.36, 0.46}, {1.5, 0.52}, {1.5, 0.6}, {1.24, 0.6},
             {1.2, 0.3}, {0, 0.3}},
            around, p.limestone.size);
    b.lathe(p.water.material, Place(1), {{1.22, 0.48}, {0, 0.48}}, around, 1);
    b.lathe(p.limestone.material, Place(1),
            {{0.26, 0.3}, {0.26, 0.55}, {0.13, 0.7}, {0.1, 0.9}, {0.15, 1.1}, {0.5, 1.26}, {0.66, 1.4}, {0.68, 1.46},
             {0.62, 1.46}, {0.45, 1.36}, {0.1, 1.34}, {0.07, 1.6}, {0.16, 1.72}, {0.18, 1.8}, {0.1, 1.9}, {0, 1.95}},
            around, p.limestone.size);

    b.object("urns");
    int seed = 0;
    for (double x = -9; x < 10 && d >= 0.15; x += 6)
        for (int side = -1; side <= 1; side += 2)
            parts::urn(b, p.limestone, p.leaves, move({x, 0, side * 3.55}), std::uint32_t(++seed), d);
    b.object("ivy");
    const double places[][3] = {{0, -7.5, 2.2}, {0, 1.5, 3.1}, {2, -4.5, 2.6},
                                {2, 6, 3.4},    {3, 1, 2.8},   {1, -1.5, 2.4}};
    for (const double* at : places)
        parts::hanging_leaves(b, p.leaves, on_side(int(at[0]), at[1], 7.08, -0.5), at[2], 1.9, std::uint32_t(++seed),
                              d);
}

void curtains(Builder& b, const Palette& p, double cloth) {
    // Colours and states of the eight bays of a long side, from its left end.
    const int colour[2][8] = {{0, 1, 2, 0, 1, 2, 0, 1}, {2, 0, 1, 2, 0, 1, 2, 0}};
    const bool drawn[2][8] = {{false, true, false, true, true, false, true, false},
                              {true, false, true, true, false, true, false, true}};
    for (int side = 0; side < 2; ++side)
        for (int i = 0; i < 8; ++i) {
            b.object("curtain_" + std::to_string(8 * side + i));
            parts::Curtain c{1.13, 3.35, drawn[side][i], std::uint32_t(8 * side + i + 1)};
            const Surface& fabric = p.cloth[std::size_t(colour[side][i])];
            parts::curtain(b, fabric, p.gold, on_side(2 * side, -10.5 + 3 * i, spring - 0.06), c, cloth);
        }
}

void build(Builder& b, const Palette& p, double detail, double cloth) {
    shell(b, p, detail);
    lower_storey(b, p, detail);
    upper_storey(b, p, detail);
    tiles(b, p, detail);
    furnish(b, p, detail);
    curtains(b, p, cloth);
}

Camera view(std::uint32_t seed) {
    Camera c;
    c.near = 0.1, c.far = 100;
    c.fov_y_deg = 60;
    c.position = {-11, 2.1, 0.9}, c.look_at = {0, 3.7, -0.5};
    if (seed == 2) c.position = {9.75, 8, 4}, c.look_at = {-3, 4.2, -3.2};
    if (seed == 3) c.position = {10.9, 1.9, 1.6}, c.look_at = {-3, 4, -3};
    return c;
}

}  // namespace

Scene atrium(const GenerateOptions& options) {
    // Find the detail for the number of triangles, then let the cloth take up what its steps leave.
    const double detail = fit_detail(options.triangles, 0.02, 20, [](Builder& b, double d) { build(b, {}, d, d); });
    const double cloth =
        fit_detail(options.triangles, 0.02, 20, [&](Builder& b, double c) { build(b, {}, detail, c); });
    Builder b("atrium");
    build(b, make_palette(b), detail, cloth);
    Scene scene = b.take();
    scene.seed = options.seed;

    Light sun;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = glm::vec3(glm::normalize(glm::dvec3(0.3, -1, -0.36)));
    sun.intensity = {900, 820, 680};  // W/m2
    sun.rsm_size = 1024;              // 0.035 m a texel
    scene.lights = {sun};
    scene.environment.radiance = {70, 105, 150};  // W/(m2 sr)
    scene.camera = view(options.seed);
    scene.frame_size = {1280, 720};
    const std::string place = "atrium";
    scene.settings = {{"rsm", "radius", 0.7, place}, {"rsm", "samples", 1024.0, place},
                      {"rsm", "projection", std::string("clamped"), place}, {"rsm", "min_distance", 0.5, place},
                      {"tonemap", "operator", std::string("filmic"), place}, {"tonemap", "exposure", 0.027, place}};
    return scene;
}

}  // namespace plumb::io::scenes
