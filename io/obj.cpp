#include "io/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"
#include "io/text_scan.h"
#include "io/triangulate.h"

namespace plumb::io {
namespace {

constexpr std::size_t max_triangles = std::size_t(1) << 28;

// Indices from 0 of a position, a texture coordinate and a normal; -1: none.
struct Corner {
    std::int32_t position = -1, texture = -1, normal = -1;
    friend bool operator==(const Corner& a, const Corner& b) {
        return a.position == b.position && a.texture == b.texture && a.normal == b.normal;
    }
};

struct CornerHash {
    std::size_t operator()(const Corner& c) const {
        std::uint64_t h = std::uint32_t(c.position);
        h = h * 0x9e3779b97f4a7c15u + std::uint32_t(c.texture);
        h = h * 0x9e3779b97f4a7c15u + std::uint32_t(c.normal);
        return std::size_t(h ^ h >> 29);
    }
};

struct Face {
    std::size_t first;  // of its corners
    std::int64_t line;
    std::int32_t material;  // index into used names; -1: none
};

// Names, each once and with the line where it first occurs.
struct Names {
    std::vector<std::pair<std::string, std::int64_t>> list;
    std::map<std::string, std::int32_t> index;
};

// What the lines say, before any of it is put together.
struct Lines {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> texture_coordinates;
    std::vector<Corner> corners;
    std::vector<Face> faces;
    Names libraries, materials;  // of mtllib, of usemtl
};

class ObjScanner {
  public:
    explicit ObjScanner(const std::string& path) : path_(path) {}

    [[noreturn]] void fail(std::int64_t line, const std::string& cause) const {
        throw InputError(shown(path_), fmt::format("line {}", line), cause);
    }

    Lines scan(std::string_view text) {
        LineScanner scanner(text);
        std::string joined;
        for (std::string_view line; scanner.next(line);) {
            line_ = scanner.number();
            // A backslash at the end goes on in the next line.
            if (!line.empty() && line.back() == '\\') {
                joined = line;
                while (!joined.empty() && joined.back() == '\\') {
                    joined.back() = ' ';
                    std::string_view more;
                    if (scanner.next(more)) joined += more;
                }
                line = joined;
            }
            const std::string_view key = next_word(line);
            if (!key.empty() && key[0] != '#') read(key, line);
        }
        check_indices();
        return std::move(out_);
    }

  private:
    void read(std::string_view key, std::string_view rest) {
        // A comment may follow numbers; a name may hold the sign.
        if (key[0] == 'v' || key == "f") rest = rest.substr(0, rest.find('#'));
        if (key == "v") return out_.positions.push_back(numbers<3>(key, rest, 3));
        if (key == "vn") return out_.normals.push_back(numbers<3>(key, rest, 3));
        if (key == "vt") return out_.texture_coordinates.push_back(glm::vec2(numbers<3>(key, rest, 1)));
        if (key == "f") return face(rest);
        if (key == "usemtl") {
            material_ = remember(out_.materials, key, rest);
            return;
        }
        if (key == "mtllib") {
            remember(out_.libraries, key, rest);
            return;
        }
        static constexpr std::string_view ignored[] = {"o",     "g",        "s",        "l",          "p",
                                                       "vp",    "mg",       "lod",      "usemap",     "maplib",
                                                       "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"};
        if (std::find(std::begin(ignored), std::end(ignored), key) != std::end(ignored)) return;
        static constexpr std::string_view refused[] = {"cstype", "deg",  "bmat",  "step",  "curv", "curv2",
                                                       "surf",   "parm", "trim",  "hole",  "scrv", "sp",
                                                       "end",    "con",  "ctech", "stech", "call", "csh"};
        if (std::find(std::begin(refused), std::end(refused), key) != std::end(refused))
            fail(line_, "\"" + std::string(key) + "\": free-form surfaces and calls of other files are not read");
        fail(line_, "\"" + printable(key) + "\" is not a statement of OBJ");
    }

    // At least `least` of N finite numbers, the rest 0. What stands behind them (a weight, a colour) must be numbers
    // too.
    template <int N>
    glm::vec3 numbers(std::string_view key, std::string_view rest, int least) const {
        glm::vec3 value(0);
        int n = 0;
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest), ++n) {
            const auto number = parse_float(word);
            if (!number) fail(line_, fmt::format("{}: \"{}\" is not a number", key, printable(word)));
            if (!std::isfinite(*number))
                fail(line_, fmt::format("{}: {} is not a finite number of 32 bits", key, printable(word)));
            if (n < N) value[n] = *number;
        }
        if (n < least) fail(line_, fmt::format("{} has {} numbers; expected {}", key, n, least));
        return value;
    }

    // Positive indices count from 1; negative ones back from the last so far. Whether the list is long enough is seen
    // at the end: faces may stand before their vertices.
    std::int32_t index(std::string_view text, std::size_t so_far, const char* what) const {
        const auto i = parse_integer(text);
        if (!i) fail(line_, fmt::format("f: \"{}\" is not an index", printable(text)));
        if (*i == 0) fail(line_, fmt::format("f: {} 0; indices count from 1", what));
        if (*i < -std::int64_t(so_far) || *i > std::int64_t(std::numeric_limits<std::int32_t>::max()))
            fail(line_, fmt::format("f: {} {} is out of range; there are {} so far", what, *i, so_far));
        return std::int32_t(*i > 0 ? *i - 1 : std::int64_t(so_far) + *i);
    }

    Corner corner(std::string_view word) const {
        Corner c;
        const std::size_t slash = word.find('/');
        c.position = index(word.substr(0, slash), out_.positions.size(), "vertex");
        if (slash == word.npos) return c;
        const std::string_view rest = word.substr(slash + 1);
        const std::size_t second = rest.find('/');
        const std::string_view texture = rest.substr(0, second);
        if (!texture.empty()) c.texture = index(texture, out_.texture_coordinates.size(), "texture coordinate");
        if (second != rest.npos) c.normal = index(rest.substr(second + 1), out_.normals.size(), "normal");
        return c;
    }

    void face(std::string_view rest) {
        const std::size_t first = out_.corners.size();
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
            out_.corners.push_back(corner(word));
        const std::size_t n = out_.corners.size() - first;
        if (n < 3) fail(line_, fmt::format("f has {} corners; a face has at least 3", n));
        if (out_.corners.size() - 2 * out_.faces.size() > max_triangles)
            fail(line_, fmt::format("more than {} triangles", max_triangles));
        out_.faces.push_back({first, line_, material_});
    }

    std::int32_t remember(Names& names, std::string_view key, std::string_view rest) {
        const std::string name(trimmed(rest));
        if (name.empty()) fail(line_, std::string(key) + " names nothing");
        const auto [at, is_new] = names.index.try_emplace(name, std::int32_t(names.list.size()));
        if (is_new) names.list.emplace_back(name, line_);
        return at->second;
    }

    void check_indices() const {
        auto check = [&](std::int32_t i, std::size_t size, std::int64_t line, const char* what) {
            if (i >= 0 && std::size_t(i) >= size)
                fail(line, fmt::format("f: {} {} is out of range; the file has {}", what, std::int64_t(i) + 1, size));
        };
        for (std::size_t f = 0; f < out_.faces.size(); ++f) {
            const std::size_t end = f + 1 < out_.faces.size() ? out_.faces[f + 1].first : out_.corners.size();
            for (std::size_t i = out_.faces[f].first; i < end; ++i) {
                const Corner& c = out_.corners[i];
                check(c.position, out_.positions.size(), out_.faces[f].line, "vertex");
                check(c.texture, out_.texture_coordinates.size(), out_.faces[f].line, "texture coordinate");
                check(c.normal, out_.normals.size(), out_.faces[f].line, "normal");
            }
        }
    }

    const std::string& path_;
    Lines out_;
    std::int64_t line_ = 0;
    std::int32_t material_ = -1;
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
    ObjBuilder(const std::string& path, const Lines& in, Mesh& mesh) : path_(path), in_(in), mesh_(mesh) {
        normals_.reserve(in.normals.size());
        for (const glm::vec3& n : in.normals) normals_.push_back(normalised(glm::dvec3(n)));
    }

    void add(std::size_t f, std::int32_t material) {
        const std::size_t first = in_.faces[f].first;
        const std::size_t end = f + 1 < in_.faces.size() ? in_.faces[f + 1].first : in_.corners.size();
        polygon_.clear(), triangles_.clear();
        for (std::size_t i = first; i < end; ++i)
            polygon_.push_back(in_.positions[std::size_t(in_.corners[i].position)]);
        if (!triangulate(polygon_, triangles_))
            throw InputError(
                shown(path_), fmt::format("line {}", in_.faces[f].line),
                fmt::format("a concave face of {} corners; the limit is {}", polygon_.size(), max_concave_corners));
        for (const auto& t : triangles_) {
            const glm::vec3 flat = geometric_normal(polygon_[t[0]], polygon_[t[1]], polygon_[t[2]]);
            glm::uvec3 triangle;
            for (int k = 0; k < 3; ++k) triangle[k] = vertex(in_.corners[first + t[std::size_t(k)]], flat);
            mesh_.triangles.push_back(triangle);
            mesh_.material.push_back(material);
        }
    }

  private:
    std::uint32_t vertex(Corner c, const glm::vec3& flat) {
        const bool own = c.normal >= 0 && normals_[std::size_t(c.normal)] != glm::vec3(0);
        if (own) {
            const auto [at, is_new] = index_of_.try_emplace(c, std::uint32_t(mesh_.vertices.size()));
            if (!is_new) return at->second;
        }
        Vertex v;
        v.position = in_.positions[std::size_t(c.position)];
        v.normal = own ? normals_[std::size_t(c.normal)] : flat;
        if (c.texture >= 0) {
            // OBJ counts v from the bottom of the picture.
            const glm::vec2 uv = in_.texture_coordinates[std::size_t(c.texture)];
            v.u = uv.x, v.v = 1 - uv.y;
        }
        mesh_.vertices.push_back(v);
        return std::uint32_t(mesh_.vertices.size()) - 1;
    }

    const std::string& path_;
    const Lines& in_;
    Mesh& mesh_;
    std::vector<glm::vec3> normals_;
    std::vector<glm::vec3> polygon_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::unordered_map<Corner, std::uint32_t, CornerHash> index_of_;
};

void read_libraries(const std::string& path, const Lines& lines, const ReadLibrary& read_library, ObjModel& model) {
    for (const auto& [name, line] : lines.libraries.list) {
        const std::string file = beside(path, name);
        std::string text;
        try {
            text = read_library(file);
        } catch (const InputError& e) {
            throw InputError(shown(path), fmt::format("line {}", line), std::string("mtllib: ") + e.what());
        }
        for (Material& material : parse_mtl(file, text, model.textures, model.notes))
            model.materials.push_back(std::move(material));
    }
}

// Index of each name of usemtl into the model's materials.
std::vector<std::int32_t> resolve_materials(const std::string& path, const Lines& lines, const ObjModel& model) {
    std::map<std::string, std::int32_t> index;
    for (std::size_t i = 0; i < model.materials.size(); ++i)
        index.try_emplace(model.materials[i].name, std::int32_t(i));
    std::vector<std::int32_t> indices;
    for (const auto& [name, line] : lines.materials.list) {
        const auto at = index.find(name);
        if (at == index.end()) {
            std::vector<std::string> known;
            for (const Material& material : model.materials) known.push_back(material.name);
            throw InputError(shown(path), fmt::format("line {}", line),
                             fmt::format("usemtl: unknown material \"{}\"{}", printable(name),
                                         known.empty() ? "; no mtllib gives any"
                                                       : shown(nearest_known(name, known, "\"\""))));
        }
        indices.push_back(at->second);
    }
    return indices;
}

}  // namespace

ObjModel parse_obj(const std::string& path, const std::string& text, const ReadLibrary& read_library) {
    if (text.empty()) throw InputError(shown(path), "", "is empty; expected an OBJ");
    const Lines lines = ObjScanner(path).scan(text);
    if (lines.faces.empty())
        throw InputError(shown(path), "", fmt::format("holds no face (f); it has {} vertices", lines.positions.size()));

    ObjModel model;
    read_libraries(path, lines, read_library, model);
    const std::vector<std::int32_t> material_of_name = resolve_materials(path, lines, model);
    if (std::any_of(lines.faces.begin(), lines.faces.end(), [](const Face& f) { return f.material < 0; })) {
        model.materials.push_back({});
        model.materials.back().name = "default";
    }

    model.mesh.name = stem_of(path);
    ObjBuilder builder(path, lines, model.mesh);
    const std::int32_t none = std::int32_t(model.materials.size()) - 1;
    for (std::size_t f = 0; f < lines.faces.size(); ++f) {
        const std::int32_t name = lines.faces[f].material;
        builder.add(f, name < 0 ? none : material_of_name[std::size_t(name)]);
    }
    model.has_texture_coordinates =
        std::any_of(lines.corners.begin(), lines.corners.end(), [](const Corner& c) { return c.texture >= 0; });
    return model;
}

ObjModel read_obj(const std::string& path) {
    return parse_obj(path, read_text(path), [](const std::string& library) { return read_text(library); });
}

}  // namespace plumb::io
