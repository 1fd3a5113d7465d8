#include "tools/vulkan/twins.h"

#include <algorithm>
#include <bit>

#include "tools/vulkan/device.h"
#include "tools/vulkan/embedded_twins.h"

namespace plumb::vulkan {

namespace {

constexpr std::size_t header_words = 4, tap_words = 8;

struct Tap {
    int run;
    TapValue value;
};

Tap read_tap(const Twin& twin, std::span<const std::int32_t> words) {
    if (words[0] < 0 || words[0] >= int(twin.taps.size()) || words[2] < 1 || words[2] > 4)
        throw Error(twin.name + ": the device wrote a tap that the twin does not have");
    TapValue value{twin.taps[std::size_t(words[0])], words[1], {}, ""};
    for (int c = 0; c < words[2]; ++c) value.value.push_back(std::bit_cast<float>(words[std::size_t(4 + c)]));
    return {words[3], std::move(value)};
}

}  // namespace

Twin find_twin(const std::string& name) {
    if (embedded_twins().empty())
        throw Error("no twins: this program was built without glslangValidator and spirv-val, which compile them");
    for (const EmbeddedTwin& e : embedded_twins()) {
        if (name != e.name) continue;
        Twin twin{name, e.spirv, e.tapped, {}};
        for (const char* const* tap = e.taps; *tap; ++tap) twin.taps.push_back(*tap);
        return twin;
    }
    throw Error("no twin \"" + name + "\"");
}

std::vector<TapValue> read_taps(const Twin& twin, std::span<const std::int32_t> buffer, bool reversed_z) {
    const std::size_t room = (buffer.size() - header_words) / tap_words;
    const std::size_t count = std::min(room, std::size_t(std::max(buffer[3], 0)));
    std::vector<Tap> taps;
    for (std::size_t i = 0; i < count; ++i)
        taps.push_back(read_tap(twin, buffer.subspan(header_words + i * tap_words, tap_words)));

    // Of equal depth the triangle that was drawn first stays.
    const Tap* seen = nullptr;
    for (const Tap& t : taps) {
        if (t.value.name != "z") continue;
        const double z = t.value.value[0], best = seen ? seen->value.value[0] : 0;
        const bool nearer = reversed_z ? z > best : z < best;
        if (!seen || nearer || (z == best && t.run < seen->run)) seen = &t;
    }
    std::vector<TapValue> values;
    for (const Tap& t : taps)
        if (!seen || t.run == seen->run) values.push_back(t.value);
    return values;
}

}  // namespace plumb::vulkan
