// glTF's meshes. glTF 2.0, 3.7.2.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/host_math.h"
#include "io/gltf_document.h"

namespace plumb::io {
namespace {

enum Mode : int { triangles = 4, strip = 5, fan = 6 };

constexpr std::uint32_t no_vertex = ~0u;
constexpr const char* second_set = "TEXCOORD_1";

// The triangle's own normal; +Y where it has no area: it covers no pixel.
glm::vec3 flat_normal(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const glm::dvec3 u = glm::dvec3(b) - glm::dvec3(a), v = glm::dvec3(c) - glm::dvec3(a);
    const glm::vec3 n = made_unit({u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x});
    return n == glm::vec3(0) ? glm::vec3(0, 1, 0) : n;
}

// The corners of triangle t (glTF 2.0, 3.7.2.1).
std::array<std::size_t, 3> corners_of(int mode, std::size_t t) {
    if (mode == strip) return {t, t + 1 + t % 2, t + 2 - t % 2};
    if (mode == fan) return {t + 1, t + 2, 0};
    return {3 * t, 3 * t + 1, 3 * t + 2};
}

// Puts the primitives of one mesh together. Primitives that name the same attributes share their vertices.
class MeshReader {
  public:
    MeshReader(GltfDocument& document, const std::vector<TextureCoordinates>& coordinates, GltfModel& model, const MeshWanted& wanted)
        : document_(document), coordinates_(coordinates), model_(model), skinned_(wanted.skin), all_have_second_(wanted.second_coordinates) {}

    GltfMesh read(const JsonValue& json, const std::string& name) {
        out_.mesh.name = json["name"].text(name);
        const JsonValue primitives = json["primitives"].required();
        for (std::size_t p = 0; p < primitives.size(); ++p) read_primitive(primitives[p]);
        fill_zero_normals();
        if (!all_have_tangents_) out_.mesh.tangents.clear();
        if (!all_have_second_) out_.second_coordinates.clear();
        if (!order_.empty()) restore_order(json);
        return std::move(out_);
    }

  private:
    void read_primitive(const JsonValue& json) {
        const int mode = int(json["mode"].integer(0, 6, triangles));
        if (mode < triangles) {
            ++(mode == 0 ? document_.skipped.points : document_.skipped.lines);
            return;
        }
        // glTF 2.0, 3.7.2.1: positions may come from an extension; nothing is drawn without.
        if (!json["attributes"].required()["POSITION"]) {
            ++document_.skipped.without_position;
            return;
        }
        if (json["targets"]) document_.note("morph targets are not read");
        const std::optional<std::size_t> material =
            json["material"].index(document_.list("materials").size(), "materials");
        const TextureCoordinates coordinates = material ? coordinates_[*material] : TextureCoordinates{};
        const JsonValue attributes = json["attributes"].required(), position = attributes["POSITION"];
        const std::size_t vertices = accessor_count(document_, position);
        if (attributes["COLOR_0"]) document_.note("colours of vertices are not read");

        std::vector<std::uint32_t> corners;
        if (json["indices"]) corners = read_integers(document_, json["indices"], vertices, "vertices");
        const std::size_t n = json["indices"] ? corners.size() : vertices;
        if (n < 3 || (mode == triangles && n % 3 != 0))
            json.fail(fmt::format("{} corners; expected {}", n, mode == triangles ? "three a triangle" : "at least 3"));
        const std::size_t count = mode == triangles ? n / 3 : n - 2;
        if (out_.mesh.triangles.size() + count > max_gltf_total ||
            out_.mesh.vertices.size() + std::max(vertices, 3 * count) > max_gltf_total)
            json.fail(fmt::format("more than {} triangles or vertices in one mesh", max_gltf_total));

        const bool has_normals = bool(attributes["NORMAL"]);
        const std::uint32_t first = has_normals ? shared_block(attributes, coordinates, vertices) : no_vertex;
        const std::vector<Vertex> block =
            has_normals ? std::vector<Vertex>{} : read_vertices(attributes, coordinates, vertices);
        const std::vector<glm::vec2> second = has_normals ? std::vector<glm::vec2>{} : read_second(attributes, vertices);
        const std::vector<SkinWeights> skin = has_normals ? std::vector<SkinWeights>{} : read_skin(attributes, vertices);
        const std::int32_t number = material ? std::int32_t(*material) : default_material();
        for (std::size_t t = 0; t < count; ++t) {
            glm::uvec3 triangle;
            const std::array<std::size_t, 3> at = corners_of(mode, t);
            for (int k = 0; k < 3; ++k) {
                const std::size_t corner = at[std::size_t(k)];
                triangle[k] = corners.empty() ? std::uint32_t(corner) : corners[corner];
            }
            add_triangle(has_normals ? triangle + first : flat_triangle(block, second, skin, triangle), number);
        }
        if (!has_normals) all_have_tangents_ = false;
        const JsonValue order = json.own()["order"];
        if (order || !order_.empty()) add_order(json, order, count);
    }

    void add_triangle(const glm::uvec3& triangle, std::int32_t material) {
        out_.mesh.triangles.push_back(triangle);
        out_.mesh.material.push_back(material);
    }

    // Three vertices of the triangle's own, with its normal.
    glm::uvec3 flat_triangle(const std::vector<Vertex>& block, const std::vector<glm::vec2>& second,
                             const std::vector<SkinWeights>& skin, const glm::uvec3& triangle) {
        const std::uint32_t first = std::uint32_t(out_.mesh.vertices.size());
        const glm::vec3 normal =
            flat_normal(block[triangle.x].position, block[triangle.y].position, block[triangle.z].position);
        for (int k = 0; k < 3; ++k) {
            out_.mesh.vertices.push_back(block[triangle[k]]);
            out_.mesh.vertices.back().normal = normal;
            if (all_have_second_) out_.second_coordinates.push_back(second[triangle[k]]);
            if (skinned_) out_.skin.push_back(skin[triangle[k]]);
        }
        return {first, first + 1, first + 2};
    }

    // Numbers of positions and the like are floats; KHR_mesh_quantization allows integers.
    FloatsWanted numbers(int components, bool of_lengths) const {
        if (!document_.quantized) return {components};
        return of_lengths ? FloatsWanted{components, {5120, 5121, 5122, 5123}, true} : FloatsWanted{components, {5120, 5122}};
    }
    FloatsWanted coordinates_wanted() const {
        return document_.quantized ? FloatsWanted{2, {5120, 5121, 5122, 5123}, true} : FloatsWanted{2, {5121, 5123}};
    }

    std::vector<float> attribute(const JsonValue& json, std::size_t vertices, const FloatsWanted& wanted) {
        std::vector<float> values = read_floats(document_, json, wanted);
        if (values.size() != vertices * std::size_t(wanted.components))
            json.fail(fmt::format("has {} elements; POSITION has {}", values.size() / std::size_t(wanted.components),
                                  vertices));
        return values;
    }

    std::vector<Vertex> read_vertices(const JsonValue& attributes, const TextureCoordinates& c, std::size_t n) {
        // Read before memory is taken for as many vertices as the accessor says.
        const std::vector<float> position = attribute(attributes["POSITION"], n, numbers(3, true));
        std::vector<Vertex> block(n);
        for (std::size_t i = 0; i < n; ++i)
            block[i].position = {position[3 * i], position[3 * i + 1], position[3 * i + 2]};
        if (attributes["NORMAL"]) {
            const std::vector<float> normal = attribute(attributes["NORMAL"], n, numbers(3, false));
            for (std::size_t i = 0; i < n; ++i)
                block[i].normal = made_unit({normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]});
        }
        const JsonValue uv = attributes[fmt::format("TEXCOORD_{}", c.set).c_str()];
        if (!uv) return block;
        out_.has_texture_coordinates = true;
        const std::vector<float> values = attribute(uv, n, coordinates_wanted());
        const bool moved = !(c == TextureCoordinates{c.set, {0, 0}, {1, 1}, 0});
        const double sine = host::sin(c.rotation), cosine = host::cos(c.rotation);
        for (std::size_t i = 0; i < n; ++i) {
            block[i].u = values[2 * i], block[i].v = values[2 * i + 1];
            if (!moved) continue;
            // Counter-clockwise where v points down; the listing in KHR_texture_transform turns the other way round.
            const double x = c.scale.x * double(block[i].u), y = c.scale.y * double(block[i].v);
            block[i].u = float(cosine * x + sine * y + c.offset.x);
            block[i].v = float(cosine * y - sine * x + c.offset.y);
            if (!std::isfinite(block[i].u) || !std::isfinite(block[i].v))
                uv.fail(fmt::format("element {} is not finite once KHR_texture_transform has moved it", i));
        }
        return block;
    }

    // The lightmap's coordinates, as they are: no material moves them.
    std::vector<glm::vec2> read_second(const JsonValue& attributes, std::size_t n) {
        const JsonValue uv = attributes[second_set];
        all_have_second_ = all_have_second_ && bool(uv);
        if (!all_have_second_) return {};
        const std::vector<float> values = attribute(uv, n, coordinates_wanted());
        std::vector<glm::vec2> second(n);
        for (std::size_t i = 0; i < n; ++i) second[i] = {values[2 * i], values[2 * i + 1]};
        return second;
    }

    // Joints and weights; a primitive without them stays where it is.
    std::vector<SkinWeights> read_skin(const JsonValue& attributes, std::size_t n) {
        std::vector<SkinWeights> skin(skinned_ ? n : 0);
        const JsonValue joints = attributes["JOINTS_0"], weights = attributes["WEIGHTS_0"];
        if (!skinned_ || !joints || !weights) return skin;
        if (attributes["JOINTS_1"]) document_.note("of a vertex's joints the first four move it");
        const std::vector<std::uint32_t> joint = read_integers(document_, joints, max_gltf_elements, "joints", 4);
        if (joint.size() != 4 * n) joints.fail(fmt::format("has {} elements; POSITION has {}", joint.size() / 4, n));
        const std::vector<float> weight = attribute(weights, n, {4, {5121, 5123}});
        for (std::size_t i = 0; i < 4 * n; ++i) {
            if (weight[i] < 0) weights.fail(fmt::format("element {} is negative", i / 4));
            skin[i / 4].joint[i % 4] = joint[i], skin[i / 4].weight[i % 4] = weight[i];
        }
        return skin;
    }

    // Appends vertices that have normals, once, and returns the first.
    std::uint32_t shared_block(const JsonValue& attributes, const TextureCoordinates& c, std::size_t n) {
        Block wanted{{}, c, std::uint32_t(out_.mesh.vertices.size())};
        const std::string uv = fmt::format("TEXCOORD_{}", c.set);
        const char* const names[] = {"POSITION", "NORMAL", uv.c_str(), "TANGENT", "JOINTS_0", "WEIGHTS_0", second_set};
        for (std::size_t i = 0; i < (all_have_second_ ? 7 : 6); ++i) {
            const std::size_t accessors = document_.list("accessors").size();
            wanted.accessors[i] = std::int64_t(attributes[names[i]].index(accessors, "accessors").value_or(accessors));
        }
        for (const Block& block : blocks_)
            if (block.accessors == wanted.accessors && block.coordinates == wanted.coordinates) return block.first;
        blocks_.push_back(wanted);
        const std::vector<Vertex> block = read_vertices(attributes, c, n);
        out_.mesh.vertices.insert(out_.mesh.vertices.end(), block.begin(), block.end());
        read_tangents(attributes["TANGENT"], n);
        const std::vector<glm::vec2> second = read_second(attributes, n);
        out_.second_coordinates.insert(out_.second_coordinates.end(), second.begin(), second.end());
        const std::vector<SkinWeights> skin = read_skin(attributes, n);
        out_.skin.insert(out_.skin.end(), skin.begin(), skin.end());
        return wanted.first;
    }

    void read_tangents(const JsonValue& json, std::size_t n) {
        if (!json) all_have_tangents_ = false;
        if (!all_have_tangents_) return;
        const std::vector<float> values = attribute(json, n, numbers(4, false));
        for (std::size_t i = 0; i < n; ++i) {
            const float side = values[4 * i + 3];
            const glm::vec3 tangent = made_unit({values[4 * i], values[4 * i + 1], values[4 * i + 2]});
            if (side != 1 && side != -1 && !(side == 0 && tangent == glm::vec3(0)))
                json.fail(fmt::format("element {} has w = {}; expected 1 or -1", i, side));
            out_.mesh.tangents.emplace_back(tangent, side);
        }
    }

    // A normal without a length becomes that of the first triangle around it.
    void fill_zero_normals() {
        for (const glm::uvec3& t : out_.mesh.triangles)
            for (int k = 0; k < 3; ++k) {
                Vertex& v = out_.mesh.vertices[t[k]];
                if (v.normal == glm::vec3(0))
                    v.normal = flat_normal(out_.mesh.vertices[t.x].position, out_.mesh.vertices[t.y].position,
                                           out_.mesh.vertices[t.z].position);
            }
        for (Vertex& v : out_.mesh.vertices)
            if (v.normal == glm::vec3(0)) v.normal = {0, 1, 0};
    }

    std::int32_t default_material() {
        if (model_.materials.size() == coordinates_.size()) {
            model_.materials.push_back({});
            model_.materials.back().name = "default";
            model_.materials.back().reflectance = glm::vec3(1);
            model_.materials.back().microfacet = true, model_.materials.back().metalness = 1;
        }
        return std::int32_t(coordinates_.size());
    }

    // extras/plumb/order: where in the mesh each triangle of the primitive stands.
    void add_order(const JsonValue& json, const JsonValue& order, std::size_t count) {
        if (!order || order_.size() + count != out_.mesh.triangles.size())
            json.fail("extras/plumb/order stands at some primitives only");
        const std::vector<std::uint32_t> places = read_integers(document_, order, max_gltf_elements, "triangles");
        if (places.size() != count) order.fail(fmt::format("has {} elements for {} triangles", places.size(), count));
        order_.insert(order_.end(), places.begin(), places.end());
    }

    void restore_order(const JsonValue& json) {
        Mesh& mesh = out_.mesh;
        std::vector<glm::uvec3> sorted(mesh.triangles.size());
        std::vector<std::int32_t> material(mesh.triangles.size(), -1);
        if (order_.size() != sorted.size()) json.fail("extras/plumb/order stands at some primitives only");
        for (std::size_t i = 0; i < order_.size(); ++i) {
            if (order_[i] >= sorted.size() || material[order_[i]] >= 0)
                json.fail(fmt::format("extras/plumb/order: triangle {} is out of range or there twice", order_[i]));
            sorted[order_[i]] = mesh.triangles[i], material[order_[i]] = mesh.material[i];
        }
        mesh.triangles = std::move(sorted), mesh.material = std::move(material);
    }

    struct Block {
        std::array<std::int64_t, 7> accessors;
        TextureCoordinates coordinates;
        std::uint32_t first;
    };

    GltfDocument& document_;
    const std::vector<TextureCoordinates>& coordinates_;
    GltfModel& model_;
    GltfMesh out_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> order_;
    const bool skinned_;
    bool all_have_tangents_ = true;
    bool all_have_second_;
};

}  // namespace

GltfMesh read_gltf_mesh(GltfDocument& document, std::size_t index, GltfModel& model,
                        const std::vector<TextureCoordinates>& coordinates, const MeshWanted& wanted) {
    return MeshReader(document, coordinates, model, wanted)
        .read(document.list("meshes")[index], fmt::format("mesh{}", index));
}

}  // namespace plumb::io
