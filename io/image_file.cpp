#include "io/image_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>

#include "core/error.h"
#include "core/fields.h"
#include "core/number.h"
#include "io/file.h"

namespace plumb::io {
namespace {

constexpr std::int64_t max_pixels = std::int64_t(1) << 31;
constexpr std::int64_t max_values = std::int64_t(1) << 34;
constexpr int max_channels = 1024;
constexpr std::int64_t max_texels = std::int64_t(1) << 28;

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
        {"exr", "openexr", {"\x76\x2f\x31\x01"sv}}, {"pfm", "pnm", pnm},
        {"hdr", "hdr", {"#?RADIANCE"sv, "#?RGBE"sv}}, {"tif", "tiff", tiff},
        {"tiff", "tiff", tiff}, {"dds", "dds", {"DDS "sv}},
        {"png", "png", {"\x89PNG\r\n\x1a\n"sv}}, {"jpg", "jpeg", {"\xff\xd8\xff"sv}},
        {"jpeg", "jpeg", {"\xff\xd8\xff"sv}}, {"ppm", "pnm", pnm},
        {"pgm", "pnm", pnm}, {"bmp", "bmp", {"BM"sv}},
        {"tga", "targa", {}},
    };
    return list;
}

const Format& format_of(const std::string& path) {
    const std::string extension = extension_of(path);
    std::string known;
    for (const Format& f : formats()) {
        if (extension == f.extension) return f;
        known += (known.empty() ? "." : ", .") + std::string(f.extension);
    }
    throw InputError(shown(path), "", fmt::format("not a picture by its name; expected one of {}", known));
}

// OpenImageIO's messages in one line.
std::string reason(std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    while (!message.empty() && message.back() == ' ') message.pop_back();
    return message.empty() ? "unknown reason" : printable(message, 300);
}

// A picture as its file stores it: the header, and the pixels in the file's own number types.
struct Raw {
    OIIO::ImageSpec spec;
    std::vector<unsigned char> bytes;
};

// What decoding may cost is decided from the header. Of the compressions that are read, LZW packs most: under 4096 to 1.
void check_size(const std::string& path, const OIIO::ImageSpec& spec, std::size_t file_bytes) {
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
    if (spec.image_bytes(true) > (std::size_t(1) << 20) + 4096 * file_bytes)
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
        return std::uint32_t(file[at]) << 24 | std::uint32_t(file[at + 1]) << 16 | std::uint32_t(file[at + 2]) << 8 | file[at + 3];
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

Raw read_raw(const std::string& path) {
    // The file goes into memory whole: its size and its first bytes are known before a decoder sees it.
    const Format& format = format_of(path);
    std::vector<unsigned char> file = read_bytes(path);
    if (file.empty()) throw InputError(shown(path), "", "is empty; expected a picture");
    const std::string_view head(reinterpret_cast<const char*>(file.data()), std::min<std::size_t>(file.size(), 16));
    if (!format.magics.empty() && std::none_of(format.magics.begin(), format.magics.end(),
                                               [&](std::string_view m) { return head.substr(0, m.size()) == m; }))
        throw InputError(shown(path), "byte 0", fmt::format("does not begin as a .{} file does", format.extension));

    if (format.reader == std::string_view("png")) check_png(path, file);

    OIIO::Filesystem::IOMemReader memory(file.data(), file.size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format.reader);
    if (!input) throw InputError(shown(path), "", "OpenImageIO here has no reader for it: " + reason(OIIO::geterror()));
    // Straight alpha and colours as they are: no reader is to change a value.
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    input->set_ioproxy(&memory);

    Raw raw;
    try {
        if (!input->open(path, raw.spec, wish)) throw InputError(shown(path), "header", reason(input->geterror()));
        check_size(path, raw.spec, file.size());
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
    if (format.reader == std::string_view("jpeg") && (file.size() < 2 || file[file.size() - 2] != 0xff || file.back() != 0xd9))
        throw InputError(shown(path), "end", "the end of the picture is missing");
    return raw;
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
        case OIIO::TypeDesc::UINT8: return normalise ? float(*p) / 255.0f : float(*p);
        case OIIO::TypeDesc::UINT16: return normalise ? float(load<std::uint16_t>(p)) / 65535.0f : load<std::uint16_t>(p);
        case OIIO::TypeDesc::UINT32: {
            const double value = load<std::uint32_t>(p);
            return float(normalise ? value / 4294967295.0 : value);
        }
        case OIIO::TypeDesc::HALF: return half_to_float(load<Half>(p));
        case OIIO::TypeDesc::FLOAT: return load<float>(p);
        default: return float(load<double>(p));
    }
}

bool readable(OIIO::TypeDesc type) {
    switch (type.basetype) {
        case OIIO::TypeDesc::UINT8:
        case OIIO::TypeDesc::UINT16:
        case OIIO::TypeDesc::UINT32:
        case OIIO::TypeDesc::HALF:
        case OIIO::TypeDesc::FLOAT:
        case OIIO::TypeDesc::DOUBLE: return true;
        default: return false;
    }
}

FloatPicture to_float(const std::string& path, const Raw& raw) {
    const OIIO::ImageSpec& spec = raw.spec;
    const bool normalise = extension_of(path) != "exr";
    FloatPicture picture{{spec.channelnames.begin(), spec.channelnames.end()}, spec.width, spec.height, {}};
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
            *out++ = value_of(raw.bytes.data() + i * pixel_bytes + offsets[c], types[c], normalise);
    return picture;
}

// Encodes into memory, then writes the file in one go.
void encode(const std::string& path, const char* format, const OIIO::ImageSpec& spec, const void* pixels) {
    std::vector<unsigned char> file;
    OIIO::Filesystem::IOVecOutput memory(file);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
    if (!output) throw InputError(shown(path), "", "OpenImageIO here cannot write it: " + reason(OIIO::geterror()));
    output->set_ioproxy(&memory);
    const bool done = output->open(path, spec) && output->write_image(spec.format, pixels) && output->close();
    if (!done) throw InputError(shown(path), "", "cannot be written: " + reason(output->geterror()));
    write_file(path, {{reinterpret_cast<const char*>(file.data()), file.size()}});
}

void check_writable(const std::string& path, int width, int height, std::size_t channels) {
    const std::int64_t pixels = std::int64_t(width) * height;
    if (width < 1 || height < 1 || channels < 1 || channels > max_channels || pixels > max_pixels ||
        pixels * std::int64_t(channels) > max_values)
        throw InputError(shown(path), "", fmt::format("cannot be written: {} x {} pixels of {} channels; the limits are 1 to "
                                                "2^31 pixels, 2^34 values and {} channels",
                                                width, height, channels, max_channels));
}

std::string layer_of(const std::string& channel) {
    const std::size_t dot = channel.rfind('.');
    return dot == std::string::npos ? "" : channel.substr(0, dot);
}

}  // namespace

std::string channel_name(const std::vector<Layer>& layers, std::size_t layer, std::size_t component) {
    const std::string& letter = layers[layer].components[component];
    return layer == 0 && layers[0].name == "color" ? letter : layers[layer].name + "." + letter;
}

void write_exr(const std::string& path, int width, int height, const std::vector<Layer>& layers) {
    std::vector<std::string> names;
    for (std::size_t l = 0; l < layers.size(); ++l)
        for (std::size_t c = 0; c < layers[l].components.size(); ++c) {
            names.push_back(channel_name(layers, l, c));
            // OpenEXR holds 255 bytes of a name, and of two channels of one name it would keep one.
            if (names.back().empty() || names.back().size() > 255 ||
                std::count(names.begin(), names.end(), names.back()) > 1)
                throw InputError(shown(path), "", "cannot be written: channel \"" + printable(names.back()) +
                                                "\" is named twice or has no name of 1 to 255 bytes");
        }
    check_writable(path, width, height, names.size());

    // Interleaves the layers' components.
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    std::vector<float> values(pixels * names.size());
    std::size_t first = 0;
    for (const Layer& layer : layers) {
        const std::size_t n = layer.components.size();
        for (std::size_t i = 0; i < pixels; ++i)
            std::copy_n(layer.data + i * std::size_t(layer.stride), n, values.data() + i * names.size() + first);
        first += n;
    }

    OIIO::ImageSpec spec(width, height, int(names.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = {names.begin(), names.end()};
    spec.attribute("compression", "zip");
    spec.attribute("DateTime", "");  // without it OpenImageIO writes the time of day
    encode(path, "openexr", spec, values.data());
}

void write_png(const std::string& path, int width, int height, const std::uint8_t* rgb) {
    check_writable(path, width, height, 3);
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    encode(path, "png", spec, rgb);
}

FloatPicture read_picture(const std::string& path) { return to_float(path, read_raw(path)); }

std::vector<std::string> layer_names(const FloatPicture& picture) {
    std::vector<std::string> names;
    for (const std::string& channel : picture.channels)
        if (std::find(names.begin(), names.end(), layer_of(channel)) == names.end()) names.push_back(layer_of(channel));
    return names;
}

FloatPicture select_layer(const FloatPicture& picture, const std::string& layer, const std::string& path) {
    FloatPicture selected{{}, picture.width, picture.height, {}};
    std::vector<std::size_t> from;
    for (std::size_t c = 0; c < picture.channels.size(); ++c)
        if (layer_of(picture.channels[c]) == layer) {
            from.push_back(c);
            selected.channels.push_back(picture.channels[c].substr(layer.empty() ? 0 : layer.size() + 1));
        }
    if (from.empty())
        throw InputError(shown(path), "",
                         fmt::format("has no layer \"{}\"; the nearest is \"{}\"", printable(layer),
                                     printable(nearest_name(layer, layer_names(picture)))));
    const std::size_t pixels = std::size_t(picture.width) * std::size_t(picture.height);
    selected.data.reserve(pixels * from.size());
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c : from) selected.data.push_back(picture.data[i * picture.channels.size() + c]);
    return selected;
}

Texture read_texture(const std::string& path) {
    const Raw raw = read_raw(path);
    const std::int64_t width = raw.spec.width, height = raw.spec.height;
    if (width * height > max_texels)
        throw InputError(shown(path), "header", fmt::format("{} x {} texels; the limit is 2^28", width, height));
    if (raw.spec.nchannels > 4)
        throw InputError(shown(path), "header",
                         fmt::format("{} channels; expected 1 to 4: grey, grey and alpha, RGB, RGBA", raw.spec.nchannels));
    const FloatPicture picture = to_float(path, raw);

    Texture texture;
    texture.name = std::filesystem::path(path).filename().string();
    texture.srgb = !raw.spec.format.is_floating_point();
    texture.texels = Image<std::uint32_t>(int(width), int(height));
    const std::size_t n = picture.channels.size();
    for (std::size_t i = 0; i < texture.texels.size(); ++i) {
        std::uint32_t byte[4] = {};
        for (std::size_t c = 0; c < n; ++c) {
            const float value = picture.data[i * n + c];
            if (!(value >= 0 && value <= 1))
                throw InputError(shown(path), fmt::format("pixel {},{}", i % std::size_t(width), i / std::size_t(width)),
                                 fmt::format("{} = {}; a texture's values lie in 0 to 1", printable(picture.channels[c]),
                                             value));
            byte[c] = std::uint32_t(value * 255.0f + 0.5f);
        }
        const std::uint32_t red = byte[0], green = n < 3 ? red : byte[1], blue = n < 3 ? red : byte[2];
        const std::uint32_t alpha = n == 4 ? byte[3] : n == 2 ? byte[1] : 255;
        texture.texels.data()[i] = red | green << 8 | blue << 16 | alpha << 24;
    }
    return texture;
}

}  // namespace plumb::io
