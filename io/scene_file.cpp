#include "io/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/host_math.h"
#include "io/choose_view.h"
#include "io/cornell.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/obj.h"
#include "io/toml_reader.h"

namespace plumb::io {
namespace {

constexpr int max_frame_side = 32768;
constexpr int max_rsm_size = 16384;
constexpr std::size_t max_scene_bytes = std::size_t(1) << 24;

void refuse_gltf(const std::string& path, const std::string& extension) {
    if (extension == "gltf" || extension == "glb")
        throw InputError(shown(path), "", "glTF is not read by this version; a later one will. Expected .obj");
}

// Sine and cosine of degrees, exact at multiples of a right angle.
glm::dvec2 sin_cos_deg(double degrees) {
    const double turn = degrees - 360 * std::floor(degrees / 360);
    if (turn == 0) return {0, 1};
    if (turn == 90) return {1, 0};
    if (turn == 180) return {0, -1};
    if (turn == 270) return {-1, 0};
    const double radians = turn * (host::pi / 180);
    return {host::sin(radians), host::cos(radians)};
}

// Rotation by `degrees` that takes axis a towards axis b.
glm::dmat4 rotation(double degrees, int a, int b) {
    const glm::dvec2 sc = sin_cos_deg(degrees);
    glm::dmat4 m(1);
    m[a][a] = m[b][b] = sc.y;
    m[a][b] = sc.x;
    m[b][a] = -sc.x;
    return m;
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

    glm::dmat4 read_transform(TomlReader& mesh) {
        glm::dmat4 m(1);
        if (const auto rows = mesh.numbers("matrix", 16)) {
            for (const char* other : {"translate", "rotate_deg", "scale"})
                if (mesh.has(other)) mesh.fail(other, "stands beside matrix; expected one or the other");
            for (int row = 0; row < 4; ++row)
                for (int column = 0; column < 4; ++column) m[column][row] = (*rows)[std::size_t(4 * row + column)];
            if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1)
                mesh.fail("matrix", "expected 0, 0, 0, 1 in the last row");
            const double determinant = glm::determinant(glm::dmat3(m));
            if (!(std::fabs(determinant) > 0) || !std::isfinite(determinant))
                mesh.fail("matrix", "cannot be inverted");
            return m;
        }
        // The object is scaled, rolls about z, pitches about x, turns by yaw about y, and moves.
        const glm::dvec3 angles = mesh.vector("rotate_deg", glm::dvec3(0));
        m = rotation(angles.x, 2, 0) * rotation(angles.y, 1, 2) * rotation(angles.z, 0, 1);
        const glm::dvec3 scale = read_scale(mesh);
        for (int axis = 0; axis < 3; ++axis) m[axis] *= scale[axis];
        m[3] = glm::dvec4(mesh.vector("translate", glm::dvec3(0)), 1);
        return m;
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
                throw InputError(fmt::format("{}: [[mesh]] material = \"{}\": no [[material]] and no file has that name{}",
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
            scene_.lights.push_back(read_light(reader));
            reader.finish();
        }
        if (scene_.lights.empty()) scene_.notes.push_back("no light in the file: only what emits is seen");
    }

    Light read_light(TomlReader& reader) {
        Light light;
        // Names of lights become names of layers.
        light.name = reader.word("name", fmt::format("light{}", scene_.lights.size()));
        const auto plain = [](char c) {
            return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
        };
        if (light.name.empty() || light.name.size() > 64 || !std::all_of(light.name.begin(), light.name.end(), plain))
            reader.fail("name", "expected 1 to 64 letters, digits, _ or -");
        for (const Light& other : scene_.lights)
            if (other.name == light.name) reader.fail("name", "another light has that name");

        light.type = LightType(reader.choice("type", 0, {"spot", "point", "directional"}));
        light.position = glm::vec3(reader.vector("position", glm::dvec3(0), -1e30, 1e30));
        const glm::dvec3 d = reader.vector("direction", glm::dvec3(0, -1, 0), -1e30, 1e30);
        const double largest = std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
        if (!(largest > 0)) reader.fail("direction", "has no length");
        const glm::dvec3 s = d / largest;
        light.direction = glm::vec3(s / std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z));
        if (const auto cone = reader.numbers("cone_deg", 2, 0, 89)) {
            light.cone_inner_deg = float((*cone)[0]), light.cone_outer_deg = float((*cone)[1]);
            if (!(light.cone_outer_deg > 0 && light.cone_inner_deg <= light.cone_outer_deg))
                reader.fail("cone_deg", "expected 0 <= inner <= outer <= 89, outer above 0");
        }
        light.intensity = glm::vec3(reader.vector("intensity", glm::dvec3(1), 0, 3e38));
        light.on = reader.flag("on", true);
        light.rsm_size = reader.integer("rsm_size", 512, 1, max_rsm_size);
        return light;
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
