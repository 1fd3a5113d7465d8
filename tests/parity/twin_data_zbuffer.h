// Data for the z-buffer techniques: a floor and a wall of triangles, lamps of all kinds, materials from dull to sharp.
#pragma once

#include <vector>

#include "gi/zbuffer/zbuffer.h"
#include "tests/parity/twin_data_parts.h"

namespace plumb::test {

struct ZbufferData {
    zbuffer::VertexTable table;
    std::vector<Light> lights;
    Points points;
    Image4 albedo, emission;
    Image<glm::ivec2> id;
    glm::vec3 eye{0.4f, 1.7f, 3.1f};
};

// Triangles of room(): floor and wall. Their vertices' normals are rough, some cancel, some are none; one triangle has no area. One
// row of each list lies behind what counts.
inline ZbufferData zbuffer_data(glm::ivec2 size) {
    ZbufferData d;
    d.points = room(size, 5), d.albedo = noise_image(size, 31, 0, 1), d.emission = noise_image(size, 32, 0, 2);
    const glm::vec3 places[] = {{-2, 0, -2}, {2, 0, -2}, {2, 0, 2}, {-2, 0, 2}, {-2, 0, -2}, {2, 0, -2}, {2, 4, -2}, {-2, 4, -2}, {1, 1, 1}};
    for (int i = 0; i < 9; ++i) {
        const glm::vec3 bump(noise(i, 0, 0, 33) - 0.5f, noise(i, 1, 0, 33) - 0.5f, noise(i, 2, 0, 33) - 0.5f);
        const glm::vec3 up = i < 4 ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
        d.table.vertices.emplace_back(places[i], 0);
        d.table.vertices.emplace_back(i == 7 ? glm::vec3(0) : normalize3<float>(up + bump), 0);
        d.table.kinds.emplace_back(i % 4, i % 3);
    }
    d.table.vertices[5] = -d.table.vertices[3];
    d.table.corners = {{0, 1, 2, 0}, {0, 2, 3, 0}, {4, 6, 5, 0}, {4, 7, 6, 0}, {8, 8, 8, 0}, {0, 1, 6, 0}};
    for (int m = 0; m < 4; ++m) {
        const float exponents[] = {0, 12, 90, 1e6f};
        d.table.materials.emplace_back(noise(m, 0, 0, 34), noise(m, 1, 0, 34), noise(m, 2, 0, 34), 0);
        d.table.materials.emplace_back(noise(m, 3, 0, 34), noise(m, 4, 0, 34), noise(m, 5, 0, 34), exponents[m]);
    }
    for (int k = 0; k < 18; ++k) {
        glm::vec4 row(noise(k, 0, 0, 35) - 0.5f, noise(k, 1, 0, 35) - 0.5f, noise(k, 2, 0, 35) - 0.5f, 0);
        row[k % 3] += 1.2f;
        d.table.objects.push_back(row);
    }
    d.lights = {make_light(LightType::spot, 16), make_light(LightType::directional, 16), make_light(LightType::point, 16)};
    d.lights[2].radius = 3.5f;  // ends in the room
    d.id = Image<glm::ivec2>(size.x, size.y, glm::ivec2(-1));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const int i = y * size.x + x;
            const glm::vec3 p(d.points.position(x, y));
            const bool floor = 2 * x < size.x;
            // Some see another triangle than they lie on.
            const int first = floor ? (p.x > p.z ? 0 : 1) : (p.x + 2 > p.y ? 2 : 3);
            if (i % 11 != 0) d.id(x, y) = {i % 3, i % 17 == 5 ? 4 : i % 19 == 3 ? (first + 1) % 4 : first};
        }
    return d;
}

// copies: of all vertices and lamps. Of many the items fill more than a row, and the lamps more than a part of the sum.
inline StageData vertices_case(const zbuffer::ZbufferParams& params, const std::string& id, int copies = 1) {
    ZbufferData d = zbuffer_data({4, 4});
    const ZbufferData one = d;
    for (int i = 1; i < copies; ++i) {
        d.table.vertices.insert(d.table.vertices.end(), one.table.vertices.begin(), one.table.vertices.end());
        d.table.kinds.insert(d.table.kinds.end(), one.table.kinds.begin(), one.table.kinds.end());
        if (i < 23) d.lights.insert(d.lights.end(), one.lights.begin(), one.lights.end());
    }
    return named(owned_data(zbuffer::data_of(params, zbuffer::VerticesInputs{&d.table, &d.lights, d.eye})), id);
}
// The light of vertices lies in rows of seven.
inline StageData interpolate_case(glm::ivec2 size, zbuffer::Variant variant, const std::string& id) {
    const ZbufferData d = zbuffer_data(size);
    zbuffer::VertexLight light{noise_image({18, 1}, 36, 0, 3), noise_image({18, 1}, 37, 0, 3)};
    zbuffer::ZbufferParams params;
    params.technique = zbuffer::Technique::cads, params.variant = variant;
    StageData data = owned_data(zbuffer::data_of(params, zbuffer::InterpolateInputs{&d.points.position, &d.id, &d.emission, &d.table, &light, d.eye}));
    for (Array& a : data.inputs.arrays)
        if (a.name == "vertex_diffuse" || a.name == "vertex_specular") {
            const Image4 rows = noise_image({7, 3}, a.name == "vertex_diffuse" ? 36 : 37, 0, 3);
            a.shape = {3, 7, 4}, a.bytes.resize(rows.size() * sizeof(glm::vec4));
            std::memcpy(a.bytes.data(), rows.data(), a.bytes.size());
        }
    const double row = 7;
    set_uniform(parity::find_binding(data.stage, "test"), data, "row", {&row, 1}, "test");
    return named(data, id);
}
inline StageData pixels_case(glm::ivec2 size, const zbuffer::ZbufferParams& params, const std::string& id) {
    const ZbufferData d = zbuffer_data(size);
    const zbuffer::PixelsInputs in{&d.points.position, &d.points.normal, &d.albedo, &d.emission, &d.id, &d.table, &d.lights, d.eye};
    return named(owned_data(zbuffer::data_of(params, in)), id);
}

inline std::vector<StageData> zbuffer_cases(glm::ivec2 size) {
    using namespace zbuffer;
    const ZbufferParams vertex{.technique = Technique::cads}, pixel{.technique = Technique::cads_p};
    const auto with = [](ZbufferParams p, auto change) {
        change(p);
        return p;
    };
    const auto printed = [](ZbufferParams& p) { p.variant = Variant::published; };
    const auto blinn = [](ZbufferParams& p) { p.lobe = Lobe::blinn; };
    const auto saturated = [](ZbufferParams& p) { p.range = Range::saturate; };
    return {
        vertices_case(vertex, "zbuffer.vertices"),
        vertices_case(with(vertex, printed), "zbuffer.vertices.published"),
        vertices_case(with(vertex, blinn), "zbuffer.vertices.blinn"),
        vertices_case(with(vertex, saturated), "zbuffer.vertices.saturated"),
        vertices_case({.technique = Technique::cas}, "zbuffer.vertices.cas"),
        vertices_case({.technique = Technique::c}, "zbuffer.vertices.c"),
        vertices_case(vertex, "zbuffer.vertices.many", 70),  // 630 vertices, 69 lamps
        interpolate_case(size, Variant::corrected, "zbuffer.interpolate"),
        interpolate_case(size, Variant::published, "zbuffer.interpolate.published"),
        pixels_case(size, pixel, "zbuffer.pixels"),
        pixels_case(size, with(pixel, printed), "zbuffer.pixels.published"),
        pixels_case(size, with(pixel, blinn), "zbuffer.pixels.blinn"),
        pixels_case(size, with(pixel, saturated), "zbuffer.pixels.saturated"),
        pixels_case(size, with(pixel, [](ZbufferParams& p) { p.renormalise = false; }), "zbuffer.pixels.short"),
        pixels_case(size, {.technique = Technique::cas_p}, "zbuffer.pixels.cas"),
    };
}

}  // namespace plumb::test
