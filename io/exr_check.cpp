// OpenEXR, "The OpenEXR File Layout": version field, header, offset table.
#include "io/exr_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "io/file.h"
#include "io/image_decode.h"

namespace plumb::io {
namespace {

using namespace std::string_view_literals;

struct FixedType {
    std::string_view name;
    std::size_t size;
};
// OpenEXR reads as many bytes as these types have, whatever size the file gives.
constexpr FixedType fixed_types[] = {
    {"box2f", 16},   {"box2i", 16}, {"chromaticities", 32}, {"compression", 1}, {"deepImageState", 1}, {"double", 8},
    {"envmap", 1},   {"float", 4},  {"int", 4},             {"keycode", 28},    {"lineOrder", 1},      {"m33d", 72},
    {"m33f", 36},    {"m44d", 128}, {"m44f", 64},           {"rational", 8},    {"tiledesc", 9},       {"timecode", 8},
    {"v2d", 16},     {"v2f", 8},    {"v2i", 8},             {"v3d", 24},        {"v3f", 12},           {"v3i", 12},
};

// Lines that are packed together, by compression: none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab.
constexpr std::array<std::int64_t, 10> lines_of_block = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

// OpenEXR takes a block whole where the picture has fewer lines, too: so much of one is no reason to refuse it.
constexpr std::int64_t small_block = std::int64_t(1) << 24;

constexpr std::uint32_t tiled_flag = 0x200, deep_flag = 0x800, parts_flag = 0x1000;

class ExrHeader {
  public:
    ExrHeader(const std::string& path, const std::vector<unsigned char>& file) : path_(path), file_(file) {}

    void check() {
        const std::uint32_t version = word("the version");
        if ((version & 255) != 2) fail(4, fmt::format("version {}; expected 2", version & 255));
        if (version & deep_flag) throw InputError(shown(path_), "header", "deep pictures are not read");
        tiled_ = (version & tiled_flag) != 0;
        while (attribute()) {}
        if (version & parts_flag) {
            // Another empty name ends the list of headers.
            if (at_ >= file_.size()) fail(at_, "the header is cut off");
            if (file_[at_] != 0) throw InputError(shown(path_), "", "holds several pictures; expected one (EXR: one part)");
            ++at_;
            tiled_ = type_ == "tiledimage";
            if (type_.substr(0, 4) == "deep") throw InputError(shown(path_), "header", "deep pictures are not read");
        }
        check_declared();
    }

  private:
    [[noreturn]] void fail(std::size_t at, const std::string& cause) const {
        throw InputError(shown(path_), fmt::format("header: byte {}", at), cause);
    }
    std::size_t left() const { return file_.size() - at_; }

    std::uint32_t word(const char* what) {
        if (left() < 4) fail(at_, fmt::format("{} is cut off", what));
        const std::uint32_t value = word_at(at_);
        at_ += 4;
        return value;
    }
    std::uint32_t word_at(std::size_t at) const {
        return file_[at] | std::uint32_t(file_[at + 1]) << 8 | std::uint32_t(file_[at + 2]) << 16 |
               std::uint32_t(file_[at + 3]) << 24;
    }
    std::int64_t int_at(std::size_t at) const { return std::int32_t(word_at(at)); }

    // Up to a zero, which must be before `end`.
    std::string_view name(std::size_t end) {
        const auto begin = file_.begin() + std::ptrdiff_t(at_), last = file_.begin() + std::ptrdiff_t(end);
        const auto zero = std::find(begin, last, 0);
        if (zero == last) fail(at_, "a name has no end");
        const std::string_view text(reinterpret_cast<const char*>(file_.data()) + at_, std::size_t(zero - begin));
        at_ += text.size() + 1;
        return text;
    }

    // Name, type, size, value; false at the empty name that ends a header.
    bool attribute() {
        const std::string_view key = name(file_.size());
        if (key.empty()) return false;
        const std::string_view type = name(file_.size());
        const std::size_t where = at_, size = word("the size of an attribute");
        if (size > left())
            fail(where, fmt::format("attribute {} has {} bytes; {} are left", printable(key), size, left()));
        const auto fixed = std::find_if(std::begin(fixed_types), std::end(fixed_types),
                                        [&](const FixedType& f) { return f.name == type; });
        if (fixed != std::end(fixed_types) && fixed->size != size)
            fail(where, fmt::format("attribute {} of type {} has {} bytes; expected {}", printable(key), type, size, fixed->size));
        const std::size_t end = at_ + size;
        if (type == "chlist"sv) channels(end, key == "channels"sv);
        if (type == "preview"sv) preview(where, size);
        if (type == "stringvector"sv) texts(end);
        if (key == "dataWindow"sv && type == "box2i"sv)
            width_ = int_at(at_ + 8) - int_at(at_) + 1, height_ = int_at(at_ + 12) - int_at(at_ + 4) + 1;
        if (key == "compression"sv && type == "compression"sv) compression_ = file_[at_];
        if (key == "tiles"sv && type == "tiledesc"sv) tile_width_ = word_at(at_), tile_height_ = word_at(at_ + 4), mode_ = file_[at_ + 8] & 15;
        if (key == "chunkCount"sv && type == "int"sv) chunks_declared_ = int_at(at_);
        if (key == "type"sv && type == "string"sv)
            type_ = {reinterpret_cast<const char*>(file_.data()) + at_, size};
        at_ = end;
        return true;
    }

    // Name, then 16 bytes, of which the first four are the number type; an empty name at the end.
    void channels(std::size_t end, bool counted) {
        std::int64_t bytes = 0;
        for (;;) {
            const std::string_view channel = name(end);
            if (channel.empty()) break;
            if (end - at_ < 16) fail(at_, "the list of channels is cut off");
            bytes += word_at(at_) == 1 ? 2 : 4;
            at_ += 16;
        }
        if (at_ != end) fail(at_, fmt::format("{} bytes follow the list of channels", end - at_));
        if (counted) pixel_bytes_ = bytes;
        at_ = end;
    }

    void preview(std::size_t where, std::size_t size) {
        if (size < 8 || std::uint64_t(word_at(at_)) * word_at(at_ + 4) != (size - 8) / 4 || size % 4 != 0)
            fail(where, "a preview has other bytes than its width and height ask for");
    }

    void texts(std::size_t end) {
        for (std::size_t at = at_; at < end; at += 4 + word_at(at))
            if (end - at < 4 || word_at(at) > end - at - 4) fail(at, "a list of texts is cut off");
    }

    // Tiles of a level, or of all of them.
    std::int64_t tiles() const {
        const auto across = [](std::int64_t size, std::int64_t tile) { return (size + tile - 1) / tile; };
        std::int64_t sum = 0;
        for (std::int64_t w = width_, h = height_;; w = std::max<std::int64_t>(w / 2, 1), h = std::max<std::int64_t>(h / 2, 1)) {
            sum += across(w, tile_width_) * across(h, tile_height_);
            if (mode_ == 0 || (w == 1 && h == 1)) return sum;
        }
    }

    void check_declared() const {
        if (width_ < 1 || height_ < 1 || pixel_bytes_ < 1)
            throw InputError(shown(path_), "header",
                             fmt::format("{} x {} pixels of {} bytes: expected at least one", width_, height_, pixel_bytes_));
        if (compression_ >= lines_of_block.size())
            throw InputError(shown(path_), "header", fmt::format("compression {} is not known", compression_));
        if (tiled_ && (tile_width_ < 1 || tile_height_ < 1))
            throw InputError(shown(path_), "header", "has tiles of no pixel");
        // Products stay below 2^63: a side is below 2^32, a pixel below 2^31 bytes of the file.
        const std::int64_t most = std::int64_t(most_picture_bytes(file_.size()));
        const std::int64_t block_pixels = tiled_ ? std::min(tile_width_, most) * std::min(tile_height_, most)
                                                 : width_ * lines_of_block[compression_];
        for (const auto& [pixels, limit] : {std::pair{width_ * height_, most}, std::pair{block_pixels, std::max(most, small_block)}})
            if (pixels > limit / pixel_bytes_)
                throw InputError(shown(path_), "header",
                                 fmt::format("declares {} pixels of {} bytes, which {} bytes cannot hold", pixels,
                                             pixel_bytes_, file_.size()));
        // OpenEXR takes the whole table of offsets, eight bytes a block, before it reads the first.
        const std::int64_t lines = lines_of_block[compression_];
        const std::int64_t blocks = std::max(chunks_declared_, tiled_ ? tiles() : (height_ + lines - 1) / lines);
        if (blocks > std::int64_t(left() / 8))
            throw InputError(shown(path_), "header",
                             fmt::format("a table of {} blocks is cut off; {} bytes are left", blocks, left()));
    }

    const std::string& path_;
    const std::vector<unsigned char>& file_;
    std::size_t at_ = 4;
    bool tiled_ = false;
    std::int64_t width_ = 0, height_ = 0, pixel_bytes_ = 0, tile_width_ = 0, tile_height_ = 0, chunks_declared_ = 0;
    std::size_t compression_ = 0;
    int mode_ = 0;
    std::string_view type_;
};

}  // namespace

void check_exr(const std::string& path, const std::vector<unsigned char>& file) { ExrHeader(path, file).check(); }

}  // namespace plumb::io
