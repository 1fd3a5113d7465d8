// Colours and materials of a flat: drawn from its seed.
#include <algorithm>
#include <cmath>

#include "io/scenes/rooms_parts.h"

namespace plumb::io::scenes::flat {
namespace {

glm::vec3 colour(Dice& dice, double saturation, double brightness) {
    // Red, green and blue as three phases of a hue.
    const double hue = dice();
    glm::vec3 c;
    for (int k = 0; k < 3; ++k) {
        const double t = hue + k / 3.0, wave = std::abs(2 * (t - std::floor(t)) - 1);
        c[k] = float(std::clamp(brightness * (1 - saturation * wave), 0.02, 0.92));
    }
    return c;
}

glm::dvec3 boards(double u, double v, const glm::dvec3& dark, const glm::dvec3& light) {
    const double row = v * 12, i = std::floor(row), joint = row - i;
    const double shift = u * 2 + white_noise(int(i), 1, 9), plank = std::floor(shift);
    if (joint < 0.035 || shift - plank < 0.004) return 0.35 * dark;
    const double tone = 0.6 * white_noise(int(i), int(plank) % 2, 10) + 0.4 * fractal_noise(u, v, 3, 3, 11);
    const double grain = smooth_noise(u, v * 8 - std::floor(v * 8), 24, 12);
    return (dark + (light - dark) * tone) * (0.88 + 0.2 * grain);
}

glm::dvec3 weave(double u, double v, const glm::dvec3& a, const glm::dvec3& c) {
    const double x = std::abs(2 * u - 1), y = std::abs(2 * v - 1), ring = std::max(x, y);
    const bool band = (ring > 0.82 && ring < 0.9) || (x + y < 0.7 && x + y > 0.55) || x + y < 0.25;
    const bool dots = u * 16 - std::floor(u * 16) < 0.3 && v * 16 - std::floor(v * 16) < 0.3;
    return (band ? c : dots ? 0.5 * (a + c) : a) * (0.8 + 0.3 * white_noise(int(u * 128), int(v * 128), 15));
}

glm::dvec3 painting(double u, double v, std::uint32_t seed) {
    const double land = 0.45 + 0.25 * fractal_noise(u, 0.3, 3, 3, seed),
                 sun = (u - 0.7) * (u - 0.7) + (v - 0.75) * (v - 0.75);
    if (v > land)
        return sun < 0.006 ? glm::dvec3(0.9, 0.7, 0.3)
                           : glm::dvec3(0.35, 0.5, 0.7) + glm::dvec3(0.4, 0.2, 0.0) * (1 - v);
    const double n = fractal_noise(u, v, 5, 3, seed + 7);
    return glm::dvec3(0.15, 0.3, 0.1) * (1 - n) + glm::dvec3(0.5, 0.35, 0.12) * n;
}

}  // namespace

Finish make_finish(Builder& b, Dice& dice) {
    const auto plain = [&](const std::string& name, const glm::vec3& reflectance, int texture = -1) {
        Material m;
        m.name = name, m.reflectance = reflectance, m.texture = texture;
        return b.material(m);
    };
    Finish f;
    for (int k = 0; k < 4; ++k) {
        const double saturation = dice.between(0.05, 0.55);
        f.wall[k] = plain("wall " + std::to_string(k), colour(dice, saturation, 0.6 + 0.25 * dice.between(0, 1)));
    }
    f.ceiling = plain("ceiling", glm::vec3(0.82f));
    f.white = plain("white paint", glm::vec3(0.8f));
    f.sill = plain("sill", glm::vec3(0.7f, 0.68f, 0.64f));
    const double tone = dice.between(0.5, 1.1);
    f.floor = plain("boards", glm::vec3(1), b.texture(paint("boards", 256, [tone](double u, double v) {
        return boards(u, v, tone * glm::dvec3(0.28, 0.17, 0.09), tone * glm::dvec3(0.52, 0.35, 0.20));
    })));
    const glm::vec3 woods[3] = {{0.42f, 0.28f, 0.16f}, {0.20f, 0.12f, 0.07f}, {0.62f, 0.52f, 0.40f}};
    for (int k = 0; k < 3; ++k)
        f.wood[k] = plain("wood " + std::to_string(k), woods[k] * float(dice.between(0.8, 1.1)));
    for (int k = 0; k < 4; ++k)
        f.cloth[k] = plain("cloth " + std::to_string(k), colour(dice, 0.7, dice.between(0.35, 0.75)));
    for (int k = 0; k < 6; ++k)
        f.paper[k] = plain("book " + std::to_string(k), colour(dice, 0.75, dice.between(0.2, 0.7)));
    f.metal = plain("metal", glm::vec3(0.12f));
    Material shade;
    shade.name = "shade", shade.reflectance = {0.80f, 0.74f, 0.62f}, shade.emission = {2.4f, 1.9f, 1.2f};
    f.shade = b.material(shade);
    f.leaf = plain("leaf", {0.10f, 0.28f, 0.08f});
    const glm::dvec3 ground(colour(dice, 0.7, 0.5)), pattern(colour(dice, 0.5, 0.8));
    f.rug = plain("rug", glm::vec3(1), b.texture(paint("rug", 128, [=](double u, double v) {
        return weave(u, v, ground, pattern);
    })));
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t seed = 40 + 13 * std::uint32_t(dice.pick(50));
        f.picture[k] = plain("picture " + std::to_string(k), glm::vec3(1),
                             b.texture(paint("picture " + std::to_string(k), 96,
                                             [=](double u, double v) { return painting(u, v, seed); })));
    }
    return f;
}

}  // namespace plumb::io::scenes::flat
