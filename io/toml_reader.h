// A TOML table, read key by key with the line of each for messages. Private to io/.
#pragma once

#include <toml++/toml.h>

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/fields.h"

namespace plumb::io {

// Parses `text`; throws InputError with the line of what is wrong, and for values nested deeper than 16.
toml::table parse_toml(const std::string& path, const std::string& text);

// Each function that reads a key also makes it known; finish() refuses the keys that nobody has asked for.
class TomlReader {
  public:
    // `name` as messages show it: "[camera]"; "" for the top of the file.
    TomlReader(const toml::table& table, const std::string& path, std::string name)
        : table_(table), path_(path), name_(std::move(name)) {}

    bool has(const std::string& key) { return node(key) != nullptr; }
    bool holds_array(const std::string& key) { return node(key) && node(key)->is_array(); }
    double number(const std::string& key, double fallback, double min = -unbounded, double max = unbounded);
    int integer(const std::string& key, int fallback, int min, int max);
    bool flag(const std::string& key, bool fallback);
    std::string word(const std::string& key, const std::string& fallback);
    // One of `choices`, as its number in the list.
    int choice(const std::string& key, int fallback, const std::vector<std::string>& choices);
    // Exactly as many finite numbers, each in the range; none where the key is not there.
    std::optional<std::vector<double>> numbers(const std::string& key, std::size_t count, double min = -unbounded,
                                               double max = unbounded);
    glm::dvec3 vector(const std::string& key, const glm::dvec3& fallback, double min = -unbounded,
                      double max = unbounded);
    // A list of vectors, as many as that.
    std::vector<glm::dvec3> vectors(const std::string& key, std::size_t least, std::size_t most);
    // One number for grey, or three.
    glm::dvec3 colour(const std::string& key, const glm::dvec3& fallback, double min, double max);
    // The value as core/fields.h takes it: a number, true/false, a string or three numbers.
    FieldValue field_value(const std::string& key);

    const toml::table* table(const std::string& key);
    // [[key]]: its tables in order. A single [key] is an error that says so.
    std::vector<const toml::table*> tables(const std::string& key);

    void finish() const;

    std::string place(const std::string& key);  // "scene.toml: line 12"
    std::string place() const;                  // of the table itself
    // Throws InputError: "scene.toml: line 12: [camera] near = 0: <cause>".
    [[noreturn]] void fail(const std::string& key, const std::string& cause);

  private:
    const toml::node* node(const std::string& key);
    [[noreturn]] void fail_type(const std::string& key, const std::string& expected);
    double checked(const std::string& key, const toml::node& node, double min, double max);

    const toml::table& table_;
    const std::string& path_;
    std::string name_;
    std::vector<std::string> known_;
};

}  // namespace plumb::io
