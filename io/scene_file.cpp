#include "io/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "io/choose_view.h"
#include "io/cornell.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/obj.h"
#include "io/scene_parts.h"
#include "io/toml_reader.h"

namespace plumb::io {
namespace {

constexpr int max_frame_side = 32768;
constexpr std::size_t max_scene_bytes = std::size_t(1) << 24;

void refuse_gltf(const std::string& path, const std::string& extension) {
    if (extension == "gltf" || extension == "glb")
        throw InputError(shown(path), "", "glTF is not read by this version; a later one will. Expected .obj");
}

class SceneReader {
  public:
    SceneReader(const std::string& path, const std::vector<std::string>& method_tables)
        : path_(path), method_tables_(method_tables) {}

    Scene read(const std::string& text) {
        const toml::table root = parse_toml(path_, text);
        TomlReader top(root, path_, "");
        scene_.name = path_;
        read_top(top);
        read_frame(top);
        read_meshes(top);
        read_materials(top);
        read_lights(top);
        read_render(top);
        read_settings(top);
        read_camera(top);
        top.finish();
        return std::move(scene_);
    }

  private:
    void read_top(TomlReader& top) {
        if (top.has("convention"))
            scene_.convention = parse_convention(top.word("convention", ""), top.place("convention"));
        scene_.camera.reversed_z = top.flag("reversed_z", false);
        // Only glTF's lights are photometric: the key is checked and changes nothing here.
        top.choice("photometric", 0, {"watt", "as_is"});
        const double seed = top.number("seed", 1, 0, 4294967295.0);
        if (seed != std::floor(seed)) top.fail("seed", "expected an integer from 0 to 4294967295");
        scene_.seed = std::uint32_t(seed);
    }

    void read_frame(TomlReader& top) {
        const toml::table* table = top.table("frame");
        if (!table) return;
        TomlReader frame(*table, path_, "[frame]");
        if (const auto size = frame.numbers("size", 2, 1, max_frame_side)) {
            if ((*size)[0] != std::floor((*size)[0]) || (*size)[1] != std::floor((*size)[1]))
                frame.fail("size", "expected two integers");
            scene_.frame_size = {int((*size)[0]), int((*size)[1])};
            if (std::int64_t(scene_.frame_size.x) * scene_.frame_size.y > (std::int64_t(1) << 28))
                frame.fail("size", "more than 2^28 pixels");
        }
        frame.finish();
    }

    void read_camera(TomlReader& top) {
        const toml::table* table = top.table("camera");
        if (!table) return choose_camera(scene_, flatten(scene_));
        TomlReader camera(*table, path_, "[camera]");
        Camera& c = scene_.camera;
        // Half a pose is none: both ends of the line of sight are chosen together.
        const bool has_pose = camera.has("position") && camera.has("look_at");
        if (!has_pose && (camera.has("position") || camera.has("look_at")))
            camera.fail(camera.has("position") ? "look_at" : "position", "is missing");
        if (!has_pose) choose_camera(scene_, flatten(scene_));
        c.position = camera.vector("position", c.position);
        c.look_at = camera.vector("look_at", c.look_at);
        c.up = camera.vector("up", c.up);
        c.fov_y_deg = camera.number("fov_y_deg", c.fov_y_deg);
        c.near = camera.number("near", c.near);
        c.far = camera.number("far", c.far);
        camera.finish();
        try {
            validate(c);
        } catch (const InputError& e) {
            throw InputError(camera.place() + ": " + e.what());
        }
    }

    // Appends a model's materials and textures to the scene and its mesh with them.
    void add_model(ObjModel model) {
        const std::int32_t first_material = std::int32_t(scene_.materials.size());
        const int first_texture = int(scene_.textures.size());
        for (std::int32_t& m : model.mesh.material) m += first_material;
        for (Material& m : model.materials) {
            if (m.texture >= 0) m.texture += first_texture;
            scene_.materials.push_back(std::move(m));
        }
        for (Texture& t : model.textures) scene_.textures.push_back(std::move(t));
        has_coordinates_.push_back(model.has_texture_coordinates);
        scene_.meshes.push_back(std::move(model.mesh));
    }

    ObjModel read_model(TomlReader& mesh) {
        if (mesh.has("file") == mesh.has("generate")) mesh.fail("file", "expected either file or generate");
        if (mesh.has("generate")) {
            mesh.choice("generate", 0, {"cornell"});
            return parse_obj("cornell.obj", cornell_obj(), [](const std::string&) { return cornell_mtl(); });
        }
        const std::string file = beside(path_, mesh.word("file", ""));
        try {
            const std::string extension = extension_of(file);
            refuse_gltf(file, extension);
            if (extension != "obj") throw InputError(shown(file), "", "not a mesh by its name; expected .obj");
            return read_obj(file);
        } catch (const InputError& e) {
            // The place in the mesh's file comes first; who named it, last.
            throw InputError(fmt::format("{} ({} names it)", e.what(), mesh.place("file")));
        }
    }

    void read_meshes(TomlReader& top) {
        for (const toml::table* table : top.tables("mesh")) {
            TomlReader mesh(*table, path_, "[[mesh]]");
            const glm::dmat4 transform = read_transform(mesh);
            const bool dynamic = mesh.flag("dynamic", false);
            const double share = mesh.number("share", 1, 0, 1);
            const std::string material = mesh.word("material", "");
            if (mesh.has("material") && material.empty()) mesh.fail("material", "expected a name");
            ObjModel model = read_model(mesh);
            mesh.finish();
            add_model(std::move(model));
            Mesh& added = scene_.meshes.back();
            added.transform = transform, added.dynamic = dynamic, added.share = share;
            if (!material.empty()) wanted_.push_back({scene_.meshes.size() - 1, material, mesh.place("material")});
        }
    }

    int read_texture_of(TomlReader& material) {
        const std::string file = material.word("texture", "");
        try {
            scene_.textures.push_back(read_texture(beside(path_, file)));
        } catch (const InputError& e) {
            material.fail("texture", e.what());
        }
        scene_.textures.back().filter = Filter(material.choice("filter", 0, {"bilinear", "nearest"}));
        return int(scene_.textures.size()) - 1;
    }

    void read_materials(TomlReader& top) {
        // A mesh may name a material that only this file describes.
        for (const Wanted& wanted : wanted_)
            if (!find_material(wanted.material)) described_here_.push_back(wanted.material);
        for (const toml::table* table : top.tables("material")) read_material(*table);
        for (const Wanted& wanted : wanted_) {
            const auto index = find_material(wanted.material);
            if (!index)
                throw InputError(
                    fmt::format("{}: [[mesh]] material = \"{}\": no [[material]] and no file has that name{}",
                                wanted.place, printable(wanted.material), nearest(wanted.material)));
            std::fill(scene_.meshes[wanted.mesh].material.begin(), scene_.meshes[wanted.mesh].material.end(), *index);
        }
        for (std::size_t m = 0; m < scene_.meshes.size(); ++m)
            if (!has_coordinates_[m] && uses_texture(scene_.meshes[m]))
                scene_.notes.push_back(fmt::format(
                    "mesh \"{}\" has no texture coordinates: it shows its texture's lower left corner everywhere",
                    scene_.meshes[m].name));
    }

    void read_material(const toml::table& table) {
        TomlReader reader(table, path_, "[[material]]");
        const std::string name = reader.word("name", "");
        if (name.empty()) reader.fail("name", "expected the name of a material");
        if (!find_material(name)) {
            if (std::find(described_here_.begin(), described_here_.end(), name) == described_here_.end())
                reader.fail("name", "no file and no [[mesh]] has a material of that name" + nearest(name));
            scene_.materials.push_back({});
            scene_.materials.back().name = name;
            // The picture is the reflectance, unless a factor is given.
            if (reader.has("texture")) scene_.materials.back().reflectance = glm::vec3(1);
        }
        const int texture = reader.has("texture") ? read_texture_of(reader) : -1;
        if (texture < 0 && reader.has("filter")) reader.fail("filter", "stands without a texture");
        for (Material& m : scene_.materials) {
            if (m.name != name) continue;
            m.reflectance = glm::vec3(reader.vector("reflectance", glm::dvec3(m.reflectance), 0, 1));
            m.emission = glm::vec3(reader.vector("emission", glm::dvec3(m.emission), 0, 3e38));
            if (texture >= 0) m.texture = texture;
        }
        reader.finish();
    }

    std::optional<std::int32_t> find_material(const std::string& name) const {
        for (std::size_t i = 0; i < scene_.materials.size(); ++i)
            if (scene_.materials[i].name == name) return std::int32_t(i);
        return {};
    }

    std::string nearest(const std::string& name) const {
        std::vector<std::string> names;
        for (const Material& m : scene_.materials) names.push_back(m.name);
        return names.empty() ? "" : "; the nearest known one is \"" + printable(nearest_name(name, names)) + "\"";
    }

    bool uses_texture(const Mesh& mesh) const {
        return std::any_of(mesh.material.begin(), mesh.material.end(),
                           [&](std::int32_t m) { return scene_.materials[std::size_t(m)].texture >= 0; });
    }

    void read_lights(TomlReader& top) {
        for (const toml::table* table : top.tables("light")) {
            TomlReader reader(*table, path_, "[[light]]");
            scene_.lights.push_back(read_light(reader, scene_.lights));
            reader.finish();
        }
        if (scene_.lights.empty()) scene_.notes.push_back("no light in the file: only what emits is seen");
    }

    void read_render(TomlReader& top) {
        if (const toml::table* table = top.table("environment")) {
            TomlReader environment(*table, path_, "[environment]");
            if (environment.has("file")) environment.fail("file", "pictures of the sky are not read by this version");
            scene_.environment.radiance = glm::vec3(environment.vector("radiance", glm::dvec3(0), 0, 3e38));
            environment.finish();
        }
        if (const toml::table* table = top.table("render")) {
            TomlReader render(*table, path_, "[render]");
            scene_.method = render.word("method", scene_.method);
            scene_.layout = render.word("layout", scene_.layout);
            render.finish();
        }
    }

    // The parameters of stages go on as they are; who owns them checks them.
    void read_settings(TomlReader& top) {
        for (const std::string& name : method_tables_) {
            const toml::table* table = top.table(name);
            if (!table) continue;
            TomlReader reader(*table, path_, "[" + name + "]");
            std::vector<std::pair<toml::source_position, std::string>> keys;
            for (const auto& [key, value] : *table) keys.emplace_back(key.source().begin, key.str());
            std::sort(keys.begin(), keys.end());
            for (const auto& [position, key] : keys)
                scene_.settings.push_back({name, key, reader.field_value(key), reader.place(key)});
        }
    }

    // [[mesh]] material = "name".
    struct Wanted {
        std::size_t mesh;
        std::string material, place;
    };

    const std::string& path_;
    const std::vector<std::string>& method_tables_;
    Scene scene_;
    std::vector<bool> has_coordinates_;  // of each mesh
    std::vector<Wanted> wanted_;
    std::vector<std::string> described_here_;
};

Scene load_bare_obj(const std::string& path) {
    Scene scene;
    scene.name = path;
    ObjModel model = read_obj(path);
    scene.meshes.push_back(std::move(model.mesh));
    scene.materials = std::move(model.materials);
    scene.textures = std::move(model.textures);
    const Geometry geometry = flatten(scene);
    choose_camera(scene, geometry);
    choose_light(scene, geometry);
    return scene;
}

}  // namespace

Scene load_scene(const std::string& path, const std::vector<std::string>& method_tables) {
    const std::string extension = extension_of(path);
    refuse_gltf(path, extension);
    if (extension == "obj") return load_bare_obj(path);
    if (extension != "toml") throw InputError(shown(path), "", "not a scene by its name; expected .toml or .obj");
    return SceneReader(path, method_tables).read(read_text(path, max_scene_bytes));
}

}  // namespace plumb::io
