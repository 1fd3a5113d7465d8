#include "io/bundle_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "io/file.h"
#include "io/gltf_json.h"

namespace plumb::io::bundle_layout {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view magic = "PLUMBNDL";
constexpr std::uint32_t version = 2;
constexpr std::size_t header_start = 24, alignment = 64, checksum_bytes = 8;
constexpr std::size_t max_header_bytes = std::size_t(1) << 24, max_arrays = 4096, max_rank = 32;

// Numbers in files are little-endian.
template <class Word>
std::string little_endian(Word word) {
    std::string bytes;
    for (std::size_t i = 0; i < sizeof(Word); ++i) bytes += char(word >> 8 * i & 255);
    return bytes;
}
template <class Word>
Word from_little_endian(const char* p) {
    Word word = 0;
    for (std::size_t i = 0; i < sizeof(Word); ++i) word |= Word(static_cast<unsigned char>(p[i])) << 8 * i;
    return word;
}

std::string in_quotes(const std::string& name) { return "\"" + printable(name) + "\""; }

// ---- Writing ------------------------------------------------------------------------------------------------------

Json json_of(const NamedFact& fact, const std::string& path) {
    if (const double* number = std::get_if<double>(&fact.value); number && !std::isfinite(*number))
        throw InputError(shown(path), "",
                         "cannot be written: fact " + in_quotes(fact.name) + " is not a finite number");
    return std::visit([](const auto& value) { return Json(value); }, fact.value);
}

Json json_of(const Array& array, const Description* description, std::size_t offset) {
    Json entry = {{"name", array.name}, {"type", dtype_name(array.dtype)}, {"shape", array.shape}};
    if (description) {
        entry["axes"] = description->axes;
        entry["unit"] = description->unit;
        entry["meaning"] = description->meaning;
    }
    entry["offset"] = offset;
    entry["checksum"] = hash_text(content_hash(array.bytes.data(), array.bytes.size()));
    return entry;
}

void require_described(const DescribedFile& file, const auto& fail) {
    if (file.kind.empty()) return;
    if (file.version < 1) fail("its version is below 1");
    if (file.descriptions.size() != file.arrays.arrays.size()) fail("not every array has a description");
    for (std::size_t i = 0; i < file.descriptions.size(); ++i) {
        const Array& array = file.arrays.arrays[i];
        const Description& description = file.descriptions[i];
        if (description.meaning.empty()) fail("array " + in_quotes(array.name) + " has no meaning");
        if (description.axes.size() != array.shape.size())
            fail(fmt::format("array {} has {} extents and {} axes", in_quotes(array.name), array.shape.size(),
                             description.axes.size()));
    }
}

// ---- Reading ------------------------------------------------------------------------------------------------------

// Reads the header, whose checksum is right: what it says may still be impossible.
class HeaderReader {
  public:
    HeaderReader(const std::string& path, std::size_t start, std::size_t file_bytes)
        : path_(path), start_(start), file_bytes_(file_bytes), offset_(start) {}

    Head read(std::string_view text) {
        require_small_json(shown(path_) + ": header", text);
        const Json header = Json::parse(text, nullptr, false);
        const bool described = has_keys(header, {"kind", "version", "facts", "arrays"});
        if ((!described && !has_keys(header, {"arrays"})) || !header["arrays"].is_array() ||
            header["arrays"].size() > max_arrays)
            fail("expected a list of arrays");
        Head head;
        head.file.path = path_;
        if (described) read_kind(header, head.file);
        for (const Json& entry : header["arrays"]) read_entry(entry, described, head);
        if (offset_ != file_bytes_)
            throw InputError(shown(path_), "end", fmt::format("{} bytes follow the last array", file_bytes_ - offset_));
        return head;
    }

  private:
    [[noreturn]] void fail(const std::string& cause) const { throw InputError(shown(path_), "header", cause); }

    static bool has_keys(const Json& json, std::initializer_list<const char*> keys) {
        return json.is_object() && json.size() == keys.size() &&
               std::all_of(keys.begin(), keys.end(), [&](const char* key) { return json.contains(key); });
    }
    static bool is_texts(const Json& json) {
        return json.is_array() && std::all_of(json.begin(), json.end(), [](const Json& j) { return j.is_string(); });
    }
    static bool is_int64(const Json& json) {
        return json.is_number_integer() && (!json.is_number_unsigned() || json.get<std::uint64_t>() >> 63 == 0);
    }

    void read_kind(const Json& header, DescribedFile& file) const {
        const Json& number = header["version"];
        if (!header["kind"].is_string() || header["kind"].get<std::string>().empty() || !is_int64(number) ||
            number.get<std::int64_t>() != std::int32_t(number.get<std::int64_t>()) || !header["facts"].is_object())
            fail("expected a kind, its version and facts");
        file.kind = header["kind"].get<std::string>();
        file.version = number.get<int>();
        for (const auto& [name, value] : header["facts"].items()) {
            if (value.is_string())
                file.facts.push_back({name, value.get<std::string>()});
            else if (is_int64(value))
                file.facts.push_back({name, value.get<std::int64_t>()});
            else if (value.is_number_float())
                file.facts.push_back({name, value.get<double>()});
            else
                fail("fact " + in_quotes(name) + " is neither text nor a number");
        }
    }

    void read_entry(const Json& entry, bool described, Head& head) {
        const bool complete =
            described ? has_keys(entry, {"name", "type", "shape", "axes", "unit", "meaning", "offset", "checksum"})
                      : has_keys(entry, {"name", "type", "shape", "offset", "checksum"});
        if (!complete || !entry["name"].is_string() || !entry["type"].is_string() || !entry["shape"].is_array() ||
            !entry["offset"].is_number_unsigned() || !entry["checksum"].is_string() || entry["shape"].size() > max_rank)
            fail("expected an array's name, type, shape, offset and checksum");
        Array array;
        array.name = entry["name"].get<std::string>();
        if (!names_.insert(array.name).second) fail("two arrays have the name " + in_quotes(array.name));
        array.dtype = parse_dtype(printable(entry["type"].get<std::string>()), shown(path_) + ": header");
        for (const Json& extent : entry["shape"]) {
            if (!extent.is_number_unsigned() || extent.get<std::uint64_t>() > std::uint64_t(1) << 62)
                fail("an extent of array " + in_quotes(array.name) + " is not a whole number");
            array.shape.push_back(extent.get<std::int64_t>());
        }
        head.extents.push_back(read_extent(entry, array));
        head.file.arrays.arrays.push_back(std::move(array));
        if (described) head.file.descriptions.push_back(read_description(entry));
    }

    Description read_description(const Json& entry) const {
        if (!is_texts(entry["axes"]) || entry["axes"].size() != entry["shape"].size() || !entry["unit"].is_string() ||
            !entry["meaning"].is_string())
            fail("array " + in_quotes(entry["name"].get<std::string>()) + ": expected axes, unit and meaning");
        return {entry["unit"].get<std::string>(), entry["meaning"].get<std::string>(),
                entry["axes"].get<std::vector<std::string>>()};
    }

    // Arrays lie one behind the other, inside the file.
    Extent read_extent(const Json& entry, const Array& array) {
        Extent extent;
        extent.offset = offset_;
        if (entry["offset"].get<std::uint64_t>() != offset_ - start_)
            fail("array " + in_quotes(array.name) + " does not begin where the one before it ends");
        try {
            extent.bytes = element_count(printable(array.name), array.shape) * dtype_size(array.dtype);
        } catch (const InputError& e) {
            fail(e.what());
        }
        if (extent.bytes > file_bytes_ - offset_ || aligned(extent.bytes) > file_bytes_ - offset_)
            throw InputError(shown(path_), "array " + in_quotes(array.name),
                             fmt::format("{} bytes go beyond the end of the file", extent.bytes));
        extent.padded_bytes = aligned(extent.bytes);
        offset_ += extent.padded_bytes;

        const std::string text = entry["checksum"].get<std::string>();
        if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != text.npos)
            fail("the checksum of array " + in_quotes(array.name) + " is not 16 hexadecimal digits");
        extent.checksum = std::stoull(text, nullptr, 16);
        return extent;
    }

    const std::string& path_;
    std::size_t start_, file_bytes_, offset_;
    std::set<std::string> names_;
};

// Finds the array in which a file that was cut off ends; what its header says of sizes is not checked yet.
std::string where_cut(const Head& head, std::size_t file_bytes) {
    for (std::size_t i = 0; i < head.extents.size(); ++i)
        if (head.extents[i].offset + head.extents[i].padded_bytes > file_bytes)
            return "array " + in_quotes(head.file.arrays.arrays[i].name);
    return "end";
}

void require_kind(const Head& head, const Kind& kind) {
    const DescribedFile& file = head.file;
    const auto name = [](const std::string& k) { return k.empty() ? "a bundle" : "a file of kind " + in_quotes(k); };
    if (file.kind != kind.name)
        throw InputError(shown(file.path), "header", "is " + name(file.kind) + "; expected " + name(kind.name));
    if (!kind.name.empty() && (file.version < kind.oldest || file.version > kind.newest))
        throw InputError(shown(file.path), "header",
                         fmt::format("version {} of {}; this program reads {}", file.version, in_quotes(file.kind),
                                     kind.oldest == kind.newest ? fmt::format("{}", kind.newest)
                                                                : fmt::format("{} to {}", kind.oldest, kind.newest)));
}

}  // namespace

std::size_t aligned(std::size_t n) { return (n + alignment - 1) / alignment * alignment; }

std::string head_bytes(const std::string& path, const DescribedFile& file) {
    const auto fail = [&](const std::string& cause) {
        throw InputError(shown(path), "", "cannot be written: " + cause);
    };
    if (file.arrays.arrays.size() > max_arrays) fail(fmt::format("more than {} arrays", max_arrays));
    require_described(file, fail);

    const bool described = !file.kind.empty();
    Json header = Json::object();
    if (described) {
        header = {{"kind", file.kind}, {"version", file.version}, {"facts", Json::object()}};
        for (const NamedFact& fact : file.facts) {
            if (header["facts"].contains(fact.name)) fail("two facts have the name " + in_quotes(fact.name));
            header["facts"][fact.name] = json_of(fact, path);
        }
    }
    // Offsets count from the first array, so that they do not depend on the header's length.
    Json arrays = Json::array();
    std::set<std::string> names;
    std::size_t offset = 0;
    for (std::size_t i = 0; i < file.arrays.arrays.size(); ++i) {
        const Array& array = file.arrays.arrays[i];
        require(array, array.dtype, array.shape);
        if (!names.insert(array.name).second) fail("two arrays have the name " + in_quotes(array.name));
        arrays.push_back(json_of(array, described ? &file.descriptions[i] : nullptr, offset));
        offset += aligned(array.bytes.size());
    }
    header["arrays"] = std::move(arrays);

    std::string text;
    try {
        text = header.dump();
    } catch (const Json::exception&) {
        fail("a name or a text is not UTF-8");
    }
    const std::size_t start = aligned(header_start + text.size() + checksum_bytes);
    if (start > max_header_bytes) fail(fmt::format("a header of more than {} bytes", max_header_bytes));
    text.resize(start - header_start - checksum_bytes, ' ');
    std::string head = std::string(magic) + little_endian(version) + little_endian(std::uint32_t(start)) +
                       little_endian(std::uint64_t(start + offset)) + text;
    return head + little_endian(content_hash(head));
}

Head read_head(const std::string& path, const RandomFile& bytes, const Kind& kind) {
    const std::size_t there = std::size_t(bytes.size());
    std::string head(std::min(there, header_start), '\0');
    bytes.read(0, head.size(), head.data());
    if (std::string_view(head).substr(0, magic.size()) != magic)
        throw InputError(shown(path), "byte 0", there ? "is not a bundle" : "is empty; expected a bundle");
    if (head.size() < header_start) throw InputError(shown(path), "header", "the file is cut off");
    if (const auto found = from_little_endian<std::uint32_t>(&head[8]); found != version)
        throw InputError(shown(path), "byte 8", fmt::format("version {}; this program reads {}", found, version));
    const std::size_t start = from_little_endian<std::uint32_t>(&head[12]);
    if (start > max_header_bytes || start < header_start + checksum_bytes || start % alignment != 0)
        throw InputError(shown(path), "byte 12", fmt::format("a header of {} bytes cannot be", start));
    if (start > there) throw InputError(shown(path), "header", "the file is cut off");

    // Nothing in the header is believed before its checksum is right.
    const std::size_t checked = start - checksum_bytes;
    head.resize(start);
    bytes.read(0, start, head.data());
    if (content_hash(head.data(), checked) != from_little_endian<std::uint64_t>(&head[checked]))
        throw InputError(shown(path), "header", "the checksum is wrong: the header was changed");

    const std::size_t written = from_little_endian<std::uint64_t>(&head[16]);
    if (written < start || written > max_file_bytes)
        throw InputError(shown(path), "byte 16", fmt::format("a file of {} bytes cannot be", written));
    const Head result =
        HeaderReader(path, start, written).read(std::string_view(head).substr(header_start, checked - header_start));
    require_kind(result, kind);
    if (there < written)
        throw InputError(shown(path), where_cut(result, there),
                         fmt::format("the file is cut off: it has {} of {} bytes", there, written));
    if (there > written)
        throw InputError(shown(path), "end", fmt::format("{} bytes follow the last array", there - written));
    return result;
}

void verify(const std::string& path, const Array& array, const Extent& extent, const unsigned char* data) {
    const std::string place = "array " + in_quotes(array.name);
    if (content_hash(data, extent.bytes) != extent.checksum)
        throw InputError(shown(path), place, "the checksum is wrong: it was changed");
    if (std::any_of(data + extent.bytes, data + extent.padded_bytes, [](unsigned char byte) { return byte != 0; }))
        throw InputError(shown(path), place, "the bytes behind it are not 0: they were changed");
}

}  // namespace plumb::io::bundle_layout
