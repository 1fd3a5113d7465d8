#include "gi/probes/lightmap_uv.h"

#include <algorithm>

#include "gi/lend.h"
#include "gi/probes/atlas.h"
#include "gi/probes/lookup.h"
#include "gi/probes/static_scene.h"

namespace plumb::probes {

ChartedTriangles charted_triangles(const Scene& scene, const Geometry& geometry, const Atlas& atlas) {
    ChartedTriangles c{static_triangles(scene, geometry), {}};
    const std::ptrdiff_t next = std::count_if(c.charted_of.begin(), c.charted_of.end(), [](std::int32_t i) { return i >= 0; });
    if (std::size_t(next) != atlas.geometry.triangles.size())
        throw InputError(fmt::format("probes: the scene's static meshes have {} triangles, those of the bake {}", next,
                                     atlas.geometry.triangles.size()));
    c.corners.reserve(4 * std::size_t(next));
    for (const glm::uvec3& t : atlas.geometry.triangles) {
        glm::vec4 v(0);
        for (int k = 0; k < 3; ++k) {
            const glm::vec2 uv = atlas.uv[t[k]];
            c.corners.emplace_back(atlas.geometry.vertices[t[k]].position, uv.x);
            v[k] = uv.y;
        }
        c.corners.push_back(v);
    }
    return c;
}

StageData data_of(const LightmapUvInputs& in) {
    const Image4& position = bound("probes.lightmap_uv", "position", in.position);
    if (!in.id || !in.charted) throw InputError("probes.lightmap_uv: id and charted triangles must be bound");
    static const std::int32_t no_triangle = -1;
    static const glm::vec4 no_corners[4] = {};
    const std::int64_t triangles = std::int64_t(in.charted->charted_of.size()), corners = std::int64_t(in.charted->corners.size());
    LightmapUvUniforms u{position.width, position.height, std::int32_t(std::max<std::int64_t>(triangles, 1)),
                         std::int32_t(std::max<std::int64_t>(corners / 4, 1)), in.rule.levels, {}, {}, {}, {}, {}, {}, {}};
    const auto put = [](float* to, const glm::vec4& from) {
        for (int c = 0; c < 4; ++c) to[c] = from[c];
    };
    put(u.eye, in.rule.eye), put(u.forward, in.rule.forward), put(u.zones, in.rule.zones);
    put(u.scales, in.rule.scales), put(u.distances, in.rule.distances), put(u.widths, in.rule.widths);
    StageData d = begin_data<LightmapUvKernel>(size_of(position), u);
    lend(d, {{"position", in.position}});
    lend(d.inputs, "id", {std::int64_t(in.id->size()), 2}, &in.id->data()->x);
    lend(d.inputs, "charted_of", {std::max<std::int64_t>(triangles, 1)}, triangles > 0 ? in.charted->charted_of.data() : &no_triangle);
    lend(d.inputs, "corners", {std::max<std::int64_t>(corners, 4), 4}, corners > 0 ? &in.charted->corners[0].x : &no_corners[0].x);
    return d;
}

StageData data_of(const LookupInputs& in) {
    const Image4 &uv = bound("probes.lookup", "uv", in.uv), &lightmap = bound("probes.lookup", "lightmap", in.lightmap);
    StageData d = begin_data<LookupKernel>(size_of(uv), LookupUniforms{uv.width, uv.height, lightmap.width, in.levels});
    lend(d, {{"uv", in.uv}, {"lightmap", in.lightmap}});
    return d;
}

}  // namespace plumb::probes
