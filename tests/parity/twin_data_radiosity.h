// Data for the twins of hemicube radiosity.
#pragma once

#include "gi/radiosity/gather.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/lookup.h"
#include "gi/radiosity/reduce.h"
#include "tests/parity/twin_data_parts.h"

namespace plumb::test {

inline glm::vec3 noise_vector(int i, std::uint32_t seed, float low, float high) {
    return glm::vec3(low) + (high - low) * glm::vec3(noise(i, 0, 0, seed), noise(i, 0, 1, seed), noise(i, 0, 2, seed));
}

// Hemicubes among triangles large and small, through eyes and beyond them, fronts and backs; of the first six each has a corner that
// is not there.
inline StageData items_case(int side, int cubes, const std::string& id) {
    const int n = 90;
    Buffer<glm::vec4> vertices, position, normal;
    Buffer<glm::ivec4> triangles;
    for (int i = 0; i < 6; ++i) {
        glm::ivec4 t(0, 15, 31, 0);
        t[i % 3] = i < 3 ? -1 : 3 * n;
        triangles.push_back(t);
    }
    for (int i = 0; i < n; ++i) {
        const glm::vec3 a = noise_vector(i, 181, -2, 2);
        const float size = i % 5 == 0 ? 3.0f : i % 5 == 1 ? 0.02f : 0.6f;
        for (int k = 0; k < 3; ++k) vertices.push_back(glm::vec4(k == 0 ? a : a + noise_vector(3 * i + k, 182, -size, size), 0));
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2, 0});
    }
    for (int i = 0; i < cubes; ++i)
        position.push_back(glm::vec4(noise_vector(i, 183, -0.7f, 0.7f), 0)), normal.push_back(glm::vec4(noise_vector(i, 184, -1, 1), 0));
    const Buffer<glm::vec4> eyes = radiosity::eyes_of(position, normal);
    return named(owned_data(data_of(radiosity::ItemsInputs{&vertices, &triangles, &eyes, side}, 0, cubes)), id);
}

// Rows of several runs of any length, one without any, one of a single number; some go beyond the elements, on either side.
inline StageData gather_rows_case(int count, const std::string& id) {
    const int elements = 211;
    radiosity::RowBlock block;
    for (int i = 0; i < count; ++i) {
        radiosity::DenseRow row;
        row.share.assign(elements + 12, 0.0f);
        for (int j = 0; j < elements + 12 && i % 9 != 4; ++j)
            if (noise(j / 23, i, 0, 185) > 0.4f && (i % 9 != 5 || j == 40)) row.share[std::size_t(j)] = 0.02f * noise(j, i, 1, 186);
        radiosity::pack(row, block);
    }
    for (std::size_t i = 0; i < block.runs.size(); i += 7) block.runs[i].x -= 30;
    block.weights.resize(block.weights.size() + radiosity::row_lanes);
    const Buffer<glm::vec4> own = noise_image({elements, 1}, 187, 0, 2).texels, b = noise_image({elements, 1}, 188, 0, 9).texels;
    radiosity::GatherInputs in{&block, &own, &b};
    in.decoded = true;
    return named(owned_data(data_of(in)), id);
}

// Positions on triangles and off them; some pixels see nothing, some a triangle or an element that is not there.
inline StageData corners_case(glm::ivec2 size, const std::string& id) {
    const int triangles = 17, elements = 29;
    radiosity::TriangleElements t;
    for (int i = 0; i < triangles; ++i) {
        for (int k = 0; k < 3; ++k) t.corners.push_back(glm::vec4(noise_vector(3 * i + k, 189, -2, 2), 0));
        t.of.push_back({(7 * i) % elements, (7 * i + 5) % elements, i == 11 ? elements : (7 * i + 12) % elements, 0});
    }
    t.corners[3 * 5 + 1] = t.corners[3 * 5 + 2] = t.corners[3 * 5];  // without area
    Image4 position(size.x, size.y);
    Image<glm::ivec2> ids(size.x, size.y);
    for (int i = 0; i < size.x * size.y; ++i) {
        const int of = i % 13 == 7 ? -1 : i % 31 == 9 ? triangles : (3 * i) % triangles;
        ids.data()[i] = {0, of};
        const glm::vec4* c = &t.corners[3 * std::size_t(std::clamp(of, 0, triangles - 1))];
        const float a = 1.4f * noise(i, 0, 0, 190) - 0.2f, b = 1.4f * noise(i, 0, 1, 190) - 0.2f;
        position.data()[i] = c[0] + a * (c[1] - c[0]) + b * (c[2] - c[0]);
    }
    const Buffer<glm::vec4> irradiance = noise_image({elements, 1}, 191, 0, 5).texels;
    return named(owned_data(data_of(radiosity::LookupInputs{&position, &ids, &t, &irradiance})), id);
}

// Three hemicubes of noise, some of whose texels are dark; the first pass, and a further one without weights.
inline StageData reduce_case(int side, bool weighted, const glm::ivec2& box, float gain, const std::string& id) {
    const Buffer<glm::vec4> texels = noise_image({side, 9 * side}, 192, -0.4f, 3).texels;
    Buffer<float> weights;
    for (const double w : radiosity::texel_weights(side, radiosity::Weights::exact)) weights.push_back(float(w));
    return named(owned_data(data_of(radiosity::ReduceInputs{&texels, side, 3 * side, weighted ? &weights : nullptr, box, gain})), id);
}

inline std::vector<StageData> radiosity_cases(glm::ivec2 size) {
    return {
        items_case(16, 2, "radiosity.items"),
        items_case(6, 3, "radiosity.items.small"),
        gather_rows_case(67, "radiosity.gather"),
        corners_case(size, "radiosity.lookup"),
        reduce_case(24, true, {4, 2}, 1, "radiosity.reduce"),
        reduce_case(12, false, {3, 4}, 1.0f / 12, "radiosity.reduce.means"),
    };
}

}  // namespace plumb::test
