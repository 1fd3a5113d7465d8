// Inputs that no rasterizer would hand over: each edit names the inputs that it knows.
#include <cmath>
#include <cstring>

#include "core/hash.h"
#include "gi/stability/cases_parts.h"

namespace plumb::stability {

namespace {

glm::vec3 at(std::span<const float> texels, std::size_t i) {
    return {texels[4 * i], texels[4 * i + 1], texels[4 * i + 2]};
}
void put(std::span<float> texels, std::size_t i, const glm::vec3& v) {
    texels[4 * i] = v.x, texels[4 * i + 1] = v.y, texels[4 * i + 2] = v.z;
}
std::size_t hashed(std::size_t i, std::size_t n) { return std::size_t(std::uint32_t(pcg(std::int32_t(i)))) % n; }

// The point that the dispatch measures distances from, by pixel: a texel of its map, or one of its lights.
std::span<float> anchors(StageData& d) {
    if (d.stage == "direct") return input_floats(d, "lights");
    return input_floats(d, "rsm_position");
}
// In the buffer of lights three vec4 stand for a light, of which the first is its position.
std::size_t anchor_step(const StageData& d) { return d.stage == "direct" ? 3 : 1; }

// Every pixel lies exactly at a texel of the map, or at a light.
bool at_distance_0(StageData& d) {
    const std::span<float> position = input_floats(d, "position"), anchor = anchors(d);
    const std::size_t step = anchor_step(d), n = anchor.size() / 4 / step;
    if (position.empty() || anchor.empty()) return false;
    for (std::size_t i = 0; i < position.size() / 4; ++i) put(position, i, at(anchor, step * hashed(i, n)));
    return true;
}

// Every texel and every light lies at the origin, every pixel so far behind it along its own normal, so that all of
// them are in front of the surface; every other texel is turned to face the first ones.
bool at_distance(StageData& d, float distance) {
    const std::span<float> position = input_floats(d, "position"), normal = input_floats(d, "normal"),
                           anchor = anchors(d), facing = input_floats(d, "rsm_normal");
    if (position.empty() || anchor.empty()) return false;
    const std::size_t step = anchor_step(d);
    for (std::size_t i = 0; i < anchor.size() / 4; i += step) put(anchor, i, glm::vec3(0));
    for (std::size_t i = 1; i < facing.size() / 4; i += 2) put(facing, i, -at(facing, i));
    for (std::size_t i = 0; i < position.size() / 4; ++i) put(position, i, at(normal, i) * -distance);
    return true;
}

// Scales the triangles of a raster stage about the origin; they are seen where they were before.
bool vertices_times(StageData& d, float factor) {
    const std::span<float> vertices = input_floats(d, "vertices");
    for (std::size_t v = 0; v < vertices.size() / 8; ++v)
        for (std::size_t c = 0; c < 3; ++c) vertices[8 * v + c] *= factor;
    return !vertices.empty();
}

// A depth map whose texels lie at that depth, every other one at none; points as deep.
bool depths(StageData& d, float depth) {
    const std::span<float> map = input_floats(d, "map_position"), position = input_floats(d, "position");
    if (map.empty()) return false;
    for (std::size_t i = 0; i < map.size() / 4; ++i) map[4 * i + 3] = i % 2 ? depth : 0;
    for (std::size_t i = 0; i < position.size() / 4; ++i) put(position, i, at(position, i) * depth);
    return true;
}

// The smallest float above 0 and those above it, by a hash: all are denormal, and keep the sign that was there.
float denormal(float v, std::size_t i) {
    const std::uint32_t bits = 1 + std::uint32_t(pcg(std::int32_t(i))) % 0x7fffff;
    float tiny;
    std::memcpy(&tiny, &bits, sizeof tiny);
    return std::copysign(tiny, v);
}

// Components [first, end) of rows of `row`: those of every other row become denormal.
struct Part {
    const char* input;
    std::size_t row, first, end;
};
constexpr Part positions[] = {{"position", 4, 0, 3}, {"rsm_position", 4, 0, 3}, {"map_position", 4, 0, 4},
                              {"vertices", 8, 0, 3}, {"lights", 12, 0, 3}};
constexpr Part normals[] = {{"normal", 4, 0, 3}, {"rsm_normal", 4, 0, 3}, {"map_normal", 4, 0, 3}, {"vertices", 8, 4, 7},
                            {"tangents", 4, 0, 3}, {"lights", 12, 4, 7}};
constexpr Part amounts[] = {{"rsm_flux", 4, 0, 3},   {"albedo", 4, 0, 3},     {"emission", 4, 0, 3},
                            {"direct", 4, 0, 3},     {"indirect", 4, 0, 3},   {"radiance", 4, 0, 3},
                            {"materials", 16, 0, 3}, {"materials", 16, 4, 7}, {"lights", 12, 8, 11},
                            {"visibility", 1, 0, 1}, {"weights", 1, 0, 1},    {"vertices", 8, 3, 4},
                            {"vertices", 8, 7, 8}};

bool make_denormal(StageData& d, std::span<const Part> parts) {
    bool any = false;
    for (const Part& part : parts) {
        const std::span<float> values = input_floats(d, part.input);
        for (std::size_t r = 0; r < values.size() / part.row; r += 2)
            for (std::size_t c = part.first; c < part.end; ++c) {
                float& v = values[r * part.row + c];
                v = denormal(v, r * part.row + c);
            }
        any = any || !values.empty();
    }
    return any;
}

Case edited(const std::string& name, const std::string& group, const std::string& meaning,
            const std::function<bool(StageData&)>& edit) {
    return {name, group, meaning, room, nullptr, edit};
}

}  // namespace

std::vector<Case> edited_cases() {
    return {
        edited("distance 0", "distance", "each point lies at a texel or a light, exactly; triangles are points",
               [](StageData& d) { return at_distance_0(d) || vertices_times(d, 0) || depths(d, 0); }),
        edited("distance 1e-20", "distance", "texels and lights 1e-20 m from every point; triangles as small",
               [](StageData& d) { return at_distance(d, 1e-20f) || vertices_times(d, 1e-20f) || depths(d, 1e-20f); }),
        edited("distance 1e20", "distance", "texels and lights 1e20 m from every point; triangles as large",
               [](StageData& d) { return at_distance(d, 1e20f) || vertices_times(d, 1e20f) || depths(d, 1e20f); }),
        edited("denormal positions", "denormal", "every other position in every input",
               [](StageData& d) { return make_denormal(d, positions); }),
        edited("denormal normals", "denormal", "every other normal, tangent and direction in every input",
               [](StageData& d) { return make_denormal(d, normals); }),
        edited("denormal amounts", "denormal", "every other flux, reflectance, irradiance, weight in every input",
               [](StageData& d) { return make_denormal(d, amounts); }),
        edited("denormals everywhere", "denormal", "all of the above at once",
               [](StageData& d) {
                   const bool a = make_denormal(d, positions), b = make_denormal(d, normals);
                   return make_denormal(d, amounts) || a || b;
               }),
    };
}

}  // namespace plumb::stability
