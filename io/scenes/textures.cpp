#include "io/scenes/textures.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/host_math.h"
#include "core/parallel.h"
#include "io/scenes/builder.h"

namespace plumb::io::scenes::textures {
namespace {

constexpr int side = 512;

double mix(double a, double b, double t) { return a + (b - a) * t; }
glm::dvec3 mix(const glm::dvec3& a, const glm::dvec3& b, double t) { return a + (b - a) * t; }
double smoothstep(double low, double high, double x) {
    const double t = std::min(std::max((x - low) / (high - low), 0.0), 1.0);
    return t * t * (3 - 2 * t);
}
double fraction(double x) { return x - std::floor(x); }
// A triangle wave of period 1 between -1 and 1: cheaper than a sine, and as good under noise.
double wave(double x) { return 4 * std::abs(fraction(x) - 0.5) - 1; }

// fractal_noise() from tables of its lattices: a texture asks for a million values.
class Noise {
  public:
    Noise(int periods, int octaves, std::uint32_t seed) {
        for (int k = 0; k < octaves; ++k) {
            const int n = periods << k;
            Lattice lattice{n, std::vector<double>(std::size_t(n + 1) * (n + 1))};
            for (int j = 0; j <= n; ++j)
                for (int i = 0; i <= n; ++i)
                    lattice.values[std::size_t(j) * (n + 1) + i] = white_noise(i % n, j % n, seed + std::uint32_t(k));
            lattices_.push_back(lattice);
        }
    }
    double operator()(double u, double v) const {
        double sum = 0, weight = 0.5, total = 0;
        u = fraction(u), v = fraction(v);
        for (const Lattice& l : lattices_) {
            const double x = u * l.n, y = v * l.n;
            const int i = std::min(int(x), l.n - 1), j = std::min(int(y), l.n - 1);
            const double* p = &l.values[std::size_t(j) * (l.n + 1) + i];
            const double s = x - i, t = y - j, a = s * s * (3 - 2 * s), b = t * t * (3 - 2 * t);
            sum += weight * mix(mix(p[0], p[1], a), mix(p[l.n + 1], p[l.n + 2], a), b);
            total += weight;
            weight *= 0.5;
        }
        return sum / total;
    }

  private:
    struct Lattice {
        int n;
        std::vector<double> values;
    };
    std::vector<Lattice> lattices_;
};

// Where a point lies in its block: which one, and how far from the nearest joint's middle, in texture sides.
struct InBlock {
    int column, row;
    double edge;
};
InBlock find_block(const Blocks& b, double u, double v) {
    const int row = std::min(int(v * b.rows), b.rows - 1);
    const double x = fraction(u + (row % 2) * 0.5 / b.columns) * b.columns, y = v * b.rows - row;
    const int column = std::min(int(x), b.columns - 1);
    const double along = std::min(x - column, 1 - (x - column)) / b.columns, across = std::min(y, 1 - y) / b.rows;
    return {column, row, std::min(along, across)};
}

}  // namespace

Texture blocks(const std::string& name, const Blocks& b) {
    const Noise clouds(5, 5, b.seed + 10), grain(64, 2, b.seed + 20), wobble(24, 2, b.seed + 30);
    return paint(name, side, [&](double u, double v) {
        const InBlock at = find_block(b, u, v);
        const double edge = at.edge + b.joint * 0.7 * (wobble(u, v) - 0.5);
        const double tone = 1 + b.variety * (white_noise(at.column, at.row, b.seed) - 0.5) * 2;
        const double warmth = 0.06 * (white_noise(at.column, at.row, b.seed + 1) - 0.5);
        const double surface = 0.78 + 0.3 * clouds(u, v) + 0.14 * (grain(u, v) - 0.5);
        const glm::dvec3 stone = b.stone * (tone * surface) * glm::dvec3(1 + warmth, 1, 1 - warmth);
        const glm::dvec3 mortar = b.mortar * (0.8 + 0.4 * grain(v, u));
        return mix(mortar, stone, smoothstep(0.6 * b.joint, 1.1 * b.joint, edge));
    });
}

Texture blocks_normals(const std::string& name, const Blocks& b, double depth) {
    const Noise rough(16, 5, b.seed + 10), wobble(24, 2, b.seed + 30);
    std::vector<double> height(std::size_t(side) * side);
    parallel_bands(side, 16, 0, [&](int first, int last) {
        for (int y = first; y < last; ++y)
            for (int x = 0; x < side; ++x) {
                const double u = (x + 0.5) / side, v = (y + 0.5) / side;
                const double edge = find_block(b, u, v).edge + b.joint * 0.7 * (wobble(u, v) - 0.5);
                const double worn = smoothstep(0.4 * b.joint, 2.2 * b.joint, edge);
                height[std::size_t(y) * side + x] = depth * (worn + 0.35 * rough(u, v));
            }
    });
    // Central differences; rows run downwards, the map's y upwards.
    auto at = [&](int x, int y) { return height[std::size_t(y & (side - 1)) * side + (x & (side - 1))]; };
    Texture texture;
    texture.name = name;
    texture.srgb = false;
    texture.texels = Image<std::uint32_t>(side, side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double dx = (at(x + 1, y) - at(x - 1, y)) * side / 2, dy = (at(x, y - 1) - at(x, y + 1)) * side / 2;
            const double scale = 1 / std::sqrt(dx * dx + dy * dy + 1);
            const double n[3] = {-dx * scale, -dy * scale, scale};
            std::uint32_t texel = 0xff000000u;
            for (int k = 0; k < 3; ++k) texel |= std::uint32_t(std::floor(127.5 * (n[k] + 1) + 0.5)) << (8 * k);
            texture.texels(x, y) = texel;
        }
    return texture;
}

Texture stone(const std::string& name, const glm::dvec3& tone, double contrast, std::uint32_t seed) {
    const Noise clouds(3, 6, seed), grain(96, 2, seed + 50);
    return paint(name, side, [&](double u, double v) {
        return tone * (1 + contrast * (clouds(u, v) - 0.5) + 0.3 * contrast * (grain(u, v) - 0.5));
    });
}

Texture marble(const std::string& name, int tiles, const glm::dvec3& light, const glm::dvec3& dark,
               std::uint32_t seed) {
    const Noise clouds(4, 5, seed), veins(3, 5, seed + 40);
    return paint(name, side, [&](double u, double v) {
        const int i = std::min(int(u * tiles), tiles - 1), j = std::min(int(v * tiles), tiles - 1);
        const double x = u * tiles - i, y = v * tiles - j;
        const double edge = std::min(std::min(x, 1 - x), std::min(y, 1 - y));
        // Each slab is cut from elsewhere.
        const double shift_u = white_noise(i, j, seed + 1), shift_v = white_noise(i, j, seed + 2);
        const double vein = 1 - std::abs(2 * veins(u + shift_u, v + shift_v) - 1) * 9;
        const double tone = 0.88 + 0.16 * white_noise(i, j, seed + 3) + 0.22 * (clouds(u + shift_v, v + shift_u) - 0.5);
        glm::dvec3 c = ((i + j) % 2 == 0 ? light : dark) * tone;
        c = mix(c, (i + j) % 2 == 0 ? dark : light, 0.35 * std::max(vein, 0.0));
        return mix(dark * 0.35, c, smoothstep(0.008, 0.02, edge));
    });
}

Texture wood(const std::string& name, int boards, const glm::dvec3& tone, std::uint32_t seed) {
    const Noise bend(3, 3, seed), grain(64, 2, seed + 60);
    return paint(name, side, [&](double u, double v) {
        const int board = std::min(int(u * boards), boards - 1);
        const double x = u * boards - board, edge = std::min(x, 1 - x);
        const double shift = white_noise(board, 0, seed + 1);
        const double rings = wave(7 * (x + 0.35 * bend(u + shift, v + shift)) + 5 * shift);
        const double fibres = grain(u, v * 0.125) - 0.5;
        const double shade = 0.86 + 0.28 * shift + 0.13 * rings + 0.3 * fibres;
        return tone * (shade * mix(0.3, 1, smoothstep(0.0, 0.035, edge)));
    });
}

Texture fabric(const std::string& name, std::uint32_t seed) {
    const Noise worn(4, 4, seed);
    // A lozenge with petals: painted once, it comes back in every cell.
    constexpr int cells = 4, cell = side / cells;
    std::vector<double> motif(std::size_t(cell) * cell);
    for (int j = 0; j < cell; ++j)
        for (int i = 0; i < cell; ++i) {
            const double x = (i + 0.5) / cell - 0.5, y = (j + 0.5) / cell - 0.5;
            const double lozenge = std::abs(x) + 0.8 * std::abs(y), distance = std::sqrt(x * x + y * y);
            const double petals = distance - 0.16 - 0.09 * wave(host::atan2(y, x) / host::pi * 2.5 + 0.25);
            motif[std::size_t(j) * cell + i] =
                std::max(smoothstep(0.02, -0.02, petals), smoothstep(0.03, 0.012, std::abs(lozenge - 0.4)));
        }
    return paint(name, side, [&](double u, double v) {
        // Threads over and under each other.
        const double warp = wave(u * 64), weft = wave(v * 64);
        const bool over = (int(u * 64) + int(v * 64)) % 2 == 0;
        const double thread = 0.9 + 0.1 * (over ? warp : weft);
        // In half-drop.
        const double x = fraction(u * cells), y = fraction(v * cells + 0.5 * (int(u * cells) % 2));
        const double tone = thread * (0.86 + 0.12 * worn(u, v));
        return mix(glm::dvec3(0.7), glm::dvec3(1.0, 0.97, 0.86), motif[std::size_t(y * cell) * cell + int(x * cell)]) *
               tone;
    });
}

Texture clay(const std::string& name, const glm::dvec3& tone, std::uint32_t seed) {
    const Noise clouds(4, 5, seed), streaks(32, 2, seed + 70);
    return paint(name, side, [&](double u, double v) {
        const double shade = 0.75 + 0.4 * clouds(u, v) + 0.2 * (streaks(u, v * 0.0625) - 0.5);
        return mix(tone, glm::dvec3(0.33, 0.31, 0.27), 0.45 * smoothstep(0.55, 0.75, clouds(v, u))) * shade;
    });
}

Texture leaves(const std::string& name, std::uint32_t seed) {
    struct Leaf {
        glm::dvec2 at, along;
        double size, shade;
    };
    // Leaves hang, tips down and to either side; later ones lie on top.
    std::vector<Leaf> all;
    for (int k = 0; k < 80; ++k) {
        const double angle = host::pi * (0.5 + 0.9 * (white_noise(k, 2, seed) - 0.5));
        all.push_back({{white_noise(k, 0, seed), white_noise(k, 1, seed)},
                       {host::cos(angle), host::sin(angle)},
                       0.055 + 0.04 * white_noise(k, 3, seed),
                       0.55 + 0.6 * white_noise(k, 4, seed)});
    }
    std::vector<glm::dvec4> texels(std::size_t(side) * side, glm::dvec4(0.1, 0.18, 0.05, 0));
    for (const Leaf& leaf : all) {
        const int reach = int(leaf.size * side) + 1, x0 = int(leaf.at.x * side), y0 = int(leaf.at.y * side);
        for (int y = y0 - reach; y <= y0 + reach; ++y)
            for (int x = x0 - reach; x <= x0 + reach; ++x) {
                const glm::dvec2 p = (glm::dvec2(x + 0.5, y + 0.5) / double(side) - leaf.at) / leaf.size;
                // Along and across the leaf: a blade with a broad shoulder at -0.5 and a pointed tip at 1.
                const double s = p.x * leaf.along.x + p.y * leaf.along.y, t = p.y * leaf.along.x - p.x * leaf.along.y;
                const double half = s < -0.5 ? 0.62 * std::sqrt(std::max(1 - 4 * (s + 0.5) * (s + 0.5), 0.0))
                                             : 0.62 * (1 - (s + 0.5) / 1.5);
                if (!(std::abs(t) < half)) continue;
                const double vein =
                    smoothstep(0.05, 0.0, std::abs(t)) + 0.5 * smoothstep(0.8, 1.0, wave(s * 3 + std::abs(t) * 2));
                const glm::dvec3 green = glm::dvec3(0.11, 0.22, 0.05) * (leaf.shade * (1 + 0.35 * vein));
                texels[std::size_t(y & (side - 1)) * side + (x & (side - 1))] = glm::dvec4(green, 1);
            }
    }
    return paint_masked(name, side, [&](double u, double v) {
        return texels[std::size_t(int(v * side)) * side + int(u * side)];
    });
}

}  // namespace plumb::io::scenes::textures
