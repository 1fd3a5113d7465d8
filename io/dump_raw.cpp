// Raw texels and DDS, read row by row.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "io/dump_source.h"
#include "io/file.h"
#include "io/filling.h"
#include "io/random_file.h"

namespace plumb::io {
namespace {

class RawSource : public DumpSource {
  public:
    RawSource(const DumpSpec& spec, const TexelFormat& format)
        : format_(format), offset_(spec.offset), pitch_(spec.row_pitch), filling_(spec.filling) {
        open(spec);
        width = spec.count ? spec.count : spec.width, height = spec.count ? 1 : spec.height;
        channels = format.channels, kind = format.kind, is_depth = format.name[0] == 'D' || format.name[0] == 'X';
        const std::int64_t row = std::int64_t(width) * format.bytes;
        if (pitch_ == 0) pitch_ = row;

        // Compares with what is there before memory is taken. A file may lack the last row's padding.
        std::int64_t rows = 0, end = 0, padded_end = 0;
        const bool too_large = __builtin_mul_overflow(pitch_, std::int64_t(height) - 1, &rows) ||
                               __builtin_add_overflow(rows, offset_, &rows) ||
                               __builtin_add_overflow(rows, row, &end) ||
                               __builtin_add_overflow(rows, pitch_, &padded_end);
        const std::string what = fmt::format("{} x {} texels of {}, {} bytes a row, from byte {} on", width, height,
                                             format.name, pitch_, offset_);
        if (too_large) fail_dump(spec, what + " are more than 2^63 bytes");
        if (bytes_ < end && !filling_)
            fail_dump(spec, fmt::format("has {} bytes; {} end at byte {}", bytes_, what, end));
        if (bytes_ > padded_end && !spec.trailing)
            fail_dump(spec, fmt::format("has {} bytes; {} end at byte {}; where that is meant, trailing = true",
                                        bytes_, what, end));
    }

    void read(int x, int y, int n, double* to) const override {
        decode_texels(format_, bytes_at(x, y, n).data(), n, to);
    }

    // Texels of less than a word hold its bytes by chance: of these only the end of the file is told.
    void mark_unwritten(int x, int y, int n, std::uint8_t* marks) const override {
        if (!filling_) return;
        const std::int64_t first = place_of(x, y), texel = format_.bytes;
        const bool words = texel % 4 == 0 && first % 4 == 0;
        const std::vector<unsigned char> bytes = bytes_at(x, y, n);
        const std::vector<unsigned char> nothing = filled_bytes(*filling_, std::size_t(texel));
        for (int i = 0; i < n; ++i) {
            const unsigned char* at = bytes.data() + i * texel;
            if (first + (i + 1) * texel > bytes_)
                marks[i] = 2;
            else if (words && std::memcmp(at, nothing.data(), nothing.size()) == 0)
                marks[i] = 1;
        }
    }

  private:
    // A file with a filling of which nothing was written counts as empty, whatever its size.
    void open(const DumpSpec& spec) {
        if (filling_) {
            FillingState state = look_for_filling(spec.file.string(), *filling_);
            absent = std::move(state.why);
            if (state.nothing) return;
        }
        file_.emplace(spec.file.string());
        bytes_ = file_->size();
    }

    std::int64_t place_of(int x, int y) const { return offset_ + y * pitch_ + std::int64_t(x) * format_.bytes; }

    // Zeros behind the end of the file.
    std::vector<unsigned char> bytes_at(int x, int y, int n) const {
        std::vector<unsigned char> bytes(std::size_t(n) * std::size_t(format_.bytes));
        const std::int64_t there = std::clamp<std::int64_t>(bytes_ - place_of(x, y), 0, std::int64_t(bytes.size()));
        if (there > 0) file_->read(place_of(x, y), std::size_t(there), bytes.data());
        return bytes;
    }

    const TexelFormat& format_;
    std::optional<RandomFile> file_;
    std::int64_t bytes_ = 0;  // of the file that count
    std::int64_t offset_, pitch_;
    std::optional<std::uint32_t> filling_;
};

struct DdsFormat {
    std::uint32_t code;
    const char* name;
};

// DXGI_FORMAT, the typed and uncompressed ones. 20 has its stencil in the second word.
constexpr DdsFormat dxgi_formats[] = {
    {2, "R32G32B32A32_SFLOAT"},
    {3, "R32G32B32A32_UINT"},
    {4, "R32G32B32A32_SINT"},
    {6, "R32G32B32_SFLOAT"},
    {10, "R16G16B16A16_SFLOAT"},
    {11, "R16G16B16A16_UNORM"},
    {12, "R16G16B16A16_UINT"},
    {13, "R16G16B16A16_SNORM"},
    {14, "R16G16B16A16_SINT"},
    {16, "R32G32_SFLOAT"},
    {17, "R32G32_UINT"},
    {18, "R32G32_SINT"},
    {20, "R32G32_SFLOAT"},
    {24, "A2B10G10R10_UNORM_PACK32"},
    {26, "B10G11R11_UFLOAT_PACK32"},
    {28, "R8G8B8A8_UNORM"},
    {29, "R8G8B8A8_SRGB"},
    {30, "R8G8B8A8_UINT"},
    {31, "R8G8B8A8_SNORM"},
    {32, "R8G8B8A8_SINT"},
    {34, "R16G16_SFLOAT"},
    {35, "R16G16_UNORM"},
    {36, "R16G16_UINT"},
    {37, "R16G16_SNORM"},
    {38, "R16G16_SINT"},
    {40, "D32_SFLOAT"},
    {41, "R32_SFLOAT"},
    {42, "R32_UINT"},
    {43, "R32_SINT"},
    {45, "D24_UNORM_S8_UINT"},
    {46, "X8_D24_UNORM_PACK32"},
    {49, "R8G8_UNORM"},
    {50, "R8G8_UINT"},
    {51, "R8G8_SNORM"},
    {54, "R16_SFLOAT"},
    {55, "D16_UNORM"},
    {56, "R16_UNORM"},
    {57, "R16_UINT"},
    {58, "R16_SNORM"},
    {59, "R16_SINT"},
    {61, "R8_UNORM"},
    {62, "R8_UINT"},
    {63, "R8_SNORM"},
    {67, "E5B9G9R9_UFLOAT_PACK32"},
    {87, "B8G8R8A8_UNORM"},
    {91, "B8G8R8A8_SRGB"},
};
// D3DFORMAT in the place of the four characters.
constexpr DdsFormat d3d9_formats[] = {
    {36, "R16G16B16A16_UNORM"},   {110, "R16G16B16A16_SNORM"}, {111, "R16_SFLOAT"},    {112, "R16G16_SFLOAT"},
    {113, "R16G16B16A16_SFLOAT"}, {114, "R32_SFLOAT"},         {115, "R32G32_SFLOAT"}, {116, "R32G32B32A32_SFLOAT"},
};

template <std::size_t N>
const char* name_of(const DdsFormat (&formats)[N], std::uint32_t code) {
    for (const DdsFormat& format : formats)
        if (format.code == code) return format.name;
    return nullptr;
}

}  // namespace

std::unique_ptr<DumpSource> open_raw(const DumpSpec& spec) {
    return std::make_unique<RawSource>(spec, *find_texel_format(spec.vk_format));
}

// The header: Microsoft, "DDS file layout", DDS_HEADER and DDS_HEADER_DXT10.
std::unique_ptr<DumpSource> open_dds(const DumpSpec& spec) {
    const RandomFile file(spec.file.string());
    constexpr std::int64_t header_bytes = 128, long_header_bytes = 148;
    if (file.size() < header_bytes)
        fail_dump(spec, fmt::format("ends after {} bytes; a DDS has 128 of header", file.size()));
    unsigned char header[long_header_bytes] = {};
    file.read(0, std::size_t(std::min(file.size(), long_header_bytes)), header);
    const auto word = [&](std::size_t at) {
        std::uint32_t value;
        std::memcpy(&value, header + at, 4);
        return value;
    };
    if (std::memcmp(header, "DDS ", 4) != 0) fail_dump(spec, "byte 0: does not begin as a .dds file does");
    constexpr std::uint32_t has_code = 4, has_colour = 0x40, is_cube = 0x200, is_volume = 0x200000;
    const std::uint32_t flags = word(80), code = word(84);
    if (word(112) & (is_cube | is_volume)) fail_dump(spec, "holds a cube or a volume; expected one picture");

    DumpSpec raw = spec;
    raw.offset = header_bytes, raw.row_pitch = 0;
    raw.trailing = spec.trailing || word(28) > 1;  // smaller pictures follow
    if (flags & has_code && std::memcmp(header + 84, "DX10", 4) == 0) {
        if (file.size() < long_header_bytes)
            fail_dump(spec, fmt::format("ends after {} bytes; a DDS of DX10 has 148 of header", file.size()));
        constexpr std::uint32_t cube_flag = 4, volume_dimension = 4;
        if (word(132) == volume_dimension || word(136) & cube_flag || word(140) > 1)
            fail_dump(spec, "holds a cube, a volume or several pictures; expected one picture");
        const char* name = name_of(dxgi_formats, word(128));
        if (!name)
            fail_dump(spec,
                      fmt::format("DXGI_FORMAT {} is not read: compressed, typeless or rare; a typeless one is read "
                                  "as a raw file: vk_format, width, height, offset = 148",
                                  word(128)));
        raw.vk_format = name, raw.offset = long_header_bytes;
    } else if (flags & has_code) {
        if (const char* name = name_of(d3d9_formats, code)) raw.vk_format = name;
    } else if (flags & has_colour && word(88) == 32 && word(96) == 0xff00 && word(104) == 0xff000000u) {
        if (word(92) == 0xff && word(100) == 0xff0000) raw.vk_format = "R8G8B8A8_UNORM";
        if (word(92) == 0xff0000 && word(100) == 0xff) raw.vk_format = "B8G8R8A8_UNORM";
    }
    if (raw.vk_format.empty()) return nullptr;

    constexpr std::uint32_t max_side = 32767;
    if (word(16) < 1 || word(16) > max_side || word(12) < 1 || word(12) > max_side)
        fail_dump(spec, fmt::format("{} x {} pixels; expected 1 to {} a side", word(16), word(12), max_side));
    raw.width = int(word(16)), raw.height = int(word(12)), raw.count = 0;
    auto source = std::make_unique<RawSource>(raw, *find_texel_format(raw.vk_format));
    if (word(128) == 20 && raw.offset == long_header_bytes) source->channels = 1;
    return source;
}

}  // namespace plumb::io
