#include "io/bundle_file.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/file.h"

namespace plumb::io {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view magic = "PLUMBNDL";
constexpr std::uint32_t version = 1;
constexpr std::size_t header_start = 16, alignment = 64, checksum_bytes = 8;
constexpr std::size_t max_header_bytes = std::size_t(1) << 24, max_arrays = 4096, max_rank = 32;

std::size_t aligned(std::size_t n) { return (n + alignment - 1) / alignment * alignment; }

// Numbers in files are little-endian.
template <class Word>
std::string little_endian(Word word) {
    std::string bytes;
    for (std::size_t i = 0; i < sizeof(Word); ++i) bytes += char(word >> 8 * i & 255);
    return bytes;
}
template <class Word>
Word from_little_endian(const unsigned char* p) {
    Word word = 0;
    for (std::size_t i = 0; i < sizeof(Word); ++i) word |= Word(p[i]) << 8 * i;
    return word;
}

std::string_view view_of(const Array& array) {
    return {reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size()};
}

// One entry of the header; its bytes must begin at `offset`.
Array parse_entry(const std::string& path, const Json& entry, std::size_t offset, std::size_t end) {
    const auto fail = [&](const std::string& cause) -> void { throw InputError(shown(path), "header", cause); };
    const bool has_keys = entry.is_object() && entry.size() == 4 && entry.contains("name") && entry.contains("type") &&
                          entry.contains("shape") && entry.contains("offset");
    if (!has_keys || !entry["name"].is_string() || !entry["type"].is_string() || !entry["shape"].is_array() ||
        !entry["offset"].is_number_unsigned() || entry["shape"].size() > max_rank)
        fail("expected an array's name, type, shape and offset");
    Array array;
    array.name = entry["name"].get<std::string>();
    array.dtype = parse_dtype(printable(entry["type"].get<std::string>()), shown(path) + ": header");
    for (const Json& extent : entry["shape"]) {
        if (!extent.is_number_unsigned() || extent.get<std::uint64_t>() > std::uint64_t(1) << 62)
            fail("an extent is not a whole number");
        array.shape.push_back(extent.get<std::int64_t>());
    }
    if (entry["offset"].get<std::uint64_t>() != offset)
        fail("array \"" + printable(array.name) + "\" does not begin where the one before it ends");
    std::size_t size = 0;
    try {
        size = element_count(printable(array.name), array.shape) * dtype_size(array.dtype);
    } catch (const InputError& e) {
        fail(e.what());
    }
    if (size > end - offset)
        fail(fmt::format("array \"{}\" of {} bytes goes beyond the end of the file", printable(array.name), size));
    array.bytes.resize(size);
    return array;
}

}  // namespace

void write_bundle(const std::string& path, const Bundle& bundle) {
    if (bundle.arrays.size() > max_arrays)
        throw InputError(shown(path), "", fmt::format("cannot be written: more than {} arrays", max_arrays));
    // Where each array begins depends on nothing but those before it; offsets count from the first array.
    Json arrays = Json::array();
    std::size_t offset = 0;
    for (const Array& array : bundle.arrays) {
        require(array, array.dtype, array.shape);
        arrays.push_back(
            {{"name", array.name}, {"type", dtype_name(array.dtype)}, {"shape", array.shape}, {"offset", offset}});
        offset = aligned(offset + array.bytes.size());
    }
    std::string header;
    try {
        header = Json{{"arrays", arrays}}.dump();
    } catch (const Json::exception&) {
        throw InputError(shown(path), "", "cannot be written: the name of an array is not UTF-8");
    }
    header.resize(aligned(header_start + header.size()) - header_start, ' ');

    // One buffer, so that the checksum is over the bytes as they lie in the file.
    std::string file =
        std::string(magic) + little_endian(version) + little_endian(std::uint32_t(header.size())) + header;
    file.reserve(file.size() + offset + checksum_bytes);
    for (const Array& array : bundle.arrays) {
        file += view_of(array);
        file.resize(aligned(file.size()));
    }
    file += little_endian(content_hash(file));
    write_file(path, {file});
}

Bundle read_bundle(const std::string& path) {
    const std::vector<unsigned char> file = read_bytes(path);
    const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
    if (bytes.substr(0, magic.size()) != magic)
        throw InputError(shown(path), "byte 0", bytes.empty() ? "is empty; expected a bundle" : "is not a bundle");
    if (file.size() < header_start + checksum_bytes) throw InputError(shown(path), "header", "the file is cut off");
    const std::uint32_t found = from_little_endian<std::uint32_t>(file.data() + 8);
    if (found != version)
        throw InputError(shown(path), "byte 8", fmt::format("version {}; this program reads {}", found, version));
    const std::size_t end = file.size() - checksum_bytes;
    const std::size_t length = from_little_endian<std::uint32_t>(file.data() + 12);
    if (length > max_header_bytes || length > end - header_start)
        throw InputError(shown(path), "byte 12", fmt::format("a header of {} bytes does not fit", length));

    // Nothing in the file is believed before its checksum is right.
    const auto checksum = content_hash(file.data(), end);
    if (checksum != from_little_endian<std::uint64_t>(file.data() + end))
        throw InputError(shown(path), "end", "the checksum is wrong: the file is cut off or was changed");

    Bundle bundle;
    const Json header = Json::parse(bytes.substr(header_start, length), nullptr, false);
    if (!header.is_object() || header.size() != 1 || !header.contains("arrays") || !header["arrays"].is_array() ||
        header["arrays"].size() > max_arrays)
        throw InputError(shown(path), "header", "expected a list of arrays");
    const std::size_t first = header_start + length;
    std::size_t offset = 0;
    for (const Json& entry : header["arrays"]) {
        try {
            Array array = parse_entry(path, entry, offset, end - first);
            if (find(bundle, array.name)) throw InputError(shown(path), "header", "two arrays have one name");
            if (!array.bytes.empty()) std::memcpy(array.bytes.data(), file.data() + first + offset, array.bytes.size());
            offset = std::min(aligned(offset + array.bytes.size()), end - first);
            bundle.arrays.push_back(std::move(array));
        } catch (const Json::exception& e) {
            throw InputError(shown(path), "header", printable(e.what(), 200));
        }
    }
    if (first + offset != end) throw InputError(shown(path), "end", "bytes follow the last array");
    return bundle;
}

}  // namespace plumb::io
