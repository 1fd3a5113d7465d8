#include "io/make_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/fields.h"
#include "core/nearest_known.h"
#include "io/cornell.h"
#include "io/file.h"
#include "io/glb_write.h"
#include "io/scene_model.h"
#include "io/scene_parts.h"

namespace plumb::io {
namespace {

// The shortest text that TOML reads back as this double.
std::string number(double x) { return std::isinf(x) ? (x < 0 ? "-inf" : "inf") : fmt::format("{}", x); }

// The shortest text that reads back as this float, by way of a double.
std::string number(float x) {
    const std::string text = fmt::format("{}", x);
    double read = 0;
    std::from_chars(text.data(), text.data() + text.size(), read);
    return std::isinf(x) || float(read) == x ? text : number(double(x));
}

template <class Vector>
std::string vector(const Vector& v) {
    return fmt::format("[{}, {}, {}]", number(v.x), number(v.y), number(v.z));
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (char c : text) {
        const unsigned char byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\')
            out += std::string("\\") + c;
        else if (byte < 32 || byte == 127)
            out += fmt::format("\\u{:04x}", byte);
        else
            out += c;
    }
    return out + '"';
}

std::string value_of(const FieldValue& value) {
    if (const double* x = std::get_if<double>(&value)) return number(*x);
    if (const bool* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
    if (const std::string* s = std::get_if<std::string>(&value)) return quoted(*s);
    return vector(std::get<glm::vec3>(value));
}

std::string light_toml(const Light& light, const std::string& name) {
    constexpr const char* types[] = {"spot", "point", "directional"};
    std::string out = fmt::format("\n[[light]]\nname = {}\ntype = \"{}\"\n", quoted(name), types[int(light.type)]);
    out += "position = " + vector(light.position) + "\ndirection = " + vector(light.direction) + "\n";
    if (light.type == LightType::spot)
        out += fmt::format("cone_deg = [{}, {}]\n", number(light.cone_inner_deg), number(light.cone_outer_deg));
    out += fmt::format("intensity = {}  # {}\n", vector(light.intensity),
                       light.type == LightType::directional || light.radius > 0 ? "W/m2" : "W/sr");
    if (light.radius > 0) out += fmt::format("radius = {}\n", number(light.radius));
    if (!light.on) out += "on = false\n";
    return out + fmt::format("rsm_size = {}\n", light.rsm_size);
}

// Tables in the order in which they first occur; of a key that is set twice the last value holds.
std::string settings_toml(const std::vector<Setting>& settings) {
    std::vector<std::string> tables;
    for (const Setting& s : settings)
        if (std::find(tables.begin(), tables.end(), s.table) == tables.end()) tables.push_back(s.table);
    std::string out;
    for (const std::string& table : tables) {
        out += fmt::format("\n[{}]\n", table);
        for (auto at = settings.begin(); at != settings.end(); ++at) {
            const bool is_last = std::none_of(
                at + 1, settings.end(), [&](const Setting& s) { return s.table == table && s.key == at->key; });
            if (at->table == table && is_last) out += fmt::format("{} = {}\n", at->key, value_of(at->value));
        }
    }
    return out;
}

MadeScene counts_of(const Scene& scene, const std::string& file) {
    MadeScene made;
    made.file = file;
    for (const Mesh& mesh : scene.meshes) {
        made.triangles += std::int64_t(mesh.triangles.size());
        made.vertices += std::int64_t(mesh.vertices.size());
    }
    made.meshes = std::int64_t(scene.meshes.size()), made.materials = std::int64_t(scene.materials.size());
    made.textures = std::int64_t(scene.textures.size()), made.lights = std::int64_t(scene.lights.size());
    return made;
}

}  // namespace

std::vector<SceneSummary> scene_summaries() {
    const Scene cornell = generate_model("cornell", {}, "cornell").scene;
    std::vector<SceneSummary> list = {
        {"cornell", "the Cornell box with a spot under its lamp", counts_of(cornell, "").triangles, false}};
    for (const GeneratedScene& s : generated_scenes()) list.push_back({s.name, s.summary, s.triangles, true});
    return list;
}

std::string scene_toml(const Scene& scene, const std::string& mesh_file, const std::string& heading) {
    const Camera& c = scene.camera;
    std::string out = "# " + heading + "\n";
    constexpr const char* conventions[] = {"vulkan", "opengl", "d3d11", "d3d9", "left_handed"};
    if (scene.convention != Convention::vulkan)
        out += fmt::format("convention = \"{}\"\n", conventions[int(scene.convention)]);
    if (c.reversed_z) out += "reversed_z = true\n";
    out += fmt::format("seed = {}\n", scene.seed);
    out += fmt::format("\n[frame]\nsize = [{}, {}]\n", scene.frame_size.x, scene.frame_size.y);
    out += "\n[camera]\nposition = " + vector(c.position) + "\nlook_at = " + vector(c.look_at) + "\nup = " +
           vector(c.up) + "\nfov_y_deg = " + number(c.fov_y_deg) + "\nnear = " + number(c.near) +
           "\nfar = " + number(c.far) + "\n";
    out += "\n[[mesh]]\nfile = " + quoted(mesh_file) + "\n";
    std::vector<Light> named;
    for (const Light& light : scene.lights) {
        const std::string name = layer_name(light.name, named);
        out += light_toml(light, name);
        named.push_back(light);
        named.back().name = name;
    }
    if (scene.environment.radiance != glm::vec3(0))
        out += "\n[environment]\nradiance = " + vector(scene.environment.radiance) + "\n";
    out += fmt::format("\n[render]\nmethod = {}\nlayout = {}\n", quoted(scene.method), quoted(scene.layout));
    return out + settings_toml(scene.settings);
}

MadeScene make_scene(const std::string& name, const std::string& folder, const GenerateOptions& options) {
    const std::vector<std::string> names = model_names();
    if (std::find(names.begin(), names.end(), name) == names.end())
        throw InputError("make-scene: unknown scene \"" + printable(name) + "\"" + nearest_known(name, names, "\"\""));
    const SceneModel model = generate_model(name, options, "make-scene");
    make_folder(folder);
    const std::string file = beside(folder + "/", name + ".toml");
    if (name == "cornell") {
        write_text(beside(file, "cornell.obj"), cornell_obj());
        write_text(beside(file, "cornell.mtl"), cornell_mtl());
        write_text(file, cornell_toml());
        MadeScene made = counts_of(model.scene, file);
        made.lights = 1;
        return made;
    }
    std::string command = "plumb make-scene " + name;
    if (options.triangles != 0) command += fmt::format(" --triangles {}", options.triangles);
    if (options.seed != 1) command += fmt::format(" --seed {}", options.seed);
    write_glb(beside(file, name + ".glb"), model.scene);
    write_text(file, scene_toml(model.scene, name + ".glb", command));
    return counts_of(model.scene, file);
}

}  // namespace plumb::io
