// Paints the city's surfaces and names its materials. Every texture tiles.
#include <algorithm>
#include <cmath>

#include "io/scenes/city_parts.h"

namespace plumb::io::scenes::town {
namespace {

using Colour = glm::dvec3;

Colour mix(const Colour& a, const Colour& b, double t) { return a + std::clamp(t, 0.0, 1.0) * (b - a); }
double grain(double u, double v, std::uint32_t seed) { return white_noise(int(u * 512), int(v * 512), seed); }

// Weathered plaster, near white: the material's reflectance tints it.
Colour plaster(double u, double v) {
    const double stains = fractal_noise(u, v, 4, 4, 11), streaks = smooth_noise(u, v * 0.25, 24, 12);
    const double light = 0.72 + 0.30 * stains - 0.10 * streaks * streaks + 0.05 * grain(u, v, 13);
    return mix(Colour(0.92), Colour(0.80, 0.76, 0.70), 2 * stains - 0.7) * light;
}

// One bay of one storey as a picture, v upward: pane, frame, sill and shutters.
Colour bay(double u, double v) {
    const double x = std::abs(u - 0.5), y = v - 0.30;
    if (x < 0.17 && y > 0 && y < 0.46) {
        const bool bar = x < 0.014 || x > 0.15 || y < 0.02 || y > 0.44 || std::abs(y - 0.30) < 0.012;
        return bar ? Colour(0.45, 0.42, 0.38) : Colour(0.035, 0.04, 0.05) * (y > 0.36 ? 0.5 : 1.0);
    }
    if (x < 0.33 && y > 0 && y < 0.46) return Colour(0.13, 0.19, 0.15) * (white_noise(0, int(v * 64), 3) * 0.4 + 0.7);
    if (x < 0.22 && y < 0 && y > -0.04) return Colour(0.75, 0.73, 0.68);
    const double shade = x < 0.22 && y < 0 && y > -0.07 ? 0.6 : 1.0;
    return plaster(u, v) * (v > 0.97 ? 0.82 : shade);
}

// 16 x 16 roof tiles, one above the other; `relief` paints the shade that modelled tiles have by themselves.
Colour tiles(double u, double v, bool relief) {
    const double column = u * 16, row = v * 16;
    const int i = int(column), j = int(row);
    const double x = column - i, y = row - j, kind = white_noise(i, j, 31), age = fractal_noise(u, v, 3, 3, 32);
    Colour c = mix(Colour(0.36, 0.155, 0.08), Colour(0.50, 0.27, 0.15), kind);
    c = mix(c, Colour(0.21, 0.17, 0.13), 2.2 * age - 0.8);
    if (kind > 0.93) c = Colour(0.50, 0.38, 0.26);
    double light = 0.85 + 0.2 * grain(u, v, 33);
    if (relief) light *= (0.45 + 0.75 * std::min(1.0, 4 * x * (1 - x))) * (y < 0.12 ? 0.5 : 1.0);
    return c * light;
}

// Rows of stones with joints: `rows` to the texture, each shifted and with stones of its own widths.
Colour stones(double u, double v, int rows, int columns, const Colour& dark, const Colour& light, const Colour& joint,
              double gap, std::uint32_t seed) {
    const double row = v * rows;
    const int j = int(row);
    double column = u * columns + 0.5 * (j % 2) + 0.3 * white_noise(0, j, seed);
    const int i = int(std::floor(column)) % columns;
    const double x = column - std::floor(column), y = row - j;
    if (std::min(x, 1 - x) * rows < gap * columns || std::min(y, 1 - y) < gap) return joint;
    return mix(dark, light, 0.75 * white_noise(i, j, seed + 1) + 0.25 * grain(u, v, seed + 2)) *
           (0.8 + 0.3 * fractal_noise(u, v, 4, 3, seed + 3));
}

// Three storeys of arches as a picture, one bay wide: the amphitheatre from far.
Colour arches(double u, double v) {
    const double x = std::abs(u - 0.5), y = v * 4 - std::floor(v * 4);
    const bool open = v < 0.75 ? (x < 0.3 && (y < 0.5 || x * x + (y - 0.5) * (y - 0.5) < 0.09))
                               : (x < 0.1 && y > 0.35 && y < 0.6);
    return open ? Colour(0.06, 0.05, 0.04) : Colour(0.62, 0.55, 0.43) * (y > 0.93 ? 0.7 : 1.0) *
                                                 (0.75 + 0.4 * fractal_noise(u, v, 5, 3, 41));
}

Colour foliage(double u, double v, const Colour& dark, const Colour& light, std::uint32_t seed) {
    return mix(dark, light, 1.8 * fractal_noise(u, v, 12, 3, seed) - 0.4) * (0.7 + 0.5 * grain(u, v, seed + 9));
}

Colour water(double u, double v) {
    return mix(Colour(0.07, 0.11, 0.09), Colour(0.14, 0.20, 0.17), fractal_noise(u, v, 6, 4, 61));
}

int textured(Builder& b, const std::string& name, const glm::vec3& tint, int texture) {
    Material m;
    m.name = name, m.reflectance = tint, m.texture = texture;
    return b.material(m);
}
int plain(Builder& b, const std::string& name, const glm::vec3& reflectance, float emission = 0) {
    Material m;
    m.name = name, m.reflectance = reflectance, m.emission = glm::vec3(emission, 0.8f * emission, 0.5f * emission);
    return b.material(m);
}

}  // namespace

Palette make_palette(Builder& b) {
    const auto picture = [&](const std::string& name, int side, auto&& colour) {
        Texture texture = paint(name, side, colour);
        texture.mips = true;  // most of the city is far away
        return b.texture(texture);
    };
    const int plaster_picture = picture("plaster", 256, plaster), bay_picture = picture("bay", 128, bay);
    const glm::vec3 tint[tints] = {{0.80f, 0.52f, 0.27f}, {0.70f, 0.33f, 0.20f}, {0.84f, 0.68f, 0.42f},
                                   {0.74f, 0.70f, 0.62f}, {0.68f, 0.40f, 0.30f}, {0.80f, 0.60f, 0.40f},
                                   {0.58f, 0.50f, 0.43f}, {0.86f, 0.76f, 0.60f}};
    const glm::vec3 shutters[4] = {{0.10f, 0.20f, 0.14f}, {0.22f, 0.15f, 0.09f}, {0.30f, 0.34f, 0.34f},
                                   {0.13f, 0.24f, 0.26f}};
    Palette p;
    for (int k = 0; k < tints; ++k) {
        p.plaster[k] = textured(b, "plaster " + std::to_string(k), tint[k], plaster_picture);
        p.painted[k] = textured(b, "facade " + std::to_string(k), tint[k], bay_picture);
    }
    for (int k = 0; k < 4; ++k) p.shutter[k] = plain(b, "shutter " + std::to_string(k), shutters[k]);
    const glm::vec3 white(1);
    p.tiles = textured(b, "roof", white, picture("tiles", 256, [](double u, double v) { return tiles(u, v, true); }));
    p.terracotta = textured(b, "roof tiles", white,
                            picture("terracotta", 256, [](double u, double v) { return tiles(u, v, false); }));
    const int stone = picture("stone", 256, [](double u, double v) {
        return stones(u, v, 6, 3, {0.52, 0.47, 0.39}, {0.72, 0.67, 0.57}, {0.42, 0.38, 0.32}, 0.025, 71);
    });
    p.stone = textured(b, "stone", {0.80f, 0.78f, 0.76f}, stone);
    p.travertine = textured(b, "travertine", white, stone);
    p.brick = textured(b, "brick", white, picture("brick", 256, [](double u, double v) {
        return stones(u, v, 24, 8, {0.40, 0.22, 0.14}, {0.58, 0.36, 0.24}, {0.50, 0.45, 0.38}, 0.07, 75);
    }));
    p.arches = textured(b, "arches", white, picture("arches", 128, arches));
    p.lead = plain(b, "lead", {0.42f, 0.46f, 0.48f});
    p.glass = plain(b, "window", {0.05f, 0.06f, 0.08f});
    p.wood = plain(b, "wood", {0.26f, 0.16f, 0.09f});
    p.metal = plain(b, "iron", {0.05f, 0.05f, 0.05f});
    p.lamp = plain(b, "lamp", {0.8f, 0.8f, 0.75f}, 3);
    p.cobbles = textured(b, "cobbles", white, picture("cobbles", 512, [](double u, double v) {
        return stones(u, v, 32, 32, {0.20, 0.19, 0.18}, {0.34, 0.32, 0.30}, {0.15, 0.14, 0.12}, 0.08, 81);
    }));
    p.paving = textured(b, "paving", white, picture("paving", 256, [](double u, double v) {
        return stones(u, v, 8, 6, {0.40, 0.38, 0.34}, {0.54, 0.51, 0.46}, {0.30, 0.28, 0.25}, 0.03, 85);
    }));
    p.grass = textured(b, "grass", white, picture("grass", 256, [](double u, double v) {
        return foliage(u, v, {0.09, 0.13, 0.04}, {0.27, 0.29, 0.12}, 51);
    }));
    p.earth = plain(b, "earth", {0.33f, 0.26f, 0.19f});
    p.water = textured(b, "water", white, picture("water", 128, water));
    p.bark = plain(b, "bark", {0.19f, 0.14f, 0.10f});
    const int leaves = picture("leaves", 128, [](double u, double v) {
        return foliage(u, v, {0.25, 0.3, 0.2}, {0.95, 1.0, 0.8}, 55);
    });
    p.leaf[0] = textured(b, "plane tree", {0.20f, 0.32f, 0.09f}, leaves);
    p.leaf[1] = textured(b, "pine", {0.11f, 0.22f, 0.08f}, leaves);
    p.leaf[2] = textured(b, "cypress", {0.08f, 0.16f, 0.07f}, leaves);
    return p;
}

}  // namespace plumb::io::scenes::town
