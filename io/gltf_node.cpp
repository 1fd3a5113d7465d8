// glTF's nodes, cameras and lights. glTF 2.0, 3.5 and 3.10; KHR_lights_punctual.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "io/file.h"
#include "io/gltf_document.h"

namespace plumb::io {
namespace {

constexpr double lumen_per_watt = 683;  // at 555 nm: the photometric base of SI
constexpr double max_coordinate = 1e30;

glm::dmat4 rotation_of(const JsonValue& json) {
    const std::vector<double> q = json.numbers({0, 0, 0, 1}, -2, 2);
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(square > 0.99 && square < 1.01)) json.fail("expected a quaternion of length 1");
    // Exact where the quaternion is: 2 / |q|^2 is 2 for the identity.
    const double s = 2 / square, x = q[0], y = q[1], z = q[2], w = q[3];
    glm::dmat4 m(1);
    m[0] = {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w), 0};
    m[1] = {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w), 0};
    m[2] = {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y), 0};
    return m;
}

glm::dmat4 transform_of(const JsonValue& node) {
    const JsonValue matrix = node["matrix"];
    const char* const parts[] = {"translation", "rotation", "scale"};
    if (matrix) {
        for (const char* part : parts)
            if (node[part]) node[part].fail("stands beside matrix; expected one or the other");
        const std::vector<double> columns = matrix.numbers(std::vector<double>(16), -max_coordinate, max_coordinate);
        glm::dmat4 m;
        for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = columns[std::size_t(i)];
        if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1)
            matrix.fail("expected 0, 0, 0, 1 in the last row");
        return m;
    }
    glm::dmat4 m = node["rotation"] ? rotation_of(node["rotation"]) : glm::dmat4(1);
    const std::vector<double> s = node["scale"].numbers({1, 1, 1}, -max_coordinate, max_coordinate);
    const std::vector<double> t = node["translation"].numbers({0, 0, 0}, -max_coordinate, max_coordinate);
    for (int axis = 0; axis < 3; ++axis) m[axis] *= s[std::size_t(axis)];
    m[3] = {t[0], t[1], t[2], 1};
    return m;
}

// The parent of each node, -1 where it has none. No node has two, none is its own ancestor.
std::vector<std::int64_t> read_parents(const JsonValue& nodes) {
    std::vector<std::int64_t> parent(nodes.size(), -1);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const JsonValue children = nodes[n]["children"];
        for (std::size_t i = 0; i < children.size(); ++i) {
            const std::size_t child = *children[i].index(nodes.size(), "nodes");
            if (parent[child] >= 0) children[i].fail(fmt::format("node {} is its parent already", parent[child]));
            parent[child] = std::int64_t(n);
        }
    }
    // Each walk towards the root stops where an earlier one came through.
    std::vector<std::size_t> seen(nodes.size(), 0);
    for (std::size_t n = 0; n < nodes.size(); ++n)
        for (std::int64_t at = std::int64_t(n); at >= 0 && seen[std::size_t(at)] == 0; at = parent[std::size_t(at)]) {
            seen[std::size_t(at)] = n + 1;
            if (parent[std::size_t(at)] >= 0 && seen[std::size_t(parent[std::size_t(at)])] == n + 1)
                nodes[std::size_t(at)].fail("is its own ancestor");
        }
    return parent;
}

std::vector<std::size_t> read_roots(GltfDocument& document, const std::vector<std::int64_t>& parent) {
    std::vector<std::size_t> roots;
    const JsonValue scenes = document.list("scenes");
    const std::optional<std::size_t> chosen = document.list("scene").index(scenes.size(), "scenes");
    if (scenes.size() == 0) {
        for (std::size_t n = 0; n < parent.size(); ++n)
            if (parent[n] < 0) roots.push_back(n);
        return roots;
    }
    if (scenes.size() > 1)
        document.note(fmt::format("scene {} of {} is read", chosen.value_or(0), scenes.size()));
    const JsonValue nodes = scenes[chosen.value_or(0)]["nodes"];
    std::vector<bool> listed(parent.size(), false);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const std::size_t node = *nodes[i].index(parent.size(), "nodes");
        if (parent[node] >= 0) nodes[i].fail(fmt::format("expected a root; node {} is its parent", parent[node]));
        if (listed[node]) nodes[i].fail("is listed twice");
        listed[node] = true;
        roots.push_back(node);
    }
    return roots;
}

}  // namespace

glm::vec3 made_unit(const glm::dvec3& v) {
    const double square = v.x * v.x + v.y * v.y + v.z * v.z;
    if (std::fabs(square - 1) < 1e-6) return glm::vec3(v);
    const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    if (!(largest > 0)) return glm::vec3(0);
    const glm::dvec3 s = v / largest;
    return glm::vec3(s / std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z));
}

std::vector<GltfNode> read_gltf_nodes(GltfDocument& document) {
    const JsonValue nodes = document.list("nodes");
    const std::vector<std::int64_t> parent = read_parents(nodes);
    const std::vector<std::size_t> roots = read_roots(document, parent);

    // Depth first, children in order, without recursion: a chain of nodes may be as long as the file.
    std::vector<GltfNode> result, open;
    for (std::size_t i = roots.size(); i-- > 0;) open.push_back({roots[i], transform_of(nodes[roots[i]])});
    while (!open.empty()) {
        const GltfNode node = open.back();
        open.pop_back();
        result.push_back(node);
        const JsonValue children = nodes[node.index]["children"];
        for (std::size_t i = children.size(); i-- > 0;) {
            const std::size_t child = std::size_t(children[i].integer(0, nodes.size()));
            open.push_back({child, node.to_world * transform_of(nodes[child])});
        }
    }
    return result;
}

Camera read_gltf_camera(const JsonValue& json, const glm::dmat4& to_world) {
    const JsonValue perspective = json["perspective"].required();
    Camera camera;
    camera.position = glm::dvec3(to_world[3]);
    camera.look_at = camera.position - glm::dvec3(to_world[2]);
    camera.up = glm::dvec3(to_world[1]);
    camera.fov_y_deg = perspective["yfov"].number(0, 4) * (180 / host::pi);
    camera.near = perspective["znear"].number(0, max_coordinate);
    camera.far = perspective["zfar"] ? perspective["zfar"].number(0, max_coordinate) : unbounded;
    try {
        validate(camera);
    } catch (const InputError& e) {
        perspective.fail(e.what());
    }
    return camera;
}

Light read_gltf_light(const JsonValue& json, const glm::dmat4& to_world, const GltfOptions& options,
                      GltfDocument& document) {
    Light light;
    light.name = json["name"].text("");
    const std::string type = json["type"].text();
    if (type == "directional")
        light.type = LightType::directional;
    else if (type == "point")
        light.type = LightType::point;
    else if (type == "spot")
        light.type = LightType::spot;
    else
        json["type"].fail("expected directional, point or spot");

    light.position = glm::vec3(glm::dvec3(to_world[3]));
    if (light.type != LightType::point) light.direction = made_unit(-glm::dvec3(to_world[2]));
    const std::vector<double> colour = json["color"].numbers({1, 1, 1}, 0, unbounded_number);
    const double intensity = json["intensity"].number(0, unbounded_number, 1);
    const double unit = options.photometric_as_is ? 1 : lumen_per_watt;
    for (int c = 0; c < 3; ++c) light.intensity[c] = float(colour[std::size_t(c)] * intensity / unit);
    if (!std::isfinite(light.intensity.x + light.intensity.y + light.intensity.z))
        json.fail("its intensity is not a finite number of 32 bits");
    if (json["range"])
        document.note("the range of a light is not read: its light falls off with the square of the distance alone");

    if (light.type == LightType::spot) {
        const double degrees = 180 / host::pi, right_angle = host::pi / 2;
        const JsonValue spot = json["spot"].required();
        double outer = spot["outerConeAngle"].number(0, right_angle * (1 + 1e-7), host::pi / 4);
        const double inner = spot["innerConeAngle"].number(0, right_angle, 0);
        if (!(outer > 0)) spot["outerConeAngle"].fail("expected an angle above 0");
        if (inner > outer) spot["innerConeAngle"].fail("is larger than outerConeAngle");
        if (outer * degrees > 89) document.note("a spot's cone is cut to a half angle of 89 degrees");
        light.cone_outer_deg = std::min(float(outer * degrees), 89.0f);
        light.cone_inner_deg = std::min(float(inner * degrees), light.cone_outer_deg);
    }
    const JsonValue own = json.own();
    light.on = own["on"].flag(true);
    light.radius = float(own["radius"].number(0, largest_light_radius, 0));
    if (light.radius > 0 && (light.radius < least_light_radius || light.type == LightType::directional))
        own["radius"].fail(fmt::format("expected 0, or of a spot or point light {} m or more", least_light_radius));
    light.rsm_size = int(own["rsm_size"].integer(1, 16384, 512));
    return light;
}

}  // namespace plumb::io
