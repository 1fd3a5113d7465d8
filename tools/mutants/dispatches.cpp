#include "tools/mutants/dispatches.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "core/error.h"
#include "core/hash.h"
#include "gi/compose/compose.h"
#include "gi/filter/filter.h"
#include "gi/frame/frame.h"
#include "gi/frame/probe_bake.h"
#include "gi/parity/stages.h"
#include "io/document.h"
#include "io/scene_file.h"
#include "tests/parity/twin_data.h"
#include "tools/mutants/quads.h"
#include "tools/mutants/ties.h"

namespace plumb::mutants {
namespace {

// A panel of tests/parity/panels.toml.
struct Panel {
    std::string name, scene, place;
    glm::ivec2 size{0};
    int maps = 0;
    double radius = 0;
    std::vector<std::string> settings, ties, off;
};

std::vector<std::string> words_of(io::DocumentReader& reader, const std::string& key) {
    std::vector<std::string> out;
    if (const io::DocumentValue* list = reader.find(key))
        for (const io::DocumentValue& v : list->list) out.push_back(v.text);
    return out;
}

std::vector<Panel> read_panels(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(file.string() + ": cannot be read");
    std::ostringstream text;
    text << in.rdbuf();
    const std::string path = file.filename().string();
    const io::DocumentValue document = io::parse_document(path, text.str());
    io::DocumentReader all(document, path, "");
    std::vector<Panel> out;
    for (const io::DocumentValue* table : all.tables("panel")) {
        io::DocumentReader reader(*table, path, "panel");
        Panel p;
        p.place = reader.place(), p.name = reader.filled("name", ""), p.scene = reader.filled("scene", "box");
        const io::DocumentValue* size = reader.find("size");
        if (!size || size->list.size() != 2) reader.fail("size", "must be two numbers");
        p.size = {int(size->list[0].integer), int(size->list[1].integer)};
        p.maps = int(reader.integer("maps", 0, 0, 4096));
        p.radius = reader.number("radius", 0, 0, 1e9);
        p.settings = words_of(reader, "settings"), p.ties = words_of(reader, "ties");
        p.off = words_of(reader, "off");
        reader.finish();
        out.push_back(std::move(p));
    }
    all.finish();
    return out;
}

std::string trimmed(const std::string& word) {
    const std::size_t first = word.find_first_not_of(' '), last = word.find_last_not_of(' ');
    return first == std::string::npos ? "" : word.substr(first, last - first + 1);
}

FieldValue value_of(const std::string& word) {
    glm::vec3 v;
    if (std::sscanf(word.c_str(), "[%f, %f, %f]", &v.x, &v.y, &v.z) == 3) return v;
    if (word == "true" || word == "false") return word == "true";
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (end != word.c_str() && *end == 0) return number;
    return word;
}

// "table.key = value", as a scene file has it.
void set(Scene& scene, const std::string& setting, const std::string& place) {
    const std::size_t dot = setting.find('.'), equals = setting.find('=');
    if (dot == std::string::npos || equals == std::string::npos || equals < dot)
        throw InputError(place + ": \"" + setting + "\": expected table.key = value");
    const std::string table = setting.substr(0, dot), key = trimmed(setting.substr(dot + 1, equals - dot - 1)),
                      value = trimmed(setting.substr(equals + 1));
    if (table == "render" && key == "method")
        scene.method = value;
    else if (table == "render" && key == "layout")
        scene.layout = value;
    else
        scene.settings.push_back({table, key, value_of(value), place + ": " + setting});
}

// A spot with a wide penumbra, a lamp that shines everywhere, and a sun through the open side.
std::vector<Light> three_lights() {
    Light key, bulb, sun;
    key.name = "key", key.position = {0, 1.97f, 0}, key.direction = {0.1f, -0.99f, -0.1f};
    key.direction = normalize3<float>(key.direction);
    key.cone_inner_deg = 25, key.cone_outer_deg = 60, key.intensity = {12, 11, 9}, key.rsm_size = 48;
    bulb.name = "bulb", bulb.type = LightType::point, bulb.position = {-0.45f, 1.3f, 0.4f};
    bulb.intensity = {1, 1.5f, 2}, bulb.rsm_size = 40;
    sun.name = "sun", sun.type = LightType::directional, sun.direction = normalize3<float>(glm::vec3(0.3f, -0.5f, -1));
    sun.intensity = {2, 2, 1.5f}, sun.rsm_size = 48;
    return {key, bulb, sun};
}

Scene box(const std::filesystem::path& source) {
    Scene scene = io::load_scene((source / "data/scenes/cornell_small.toml").string(), frame::method_tables());
    scene.settings.clear();
    scene.lights = three_lights();
    return scene;
}

// For the z-buffer techniques: highlights from dull to sharp, and meshes of which normals, and light as it is printed, are turned and
// scaled.
void gloss(Scene& scene) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        Material& m = scene.materials[i];
        m.specular = {0.3f + 0.1f * float(i % 3), 0.4f, 0.5f - 0.1f * float(i % 2)}, m.exponent = 2 + 3 * float(i % 5);
    }
    for (Mesh& mesh : scene.meshes) {
        mesh.transform[0] *= 1.25, mesh.transform[1] *= 0.875;
        mesh.transform[1].x += 0.125, mesh.transform[2].y -= 0.0625;
    }
}

// For reflections: all surfaces mirror, but every third kind, and have lobes from dull to sharp, but every fourth.
void polish(Scene& scene) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        Material& m = scene.materials[i];
        if (i % 3 != 2) m.mirror = 0.5f * (glm::vec3(1) - m.reflectance);
        if (i % 4 != 3) m.specular = 0.25f * (glm::vec3(1) - m.reflectance), m.exponent = 2 + 15 * float(i % 5);
    }
}

// Every stage of the panel's frame.
void append(const Panel& panel, const std::filesystem::path& source, std::vector<Dispatch>& out) {
    Scene scene = panel.scene == "quads" ? quads() : box(source);
    scene.frame_size = panel.size;
    for (Light& light : scene.lights) {
        if (panel.maps > 0) light.rsm_size = panel.maps;
        if (panel.radius > 0 && light.type != LightType::directional) light.radius = float(panel.radius);
        if (std::find(panel.off.begin(), panel.off.end(), light.name) != panel.off.end()) light.on = false;
    }
    for (const std::string& setting : panel.settings) set(scene, setting, panel.place);
    frame::Settings settings = frame::settings_of(scene);
    if (settings.method == frame::Method::zbuffer) gloss(scene);
    if (settings.reflect.march != screen::March::off) polish(scene);
    frame::add_bake(scene, settings);
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame frame = frame::execute(scene, settings, plan, {});
    for (StageData& data : parity::frame_data(scene, settings, plan, frame)) {
        const bool tied = std::find(panel.ties.begin(), panel.ties.end(), data.stage) != panel.ties.end();
        if (tied && data.id.find(".bulb.") == std::string::npos) {
            out.push_back({panel.name + " with ties: " + data.id, data});
            plant_ties(out.back().data);
        }
        out.push_back({panel.name + ": " + data.id, std::move(data)});
    }
}

// Frames of one scene have stages in common.
void drop_repeated(std::vector<Dispatch>& all) {
    std::set<std::uint64_t> met;
    std::erase_if(all, [&](const Dispatch& d) {
        std::string bytes = d.data.stage + std::to_string(d.data.size.x) + "x" + std::to_string(d.data.size.y);
        bytes.append(d.data.uniforms.begin(), d.data.uniforms.end());
        for (const Array& a : d.data.inputs.arrays) bytes.append(a.bytes.begin(), a.bytes.end());
        return !met.insert(std::hash<std::string>()(bytes)).second;
    });
}

// A number of any size up to 2^high, of both signs now and then, or 0.
float any_size(std::uint32_t i, int low, int high) {
    const std::uint32_t h = pcg<std::uint32_t>(i);
    if (h % 29 == 0) return 0;
    const std::uint32_t exponent = std::uint32_t(127 + low) + (h >> 3) % std::uint32_t(high - low);
    const float size = std::bit_cast<float>(exponent << 23 | h >> 9);
    return h % 23 == 0 ? -size : size;
}

Image4 any_image(glm::ivec2 size, std::uint32_t seed, int low, int high) {
    Image4 image(size.x, size.y);
    for (std::size_t i = 0; i < image.size(); ++i)
        for (int c = 0; c < 4; ++c) image.data()[i][c] = any_size(seed + std::uint32_t(4 * i) + std::uint32_t(c), low, high);
    return image;
}

void append_values(std::vector<Dispatch>& out) {
    const glm::ivec2 size(72, 64);
    const Image4 normal = any_image(size, 100000, -1, 1), albedo = any_image(size, 200000, -6, 0),
                 emission = any_image(size, 300000, -3, 4), direct = any_image(size, 400000, -12, 10),
                 indirect = any_image(size, 500000, -14, 8), radiance = any_image(size, 600000, -16, 8);
    const compose::ComposeInputs inputs{&normal, &albedo, &emission, &direct, &indirect, glm::vec3(0.3f, 0.5f, 0.9f)};
    auto keep = [&](const std::string& name, StageData data) {
        data.label = data.id = data.stage;
        out.push_back({name, owned(parity::find_binding(data.stage, name), data)});
    };
    for (const glm::vec3 shadow_color : {glm::vec3(0), glm::vec3(0.5f, 0.2f, 0.7f)}) {
        keep("values: compose", compose::data_of(compose::ComposeParams{shadow_color}, inputs));
    }
    const std::pair<const char*, compose::Operator> operators[] = {{"exposure", compose::Operator::exposure},
                                                                   {"clamp", compose::Operator::clamp},
                                                                   {"reinhard", compose::Operator::reinhard},
                                                                   {"filmic", compose::Operator::filmic}};
    for (const auto& [name, op] : operators) {
        keep(std::string("values: tonemap ") + name,
             compose::data_of(compose::TonemapParams{op, 0.7f}, compose::TonemapInputs{&radiance}));
    }
    keep("values: tonemap by figure A.1", compose::data_of(compose::TonemapParams{compose::Operator::exposure, 2, 0.3f, 2.1f, 1.58f},
                                                           compose::TonemapInputs{&radiance}));
}

// Surfaces that fill an odd frame up to its borders, at two depths and turned two ways, with holes where nothing is seen
// but where some light lies.
void append_surfaces(std::vector<Dispatch>& out) {
    const glm::ivec2 size(37, 29);
    Image4 position(size.x, size.y), normal(size.x, size.y), irradiance(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const std::uint32_t h = pcg<std::uint32_t>(std::uint32_t(y * size.x + x));
            for (int c = 0; c < 3; ++c) irradiance(x, y)[c] = 0.5f + float(h >> (8 * c) & 0xff) / 256;
            if (h % 7 == 0) continue;  // nothing is seen
            const bool near = h % 5 < 2;
            const float depth = (near ? 1.0f : 4.0f) + 0.01f * float(x) + 0.02f * float(y);
            position(x, y) = glm::vec4(0.1f * float(x), 0.1f * float(y), -depth, depth);
            normal(x, y) = glm::vec4(near ? glm::vec3(0, 0, 1) : glm::vec3(0.6f, 0, 0.8f), 1);
            irradiance(x, y).w = depth;
        }
    auto keep = [&](const std::string& name, StageData data) {
        data.label = data.id = data.stage;
        out.push_back({"surfaces: " + name, owned(parity::find_binding(data.stage, name), data)});
    };
    keep("reduce", filter::data_of({}, filter::ReduceInputs{&irradiance}));
    filter::FilterParams params;
    params.kernel = 5;
    keep("blur", filter::data_of(params, filter::BlurInputs{&irradiance, &position, &normal}));
    Image4 coarse_irradiance, coarse_position, coarse_normal;
    filter::run(params, filter::ReduceInputs{&irradiance}, {}, coarse_irradiance);
    filter::run(params, filter::ReduceInputs{&position}, {}, coarse_position);
    filter::run(params, filter::ReduceInputs{&normal}, {}, coarse_normal);
    const filter::UpsampleInputs in{&coarse_irradiance, &coarse_position, &coarse_normal, &position, &normal};
    keep("upsample", filter::data_of(params, in));
    params.similarity = filter::Similarity::depth;
    keep("upsample by depth", filter::data_of(params, in));
}

}  // namespace

std::vector<Dispatch> dispatches(const std::filesystem::path& source) {
    std::vector<Dispatch> out;
    for (const Panel& panel : read_panels(source / "tests/parity/panels.toml")) append(panel, source, out);
    for (StageData& data : test::compute_cases({37, 23})) out.push_back({"by hand: " + data.id, std::move(data)});
    append_values(out);
    append_surfaces(out);
    drop_repeated(out);
    return out;
}

}  // namespace plumb::mutants
