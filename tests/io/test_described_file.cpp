// Described files: what they hold comes back, what is wrong with one is one line, and Python reads them without our
// code.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bundle_bytes.h"
#include "core/hash.h"
#include "files.h"
#include "io/bundle_file.h"
#include "io/described_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const Kind kind{"test", 1, 2};

// One array of every type, one of none, one without extents; facts of every type.
DescribedFile sample() {
    DescribedFile file;
    file.kind = "test", file.version = 2;
    add_scene(file, 0x8000000000000001);
    file.facts.push_back({"probes", std::int64_t(78)});
    file.facts.push_back({"radius", 0.1});
    const float positions[] = {1, -2, 0.1f, 4, 5, 6};
    const double doubles[] = {0.1, -1e300};
    const std::uint8_t bytes[] = {9, 8, 255};
    const std::uint16_t words[] = {65535};
    const std::int32_t indices[] = {-2147483647 - 1, 2147483647, -1};
    const std::uint32_t counts[] = {4294967295u, 0};
    const Half halves[] = {{0x3c00}, {0xc000}, {0x0001}};  // 1, -2, 2^-24
    const float one = 7;
    add(file, "positions", {2, 3}, positions, {"m", "position of each probe", {"probe", "x, y, z"}});
    add(file, "doubles", {2}, doubles, {"W/m2", "sums", {"item"}});
    add(file, "bytes", {3, 1}, bytes, {"", "masks", {"receiver", "mask"}});
    add(file, "words", {1}, words, {"", "Weite \xc3\xa4", {"texel"}});
    add(file, "indices", {3}, indices, {"", "materials; -1: none", {"material"}});
    add(file, "counts", {2}, counts, {"", "rays", {"probe"}});
    add(file, "halves", {3}, halves, {"sr", "solid angles", {"ray"}});
    add(file, "nothing", {0, 4}, doubles, {"", "clusters without receivers", {"cluster", "w"}});
    add(file, "one", {}, &one, {"m", "radius of a probe", {}});
    return file;
}

bool same(const DescribedFile& a, const DescribedFile& b) {
    if (a.kind != b.kind || a.version != b.version || a.facts.size() != b.facts.size()) return false;
    for (std::size_t i = 0; i < a.facts.size(); ++i)
        if (a.facts[i].name != b.facts[i].name || a.facts[i].value != b.facts[i].value) return false;
    if (a.descriptions.size() != b.descriptions.size()) return false;
    for (std::size_t i = 0; i < a.descriptions.size(); ++i) {
        const Description &p = a.descriptions[i], &q = b.descriptions[i];
        if (p.unit != q.unit || p.meaning != q.meaning || p.axes != q.axes) return false;
    }
    return content_hash(a.arrays) == content_hash(b.arrays);
}

// The message of both ways to read it, which is one.
std::string refusal(const std::string& path, const Kind& expected = kind) {
    const std::string read = error_of([&] { read_described(path, expected); });
    const std::string mapped = error_of([&] { MappedFile(path, expected).verify_all(); });
    CHECK(read == mapped);
    return read;
}

struct Sample {
    Folder folder;
    std::string path = folder / "good.bake", content;
    Sample() {
        write_described(path, sample());
        content = read_text(path);
    }
    std::string refuse(const std::string& bytes) const { return refusal(folder.put("a.bake", bytes)); }
    // Counts as the header everything before the arrays.
    std::size_t start() const {
        std::size_t start = 0;
        for (int i = 3; i >= 0; --i) start = start << 8 | static_cast<unsigned char>(content[std::size_t(12 + i)]);
        return start;
    }
};

}  // namespace

TEST_CASE("described file: everything comes back, read and mapped, and equal files are equal bytes", "[io]") {
    const Sample s;
    const DescribedFile written = sample();
    write_described(s.folder / "again.bake", written);
    CHECK(read_text(s.folder / "again.bake") == s.content);
    CHECK(s.content.size() % 64 == 0);

    const DescribedFile read = read_described(s.path, kind);
    CHECK(same(read, written));
    MappedFile mapped(s.path, kind);
    CHECK(mapped.head().facts.size() == 3);
    CHECK(mapped.head().descriptions[0].unit == "m");
    Bundle lent;
    for (const Array& array : written.arrays.arrays) {
        lent.arrays.push_back(mapped.array(array.name));
        const Bytes& bytes = lent.arrays.back().bytes;
        CHECK(reinterpret_cast<std::uintptr_t>(std::as_const(bytes).data()) % 64 == 0);
    }
    CHECK(content_hash(lent) == content_hash(written.arrays));
    CHECK(mapped.elements<float>("positions", {any_extent, 3})[2] == 0.1f);
    // The mapping goes where the object goes.
    const MappedFile moved = std::move(mapped);
    CHECK(content_hash(lent) == content_hash(written.arrays));
    CHECK(s.folder.files() == 2);
}

TEST_CASE("described file: every type with every shape comes back", "[io]") {
    const Folder folder;
    for (DType dtype : {DType::f32, DType::f64, DType::u8, DType::u16, DType::i32, DType::u32, DType::f16})
        for (const Shape& shape : {Shape{}, Shape{5}, Shape{2, 3}, Shape{1, 0, 7}, Shape(32, 1), Shape{1000003}}) {
            DescribedFile file;
            file.kind = "test";
            Array& array = plumb::add(file.arrays, "a", dtype, shape);
            for (std::size_t i = 0; i < array.bytes.size(); ++i)
                array.bytes[i] = static_cast<unsigned char>(37 * i + 1);
            file.descriptions.push_back({"", "any", std::vector<std::string>(shape.size(), "axis")});
            write_described(folder / "a.bake", file);
            CHECK(same(read_described(folder / "a.bake", kind), file));
            CHECK(content_hash(MappedFile(folder / "a.bake", kind).array("a")) == content_hash(file.arrays.arrays[0]));
        }
    DescribedFile none;
    none.kind = "test";
    write_described(folder / "none.bake", none);
    CHECK(same(read_described(folder / "none.bake", kind), none));
    CHECK_NOTHROW(MappedFile(folder / "none.bake", kind).verify_all());
}

TEST_CASE("described file: numbers among the facts come back to the bit", "[io]") {
    const Folder folder;
    DescribedFile file;
    file.kind = "test";
    const auto put = [&](Fact fact) { file.facts.push_back({fmt::format("fact {}", file.facts.size()), fact}); };
    for (double x :
         {0.0, -0.0, 1.0, 0.1, 1e22, 5e-324, -1.7976931348623157e308, 2.2250738585072014e-308, 4503599627370497.5})
        put(x);
    for (std::int64_t n : {std::int64_t(0), INT64_MIN, INT64_MAX, std::int64_t(1) << 53, (std::int64_t(1) << 53) + 1})
        put(n);
    for (const char* text : {"", "ffffffffffffffff", "\n\"\\", "\xc3\xa4"}) put(std::string(text));
    // Any bits but those of infinities and NaN.
    for (int i = 0; file.facts.size() < 2000; ++i) {
        const auto h = pcg3d(i, 1, 2);
        const std::uint64_t bits = std::uint64_t(std::uint32_t(h.x)) << 32 | std::uint32_t(h.y);
        if ((bits >> 52 & 0x7ff) != 0x7ff) put(std::bit_cast<double>(bits));
    }
    write_described(folder / "a.bake", file);
    const DescribedFile back = read_described(folder / "a.bake", kind);
    REQUIRE(back.facts.size() == file.facts.size());
    std::size_t differ = 0;
    for (std::size_t i = 0; i < file.facts.size(); ++i) {
        const Fact &a = file.facts[i].value, &b = back.facts[i].value;
        differ += back.facts[i].name != file.facts[i].name || a != b;
        if (const double* x = std::get_if<double>(&a); x && a == b)
            differ += std::bit_cast<std::uint64_t>(*x) != std::bit_cast<std::uint64_t>(std::get<double>(b));
    }
    CHECK(differ == 0);
}

TEST_CASE("described file: cut at any byte or longer, it is refused and the array named", "[io][robustness]") {
    const Sample s;
    std::size_t missed = 0, unnamed = 0;
    for (std::size_t n = 0; n < s.content.size(); ++n) {
        const std::string path = s.folder.put("a.bake", s.content.substr(0, n));
        const std::string message = error_of([&] { read_described(path, kind); });
        missed += message.find("a.bake: ") == message.npos || message.find('\n') != message.npos;
        missed += error_of([&] { MappedFile{path, kind}; }) != message;
        unnamed += n >= s.start() && message.find(": array \"") == message.npos;
    }
    CHECK(missed == 0);
    CHECK(unnamed == 0);
    require_message(s.refuse(""), {"a.bake: byte 0: is empty"});
    require_message(s.refuse(s.content.substr(0, 100)), {"a.bake: header: the file is cut off"});
    require_message(s.refuse(s.content.substr(0, s.start())), {"a.bake: array \"positions\": the file is cut off"});
    require_message(s.refuse(s.content + "x"), {"a.bake: end: 1 bytes follow the last array"});
    require_message(s.refuse(s.content + std::string(64, '\0')), {"a.bake: end: 64 bytes follow"});
    require_message(s.refuse(s.content + s.content), {"a.bake: end: "});
}

TEST_CASE("described file: every flipped bit of the header is refused when the file is opened", "[io][robustness]") {
    const Sample s;
    std::size_t missed = 0;
    for (std::size_t bit = 0; bit < 8 * s.start(); ++bit) {
        std::string changed = s.content;
        changed[bit / 8] = char(changed[bit / 8] ^ 1 << bit % 8);
        const std::string path = s.folder.put("a.bake", changed);
        missed += error_of([&] { MappedFile{path, kind}; }).find("a.bake: ") == std::string::npos;
    }
    CHECK(missed == 0);
}

TEST_CASE("described file: 1000 flipped bytes are refused, and a flipped array is named", "[io][robustness]") {
    const Sample s;
    std::size_t missed = 0, unnamed = 0;
    for (int i = 0; i < 1000; ++i) {
        const auto h = pcg3d(i, 17, 2024);
        std::string changed = s.content;
        // Half of them behind the header.
        const std::size_t first = i % 2 ? s.start() : 0;
        const std::size_t at = first + std::size_t(std::uint32_t(h.x)) % (s.content.size() - first);
        changed[at] = char(changed[at] ^ (1 + std::uint32_t(h.y) % 255));
        const std::string path = s.folder.put("a.bake", changed);
        const std::string message = error_of([&] { read_described(path, kind); });
        missed += message.find("a.bake: ") == message.npos || message.find('\n') != message.npos;
        missed += error_of([&] { MappedFile(path, kind).verify_all(); }) != message;
        unnamed += at >= s.start() && message.find(": array \"") == message.npos;
    }
    CHECK(missed == 0);
    CHECK(unnamed == 0);
}

TEST_CASE("described file: a mapped array is looked at when it is asked for", "[io][robustness]") {
    const Sample s;
    std::string changed = s.content;
    changed[s.start() + 4] = char(changed[s.start() + 4] ^ 1);  // within "positions", the first
    changed[s.start() + 64 + 20] = 1;                           // behind "doubles", whose 16 bytes come next
    MappedFile file(s.folder.put("a.bake", changed), kind);
    CHECK(elements<std::uint16_t>(file.array("words"), {1})[0] == 65535);
    for (int again = 0; again < 2; ++again) {
        require_message(error_of([&] { file.array("positions"); }),
                        {"a.bake: array \"positions\": the checksum is wrong: it was changed"});
        require_message(error_of([&] { file.array("doubles"); }),
                        {"a.bake: array \"doubles\": the bytes behind it are not 0"});
    }
    require_message(error_of([&] { file.verify_all(); }), {"array \"positions\""});
    require_message(error_of([&] { read_described(s.folder / "a.bake", kind); }), {"array \"positions\""});
}

TEST_CASE("described file: what is not the caller's is refused with what it is", "[io][robustness]") {
    const Sample s;
    require_message(refusal(s.path, {"probe bake", 1, 9}),
                    {"good.bake: header: is a file of kind \"test\"; expected a file of kind \"probe bake\""});
    require_message(refusal(s.path, {"test", 3, 4}),
                    {"good.bake: header: version 2 of \"test\"; this program reads 3 to 4"});
    require_message(refusal(s.path, {"test", 1, 1}), {"version 2 of \"test\"; this program reads 1"});
    require_message(error_of([&] { read_bundle(s.path); }), {"is a file of kind \"test\"; expected a bundle"});
    write_bundle(s.folder / "a.bundle", {});
    require_message(refusal(s.folder / "a.bundle"),
                    {"a.bundle: header: is a bundle; expected a file of kind \"test\""});
    require_message(s.refuse(bundle_bytes("{\"arrays\":[]}", "", 3)), {"byte 8: version 3; this program reads 2"});
    require_message(s.refuse("PLUMBNDX" + s.content.substr(8)), {"byte 0: is not a bundle"});
    require_message(refusal(s.folder / "none.bake"), {"none.bake: cannot be read: No such file"});
    require_message(refusal("/dev/zero"), {"/dev/zero: cannot be read: it is not a regular file"});

    const DescribedFile file = read_described(s.path, kind);
    CHECK(error_of([&] { require_scene(file, 0x8000000000000001, "hall.toml"); }) == "");
    require_message(
        error_of([&] { require_scene(file, 5, "hall.toml"); }),
        {"good.bake: facts: made of another scene: its content hash is 8000000000000001, that of hall.toml is "
         "0000000000000005"});
    MappedFile mapped(s.path, kind);
    for (const auto& array :
         {std::function([&] { array_of(file, "no", DType::f32, {}); }), std::function([&] { mapped.array("no"); })})
        require_message(error_of(array), {"good.bake: array \"no\" is missing; there are: positions, doubles"});
    for (const auto& array : {std::function([&] {
                                  elements<float>(file, "positions", {any_extent, 4});
                              }),
                              std::function([&] {
                                  mapped.elements<float>("positions", {any_extent, 4});
                              })})
        require_message(error_of(array), {"good.bake: array \"positions\": expected f32 [*, 4], got f32 [2, 3]"});
    for (const auto& array : {std::function([&] {
                                  elements<double>(file, "positions", {2, 3});
                              }),
                              std::function([&] {
                                  mapped.elements<double>("positions", {2, 3});
                              })})
        require_message(error_of(array), {"good.bake: array \"positions\": expected f64 [2, 3], got f32 [2, 3]"});

    CHECK(integer_fact(file, "probes") == 78);
    CHECK(number_fact(file, "probes") == 78);
    CHECK(number_fact(file, "radius") == 0.1);
    require_message(error_of([&] { text_fact(file, "no"); }), {"good.bake: facts: \"no\" is missing"});
    require_message(error_of([&] { integer_fact(file, "radius"); }), {"facts: \"radius\" is not a whole number"});
    require_message(error_of([&] { number_fact(file, "scene"); }), {"facts: \"scene\" is not a number"});
    require_message(error_of([&] { text_fact(file, "radius"); }), {"facts: \"radius\" is not a text"});
}

TEST_CASE("described file: headers that lie under right checksums are named with the cause", "[io][robustness]") {
    const Sample s;
    const std::string payload(64, 'x'), sum = hash_text(content_hash(payload));
    const auto header = [](const std::string& arrays, const std::string& facts = "{}",
                           const std::string& version = "1") {
        return R"({"kind":"test","version":)" + version + R"(,"facts":)" + facts + R"(,"arrays":[)" + arrays + "]}";
    };
    const auto entry = [&](const std::string& shape, const std::string& axes, const std::string& checksum) {
        return R"({"name":"a","type":"u8","shape":)" + shape + R"(,"axes":)" + axes +
               R"(,"unit":"","meaning":"x","offset":0,"checksum":")" + checksum + "\"}";
    };
    const std::string good = entry("[64]", "[\"i\"]", sum);
    CHECK(s.refuse(bundle_bytes(header(good, R"({"a":1})"), payload)) == "");  // files that are read
    const std::vector<std::pair<std::string, std::string>> cases = {
        {header(good, R"({"a":null})"), "header: fact \"a\" is neither text nor a number"},
        {header(good, R"({"a":[1]})"), "header: fact \"a\" is neither text nor a number"},
        {header(good, R"({"a":18446744073709551615})"), "header: fact \"a\" is neither text nor a number"},
        {header(good, R"({"a":1e999})"), "header: expected a list of arrays"},
        {header(good, R"({"a":1,"a":2})"), "header: an object holds \"a\" twice"},
        {header(good, "[]"), "header: expected a kind, its version and facts"},
        {header(good, "{}", "1.5"), "header: expected a kind, its version and facts"},
        {header(good, "{}", "4294967297"), "header: expected a kind, its version and facts"},
        {header(good, "{}", "-1"), "header: version -1 of \"test\"; this program reads 1 to 2"},
        {header(entry("[64]", "[]", sum)), "header: array \"a\": expected axes, unit and meaning"},
        {header(entry("[64]", "[1]", sum)), "header: array \"a\": expected axes, unit and meaning"},
        {header(entry("[64]", "[\"i\"]", "x" + sum.substr(1))), "checksum of array \"a\" is not 16 hexadecimal digits"},
        {header(entry("[64]", "[\"i\"]", sum + "0")), "checksum of array \"a\" is not 16 hexadecimal digits"},
        {header(entry("[9223372036854775807]", "[\"i\"]", sum)),
         "header: an extent of array \"a\" is not a whole number"},
        {header(entry("[4611686018427387904]", "[\"i\"]", sum)), "header: array \"a\": shape"},
        {header(entry("[1000000000000000000]", "[\"i\"]", sum)),
         "array \"a\": 1000000000000000000 bytes go beyond the end of the file"},
        {header(entry("[65]", "[\"i\"]", sum)), "array \"a\": 65 bytes go beyond the end of the file"},
        {header(entry("[0]", "[\"i\"]", sum)), "end: 64 bytes follow the last array"},
        {header(good) + "x", "header: expected a list of arrays"},
        {R"({"kind":"test","version":1,"arrays":[]})", "header: expected a list of arrays"},
        {R"({"kind":"","version":1,"facts":{},"arrays":[]})", "header: expected a kind, its version and facts"},
    };
    for (const auto& [text, message] : cases) {
        CAPTURE(text);
        require_message(s.refuse(bundle_bytes(text, payload)), {"a.bake: ", message});
    }
    // The zeros behind an array have to be there, too.
    require_message(s.refuse(bundle_bytes(header(entry("[70]", "[\"i\"]", sum)), std::string(100, 'x'))),
                    {"a.bake: array \"a\": 70 bytes go beyond the end of the file"});
    // Sizes that cannot be, before anything is read or memory taken for it.
    for (const auto& [at, value, message] : {std::tuple{12, 0, "byte 12: a header of 0 bytes cannot be"},
                                             {12, 65, "byte 12: a header of 65 bytes cannot be"},
                                             {12, 1 << 25, "byte 12: a header of 33554432 bytes cannot be"},
                                             {12, 1 << 24, "header: the file is cut off"}}) {
        std::string bytes = s.content;
        bytes.replace(std::size_t(at), 4, little_endian_bytes(std::uint64_t(value), 4));
        require_message(s.refuse(bytes), {"a.bake: ", message});
    }
    for (const std::uint64_t bytes : {std::uint64_t(0), std::uint64_t(1) << 37, ~std::uint64_t(0)}) {
        std::string head = s.content.substr(0, s.start() - 8);
        head.replace(16, 8, little_endian_bytes(bytes, 8));
        const std::string lies = head + little_endian_bytes(content_hash(head), 8) + s.content.substr(s.start());
        require_message(s.refuse(lies), {fmt::format("a.bake: byte 16: a file of {} bytes cannot be", bytes)});
    }
}

TEST_CASE("described file: what does not describe itself is not written", "[io][robustness]") {
    const Folder folder;
    const auto refuse = [&](const auto& change) {
        DescribedFile file = sample();
        change(file);
        return error_of([&] { write_described(folder / "a.bake", file); });
    };
    require_message(refuse([](DescribedFile& f) {
                        f.facts.push_back({"x", std::nan("")});
                    }),
                    {"a.bake: cannot be written: fact \"x\" is not a finite number"});
    require_message(refuse([](DescribedFile& f) {
                        f.facts.push_back({"scene", std::int64_t(1)});
                    }),
                    {"two facts have the name \"scene\""});
    require_message(refuse([](DescribedFile& f) { f.descriptions[2].meaning = ""; }),
                    {"array \"bytes\" has no meaning"});
    require_message(refuse([](DescribedFile& f) { f.descriptions[2].axes.pop_back(); }),
                    {"array \"bytes\" has 2 extents and 1 axes"});
    require_message(refuse([](DescribedFile& f) { f.descriptions.pop_back(); }), {"not every array has a description"});
    require_message(refuse([](DescribedFile& f) { f.descriptions[2].unit = "\xff"; }), {"not UTF-8"});
    require_message(refuse([](DescribedFile& f) { f.version = 0; }), {"its version is below 1"});
    require_message(refuse([](DescribedFile& f) { f.arrays.arrays[1].name = "positions"; }),
                    {"two arrays have the name \"positions\""});
    require_message(refuse([](DescribedFile& f) { f.arrays.arrays[0].bytes.pop_back(); }),
                    {"\"positions\": expected 24 bytes"});
    require_message(
        refuse([](DescribedFile& f) { f.descriptions[0].meaning = std::string(std::size_t(1) << 24, 'x'); }),
        {"a header of more than 16777216 bytes"});
    CHECK(folder.files() == 0);
}

TEST_CASE("described file: a write that fails in the middle leaves the old file and no other", "[io][robustness]") {
    // A limit on file sizes stands for the full disk.
    const Sample s;
    DescribedFile large = sample();
    const std::vector<float> numbers(100000, 1.f);
    add(large, "large", {100000}, numbers.data(), {"", "more than fits", {"item"}});
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before;
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{100000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string message = error_of([&] { write_described(s.path, large); });
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_DFL);
    require_message(message, {"good.bake", "cannot be written", "File too large"});
    CHECK(read_text(s.path) == s.content);
    CHECK(s.folder.files() == 1);
    // What is mapped stays what it was when another file takes its place.
    MappedFile mapped(s.path, kind);
    write_described(s.path, large);
    CHECK_NOTHROW(mapped.verify_all());
    CHECK(mapped.head().arrays.arrays.size() == 9);
    CHECK(read_described(s.path, kind).arrays.arrays.size() == 10);
}

TEST_CASE("described file: the ten lines of Python in io/README.md read it, with numpy alone", "[io]") {
    // Debian's Python, whatever else is first on the path.
    if (std::system("/usr/bin/python3 -c 'import numpy' > /dev/null 2>&1") != 0) {
        std::cout << "SKIPPED: no numpy here (Debian's package python3-numpy; tools/install-deps)\n";
        return;
    }
    const std::string readme = read_text(PLUMB_SOURCE_DIR "/io/README.md");
    const std::string fence = "```python\n";
    const std::size_t from = readme.find(fence) + fence.size(), to = readme.find("```", from);
    REQUIRE(readme.find(fence) != readme.npos);
    REQUIRE(readme.find(fence, to) == readme.npos);
    const std::string lines = readme.substr(from, to - from);
    CHECK(std::count(lines.begin(), lines.end(), '\n') == 10);

    // Behind the ten lines one that says every number, floats as their bits say.
    const Sample s;
    const std::string script =
        s.folder.put("read.py", lines + "print(json.dumps({n: a.tolist() for n, a in arrays.items()}))\n");
    const std::string command =
        "/usr/bin/python3 '" + script + "' '" + s.path + "' > '" + (s.folder / "out.txt") + "' 2>&1";
    const int status = std::system(command.c_str());
    const std::string out = read_text(s.folder / "out.txt");
    INFO(out);
    REQUIRE(status == 0);
    std::istringstream stream(out);
    std::vector<std::string> said;
    for (std::string line; std::getline(stream, line);) said.push_back(line);
    REQUIRE(said.size() == 11);
    CHECK(said[0] == "test 2 {'scene': '8000000000000001', 'probes': 78, 'radius': 0.1}");
    CHECK(said[1] ==
          "positions [2, 3] ['probe', 'x, y, z'] m position of each probe [1.0, -2.0, 0.10000000149011612, 4.0]");
    CHECK(said[8] == "nothing [0, 4] ['cluster', 'w']  clusters without receivers []");
    CHECK(said[9] == "one [] [] m radius of a probe [7.0]");
    const auto expected = nlohmann::json::parse(R"({"positions": [[1, -2, 0.10000000149011612], [4, 5, 6]],
        "doubles": [0.1, -1e300], "bytes": [[9], [8], [255]], "words": [65535],
        "indices": [-2147483648, 2147483647, -1], "counts": [4294967295, 0],
        "halves": [1, -2, 5.9604644775390625e-8], "nothing": [], "one": 7})");
    CHECK(nlohmann::json::parse(said[10]) == expected);
}
