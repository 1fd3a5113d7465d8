#include <fmt/format.h>

#include "bundle_bytes.h"
#include "files.h"
#include "io/bundle_file.h"
#include "io/npy.h"

using namespace plumb;
using namespace plumb::io;

namespace {

std::string npy(const std::string& header, const std::string& data, char version = 1) {
    std::string s = std::string("\x93NUMPY") + version + '\0' + char(header.size()) + '\0';
    if (version > 1) s += std::string(2, '\0');
    return s + header + data;
}

Bundle sample() {
    Bundle bundle;
    const float values[] = {1, 2, 3, 4, 5, 6};
    const std::uint8_t bytes[] = {9, 8, 7};
    add<float>(bundle, "weights", {2, 3}, values);
    add<std::uint8_t>(bundle, "ids", {3}, bytes);
    add(bundle, "nothing", DType::f64, {0, 4});
    add<float>(bundle, "one", {}, values);
    return bundle;
}

}  // namespace

TEST_CASE("npy: every type and shape comes back", "[io]") {
    const Folder folder;
    for (DType dtype : {DType::f32, DType::f64, DType::u8, DType::u16, DType::i32, DType::u32, DType::f16})
        for (const Shape& shape : {Shape{}, Shape{5}, Shape{2, 3}, Shape{1, 0, 7}}) {
            Bundle bundle;
            Array& array = add(bundle, "a", dtype, shape);
            for (std::size_t i = 0; i < array.bytes.size(); ++i)
                array.bytes[i] = static_cast<unsigned char>(37 * i + 1);
            write_npy(folder / "a.npy", array);
            const Array back = read_npy(folder / "a.npy");
            CHECK(content_hash(back) == content_hash(array));
            // NumPy asks that the data begin at a multiple of 64.
            CHECK((read_bytes(folder / "a.npy").size() - array.bytes.size()) % 64 == 0);
        }
}

TEST_CASE("npy: what NumPy writes is read", "[io]") {
    // As numpy.save(f, numpy.array([[1, 2], [3, 4]], '<i4')) lays it out; and version 2 of the format.
    const Folder folder;
    const std::string data("\1\0\0\0\2\0\0\0\3\0\0\0\4\0\0\0", 16);
    for (char version : {char(1), char(2)}) {
        const std::string header = "{'descr': '<i4', 'fortran_order': False, 'shape': (2, 2), }      \n";
        const Array array = read_npy(folder.put("a.npy", npy(header, data, version)));
        CHECK(array.name == "a");
        CHECK(array.shape == Shape{2, 2});
        const auto values = elements<std::int32_t>(array, {2, 2});
        CHECK(values[3] == 4);
    }
    CHECK(read_npy(folder.put("a.npy", npy("{'shape':(2,),'fortran_order':False,\"descr\":'|u1'}", "ab"))).shape ==
          Shape{2});
}

TEST_CASE("npy: malformed files are named with the cause", "[io][robustness]") {
    const Folder folder;
    const auto dictionary = [](const std::string& descr, const std::string& order, const std::string& shape) {
        return "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
    };
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "is empty"},
        {"hello", "byte 0: does not begin as a .npy file does"},
        {"\x93NUMPY", "byte 6: ends before its version"},
        {npy("", "", 4), "byte 6: version 4.0; expected 1 to 3"},
        {std::string("\x93NUMPY\1\0\xff\xff{", 11), "header: ends after 11 bytes; 65545 were declared"},
        {npy("", ""), "header: expected '{'"},
        {npy(dictionary(">f4", "False", "(1,)"), "abcd"), "header: descr '>f4'; expected one of <f4"},
        {npy(dictionary("|O", "False", "(1,)"), "abcd"), "header: descr '|O'"},
        {npy(dictionary("<f4", "True", "(1,)"), "abcd"), "header: is in Fortran order"},
        {npy(dictionary("<f4", "Maybe", "(1,)"), "abcd"), "header: fortran_order: expected True or False"},
        {npy(dictionary("<f4", "False", "(-1,)"), "abcd"), "header: shape: expected a whole number at \"-1,)"},
        {npy(dictionary("<f4", "False", "1"), "abcd"), "header: expected '(' at \"1"},
        {npy(dictionary("<f4", "False", "(2,)"), "abcd"), "data: [2] of <f4 has 8 bytes; found 4"},
        {npy(dictionary("<f4", "False", "(1,)"), "abcdef"), "data: [1] of <f4 has 4 bytes; found 6"},
        {npy(dictionary("<f4", "False", "(99999999999, 99999999999)"), "abcd"), "header: array \"a\": shape"},
        {npy(dictionary("<f4", "False", "(4611686018427387904,)"), "abcd"), "header: array \"a\": shape"},
        {npy("{'descr': '<f4', 'shape': (1,)}", "abcd"), "header: expected the keys descr, fortran_order and shape"},
        {npy("{'descr': '<f4', 'descr': '<f4'}", "abcd"), "header: key 'descr' is unknown or given twice"},
        {npy(dictionary("<f4", "False", "(1,)") + "x", "abcd"), "header: something follows the dictionary"},
        {npy(dictionary("<f4", "False", "(" + std::string(3 * 33, '1') + ")"), ""), "header: array \"a\": shape"},
    };
    for (const auto& [content, message] : cases) {
        CAPTURE(content);
        const std::string path = folder.put("a.npy", content);
        require_message(error_of([&] { read_npy(path); }), {"a.npy: ", message});
    }
}

TEST_CASE("npy: cut off at any byte, it is refused", "[io][robustness]") {
    const Folder folder;
    const Bundle bundle = sample();
    write_npy(folder / "a.npy", bundle.arrays[0]);
    const std::string content = read_text(folder / "a.npy");
    CHECK(load_damaged(folder, "a.npy", content, [](const std::string& path) { read_npy(path); }) == 0);
}

TEST_CASE("bundle: every array comes back, and equal bundles are equal files", "[io]") {
    const Folder folder;
    const Bundle bundle = sample();
    write_bundle(folder / "a.bundle", bundle);
    write_bundle(folder / "b.bundle", bundle);
    CHECK(read_bytes(folder / "a.bundle") == read_bytes(folder / "b.bundle"));
    const Bundle back = read_bundle(folder / "a.bundle");
    CHECK(back.arrays.size() == 4);
    CHECK(content_hash(back) == content_hash(bundle));
    CHECK(at(back, "one").shape.empty());
    write_bundle(folder / "empty.bundle", {});
    CHECK(read_bundle(folder / "empty.bundle").arrays.empty());
}

TEST_CASE("bundle: a cut, an added and a changed byte are seen, whichever it is", "[io][robustness]") {
    const Folder folder;
    write_bundle(folder / "good.bundle", sample());
    const std::string content = read_text(folder / "good.bundle");
    const auto refused = [&](const std::string& bytes) {
        const std::string path = folder.put("a.bundle", bytes);
        return error_of([&] { read_bundle(path); }).find("a.bundle: ") != std::string::npos;
    };
    std::size_t missed = 0;
    for (std::size_t n = 0; n < content.size(); ++n) {
        missed += !refused(content.substr(0, n));
        std::string changed = content;
        changed[n] = char(changed[n] ^ 1 << n % 8);
        missed += !refused(changed);
    }
    CHECK(missed == 0);
    CHECK(refused(content + "x"));
}

TEST_CASE("bundle: headers that lie under a right checksum are named with the cause", "[io][robustness]") {
    const Folder folder;
    const auto refuse = [&](const std::string& header, const std::string& payload) {
        const std::string path = folder.put("a.bundle", bundle_bytes(header, payload));
        return error_of([&] { read_bundle(path); });
    };
    const std::string pad(64, 'x');
    const auto entry = [](const std::string& name, const std::string& type, const std::string& shape, int offset) {
        return fmt::format(R"({{"name":"{}","type":"{}","shape":{},"offset":{},"checksum":"{}"}})", name, type, shape,
                           offset, hash_text(content_hash(std::string(64, 'x'))));
    };
    const auto list = [](const std::string& entries) { return "{\"arrays\":[" + entries + "]}"; };
    CHECK(refuse(list(entry("a", "f32", "[16]", 0)), pad) == "");  // the helper makes files that are read
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"not json", "header: expected a list of arrays"},
        {std::string(100000, '['), "header: byte 64: values nested deeper than 64"},
        {R"({"arrays":[],"arrays":[]})", "header: an object holds \"arrays\" twice"},
        {"[]", "header: expected a list of arrays"},
        {list("1"), "header: expected an array's name, type, shape, offset and checksum"},
        {list(entry("a", "f31", "[16]", 0)), "header: type \"f31\" is unknown"},
        {list(entry("a", "f32", "[-16]", 0)), "header: an extent of array \"a\" is not a whole number"},
        {list(entry("a", "f32", "[1.5]", 0)), "header: an extent of array \"a\" is not a whole number"},
        {list(entry("a", "f32", "[99999999999]", 0)), "array \"a\": 399999999996 bytes go beyond the end"},
        {list(entry("a", "f32", "[4294967296,4294967296]", 0)), "header: array \"a\": shape"},
        {list(entry("a", "f32", "[16]", 64)), "header: array \"a\" does not begin where the one before it ends"},
        {list(entry("a", "f32", "[16]", 0) + "," + entry("a", "f32", "[0]", 64)), "two arrays have the name \"a\""},
        {list(entry("a", "f32", "[15]", 0)), "array \"a\": the checksum is wrong"},
        {list(""), "end: 64 bytes follow the last array"},
    };
    for (const auto& [header, message] : cases) {
        CAPTURE(header.substr(0, 80));
        require_message(refuse(header, pad), {"a.bundle: ", message});
    }
}

TEST_CASE("arrays: what cannot be written is one line, and nothing is left", "[io][robustness]") {
    const Folder folder;
    const Bundle bundle = sample();
    require_message(error_of([&] { write_npy(folder / "none/a.npy", bundle.arrays[0]); }),
                    {"none/a.npy: cannot be written"});
    require_message(error_of([&] { write_bundle(folder / "none/a.bundle", bundle); }),
                    {"none/a.bundle: cannot be written"});
    Bundle bad;
    add(bad, "\xff", DType::f32, {1});
    require_message(error_of([&] { write_bundle(folder / "a.bundle", bad); }), {"a.bundle", "not UTF-8"});
    CHECK(folder.files() == 0);
}
