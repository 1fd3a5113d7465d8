#include "io/camera_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "core/animation.h"
#include "core/error.h"
#include "io/file.h"
#include "io/scene_file.h"
#include "io/scene_parts.h"
#include "io/scenes/generate.h"
#include "io/toml_reader.h"

namespace plumb::io {

namespace {

constexpr std::size_t max_list_bytes = std::size_t(1) << 24;
constexpr double farthest = 1e9;  // m

std::string filled(TomlReader& camera, const std::string& key) {
    const std::string word = camera.word(key, "");
    if (!camera.has(key)) camera.fail(key, "is missing");
    if (word.empty()) camera.fail(key, "expected a word");
    return word;
}

glm::dvec3 place(TomlReader& camera, const std::string& key) {
    if (!camera.has(key)) camera.fail(key, "is missing");
    return camera.vector(key, {}, -farthest, farthest);
}

ListedCamera read_listed(TomlReader& reader, std::set<std::string>& names) {
    ListedCamera c;
    c.scene = filled(reader, "scene");
    c.name = filled(reader, "name");
    if (!is_layer_name(c.name)) reader.fail("name", "expected 1 to 64 letters, digits, _ or -");
    if (!names.insert(c.name).second) reader.fail("name", "another view has that name");
    c.position = place(reader, "position");
    c.look_at = place(reader, "look_at");
    c.up = reader.vector("up", c.up, -farthest, farthest);
    c.fov_y_deg = reader.number("fov_y_deg", c.fov_y_deg);
    if (reader.has("exposure")) c.exposure = reader.number("exposure", 1, 1e-12, 1e12);
    if (reader.has("frame")) c.frame = reader.integer("frame", 0, 0, 1'000'000);
    reader.finish();
    Camera camera;
    camera.position = c.position, camera.look_at = c.look_at, camera.up = c.up, camera.fov_y_deg = c.fov_y_deg;
    try {
        validate(camera);
    } catch (const InputError& e) {
        throw InputError(reader.place() + ": " + e.what());
    }
    return c;
}

std::string vector_text(const glm::dvec3& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

// A whole number that a name of a generated scene carries.
std::int64_t count_of(const std::string& scene, const std::string& part, const char* what, std::int64_t least,
                      std::int64_t most) {
    std::int64_t n = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), n);
    if (error != std::errc() || end != part.data() + part.size() || n < least || n > most)
        throw InputError(fmt::format("scene \"{}\": {} \"{}\": expected a whole number from {} to {}", printable(scene),
                                     what, printable(part), least, most));
    return n;
}

}  // namespace

bool is_scene_file(const std::string& scene) { return !extension_of(scene).empty(); }

CameraList read_camera_list(const std::string& path) {
    const toml::table root = parse_toml(path, read_text(path, max_list_bytes));
    TomlReader top(root, path, "");
    CameraList list{path, "", {}};
    const std::vector<const toml::table*> tables = top.tables("camera");
    top.finish();
    if (tables.empty()) throw InputError(shown(path), "", "no [[camera]]: expected at least one");
    if (tables.size() > max_listed_cameras)
        throw InputError(shown(path), "",
                         fmt::format("{} cameras: expected at most {}", tables.size(), max_listed_cameras));
    std::set<std::string> names;
    for (const toml::table* table : tables) {
        TomlReader reader(*table, path, "[[camera]]");
        list.cameras.push_back(read_listed(reader, names));
    }
    return list;
}

std::string camera_list_text(const CameraList& list) {
    std::string text;
    for (std::size_t from = 0; from < list.comment.size();) {
        const std::size_t end = std::min(list.comment.find('\n', from), list.comment.size());
        text += "# " + list.comment.substr(from, end - from) + "\n";
        from = end + 1;
    }
    for (const ListedCamera& c : list.cameras) {
        text += fmt::format("\n[[camera]]\nscene = \"{}\"\nname = \"{}\"\n", c.scene, c.name);
        text += fmt::format("position = {}  # m\nlook_at = {}\nup = {}\nfov_y_deg = {}\n", vector_text(c.position),
                            vector_text(c.look_at), vector_text(c.up), c.fov_y_deg);
        if (c.exposure) text += fmt::format("exposure = {}\n", *c.exposure);
        if (c.frame) text += fmt::format("frame = {}\n", *c.frame);
    }
    return text;
}

Scene load_listed_scene(const std::string& list_path, const std::string& scene,
                        const std::vector<std::string>& method_tables) {
    if (is_scene_file(scene)) return load_scene(beside(list_path, scene), method_tables);
    std::vector<std::string> parts(1);
    for (const char c : scene) {
        if (c == ':')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    if (parts.size() > 3)
        throw InputError(
            fmt::format("scene \"{}\": expected NAME, NAME:TRIANGLES or NAME:TRIANGLES:SEED", printable(scene)));
    GenerateOptions options;
    if (parts.size() > 1) options.triangles = count_of(scene, parts[1], "triangles", 1, 1 << 30);
    if (parts.size() > 2) options.seed = std::uint32_t(count_of(scene, parts[2], "seed", 0, 2147483647));
    Scene made = generate_scene(parts[0], options, shown(list_path));
    made.name = scene;
    return made;
}

Scene scene_of(const CameraList& list, const ListedCamera& listed, const Scene& loaded) {
    Scene scene = listed.frame ? scene_at(loaded, *listed.frame) : loaded;
    scene.camera.position = listed.position, scene.camera.look_at = listed.look_at, scene.camera.up = listed.up;
    scene.camera.fov_y_deg = listed.fov_y_deg;
    scene.animation = {};
    try {
        validate(scene.camera);
    } catch (const InputError& e) {
        throw InputError(fmt::format("{}: camera {}: {}", shown(list.path), listed.name, e.what()));
    }
    return scene;
}

}  // namespace plumb::io
