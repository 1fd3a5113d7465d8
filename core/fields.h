// Fields: the members of a parameter struct, listed once.
//
// A stage's Params is a plain struct with defaults and one function
//
//     std::vector<Field> fields(GatherParams& p);
//
// that names each member with its range, unit and meaning. From this list come the command line, the keys of a scene
// file, the std140 block of the GLSL twin, `plumb stages`, and validate().
#pragma once

#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace plumb {

inline constexpr double unbounded = std::numeric_limits<double>::infinity();

// What `plumb sweep` tries: values worth a point or a curve.
struct SweepRange {
    enum class Role { along, curves };  // points of one curve, which trades error for time; or a curve for each value
    Role role = Role::along;
    std::vector<double> values;  // of an enumeration: its numbers; none: it is not swept unless it is asked for
    // A parameter of the same struct, and the value that it must have for this one to change anything: a word of its
    // choices, or a number. Empty: always.
    std::string when, is;
};

struct Field {
    std::string name;
    std::variant<int*, float*, bool*, glm::vec3*, std::string*> value;
    std::string unit;                  // "" where it has none
    std::string meaning;               // one sentence, and where it comes from
    double min = -unbounded, max = unbounded;
    std::vector<std::string> choices;  // for an enumeration: value is an int that counts from 0 along this list
    bool uniform = true;               // false: shapes the host's tables only, and is no member of the twin's block
    SweepRange sweep = {};
};

// An enumeration is stored as int; its names are the words that users write.
template <class E>
int* as_int(E& e) {
    static_assert(sizeof(E) == sizeof(int));
    return reinterpret_cast<int*>(&e);
}

// Throws InputError that names stage, field, value and range, for the first field that is out of range or not finite.
void validate_fields(const std::string& stage, const std::vector<Field>& fields);

// Sets a field from a number, a word or true/false; throws InputError that says what was expected. `place` is where the
// value was written: "scene.toml: line 12" or "--samples".
using FieldValue = std::variant<double, bool, std::string, glm::vec3>;
void set_field(Field& field, const FieldValue& value, const std::string& place);

// The field of that name; throws InputError at `place` that names the nearest known one.
Field& find_field(std::vector<Field>& fields, const std::string& name, const std::string& place);

// The candidate with the smallest edit distance to `name`: for "did you mean".
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

std::string type_name(const Field& field);   // "int", "float", "bool", "vec3", "string", "choice"
std::string value_text(const Field& field);  // as a scene file would write it

// Byte offset of each uniform field in a std140 block, in order, and the block's size last (a multiple of 16).
std::vector<int> std140_offsets(const std::vector<Field>& fields);
// The block itself: what a GPU's uniform buffer holds.
std::vector<unsigned char> std140_block(const std::vector<Field>& fields);

}  // namespace plumb
