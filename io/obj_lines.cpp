#include "io/obj_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "io/file.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

constexpr std::size_t max_triangles = std::size_t(1) << 28;

class ObjScanner {
  public:
    ObjScanner(const std::string& path, Findings& findings) : path_(path), findings_(findings) {}

    [[noreturn]] void fail(std::int64_t line, const std::string& cause) const {
        throw InputError(shown(path_), fmt::format("line {}", line), cause);
    }

    ObjLines scan(std::string_view text) {
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
        if (key == "v") return vertex(key, rest);
        if (key == "vn") return out_.normals.push_back(numbers<3>(key, rest, 3).value);
        if (key == "vt") return out_.texture_coordinates.push_back(glm::vec2(numbers<3>(key, rest, 1).value));
        if (key == "f" || key == "fo") return face(rest);
        if (key == "usemtl") return use_material(rest);
        if (key == "mtllib") return use_library(rest);
        if (key == "p") return void(++out_.points);
        if (key == "l") return void(++out_.lines);
        pass_over(key);
    }

    void pass_over(std::string_view key) {
        static constexpr std::string_view silent[] = {"o",      "g",      "s",        "vp",       "mg",         "lod",      "bevel",
                                                      "usemap", "maplib", "c_interp", "d_interp", "shadow_obj", "trace_obj"};
        static constexpr std::string_view curved[] = {"cstype", "deg",  "bmat", "step", "curv", "curv2", "surf",
                                                      "parm",   "trim", "hole", "scrv", "sp",   "end",   "con",
                                                      "ctech",  "stech", "bsp", "bzp",  "cdc",  "cdp",   "res"};
        if (contains(silent, key)) return;
        if (contains(curved, key)) {
            out_.surfaces += key == "surf" || key == "curv" || key == "curv2";
            return found("curved", "\"" + std::string(key) + "\": free-form curves and surfaces are not read",
                         "they are not drawn");
        }
        if (key == "call" || key == "csh")
            return found("call", "\"" + std::string(key) + "\": calls of other files and programs are not read",
                         "it is passed over");
        if (findings_.counted("statement")) return;
        found("statement", "\"" + printable(key) + "\" is not a statement of OBJ", "it is passed over");
    }

    template <std::size_t N>
    static bool contains(const std::string_view (&list)[N], std::string_view key) {
        return std::find(std::begin(list), std::end(list), key) != std::end(list);
    }

    void found(std::string_view kind, const std::string& cause, const std::string& instead) {
        findings_.add(kind, path_, line_, cause, instead);
    }

    // x y z, then a weight or a colour or both.
    void vertex(std::string_view key, std::string_view rest) {
        const Numbers read = numbers<3>(key, rest, 3);
        out_.positions.push_back(read.value);
        out_.coloured += read.count >= 6;
    }

    // A library's name may hold blanks, and a line may name several: which it is depends on the files that there are.
    void use_library(std::string_view rest) {
        if (trimmed(rest).empty()) return found("empty mtllib", "mtllib names nothing", "it is passed over");
        remember(out_.libraries, rest);
    }

    void use_material(std::string_view rest) {
        material_ = trimmed(rest).empty() ? -1 : remember(out_.materials, rest);
        if (material_ < 0) found("empty usemtl", "usemtl names nothing", "faces after it are grey, 0.5");
    }

    struct Numbers {
        glm::vec3 value;
        int count;
    };

    // At least `least` of N finite numbers, the rest 0. What stands behind them (a weight, a colour) must be numbers
    // too.
    template <int N>
    Numbers numbers(std::string_view key, std::string_view rest, int least) const {
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
        return {value, n};
    }

    // Positive indices count from 1; negative ones back from the last so far. Whether the list is long enough is seen
    // at the end: faces may stand before their vertices. Without `must` one that is out of range is none.
    std::int32_t index(std::string_view text, std::size_t so_far, const char* what, bool must) {
        const auto i = parse_integer(text);
        if (!i) fail(line_, fmt::format("f: \"{}\" is not an index", printable(text)));
        if (*i == 0) fail(line_, fmt::format("f: {} 0; indices count from 1", what));
        if (*i < -std::int64_t(so_far) || *i > std::int64_t(std::numeric_limits<std::int32_t>::max())) {
            if (!must) return lacks(line_, what, *i, so_far), -1;
            fail(line_, fmt::format("f: {} {} is out of range; there are {} so far", what, *i, so_far));
        }
        return std::int32_t(*i > 0 ? *i - 1 : std::int64_t(so_far) + *i);
    }

    // Coordinates and normals that the file has not: the corner goes without.
    void lacks(std::int64_t line, const char* what, std::int64_t index, std::size_t there) {
        findings_.add(what, path_, line, fmt::format("f: {} {} is out of range; the file has {}", what, index, there),
                      "the corner goes without");
    }

    Corner corner(std::string_view word) {
        Corner c;
        const std::size_t slash = word.find('/');
        c.position = index(word.substr(0, slash), out_.positions.size(), "vertex", true);
        if (slash == word.npos) return c;
        const std::string_view rest = word.substr(slash + 1);
        const std::size_t second = rest.find('/');
        const std::string_view texture = rest.substr(0, second);
        if (!texture.empty()) c.texture = index(texture, out_.texture_coordinates.size(), "texture coordinate", false);
        const std::string_view normal = second == rest.npos ? "" : rest.substr(second + 1);
        if (!normal.empty()) c.normal = index(normal, out_.normals.size(), "normal", false);
        return c;
    }

    void face(std::string_view rest) {
        const std::size_t first = out_.corners.size();
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
            out_.corners.push_back(corner(word));
        const std::size_t n = out_.corners.size() - first;
        if (n < 3) {
            out_.corners.resize(first);
            return found("short face", fmt::format("f has {} corners; a face has at least 3", n), "it is passed over");
        }
        if (out_.corners.size() - 2 * out_.faces.size() > max_triangles)
            fail(line_, fmt::format("more than {} triangles", max_triangles));
        out_.faces.push_back({first, line_, material_});
    }

    std::int32_t remember(Names& names, std::string_view rest) {
        const std::string name(trimmed(rest));
        const auto [at, is_new] = names.index.try_emplace(name, std::int32_t(names.list.size()));
        if (is_new) names.list.emplace_back(name, line_);
        return at->second;
    }

    void check_indices() {
        const auto beyond = [](std::int32_t i, std::size_t size) { return i >= 0 && std::size_t(i) >= size; };
        for (std::size_t f = 0; f < out_.faces.size(); ++f) {
            const std::size_t end = f + 1 < out_.faces.size() ? out_.faces[f + 1].first : out_.corners.size();
            const std::int64_t line = out_.faces[f].line;
            for (std::size_t i = out_.faces[f].first; i < end; ++i) {
                Corner& c = out_.corners[i];
                if (beyond(c.position, out_.positions.size()))
                    fail(line, fmt::format("f: vertex {} is out of range; the file has {}", std::int64_t(c.position) + 1,
                                           out_.positions.size()));
                if (beyond(c.texture, out_.texture_coordinates.size())) {
                    lacks(line, "texture coordinate", std::int64_t(c.texture) + 1, out_.texture_coordinates.size());
                    c.texture = -1;
                }
                if (beyond(c.normal, out_.normals.size())) {
                    lacks(line, "normal", std::int64_t(c.normal) + 1, out_.normals.size());
                    c.normal = -1;
                }
            }
        }
    }

    const std::string& path_;
    Findings& findings_;
    ObjLines out_;
    std::int64_t line_ = 0;
    std::int32_t material_ = -1;
};

}  // namespace

ObjLines scan_obj(const std::string& path, std::string_view text, Findings& findings) {
    return ObjScanner(path, findings).scan(text);
}

}  // namespace plumb::io
