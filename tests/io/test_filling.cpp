// What stands in an output before a renderer has written to it.
#include <cmath>
#include <cstring>

#include "dumps.h"
#include "io/filling.h"

using namespace plumb;
using namespace plumb::io;

namespace {

std::string filled(std::uint32_t word, std::size_t bytes) {
    const std::vector<unsigned char> filled = filled_bytes(word, bytes);
    return {filled.begin(), filled.end()};
}

// 4 x 3 texels of one float.
DumpedImage read_output(const std::string& path, const std::string& format = "R32_SFLOAT", bool flipped = false) {
    DumpSpec spec;
    spec.file = path;
    spec.vk_format = format;
    spec.width = 4, spec.height = 3;
    spec.filling = 0xffe1a2b3u;
    spec.flip_y = flipped;
    return read_dump(spec);
}

}  // namespace

// By IEEE 754 a float whose exponent is all ones and whose fraction is not 0 is NaN; that of invalid operations is
// 0xffc00000 on x86 and 0x7fc00000 or 0x7fffffff elsewhere.
TEST_CASE("filling: every word is a NaN that no operation makes, and an integer below -1", "[io][filling]") {
    for (const std::uint64_t id : {std::uint64_t(0), std::uint64_t(1), std::uint64_t(0x1ffffd), ~std::uint64_t(0),
                                   std::uint64_t(0x0123456789abcdef)}) {
        const std::uint32_t word = filling_word(id);
        CAPTURE(word);
        float f;
        std::memcpy(&f, &word, 4);
        CHECK(std::isnan(f));
        CHECK(std::int32_t(word) < -1);
        CHECK(is_filling(word));
        CHECK(parse_filling(filling_text(word)) == word);
    }
    for (const std::uint32_t word : {0u, 0xffffffffu, 0xffc00000u, 0x7fc00000u, 0x7fffffffu, 0xffe00000u, 0xff800000u})
        CHECK_FALSE(is_filling(word));
    CHECK(next_filling(0xffe1a2b3u) == 0xffe1a2b4u);
    CHECK(next_filling(0xfffffffeu) == 0xffe00001u);
    CHECK(filling_word(1) != filling_word(2));
}

TEST_CASE("filling: a file is told that is missing, empty, untouched, or another export's", "[io][filling]") {
    const Folder folder;
    const std::uint32_t word = 0xffe1a2b3u, other = 0xffe1a2b4u;
    const auto why = [&](const std::string& path) { return look_for_filling(path, word).why; };
    CHECK(why(folder / "none.bin") == "is missing");
    CHECK(why(folder.put("a.bin", "")) == "is empty");
    CHECK(why(folder.put("a.bin", filled(word, 400000))) == "still holds what the export filled it with");
    CHECK(why(folder.put("a.bin", filled(other, 400000))) == "holds what another export filled it with");
    // One other byte, and at the very end.
    for (const std::size_t at : {std::size_t(0), std::size_t(65536), std::size_t(399999)}) {
        std::string bytes = filled(word, 400000);
        bytes[at] = char(bytes[at] + 1);
        CHECK_FALSE(look_for_filling(folder.put("a.bin", bytes), word).nothing);
    }
    CHECK_FALSE(look_for_filling(folder.put("a.bin", std::string(4000, '\0')), word).nothing);
    CHECK_FALSE(look_for_filling(folder.put("a.bin", filled(0x7fc00000u, 4000)), word).nothing);
    CHECK_FALSE(look_for_filling(folder.put("a.bin", "abc"), word).nothing);
}

TEST_CASE("filling: texels that were not written are marked, the others read as they are", "[io][filling]") {
    const Folder folder;
    const std::string nothing = filled(0xffe1a2b3u, 48), four = bytes_of<float>({1, 2, 3, 4});
    const std::string path = folder / "a.bin";
    const auto marks = [&](const std::string& bytes, bool flipped = false) {
        return read_output(folder.put("a.bin", bytes), "R32_SFLOAT", flipped).unwritten;
    };
    using Marks = std::vector<std::uint8_t>;
    CHECK(marks(four + nothing.substr(16)) == Marks{0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1});
    CHECK(marks(four + nothing.substr(16), true) == Marks{1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0});
    CHECK(marks(four) == Marks{0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 2, 2});
    CHECK(marks(four + four.substr(0, 6)) == Marks{0, 0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 2});
    CHECK(marks(four + four + four).empty());
    CHECK(marks("") == Marks(12, 2));
    CHECK(marks(nothing) == Marks(12, 2));
    CHECK(marks(filled(0xffe1a2b4u, 48)) == Marks(12, 2));
    CHECK(read_output(folder / "none.bin").absent == "is missing");
    // Half of it in one's own, smaller format; texels of a byte hold the word's bytes by chance.
    CHECK(read_output(folder.put("a.bin", nothing), "R8_UNORM").unwritten == Marks(12, 2));
    CHECK(read_output(folder.put("a.bin", nothing.substr(0, 8) + "abcd"), "R8_UNORM").unwritten.empty());
    const DumpedImage some = read_output(folder.put("a.bin", four + nothing.substr(16)));
    CHECK(some.absent == "");
    float first[4];
    std::memcpy(first, some.array.bytes.data(), sizeof first);
    CHECK(first[0] == 1);
    // What is too long is at fault, as without a filling, and so is what no filling excuses.
    CHECK_THAT(error_of([&] { marks(four + four + four + four); }), Catch::Contains("has 64 bytes"));
    DumpSpec plain;
    plain.file = folder.put("a.bin", four);
    plain.vk_format = "R32_SFLOAT", plain.width = 4, plain.height = 3;
    CHECK_THAT(error_of([&] { read_dump(plain); }), Catch::Contains("has 16 bytes"));
}
