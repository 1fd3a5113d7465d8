#include "io/gltf_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {
namespace {

constexpr std::size_t max_depth = 64, max_values = std::size_t(1) << 24;
constexpr double max_whole = 9007199254740992.0;  // 2^53: every integer up to it is a double

// Counts what a parser would build, before one does.
void require_few(const std::string& shown_path, std::string_view text) {
    std::size_t depth = 0, values = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"') {
            for (++i; i < text.size() && text[i] != '"'; ++i)
                if (text[i] == '\\') ++i;
        } else if (c == '[' || c == '{') {
            ++depth, ++values;
        } else if (c == ']' || c == '}') {
            depth -= depth > 0;
        } else if (c == ',') {
            ++values;
        }
        if (depth > max_depth)
            throw InputError(shown_path, fmt::format("byte {}", i),
                             fmt::format("values nested deeper than {}", max_depth));
        if (values > max_values)
            throw InputError(shown_path, fmt::format("byte {}", i), fmt::format("more than {} values", max_values));
    }
}

// Finds a key that an object holds twice; leaves everything else to the parser.
struct DuplicateKeys : GltfJson::json_sax_t {
    std::vector<std::set<std::string>> open;
    std::string found;

    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(number_integer_t) override { return true; }
    bool number_unsigned(number_unsigned_t) override { return true; }
    bool number_float(number_float_t, const string_t&) override { return true; }
    bool string(string_t&) override { return true; }
    bool binary(binary_t&) override { return true; }
    bool start_array(std::size_t) override { return true; }
    bool end_array() override { return true; }
    bool start_object(std::size_t) override {
        open.emplace_back();
        return true;
    }
    bool end_object() override {
        open.pop_back();
        return true;
    }
    bool key(string_t& name) override {
        if (open.back().insert(name).second) return true;
        found = name.empty() ? "\"\"" : name;
        return false;
    }
    bool parse_error(std::size_t, const std::string&, const GltfJson::exception&) override { return false; }
};

// The parser's message without its name and number: "[json.exception.parse_error.101] parse error at ...: cause".
std::string cause_of(const std::string& message) {
    std::size_t from = message.find("] ");
    from = from == message.npos ? 0 : from + 2;
    const std::size_t colon = message.compare(from, 11, "parse error") == 0 ? message.find(": ", from) : message.npos;
    return printable(message.substr(colon == message.npos ? from : colon + 2), 200);
}

std::string shown_value(const GltfJson& json) {
    if (json.is_object()) return "an object";
    if (json.is_array()) return fmt::format("an array of {}", json.size());
    return printable(json.dump(-1, ' ', false, GltfJson::error_handler_t::replace));
}

}  // namespace

void require_small_json(const std::string& shown_path, std::string_view text) {
    require_few(shown_path, text);
    // A pass of its own: a parser with a callback takes a time quadratic in the length of a list.
    DuplicateKeys duplicates;
    GltfJson::sax_parse(text.begin(), text.end(), &duplicates);
    if (!duplicates.found.empty())
        throw InputError(shown_path, "", fmt::format("an object holds \"{}\" twice", printable(duplicates.found)));
}

GltfJson parse_gltf_json(const std::string& path, std::string_view text) {
    require_small_json(shown(path), text);
    try {
        return GltfJson::parse(text.begin(), text.end());
    } catch (const GltfJson::parse_error& e) {
        throw InputError(shown(path), fmt::format("byte {}", e.byte), cause_of(e.what()));
    } catch (const GltfJson::exception& e) {
        throw InputError(shown(path), "", cause_of(e.what()));
    }
}

void JsonValue::fail(const std::string& cause) const {
    std::string value;
    if (json_ && !json_->is_structured()) value = " = " + shown_value(*json_);
    throw InputError(shown(*path_) + ": " + (pointer_.empty() ? "/" : printable(pointer_, 200)) + value + ": " + cause);
}

const JsonValue& JsonValue::required() const {
    if (!json_) fail("is missing");
    return *this;
}

JsonValue JsonValue::operator[](const char* key) const {
    JsonValue value = *this;
    value.pointer_ += std::string("/") + key;
    value.json_ = nullptr;
    if (!json_) return value;
    if (!json_->is_object()) fail("expected an object");
    const auto at = json_->find(key);
    if (at != json_->end()) value.json_ = &*at;
    return value;
}

JsonValue JsonValue::operator[](std::size_t i) const {
    JsonValue value = *this;
    value.pointer_ += fmt::format("/{}", i);
    value.json_ = &(*json_)[i];
    return value;
}

JsonValue JsonValue::own() const {
    const JsonValue extras = (*this)["extras"];
    JsonValue plumb = extras.json_ && extras.json_->is_object() ? extras["plumb"] : extras;
    if (!plumb.json_ || !plumb.json_->is_object() || plumb.pointer_ == extras.pointer_) plumb.json_ = nullptr;
    return plumb;
}

std::size_t JsonValue::size() const {
    if (!json_) return 0;
    if (!json_->is_array()) fail("expected an array");
    return json_->size();
}

std::vector<std::string> JsonValue::keys() const {
    std::vector<std::string> names;
    if (!json_) return names;
    if (!json_->is_object()) fail("expected an object");
    for (const auto& [key, value] : json_->items()) names.push_back(key);
    return names;
}

double JsonValue::number(double min, double max) const {
    required();
    if (!json_->is_number()) fail("expected a number");
    const double x = json_->get<double>();
    if (x >= min && x <= max) return x;
    if (min <= -1e300) fail("expected a finite number");
    if (max >= 1e30) fail(fmt::format("expected a number of at least {}", min));
    fail(fmt::format("expected {} to {}", min, max));
}

std::uint64_t JsonValue::integer(std::uint64_t min, std::uint64_t max) const {
    required();
    const double x = json_->is_number() ? json_->get<double>() : -1;
    // 25.0 is an integer to JSON.
    if (!(x >= 0 && x <= max_whole && x == std::floor(x))) fail("expected a whole number from 0 on");
    const std::uint64_t i = std::uint64_t(x);
    if (i < min || i > max) fail(fmt::format("expected {} to {}", min, max));
    return i;
}

std::optional<std::size_t> JsonValue::index(std::size_t size, const char* things) const {
    if (!json_) return {};
    const std::uint64_t i = integer(0, std::uint64_t(max_whole));
    if (i >= size) fail(fmt::format("out of range; the file has {} {}", size, things));
    return std::size_t(i);
}

std::string JsonValue::text() const {
    required();
    if (!json_->is_string()) fail("expected a string");
    return json_->get<std::string>();
}

bool JsonValue::flag(bool fallback) const {
    if (!json_) return fallback;
    if (!json_->is_boolean()) fail("expected true or false");
    return json_->get<bool>();
}

std::vector<double> JsonValue::numbers(std::vector<double> fallback, double min, double max) const {
    if (!json_) return fallback;
    if (!json_->is_array() || json_->size() != fallback.size())
        fail(fmt::format("expected {} numbers", fallback.size()));
    for (std::size_t i = 0; i < fallback.size(); ++i) fallback[i] = (*this)[i].number(min, max);
    return fallback;
}

}  // namespace plumb::io
