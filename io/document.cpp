#include "io/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/file.h"
#include "io/gltf_json.h"
#include "io/toml_reader.h"

namespace plumb::io {
namespace {

using Kind = DocumentValue::Kind;
constexpr double max_whole = 9007199254740992.0;  // 2^53: every integer up to it is a double

void set_number(DocumentValue& value, double x) {
    value.kind = Kind::number, value.number = x;
    value.is_integer = std::fabs(x) <= max_whole && x == std::floor(x);
    if (value.is_integer) value.integer = std::int64_t(x);
}

void set_integer(DocumentValue& value, std::int64_t i) {
    value.kind = Kind::number, value.number = double(i), value.is_integer = true, value.integer = i;
}

DocumentValue from_toml(const toml::node& node) {
    DocumentValue value;
    if (node.source().begin.line > 0) value.place = fmt::format("line {}", node.source().begin.line);
    if (const auto text = node.value_exact<std::string>()) {
        value.kind = Kind::text, value.text = *text;
    } else if (const auto flag = node.value_exact<bool>()) {
        value.kind = Kind::flag, value.flag = *flag;
    } else if (const auto integer = node.value_exact<std::int64_t>()) {
        set_integer(value, *integer);
    } else if (const auto number = node.value_exact<double>()) {
        set_number(value, *number);
    } else if (const toml::array* array = node.as_array()) {
        value.kind = Kind::list;
        for (const toml::node& element : *array) value.list.push_back(from_toml(element));
    } else if (const toml::table* table = node.as_table()) {
        value.kind = Kind::table;
        std::vector<std::pair<toml::source_position, std::string>> order;
        for (const auto& [key, element] : *table) order.emplace_back(key.source().begin, key.str());
        std::sort(order.begin(), order.end());
        for (const auto& [position, key] : order) value.table.push_back({key, from_toml(*table->get(key))});
    }
    return value;
}

DocumentValue from_json(const GltfJson& json, const std::string& pointer) {
    DocumentValue value;
    value.place = pointer.empty() ? "/" : pointer;
    if (json.is_string()) {
        value.kind = Kind::text, value.text = json.get<std::string>();
    } else if (json.is_boolean()) {
        value.kind = Kind::flag, value.flag = json.get<bool>();
    } else if (json.is_number_integer() && (!json.is_number_unsigned() || json.get<std::uint64_t>() >> 63 == 0)) {
        set_integer(value, json.get<std::int64_t>());
    } else if (json.is_number()) {
        set_number(value, json.get<double>());
    } else if (json.is_array()) {
        value.kind = Kind::list;
        for (std::size_t i = 0; i < json.size(); ++i)
            value.list.push_back(from_json(json[i], fmt::format("{}/{}", pointer, i)));
    } else if (json.is_object()) {
        value.kind = Kind::table;
        for (const auto& [key, element] : json.items())
            value.table.push_back({key, from_json(element, pointer + "/" + key)});
    }
    return value;
}

std::string text_of(const DocumentValue& value) {
    switch (value.kind) {
        case Kind::number:
            return value.is_integer ? fmt::format("{}", value.integer) : fmt::format("{}", value.number);
        case Kind::flag:
            return value.flag ? "true" : "false";
        case Kind::text:
            return "\"" + printable(value.text) + "\"";
        case Kind::list:
            return fmt::format("a list of {}", value.list.size());
        case Kind::table:
            return "a table";
        case Kind::other:
            break;
    }
    return "null, a date or a time";
}

}  // namespace

DocumentValue parse_document(const std::string& path, const std::string& text) {
    if (extension_of(path) == "json") return from_json(parse_gltf_json(path, text), "");
    return from_toml(parse_toml(path, text));
}

const DocumentValue* DocumentReader::find(const std::string& key) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
    for (const auto& [name, value] : table_->table)
        if (name == key) return &value;
    return nullptr;
}

std::string DocumentReader::place_of(const DocumentValue& value) const {
    return shown(*path_) + (value.place.empty() ? "" : ": " + printable(value.place, 200));
}

void DocumentReader::fail(const std::string& key, const std::string& cause) {
    const DocumentValue* value = find(key);
    throw InputError(fmt::format("{}: {}{}{}: {}", place_of(value ? *value : *table_),
                                 name_.empty() ? "" : name_ + ": ", printable(key),
                                 value ? " = " + text_of(*value) : "", cause));
}

double DocumentReader::number(const std::string& key, double fallback, double min, double max) {
    const DocumentValue* value = find(key);
    if (!value) return fallback;
    if (value->kind != Kind::number) fail(key, "expected a number");
    if (!(value->number >= min && value->number <= max)) fail(key, fmt::format("expected {} to {}", min, max));
    return value->number;
}

std::int64_t DocumentReader::integer(const std::string& key, std::int64_t fallback, std::int64_t min,
                                     std::int64_t max) {
    const DocumentValue* value = find(key);
    if (!value) return fallback;
    if (value->kind != Kind::number || !value->is_integer) fail(key, "expected an integer");
    if (value->integer < min || value->integer > max) fail(key, fmt::format("expected {} to {}", min, max));
    return value->integer;
}

bool DocumentReader::flag(const std::string& key, bool fallback) {
    const DocumentValue* value = find(key);
    if (value && value->kind != Kind::flag) fail(key, "expected true or false");
    return value ? value->flag : fallback;
}

std::string DocumentReader::word(const std::string& key, const std::string& fallback) {
    const DocumentValue* value = find(key);
    if (value && value->kind != Kind::text) fail(key, "expected a string");
    return value ? value->text : fallback;
}

std::string DocumentReader::filled(const std::string& key, const std::string& fallback) {
    if (has(key) && word(key, "").empty()) fail(key, "expected a string that is not empty");
    return word(key, fallback);
}

const DocumentValue* DocumentReader::table(const std::string& key) {
    const DocumentValue* value = find(key);
    if (value && value->kind != Kind::table) fail(key, "expected a table");
    return value;
}

std::vector<const DocumentValue*> DocumentReader::tables(const std::string& key) {
    std::vector<const DocumentValue*> result;
    const DocumentValue* value = find(key);
    if (!value) return result;
    const auto is_table = [](const DocumentValue& element) { return element.kind == Kind::table; };
    if (value->kind != Kind::list || !std::all_of(value->list.begin(), value->list.end(), is_table))
        fail(key, "expected a list of tables; in TOML, [[" + key + "]]");
    for (const DocumentValue& element : value->list) result.push_back(&element);
    return result;
}

std::vector<std::string> DocumentReader::keys() const {
    std::vector<std::string> names;
    for (const auto& [key, value] : table_->table) names.push_back(key);
    return names;
}

void DocumentReader::allow(const std::vector<std::string>& keys) {
    for (const std::string& key : keys) find(key);
    finish();
}

void DocumentReader::finish() const {
    for (const auto& [key, value] : table_->table) {
        if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
        throw InputError(fmt::format("{}: {}unknown key '{}'{}", place_of(value), name_.empty() ? "" : name_ + ": ",
                                     printable(key), nearest_known(key, known_)));
    }
}

}  // namespace plumb::io
