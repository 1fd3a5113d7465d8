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

int ChartTexels::receivers_of(std::int32_t chart, const glm::ivec2& texel, std::array<int, 8>& which) const {
    const int here = receiver_at(texel);
    if (here >= 0 && chart_of(here) == chart) {
        which[0] = here;
        return 1;
    }
    int n = 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int beside = receiver_at(texel + glm::ivec2(dx, dy));
            if ((dx != 0 || dy != 0) && beside >= 0 && chart_of(beside) == chart) which[std::size_t(n++)] = beside;
        }
    return n;
}

TexelValue ChartTexels::expected(std::int32_t chart, const glm::ivec2& texel) const {
    Bilinear one;
    one.texel.fill(texel), one.weight = {1, 0, 0, 0};
    return lookup(chart, one);
}

TexelValue ChartTexels::lookup(std::int32_t chart, const Bilinear& from) const {
    // One list of receivers, each once, with its weight.
    std::array<int, 32> receiver;
    std::array<double, 32> weight;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        if (from.weight[k] == 0) continue;
        std::array<int, 8> which;
        const int n = receivers_of(chart, from.texel[k], which);
        if (n == 0) return {};
        for (int i = 0; i < n; ++i) {
            const auto end = receiver.begin() + std::ptrdiff_t(count), at = std::find(receiver.begin(), end, which[std::size_t(i)]);
            const std::size_t place = std::size_t(at - receiver.begin());
            if (at == end) receiver[count] = which[std::size_t(i)], weight[count] = 0, ++count;
            weight[place] += from.weight[k] / n;
        }
    }
    TexelValue sum;
    sum.known = true;
    glm::dvec3 variance(0);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 error = weight[i] * glm::dvec3(truth_.error[std::size_t(receiver[i])]);
        sum.value += weight[i] * glm::dvec3(truth_.mean[std::size_t(receiver[i])]), variance += error * error;
    }
    for (int c = 0; c < 3; ++c) sum.error[c] = std::sqrt(variance[c]);
    return sum;
}

}  // namespace plumb::probes
