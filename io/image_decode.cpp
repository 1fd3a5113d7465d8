#include "io/image_decode.h"

#include <fmt/format.h>
#include <OpenImageIO/filesystem.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "core/error.h"
#include "core/number.h"
#include "io/exr_check.h"
#include "io/file.h"
#include "io/picture_check.h"
#include "io/png_check.h"

namespace plumb::io {
namespace {

// OpenImageIO 2.4 reads before its memory where a file names a place below zero, as the table of offsets of an EXR can.
class Memory : public OIIO::Filesystem::IOMemReader {
  public:
    using IOMemReader::IOMemReader;
    std::size_t pread(void* to, std::size_t size, std::int64_t offset) override {
        return offset < 0 || std::uint64_t(offset) > this->size() ? 0 : IOMemReader::pread(to, size, offset);
    }
};

struct Format {
    const char* extension;
    const char* reader;  // OpenImageIO's name
    std::vector<std::string_view> magics;
};

// Readers are chosen by this list alone: OpenImageIO has many more than have been tried here.
const std::vector<Format>& formats() {
    using namespace std::string_view_literals;
    static const std::vector<std::string_view> tiff = {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv};
    static const std::vector<std::string_view> pnm = {"P1"sv, "P2"sv, "P3"sv, "P4"sv, "P5"sv, "P6"sv, "PF"sv, "Pf"sv};
    static const std::vector<Format> list = {
        {"exr", "openexr", {"\x76\x2f\x31\x01"sv}},
        {"pfm", "pnm", pnm},
        {"hdr", "hdr", {"#?RADIANCE"sv, "#?RGBE"sv}},
        {"tif", "tiff", tiff},
        {"tiff", "tiff", tiff},
        {"dds", "dds", {"DDS "sv}},
        {"png", "png", {"\x89PNG\r\n\x1a\n"sv}},
        {"jpg", "jpeg", {"\xff\xd8\xff"sv}},
        {"jpeg", "jpeg", {"\xff\xd8\xff"sv}},
        {"ppm", "pnm", pnm},
        {"pgm", "pnm", pnm},
        {"bmp", "bmp", {"BM"sv}},
        {"tga", "targa", {}},
    };
    return list;
}

const Format& format_of(const std::string& path, const std::string& extension) {
    std::string known;
    for (const Format& f : formats()) {
        if (extension == f.extension) return f;
        known += (known.empty() ? "." : ", .") + std::string(f.extension);
    }
    throw InputError(shown(path), "", fmt::format("not a picture by its name; expected one of {}", known));
}

void check_size(const std::string& path, const OIIO::ImageSpec& spec, std::size_t file_bytes, std::int64_t limit) {
    const std::int64_t pixels = std::int64_t(spec.width) * spec.height;
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.depth > 1)
        throw InputError(shown(path), "header",
                         fmt::format("{} x {} x {} pixels of {} channels: expected a flat picture of at least one",
                                     spec.width, spec.height, spec.depth, spec.nchannels));
    if (pixels > max_pixels || spec.nchannels > max_channels || pixels * spec.nchannels > max_values)
        throw InputError(shown(path), "header",
                         fmt::format("{} x {} pixels of {} channels; the limits are 2^31 pixels, 2^34 values and {} "
                                     "channels",
                                     spec.width, spec.height, spec.nchannels, max_channels));
    if (pixels > limit)
        throw InputError(shown(path), "header",
                         fmt::format("{} x {} pixels; the limit here is {}", spec.width, spec.height, limit));
    if (spec.image_bytes(true) > most_picture_bytes(file_bytes))
        throw InputError(shown(path), "header",
                         fmt::format("declares {} x {} pixels of {} channels, which {} bytes cannot hold", spec.width,
                                     spec.height, spec.nchannels, file_bytes));
    if (spec.deep) throw InputError(shown(path), "header", "deep pictures are not read");
}

// The chunks of a PNG, up to IEND, and their checksums (ISO 15948, 5.3): libpng would print what it finds amiss.
void check_png(const std::string& path, const std::vector<unsigned char>& file) {
    static const std::array<std::uint32_t, 256> table = [] {
        std::array<std::uint32_t, 256> t{};
        for (std::uint32_t n = 0; n < 256; ++n) {
            t[n] = n;
            for (int bit = 0; bit < 8; ++bit) t[n] = (t[n] & 1 ? 0xedb88320u : 0) ^ t[n] >> 1;
        }
        return t;
    }();
    const auto word = [&](std::size_t at) {
        return std::uint32_t(file[at]) << 24 | std::uint32_t(file[at + 1]) << 16 | std::uint32_t(file[at + 2]) << 8 |
               file[at + 3];
    };
    for (std::size_t at = 8;;) {
        const std::string place = fmt::format("byte {}", at);
        if (file.size() - at < 12 || file.size() - at - 12 < word(at))
            throw InputError(shown(path), place, "the picture is cut off here");
        const std::size_t length = word(at);
        std::uint32_t crc = ~0u;
        for (std::size_t i = at + 4; i < at + 8 + length; ++i) crc = table[(crc ^ file[i]) & 255] ^ crc >> 8;
        const std::string type(file.begin() + std::ptrdiff_t(at) + 4, file.begin() + std::ptrdiff_t(at) + 8);
        if (~crc != word(at + 8 + length))
            throw InputError(shown(path), place, "the checksum of chunk " + printable(type) + " is wrong");
        if (type == "IEND") return;
        at += 12 + length;
    }
}

template <class T>
T load(const unsigned char* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return value;
}

// One value as float; `normalise` maps the whole range of an unsigned integer to 0..1.
float value_of(const unsigned char* p, OIIO::TypeDesc type, bool normalise) {
    switch (type.basetype) {
        case OIIO::TypeDesc::UINT8:
            return normalise ? float(*p) / 255.0f : float(*p);
        case OIIO::TypeDesc::UINT16:
            return normalise ? float(load<std::uint16_t>(p)) / 65535.0f : load<std::uint16_t>(p);
        case OIIO::TypeDesc::UINT32: {
            const double value = load<std::uint32_t>(p);
            return float(normalise ? value / 4294967295.0 : value);
        }
        case OIIO::TypeDesc::HALF:
            return half_to_float(load<Half>(p));
        case OIIO::TypeDesc::FLOAT:
            return load<float>(p);
        default:
            return float(load<double>(p));
    }
}

bool readable(OIIO::TypeDesc type) {
    switch (type.basetype) {
        case OIIO::TypeDesc::UINT8:
        case OIIO::TypeDesc::UINT16:
        case OIIO::TypeDesc::UINT32:
        case OIIO::TypeDesc::HALF:
        case OIIO::TypeDesc::FLOAT:
        case OIIO::TypeDesc::DOUBLE:
            return true;
        default:
            return false;
    }
}

}  // namespace

std::string reason(std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    while (!message.empty() && message.back() == ' ') message.pop_back();
    return message.empty() ? "unknown reason" : printable(message, 300);
}

bool is_picture(const std::string& extension) {
    return std::any_of(formats().begin(), formats().end(), [&](const Format& f) { return f.extension == extension; });
}

Raw read_raw(const std::string& path, std::int64_t pixels) {
    const std::string extension = extension_of(path);
    format_of(path, extension);
    return decode_raw(path, extension, read_bytes(path), pixels);
}

Raw decode_raw(const std::string& path, const std::string& extension, std::vector<unsigned char> file,
               std::int64_t pixels) {
    // The file is in memory whole: its size and its first bytes are known before a decoder sees it.
    const Format& format = format_of(path, extension);
    if (file.empty()) throw InputError(shown(path), "", "is empty; expected a picture");
    const std::string_view head(reinterpret_cast<const char*>(file.data()), std::min<std::size_t>(file.size(), 16));
    if (!format.magics.empty() && std::none_of(format.magics.begin(), format.magics.end(),
                                               [&](std::string_view m) { return head.substr(0, m.size()) == m; }))
        throw InputError(shown(path), "byte 0", fmt::format("does not begin as a .{} file does", format.extension));

    if (format.reader == std::string_view("png")) {
        check_png(path, file);
        read_png_through(path, file);
    }
    if (format.reader == std::string_view("openexr")) check_exr(path, file);
    if (format.reader == std::string_view("dds")) check_dds(path, file);
    if (format.reader == std::string_view("bmp")) check_bmp(path, file);

    Memory memory(file.data(), file.size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format.reader);
    if (!input) throw InputError(shown(path), "", "OpenImageIO here has no reader for it: " + reason(OIIO::geterror()));
    // Straight alpha and colours as they are: no reader is to change a value.
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    input->set_ioproxy(&memory);

    Raw raw;
    raw.normalise = extension != "exr";
    try {
        if (!input->open(path, raw.spec, wish)) throw InputError(shown(path), "header", reason(input->geterror()));
        check_size(path, raw.spec, file.size(), pixels);
        raw.bytes.resize(raw.spec.image_bytes(true));
        if (!input->read_image(0, 0, 0, raw.spec.nchannels, OIIO::TypeDesc::UNKNOWN, raw.bytes.data()))
            throw InputError(shown(path), "pixels", reason(input->geterror()));
        if (input->has_error()) throw InputError(shown(path), "pixels", reason(input->geterror()));
        if (input->seek_subimage(1, 0))
            throw InputError(shown(path), "", "holds several pictures; expected one (EXR: one part)");
    } catch (const InputError&) {
        throw;
    } catch (const std::exception& e) {
        throw InputError(shown(path), "", reason(e.what()));
    }
    // A JPEG that is cut off decodes to grey without an error; its end mark is what tells.
    if (format.reader == std::string_view("jpeg") &&
        (file.size() < 2 || file[file.size() - 2] != 0xff || file.back() != 0xd9))
        throw InputError(shown(path), "end", "the end of the picture is missing");
    return raw;
}

compare::Picture to_float(const std::string& path, const Raw& raw) {
    const OIIO::ImageSpec& spec = raw.spec;
    compare::Picture picture{{spec.channelnames.begin(), spec.channelnames.end()}, spec.width, spec.height, {}};
    for (std::size_t c = 0; c < picture.channels.size(); ++c)
        for (std::size_t d = 0; d < c; ++d)
            if (picture.channels[c] == picture.channels[d])
                throw InputError(shown(path), "header", "two channels are named " + printable(picture.channels[c]));
    std::vector<OIIO::TypeDesc> types;
    std::vector<std::size_t> offsets;
    std::size_t pixel_bytes = 0;
    for (int c = 0; c < spec.nchannels; ++c) {
        types.push_back(spec.channelformat(c));
        if (!readable(types.back()))
            throw InputError(shown(path), "header",
                             fmt::format("channel {} is of type {}; expected unsigned integers or floats",
                                         printable(picture.channels[std::size_t(c)]), types.back().c_str()));
        offsets.push_back(pixel_bytes);
        pixel_bytes += types.back().size();
    }

    const std::size_t pixels = std::size_t(spec.width) * std::size_t(spec.height);
    picture.data.resize(pixels * types.size());
    float* out = picture.data.data();
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c = 0; c < types.size(); ++c)
            *out++ = value_of(raw.bytes.data() + i * pixel_bytes + offsets[c], types[c], raw.normalise);
    return picture;
}

}  // namespace plumb::io
