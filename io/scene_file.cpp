#include "io/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/choose_view.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/sample_rows.h"
#include "io/scene_keyframes.h"
#include "io/scene_model.h"
#include "io/scene_parts.h"
#include "io/toml_reader.h"

namespace plumb::io {
namespace {

constexpr int max_frame_side = 32767;  // as the rasterizer
constexpr std::size_t max_scene_bytes = std::size_t(1) << 24;

// A list for each mesh of the model, before its meshes are moved away.
void append_second(SceneModel& model, SecondCoordinates& second) {
    model.second_coordinates.resize(model.scene.meshes.size());
    for (std::vector<glm::vec2>& of_mesh : model.second_coordinates) second.push_back(std::move(of_mesh));
}

// Tangents split vertices; triangles keep their order, and with them each corner its coordinate.
void complete(Scene& scene, SecondCoordinates* second) {
    if (!second) return complete_tangents(scene);
    std::vector<std::vector<glm::uvec3>> before;
    for (const Mesh& mesh : scene.meshes) before.push_back(mesh.triangles);
    complete_tangents(scene);
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        std::vector<glm::vec2>& of_mesh = (*second)[m];
        if (of_mesh.empty() || of_mesh.size() == mesh.vertices.size()) continue;
        std::vector<glm::vec2> split(mesh.vertices.size(), glm::vec2(0));
        std::copy(of_mesh.begin(), of_mesh.end(), split.begin());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) split[mesh.triangles[t][k]] = of_mesh[before[m][t][k]];
        of_mesh = std::move(split);
    }
}

class SceneReader {
  public:
    SceneReader(const std::string& path, const std::vector<std::string>& method_tables, SecondCoordinates* second,
                const LoadOptions& options)
        : path_(path), method_tables_(method_tables), second_(second), options_(options) {}

    Scene read(const std::string& text) {
        const toml::table root = parse_toml(path_, text);
        TomlReader top(root, path_, "");
        // The meshes come first: a generated scene brings what this file leaves open.
        read_meshes(top);
        scene_.name = path_;
        read_top(top);
        read_frame(top);
        read_materials(top);
        read_lights(top);
        read_render(top);
        read_settings(top);
        read_camera(top);
        read_keyframes(top, path_, named_, scene_);
        top.finish();
        complete(scene_, second_);
        return std::move(scene_);
    }

  private:
    void read_top(TomlReader& top) {
        if (top.has("convention"))
            scene_.convention = parse_convention(top.word("convention", ""), top.place("convention"));
        scene_.camera.reversed_z = top.flag("reversed_z", scene_.camera.reversed_z);
        const double seed = top.number("seed", double(scene_.seed), 0, 4294967295.0);
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
        if (!table && !camera_from_.empty())
            return scene_.notes.push_back("no camera in the file: the one of " + camera_from_);
        if (!table) return choose_camera(scene_, flatten(scene_));
        TomlReader camera(*table, path_, "[camera]");
        Camera& c = scene_.camera;
        // Half a pose is none: both ends of the line of sight are chosen together.
        const auto along = read_yaw_pitch(camera);
        if (along && camera.has("look_at")) camera.fail("look_at", "stands beside yaw_deg or pitch_deg; expected one or the other");
        const bool has_pose = camera.has("position") && (along || camera.has("look_at"));
        if (!has_pose && (camera.has("position") || camera.has("look_at") || along))
            camera.fail(camera.has("position") ? "look_at" : "position", "is missing");
        if (!has_pose && camera_from_.empty()) choose_camera(scene_, flatten(scene_));
        if (has_pose) {
            const bool reversed_z = c.reversed_z;
            c = {}, c.reversed_z = reversed_z;
        }
        c.position = camera.vector("position", c.position);
        c.look_at = along ? c.position + *along : camera.vector("look_at", c.look_at);
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

    SceneModel read_model(TomlReader& mesh, const GltfOptions& options) {
        if (mesh.has("file") == mesh.has("generate")) mesh.fail("file", "expected either file or generate");
        if (mesh.has("generate")) {
            const std::vector<std::string> names = model_names();
            const std::string name = names[std::size_t(mesh.choice("generate", 0, names))];
            GenerateOptions wanted;
            wanted.triangles = mesh.integer("triangles", 0, 1, 1 << 30);
            wanted.seed = std::uint32_t(mesh.integer("seed", 1, 0, std::numeric_limits<int>::max()));
            return generate_model(name, wanted, mesh.place(mesh.has("triangles") ? "triangles" : "generate"));
        }
        const std::string file = beside(path_, mesh.word("file", ""));
        try {
            return load_model(file, options);
        } catch (const InputError& e) {
            // The place in the mesh's file comes first; who named it, last.
            throw InputError(fmt::format("{} ({} names it)", e.what(), mesh.place("file")));
        }
    }

    void read_meshes(TomlReader& top) {
        GltfOptions options;
        options.second_coordinates = second_ != nullptr, options.strict = options_.strict;
        options.photometric_as_is = top.choice("photometric", 0, {"watt", "as_is"}) == 1;
        for (const toml::table* table : top.tables("mesh")) {
            TomlReader mesh(*table, path_, "[[mesh]]");
            const glm::dmat4 transform = read_transform(mesh);
            const bool dynamic = mesh.flag("dynamic", false);
            const double share = mesh.number("share", 1, 0, 1);
            const std::string name = read_name(mesh), material = mesh.word("material", "");
            if (mesh.has("material") && material.empty()) mesh.fail("material", "expected a name");
            SceneModel model = read_model(mesh, options);
            const std::string from = "\"" + printable(mesh.word(mesh.has("file") ? "file" : "generate", "")) + "\"";
            mesh.finish();
            move_model(model, transform);
            if (!name.empty()) named_.push_back({name, glm::dvec3(transform[3])});
            for (Mesh& m : model.scene.meshes) {
                if (!name.empty()) m.name = model.scene.meshes.size() == 1 ? name : name + "/" + m.name;
                if (mesh.has("dynamic")) m.dynamic = dynamic;
                if (mesh.has("share")) m.share = share;
                if (!material.empty())
                    wanted_.push_back({scene_.meshes.size() + std::size_t(&m - model.scene.meshes.data()), material,
                                       mesh.place("material")});
            }
            take_surroundings(model, from);
            if (second_) append_second(model, *second_);
            append_model(scene_, model);
            has_coordinates_.insert(has_coordinates_.end(), model.has_texture_coordinates.begin(),
                                    model.has_texture_coordinates.end());
        }
    }

    std::string read_name(TomlReader& mesh) {
        const std::string name = mesh.word("name", "");
        if (mesh.has("name") && name.empty()) mesh.fail("name", "expected a name");
        for (const NamedMesh& other : named_)
            if (other.name == name) mesh.fail("name", "another mesh has that name");
        return name;
    }

    // Camera, lights and settings of a model, for what this file leaves open.
    void take_surroundings(SceneModel& model, const std::string& from) {
        Scene& its = model.scene;
        for (const std::string& note : its.notes) scene_.notes.push_back(from + ": " + note);
        if (model.is_whole && !has_whole_) {
            has_whole_ = true;
            scene_.environment = its.environment, scene_.convention = its.convention, scene_.seed = its.seed;
            scene_.frame_size = its.frame_size, scene_.method = its.method, scene_.layout = its.layout;
            scene_.settings = its.settings;
            if (camera_from_.empty()) scene_.camera.reversed_z = its.camera.reversed_z;
        }
        if (model.has_camera && camera_from_.empty()) {
            const bool reversed_z = model.is_whole ? its.camera.reversed_z : scene_.camera.reversed_z;
            camera_from_ = from, scene_.camera = its.camera, scene_.camera.reversed_z = reversed_z;
        }
        for (Light& light : its.lights) {
            light.name = layer_name(light.name, model_lights_);
            model_lights_.push_back(std::move(light));
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
                    printable(scene_.meshes[m].name)));
    }

    void read_material(const toml::table& table) {
        TomlReader reader(table, path_, "[[material]]");
        if (reader.has("index")) return read_material_at(reader);
        const std::string name = reader.word("name", "");
        if (name.empty()) reader.fail("name", "expected the name of a material, or its index");
        if (!find_material(name)) {
            if (std::find(described_here_.begin(), described_here_.end(), name) == described_here_.end())
                reader.fail("name", "no file and no [[mesh]] has a material of that name" + nearest(name));
            scene_.materials.push_back({});
            ++new_materials_;
            scene_.materials.back().name = name;
            // The picture is the reflectance, unless a factor is given.
            if (reader.has("texture")) scene_.materials.back().reflectance = glm::vec3(1);
        }
        const int texture = reader.has("texture") ? read_texture_of(reader) : -1;
        if (texture < 0 && reader.has("filter")) reader.fail("filter", "stands without a texture");
        for (Material& m : scene_.materials) {
            if (m.name != name) continue;
            read_surface(reader, m);
            if (texture >= 0) m.texture = texture;
        }
        reader.finish();
    }

    // By its number among the materials that the meshes bring, in their order.
    void read_material_at(TomlReader& reader) {
        if (reader.has("name")) reader.fail("index", "stands beside a name; expected one or the other");
        const int count = int(scene_.materials.size()) - int(new_materials_);
        if (count == 0) reader.fail("index", "no mesh brings a material");
        Material& m = scene_.materials[std::size_t(reader.integer("index", 0, 0, count - 1))];
        read_surface(reader, m);
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
        return shown(nearest_known(name, names, "\"\""));
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
        if (scene_.lights.empty() && !model_lights_.empty()) {
            scene_.lights = std::move(model_lights_);
            scene_.notes.push_back(fmt::format("no light in the file: the {} of its meshes", scene_.lights.size()));
        }
        if (scene_.lights.empty()) scene_.notes.push_back("no light in the file: only what emits is seen");
    }

    void read_render(TomlReader& top) {
        if (const toml::table* table = top.table("environment")) {
            TomlReader environment(*table, path_, "[environment]");
            read_environment(environment, path_, scene_);
            environment.finish();
        }
        if (const toml::table* table = top.table("render")) {
            TomlReader render(*table, path_, "[render]");
            scene_.method = render.word("method", scene_.method);
            scene_.layout = render.word("layout", scene_.layout);
            if (render.has("mips")) {
                const bool mips = render.flag("mips", false);
                for (Texture& texture : scene_.textures) texture.mips = mips;
            }
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
            for (const auto& [position, key] : keys) {
                Setting setting{name, key, reader.field_value(key), reader.place(key)};
                const std::string* file = std::get_if<std::string>(&setting.value);
                // The only parameter that names a file.
                if (name == "rsm" && key == "pattern" && file)
                    setting.rows = read_sample_rows(*file, file->empty() ? "" : beside(path_, *file), setting.place);
                scene_.settings.push_back(std::move(setting));
            }
        }
    }

    // [[mesh]] material = "name".
    struct Wanted {
        std::size_t mesh;
        std::string material, place;
    };

    const std::string& path_;
    const std::vector<std::string>& method_tables_;
    SecondCoordinates* const second_;  // null: nobody asks for them
    const LoadOptions& options_;
    Scene scene_;
    std::vector<bool> has_coordinates_;  // of each mesh
    std::vector<NamedMesh> named_;
    std::vector<Wanted> wanted_;
    std::vector<std::string> described_here_;
    std::size_t new_materials_ = 0;    // that this file alone describes: they come last
    bool has_whole_ = false;           // a generated scene among the meshes
    std::string camera_from_;          // which mesh brought a camera; "" if none
    std::vector<Light> model_lights_;  // of all meshes
};

Scene load_bare(const std::string& path, SecondCoordinates* second, bool strict) {
    GltfOptions options;
    options.second_coordinates = second != nullptr, options.strict = strict;
    SceneModel model = load_model(path, options);
    if (second) append_second(model, *second);
    Scene scene = std::move(model.scene);
    scene.name = path;
    if (!model.has_camera || scene.lights.empty()) {
        const Geometry geometry = flatten(scene);
        if (!model.has_camera) choose_camera(scene, geometry);
        if (scene.lights.empty()) choose_light(scene, geometry);
    }
    complete(scene, second);
    return scene;
}

Scene load(const std::string& path, const std::vector<std::string>& method_tables, SecondCoordinates* second,
           const LoadOptions& options) {
    const std::string extension = extension_of(path);
    if (extension == "obj" || extension == "gltf" || extension == "glb") return load_bare(path, second, options.strict);
    if (extension != "toml")
        throw InputError(shown(path), "", "not a scene by its name; expected .toml, .obj, .gltf or .glb");
    return SceneReader(path, method_tables, second, options).read(read_text(path, max_scene_bytes));
}

}  // namespace

Scene load_scene(const std::string& path, const std::vector<std::string>& method_tables, const LoadOptions& options) {
    return load(path, method_tables, nullptr, options);
}

Scene load_scene(const std::string& path, const std::vector<std::string>& method_tables, SecondCoordinates& second,
                 const LoadOptions& options) {
    second.clear();
    return load(path, method_tables, &second, options);
}

}  // namespace plumb::io
