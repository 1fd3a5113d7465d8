#include "io/scene_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/rotation.h"
#include "io/file.h"
#include "io/gltf_document.h"
#include "io/image_file.h"
#include "io/scene_model.h"

namespace plumb::io {
namespace {

constexpr int max_rsm_size = 16384;

bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

}  // namespace

bool is_layer_name(const std::string& name) {
    return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), is_plain);
}

std::string layer_name(std::string name, const std::vector<Light>& others) {
    for (char& c : name)
        if (!is_plain(c)) c = '_';
    if (name.empty()) name = fmt::format("light{}", others.size());
    name = name.substr(0, 64);
    const auto taken = [&](const std::string& n) {
        return std::any_of(others.begin(), others.end(), [&](const Light& light) { return light.name == n; });
    };
    const std::string stem = name.substr(0, 50);
    for (std::size_t i = 2; taken(name); ++i) name = fmt::format("{}_{}", stem, i);
    return name;
}

glm::dvec3 read_scale(TomlReader& mesh) {
    glm::dvec3 scale(1);
    if (!mesh.has("scale")) return scale;
    if (mesh.holds_array("scale"))
        scale = mesh.vector("scale", scale);
    else
        scale = glm::dvec3(mesh.number("scale", 1));
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::fabs(scale[axis]) >= 1e-30 && std::fabs(scale[axis]) <= 1e30))
            mesh.fail("scale", "expected a size of 1e-30 to 1e30");
    return scale;
}

std::optional<Turn> read_turn(TomlReader& reader, const char* key) {
    const auto n = reader.numbers(key, 4, -1e9, 1e9);
    if (!n) return {};
    const glm::dvec3 axis((*n)[1], (*n)[2], (*n)[3]);
    const double length = std::sqrt(axis.x * axis.x + axis.y * axis.y + axis.z * axis.z);
    if (!(length > 1e-30)) reader.fail(key, "the axis, its last three numbers, has no length");
    return Turn{(*n)[0], axis / length};
}

std::optional<glm::dvec3> read_yaw_pitch(TomlReader& reader) {
    if (!reader.has("yaw_deg") && !reader.has("pitch_deg")) return {};
    const double yaw = reader.number("yaw_deg", 0, -1e6, 1e6), pitch = reader.number("pitch_deg", 0, -90, 90);
    return -glm::dvec3(rotation_deg(glm::dvec3(yaw, pitch, 0))[2]);
}

glm::dmat4 read_transform(TomlReader& mesh) {
    glm::dmat4 m(1);
    if (const auto rows = mesh.numbers("matrix", 16)) {
        for (const char* other : {"translate", "rotate_deg", "turn_deg", "scale"})
            if (mesh.has(other)) mesh.fail(other, "stands beside matrix; expected one or the other");
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column) m[column][row] = (*rows)[std::size_t(4 * row + column)];
        if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1)
            mesh.fail("matrix", "expected 0, 0, 0, 1 in the last row");
        const double determinant = glm::determinant(glm::dmat3(m));
        if (!(std::fabs(determinant) > 0) || !std::isfinite(determinant)) mesh.fail("matrix", "cannot be inverted");
        return m;
    }
    // The object is scaled, rolls about z, pitches about x, turns by yaw about y, and moves.
    m = rotation_deg(mesh.vector("rotate_deg", glm::dvec3(0)));
    if (const auto turn = read_turn(mesh, "turn_deg")) {
        if (mesh.has("rotate_deg")) mesh.fail("turn_deg", "stands beside rotate_deg; expected one or the other");
        m = glm::dmat4(rotation_about(turn->axis, turn->angle_deg));
    }
    const glm::dvec3 scale = read_scale(mesh);
    for (int axis = 0; axis < 3; ++axis) m[axis] *= scale[axis];
    m[3] = glm::dvec4(mesh.vector("translate", glm::dvec3(0)), 1);
    return m;
}

std::optional<glm::dvec2> read_cone(TomlReader& reader) {
    const auto cone = reader.numbers("cone_deg", 2, 0, 89);
    if (!cone) return {};
    const glm::dvec2 degrees((*cone)[0], (*cone)[1]);
    if (!(float(degrees.y) > 0 && degrees.x <= degrees.y))
        reader.fail("cone_deg", "expected 0 <= inner <= outer <= 89, outer above 0");
    return degrees;
}

Light read_light(TomlReader& reader, const std::vector<Light>& others) {
    Light light;
    light.name = reader.word("name", fmt::format("light{}", others.size()));
    if (!is_layer_name(light.name)) reader.fail("name", "expected 1 to 64 letters, digits, _ or -");
    for (const Light& other : others)
        if (other.name == light.name) reader.fail("name", "another light has that name");

    light.type = LightType(reader.choice("type", 0, {"spot", "point", "directional"}));
    light.position = glm::vec3(reader.vector("position", glm::dvec3(0), -1e30, 1e30));
    const glm::dvec3 d = reader.vector("direction", glm::dvec3(0, -1, 0), -1e30, 1e30);
    if (d == glm::dvec3(0)) reader.fail("direction", "has no length");
    light.direction = made_unit(d);
    if (const auto along = read_yaw_pitch(reader)) {
        if (reader.has("direction")) reader.fail("direction", "stands beside yaw_deg or pitch_deg; expected one or the other");
        light.direction = made_unit(*along);
    }
    if (const auto cone = read_cone(reader)) light.cone_inner_deg = float(cone->x), light.cone_outer_deg = float(cone->y);
    light.intensity = glm::vec3(reader.vector("intensity", glm::dvec3(1), 0, 3e38));
    light.radius = float(reader.number("radius", 0, 0, largest_light_radius));
    if (light.radius > 0 && light.type == LightType::directional)
        reader.fail("radius", "a directional light has no distance to end at; expected 0");
    if (light.radius > 0 && light.radius < least_light_radius)
        reader.fail("radius", fmt::format("expected 0, or {} m or more", least_light_radius));
    light.on = reader.flag("on", true);
    light.rsm_size = reader.integer("rsm_size", 512, 1, max_rsm_size);
    return light;
}

namespace {

// Metalness or roughness make a material one of microfacets, a lobe or a mirror one of those; one material has not both.
void read_microfacets(TomlReader& reader, Material& m) {
    const bool facets = reader.has("metalness") || reader.has("roughness");
    const bool lobes = reader.has("specular") || reader.has("mirror");
    m.metalness = float(reader.number("metalness", m.metalness, 0, 1));
    m.roughness = float(reader.number("roughness", m.roughness, 0, 1));
    m.microfacet = reader.flag("microfacet", facets || (m.microfacet && !lobes));
    if (!m.microfacet || (m.specular == glm::vec3(0) && m.mirror == glm::vec3(0))) return;
    reader.fail(reader.has("metalness") ? "metalness" : reader.has("roughness") ? "roughness" : "microfacet",
                "stands beside specular or mirror, which the material has; expected one or the other, or those 0");
}

}  // namespace

void read_surface(TomlReader& reader, Material& m) {
    const auto share = [&](const char* key, glm::vec3& value) {
        value = glm::vec3(reader.colour(key, glm::dvec3(value), 0, 1));
    };
    share("reflectance", m.reflectance), share("specular", m.specular), share("mirror", m.mirror);
    m.exponent = float(reader.number("exponent", m.exponent, 0, max_exponent));
    m.emission = glm::vec3(reader.colour("emission", glm::dvec3(m.emission), 0, 3e38));
    m.alpha_cutoff = float(reader.number("alpha_cutoff", m.alpha_cutoff, 0, 1));
    m.normal_scale = float(reader.number("normal_scale", m.normal_scale, -1e30, 1e30));
    read_microfacets(reader, m);
    const std::string excess = excess_of(m);
    const char* const given = reader.has("mirror") ? "mirror" : reader.has("specular") ? "specular" : "reflectance";
    if (!excess.empty()) reader.fail(given, excess);
}

void read_environment(TomlReader& reader, const std::string& path, Scene& scene) {
    Environment& environment = scene.environment;
    if (reader.has("file")) {
        const std::string file = reader.word("file", "");
        try {
            environment.map = read_radiance_map(beside(path, file));
        } catch (const InputError& e) {
            reader.fail("file", e.what());
        }
        environment.radiance = glm::vec3(1);
        scene.notes.push_back(fmt::format(
            "the sky \"{}\" is what path tracing sees; rasterised pictures show `radiance` alone behind their surfaces",
            printable(file)));
        if (environment.map.width != 2 * environment.map.height)
            scene.notes.push_back(fmt::format("the sky \"{}\" has {} x {} texels, not 2 : 1: it is stretched",
                                              printable(file), environment.map.width, environment.map.height));
    }
    if (reader.has("filter") && environment.map.empty()) reader.fail("filter", "stands without a file");
    environment.filter = Filter(reader.choice("filter", int(Filter::nearest), {"bilinear", "nearest"}));
    if (!environment.map.empty())
        scene.notes.push_back(fmt::format(
            "the sky's {} x {} texels are {}", environment.map.width, environment.map.height,
            environment.filter == Filter::bilinear
                ? "interpolated"
                : "patches of constant radiance; [environment] filter = \"bilinear\" interpolates"));
    environment.radiance = glm::vec3(reader.colour("radiance", glm::dvec3(environment.radiance), 0, 3e38));
    for (const glm::vec4& texel : environment.map.texels)
        for (int c = 0; c < 3; ++c)
            if (!std::isfinite(texel[c] * environment.radiance[c]))
                reader.fail("radiance", fmt::format("times {} of the map is not finite", texel[c]));
}

}  // namespace plumb::io
