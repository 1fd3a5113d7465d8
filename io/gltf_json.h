// A JSON document read value by value, with the place of each for messages. Private to io/.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::io {

using GltfJson = nlohmann::json;

// Throws InputError with the byte where values are nested deeper than 64 or there are more than 2^24: before a parser sees
// them; and for a key that an object holds twice. What else is wrong it leaves to the parser.
void require_small_json(const std::string& shown_path, std::string_view text);

// Parses `text`. Throws InputError with the byte of what is wrong: also as require_small_json().
GltfJson parse_gltf_json(const std::string& path, std::string_view text);

// A value, or the absence of one, and where it stands. Each function that returns something throws InputError where the
// value is not that.
class JsonValue {
  public:
    JsonValue(const std::string& path, const GltfJson& root) : path_(&path), json_(&root) {}

    explicit operator bool() const { return json_ != nullptr; }  // is there
    JsonValue operator[](const char* key) const;                 // of an object; absent where that has no such key
    JsonValue operator[](std::size_t i) const;                   // of an array that has it
    std::size_t size() const;                                    // of an array; 0 where it is absent
    std::vector<std::string> keys() const;                       // of an object; none where it is absent

    double number(double min, double max) const;
    double number(double min, double max, double fallback) const { return json_ ? number(min, max) : fallback; }
    std::uint64_t integer(std::uint64_t min, std::uint64_t max) const;
    std::uint64_t integer(std::uint64_t min, std::uint64_t max, std::uint64_t fallback) const {
        return json_ ? integer(min, max) : fallback;
    }
    // An index into a list of `size` things; none where the value is absent.
    std::optional<std::size_t> index(std::size_t size, const char* things) const;
    std::string text() const;
    std::string text(const std::string& fallback) const { return json_ ? text() : fallback; }
    bool flag(bool fallback) const;
    // As many numbers as the fallback, which stands for an absent value.
    std::vector<double> numbers(std::vector<double> fallback, double min, double max) const;
    // What this program has added to an object of glTF: extras/plumb. Absent where others have written the extras.
    JsonValue own() const;
    // The value itself, which has to be there.
    const JsonValue& required() const;

    const std::string& pointer() const { return pointer_; }
    [[noreturn]] void fail(const std::string& cause) const;

  private:
    const std::string* path_;
    const GltfJson* json_;
    std::string pointer_;
};

}  // namespace plumb::io
