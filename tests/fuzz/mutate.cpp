#include "mutate.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/content_hash.h"
#include "mutate_json.h"
#include "png_parts.h"

namespace plumb::fuzz {
namespace {

using Random = std::minstd_rand;

std::size_t pick(Random& random, std::size_t count) { return count == 0 ? 0 : random() % count; }

// `text` after a change of its bytes, at most `limit` of them.
std::string changed(ChangeBytes change, const std::string& text, std::size_t limit) {
    limit = std::max<std::size_t>({limit, text.size(), 1});
    std::string out = text;
    out.resize(limit);
    out.resize(change(reinterpret_cast<std::uint8_t*>(out.data()), text.size(), limit));
    return out;
}

std::uint32_t little_word(const std::string& s, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | std::uint8_t(s[at + i]);
    return value;
}
std::string little_bytes(std::uint64_t value, int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += char(value >> 8 * i & 255);
    return bytes;
}

// Lines that move, are doubled or left out.
std::optional<std::string> change_lines(const std::string& file, Random& random) {
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < file.size();) {
        const std::size_t end = std::min(file.find('\n', at), file.size() - 1) + 1;
        lines.push_back(file.substr(at, end - at));
        at = end;
    }
    if (lines.size() < 2) return {};
    const std::size_t a = pick(random, lines.size()), b = pick(random, lines.size());
    switch (pick(random, 3)) {
        case 0: std::swap(lines[a], lines[b]); break;
        case 1: lines.insert(lines.begin() + std::ptrdiff_t(a), std::string(lines[b])); break;
        default: lines.erase(lines.begin() + std::ptrdiff_t(a)); break;
    }
    std::string out;
    for (const std::string& line : lines) out += line;
    return out;
}

std::optional<std::string> change_json(const std::string& file, Random& random, ChangeBytes change, std::size_t limit) {
    if (pick(random, 2) == 0) return changed(change, file, limit);
    return mutate_json(file, std::uint32_t(random()));
}

// A GLB whose JSON or BIN is another, under right lengths.
std::optional<std::string> change_glb(const std::string& file, Random& random, ChangeBytes change, std::size_t limit) {
    if (file.size() < 20) return {};
    const std::size_t json_size = std::min<std::size_t>(little_word(file, 12), file.size() - 20);
    std::string json = file.substr(20, json_size), binary;
    const std::size_t after = 20 + json_size + 8;
    const bool has_binary = after <= file.size();
    if (has_binary) binary = file.substr(after);
    const std::size_t room = limit > file.size() ? limit - file.size() : 0;
    if (has_binary && pick(random, 3) == 0)
        binary = changed(change, binary, binary.size() + room);
    else if (const auto other = change_json(json, random, change, json.size() + room))
        json = *other;
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    const std::size_t size = 20 + json.size() + (has_binary ? 8 + binary.size() : 0);
    std::string out = "glTF" + little_bytes(2, 4) + little_bytes(size, 4) + little_bytes(json.size(), 4) + "JSON" + json;
    if (has_binary) out += little_bytes(binary.size(), 4) + std::string("BIN\0", 4) + binary;
    return out;
}

// A PNG with one chunk changed, moved, doubled or left out, under right lengths and checksums.
std::optional<std::string> change_png(const std::string& file, Random& random, ChangeBytes change, std::size_t limit) {
    std::vector<PngChunk> chunks = split_png(file);
    if (chunks.empty()) return {};
    const std::size_t a = pick(random, chunks.size()), b = pick(random, chunks.size());
    const std::size_t room = limit > file.size() ? limit - file.size() : 0;
    std::string& data = chunks[a].data;
    switch (pick(random, 8)) {
        case 0: std::swap(chunks[a], chunks[b]); break;
        case 1: chunks.insert(chunks.begin() + std::ptrdiff_t(a), PngChunk(chunks[b])); break;
        case 2: chunks.erase(chunks.begin() + std::ptrdiff_t(a)); break;
        case 3: {
            static constexpr const char* types[] = {"PLTE", "tRNS", "gAMA", "sRGB", "iCCP", "tEXt", "zTXt", "iTXt",
                                                    "cHRM", "pHYs", "bKGD", "sBIT", "hIST", "tIME", "eXIf", "IDAT"};
            chunks[a].type = types[pick(random, std::size(types))];
            break;
        }
        case 4:  // the header's numbers: sizes, depth, colour, interlacing
            if (chunks[0].data.size() == 13) {
                static constexpr unsigned char values[] = {0, 1, 2, 3, 4, 6, 8, 16, 32, 127, 255};
                static constexpr std::size_t places[] = {3, 7, 8, 9, 12, 2, 6, 8, 9, 12};
                chunks[0].data[places[pick(random, std::size(places))]] = char(values[pick(random, std::size(values))]);
            }
            break;
        case 5:  // what is packed, under a right checksum of its own
            for (PngChunk& chunk : chunks)
                if (chunk.type == "IDAT") {
                    if (const auto rows = inflate(chunk.data, 1 << 16))
                        chunk.data = deflate(changed(change, *rows, rows->size() + room));
                    break;
                }
            break;
        default: data = changed(change, data, data.size() + room); break;
    }
    return join_png(chunks);
}

// The value of one attribute of the header of an EXR (name, type, size, value), or a part of what follows, in place: the
// table of offsets stays right.
std::optional<std::string> change_exr(const std::string& file, Random& random, ChangeBytes change) {
    struct Part {
        std::size_t at, size;
    };
    std::vector<Part> values;
    std::size_t at = 8;
    while (at < file.size() && file[at] != 0) {
        const std::size_t name_end = file.find('\0', at);
        const std::size_t type_end = name_end == file.npos ? file.npos : file.find('\0', name_end + 1);
        if (type_end == file.npos || type_end + 5 > file.size()) break;
        const std::size_t size = little_word(file, type_end + 1), value = type_end + 5;
        if (size > file.size() - value) break;
        values.push_back({value, size});
        values.push_back({type_end + 1, 4});
        at = value + size;
    }
    const std::size_t rest = std::min(at + 1, file.size());
    if (rest < file.size()) {
        const std::size_t from = rest + pick(random, file.size() - rest);
        values.push_back({from, std::min<std::size_t>(file.size() - from, 1 + pick(random, 24))});
        values.push_back({rest, std::min<std::size_t>(file.size() - rest, 24)});
    }
    if (values.empty()) return {};
    const Part part = values[pick(random, values.size())];
    if (part.size == 0) return {};
    std::string value = changed(change, file.substr(part.at, part.size), part.size);
    value.resize(part.size);
    std::string out = file;
    return out.replace(part.at, part.size, value);
}

// The header of a bundle (io/README.md) under its checksum.
std::optional<std::string> change_bundle(const std::string& file, Random& random, ChangeBytes change, std::size_t limit) {
    if (file.size() < 65 || file[0] % 2 == 0) return {};
    const std::size_t start = little_word(file, 1 + 12);
    if (start < 32 || start > file.size() - 1) return {};
    std::string header = file.substr(1 + 24, start - 32);
    header.erase(header.find_last_not_of(' ') + 1);
    const auto other = change_json(header, random, change, limit > 128 ? limit - 128 : 0);
    if (!other) return {};
    header = *other;
    const std::string arrays = file.substr(1 + start);
    const std::size_t end = (24 + header.size() + 8 + 63) / 64 * 64;
    header.resize(end - 32, ' ');
    const std::string head =
        "PLUMBNDL" + file.substr(9, 4) + little_bytes(end, 4) + little_bytes(end + arrays.size(), 8) + header;
    return file.substr(0, 1) + head + little_bytes(content_hash(head), 8) + arrays;
}

std::optional<std::string> change_format(Target target, const std::string& file, Random& random, ChangeBytes change,
                                         std::size_t limit) {
    if (target == fuzz_gltf) return change_json(file, random, change, limit);
    if (target == fuzz_glb) return change_glb(file, random, change, limit);
    if (target == fuzz_png) return change_png(file, random, change, limit);
    if (target == fuzz_exr) return change_exr(file, random, change);
    if (target == fuzz_array) return change_bundle(file, random, change, limit);
    if (target == fuzz_picture || pick(random, 3) != 0) return {};
    return change_lines(file, random);
}

}  // namespace

std::size_t mutate(Target target, ChangeBytes change, std::uint8_t* data, std::size_t size, std::size_t limit,
                   unsigned seed) {
    Random random(seed);
    random.discard(2);
    if (pick(random, 8) != 0) {
        const std::string file(reinterpret_cast<const char*>(data), size);
        const auto other = change_format(target, file, random, change, limit);
        if (other && !other->empty() && other->size() <= limit) {
            std::memcpy(data, other->data(), other->size());
            return other->size();
        }
    }
    return change(data, size, limit);
}

}  // namespace plumb::fuzz
