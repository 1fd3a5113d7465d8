#include "io/scene_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/tangents.h"
#include "io/cornell.h"
#include "io/file.h"
#include "io/gltf_document.h"
#include "io/obj.h"

namespace plumb::io {
namespace {

SceneModel from_obj(ObjModel obj) {
    SceneModel model;
    model.has_texture_coordinates = {obj.has_texture_coordinates};
    model.scene.meshes.push_back(std::move(obj.mesh));
    model.scene.materials = std::move(obj.materials);
    model.scene.textures = std::move(obj.textures);
    model.scene.notes = std::move(obj.notes);
    return model;
}

SceneModel from_gltf(GltfModel gltf) {
    SceneModel model;
    model.has_texture_coordinates = std::move(gltf.has_texture_coordinates);
    model.second_coordinates = std::move(gltf.second_coordinates);
    model.scene.meshes = std::move(gltf.meshes);
    model.scene.materials = std::move(gltf.materials);
    model.scene.textures = std::move(gltf.textures);
    model.scene.lights = std::move(gltf.lights);
    model.scene.notes = std::move(gltf.notes);
    model.has_camera = gltf.has_camera;
    model.scene.camera = gltf.camera;
    return model;
}

bool shows_normal_map(const Scene& scene, const Mesh& mesh) {
    return std::any_of(mesh.material.begin(), mesh.material.end(),
                       [&](std::int32_t m) { return scene.materials[std::size_t(m)].normal_texture >= 0; });
}

}  // namespace

SceneModel load_model(const std::string& path, const GltfOptions& options) {
    const std::string extension = extension_of(path);
    if (extension == "obj") return from_obj(read_obj(path, options.strict));
    if (extension == "gltf" || extension == "glb") return from_gltf(read_gltf(path, options));
    throw InputError(shown(path), "", "not a mesh by its name; expected .obj, .gltf or .glb");
}

std::vector<std::string> model_names() {
    std::vector<std::string> names = {"cornell"};
    for (const GeneratedScene& scene : generated_scenes()) names.emplace_back(scene.name);
    return names;
}

SceneModel generate_model(const std::string& name, const GenerateOptions& options, const std::string& place) {
    if (name == "cornell") {
        if (options.triangles != 0) throw InputError(place + ": the scene \"cornell\" has no adjustable count");
        return from_obj(parse_obj("cornell.obj", cornell_obj(), [](const std::string& name, auto&&...) {
            return Library{name, cornell_mtl()};
        }));
    }
    SceneModel model;
    model.scene = generate_scene(name, options, place);
    model.has_texture_coordinates.assign(model.scene.meshes.size(), true);
    model.has_camera = model.is_whole = true;
    return model;
}

void move_model(SceneModel& model, const glm::dmat4& transform) {
    // Nothing is computed where nothing moves: not even a zero changes its sign.
    if (transform == glm::dmat4(1)) return;
    const glm::dmat3 linear(transform);
    const auto point = [&](const glm::dvec3& p) { return glm::dvec3(transform * glm::dvec4(p, 1)); };
    for (Mesh& mesh : model.scene.meshes)
        mesh.transform = mesh.transform == glm::dmat4(1) ? transform : transform * mesh.transform;
    for (Light& light : model.scene.lights) {
        light.position = glm::vec3(point(light.position));
        light.direction = made_unit(linear * glm::dvec3(light.direction));
    }
    Camera& camera = model.scene.camera;
    camera.position = point(camera.position);
    camera.look_at = point(camera.look_at);
    camera.up = linear * camera.up;
}

void append_model(Scene& scene, SceneModel& model) {
    const std::int32_t first_material = std::int32_t(scene.materials.size());
    const int first_texture = int(scene.textures.size());
    for (Mesh& mesh : model.scene.meshes) {
        for (std::int32_t& m : mesh.material) m += first_material;
        scene.meshes.push_back(std::move(mesh));
    }
    for (Material& material : model.scene.materials) {
        for (int* texture : {&material.texture, &material.emission_texture, &material.normal_texture,
                             &material.surface_texture})
            if (*texture >= 0) *texture += first_texture;
        scene.materials.push_back(std::move(material));
    }
    for (Texture& texture : model.scene.textures) scene.textures.push_back(std::move(texture));
}

std::string excess_of(const Material& m) {
    constexpr const char* channels[] = {"red", "green", "blue"};
    for (int c = 0; c < 3; ++c)
        if (!(double(m.reflectance[c]) + double(m.specular[c]) + double(m.mirror[c]) <= 1 + 1e-6))
            return fmt::format(
                "material \"{}\" reflects more than it receives: reflectance {:.4g} + specular {:.4g} + mirror {:.4g} "
                "in {}; expected a sum of at most 1",
                printable(m.name), m.reflectance[c], m.specular[c], m.mirror[c], channels[c]);
    return "";
}

void complete_tangents(Scene& scene) {
    for (Mesh& mesh : scene.meshes)
        if (mesh.tangents.empty() && shows_normal_map(scene, mesh)) generate_tangents(mesh);
}

}  // namespace plumb::io
