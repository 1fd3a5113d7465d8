#include "io/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/file.h"
#include "io/gltf_document.h"
#include "io/scene_parts.h"

namespace plumb::io {
namespace {

// Whether one of its triangles has, before it is moved.
bool has_area(const Mesh& mesh) {
    return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const glm::uvec3& t) {
        const glm::dvec3 a(mesh.vertices[t.x].position), u = glm::dvec3(mesh.vertices[t.y].position) - a,
                         v = glm::dvec3(mesh.vertices[t.z].position) - a;
        return u.y * v.z != u.z * v.y || u.z * v.x != u.x * v.z || u.x * v.y != u.y * v.x;
    });
}

class ModelReader {
  public:
    ModelReader(GltfDocument& document, const GltfOptions& options) : document_(document), options_(options) {}

    GltfModel read() {
        coordinates_ = read_gltf_materials(document_, model_);
        cache_.resize(document_.list("meshes").size());
        const JsonValue nodes = document_.list("nodes");
        const std::vector<GltfNode> order = read_gltf_nodes(document_);
        to_world_.resize(nodes.size());
        for (const GltfNode& node : order) {
            to_world_[node.index] = node.to_world;
            const auto mesh = nodes[node.index]["mesh"].index(cache_.size(), "meshes");
            if (!mesh) continue;
            ++cache_[*mesh].uses;
            cache_[*mesh].skinned = cache_[*mesh].skinned || nodes[node.index]["skin"];
        }
        for (const GltfNode& node : order) add_node(nodes[node.index], node.to_world);
        if (triangles_ == 0) throw InputError(shown(document_.path), "", "holds no triangle: " + why_none(order));
        if (!any_area_)
            document_.note(fmt::format("nothing is seen: the corners of each of the {} triangles lie in a line", triangles_));
        const std::string skipped = document_.skipped.text();
        if (!skipped.empty()) document_.note("not drawn: " + skipped);
        model_.notes = std::move(document_.notes);
        return std::move(model_);
    }

  private:
    struct Cached {
        std::optional<GltfMesh> read;  // once a node has asked for it
        std::size_t uses = 0;          // by nodes that are still to come
        bool skinned = false;          // by one of them
    };

    // Why the nodes of the default scene bring none.
    std::string why_none(const std::vector<GltfNode>& order) {
        const JsonValue nodes = document_.list("nodes");
        const std::size_t meshes = cache_.size(), scenes = document_.list("scenes").size();
        const auto refers = [&](std::size_t node) { return nodes[node]["mesh"].index(meshes, "meshes").has_value(); };
        if (meshes == 0) return "the file has no mesh";
        if (std::any_of(order.begin(), order.end(), [&](const GltfNode& n) { return refers(n.index); }))
            return document_.skipped.text() + ", and nothing else in the meshes of the scene that is read";
        std::size_t elsewhere = 0;
        for (std::size_t n = 0; n < nodes.size(); ++n) elsewhere += refers(n);
        if (elsewhere == 0) return fmt::format("no node refers to a mesh, of which the file has {}", meshes);
        return fmt::format("no node of the scene that is read (of {}) refers to a mesh; {} elsewhere {}", scenes, elsewhere,
                           elsewhere == 1 ? "does" : "do");
    }

    void add_node(const JsonValue& node, const glm::dmat4& to_world) {
        const auto mesh = node["mesh"].index(cache_.size(), "meshes");
        const JsonValue cameras = document_.list("cameras");
        const auto camera = node["camera"].index(cameras.size(), "cameras");
        const JsonValue lights = document_.list("extensions")["KHR_lights_punctual"]["lights"];
        const auto light = node["extensions"]["KHR_lights_punctual"]["light"].index(lights.size(), "lights");
        if (!mesh && !camera && !light) return;

        double largest = 0;
        for (int i = 0; i < 16; ++i) largest = std::max(largest, std::fabs(to_world[i / 4][i % 4]));
        const double determinant = glm::determinant(glm::dmat3(to_world));
        if (!(largest < 1e37) || !(std::fabs(determinant) > 0) || !std::isfinite(determinant))
            node.fail("its transform to the world cannot be inverted");
        if (mesh) add_mesh(node, *mesh, to_world);
        if (camera) add_camera(cameras[*camera], to_world);
        if (light) {
            Light read = read_gltf_light(lights[*light], to_world, options_, document_);
            read.name = layer_name(node["name"].text(read.name), model_.lights);
            model_.lights.push_back(std::move(read));
        }
    }

    void add_mesh(const JsonValue& node, std::size_t index, const glm::dmat4& to_world) {
        Cached& cached = cache_[index];
        if (!cached.read)
            cached.read = read_gltf_mesh(document_, index, model_, coordinates_, {options_.second_coordinates, cached.skinned});
        triangles_ += cached.read->mesh.triangles.size(), vertices_ += cached.read->mesh.vertices.size();
        if (triangles_ > max_gltf_total || vertices_ > max_gltf_total)
            node.fail(fmt::format("more than {} triangles or vertices in all", max_gltf_total));
        if (cached.read->mesh.triangles.empty()) return;
        any_area_ = any_area_ || has_area(cached.read->mesh);
        // The last node takes the mesh, the others a copy of it.
        const bool has_texture_coordinates = cached.read->has_texture_coordinates;
        if (options_.second_coordinates) model_.second_coordinates.push_back(cached.read->second_coordinates);
        Mesh mesh = --cached.uses == 0 ? std::move(cached.read->mesh) : cached.read->mesh;
        mesh.name = node["name"].text(mesh.name);
        // Of a skinned mesh the joints say where it is, and its node does not.
        if (node["skin"])
            apply_gltf_skin(document_, node["skin"], to_world_, cached.read->skin, mesh);
        else
            mesh.transform = to_world;
        mesh.dynamic = node.own()["dynamic"].flag(false);
        mesh.share = node.own()["share"].number(0, 1, 1);
        model_.meshes.push_back(std::move(mesh));
        model_.has_texture_coordinates.push_back(has_texture_coordinates);
    }

    void add_camera(const JsonValue& json, const glm::dmat4& to_world) {
        const std::string type = json["type"].text();
        if (type == "orthographic") return document_.note("orthographic cameras are not read");
        if (type != "perspective") json["type"].fail("expected perspective or orthographic");
        if (json["perspective"]["aspectRatio"]) document_.note("a camera's aspectRatio gives way to the frame's");
        const Camera camera = read_gltf_camera(json, to_world);
        if (model_.has_camera) return document_.note("of several cameras the first is taken");
        model_.has_camera = true, model_.camera = camera;
    }

    GltfDocument& document_;
    const GltfOptions& options_;
    GltfModel model_;
    std::vector<TextureCoordinates> coordinates_;
    std::vector<Cached> cache_;  // of each mesh
    std::vector<std::optional<glm::dmat4>> to_world_;  // of each node of the scene
    std::size_t triangles_ = 0, vertices_ = 0;
    bool any_area_ = false;
};

}  // namespace

std::string GltfSkipped::text() const {
    std::string text;
    const auto add = [&](std::size_t count, const char* what) {
        if (count > 0) text += fmt::format("{}{} primitive{} {}", text.empty() ? "" : ", ", count, count == 1 ? "" : "s", what);
    };
    add(points, "of points"), add(lines, "of lines"), add(without_position, "without POSITION");
    return text;
}

GltfModel read_gltf(const std::string& path, const GltfOptions& options) {
    return parse_gltf(path, read_bytes(path), options);
}

GltfModel parse_gltf(const std::string& path, std::vector<unsigned char> file, const GltfOptions& options) {
    GltfDocument document;
    document.path = path;
    document.strict = options.strict;
    document.file = std::move(file);
    open_gltf(document);
    return ModelReader(document, options).read();
}

}  // namespace plumb::io
