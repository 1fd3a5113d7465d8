#include "gi/stability/moved_inputs.h"

#include <fmt/format.h>

#include "core/hash.h"

namespace plumb::stability {

namespace {

constexpr std::size_t small_buffer = 64;  // numbers; so many are moved one by one

float load(const Input& in, std::size_t i) {
    float x;
    std::memcpy(&x, in.bytes + 4 * (in.first + i * in.stride), 4);
    return x;
}
void store(const Input& in, std::size_t i, float x) { std::memcpy(in.bytes + 4 * (in.first + i * in.stride), &x, 4); }

bool finite(float x) { return x - x == 0; }

bool is_fixed(std::uint32_t mask, std::size_t column) { return column < 32 && (mask >> column & 1); }

// Numbers of a row: texels of an image, rows of a buffer whose elements have several components.
std::size_t columns_of(const Slot& slot, const Array& array) {
    if (slot.kind == SlotKind::buffer && slot.channels > 1 && array.shape.size() > 1)
        return std::size_t(array.shape.back());
    return std::size_t(slot.channels);
}

void append_slot(const Slot& slot, Array& array, std::vector<Input>& out) {
    const std::size_t numbers = array.bytes.size() / 4, columns = columns_of(slot, array);
    if (slot.dtype != DType::f32 || columns == 0 || numbers < columns) return;
    for (std::size_t c = 0; c < columns; ++c) {
        if (is_fixed(slot.fixed, c)) continue;
        const std::size_t rows = numbers / columns;
        if (slot.kind == SlotKind::buffer && numbers <= small_buffer)
            for (std::size_t r = 0; r < rows; ++r)
                out.push_back({fmt::format("{}[{}][{}]", slot.name, r, c), array.bytes.data(), r * columns + c, 1, 1});
        else
            out.push_back({fmt::format("{}.{}", slot.name, c), array.bytes.data(), c, columns, rows});
    }
}

void append_member(const UniformMember& member, StageData& data, std::vector<Input>& out) {
    const int numbers = member.type == "float" ? 1 : member.type == "vec3" ? 3 : member.type == "vec4" ? 4 : 0;
    for (int c = 0; c < numbers; ++c)
        if (!is_fixed(member.fixed, std::size_t(c)))
            out.push_back(
                {fmt::format("{}.{}", member.name, c), data.uniforms.data() + member.offset, std::size_t(c), 1, 1});
}

// Whether the number is moved up.
bool goes_up(const Input& in, std::size_t i, float x, int way) {
    if (in.count == 1) return way == 0;
    if (way == 0) return x > 0;
    if (way == 1) return true;
    return pcg3d(std::int32_t(i), std::int32_t(in.first), std::int32_t(way)).x & 1;
}

}  // namespace

std::vector<Input> inputs_of(const StageBinding& binding, StageData& data) {
    std::vector<Input> out;
    for (const Slot& slot : binding.inputs)
        for (Array& array : data.inputs.arrays)
            if (array.name == slot.name) append_slot(slot, array, out);
    for (const UniformMember& member : binding.uniforms) append_member(member, data, out);
    return out;
}

int ways_to_move(const Input& input, int patterns) { return input.count == 1 ? 2 : patterns; }

float moved(float x, bool up) {
    using N = number<float>;
    if (x == 0 || !finite(x)) return x;
    const float away = N::from_bits(N::bits(x) + 1), nearer = N::from_bits(N::bits(x) - 1);
    return (x > 0) == up && finite(away) ? away : nearer;
}

bool move(const Input& input, int way, std::vector<float>& before) {
    bool any = false;
    before.resize(input.count);
    for (std::size_t i = 0; i < input.count; ++i) {
        const float x = before[i] = load(input, i), to = moved(x, goes_up(input, i, x, way));
        any = any || (finite(x) && to != x);
        store(input, i, to);
    }
    return any;
}

void put_back(const Input& input, const std::vector<float>& before) {
    for (std::size_t i = 0; i < input.count; ++i) store(input, i, before[i]);
}

}  // namespace plumb::stability
