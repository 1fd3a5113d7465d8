// Files that say what they hold: named arrays with unit, meaning and axes, and facts beside them. The file of a bundle
// (io/bundle_file.h) with more in its header; io/README.md has the layout, and ten lines of Python that read it.
//
// Nothing in a file is believed before its checksum is right: one of the header, one of each array. A byte that was cut
// off, added or changed is an InputError that names the file, the array and the cause.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/bundle.h"

namespace plumb::io {

// A number comes back as it was, to the bit; a hash is text (hash_text()), since JSON has no whole numbers of 64 bits.
using Fact = std::variant<std::int64_t, double, std::string>;
struct NamedFact {
    std::string name;
    Fact value;
};

struct Description {
    std::string unit;               // "m"; "" of what has none
    std::string meaning;            // "position of each probe; w: 0"
    std::vector<std::string> axes;  // one an extent: "receiver", "coefficient"
};

struct DescribedFile {
    std::string kind;  // what such files are, for whoever finds one: "probe bake"
    int version = 1;   // of the kind
    std::vector<NamedFact> facts;
    Bundle arrays;
    std::vector<Description> descriptions;  // of the arrays, in their order
    std::string path;                       // where it was read, for messages
};

// Appends an array and its description.
template <class T>
Array& add(DescribedFile& file, const std::string& name, const Shape& shape, const T* data, Description description) {
    file.descriptions.push_back(std::move(description));
    return plumb::add(file.arrays, name, shape, data);
}

// The same content is the same bytes. Throws InputError: a fact that is NaN or infinite, an array without a meaning or
// with another number of axes than extents, names that stand twice or are not UTF-8; and as write_file().
void write_described(const std::string& path, const DescribedFile& file);

// What a reader expects.
struct Kind {
    std::string name;
    int oldest = 1, newest = 1;  // versions that it reads
};

// All of a file. Throws InputError for another kind or version, too.
DescribedFile read_described(const std::string& path, const Kind& kind);

// A file whose arrays are mapped into memory and looked at when they are asked for. Whoever cuts the file while it is
// mapped ends the process; who publishes by renaming, as write_described() does, cuts none. For one thread at a time.
class MappedFile {
  public:
    // Verifies the header alone. Throws InputError as read_described().
    MappedFile(const std::string& path, const Kind& kind);
    MappedFile(MappedFile&&) noexcept;
    MappedFile& operator=(MappedFile&&) noexcept;
    ~MappedFile();

    const DescribedFile& head() const;  // its arrays have names, types and shapes, but no bytes

    // Lends the mapped bytes, which end with this object. The first call verifies them.
    Array array(const std::string& name);
    template <class T>
    std::span<const T> elements(const std::string& name, const Shape& expected) {
        const Array found = array(name, dtype_of<T>, expected);
        return {reinterpret_cast<const T*>(found.bytes.data()), found.bytes.size() / sizeof(T)};
    }
    Array array(const std::string& name, DType dtype, const Shape& expected);
    void verify_all();

  private:
    struct Mapping;
    std::unique_ptr<Mapping> mapping_;
};

// Throw InputError that names the file: what is missing, or of another type or shape.
const Array& array_of(const DescribedFile& file, const std::string& name, DType dtype, const Shape& expected);
template <class T>
std::span<const T> elements(const DescribedFile& file, const std::string& name, const Shape& expected) {
    const Array& found = array_of(file, name, dtype_of<T>, expected);
    return {reinterpret_cast<const T*>(found.bytes.data()), found.bytes.size() / sizeof(T)};
}
std::int64_t integer_fact(const DescribedFile& file, const std::string& name);
double number_fact(const DescribedFile& file, const std::string& name);  // an integer, too
const std::string& text_fact(const DescribedFile& file, const std::string& name);

// The content hash of what a file was made from is its fact "scene". `scene`: the name of what is at hand.
void add_scene(DescribedFile& file, std::uint64_t content_hash);
void require_scene(const DescribedFile& file, std::uint64_t content_hash, const std::string& scene);

}  // namespace plumb::io
