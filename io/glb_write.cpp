#include "io/glb_write.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/host_math.h"
#include "io/file.h"
#include "io/glb_parts.h"
#include "io/image_file.h"

namespace plumb::io {
namespace {

class GlbWriter : GlbParts {
  public:
    GlbWriter(const std::string& path, const Scene& scene) : GlbParts(path), scene_(scene) {}

    void write() {
        for (const Material& material : scene_.materials) json_["materials"].push_back(material_json(material));
        for (const Texture& texture : scene_.textures) add_texture(texture);
        for (const Mesh& mesh : scene_.meshes)
            if (!mesh.triangles.empty()) add_mesh(mesh);
        add_camera();
        add_lights();
        write_chunks();
    }

  private:
    static Json columns(const glm::dmat4& m) {
        Json out = Json::array();
        for (int i = 0; i < 16; ++i) out.push_back(m[i / 4][i % 4]);
        return out;
    }

    Json attributes_json(const Mesh& mesh) {
        const std::size_t n = mesh.vertices.size();
        std::vector<glm::vec3> positions(n), normals(n);
        std::vector<glm::vec2> coordinates(n);
        for (std::size_t i = 0; i < n; ++i) {
            const Vertex& v = mesh.vertices[i];
            if (!std::isfinite(v.position.x + v.position.y + v.position.z) || !std::isfinite(v.u + v.v) ||
                !std::isfinite(v.normal.x + v.normal.y + v.normal.z))
                fail(fmt::format("vertex {} of mesh \"{}\" is not finite", i, printable(mesh.name)));
            positions[i] = v.position, normals[i] = v.normal, coordinates[i] = {v.u, v.v};
        }
        Json out;
        out["POSITION"] = add_positions(positions);
        out["NORMAL"] = add_accessor(normals, "VEC3", f32, vertices);
        out["TEXCOORD_0"] = add_accessor(coordinates, "VEC2", f32, vertices);
        if (mesh.tangents.size() == n) out["TANGENT"] = add_accessor(mesh.tangents, "VEC4", f32, vertices);
        return out;
    }

    // One primitive a material, all on the same vertices. Where materials take turns, an accessor of numbers says where
    // in the mesh each triangle stands: programs that do not know it draw the same surface.
    void add_mesh(const Mesh& mesh) {
        const Json attributes = attributes_json(mesh);
        std::vector<std::int32_t> order;  // of first appearance
        std::vector<int> rank(scene_.materials.size(), -1);
        bool in_runs = true;
        for (std::size_t t = 0; t < mesh.material.size(); ++t) {
            int& r = rank[std::size_t(mesh.material[t])];
            if (r < 0) {
                r = int(order.size());
                order.push_back(mesh.material[t]);
            } else if (mesh.material[t] != mesh.material[t - 1]) {
                in_runs = false;
            }
        }
        std::vector<std::vector<glm::uvec3>> triangles(order.size());
        std::vector<std::vector<std::uint32_t>> places(order.size());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const std::size_t r = std::size_t(rank[std::size_t(mesh.material[t])]);
            triangles[r].push_back(mesh.triangles[t]);
            if (!in_runs) places[r].push_back(std::uint32_t(t));
        }
        Json primitives = Json::array();
        for (std::size_t r = 0; r < order.size(); ++r) {
            const std::size_t accessor = add_accessor(triangles[r], "SCALAR", u32, indices);
            json_["accessors"].back()["count"] = 3 * triangles[r].size();
            Json primitive = {{"attributes", attributes}, {"indices", accessor}, {"material", order[r]}};
            if (!in_runs)
                primitive["extras"]["plumb"]["order"] = add_accessor(places[r], "SCALAR", u32, no_target);
            primitives.push_back(std::move(primitive));
        }
        json_["meshes"].push_back({{"name", mesh.name}, {"primitives", std::move(primitives)}});

        Json node = {{"name", mesh.name}, {"mesh", json_["meshes"].size() - 1}};
        if (mesh.transform != glm::dmat4(1)) node["matrix"] = columns(mesh.transform);
        if (mesh.dynamic) node["extras"]["plumb"]["dynamic"] = true;
        if (mesh.share != 1) node["extras"]["plumb"]["share"] = mesh.share;
        add_node(std::move(node));
    }

    Json material_json(const Material& m) {
        Json out = {{"name", m.name}};
        Json base = numbers(m.reflectance);
        base.push_back(double(m.alpha));
        Json& pbr = out["pbrMetallicRoughness"] = {{"baseColorFactor", base}, {"metallicFactor", 0.0}};
        if (m.texture >= 0) pbr["baseColorTexture"] = {{"index", m.texture}};
        if (m.microfacet) {
            pbr["metallicFactor"] = double(m.metalness), pbr["roughnessFactor"] = double(m.roughness);
            if (m.surface_texture >= 0) pbr["metallicRoughnessTexture"] = {{"index", m.surface_texture}};
            out["extras"]["plumb"]["microfacet"] = true;
        }

        // Exitance over pi is a radiance. Read back as factor * (pi * strength) in double, it rounds to the same floats.
        const double largest = double(std::max({m.emission.x, m.emission.y, m.emission.z})) / host::pi;
        const double strength = std::max(1.0, largest);
        if (largest > 0) {
            Json factor = Json::array();
            for (int c = 0; c < 3; ++c) factor.push_back(double(m.emission[c]) / host::pi / strength);
            out["emissiveFactor"] = factor;
        }
        if (strength > 1) {
            use_extension("KHR_materials_emissive_strength");
            out["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = strength;
        }
        if (m.emission_texture >= 0) out["emissiveTexture"] = {{"index", m.emission_texture}};
        if (m.normal_texture >= 0)
            out["normalTexture"] = {{"index", m.normal_texture}, {"scale", double(m.normal_scale)}};
        if (m.alpha_cutoff > 0) out["alphaMode"] = "MASK", out["alphaCutoff"] = double(m.alpha_cutoff);
        out["doubleSided"] = true;
        if (m.specular != glm::vec3(0)) out["extras"]["plumb"]["specular"] = numbers(m.specular);
        if (m.exponent != Material{}.exponent) out["extras"]["plumb"]["exponent"] = double(m.exponent);
        if (m.mirror != glm::vec3(0)) out["extras"]["plumb"]["mirror"] = numbers(m.mirror);
        return out;
    }

    void add_texture(const Texture& texture) {
        const std::vector<unsigned char> png = encode_png(path_ + ": " + texture.name, texture.texels);
        const std::size_t view = add_view(std::string(png.begin(), png.end()), no_target);
        json_["images"].push_back({{"name", texture.name}, {"mimeType", "image/png"}, {"bufferView", view}});
        constexpr std::array<int, 3> wrap = {10497, 33648, 33071};
        json_["samplers"].push_back({{"magFilter", texture.filter == Filter::nearest ? 9728 : 9729},
                                     {"wrapS", wrap[std::size_t(texture.wrap_u)]},
                                     {"wrapT", wrap[std::size_t(texture.wrap_v)]}});
        const std::size_t number = json_["images"].size() - 1;
        Json out = {{"name", texture.name}, {"source", number}, {"sampler", number}};
        out["extras"]["plumb"] = {{"srgb", texture.srgb}, {"mips", texture.mips}};
        json_["textures"].push_back(std::move(out));
    }

    // glTF's cameras and lights look along -z of their node.
    static glm::dmat4 looking(const glm::dvec3& position, const glm::dvec3& forward, const glm::dvec3& up) {
        const CameraAxes a = axes(forward, up);
        glm::dmat4 m(1);
        m[0] = glm::dvec4(a.right, 0), m[1] = glm::dvec4(a.up, 0);
        m[2] = glm::dvec4(-forward, 0), m[3] = glm::dvec4(position, 1);
        return m;
    }

    void add_camera() {
        const Camera& c = scene_.camera;
        Json perspective = {{"yfov", c.fov_y_deg * (host::pi / 180)}, {"znear", c.near}};
        if (std::isfinite(c.far)) perspective["zfar"] = c.far;
        json_["cameras"].push_back({{"type", "perspective"}, {"perspective", perspective}});
        const glm::dmat4 place = looking(c.position, axes(c).forward, c.up);
        add_node({{"name", "camera"}, {"camera", 0}, {"matrix", columns(place)}});
    }

    void add_lights() {
        Json lights = Json::array();
        for (const Light& light : scene_.lights) {
            constexpr std::array<const char*, 3> types = {"spot", "point", "directional"};
            // Photometric: candela and lux. Read back as colour * intensity / 683 in double, it rounds to the same.
            const double largest = double(std::max({light.intensity.x, light.intensity.y, light.intensity.z}));
            Json colour = Json::array();
            for (int c = 0; c < 3; ++c) colour.push_back(largest > 0 ? double(light.intensity[c]) / largest : 1.0);
            Json out = {{"type", types[std::size_t(light.type)]}, {"color", colour}, {"intensity", largest * 683}};
            if (light.type == LightType::spot) {
                // The inner angle has to be smaller: by one step of a double, which no float sees.
                const double outer = double(light.cone_outer_deg) * (host::pi / 180);
                const double inner = double(light.cone_inner_deg) * (host::pi / 180);
                out["spot"] = {{"innerConeAngle", std::min(inner, std::nextafter(outer, 0.0))},
                               {"outerConeAngle", outer}};
            }
            out["extras"]["plumb"] = {{"on", light.on}, {"rsm_size", light.rsm_size}};
            if (light.radius > 0) out["extras"]["plumb"]["radius"] = light.radius;
            const glm::dvec3 d(light.direction);
            const glm::dvec3 up = std::fabs(d.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
            Json node = {{"name", light.name}};
            node["matrix"] = columns(looking(glm::dvec3(light.position), d, up));
            node["extensions"]["KHR_lights_punctual"]["light"] = lights.size();
            lights.push_back(std::move(out));
            add_node(std::move(node));
        }
        if (lights.empty()) return;
        use_extension("KHR_lights_punctual");
        json_["extensions"]["KHR_lights_punctual"]["lights"] = lights;
    }

    const Scene& scene_;
};

}  // namespace

void write_glb(const std::string& path, const Scene& scene) { GlbWriter(path, scene).write(); }

}  // namespace plumb::io
