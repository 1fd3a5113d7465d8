#include "io/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"

namespace plumb::io {
namespace {

constexpr int max_depth = 16;

// Refuses what would nest deep: brackets within brackets, and dots in one key. The parser limits brackets but builds,
// and takes down, a table for each dot by recursion.
void require_shallow(const std::string& path, std::string_view text) {
    int line = 1, brackets = 0, dots = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '\n') ++line;
        if (c == '#') {
            i = std::min(text.find('\n', i), text.size()) - 1;
        } else if (c == '"' || c == '\'') {
            // Skips the string. Only the short basic one and the long basic one know escapes.
            const bool is_long = text.substr(i, 3) == std::string(3, c);
            const std::size_t quotes = is_long ? 3 : 1;
            for (i += quotes; i < text.size() && text.substr(i, quotes) != std::string(quotes, c); ++i) {
                if (c == '"' && text[i] == '\\') ++i;
                if (i < text.size() && text[i] == '\n') {
                    ++line;
                    if (!is_long) break;
                }
            }
            i += quotes - 1;
        } else if (c == '.') {
            ++dots;
        } else if (c == '[' || c == '{') {
            ++brackets, dots = 0;
        } else if (c == ']' || c == '}') {
            --brackets, dots = 0;
        } else if (c == ',' || c == '=' || c == '\n') {
            dots = 0;
        }
        if (brackets > max_depth || dots > max_depth)
            throw InputError(shown(path), fmt::format("line {}", line),
                             fmt::format("values or keys nested deeper than {}", max_depth));
    }
}

std::string text_of(const toml::node& node) {
    if (auto v = node.value_exact<std::string>()) return "\"" + printable(*v) + "\"";
    if (auto v = node.value_exact<bool>()) return *v ? "true" : "false";
    if (auto v = node.value_exact<std::int64_t>()) return fmt::format("{}", *v);
    if (auto v = node.value_exact<double>()) return fmt::format("{}", *v);
    if (node.is_table()) return "a table";
    if (const toml::array* array = node.as_array()) return fmt::format("an array of {}", array->size());
    return "a date or time";
}

bool is_number(const toml::node& node) { return node.is_integer() || node.is_floating_point(); }

std::string range_text(double min, double max) {
    if (min == -unbounded && max == unbounded) return "a finite number";
    if (max == unbounded) return fmt::format("a finite number of at least {}", min);
    return fmt::format("{} to {}", min, max);
}

}  // namespace

toml::table parse_toml(const std::string& path, const std::string& text) {
    require_shallow(path, text);
    try {
        return toml::parse(std::string_view(text), std::string_view(path));
    } catch (const toml::parse_error& e) {
        throw InputError(shown(path), fmt::format("line {}", e.source().begin.line), printable(e.description(), 200));
    }
}

const toml::node* TomlReader::node(const std::string& key) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
    return table_.get(key);
}

std::string TomlReader::place() const { return fmt::format("{}: line {}", shown(path_), table_.source().begin.line); }

std::string TomlReader::place(const std::string& key) {
    const toml::node* value = node(key);
    return value ? fmt::format("{}: line {}", shown(path_), value->source().begin.line) : place();
}

void TomlReader::fail(const std::string& key, const std::string& cause) {
    const toml::node* value = node(key);
    const std::string prefix = (name_.empty() ? "" : name_ + " ") + printable(key);
    throw InputError(place(key) + ": " + prefix + (value ? " = " + text_of(*value) : "") + ": " + cause);
}

void TomlReader::fail_type(const std::string& key, const std::string& expected) { fail(key, "expected " + expected); }

double TomlReader::checked(const std::string& key, const toml::node& value, double min, double max) {
    if (!is_number(value)) fail_type(key, "a number");
    const double x = *value.value<double>();
    if (!(x >= min && x <= max) || (std::isinf(x) && !std::isinf(max))) fail_type(key, range_text(min, max));
    return x;
}

double TomlReader::number(const std::string& key, double fallback, double min, double max) {
    const toml::node* value = node(key);
    return value ? checked(key, *value, min, max) : fallback;
}

int TomlReader::integer(const std::string& key, int fallback, int min, int max) {
    const toml::node* value = node(key);
    if (!value) return fallback;
    if (!value->is_integer()) fail_type(key, "an integer");
    const std::int64_t i = *value->value<std::int64_t>();
    if (i < min || i > max) fail_type(key, fmt::format("{} to {}", min, max));
    return int(i);
}

bool TomlReader::flag(const std::string& key, bool fallback) {
    const toml::node* value = node(key);
    if (value && !value->is_boolean()) fail_type(key, "true or false");
    return value ? *value->value<bool>() : fallback;
}

std::string TomlReader::word(const std::string& key, const std::string& fallback) {
    const toml::node* value = node(key);
    if (value && !value->is_string()) fail_type(key, "a string");
    return value ? *value->value<std::string>() : fallback;
}

int TomlReader::choice(const std::string& key, int fallback, const std::vector<std::string>& choices) {
    if (!has(key)) return fallback;
    const auto at = std::find(choices.begin(), choices.end(), word(key, ""));
    if (at == choices.end()) fail_type(key, fmt::format("one of {}", fmt::join(choices, ", ")));
    return int(at - choices.begin());
}

std::optional<std::vector<double>> TomlReader::numbers(const std::string& key, std::size_t count, double min,
                                                       double max) {
    const toml::node* value = node(key);
    if (!value) return {};
    const toml::array* array = value->as_array();
    if (!array || array->size() != count) fail_type(key, fmt::format("{} numbers", count));
    std::vector<double> result;
    for (const toml::node& element : *array) {
        if (!is_number(element)) fail_type(key, fmt::format("{} numbers", count));
        const double x = *element.value<double>();
        if (!(x >= min && x <= max) || !std::isfinite(x))
            throw InputError(fmt::format("{}: line {}: {} {} holds {}: expected {}", shown(path_),
                                         element.source().begin.line, name_, printable(key), x, range_text(min, max)));
        result.push_back(x);
    }
    return result;
}

glm::dvec3 TomlReader::vector(const std::string& key, const glm::dvec3& fallback, double min, double max) {
    const auto n = numbers(key, 3, min, max);
    return n ? glm::dvec3((*n)[0], (*n)[1], (*n)[2]) : fallback;
}

std::vector<glm::dvec3> TomlReader::vectors(const std::string& key, std::size_t least, std::size_t most) {
    const std::string expected = fmt::format("a list of {} to {} vectors of three numbers", least, most);
    const toml::node* value = node(key);
    const toml::array* array = value ? value->as_array() : nullptr;
    if (!array || array->size() < least || array->size() > most) fail_type(key, expected);
    std::vector<glm::dvec3> result;
    for (const toml::node& element : *array) {
        const toml::array* three = element.as_array();
        if (!three || three->size() != 3) fail_type(key, expected);
        glm::dvec3& v = result.emplace_back(0);
        for (int c = 0; c < 3; ++c) v[c] = checked(key, (*three)[std::size_t(c)], -unbounded, unbounded);
    }
    return result;
}

glm::dvec3 TomlReader::colour(const std::string& key, const glm::dvec3& fallback, double min, double max) {
    const toml::node* value = node(key);
    if (!value || value->is_array()) return vector(key, fallback, min, max);
    if (!is_number(*value)) fail_type(key, "a number or three");
    return glm::dvec3(number(key, 0, min, max));
}

FieldValue TomlReader::field_value(const std::string& key) {
    const toml::node* value = node(key);
    if (value && is_number(*value)) return *value->value<double>();
    if (value && value->is_boolean()) return *value->value<bool>();
    if (value && value->is_string()) return *value->value<std::string>();
    if (value && value->is_array()) return glm::vec3(vector(key, glm::dvec3(0)));
    fail_type(key, "a number, a string, true, false or three numbers");
}

const toml::table* TomlReader::table(const std::string& key) {
    const toml::node* value = node(key);
    if (value && !value->is_table()) fail_type(key, "a table, [" + key + "]");
    return value ? value->as_table() : nullptr;
}

std::vector<const toml::table*> TomlReader::tables(const std::string& key) {
    std::vector<const toml::table*> result;
    const toml::node* value = node(key);
    if (!value) return result;
    const toml::array* array = value->as_array();
    if (!array) fail_type(key, "a list of tables, [[" + key + "]]");
    for (const toml::node& element : *array) {
        if (!element.is_table()) fail_type(key, "a list of tables, [[" + key + "]]");
        result.push_back(element.as_table());
    }
    return result;
}

void TomlReader::finish() const {
    // The first in the file, not in the alphabet.
    const toml::key* first = nullptr;
    for (const auto& [key, value] : table_) {
        if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
        if (!first || key.source().begin < first->source().begin) first = &key;
    }
    if (!first) return;
    const std::string name(first->str());
    throw InputError(fmt::format("{}: line {}: {}unknown key '{}'{}", shown(path_), first->source().begin.line,
                                 name_.empty() ? "" : name_ + " ", printable(name), nearest_known(name, known_)));
}

}  // namespace plumb::io
