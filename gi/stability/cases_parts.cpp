#include "gi/stability/cases_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/tangents.h"

namespace plumb::stability {

namespace {

glm::vec3 face_normal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return length > 0 ? glm::vec3(n / length) : glm::vec3(0);
}

glm::dmat4 translation(const glm::dvec3& by) {
    glm::dmat4 m(1);
    m[3] = glm::dvec4(by, 1);
    return m;
}

// Four corners on the floor, turned by the angle whose cosine and sine are 0.8 and 0.6, and a lid.
Mesh box(const glm::dvec3& at, double half, double height, int material) {
    std::vector<glm::vec3> corners;
    auto add = [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, glm::dvec3 d) {
        for (const glm::dvec3& p : {a, b, c, a, c, d})
            corners.emplace_back(at + glm::dvec3(half * (0.8 * p.x + 0.6 * p.z), height * p.y,
                                                 half * (0.8 * p.z - 0.6 * p.x)));
    };
    add({-1, 1, 1}, {1, 1, 1}, {1, 1, -1}, {-1, 1, -1});
    add({-1, 0, 1}, {1, 0, 1}, {1, 1, 1}, {-1, 1, 1});
    add({1, 0, 1}, {1, 0, -1}, {1, 1, -1}, {1, 1, 1});
    add({1, 0, -1}, {-1, 0, -1}, {-1, 1, -1}, {1, 1, -1});
    add({-1, 0, -1}, {-1, 0, 1}, {-1, 1, 1}, {-1, 1, -1});
    return triangles("box", corners, material);
}

// A picture of 4 x 4 texels.
Texture texture(const std::string& name, bool srgb, bool mips, std::uint32_t (*texel)(int x, int y)) {
    Texture t;
    t.name = name, t.srgb = srgb, t.mips = mips;
    t.texels = Image<std::uint32_t>(4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) t.texels(x, y) = texel(x, y);
    return t;
}
std::uint32_t tile(int x, int y) { return (x + y) % 2 ? 0xffa0b0c0u : 0xff605040u; }
// Normals that lean towards +x and -x, +y and -y by about 0.2.
std::uint32_t bump(int x, int y) {
    return 0xfc000000u | 0xfc0000u | std::uint32_t(y % 2 ? 152 : 103) << 8 | std::uint32_t(x % 2 ? 152 : 103);
}

Light light(const std::string& name, LightType type, const glm::vec3& position, const glm::vec3& direction,
            const glm::vec3& intensity, int rsm_size) {
    Light l;
    l.name = name, l.type = type, l.position = position, l.direction = direction, l.intensity = intensity;
    l.rsm_size = rsm_size;
    return l;
}

Material material(const std::string& name, const glm::vec3& reflectance) {
    Material m;
    m.name = name, m.reflectance = reflectance;
    return m;
}

}  // namespace

Mesh triangles(const std::string& name, const std::vector<glm::vec3>& corners, int material) {
    static constexpr float uv[3][2] = {{0, 0}, {1, 0}, {1, 1}};
    Mesh mesh;
    mesh.name = name;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
        const glm::vec3 n = face_normal(corners[i], corners[i + 1], corners[i + 2]);
        for (std::size_t k = 0; k < 3; ++k) mesh.vertices.push_back({corners[i + k], uv[k][0], n, uv[k][1]});
        mesh.triangles.emplace_back(i, i + 1, i + 2);
        mesh.material.push_back(material);
    }
    return mesh;
}

Mesh quad(const std::string& name, const std::array<glm::vec3, 4>& c, int material) {
    Mesh mesh;
    mesh.name = name;
    const glm::vec3 n = face_normal(c[0], c[1], c[2]);
    mesh.vertices = {{c[0], 0, n, 1}, {c[1], 1, n, 1}, {c[2], 1, n, 0}, {c[3], 0, n, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = {material, material};
    return mesh;
}

Mesh plain(double half, double y, int material) {
    const float h = float(half), at = float(y);
    return quad("plain", {{{-h, at, h}, {h, at, h}, {h, at, -h}, {-h, at, -h}}}, material);
}

Scene room() {
    Scene s;
    s.name = "room";
    s.frame_size = {48, 32};
    s.materials = {material("tiles", {0.9f, 0.9f, 0.9f}), material("bumps", {0.7f, 0.7f, 0.6f}),
                   material("red", {0.6f, 0.1f, 0.05f}), material("green", {0.1f, 0.5f, 0.1f}),
                   material("glow", {0.5f, 0.5f, 0.7f})};
    s.textures = {texture("tiles", true, true, tile), texture("bumps", false, false, bump)};
    s.materials[tiles].texture = 0;
    s.materials[bumps].normal_texture = 1;
    s.materials[glow].emission = {0.2f, 0.3f, 0.1f};
    s.meshes = {quad("floor", {{{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}}}, tiles),
                quad("back", {{{-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}}}, bumps),
                quad("left", {{{-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}}}, red),
                quad("right", {{{1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1}}}, green),
                box({0.25, 0, -0.125}, 0.25, 0.75, glow)};
    generate_tangents(s.meshes[back_mesh]);
    s.lights = {light("key", LightType::spot, {0.25f, 1.875f, 0.5f}, {-0.25f, -1, -0.375f}, {4, 3, 2}, 24),
                light("lamp", LightType::point, {-0.5f, 1.25f, 0.25f}, {0, -1, 0}, {0.5f, 0.75f, 1}, 8),
                light("sun", LightType::directional, {0, 0, 0}, {0.375f, -1, -0.625f}, {2, 2, 1.5f}, 16)};
    s.camera.position = {0, 1, 3.25}, s.camera.look_at = {0, 0.75, 0};
    s.camera.near = 0.125, s.camera.far = 16;
    return s;
}

void scale(Scene& scene, double by) {
    const glm::dmat4 m(glm::dvec4(by, 0, 0, 0), glm::dvec4(0, by, 0, 0), glm::dvec4(0, 0, by, 0),
                       glm::dvec4(0, 0, 0, 1));
    for (Mesh& mesh : scene.meshes) mesh.transform = m * mesh.transform;
    for (Light& l : scene.lights) {
        l.position = glm::vec3(glm::dvec3(l.position) * by);
        l.radius = float(l.radius * by);
        if (l.type != LightType::directional && l.radius == 0) l.intensity = glm::vec3(glm::dvec3(l.intensity) * (by * by));
    }
    Camera& c = scene.camera;
    c.position *= by, c.look_at *= by, c.near *= by, c.far *= by;
}

void move(Scene& scene, const glm::dvec3& by) {
    for (Mesh& mesh : scene.meshes) mesh.transform = translation(by) * mesh.transform;
    for (Light& l : scene.lights) l.position = glm::vec3(glm::dvec3(l.position) + by);
    scene.camera.position += by, scene.camera.look_at += by;
}

std::string power_text(double power) {
    std::string text = fmt::format("{:.0e}", power);  // "1e+08"
    text.erase(std::remove(text.begin(), text.end(), '+'), text.end());
    const std::size_t digit = text.find('e') + (text.find('-') == text.npos ? 1 : 2);
    if (text[digit] == '0') text.erase(digit, 1);
    return text;
}

std::span<float> input_floats(StageData& data, const std::string& name) {
    for (Array& a : data.inputs.arrays)
        if (a.name == name && a.dtype == DType::f32)
            return {reinterpret_cast<float*>(a.bytes.data()), a.bytes.size() / sizeof(float)};
    return {};
}

}  // namespace plumb::stability
