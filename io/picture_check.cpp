#include "io/picture_check.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/error.h"
#include "io/file.h"
#include "io/image_decode.h"

namespace plumb::io {
namespace {

std::uint32_t word_at(const std::vector<unsigned char>& file, std::size_t at) {
    return file[at] | std::uint32_t(file[at + 1]) << 8 | std::uint32_t(file[at + 2]) << 16 |
           std::uint32_t(file[at + 3]) << 24;
}

// OpenImageIO takes memory for a picture while it opens some files, before its size can be asked for.
void check_sides(const std::string& path, std::int64_t width, std::int64_t height, std::size_t file_bytes) {
    const std::uint64_t pixels = std::uint64_t(std::llabs(width)) * std::uint64_t(std::llabs(height));
    if (pixels > most_picture_bytes(file_bytes))
        throw InputError(shown(path), "header",
                         fmt::format("declares {} x {} pixels, which {} bytes cannot hold", width, height, file_bytes));
}

}  // namespace

void check_dds(const std::string& path, const std::vector<unsigned char>& file) {
    constexpr std::uint32_t named_format = 4;  // DDPF_FOURCC
    if (file.size() < 128) return;
    check_sides(path, word_at(file, 16), word_at(file, 12), file.size());
    const std::string_view name(reinterpret_cast<const char*>(file.data()) + 84, 4);
    // OpenImageIO 2.4 divides by alpha to undo the product, where alpha is 0, too.
    if ((word_at(file, 80) & named_format) && (name == "DXT2" || name == "DXT4"))
        throw InputError(
            shown(path), "header",
            fmt::format("is packed as {}; expected DXT1, DXT3 or DXT5: colours that alpha multiplies are not read",
                        name));
}

void check_bmp(const std::string& path, const std::vector<unsigned char>& file) {
    if (file.size() < 26) return;
    const std::uint32_t sides = word_at(file, 18);
    if (word_at(file, 14) == 12)  // OS/2's header has sides of 16 bits
        check_sides(path, sides & 0xffff, sides >> 16, file.size());
    else
        check_sides(path, std::int32_t(sides), std::int32_t(word_at(file, 22)), file.size());
}

}  // namespace plumb::io
