#include "io/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"
#include "io/mtl.h"
#include "io/named_file.h"
#include "io/obj_lines.h"
#include "io/text_scan.h"
#include "io/triangulate.h"

namespace plumb::io {
namespace {

// What a vertex is made of: a corner, and how its material takes texture coordinates.
struct Key {
    Corner corner;
    std::int32_t mapping;  // 0: as they are
    friend bool operator==(const Key& a, const Key& b) { return a.corner == b.corner && a.mapping == b.mapping; }
};

struct KeyHash {
    std::size_t operator()(const Key& k) const {
        std::uint64_t h = std::uint32_t(k.corner.position);
        for (const std::int32_t i : {k.corner.texture, k.corner.normal, k.mapping})
            h = h * 0x9e3779b97f4a7c15u + std::uint32_t(i);
        return std::size_t(h ^ h >> 29);
    }
};

// Unit length, computed in double after scaling by the largest component; zero where there is no direction.
glm::vec3 normalised(const glm::dvec3& v) {
    const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    if (!(largest > 0)) return glm::vec3(0);
    const glm::dvec3 s = v / largest;
    return glm::vec3(s / std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z));
}

glm::vec3 geometric_normal(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const glm::dvec3 u = glm::dvec3(b) - glm::dvec3(a), v = glm::dvec3(c) - glm::dvec3(a);
    const glm::vec3 n = normalised({u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x});
    // A triangle without area covers no pixel; its normal only has to be one.
    return n == glm::vec3(0) ? glm::vec3(0, 1, 0) : n;
}

// Puts vertices and triangles together. Corners that agree in all three indices share a vertex, unless the normal is
// the triangle's own.
class ObjBuilder {
  public:
    ObjBuilder(const std::string& path, const ObjLines& in, Mesh& mesh) : path_(path), in_(in), mesh_(mesh) {
        normals_.reserve(in.normals.size());
        for (const glm::vec3& n : in.normals) normals_.push_back(normalised(glm::dvec3(n)));
    }

    void add(std::size_t f, std::int32_t material, const Mapping& mapping) {
        const std::size_t first = in_.faces[f].first;
        const std::size_t end = f + 1 < in_.faces.size() ? in_.faces[f + 1].first : in_.corners.size();
        line_ = in_.faces[f].line;
        polygon_.clear(), triangles_.clear();
        for (std::size_t i = first; i < end; ++i)
            polygon_.push_back(in_.positions[std::size_t(in_.corners[i].position)]);
        if (!triangulate(polygon_, triangles_))
            throw InputError(
                shown(path_), fmt::format("line {}", line_),
                fmt::format("a concave face of {} corners; the limit is {}", polygon_.size(), max_concave_corners));
        for (const auto& t : triangles_) {
            const glm::vec3 flat = geometric_normal(polygon_[t[0]], polygon_[t[1]], polygon_[t[2]]);
            glm::uvec3 triangle;
            for (int k = 0; k < 3; ++k) triangle[k] = vertex(in_.corners[first + t[std::size_t(k)]], flat, mapping);
            mesh_.triangles.push_back(triangle);
            mesh_.material.push_back(material);
        }
    }

  private:
    std::uint32_t vertex(const Corner& c, const glm::vec3& flat, const Mapping& mapping) {
        const bool own = c.normal >= 0 && normals_[std::size_t(c.normal)] != glm::vec3(0);
        if (own) {
            const Key key{c, mapping == Mapping{} ? 0 : number_of(mapping)};
            const auto [at, is_new] = index_of_.try_emplace(key, std::uint32_t(mesh_.vertices.size()));
            if (!is_new) return at->second;
        }
        Vertex v;
        v.position = in_.positions[std::size_t(c.position)];
        v.normal = own ? normals_[std::size_t(c.normal)] : flat;
        if (c.texture >= 0) {
            // OBJ counts v from the bottom of the picture.
            glm::vec2 uv = in_.texture_coordinates[std::size_t(c.texture)];
            if (!(mapping == Mapping{})) uv = moved(uv, mapping);
            v.u = uv.x, v.v = 1 - uv.y;
        }
        mesh_.vertices.push_back(v);
        return std::uint32_t(mesh_.vertices.size()) - 1;
    }

    glm::vec2 moved(const glm::vec2& uv, const Mapping& mapping) const {
        const glm::vec2 to(glm::dvec2(uv) * mapping.scale + mapping.offset);
        if (!std::isfinite(to.x) || !std::isfinite(to.y))
            throw InputError(shown(path_), fmt::format("line {}", line_),
                             fmt::format("f: vt {} {} is not finite once -s and -o of its material have moved it", uv.x, uv.y));
        return to;
    }

    std::int32_t number_of(const Mapping& mapping) {
        auto at = std::find(mappings_.begin(), mappings_.end(), mapping);
        if (at == mappings_.end()) at = mappings_.insert(at, mapping);
        return std::int32_t(at - mappings_.begin()) + 1;
    }

    const std::string& path_;
    const ObjLines& in_;
    Mesh& mesh_;
    std::int64_t line_ = 0;  // of the face
    std::vector<Mapping> mappings_;
    std::vector<glm::vec3> normals_;
    std::vector<glm::vec3> polygon_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::unordered_map<Key, std::uint32_t, KeyHash> index_of_;
};

// Puts the model together from what the lines say.
class ObjReader {
  public:
    ObjReader(const std::string& path, const ReadLibrary& read_library, bool strict)
        : path_(path), read_library_(read_library), findings_(strict) {}

    ObjModel read(const std::string& text) {
        if (text.empty()) throw InputError(shown(path_), "", "is empty; expected an OBJ");
        lines_ = scan_obj(path_, text, findings_);
        if (lines_.faces.empty()) throw InputError(shown(path_), "", "holds no face (f): " + what_it_holds());
        for (const auto& [names, line] : lines_.libraries.list) read_libraries(names, line);
        for (MtlMaterial& m : materials_) model_.materials.push_back(std::move(m.material));
        const std::vector<std::int32_t> material_of_name = resolve_materials();
        if (std::any_of(lines_.faces.begin(), lines_.faces.end(), [](const Face& f) { return f.material < 0; }))
            add_default("default");
        build(material_of_name);
        say_what_is_left_out();
        return std::move(model_);
    }

  private:
    std::string what_it_holds() const {
        std::string text = fmt::format("{} vertices, {} statements of points, {} of lines, {} of free-form curves and surfaces",
                                       lines_.positions.size(), lines_.points, lines_.lines, lines_.surfaces);
        const std::vector<std::string> found = findings_.notes();
        return found.empty() ? text : text + "; " + found[0].substr(found[0].find(": ") + 2);
    }

    // One file whose name may hold blanks, or several.
    void read_libraries(const std::string& names, std::int64_t line) {
        if (const auto whole = read_library_(names, line, nullptr)) return add(*whole);
        std::string_view rest = names;
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
            const std::string name(word);
            if (const auto one = read_library_(name, line, &findings_)) {
                add(*one);
            } else {
                findings_.add("library", path_, line, fmt::format("mtllib: there is no file \"{}\"", printable(name)),
                              "materials that only it has are grey, 0.5");
            }
        }
    }

    void add(const Library& library) {
        if (!libraries_.insert(library.file).second) return;
        for (MtlMaterial& m : parse_mtl(library.file, as_utf8(library.file, library.text), folder_of(path_), model_, findings_))
            materials_.push_back(std::move(m));
    }

    void add_default(const std::string& name) {
        model_.materials.push_back({});
        model_.materials.back().name = name;
    }

    // Index of each name of usemtl into the model's materials; a name that no library has gets a material of its own, so
    // that a scene file can describe it.
    std::vector<std::int32_t> resolve_materials() {
        std::map<std::string, std::int32_t> index;
        for (std::size_t i = 0; i < model_.materials.size(); ++i)
            index.try_emplace(model_.materials[i].name, std::int32_t(i));
        std::vector<std::int32_t> indices;
        for (const auto& [name, line] : lines_.materials.list) {
            const auto at = index.find(name);
            if (at == index.end()) report_unknown(name, line);
            indices.push_back(at == index.end() ? std::int32_t(model_.materials.size()) : at->second);
            if (at == index.end()) add_default(name);
        }
        return indices;
    }

    void report_unknown(const std::string& name, std::int64_t line) {
        std::vector<std::string> known;
        for (std::size_t i = 0; i < materials_.size(); ++i) known.push_back(model_.materials[i].name);
        findings_.add("material", path_, line,
                      fmt::format("usemtl: unknown material \"{}\"{}", printable(name),
                                  known.empty() ? "; no mtllib gives any" : shown(nearest_known(name, known, "\"\""))),
                      "it is grey, 0.5");
    }

    void build(const std::vector<std::int32_t>& material_of_name) {
        model_.mesh.name = stem_of(path_);
        ObjBuilder builder(path_, lines_, model_.mesh);
        const std::int32_t none = std::int32_t(model_.materials.size()) - 1;
        for (std::size_t f = 0; f < lines_.faces.size(); ++f) {
            const std::int32_t name = lines_.faces[f].material;
            const std::int32_t material = name < 0 ? none : material_of_name[std::size_t(name)];
            const bool described = std::size_t(material) < materials_.size();
            builder.add(f, material, described ? materials_[std::size_t(material)].mapping : Mapping{});
        }
        model_.has_texture_coordinates =
            std::any_of(lines_.corners.begin(), lines_.corners.end(), [](const Corner& c) { return c.texture >= 0; });
    }

    void say_what_is_left_out() {
        std::vector<std::string> notes = findings_.notes();
        notes.insert(notes.end(), model_.notes.begin(), model_.notes.end());
        if (lines_.coloured > 0)
            notes.push_back(fmt::format("{}: the colours of {} vertices are not read", shown(path_), lines_.coloured));
        if (lines_.points + lines_.lines > 0)
            notes.push_back(fmt::format("{}: points and lines are not drawn ({} and {} statements)", shown(path_), lines_.points,
                                        lines_.lines));
        model_.notes = std::move(notes);
    }

    const std::string& path_;
    const ReadLibrary& read_library_;
    Findings findings_;
    ObjLines lines_;
    std::vector<MtlMaterial> materials_;  // of all libraries
    std::set<std::string> libraries_;     // read already
    ObjModel model_;
};

}  // namespace

ObjModel parse_obj(const std::string& path, const std::string& text, const ReadLibrary& read_library, bool strict) {
    return ObjReader(path, read_library, strict).read(as_utf8(path, text));
}

ObjModel read_obj(const std::string& path, bool strict) {
    const ReadLibrary from_file = [&](const std::string& name, std::int64_t line, Findings* findings) -> std::optional<Library> {
        const std::string file = findings ? find_similar(path, line, name, "", *findings) : find_named(path, name, "");
        if (file.empty()) return {};
        try {
            return Library{file, read_text(file)};
        } catch (const InputError& e) {
            throw InputError(shown(path), fmt::format("line {}", line), std::string("mtllib: ") + e.what());
        }
    };
    return parse_obj(path, read_text(path), from_file, strict);
}

}  // namespace plumb::io
