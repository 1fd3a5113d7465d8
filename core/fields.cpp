#include "core/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/error.h"
#include "core/nearest_known.h"

namespace plumb {

namespace {

std::string range_text(const Field& f) {
    if (!f.choices.empty()) return fmt::format("one of {}", fmt::join(f.choices, ", "));
    const std::string unit = f.unit.empty() ? "" : " " + f.unit;
    if (f.min == -unbounded && f.max == unbounded) return "a finite number" + unit;
    if (f.max == unbounded) return fmt::format("at least {}{}", f.min, unit);
    return fmt::format("{} to {}{}", f.min, f.max, unit);
}

bool within(double x, const Field& f) { return x >= f.min && x <= f.max && x - x == 0; }

bool in_range(const Field& f) {
    if (auto p = std::get_if<int*>(&f.value))
        return f.choices.empty() ? within(**p, f) : **p >= 0 && **p < int(f.choices.size());
    if (auto p = std::get_if<float*>(&f.value)) return within(**p, f);
    if (auto p = std::get_if<glm::vec3*>(&f.value))
        return within((*p)->x, f) && within((*p)->y, f) && within((*p)->z, f);
    return true;
}

[[noreturn]] void fail(const Field& f, const std::string& place, const std::string& got) {
    throw InputError(fmt::format("{}: {} = {}: expected {}", place, f.name, got, range_text(f)));
}

std::string text(const FieldValue& v) {
    if (auto p = std::get_if<double>(&v)) return fmt::format("{}", *p);
    if (auto p = std::get_if<bool>(&v)) return *p ? "true" : "false";
    if (auto p = std::get_if<std::string>(&v)) return "\"" + *p + "\"";
    const glm::vec3 c = std::get<glm::vec3>(v);
    return fmt::format("[{}, {}, {}]", c.x, c.y, c.z);
}

int alignment(const Field& f) { return std::holds_alternative<glm::vec3*>(f.value) ? 16 : 4; }
int size(const Field& f) { return std::holds_alternative<glm::vec3*>(f.value) ? 12 : 4; }

}  // namespace

void validate_fields(const std::string& stage, const std::vector<Field>& fields) {
    for (const Field& f : fields)
        if (!in_range(f)) fail(f, stage, value_text(f));
}

void set_field(Field& f, const FieldValue& v, const std::string& place) {
    if (!f.choices.empty()) {
        const auto word = std::get_if<std::string>(&v);
        const auto at = word ? std::find(f.choices.begin(), f.choices.end(), *word) : f.choices.end();
        if (at == f.choices.end()) fail(f, place, text(v));
        *std::get<int*>(f.value) = int(at - f.choices.begin());
        return;
    }
    const auto number = std::get_if<double>(&v);
    if (auto p = std::get_if<int*>(&f.value)) {
        if (!number || !within(*number, f) || *number < -2147483648.0 || *number > 2147483647.0 || *number != int(*number))
            fail(f, place, text(v));
        **p = int(*number);
    } else if (auto p = std::get_if<float*>(&f.value)) {
        if (number && within(*number, f) && !std::isfinite(float(*number)))
            throw InputError(fmt::format("{}: {} = {}: expected {}, and no more than a float holds, {:.3g}", place, f.name,
                                         text(v), range_text(f), std::numeric_limits<float>::max()));
        if (!number || !within(*number, f) || !within(float(*number), f)) fail(f, place, text(v));
        **p = float(*number);
    } else if (auto p = std::get_if<bool*>(&f.value)) {
        if (!std::holds_alternative<bool>(v))
            throw InputError(fmt::format("{}: {} = {}: expected true or false", place, f.name, text(v)));
        **p = std::get<bool>(v);
    } else if (auto p = std::get_if<std::string*>(&f.value)) {
        if (!std::holds_alternative<std::string>(v))
            throw InputError(fmt::format("{}: {} = {}: expected a string", place, f.name, text(v)));
        **p = std::get<std::string>(v);
    } else {
        if (!std::holds_alternative<glm::vec3>(v))
            throw InputError(fmt::format("{}: {} = {}: expected three numbers", place, f.name, text(v)));
        const glm::vec3 c = std::get<glm::vec3>(v);
        if (!within(c.x, f) || !within(c.y, f) || !within(c.z, f)) fail(f, place, text(v));
        *std::get<glm::vec3*>(f.value) = c;
    }
}

Field& find_field(std::vector<Field>& fields, const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (Field& f : fields) {
        if (f.name == name) return f;
        names.push_back(f.name);
    }
    throw InputError(fmt::format("{}: unknown key '{}'{}", place, name, nearest_known(name, names)));
}

std::string type_name(const Field& f) {
    if (!f.choices.empty()) return "choice";
    static constexpr const char* names[] = {"int", "float", "bool", "vec3", "string"};
    return names[f.value.index()];
}

std::string value_text(const Field& f) {
    if (auto p = std::get_if<int*>(&f.value)) {
        const bool named = **p >= 0 && **p < int(f.choices.size());
        return named ? "\"" + f.choices[**p] + "\"" : fmt::format("{}", **p);
    }
    if (auto p = std::get_if<float*>(&f.value)) return fmt::format("{}", **p);
    if (auto p = std::get_if<bool*>(&f.value)) return **p ? "true" : "false";
    if (auto p = std::get_if<std::string*>(&f.value)) return "\"" + **p + "\"";
    const glm::vec3 c = *std::get<glm::vec3*>(f.value);
    return fmt::format("[{}, {}, {}]", c.x, c.y, c.z);
}

std::vector<int> std140_offsets(const std::vector<Field>& fields) {
    std::vector<int> offsets;
    int end = 0;
    for (const Field& f : fields) {
        if (!f.uniform || std::holds_alternative<std::string*>(f.value)) continue;
        const int a = alignment(f), at = (end + a - 1) / a * a;
        offsets.push_back(at);
        end = at + size(f);
    }
    offsets.push_back((end + 15) / 16 * 16);
    return offsets;
}

std::vector<unsigned char> std140_block(const std::vector<Field>& fields) {
    const std::vector<int> offsets = std140_offsets(fields);
    std::vector<unsigned char> block(offsets.back());
    std::size_t i = 0;
    for (const Field& f : fields) {
        if (!f.uniform || std::holds_alternative<std::string*>(f.value)) continue;
        unsigned char* at = block.data() + offsets[i++];
        if (auto p = std::get_if<bool*>(&f.value)) {
            const std::uint32_t word = **p;
            std::memcpy(at, &word, 4);
        } else {
            const void* source = std::visit([](auto* p) -> const void* { return p; }, f.value);
            std::memcpy(at, source, size(f));
        }
    }
    return block;
}

}  // namespace plumb
