// Pictures: from memory, through the reader of their format, to floats and to textures.
#include <array>

#include "core/error.h"
#include "io/image_decode.h"
#include "io/image_file.h"
#include "targets.h"

namespace plumb::fuzz {
namespace {

using Bytes = std::vector<unsigned char>;

std::size_t bytes_of(const compare::Picture& picture) { return picture.data.size() * sizeof(float); }

// What a header may declare: io/image_decode.cpp refuses more than can be packed into the file.
std::size_t declared(std::size_t size) { return (std::size_t(1) << 20) + 4096 * size; }

std::size_t read(const std::string& extension, const std::uint8_t* data, std::size_t size) {
    const std::string name = "a." + extension;
    try {
        const compare::Picture picture = io::to_float(name, io::decode_raw(name, extension, Bytes(data, data + size)));
        const std::size_t bytes = size + bytes_of(picture);
        for (const std::string& layer : io::layer_names(picture)) io::select_layer(picture, layer, name);
        return bytes;
    } catch (const InputError&) {
        return declared(size);
    }
}

}  // namespace

std::size_t fuzz_exr(const std::uint8_t* data, std::size_t size) { return read("exr", data, size); }

std::size_t fuzz_png(const std::uint8_t* data, std::size_t size) {
    try {
        const Texture texture = io::decode_texture("a.png", Bytes(data, data + size));
        return size + texture.texels.size() * 4 * sizeof(float);
    } catch (const InputError&) {
        return declared(size);
    }
}

std::size_t fuzz_picture(const std::uint8_t* data, std::size_t size) {
    static constexpr std::array<const char*, 8> extensions = {"hdr", "pfm", "tif", "dds", "jpg", "ppm", "bmp", "tga"};
    if (size == 0) return 0;
    return read(extensions[data[0] % extensions.size()], data + 1, size - 1);
}

}  // namespace plumb::fuzz
