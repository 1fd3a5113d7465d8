#include "io/coloured_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "io/file.h"
#include "io/glb_parts.h"

namespace plumb::io {
namespace {

void check(const std::string& path, const std::vector<ColouredMesh>& meshes) {
    for (const ColouredMesh& m : meshes)
        for (std::size_t i = 0; i < m.position.size(); ++i) {
            const glm::vec3 all = m.position[i] + m.normal[i] + m.radiosity[i] + m.irradiance[i];
            if (!std::isfinite(all.x + all.y + all.z))
                throw InputError(shown(path), "", fmt::format("cannot be written: vertex {} of mesh \"{}\" is not finite", i, printable(m.name)));
        }
}

class ColouredGlb : GlbParts {
  public:
    ColouredGlb(const std::string& path, const std::vector<ColouredMesh>& meshes, float scale) : GlbParts(path) {
        json_["asset"]["extras"]["plumb"] = {{"colour_scale", double(scale)},
                                             {"COLOR_0", "linear: min(1, colour_scale * _RADIOSITY)"},
                                             {"_RADIOSITY", "W/m2"},
                                             {"_IRRADIANCE", "W/m2"}};
        add_material();
        for (const ColouredMesh& m : meshes)
            if (!m.triangles.empty()) add(m, scale);
        write_chunks();
    }

  private:
    void add_material() {
        use_extension("KHR_materials_unlit");
        Json material = {{"name", "radiosity"}};
        material["pbrMetallicRoughness"] = {{"baseColorFactor", {1.0, 1.0, 1.0, 1.0}}, {"metallicFactor", 0.0}};
        material["extensions"]["KHR_materials_unlit"] = Json::object();
        json_["materials"].push_back(std::move(material));
    }
    void add(const ColouredMesh& m, float scale) {
        std::vector<glm::vec3> colour;
        for (const glm::vec3& b : m.radiosity) colour.push_back(glm::min(glm::vec3(1), scale * b));
        Json attributes;
        attributes["POSITION"] = add_positions(m.position);
        attributes["NORMAL"] = add_accessor(m.normal, "VEC3", f32, vertices);
        attributes["COLOR_0"] = add_accessor(colour, "VEC3", f32, vertices);
        attributes["_RADIOSITY"] = add_accessor(m.radiosity, "VEC3", f32, vertices);
        attributes["_IRRADIANCE"] = add_accessor(m.irradiance, "VEC3", f32, vertices);
        const std::size_t triangles = add_accessor(m.triangles, "SCALAR", u32, indices);
        json_["accessors"].back()["count"] = 3 * m.triangles.size();
        const Json primitive = {{"attributes", attributes}, {"indices", triangles}, {"material", 0}};
        json_["meshes"].push_back({{"name", m.name}, {"primitives", Json::array({primitive})}});
        add_node({{"name", m.name}, {"mesh", json_["meshes"].size() - 1}});
    }
};

// A group's name is one word.
std::string one_word(const std::string& name) {
    std::string word = printable(name, 1000);
    std::replace(word.begin(), word.end(), ' ', '_');
    return word.empty() ? "mesh" : word;
}

std::string obj_text(const std::vector<ColouredMesh>& meshes, float scale) {
    std::string text = fmt::format("# v x y z r g b: m; r g b linear, radiosity in W/m2 times {}\n", scale);
    std::size_t first = 1;
    const auto to = std::back_inserter(text);
    for (const ColouredMesh& m : meshes) {
        if (m.triangles.empty()) continue;
        fmt::format_to(to, "g {}\n", one_word(m.name));
        for (std::size_t i = 0; i < m.position.size(); ++i) {
            const glm::vec3 p = m.position[i], c = scale * m.radiosity[i];
            fmt::format_to(to, "v {} {} {} {} {} {}\n", p.x, p.y, p.z, c.x, c.y, c.z);
        }
        for (const glm::vec3& n : m.normal) fmt::format_to(to, "vn {} {} {}\n", n.x, n.y, n.z);
        for (const glm::uvec3& t : m.triangles) {
            const std::size_t a = first + t.x, b = first + t.y, c = first + t.z;
            fmt::format_to(to, "f {}//{} {}//{} {}//{}\n", a, a, b, b, c, c);
        }
        first += m.position.size();
    }
    return text;
}

}  // namespace

void require_coloured_name(const std::string& path) {
    const std::string extension = extension_of(path);
    if (extension != "glb" && extension != "obj") throw InputError(shown(path), "", "expected a name that ends in .glb or .obj");
}

void write_coloured(const std::string& path, const std::vector<ColouredMesh>& meshes, float scale) {
    require_coloured_name(path);
    check(path, meshes);
    if (extension_of(path) == "glb")
        ColouredGlb(path, meshes, scale);
    else
        write_text(path, obj_text(meshes, scale));
}

}  // namespace plumb::io
