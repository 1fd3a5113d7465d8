#include "gi/probes/lightmap_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gi/lend.h"
#include "gi/probes/bake.h"
#include "gi/probes/lod.h"
#include "gi/probes/update.h"

namespace plumb::probes {

namespace {

using StripLevel = LightmapLevel<float>;
constexpr int shift = raster::Covered::shift;

constexpr int rings = border_rings;
constexpr double margin = 0.125;  // texels that rounding may move a lookup by, and much more

// Texels [low, high] of a level.
struct Texels {
    glm::ivec2 low, high;
};
Texels around(glm::ivec2 texel, int reach, const StripLevel& level) {
    return {glm::max(texel - reach, glm::ivec2(0)), glm::min(texel + reach, glm::ivec2(level.side - 1))};
}

class TileMaker {
  public:
    explicit TileMaker(glm::ivec2 size) : size_(size), of_(size), always_(of_.any.size(), 0), shows_(of_.any.size()) {}

    void always(const StripLevel& level, const Texels& texels) {
        each(level, texels, [&](std::size_t tile) { always_[tile] = 1; });
    }
    void show(const StripLevel& level, const Texels& texels, std::int32_t cluster, int k) {
        const std::int32_t one = most_levels * cluster + k;
        each(level, texels, [&](std::size_t tile) {
            if (shows_[tile].empty() || shows_[tile].back() != one) shows_[tile].push_back(one);
        });
    }
    LightmapTiles made() {
        LightmapTiles t{size_, always_, {0}, {}};
        for (std::size_t tile = 0; tile < shows_.size(); ++tile) {
            std::vector<std::int32_t>& all = shows_[tile];
            std::sort(all.begin(), all.end());
            // Of each cluster the last, its coarsest level; where the tile is written anyway none.
            for (std::size_t i = 0; i < all.size() && !always_[tile]; ++i)
                if (i + 1 == all.size() || all[i + 1] / most_levels != all[i] / most_levels) t.shows.push_back(all[i]);
            t.first.push_back(std::int32_t(t.shows.size()));
        }
        return t;
    }

  private:
    template <class Each>
    void each(const StripLevel& level, const Texels& t, Each one) const {
        for (int y = (level.first + t.low.y) >> shift; y <= (level.first + t.high.y) >> shift; ++y)
            for (int x = t.low.x >> shift; x <= t.high.x >> shift; ++x) one(std::size_t(y) * std::size_t(of_.tiles.x) + std::size_t(x));
    }

    glm::ivec2 size_;
    raster::Covered of_;
    std::vector<std::uint8_t> always_;
    std::vector<std::vector<std::int32_t>> shows_;
};

// Which chart's receivers, of those in clusters, a texel of a level shows, or has rings of.
enum Owner : std::int32_t { nobody = -1, several = -2 };
void own(Image<std::int32_t>& owner, const Texels& t, std::int32_t chart) {
    for (int y = t.low.y; y <= t.high.y; ++y)
        for (int x = t.low.x; x <= t.high.x; ++x)
            if (std::int32_t& o = owner(x, y); o != chart) o = o == nobody ? chart : several;
}

// A triangle on a level, in texels whose centres are whole.
struct Footprint {
    std::array<glm::dvec2, 3> corner;

    glm::dvec2 low() const { return glm::min(glm::min(corner[0], corner[1]), corner[2]); }
    glm::dvec2 high() const { return glm::max(glm::max(corner[0], corner[1]), corner[2]); }
    // Whether it comes nearer than the margin to the square between four texels' centres: no edge has all of that on its far side.
    bool meets(glm::ivec2 texel) const {
        const glm::dvec2 centre = glm::dvec2(texel) + 0.5;
        const double half = 0.5 + margin;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec2 along = corner[(k + 1) % 3] - corner[k], across(-along.y, along.x);
            const double third = glm::dot(corner[(k + 2) % 3] - corner[k], across), at = glm::dot(centre - corner[k], across);
            const double reach = half * (std::fabs(across.x) + std::fabs(across.y));
            if (at - reach > std::max(third, 0.0) || at + reach < std::min(third, 0.0)) return false;
        }
        return true;
    }
};

// Lookups of a triangle that read nothing of its own chart: what they read is always written.
void add_lookups_without_receiver(const Bake& bake, const StripLevel& level, std::size_t triangle, const Image<std::int32_t>& owner, TileMaker& tiles) {
    const std::int32_t chart = bake.atlas.chart[triangle];
    if (chart < 0) return;  // no area: nothing is seen there
    Footprint f;
    for (int k = 0; k < 3; ++k)
        f.corner[std::size_t(k)] = (glm::dvec2(bake.atlas.uv[bake.atlas.geometry.triangles[triangle][k]]) * double(bake.atlas.size.x) - 0.5) * double(level.scale);
    const glm::ivec2 low(glm::floor(f.low() - margin)), high(glm::floor(f.high() + margin)), last(level.side - 1);
    const auto clamped = [&](glm::ivec2 t) { return glm::clamp(t, glm::ivec2(0), last); };
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) {
            const glm::ivec2 a = clamped({x, y}), b = clamped({x + 1, y + 1});
            if (owner(a.x, a.y) == chart || owner(b.x, a.y) == chart || owner(a.x, b.y) == chart || owner(b.x, b.y) == chart) continue;
            if (f.meets({x, y})) tiles.always(level, {a, b});
        }
}

}  // namespace

LightmapTiles lightmap_tiles(const Bake& bake, int levels, const std::vector<std::int32_t>& cluster, const std::vector<std::int32_t>& receiver_level) {
    const int side = bake.receivers.size.x;
    TileMaker tiles({side, lightmap_rows(side, levels)});
    for (int k = 0; k < levels; ++k) {
        const StripLevel level = lightmap_level<float>(side, levels, k);
        Image<std::int32_t> owner(level.side, level.side, nobody);
        for (std::size_t i = 0; i < receiver_level.size(); ++i) {
            if (receiver_level[i] < k) continue;
            const glm::ivec2 texel = bake.receivers.texel[i] >> k;
            if (cluster[i] < 0) {
                tiles.always(level, around(texel, rings, level));
                continue;
            }
            own(owner, around(texel, rings, level), bake.atlas.chart[std::size_t(bake.receivers.triangle[i])]);
            tiles.show(level, around(texel, lookup_reach, level), cluster[i], k);
        }
        for (std::size_t t = 0; t < bake.atlas.geometry.triangles.size(); ++t) add_lookups_without_receiver(bake, level, t, owner, tiles);
    }
    return tiles.made();
}

raster::Covered tiles_to_write(const LightmapTiles& tiles, const std::vector<std::int32_t>& cluster_level) {
    raster::Covered wanted(tiles.size);
    for (std::size_t t = 0; t < tiles.always.size(); ++t) {
        const auto shown = [&](std::int32_t one) {
            return cluster_level.empty() || cluster_level[std::size_t(one / most_levels)] <= one % most_levels;
        };
        wanted.any[t] = tiles.always[t] || std::any_of(tiles.shows.begin() + tiles.first[t], tiles.shows.begin() + tiles.first[t + 1], shown);
    }
    return wanted;
}

namespace {

void clear_tile(Image4& image, int tile_x, int tile_y) {
    const int x = tile_x << shift, beyond = std::min(x + raster::Covered::side, image.width);
    for (int y = tile_y << shift; y < std::min((tile_y + 1) << shift, image.height); ++y)
        std::fill(&image(x, y), &image(x, y) + (beyond - x), glm::vec4(0));
}

}  // namespace

void write_lightmap(const LightmapInputs& in, const RunOptions& options, TilesToWrite& tiles, Image4& lightmap) {
    StageData data = data_of(in);
    lend_tiles(data, &tiles.wanted);
    if (lightmap.width != data.size.x || lightmap.height != data.size.y || !tiles.written.fits(data.size))
        lightmap = Image4(data.size.x, data.size.y), tiles.written = raster::Covered(data.size);
    const glm::ivec2 count = tiles.wanted.tiles;
    for (int y = 0; y < count.y; ++y)
        for (int x = 0; x < count.x; ++x) {
            const std::size_t t = std::size_t(y) * std::size_t(count.x) + std::size_t(x);
            if (tiles.written.any[t] && !tiles.wanted.any[t]) clear_tile(lightmap, x, y);
        }
    tiles.written = tiles.wanted;
    run(stage<LightmapKernel>(), data, options, &lightmap.texels[0].x);
}

}  // namespace plumb::probes
