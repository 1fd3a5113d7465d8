#include "gi/radiosity/lookup.h"

#include "gi/lend.h"

namespace plumb::radiosity {

TriangleElements triangle_elements(const Elements& elements) {
    TriangleElements t;
    const Geometry& g = elements.geometry;
    for (std::size_t i = 0; i < g.triangles.size(); ++i) {
        for (int k = 0; k < 3; ++k) t.corners.push_back(glm::vec4(g.vertices[g.triangles[i][k]].position, 0));
        t.of.push_back(glm::ivec4(glm::ivec3(elements.of[i]), 0));
    }
    return t;
}

StageData data_of(const LookupInputs& in) {
    const Image4& position = bound("radiosity.lookup", "position", in.position);
    if (!in.id || !in.triangles || !in.irradiance) throw InputError("radiosity.lookup: id, triangles and irradiance must be bound");
    // Of a scene without any: one that no pixel sees.
    static const TriangleElements no_triangle{Buffer<glm::vec4>(3, glm::vec4(0)), {glm::ivec4(0)}};
    static const Buffer<glm::vec4> no_element(1, glm::vec4(0));
    const TriangleElements& t = in.triangles->of.empty() ? no_triangle : *in.triangles;
    const Buffer<glm::vec4>& own = in.irradiance->empty() ? no_element : *in.irradiance;
    const std::int64_t triangles = std::int64_t(t.of.size()), elements = std::int64_t(own.size());
    StageData d = begin_data<LookupKernel>(size_of(position), LookupUniforms{position.width, position.height, int(triangles), int(elements)});
    lend(d, {{"position", in.position}});
    lend(d.inputs, "id", {std::int64_t(in.id->size()), 2}, &in.id->data()->x);
    lend(d.inputs, "corners", {3 * triangles, 4}, &t.corners[0].x);
    lend(d.inputs, "of", {triangles, 4}, &t.of[0].x);
    lend(d.inputs, "own", {elements, 4}, &own[0].x);
    return d;
}

}  // namespace plumb::radiosity
