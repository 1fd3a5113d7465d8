#include "io/npy.h"

#include <fmt/format.h>

#include <cstring>

#include "core/error.h"
#include "io/file.h"
#include "io/text_scan.h"

namespace plumb::io {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view magic = "\x93NUMPY"sv;
constexpr std::size_t max_rank = 32;

struct TypeName {
    std::string_view descr;
    DType dtype;
};
constexpr TypeName types[] = {{"<f4", DType::f32}, {"<f8", DType::f64}, {"|u1", DType::u8}, {"<u2", DType::u16},
                              {"<i4", DType::i32}, {"<u4", DType::u32}, {"<f2", DType::f16}};

// Reads the header, a dictionary as Python writes it: {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }
class HeaderParser {
  public:
    HeaderParser(const std::string& path, std::string_view text) : path_(path), text_(text) {}

    std::string descr;
    bool fortran_order = false;
    Shape shape;

    void parse() {
        bool has_descr = false, has_order = false, has_shape = false;
        expect('{');
        while (!take('}')) {
            const std::string key = quoted();
            expect(':');
            if (key == "descr" && !has_descr) {
                has_descr = true, descr = quoted();
            } else if (key == "fortran_order" && !has_order) {
                has_order = true, fortran_order = boolean();
            } else if (key == "shape" && !has_shape) {
                has_shape = true, read_shape();
            } else {
                fail("key '" + printable(key) + "' is unknown or given twice");
            }
            if (!take(',')) {
                expect('}');
                break;
            }
        }
        if (!(has_descr && has_order && has_shape)) fail("expected the keys descr, fortran_order and shape");
        skip_blanks();
        if (!text_.empty()) fail("something follows the dictionary");
    }

  private:
    [[noreturn]] void fail(const std::string& cause) const { throw InputError(shown(path_), "header", cause); }

    void skip_blanks() {
        while (!text_.empty() && (text_[0] == ' ' || text_[0] == '\n')) text_.remove_prefix(1);
    }
    bool take(char c) {
        skip_blanks();
        if (text_.empty() || text_[0] != c) return false;
        text_.remove_prefix(1);
        return true;
    }
    void expect(char c) {
        if (!take(c)) fail(fmt::format("expected '{}' at \"{}\"", c, printable(text_, 20)));
    }
    std::string quoted() {
        skip_blanks();
        const char quote = text_.empty() ? ' ' : text_[0];
        const std::size_t end = quote == '\'' || quote == '"' ? text_.find(quote, 1) : text_.npos;
        if (end == text_.npos) fail(fmt::format("expected a quoted word at \"{}\"", printable(text_, 20)));
        const std::string word(text_.substr(1, end - 1));
        text_.remove_prefix(end + 1);
        return word;
    }
    bool boolean() {
        skip_blanks();
        for (const auto& [word, value] : {std::pair{"True"sv, true}, {"False"sv, false}})
            if (text_.substr(0, word.size()) == word) return text_.remove_prefix(word.size()), value;
        fail("fortran_order: expected True or False");
    }
    void read_shape() {
        expect('(');
        while (!take(')')) {
            skip_blanks();
            const std::size_t end = std::min(text_.find_first_not_of("0123456789"), text_.size());
            const auto extent = parse_integer(text_.substr(0, end));
            if (!extent) fail(fmt::format("shape: expected a whole number at \"{}\"", printable(text_, 20)));
            text_.remove_prefix(end);
            shape.push_back(*extent);
            if (shape.size() > max_rank) fail(fmt::format("shape: more than {} extents", max_rank));
            if (!take(',')) {
                expect(')');
                break;
            }
        }
    }

    const std::string& path_;
    std::string_view text_;
};

}  // namespace

Array read_npy(const std::string& path) {
    const std::vector<unsigned char> file = read_bytes(path);
    const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
    if (bytes.empty()) throw InputError(shown(path), "", "is empty; expected an array");
    if (bytes.substr(0, magic.size()) != magic)
        throw InputError(shown(path), "byte 0", "does not begin as a .npy file does");

    // Version 1 has two bytes for the header's length, 2 and 3 have four.
    const auto byte = [&](std::size_t i) { return i < file.size() ? std::size_t(file[i]) : 0; };
    if (bytes.size() < 8) throw InputError(shown(path), "byte 6", "ends before its version");
    if (byte(6) < 1 || byte(6) > 3)
        throw InputError(shown(path), "byte 6", fmt::format("version {}.{}; expected 1 to 3", byte(6), byte(7)));
    const std::size_t start = byte(6) == 1 ? 10 : 12;
    const std::size_t length = byte(8) | byte(9) << 8 | (byte(6) == 1 ? 0 : byte(10) << 16 | byte(11) << 24);
    if (bytes.size() < start || bytes.size() - start < length)
        throw InputError(shown(path), "header",
                         fmt::format("ends after {} bytes; {} were declared", bytes.size(), start + length));
    HeaderParser header(path, bytes.substr(start, length));
    header.parse();

    const TypeName* type = nullptr;
    for (const TypeName& t : types)
        if (header.descr == t.descr) type = &t;
    if (!type)
        throw InputError(
            shown(path), "header",
            fmt::format("descr '{}'; expected one of <f4, <f8, |u1, <u2, <i4, <u4, <f2", printable(header.descr)));
    if (header.fortran_order) throw InputError(shown(path), "header", "is in Fortran order; expected C order");

    // Compares the declared size with what is there before memory is taken.
    const std::string name = stem_of(path);
    std::size_t size = 0;
    try {
        size = element_count(name, header.shape) * dtype_size(type->dtype);
    } catch (const InputError& e) {
        throw InputError(shown(path), "header", e.what());
    }
    const std::string_view data = bytes.substr(start + length);
    if (data.size() != size)
        throw InputError(
            shown(path), "data",
            fmt::format("{} of {} has {} bytes; found {}", shape_text(header.shape), header.descr, size, data.size()));
    Array array{name, type->dtype, header.shape, Bytes(size)};
    if (size > 0) std::memcpy(array.bytes.data(), data.data(), size);
    return array;
}

void write_npy(const std::string& path, const Array& array) {
    require(array, array.dtype, array.shape);
    write_npy(path, array.dtype, array.shape, array.bytes.data());
}

void write_npy(const std::string& path, DType dtype, const Shape& shape, const void* data) {
    const std::size_t bytes = element_count(stem_of(path), shape) * dtype_size(dtype);
    std::string_view descr;
    for (const TypeName& t : types)
        if (t.dtype == dtype) descr = t.descr;
    // Python writes (), (5,) and (2, 3).
    const std::string extents = fmt::format("{}{}", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", descr, extents);
    // NumPy asks for data at a multiple of 64, after a newline.
    header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 10 - 1, ' ');
    header += '\n';
    std::string start = std::string(magic) + '\x01' + '\0';
    start += char(header.size() & 255);
    start += char(header.size() >> 8);
    write_file(path, {start, header, {static_cast<const char*>(data), bytes}});
}

}  // namespace plumb::io
