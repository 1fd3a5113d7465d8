#include "gi/probes/lightmap.h"

#include <algorithm>
#include <cmath>

#include "gi/reference/ray_query.h"

namespace plumb::probes {

Lightmap place_lightmap(const Scene& scene, Atlas atlas, const BakeParams& params, const RunOptions& options) {
    validate(params);
    Lightmap l;
    l.atlas = std::move(atlas);
    l.surfaces = raster::prepare(scene, l.atlas.geometry);
    l.receivers = place_receivers(l.atlas, l.surfaces, options);
    const auto query = reference::build_ray_query(l.atlas.geometry, l.surfaces, params.rays);
    l.moved = shift_receivers(l.receivers, raster::surface_args(l.atlas.geometry, l.surfaces, View{}), *query,
                              offset_of(extent_of(l.atlas.geometry)), shift_params(params), options);
    return l;
}

Bilinear bilinear(const glm::dvec2& at, const glm::ivec2& size) {
    const glm::dvec2 p = at - 0.5, low = glm::floor(p), part = p - low;
    Bilinear b;
    for (int k = 0; k < 4; ++k) {
        const int x = k % 2, y = k / 2;
        b.texel[std::size_t(k)] = glm::clamp(glm::ivec2(low) + glm::ivec2(x, y), glm::ivec2(0), size - 1);
        b.weight[std::size_t(k)] = (x ? part.x : 1 - part.x) * (y ? part.y : 1 - part.y);
    }
    return b;
}

ChartTexels::ChartTexels(const Atlas& atlas, const Receivers& receivers, const ReceiverIrradiance& truth)
    : atlas_(atlas), receivers_(receivers), truth_(truth), receiver_(receivers.size.x, receivers.size.y, -1) {
    for (int i = 0; i < receivers.count(); ++i) {
        const glm::ivec2 t = receivers.texel[std::size_t(i)];
        receiver_(t.x, t.y) = i;
    }
}

int ChartTexels::receiver_at(const glm::ivec2& t) const {
    const bool inside = t.x >= 0 && t.y >= 0 && t.x < receiver_.width && t.y < receiver_.height;
    return inside ? receiver_(t.x, t.y) : -1;
}

bool ChartTexels::is_of(std::int32_t chart, const glm::ivec2& texel) const {
    const int i = receiver_at(texel);
    return i >= 0 && chart_of(i) == chart;
}

namespace {

template <class Call>
void for_neighbours(const glm::ivec2& texel, Call call) {
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (dx != 0 || dy != 0) call(texel + glm::ivec2(dx, dy));
}

}  // namespace

std::vector<glm::ivec2> ChartTexels::beside(std::int32_t chart, const glm::ivec2& texel, int ring) const {
    std::vector<glm::ivec2> texels;
    for_neighbours(texel, [&](const glm::ivec2& t) {
        const bool inside = t.x >= 0 && t.y >= 0 && t.x < receiver_.width && t.y < receiver_.height;
        if (inside && (ring == 1 ? is_of(chart, t) : !is_of(chart, t) && !beside(chart, t, 1).empty())) texels.push_back(t);
    });
    return texels;
}

bool ChartTexels::add_receivers(std::int32_t chart, const glm::ivec2& texel, double weight, Weights& weights) const {
    if (is_of(chart, texel)) {
        const int here = receiver_at(texel);
        const auto at = std::find_if(weights.begin(), weights.end(), [&](const auto& w) { return w.first == here; });
        if (at == weights.end())
            weights.push_back({here, weight});
        else
            at->second += weight;
        return true;
    }
    for (int ring = 1; ring <= border_rings; ++ring) {
        const std::vector<glm::ivec2> texels = beside(chart, texel, ring);
        for (const glm::ivec2& t : texels) add_receivers(chart, t, weight / double(texels.size()), weights);
        if (!texels.empty()) return true;
    }
    return false;
}

TexelValue ChartTexels::expected(std::int32_t chart, const glm::ivec2& texel) const {
    Bilinear one;
    one.texel.fill(texel), one.weight = {1, 0, 0, 0};
    return lookup(chart, one);
}

TexelValue ChartTexels::lookup(std::int32_t chart, const Bilinear& from) const {
    Weights weights;
    for (std::size_t k = 0; k < 4; ++k)
        if (from.weight[k] != 0 && !add_receivers(chart, from.texel[k], from.weight[k], weights)) return {};
    TexelValue sum;
    sum.known = true;
    glm::dvec3 variance(0);
    for (const auto& [receiver, weight] : weights) {
        const glm::dvec3 error = weight * glm::dvec3(truth_.error[std::size_t(receiver)]);
        sum.value += weight * glm::dvec3(truth_.mean[std::size_t(receiver)]), variance += error * error;
    }
    for (int c = 0; c < 3; ++c) sum.error[c] = std::sqrt(variance[c]);
    return sum;
}

}  // namespace plumb::probes
