// Where streets run and houses stand: a grid of streets, turned and warped, blocks between them, lots around each
// block.
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "io/scenes/city_parts.h"

namespace plumb::io::scenes::town {
namespace {

double length(const glm::dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }
glm::dvec2 left_of(const glm::dvec2& v) { return glm::dvec2(v.y, -v.x) / std::max(length(v), 1e-9); }

// Where two lines (a point and a direction each) meet.
glm::dvec2 meet(const glm::dvec2& p, const glm::dvec2& d, const glm::dvec2& q, const glm::dvec2& e) {
    const double across = d.x * e.y - d.y * e.x;
    if (std::abs(across) < 1e-9) return q;
    return p + d * (((q.x - p.x) * e.y - (q.y - p.y) * e.x) / across);
}

// The ring with each edge moved inwards by its own distance.
Ring inset(const Ring& ring, const std::array<double, 4>& by) {
    Ring result;
    for (int k = 0; k < 4; ++k) {
        const int before = (k + 3) % 4, after = (k + 1) % 4;
        const glm::dvec2 d = ring[k] - ring[before], e = ring[after] - ring[k];
        result[k] = meet(ring[k] + by[before] * left_of(d), d, ring[k] + by[k] * left_of(e), e);
    }
    return result;
}

double signed_area(const Ring& r) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) sum += r[(k + 1) % 4].x * r[k].y - r[k].x * r[(k + 1) % 4].y;
    return sum / 2;
}

double ellipse(const glm::dvec2& p, const glm::dvec2& centre, double a, double b) {
    const glm::dvec2 d = (p - centre) / glm::dvec2(a, b);
    return length(d);
}

// Squares, the river with its quays, the hill and the edge of the model stay free of houses.
bool is_free(const glm::dvec2& p, double margin) {
    if (std::max(std::abs(p.x), std::abs(p.y)) > half_extent - margin) return false;
    if (std::abs(p.x - river_x(p.y)) < river_half + 9 + margin) return false;
    if (ellipse(p, piazza, 74 + margin, 54 + margin) < 1) return false;
    if (std::abs(p.x - church.x) < 34 + margin && std::abs(p.y - church.y + 14) < 62 + margin) return false;
    if (ellipse(p, arena, 68 + margin, 60 + margin) < 1) return false;
    return length(p - hill) > hill_radius + margin;
}

// Cuts the houses along the four sides of a block.
void divide(Plan& plan, const Block& block, double width, double detail_below, Dice& dice) {
    const bool palace = dice.chance(0.14);
    const double shared_eaves = dice.between(15, 20);
    const int shared_tint = dice.pick(tints);
    for (int side = 0; side < 4; ++side) {
        const glm::dvec2 a = block.street[side], b = block.street[(side + 1) % 4];
        const glm::dvec2 c = block.yard[(side + 1) % 4], d = block.yard[side];
        const int count = std::max(1, int(length(b - a) / (width * (palace ? 1.6 : 1)) + 0.5));
        // Shares of the side, each house of its own width.
        std::vector<double> cuts{0};
        for (int k = 0; k < count; ++k) cuts.push_back(cuts.back() + dice.between(0.7, 1.3));
        for (int k = 0; k < count; ++k) {
            const double s = cuts[k] / cuts.back(), t = cuts[k + 1] / cuts.back();
            Lot lot;
            lot.ring = {a + s * (b - a), a + t * (b - a), d + t * (c - d), d + s * (c - d)};
            lot.seed = std::uint32_t(dice.rolls) * 7919u + dice.seed;
            lot.storeys = 3 + int(dice() * dice() * 4);
            lot.eaves = 4.2 + (lot.storeys - 1) * dice.between(3.1, 3.6);
            lot.tint = dice.pick(tints);
            if (palace)
                lot.palace = true, lot.storeys = 4, lot.eaves = shared_eaves, lot.tint = shared_tint;
            bool free = true;
            for (const glm::dvec2& corner : lot.ring) free &= is_free(corner, 0);
            if (free && dice() >= detail_below) plan.lots.push_back(lot);
        }
    }
}

void place_greenery(Plan& plan, const Grade& grade, Dice& dice) {
    // Plane trees along both quays.
    const double step = grade.fine < 1 ? 190 : grade.count(60, 9);
    for (double z = -half_extent + 8; z < half_extent - 5; z += step)
        for (int bank = -1; bank <= 1; bank += 2)
            plan.trees.push_back({river_x(z) + bank * (river_half + 5.5), z + dice.between(-1.5, 1.5)});
    // Pines and cypresses on the hill.
    const int pines = grade.count(1, 260);
    for (int k = 0; k < pines; ++k) {
        const double turn = 2 * host::pi * dice(), far = hill_radius * 0.94 * std::sqrt(dice());
        plan.pines.push_back(hill + far * glm::dvec2(host::sin(turn), host::cos(turn)));
    }
    // Around the amphitheatre.
    const int ring = grade.count(1, 36);
    for (int k = 0; k < ring; ++k) {
        const double turn = 2 * host::pi * (k + 0.5 * dice()) / ring;
        plan.pines.push_back(arena + glm::dvec2(64 * host::sin(turn), 55 * host::cos(turn)));
    }
    // In courts.
    for (const Block& block : plan.blocks) {
        if (!block.court || !block.whole || grade.fine < 1.2) continue;
        const int count = 1 + dice.pick(3);
        for (int k = 0; k < count; ++k) {
            const double s = dice.between(0.25, 0.75), t = dice.between(0.25, 0.75);
            const Ring& y = block.yard;
            plan.trees.push_back((1 - t) * ((1 - s) * y[0] + s * y[1]) + t * ((1 - s) * y[3] + s * y[2]));
        }
    }
}

void place_lamps(Plan& plan, const Grade& grade) {
    if (grade.fine < 1.9) return;
    for (const Block& block : plan.blocks)
        for (int side = 0; side < 4; ++side) {
            const glm::dvec2 a = block.street[side], b = block.street[(side + 1) % 4];
            const glm::dvec2 at = a + 0.5 * (b - a) - 1.0 * left_of(b - a);
            if (is_free(at, 0)) plan.lamps.push_back(at);
        }
    for (int k = 0; k < 12; ++k) {
        const double turn = 2 * host::pi * (k + 0.5) / 12;
        plan.lamps.push_back(piazza + glm::dvec2(38 * host::cos(turn), 27 * host::sin(turn)));
    }
}

}  // namespace

double river_x(double z) { return -172 + 26 * host::sin(z / 95 + 0.6) + 8 * host::sin(z / 41); }

double ground_height(const glm::dvec2& p) {
    const double far = length(p - hill) / hill_radius;
    if (far >= 1) return 0;
    const double rise = (1 - far * far) * (1 - far * far);
    return hill_height * rise * (0.9 + 0.2 * smooth_noise(p.x / 600 + 0.5, p.y / 600 + 0.5, 16, 5));
}

Plan make_plan(const Grade& grade, std::uint32_t seed) {
    Plan plan;
    Dice dice{seed * 977u + 3};
    // Streets: unevenly spaced lines, every fourth one an avenue.
    const double pitch = grade.triangles < 1800 ? 92 : grade.triangles < 4000 ? 66 : grade.triangles < 3e4 ? 78 : 56;
    std::vector<double> line[2];
    std::vector<double> street[2];
    for (int axis = 0; axis < 2; ++axis)
        for (double at = -1.4 * half_extent; at < 1.4 * half_extent; at += pitch * dice.between(0.8, 1.25)) {
            street[axis].push_back(line[axis].size() % 4 == 2 ? dice.between(9, 11) : dice.between(3.6, 7));
            line[axis].push_back(at);
        }
    // Nodes: turned by 14 degrees and pushed about by smooth noise.
    const auto node = [&](std::size_t i, std::size_t j) {
        const double x = line[0][i], z = line[1][j], u = x / 1000 + 0.5, v = z / 1000 + 0.5;
        const glm::dvec2 p(0.970 * x + 0.242 * z, -0.242 * x + 0.970 * z);
        return p + 44.0 * glm::dvec2(smooth_noise(u, v, 6, seed + 21) - 0.5, smooth_noise(u, v, 6, seed + 22) - 0.5);
    };
    const double width = std::clamp(10.0 * host::pow(1e6 / grade.triangles, 0.24), 9.0, 60.0);
    for (std::size_t i = 0; i + 1 < line[0].size(); ++i)
        for (std::size_t j = 0; j + 1 < line[1].size(); ++j) {
            Block block;
            const Ring middle = {node(i, j + 1), node(i + 1, j + 1), node(i + 1, j), node(i, j)};
            block.street =
                inset(middle, {street[1][j + 1] / 2, street[0][i + 1] / 2, street[1][j] / 2, street[0][i] / 2});
            if (signed_area(block.street) < 250) continue;
            // Houses 9 to 12 m deep, but never so deep that the court closes.
            double narrow = 1e9;
            for (int k = 0; k < 4; ++k) narrow = std::min(narrow, length(block.street[(k + 1) % 4] - block.street[k]));
            const double deep = std::min(dice.between(9, 12), 0.36 * narrow);
            block.yard = inset(block.street, {deep, deep, deep, deep});
            block.court = narrow - 2 * deep > 12;

            const std::size_t before = plan.lots.size();
            if (grade.triangles < 4000) {
                Lot lot;
                lot.ring = block.street, lot.detached = true, lot.storeys = 4, lot.eaves = dice.between(11, 18);
                lot.tint = dice.pick(tints), lot.seed = std::uint32_t(dice.rolls);
                bool free = true;
                for (const glm::dvec2& corner : lot.ring) free &= is_free(corner, -3);
                if (free) plan.lots.push_back(lot);
            } else {
                divide(plan, block, width, 0.02, dice);
            }
            block.whole = grade.triangles >= 4000;
            for (const Ring& ring : {block.street, block.yard})
                for (const glm::dvec2& corner : ring) block.whole &= is_free(corner, 0);
            if (plan.lots.size() > before) plan.blocks.push_back(block);
        }
    place_greenery(plan, grade, dice);
    place_lamps(plan, grade);
    return plan;
}

}  // namespace plumb::io::scenes::town
