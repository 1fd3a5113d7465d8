// A large hall that is open to the sun: IPR's Open Hall (tables 5.4 to 5.7), of which the thesis gives 512,026
// receivers on its surfaces, levels of detail up to 100 m away and two kinds of light, but no model and no number of
// triangles.
//
//     z = -14  +------------------------------------------+    y = 15.5  crown of the nave's vault, with skylights
//              |  aisle                                    |        11.5  the vault springs; aisles have beams at 11
//     z = -7.5 |  o   o   o   o   o   o   o   o   o        |         7    arches on columns spring, 6 m apart
//              |  nave                        stairs|gallery|        5    arches of the open side spring
//     z =  7.5 |  o   o   o   o   o   o   o   o   o        |         4    gallery
//              |  aisle, its wall open in arches           |         0    floor
//     z =  14  +-- ---- ---- ---- ---- ---- ---- ----------+
//            x = -30                                      30
//
// Seeds 1, 2 and 3 (and all others as 1) are three views, as the thesis has three cameras: along the nave to the
// stairs, from the gallery, and from between the northern columns towards the open side. The geometry is the same in
// all of them.
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

constexpr double half_x = 30, nave_z = 7.5, wall_z = 14, bay = 6;
constexpr double spring = 7, vault_y = 11.5, vault_rise = 4, ceiling = 11, gallery_y = 4, gallery_x = 22;
constexpr int bays = 10, steps = 24;
constexpr double tread = 0.4, stair_z = 3.5;

struct Palette {
    Surface brick, limestone, plaster, floor, wood, metal, gold, glass;
    std::array<Surface, 3> cloth;
    std::array<Surface, 4> paint;
};

Palette make_palette(Builder& b) {
    using namespace textures;
    auto textured = [&](const std::string& name, Texture texture, double size) {
        texture.mips = true;
        Material m;
        m.name = name;
        m.reflectance = glm::vec3(1);
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
    Blocks courses{4, 16, 0.006, {0.55, 0.29, 0.2}, {0.55, 0.5, 0.44}, 0.22, 21};
    p.brick = textured("brick", blocks("brick", courses), 1.5);
    p.limestone = textured("limestone", stone("limestone", {0.66, 0.6, 0.5}, 0.4, 22), 2);
    p.plaster = textured("plaster", stone("plaster", {0.72, 0.66, 0.55}, 0.25, 23), 4);
    p.floor = textured("floor", marble("floor", 4, {0.62, 0.58, 0.52}, {0.3, 0.29, 0.28}, 24), 4);
    p.wood = textured("wood", wood("wood", 6, {0.36, 0.21, 0.11}, 25), 1.5);
    p.metal = plain("metal", {0.12, 0.12, 0.13});
    p.gold = plain("gold", {0.6, 0.44, 0.18});
    p.glass = plain("glass", {0.5, 0.45, 0.35}, {1400, 950, 420});
    Texture weave = fabric("fabric", 26);
    weave.mips = true;
    const int index = b.texture(weave);
    const glm::vec3 colours[] = {{0.7, 0.09, 0.07}, {0.14, 0.4, 0.16}, {0.1, 0.18, 0.55}};
    const char* const names[] = {"cloth_red", "cloth_green", "cloth_blue"};
    for (int k = 0; k < 3; ++k) {
        Material m;
        m.name = names[k];
        m.reflectance = colours[k];
        m.texture = index;
        p.cloth[std::size_t(k)] = {b.material(m), 1.5};
    }
    p.paint = {plain("paint_red", {0.75, 0.1, 0.08}), plain("paint_green", {0.16, 0.6, 0.16}),
               plain("paint_blue", {0.1, 0.25, 0.72}), plain("paint_yellow", {0.78, 0.6, 0.1})};
    return p;
}

// On a long wall: side 0 is z < 0; the front faces the nave.
Place on_side(int side, double x, double y, double z) {
    return side == 0 ? move({x, y, -z}) : turn_y(180) * move({-x, y, -z});
}
double bay_x(int i) { return -half_x + bay * (i + 0.5); }

void quad(Builder& b, const Surface& s, const Point& a, const Point& along, const Point& up, int columns, int rows) {
    const Point corners[] = {a, a + along, a + along + up, a + up};
    b.quad(s.material, Place(1), corners, columns, rows, s.size);
}

// Floor, walls, aisle ceilings.
void shell(Builder& b, const Palette& p, double d) {
    const int n = cut(d, 40, 1), m = cut(d, 12, 1);
    b.object("floor");
    quad(b, p.floor, {-half_x, 0, wall_z}, {2 * half_x, 0, 0}, {0, 0, -2 * wall_z}, n, 2 * m);
    b.object("terrace");
    quad(b, p.limestone, {-half_x, 0, wall_z + 7}, {2 * half_x, 0, 0}, {0, 0, -7}, n, cut(d, 6, 1));
    quad(b, p.brick, {half_x, 0, wall_z + 7}, {-2 * half_x, 0, 0}, {0, 2.2, 0}, n, 2);
    b.box(p.limestone.material, Place(1), {-half_x, 2.2, wall_z + 6.9}, {half_x, 2.4, wall_z + 7.4}, p.limestone.size,
          {n, 1, 1});
    b.object("walls");
    quad(b, p.plaster, {-half_x, 0, -wall_z}, {2 * half_x, 0, 0}, {0, ceiling, 0}, n, m);
    for (int end = -1; end <= 1; end += 2)
        quad(b, p.plaster, {end * half_x, 0, -end * wall_z}, {0, 0, end * 2 * wall_z}, {0, 16, 0}, n / 2 + 1, m);
    for (int side = 0; side < 2; ++side) {
        const double z = side == 0 ? -wall_z : nave_z;
        // Half a metre more than the walls: shadows begin before them.
        quad(b, p.wood, {-half_x - 0.5, ceiling, z - (side == 0 ? 0.5 : 0)}, {2 * half_x + 1, 0, 0},
             {0, 0, wall_z - nave_z + 0.5}, n, m / 2 + 1);
        // The roof over it: a shadow's bias is larger than a sheet is thick, and would let light through at the wall.
        quad(b, p.limestone, {-half_x - 0.8, ceiling + 0.6, z + wall_z - nave_z + (side == 0 ? 0 : 0.8)},
             {2 * half_x + 1.6, 0, 0}, {0, 0, nave_z - wall_z - 0.8}, 1, 1);
    }

    // The open side: arches on piers. The wall is 0.8 m thick; its inner face lies at z = 14.
    b.object("open_side");
    const parts::ArchWall wall{bay / 2, 2.2, ceiling - 5, 0.8};
    const Profile band{{{0, 0}, {0, 0.08}, {0.3, 0.08}, {0.32, 0.14}, {0.4, 0.14}, {0.4, 0}}};
    for (int i = 0; i < bays; ++i) {
        const Place place = on_side(1, bay_x(i), 5, wall_z + 0.4);
        parts::arch_wall(b, p.brick, place, wall, 1.5 * d);
        parts::arch_moulding(b, p.limestone, place * move({0, 0, 0.4}), wall.radius, band, 1.5 * d);
        const double edge = bay / 2 - wall.radius;
        for (int end = -1; end <= 1; end += 2) {
            const double x0 = end < 0 ? -bay / 2 : bay / 2 - edge, x1 = x0 + edge;
            b.box(p.brick.material, place, {x0, -5, -0.4}, {x1, 0, 0.4}, p.brick.size, {1, cut(d, 6, 1), 1});
            b.box(p.limestone.material, place, {x0 - 0.06, -0.2, -0.46}, {x1 + 0.06, 0.02, 0.46}, p.limestone.size);
            b.box(p.limestone.material, place, {x0 - 0.06, -5, -0.46}, {x1 + 0.06, -4.5, 0.46}, p.limestone.size);
        }
    }
    b.object("beams");
    for (int side = 0; side < 2; ++side)
        for (int i = 0; i <= 2 * bays; ++i)
            b.box(p.wood.material, on_side(side, -half_x + 3.0 * i, 0, wall_z), {-0.18, ceiling - 0.45, 0},
                  {0.18, ceiling + 0.02, wall_z - nave_z}, p.wood.size);
}

void arcades(Builder& b, const Palette& p, double d) {
    const parts::Column shape{spring, 0.48, 0.66, 0.66};
    const parts::ArchWall wall{bay / 2, 2.4, vault_y - spring, 0.9};
    const Profile archivolt{{{0, 0}, {0, 0.06}, {0.16, 0.06}, {0.18, 0.1}, {0.32, 0.1}, {0.36, 0.18},
                             {0.44, 0.18}, {0.44, 0}}};
    b.object("columns");
    for (int side = 0; side < 2; ++side) {
        for (int i = 1; i < bays; ++i)
            parts::column(b, p.limestone, on_side(side, -half_x + bay * i, 0, nave_z), shape, 1.7 * d);
        for (int end = -1; end <= 1; end += 2)
            b.box(p.limestone.material, on_side(side, end * half_x, 0, nave_z), {-0.6, 0, -0.45}, {0.6, spring, 0.45},
                  p.limestone.size);
    }
    b.object("arcades");
    for (int side = 0; side < 2; ++side)
        for (int i = 0; i < bays; ++i) {
            const Place place = on_side(side, bay_x(i), spring, nave_z);
            parts::arch_wall(b, p.brick, place, wall, 1.5 * d);
            for (int face = 0; face < 2; ++face)
                parts::arch_moulding(b, p.limestone, place * turn_y(180 * face) * move({0, 0, 0.45}), wall.radius,
                                     archivolt, 1.5 * d);
        }
    b.object("cornice");
    const Profile cornice{{{0, 0}, {0.06, 0.02}, {0.06, 0.2}, {0.14, 0.26}, {0.14, 0.5}, {0.24, 0.6},
                           {0.4, 0.66}, {0.4, 0.84}, {0, 0.9}}};
    for (int side = 0; side < 2; ++side) {
        b.sweep(p.limestone.material, on_side(side, 0, vault_y - 0.9, nave_z - 0.45), cornice, cut(d, 40, 1),
                2 * half_x, p.limestone.size,
                [](double u, const glm::dvec2& c) { return Point(half_x * (2 * u - 1), c.y, c.x); });
        parts::dentils(b, p.limestone, on_side(side, 0, vault_y - 0.62, nave_z - 0.59), 2 * half_x,
                       std::max(0.45, 0.3 / d), {0.22, 0.22, 0.16});
    }
}

// The nave's vault: half an ellipse in section, with an opening a bay at its crown and a rib between bays.
void vault(Builder& b, const Palette& p, double d) {
    b.object("vault");
    const double low = 0.43, high = 0.57, edge = 1.1;  // where the openings lie, in half turns, and metres from the bay
    auto at = [](double x, double t) {
        const double angle = host::pi * t;
        return Point(x, vault_y + vault_rise * host::sin(angle), -nave_z * host::cos(angle));
    };
    auto piece = [&](double x0, double x1, double t0, double t1, int columns, int rows) {
        Grid g;
        g.columns = columns, g.rows = rows;
        g.texture = glm::dvec2(x1 - x0, 19 * (t1 - t0)) / p.plaster.size;
        b.grid(p.plaster.material, Place(1), g,
               [&](double u, double v) { return at(x0 + u * (x1 - x0), t0 + (v == 1 ? t1 - t0 : v * (t1 - t0))); });
    };
    const int rows = cut(d, 16, 3), columns = cut(d, 6, 1), narrow = cut(d, 2, 1);
    for (int i = 0; i < bays; ++i) {
        const double x = -half_x + bay * i, from = x + edge, to = x + bay - edge;
        const double cuts[] = {x - (i == 0 ? 0.5 : 0), from, to, x + bay + (i == bays - 1 ? 0.5 : 0)};
        for (int k = 0; k < 3; ++k) {
            const int n = k == 1 ? columns : narrow;
            piece(cuts[k], cuts[k + 1], 0, low, n, rows);
            if (k != 1) piece(cuts[k], cuts[k + 1], low, high, n, std::max(1, rows / 4));
            piece(cuts[k], cuts[k + 1], high, 1, n, rows);
        }
        // The shaft of the skylight rises half a metre above the crown.
        const double y0 = at(0, low).y, y1 = 16, z = at(0, low).z;
        quad(b, p.limestone, {from, y0, z}, {to - from, 0, 0}, {0, y1 - y0, 0}, 1, 1);
        quad(b, p.limestone, {to, y0, -z}, {from - to, 0, 0}, {0, y1 - y0, 0}, 1, 1);
        quad(b, p.limestone, {from, y0, -z}, {0, 0, 2 * z}, {0, y1 - y0, 0}, 1, 1);
        quad(b, p.limestone, {to, y0, z}, {0, 0, -2 * z}, {0, y1 - y0, 0}, 1, 1);
        for (int bar = 1; bar < 3; ++bar) {  // glazing bars
            const double at_x = from + (to - from) * bar / 3;
            b.box(p.metal.material, Place(1), {at_x - 0.04, y1 - 0.2, z}, {at_x + 0.04, y1 - 0.1, -z}, 1);
        }
    }
    b.object("ribs");
    const Profile rib{{{0, -0.4}, {-0.3, -0.4}, {-0.3, -0.25}, {-0.2, -0.25}, {-0.2, 0.25}, {-0.3, 0.25},
                       {-0.3, 0.4}, {0, 0.4}}};
    for (int i = 1; i < bays; ++i)
        parts::arch_moulding(b, p.limestone,
                             move({-half_x + bay * i, vault_y, 0}) * scale({1, vault_rise / nave_z, 1}) * turn_y(90),
                             nave_z, rib, 1.5 * d);
}

// The gallery at the eastern end and the stairs that lead up to it.
void gallery(Builder& b, const Palette& p, double d) {
    b.object("gallery");
    b.box(p.limestone.material, Place(1), {gallery_x, 0, -nave_z - 0.4}, {half_x, gallery_y, nave_z + 0.4},
          p.limestone.size, {cut(d, 8, 1), cut(d, 4, 1), cut(d, 16, 1)});
    b.object("stairs");
    const double rise = gallery_y / steps, foot = gallery_x - steps * tread;
    for (int i = 0; i < steps; ++i) {
        const double x = foot + i * tread;
        b.box(p.limestone.material, Place(1), {x, 0, -stair_z}, {gallery_x, (i + 1) * rise, stair_z}, p.limestone.size);
        b.box(p.limestone.material, Place(1), {x - 0.04, (i + 1) * rise - 0.04, -stair_z},
              {x + 0.1, (i + 1) * rise + 0.004, stair_z}, p.limestone.size);
    }

    // Balustrades: along the stairs with a rail that climbs, and along the gallery.
    b.object("balustrades");
    const int every = d < 0.4 ? 3 : 1;
    for (int side = -1; side <= 1; side += 2) {
        const double z = side * (stair_z + 0.16);
        for (int i = 0; i < steps; i += every)
            parts::baluster(b, p.limestone, move({foot + (i + 0.5) * tread, (i + 1) * rise, z}), 0.85, 0.1, d);
        // The string that carries them.
        b.grid(p.limestone.material, Place(1), {1, 1, {4, 1}}, [&](double u, double v) {
            return Point(side > 0 ? foot + u * (gallery_x - foot) : gallery_x - u * (gallery_x - foot),
                         v * ((side > 0 ? u : 1 - u) * gallery_y + rise), side * (stair_z + 0.32));
        });
        const Profile rail{{{-0.16, 0}, {0.16, 0}, {0.16, 0.14}, {-0.16, 0.14}, {-0.16, 0}}};
        auto climb = [&](double low, double high) {
            b.sweep(p.limestone.material, Place(1), rail, 1, 10, p.limestone.size, [&](double u, const glm::dvec2& c) {
                return Point(foot + u * (gallery_x - foot), u * gallery_y + c.y * (high - low) / 0.14 + low, z + c.x);
            });
        };
        climb(0.85 + rise, 1.0 + rise);
        climb(-0.02, rise + 0.02);
        b.box(p.limestone.material, move({foot - 0.3, 0, z}), {-0.25, 0, -0.25}, {0.25, 1.35, 0.25}, p.limestone.size);
        b.lathe(p.limestone.material, move({foot - 0.3, 1.35, z}),
                {{0, 0}, {0.1, 0}, {0.14, 0.08}, {0.24, 0.2}, {0.27, 0.32}, {0.22, 0.46}, {0.1, 0.55}, {0, 0.57}},
                cut(d, 24, 6), p.limestone.size);

        const double length = nave_z - stair_z - 0.6, middle = side * (stair_z + 0.3 + length / 2);
        const int count = 12 / every;
        for (int i = 0; i < count; ++i)
            parts::baluster(b, p.limestone,
                            move({gallery_x + 0.2, gallery_y, middle + length * ((i + 0.5) / count - 0.5)}), 0.9,
                            0.1, d);
        b.box(p.limestone.material, Place(1), {gallery_x, gallery_y + 0.9, middle - length / 2 - 0.3},
              {gallery_x + 0.4, gallery_y + 1.05, middle + length / 2 + 0.3}, p.limestone.size);
        b.box(p.limestone.material, move({gallery_x + 0.2, gallery_y, side * (stair_z + 0.16)}), {-0.22, 0, -0.22},
              {0.22, 1.25, 0.22}, p.limestone.size);
    }
    b.object("doors");
    parts::door(b, p.limestone, p.wood, p.gold, move({half_x, gallery_y, 0}) * turn_y(-90), 2.6, 4);
    parts::door(b, p.limestone, p.wood, p.gold, move({-half_x, 0, 0}) * turn_y(90), 3.2, 5);
    for (int i = 1; i < bays; i += 2)
        parts::door(b, p.limestone, p.wood, p.gold, on_side(0, bay_x(i), 0, wall_z), 1.8, 3.2);
}

// Coloured things on pedestals, benches, lamps.
void furnish(Builder& b, const Palette& p, double d) {
    b.object("pedestals");
    const double at[][2] = {{-19, 3.6}, {-11, -3.8}, {-2.5, 3.8}, {5, -4}};
    for (const double* xz : at) {
        b.box(p.limestone.material, move({xz[0], 0, xz[1]}), {-0.95, 0, -0.95}, {0.95, 0.15, 0.95}, p.limestone.size);
        b.box(p.limestone.material, move({xz[0], 0, xz[1]}), {-0.8, 0.15, -0.8}, {0.8, 0.9, 0.8}, p.limestone.size);
        b.box(p.limestone.material, move({xz[0], 0, xz[1]}), {-0.9, 0.9, -0.9}, {0.9, 1.02, 0.9}, p.limestone.size);
    }
    auto place = [&](int k) { return move({at[k][0], 1.02, at[k][1]}); };
    const int rings = cut(d, 32, 4), around = cut(d, 64, 6);

    b.object("sphere");
    std::vector<glm::dvec2> arc;
    for (int k = 0; k <= rings; ++k) {
        const double angle = host::pi * k / rings;
        arc.push_back({k == 0 || k == rings ? 0 : 0.9 * host::sin(angle), 0.9 - 0.9 * host::cos(angle)});
    }
    b.lathe(p.paint[0].material, place(0), arc, around, 1, 91);

    b.object("ring");
    Grid g;
    g.columns = around, g.rows = rings;
    g.closed_u = true;
    b.grid(p.paint[2].material, place(1) * move({0, 1.15, 0}) * turn_y(35), g, [](double u, double v) {
        const double a = u == 1 ? 0 : 2 * host::pi * u, c = host::pi * (v == 1 ? 1 : 1 + 2 * v);
        const double r = 0.85 + 0.3 * host::cos(c);
        return Point(r * host::cos(a), r * host::sin(a), 0.3 * host::sin(c));
    });
    b.object("cubes");
    b.box(p.paint[3].material, place(2) * turn_y(20), {-0.6, 0, -0.6}, {0.6, 1.2, 0.6});
    b.box(p.paint[1].material, place(2) * turn_y(52), {-0.4, 1.2, -0.4}, {0.4, 2, 0.4});
    b.object("cone");
    b.lathe(p.paint[1].material, place(3), {{0, 0}, {0.8, 0}, {0.8, 0.1}, {0, 2.1}}, around, 1);

    b.object("benches");
    for (int side = 0; side < 2; ++side)
        for (int i = 1; i < 7; i += 2) {
            const Place bench = on_side(side, bay_x(i), 0, 6.1);
            b.box(p.wood.material, bench, {-1.1, 0.4, -0.25}, {1.1, 0.47, 0.25}, p.wood.size);
            for (int leg = -1; leg <= 1; leg += 2)
                b.box(p.wood.material, bench, {leg * 0.85 - 0.05, 0, -0.22}, {leg * 0.85 + 0.05, 0.4, 0.22},
                      p.wood.size);
        }
    b.object("lamps");
    for (int i = 1; i < bays; i += 2)
        parts::lantern(b, p.metal, p.glass,
                       move({-half_x + bay * i, vault_y + vault_rise - 0.28, 0}) * scale(Point(2.2)), 2.8, 2 * d);
}

void banners(Builder& b, const Palette& p, double cloth) {
    for (int i = 0; i < 9; ++i) {
        b.object("banner_" + std::to_string(i));
        const parts::Curtain c{1.2, 5, false, std::uint32_t(30 + i)};
        const Place place = on_side(0, -24 + bay * i, 9.6, wall_z - 0.3);
        parts::curtain(b, p.cloth[std::size_t(i % 3)], p.gold, place, c, cloth);
    }
}

void build(Builder& b, const Palette& p, double detail, double cloth) {
    shell(b, p, detail);
    arcades(b, p, detail);
    vault(b, p, detail);
    gallery(b, p, detail);
    furnish(b, p, detail);
    banners(b, p, cloth);
}

Light spot(const char* name, const Point& position, const Point& to, const glm::vec3& intensity) {
    Light light;
    light.name = name;
    light.type = LightType::spot;
    light.position = glm::vec3(position);
    const Point along = to - position;
    light.direction = glm::vec3(along / std::sqrt(along.x * along.x + along.y * along.y + along.z * along.z));
    light.cone_inner_deg = 35, light.cone_outer_deg = 50;
    light.intensity = intensity;
    return light;
}

Camera view(std::uint32_t seed) {
    Camera c;
    c.near = 0.1, c.far = 150;
    c.fov_y_deg = 55;
    c.position = {-27, 2.6, 1.5}, c.look_at = {0, 4.6, -0.6};
    if (seed == 2) c.position = {27, 6.2, -4}, c.look_at = {0, 4, 1.5};
    if (seed == 3) c.position = {-3, 1.9, -7.2}, c.look_at = {8, 4.2, 8};
    return c;
}

}  // namespace

Scene hall(const GenerateOptions& options) {
    // Find the detail for the number of triangles, then let the cloth take up what its steps leave.
    const double detail = fit_detail(options.triangles, 0.02, 20, [](Builder& b, double d) { build(b, {}, d, d); });
    const double cloth =
        fit_detail(options.triangles, 0.02, 20, [&](Builder& b, double c) { build(b, {}, detail, c); });
    Builder b("hall");
    build(b, make_palette(b), detail, cloth);
    Scene scene = b.take();
    scene.seed = options.seed;

    Light sun;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = glm::vec3(glm::normalize(glm::dvec3(0.3, -1, -0.32)));
    sun.intensity = {900, 820, 680};  // W/m2
    sun.rsm_size = 2048;              // 0.035 m a texel
    scene.lights = {sun, spot("lamp_gallery", {20, 10.5, 0}, {26, 4, 0}, {9000, 6800, 4200}),
                    spot("lamp_entrance", {-21, 10.5, 0}, {-23, 0, 0}, {7000, 5300, 3300}),
                    // Shines up, so that the vault lights the floor.
                    spot("lamp_vault", {0, 6, 0}, {0, 15, 0}, {34000, 28000, 20000})};
    scene.lights.back().cone_inner_deg = 55, scene.lights.back().cone_outer_deg = 72;
    scene.environment.radiance = {70, 105, 150};  // W/(m2 sr)
    scene.camera = view(options.seed);
    scene.frame_size = {1280, 720};
    const std::string place = "hall";
    scene.settings = {{"rsm", "radius", 0.7, place}, {"rsm", "samples", 1024.0, place},
                      {"rsm", "projection", std::string("clamped"), place}, {"rsm", "min_distance", 0.5, place},
                      {"rsm", "thickness", 1.0, place},  // of piers, balustrades and lamps
                      {"tonemap", "operator", std::string("filmic"), place}, {"tonemap", "exposure", 0.034, place}};
    return scene;
}

}  // namespace plumb::io::scenes
