#include "io/described_file.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "io/bundle_layout.h"
#include "io/file.h"

namespace plumb::io {
namespace {

using bundle_layout::Extent;
using bundle_layout::Head;

const Fact& fact_of(const DescribedFile& file, const std::string& name) {
    for (const NamedFact& fact : file.facts)
        if (fact.name == name) return fact.value;
    throw InputError(shown(file.path), "facts", "\"" + printable(name) + "\" is missing");
}

template <class Value>
const Value& fact_as(const DescribedFile& file, const std::string& name, const char* expected) {
    if (const Value* value = std::get_if<Value>(&fact_of(file, name))) return *value;
    throw InputError(shown(file.path), "facts", "\"" + printable(name) + "\" is not " + expected);
}

// Runs a check of core/, whose messages name the array, and names the file before it.
template <class Check>
auto in_file(const std::string& path, Check check) -> decltype(check()) {
    try {
        return check();
    } catch (const InputError& e) {
        throw InputError(shown(path), "", e.what());
    }
}

}  // namespace

void write_described(const std::string& path, const DescribedFile& file) {
    static constexpr std::array<char, 64> zeros{};
    const std::string head = bundle_layout::head_bytes(path, file);
    std::vector<std::string_view> parts = {head};
    for (const Array& array : file.arrays.arrays) {
        const std::size_t n = array.bytes.size();
        parts.emplace_back(reinterpret_cast<const char*>(array.bytes.data()), n);
        parts.emplace_back(zeros.data(), bundle_layout::aligned(n) - n);
    }
    write_file(path, parts);
}

DescribedFile read_described(const std::string& path, const Kind& kind) {
    const RandomFile bytes(path);
    Head head = bundle_layout::read_head(path, bytes, kind);
    for (std::size_t i = 0; i < head.extents.size(); ++i) {
        Array& array = head.file.arrays.arrays[i];
        const Extent& extent = head.extents[i];
        array.bytes = Bytes(extent.padded_bytes);
        bytes.read(std::int64_t(extent.offset), extent.padded_bytes, array.bytes.data());
        bundle_layout::verify(path, array, extent, array.bytes.data());
        array.bytes.resize(extent.bytes);
    }
    return std::move(head.file);
}

struct MappedFile::Mapping {
    RandomFile bytes;
    Head head;
    const unsigned char* data;
    std::vector<bool> verified;

    Mapping(const std::string& path, const Kind& kind)
        : bytes(path),
          head(bundle_layout::read_head(path, bytes, kind)),
          data(bytes.map()),
          verified(head.extents.size()) {}

    const unsigned char* verified_bytes(std::size_t i) {
        const unsigned char* bytes_of = data + head.extents[i].offset;
        if (!verified[i]) bundle_layout::verify(head.file.path, head.file.arrays.arrays[i], head.extents[i], bytes_of);
        verified[i] = true;
        return bytes_of;
    }
};

MappedFile::MappedFile(const std::string& path, const Kind& kind) : mapping_(std::make_unique<Mapping>(path, kind)) {}
MappedFile::MappedFile(MappedFile&&) noexcept = default;
MappedFile& MappedFile::operator=(MappedFile&&) noexcept = default;
MappedFile::~MappedFile() = default;

const DescribedFile& MappedFile::head() const { return mapping_->head.file; }

Array MappedFile::array(const std::string& name) {
    const std::vector<Array>& arrays = head().arrays.arrays;
    const Array& described = in_file(head().path, [&]() -> const Array& { return at(head().arrays, name); });
    const std::size_t i = std::size_t(&described - arrays.data());
    Array lent{described.name, described.dtype, described.shape, Bytes()};
    const unsigned char* bytes = mapping_->verified_bytes(i);
    lent.bytes = Bytes::lent(bytes, mapping_->head.extents[i].bytes);
    return lent;
}

Array MappedFile::array(const std::string& name, DType dtype, const Shape& expected) {
    Array lent = array(name);
    in_file(head().path, [&] { require(lent, dtype, expected); });
    return lent;
}

void MappedFile::verify_all() {
    for (std::size_t i = 0; i < mapping_->head.extents.size(); ++i) mapping_->verified_bytes(i);
}

const Array& array_of(const DescribedFile& file, const std::string& name, DType dtype, const Shape& expected) {
    return in_file(file.path, [&]() -> const Array& {
        const Array& found = at(file.arrays, name);
        require(found, dtype, expected);
        return found;
    });
}

std::int64_t integer_fact(const DescribedFile& file, const std::string& name) {
    return fact_as<std::int64_t>(file, name, "a whole number");
}
double number_fact(const DescribedFile& file, const std::string& name) {
    if (const std::int64_t* integer = std::get_if<std::int64_t>(&fact_of(file, name))) return double(*integer);
    return fact_as<double>(file, name, "a number");
}
const std::string& text_fact(const DescribedFile& file, const std::string& name) {
    return fact_as<std::string>(file, name, "a text");
}

void add_scene(DescribedFile& file, std::uint64_t content_hash) {
    file.facts.push_back({"scene", hash_text(content_hash)});
}
void require_scene(const DescribedFile& file, std::uint64_t content_hash, const std::string& scene) {
    const std::string& stored = text_fact(file, "scene");
    if (stored != hash_text(content_hash))
        throw InputError(shown(file.path), "facts",
                         "made of another scene: its content hash is " + printable(stored) + ", that of " +
                             printable(scene) + " is " + hash_text(content_hash));
}

}  // namespace plumb::io
