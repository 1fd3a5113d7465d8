#include "gi/probes/receivers.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/probes/directions.h"
#include "gi/probes/receiver_rays.h"
#include "raster/texture_space.h"

namespace plumb::probes {

namespace {

bool inside(const glm::ivec2& texel, const glm::ivec2& size) {
    return texel.x >= 0 && texel.y >= 0 && texel.x < size.x && texel.y < size.y;
}

std::uint32_t border_of(const raster::TextureSpace& drawn, const glm::ivec2& texel, const glm::ivec2& size) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < border_steps.size(); ++k) {
        const glm::ivec2 beside = texel + border_steps[k];
        if (inside(beside, size) && drawn.id(beside.x, beside.y).y < 0) bits |= 1u << k;
    }
    return bits;
}

}  // namespace

Receivers place_receivers(const Atlas& atlas, const raster::Surfaces& surfaces, const RunOptions& options) {
    raster::TextureSpace drawn;
    raster::draw_texture_space(atlas.geometry, surfaces, atlas.uv, atlas.size, options, drawn);
    Receivers r;
    r.size = atlas.size;
    for (int y = 0; y < atlas.size.y; ++y)
        for (int x = 0; x < atlas.size.x; ++x) {
            const glm::ivec3 id = drawn.id(x, y);
            if (id.y < 0) continue;
            r.position.push_back(glm::vec4(glm::vec3(drawn.position(x, y)), 0));
            r.normal.push_back(glm::vec4(glm::vec3(drawn.normal(x, y)), 0));
            r.texel.push_back({x, y});
            r.triangle.push_back(id.y);
            r.material.push_back(id.z);
            r.border.push_back(border_of(drawn, {x, y}, atlas.size));
        }
    if (r.position.empty())
        throw InputError("receivers: no surface covers a texel of the lightmap: raise the density or the size");
    r.shift.assign(r.position.size(), glm::vec4(0));
    return r;
}

int shift_receivers(Receivers& receivers, const raster::SurfaceArgs& surfaces, const RayQuery& query, float offset,
                    const ShiftParams& params, const RunOptions& options) {
    if (params.rays == 0) return 0;
    const Buffer<glm::vec4> directions =
        params.in_the_air ? relight_directions(params.rays) : receiver_directions(params.rays, Distribution::uniform);
    const int count = receivers.count();
    Buffer<glm::vec4> shortest(std::size_t(count), glm::vec4(0));
    std::vector<std::int32_t> insides(std::size_t(count), 0), escapes(std::size_t(count), 0);
    const int least = params.in_the_air ? 0 : std::min(followed_from(params.rays), std::max(1, int(std::ceil(params.share * params.rays))));
    TestRaysView view{surfaces, offset, params.rays, params.crossings, &receivers.position[0].x, &receivers.normal[0].x, &directions[0].x,
                      &shortest[0].x, insides.data(), params.in_the_air ? escapes.data() : nullptr, least};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(count, 256, options,
                       [&](int first, int last) { ReceiverRays<isa()>::test(view, query, first, last); });
    });
    int moved = 0;
    for (int i = 0; i < count; ++i) {
        if (!(insides[i] > 0 && double(insides[i]) >= params.share * (params.rays - escapes[i]))) continue;
        const glm::dvec3 along(shortest[i]);
        // It started `offset` above the surface, and ends as far beyond the back where it came out.
        const glm::dvec3 by = glm::dvec3(receivers.normal[i]) * double(offset) +
                              along * (double(shortest[i].w) + 2 * double(offset));
        receivers.shift[i] = glm::vec4(glm::vec3(by), 1);
        receivers.position[i] = glm::vec4(glm::vec3(glm::dvec3(receivers.position[i]) + by), 0);
        ++moved;
    }
    return moved;
}

float offset_of(float extent) { return extent * 0x1p-18f; }

float extent_of(const Geometry& geometry) {
    float extent = 0;
    for (const Vertex& v : geometry.vertices)
        extent = std::max({extent, std::fabs(v.position.x), std::fabs(v.position.y), std::fabs(v.position.z)});
    return extent;
}

// ---- Border texels ---------------------------------------------------------------------------------------------------

Image4 scatter(const Receivers& receivers, const Buffer<glm::vec4>& values) {
    Image4 lightmap(receivers.size.x, receivers.size.y);
    for (int i = 0; i < receivers.count(); ++i) lightmap(receivers.texel[i].x, receivers.texel[i].y) = values[i];
    return lightmap;
}

namespace {

Image4 extend_published(const Receivers& receivers, const Image4& lightmap) {
    Image4 out = lightmap;
    for (int i = 0; i < receivers.count(); ++i)
        for (std::size_t k = 0; k < border_steps.size(); ++k) {
            if (!(receivers.border[i] >> k & 1)) continue;
            const glm::ivec2 to = receivers.texel[i] + border_steps[k];
            out(to.x, to.y) = lightmap(receivers.texel[i].x, receivers.texel[i].y);
        }
    return out;
}

// Gives texels without a value the mean of those among their 8 neighbours that have one.
void extend_once(Image4& lightmap, Image<std::uint8_t>& has_value) {
    const Image4 before = lightmap;
    const Image<std::uint8_t> had_value = has_value;
    const glm::ivec2 size(lightmap.width, lightmap.height);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if (had_value(x, y)) continue;
            glm::vec4 sum(0);
            int n = 0;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const glm::ivec2 beside(x + dx, y + dy);
                    if (!inside(beside, size) || !had_value(beside.x, beside.y)) continue;
                    sum += before(beside.x, beside.y);
                    ++n;
                }
            if (n == 0) continue;
            lightmap(x, y) = sum / float(n);
            has_value(x, y) = 1;
        }
}

}  // namespace

Image4 extend_borders(const Receivers& receivers, const Image4& lightmap, bool published) {
    if (published) return extend_published(receivers, lightmap);
    Image<std::uint8_t> has_value(receivers.size.x, receivers.size.y);
    for (const glm::ivec2& t : receivers.texel) has_value(t.x, t.y) = 1;
    Image4 out = lightmap;
    for (int ring = 0; ring < border_rings; ++ring) extend_once(out, has_value);
    return out;
}

}  // namespace plumb::probes
