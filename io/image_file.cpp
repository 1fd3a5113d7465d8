#include "io/image_file.h"

#include <fmt/format.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>

#include "core/error.h"
#include "core/nearest_known.h"
#include "io/exr_attributes.h"
#include "io/file.h"
#include "io/image_decode.h"

namespace plumb::io {
namespace {

constexpr std::int64_t max_texels = std::int64_t(1) << 28;
constexpr std::int64_t max_map_texels = std::int64_t(1) << 27;  // 40 bytes each, with the tables to sample them by

// A file's bytes; write(output) writes the pixels, and returns whether it could.
std::vector<unsigned char> encode(const std::string& path, const char* format, const OIIO::ImageSpec& spec,
                                  const std::function<bool(OIIO::ImageOutput&)>& write) {
    std::vector<unsigned char> file;
    file.reserve(std::size_t(spec.image_bytes()));  // else it is copied each time that it grows
    OIIO::Filesystem::IOVecOutput memory(file);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
    if (!output) throw InputError(shown(path), "", "OpenImageIO here cannot write it: " + reason(OIIO::geterror()));
    output->set_ioproxy(&memory);
    const bool done = output->open(path, spec) && write(*output) && output->close();
    if (!done) throw InputError(shown(path), "", "cannot be written: " + reason(output->geterror()));
    return file;
}

std::vector<unsigned char> encode(const std::string& path, const char* format, const OIIO::ImageSpec& spec,
                                  const void* pixels) {
    return encode(path, format, spec,
                  [&](OIIO::ImageOutput& output) { return output.write_image(spec.format, pixels); });
}

void write_encoded(const std::string& path, const std::vector<unsigned char>& file) {
    write_file(path, {{reinterpret_cast<const char*>(file.data()), file.size()}});
}

void check_writable(const std::string& path, int width, int height, std::size_t channels) {
    const std::int64_t pixels = std::int64_t(width) * height;
    if (width < 1 || height < 1 || channels < 1 || channels > max_channels || pixels > max_pixels ||
        pixels * std::int64_t(channels) > max_values)
        throw InputError(shown(path), "",
                         fmt::format("cannot be written: {} x {} pixels of {} channels; the limits are 1 to "
                                     "2^31 pixels, 2^34 values and {} channels",
                                     width, height, channels, max_channels));
}

// Rows of a picture that are handed to its encoder at once: enough for all threads, few enough for the cache.
constexpr int band_rows = 32;

// The layers' components side by side, for rows [y, end).
void interleave(const std::vector<Layer>& layers, int width, int y, int end, std::size_t channels,
                std::vector<float>& values) {
    const std::size_t begin = std::size_t(y) * std::size_t(width), pixels = std::size_t(end - y) * std::size_t(width);
    values.resize(pixels * channels);
    float* to = values.data();
    for (const Layer& layer : layers) {
        const std::size_t n = layer.components.size(), stride = std::size_t(layer.stride);
        const float* from = layer.data + begin * stride;
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < n; ++c) to[i * channels + c] = from[i * stride + c];
        to += n;
    }
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
    write_exr(path, width, height, layers, {});
}

void write_exr(const std::string& path, int width, int height, const std::vector<Layer>& layers, const Attributes& attributes) {
    std::vector<std::string> names;
    for (std::size_t l = 0; l < layers.size(); ++l)
        for (std::size_t c = 0; c < layers[l].components.size(); ++c) {
            names.push_back(channel_name(layers, l, c));
            // OpenEXR holds 255 bytes of a name, and of two channels of one name it would keep one.
            if (names.back().empty() || names.back().size() > 255 ||
                std::count(names.begin(), names.end(), names.back()) > 1)
                throw InputError(shown(path), "",
                                 "cannot be written: channel \"" + printable(names.back()) +
                                     "\" is named twice or has no name of 1 to 255 bytes");
        }
    check_writable(path, width, height, names.size());

    OIIO::ImageSpec spec(width, height, int(names.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = {names.begin(), names.end()};
    // ZIP takes six times as long, more than rendering a frame, for files that are a quarter smaller: most bytes of
    // floats are noise to it, and what is constant along a row shrinks by RLE, too.
    spec.attribute("compression", "rle");
    spec.attribute("DateTime", "");  // without it OpenImageIO writes the time of day
    for (const auto& [name, value] : attributes) spec.attribute(name, value);
    write_encoded(path, encode(path, "openexr", spec, [&](OIIO::ImageOutput& output) {
        std::vector<float> band;
        for (int y = 0; y < height; y += band_rows) {
            const int end = std::min(y + band_rows, height);
            interleave(layers, width, y, end, names.size(), band);
            if (!output.write_scanlines(y, end, 0, spec.format, band.data())) return false;
        }
        return true;
    }));
}

void write_png(const std::string& path, int width, int height, const std::uint8_t* rgb) {
    check_writable(path, width, height, 3);
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("png:compressionLevel", 2);  // the default, 6, takes half as long again for the same size
    write_encoded(path, encode(path, "png", spec, rgb));
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
                         fmt::format("has no layer \"{}\"{}", printable(layer),
                                     shown(nearest_known(layer, layer_names(picture), "\"\""))));
    const std::size_t pixels = std::size_t(picture.width) * std::size_t(picture.height);
    selected.data.reserve(pixels * from.size());
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c : from) selected.data.push_back(picture.data[i * picture.channels.size() + c]);
    return selected;
}

namespace {

std::string pixel_name(std::size_t i, int width) {
    return fmt::format("pixel {},{}", i % std::size_t(width), i / std::size_t(width));
}

Texture to_texture(const std::string& path, const Raw& raw) {
    if (raw.spec.nchannels > 4)
        throw InputError(
            shown(path), "header",
            fmt::format("{} channels; expected 1 to 4: grey, grey and alpha, RGB, RGBA", raw.spec.nchannels));
    const FloatPicture picture = to_float(path, raw);

    Texture texture;
    texture.name = std::filesystem::path(path).filename().string();
    texture.srgb = !raw.spec.format.is_floating_point();
    texture.texels = Image<std::uint32_t>(picture.width, picture.height);
    const std::size_t n = picture.channels.size();
    for (std::size_t i = 0; i < texture.texels.size(); ++i) {
        std::uint32_t byte[4] = {};
        for (std::size_t c = 0; c < n; ++c) {
            const float value = picture.data[i * n + c];
            if (!(value >= 0 && value <= 1))
                throw InputError(
                    shown(path), pixel_name(i, picture.width),
                    fmt::format("{} = {}; a texture's values lie in 0 to 1", printable(picture.channels[c]), value));
            byte[c] = std::uint32_t(value * 255.0f + 0.5f);
        }
        const std::uint32_t red = byte[0], green = n < 3 ? red : byte[1], blue = n < 3 ? red : byte[2];
        const std::uint32_t alpha = n == 4 ? byte[3] : n == 2 ? byte[1] : 255;
        texture.texels.data()[i] = red | green << 8 | blue << 16 | alpha << 24;
    }
    return texture;
}

}  // namespace

Texture read_texture(const std::string& path) { return to_texture(path, read_raw(path, max_texels)); }

Texture decode_texture(const std::string& name, const std::vector<unsigned char>& file) {
    const bool is_jpeg = file.size() > 1 && file[0] == 0xff && file[1] == 0xd8;
    return to_texture(name, decode_raw(name, is_jpeg ? "jpg" : "png", file, max_texels));
}

Image4 read_radiance_map(const std::string& path) {
    const std::string extension = extension_of(path);
    if (extension != "exr" && extension != "hdr" && extension != "pfm")
        throw InputError(shown(path), "", "holds no radiance by its name; expected .exr, .hdr or .pfm");
    const Raw raw = read_raw(path, max_map_texels);
    const OIIO::ImageSpec& spec = raw.spec;
    if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
        spec.height != spec.full_height)
        throw InputError(shown(path), "header", "only a part of the picture is in the file; expected all directions");
    const FloatPicture picture = select_layer(to_float(path, raw), "", path);

    // Takes red, green and blue, or the only channel for all three.
    const std::size_t n = picture.channels.size();
    std::array<std::size_t, 3> from{};
    for (std::size_t c = 0; c < 3 && n > 1; ++c) {
        const std::string name(1, "RGB"[c]);
        const auto at = std::find(picture.channels.begin(), picture.channels.end(), name);
        if (at == picture.channels.end())
            throw InputError(shown(path), "header", "has no channel " + name + "; expected R, G and B, or one channel");
        from[c] = std::size_t(at - picture.channels.begin());
    }
    Image4 map(picture.width, picture.height);
    for (std::size_t i = 0; i < map.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const float value = picture.data[i * n + from[std::size_t(c)]];
            if (!(value >= 0 && std::isfinite(value)))
                throw InputError(shown(path), pixel_name(i, picture.width),
                                 fmt::format("{} = {}; a radiance is finite and not negative",
                                             printable(picture.channels[from[std::size_t(c)]]), value));
            map.data()[i][c] = value;
        }
    return map;
}

std::vector<unsigned char> encode_png(const std::string& name, const Image<std::uint32_t>& texels) {
    check_writable(name, texels.width, texels.height, 4);
    std::vector<unsigned char> bytes;
    bytes.reserve(texels.size() * 4);
    for (std::uint32_t texel : texels.texels)
        for (int c = 0; c < 4; ++c) bytes.push_back(static_cast<unsigned char>(texel >> 8 * c & 255));
    OIIO::ImageSpec spec(texels.width, texels.height, 4, OIIO::TypeDesc::UINT8);
    spec.alpha_channel = 3;
    spec.attribute("oiio:UnassociatedAlpha", 1);  // colours stay as they are, where alpha is 0 too
    return encode(name, "png", spec, bytes.data());
}

}  // namespace plumb::io
