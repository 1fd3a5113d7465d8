#include "gi/stability/lookup.h"

#include <algorithm>
#include <cmath>

#include "gi/lend.h"
#include "gi/probes/lightmap_uv.h"
#include "gi/probes/lookup.h"

namespace plumb::stability {

std::vector<StageData> lookup_data(const probes::Bake& bake) {
    const probes::Receivers& r = bake.receivers;
    const int n = std::min(96, r.count());
    Image4 position(n, 1);
    Image<glm::ivec2> id(n, 1);
    for (int i = 0; i < n; ++i) {
        const std::size_t of = std::size_t(i) * std::size_t(r.count()) / std::size_t(n);
        position(i, 0) = glm::vec4(glm::vec3(r.position[of] - r.shift[of]), 0);
        id(i, 0) = {0, r.triangle[of]};
    }
    probes::ChartedTriangles charted;
    for (const glm::uvec3& t : bake.atlas.geometry.triangles) {
        glm::vec4 v(0);
        charted.charted_of.push_back(std::int32_t(charted.charted_of.size()));
        for (int k = 0; k < 3; ++k) {
            charted.corners.emplace_back(bake.atlas.geometry.vertices[t[k]].position, bake.atlas.uv[t[k]].x);
            v[k] = bake.atlas.uv[t[k]].y;
        }
        charted.corners.push_back(v);
    }
    const glm::vec3 across(position(n - 1, 0) - position(0, 0));
    const float length = std::sqrt(across.x * across.x + across.y * across.y + across.z * across.z);
    probes::LevelRule rule;
    rule.levels = 3, rule.eye = position(0, 0), rule.forward = glm::vec4(across / std::max(length, 1e-30f), 0);
    rule.distances = {0.3f * length, 0.6f * length, length, 0}, rule.widths = {0.1f * length, 0.2f * length, 0.2f * length, 0};
    rule.scales = {1, 1, 1, 0};
    std::vector<StageData> all;
    all.push_back(owned(stage<probes::LightmapUvKernel>(), data_of(probes::LightmapUvInputs{&position, &id, &charted, rule})));
    all.back().label = all.back().stage;

    const int side = bake.atlas.size.x;
    Image4 lightmap(side, probes::lightmap_rows(side, rule.levels)), uv(n, 1);
    for (std::size_t i = 0; i < lightmap.size(); ++i) lightmap.texels[i] = {1 + float(i % 7), 0.25f * float(i % 5), i % 3 == 0 ? 0.0f : 2.0f, 1};
    for (int i = 0; i < n; ++i)
        uv(i, 0) = {(float(i % 10) + 0.31f) / 10, (float(i / 10) + 0.77f) / 10, 0.13f * float(i % 17), 1};
    all.push_back(owned(stage<probes::LookupKernel>(), data_of(probes::LookupInputs{&uv, &lightmap, rule.levels})));
    all.back().label = all.back().stage;
    return all;
}

}  // namespace plumb::stability
