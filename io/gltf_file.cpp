// glTF's container: GLB chunks, buffers, URIs. glTF 2.0, 3.6.1 and 4.4.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "core/error.h"
#include "io/file.h"
#include "io/gltf_document.h"

namespace plumb::io {
namespace {

constexpr std::size_t max_json_bytes = std::size_t(1) << 30;

std::uint32_t word_at(const std::vector<unsigned char>& bytes, std::size_t at) {
    return bytes[at] | std::uint32_t(bytes[at + 1]) << 8 | std::uint32_t(bytes[at + 2]) << 16 |
           std::uint32_t(bytes[at + 3]) << 24;
}

// The chunks of a GLB: JSON, then what follows it at once if that is BIN.
struct Chunks {
    std::string_view json;
    std::optional<ByteSpan> binary;
};

Chunks split_glb(const std::string& path, const std::vector<unsigned char>& file) {
    const auto fail = [&](std::size_t at, const std::string& cause) {
        throw InputError(shown(path), fmt::format("byte {}", at), cause);
    };
    if (file.size() < 12) fail(file.size(), "the header of 12 bytes is cut off");
    if (word_at(file, 4) != 2) fail(4, fmt::format("GLB version {}; expected 2", word_at(file, 4)));
    if (word_at(file, 8) != file.size())
        fail(8, fmt::format("declares {} bytes; the file has {}", word_at(file, 8), file.size()));
    Chunks chunks;
    std::size_t at = 12;
    for (int number = 0; at < file.size(); ++number) {
        if (file.size() - at < 8) fail(at, "the header of a chunk is cut off");
        const std::size_t length = word_at(file, at), type = word_at(file, at + 4);
        if (length % 4 != 0) fail(at, fmt::format("a chunk of {} bytes; expected a multiple of 4", length));
        if (length > file.size() - at - 8)
            fail(at, fmt::format("a chunk of {} bytes; {} are left", length, file.size() - at - 8));
        if (number == 0 && type != 0x4e4f534a) fail(at + 4, "the first chunk is not JSON");
        const unsigned char* data = file.data() + at + 8;
        if (number == 0) chunks.json = {reinterpret_cast<const char*>(data), length};
        if (number == 1 && type == 0x004e4942) chunks.binary = ByteSpan{data, length};
        at += 8 + length;
    }
    if (at == 12) fail(12, "there is no JSON chunk");
    return chunks;
}

// RFC 4648, with or without padding; none where a character is no digit.
std::optional<std::vector<unsigned char>> decode_base64(std::string_view text) {
    static const std::array<signed char, 256> value = [] {
        std::array<signed char, 256> v;
        v.fill(-1);
        const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (std::size_t i = 0; i < digits.size(); ++i) v[static_cast<unsigned char>(digits[i])] = char(i);
        return v;
    }();
    for (int i = 0; i < 2 && !text.empty() && text.back() == '='; ++i) text.remove_suffix(1);
    if (text.size() % 4 == 1) return {};
    std::vector<unsigned char> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const int digit = value[static_cast<unsigned char>(text[i])];
        if (digit < 0) return {};
        bits = bits << 6 | std::uint32_t(digit);
        if (i % 4 != 0) bytes.push_back(static_cast<unsigned char>(bits >> (6 - 2 * (i % 4)) & 255));
    }
    return bytes;
}

int hexadecimal(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

void check_asset(GltfDocument& document) {
    if (!document.json.is_object()) document.root().fail("expected an object");
    const JsonValue asset = document.list("asset").required();
    const std::string version = asset["version"].text();
    if (version.compare(0, 2, "2.") != 0) asset["version"].fail("expected glTF 2.0");
    if (asset["minVersion"] && asset["minVersion"].text() != "2.0") asset["minVersion"].fail("expected glTF 2.0");

    const std::vector<std::string> read = {"KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization",
                                           "KHR_texture_transform"};
    // What these change is how a surface looks, or when: all else is as the file says without them.
    const std::vector<std::string> harmless = {
        "KHR_animation_pointer",       "KHR_materials_anisotropy",  "KHR_materials_clearcoat",
        "KHR_materials_diffuse_transmission", "KHR_materials_dispersion", "KHR_materials_ior",
        "KHR_materials_iridescence",   "KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen",
        "KHR_materials_specular",      "KHR_materials_transmission", "KHR_materials_unlit",
        "KHR_materials_variants",      "KHR_materials_volume",       "KHR_xmp_json_ld",
    };
    const auto among = [](const std::vector<std::string>& list, const std::string& name) {
        return std::find(list.begin(), list.end(), name) != list.end();
    };
    const JsonValue required = document.list("extensionsRequired"), used = document.list("extensionsUsed");
    for (std::size_t i = 0; i < required.size(); ++i) {
        const std::string name = required[i].text();
        if (among(read, name)) continue;
        if (document.strict || !among(harmless, name)) required[i].fail("the file requires an extension that is not read");
        document.note(fmt::format("the file requires extension {}, which is not read: it is drawn without", printable(name)));
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
        const std::string name = used[i].text();
        bool is_required = false;
        for (std::size_t k = 0; k < required.size(); ++k) is_required = is_required || required[k].text() == name;
        document.quantized = document.quantized || name == "KHR_mesh_quantization";
        if (!among(read, name) && !is_required) document.note(fmt::format("extension {} is not read", printable(name)));
    }
    if (document.list("animations").size() > 0) document.note("animations are not read: all stands still");
}

void load_buffers(GltfDocument& document, const std::optional<ByteSpan>& binary) {
    // One file may be named by several buffers.
    std::map<std::string, std::size_t> loaded_from;
    const JsonValue buffers = document.list("buffers");
    document.loaded.reserve(buffers.size());
    for (std::size_t i = 0; i < buffers.size(); ++i) {
        const std::uint64_t length = buffers[i]["byteLength"].integer(1, max_file_bytes);
        ByteSpan bytes;
        const JsonValue uri = buffers[i]["uri"];
        if (!uri) {
            if (i != 0 || !binary) buffers[i].fail("has no uri, and no GLB chunk holds it");
            bytes = *binary;
        } else {
            const std::string text = uri.text();
            std::optional<std::vector<unsigned char>> data = decode_data_uri(uri, text);
            const std::string file = data ? "" : file_of_uri(document, uri, text);
            const auto known = data ? loaded_from.end() : loaded_from.find(file);
            if (known == loaded_from.end()) {
                if (!data) {
                    try {
                        data = read_bytes(file);
                    } catch (const InputError& e) {
                        throw InputError(shown(document.path) + ": " + uri.pointer() + ": " + e.what());
                    }
                    loaded_from[file] = document.loaded.size();
                }
                document.loaded.push_back(std::move(*data));
                bytes = {document.loaded.back().data(), document.loaded.back().size()};
            } else {
                const std::vector<unsigned char>& again = document.loaded[known->second];
                bytes = {again.data(), again.size()};
            }
        }
        if (bytes.size < length)
            buffers[i]["byteLength"].fail(fmt::format("the buffer has {} bytes", bytes.size));
        bytes.size = std::size_t(length);
        document.buffers.push_back(bytes);
    }
}

}  // namespace

void GltfDocument::count_zeros(std::size_t elements, const JsonValue& place) const {
    std::size_t limit = 4096 + file.size();
    for (const std::vector<unsigned char>& buffer : loaded) limit += buffer.size();
    zeros += elements;
    if (zeros > limit)
        place.fail(fmt::format("accessors without a bufferView have {} elements; a file of {} bytes may have {}", zeros,
                               limit - 4096, limit));
}

void GltfDocument::note(const std::string& text) {
    if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
}

void open_gltf(GltfDocument& document) {
    const std::vector<unsigned char>& file = document.file;
    if (file.empty()) throw InputError(shown(document.path), "", "is empty; expected glTF");
    Chunks chunks;
    if (file.size() >= 4 && std::memcmp(file.data(), "glTF", 4) == 0)
        chunks = split_glb(document.path, file);
    else if (extension_of(document.path) == "glb")
        throw InputError(shown(document.path), "byte 0", "does not begin as a .glb file does, with \"glTF\"");
    else
        chunks.json = {reinterpret_cast<const char*>(file.data()), file.size()};
    if (chunks.json.size() > max_json_bytes)
        throw InputError(shown(document.path), "",
                         fmt::format("has {} bytes of JSON; the limit is {}", chunks.json.size(), max_json_bytes));
    document.json = parse_gltf_json(document.path, chunks.json);
    check_asset(document);
    load_buffers(document, chunks.binary);
}

std::optional<std::vector<unsigned char>> decode_data_uri(const JsonValue& uri, std::string_view text) {
    if (text.substr(0, 5) != "data:") return {};
    const std::size_t comma = text.find(',');
    if (comma == text.npos) uri.fail("a data: URI without a comma");
    if (text.substr(0, comma).find(";base64") == text.npos) uri.fail("a data: URI that is not base64");
    std::optional<std::vector<unsigned char>> bytes = decode_base64(text.substr(comma + 1));
    if (!bytes) uri.fail("a data: URI that is not base64");
    return bytes;
}

std::string file_of_uri(const GltfDocument& document, const JsonValue& uri, std::string_view text) {
    std::string name;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%') {
            const int high = i + 2 < text.size() ? hexadecimal(text[i + 1]) : -1;
            const int low = i + 2 < text.size() ? hexadecimal(text[i + 2]) : -1;
            if (high < 0 || low < 0) uri.fail("\"%\" without two hexadecimal digits");
            name += char(high * 16 + low);
            i += 2;
        } else {
            name += text[i];
        }
    }
    // A scheme ends at a colon before any slash (RFC 3986, 3.1).
    if (text.find(':') < text.find('/')) uri.fail("only files beside this one and data: are read");
    if (name.empty() || name[0] == '/') uri.fail("expected the name of a file beside this one");
    return beside(document.path, name);
}

ByteSpan view_bytes(const GltfDocument& document, const JsonValue& index) {
    const JsonValue views = document.list("bufferViews");
    const JsonValue view = views[*index.required().index(views.size(), "bufferViews")];
    const ByteSpan buffer = document.buffers[*view["buffer"].required().index(document.buffers.size(), "buffers")];
    const std::uint64_t offset = view["byteOffset"].integer(0, max_file_bytes, 0);
    const std::uint64_t length = view["byteLength"].integer(1, max_file_bytes);
    if (offset > buffer.size || length > buffer.size - offset)
        view.fail(fmt::format("bytes {} to {} of a buffer of {}", offset, offset + length, buffer.size));
    return {buffer.data + offset, std::size_t(length)};
}

}  // namespace plumb::io
