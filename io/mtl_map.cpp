#include "io/mtl_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "io/file.h"
#include "io/image_decode.h"
#include "io/image_file.h"
#include "io/named_file.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

// Words of an option that follow it: numbers, of which `least` must be there, or words.
struct Option {
    std::string_view name;
    int numbers, least, words;
    bool matters;  // to the picture, and is not read
};
constexpr Option options[] = {
    {"-s", 3, 1, 0, false},      {"-o", 3, 1, 0, false},       {"-clamp", 0, 0, 1, false}, {"-t", 3, 1, 0, true},
    {"-mm", 2, 2, 0, true},      {"-bm", 1, 1, 0, false},      {"-boost", 1, 1, 0, false}, {"-texres", 1, 1, 0, false},
    {"-blendu", 0, 0, 1, false}, {"-blendv", 0, 0, 1, false},  {"-cc", 0, 0, 1, false},    {"-imfchan", 0, 0, 1, true},
    {"-type", 0, 0, 1, true},    {"-colorspace", 0, 0, 1, true}};

void add_name(std::string& list, std::string_view name) {
    if (list.find(name) != list.npos) return;
    list += (list.empty() ? "" : ", ") + std::string(name);
}

std::uint32_t channel(std::uint32_t texel, int c) { return texel >> (8 * c) & 255; }

// What cuts out: the picture's alpha where it has one that is not 1 everywhere, else its red.
std::uint32_t opacity(const Texture& mask, bool by_alpha, int x, int y) { return channel(mask.texels(x, y), by_alpha ? 3 : 0); }

bool has_alpha(const Texture& t) {
    return std::any_of(t.texels.texels.begin(), t.texels.texels.end(), [](std::uint32_t texel) { return texel >> 24 != 255; });
}

// Normals point out of the surface: blue is far above red and green, which are a half in the mean. Heights are grey.
bool shows_normals(const Texture& t) {
    double sum[3] = {0, 0, 0};
    for (const std::uint32_t texel : t.texels.texels)
        for (int c = 0; c < 3; ++c) sum[c] += channel(texel, c);
    const double n = 255 * double(t.texels.size());
    return sum[2] / n - std::max(sum[0], sum[1]) / n > 0.125;
}

}  // namespace

MtlMap parse_map(const std::string& path, std::int64_t line, std::string_view key, std::string_view rest) {
    MtlMap map;
    map.key = std::string(key), map.line = line;
    for (;;) {
        std::string_view after = rest;
        const std::string_view word = next_word(after);
        const auto option = std::find_if(std::begin(options), std::end(options), [&](const Option& o) { return o.name == word; });
        if (option == std::end(options)) break;
        double values[3] = {0, 0, 0};
        int n = 0;
        for (std::string_view ahead = after; n < option->numbers; ++n, after = ahead) {
            const auto number = parse_float(next_word(ahead));
            if (!number) break;
            if (!(*number >= -1e6f && *number <= 1e6f))
                throw InputError(shown(path), fmt::format("line {}", line),
                                 fmt::format("{}: {} {}: expected a number from -1e6 to 1e6", key, word, *number));
            values[n] = double(*number);
        }
        if (n < option->least)
            throw InputError(shown(path), fmt::format("line {}", line),
                             fmt::format("{}: {} has {} numbers; expected {}", key, word, n, option->least));
        std::string_view argument;
        for (int i = 0; i < option->words; ++i) argument = next_word(after);
        if (word == "-s") map.mapping.scale = {values[0], n > 1 ? values[1] : 1};
        if (word == "-o") map.mapping.offset = {values[0], values[1]};
        if (word == "-clamp") map.clamp = argument == "on";
        if (option->matters) add_name(map.unread, word);
        rest = after;
    }
    // An option that nobody knows has a number of words that nobody knows: the name is the last.
    std::string_view name = trimmed(rest);
    if (!name.empty() && name[0] == '-' && name.find_first_of(" \t") != name.npos) {
        std::string_view words = name;
        add_name(map.unread, next_word(words));
        name.remove_prefix(name.find_last_of(" \t") + 1);
    }
    map.file = std::string(name);
    return map;
}

std::string MtlMaps::loaded(const MtlMap& map) {
    const auto lacks = [&](const std::string& cause) {
        findings_.add("picture", path_, map.line, map.key + cause, "its material goes without");
        return std::string();
    };
    if (map.file.empty()) return lacks(" names no file");
    const std::string file = find_similar(path_, map.line, map.file, second_folder_, findings_);
    if (file.empty()) return lacks(": there is no file \"" + printable(map.file) + "\"");
    if (!is_picture(extension_of(file))) return lacks(": \"" + printable(map.file) + "\" is of no kind of pictures that is read");
    if (loaded_.count(file) == 0) {
        try {
            loaded_[file] = read_texture(file);
        } catch (const InputError& e) {
            throw InputError(shown(path_), fmt::format("line {}", map.line), map.key + ": " + e.what());
        }
    }
    return file;
}

int MtlMaps::keep(const std::string& key, const MtlMap& map, Texture texture) {
    if (map.clamp) texture.wrap_u = texture.wrap_v = Wrap::clamp_to_edge;
    textures_.push_back(std::move(texture));
    return known_[key] = int(textures_.size()) - 1;
}

int MtlMaps::colour(const MtlMap& map) {
    const std::string file = loaded(map);
    if (file.empty()) return -1;
    const std::string key = fmt::format("colour {} {}", map.clamp, file);
    const auto known = known_.find(key);
    return known != known_.end() ? known->second : keep(key, map, loaded_[file]);
}

int MtlMaps::masked(const MtlMap& map, const MtlMap& mask) {
    const std::string mask_file = loaded(mask), file = map.line > 0 ? loaded(map) : "";
    if (mask_file.empty()) return -1;
    const std::string key = fmt::format("masked {} {} {}\n{}", map.clamp, mask.clamp, file, mask_file);
    const auto known = known_.find(key);
    if (known != known_.end()) return known->second;

    const Texture& cut = loaded_[mask_file];
    Texture texture = file.empty() ? cut : loaded_[file];
    const bool by_alpha = has_alpha(cut);
    const glm::ivec2 size(texture.texels.width, texture.texels.height), from(cut.texels.width, cut.texels.height);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            // The mask's texel that holds the centre of this one.
            const int mx = int((2 * std::int64_t(x) + 1) * from.x / (2 * size.x)), my = int((2 * std::int64_t(y) + 1) * from.y / (2 * size.y));
            std::uint32_t& texel = texture.texels(x, y);
            texel = (file.empty() ? 0xffffffu : texel & 0xffffffu) | opacity(cut, by_alpha, mx, my) << 24;
        }
    return keep(key, map.line > 0 ? map : mask, std::move(texture));
}

int MtlMaps::normals(const MtlMap& map, bool& heights) {
    heights = false;
    const std::string file = loaded(map);
    if (file.empty()) return -1;
    heights = !shows_normals(loaded_[file]);
    if (heights) return -1;
    const std::string key = fmt::format("normals {} {}", map.clamp, file);
    const auto known = known_.find(key);
    if (known != known_.end()) return known->second;
    Texture texture = loaded_[file];
    texture.srgb = false;
    return keep(key, map, std::move(texture));
}

}  // namespace plumb::io
