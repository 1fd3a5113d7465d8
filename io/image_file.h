// Pictures in files, through OpenImageIO. See io/README.md for the formats, the names of layers and the limits.
//
// Equal pictures are equal files: nothing that is written carries a time, a name of a program or of a machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/compare.h"
#include "core/scene.h"

namespace plumb::io {

using FloatPicture = compare::Picture;

// One buffer of a frame as it lies in memory: component c of pixel i is data[i * stride + c], i = y * width + x.
struct Layer {
    std::string name;                     // "color", "normal", "rsm.key.flux"
    std::vector<std::string> components;  // {"R", "G", "B"}, {"X", "Y", "Z"}, {"V"}
    const float* data = nullptr;
    int stride = 4;  // floats from one pixel to the next
};

// The channel that holds a component: "R" for the layer "color" where it comes first, "layer.R" otherwise.
std::string channel_name(const std::vector<Layer>& layers, std::size_t layer, std::size_t component);

// EXR, 32-bit float, RLE. Every bit arrives as it is, NaN and Inf included. Throws InputError.
void write_exr(const std::string& path, int width, int height, const std::vector<Layer>& layers);

// PNG, 8 bits, RGB: rgb holds width * height * 3 bytes, encoded by the sRGB curve, first row on top. Throws InputError.
void write_png(const std::string& path, int width, int height, const std::uint8_t* rgb);

// EXR, PFM, HDR, TIFF, DDS, PNG and what else io/README.md lists, by the name's extension. Integers become 0..1 (those
// of EXR keep their value), colours stay encoded as they are. NaN and Inf pass. Throws InputError.
FloatPicture read_picture(const std::string& path);

// The channels of one layer, in the file's order, with the layer's name taken off. "" is the channels without a dot.
// Throws InputError that names the nearest layer; `path` is for messages.
FloatPicture select_layer(const FloatPicture& picture, const std::string& layer, const std::string& path);
std::vector<std::string> layer_names(const FloatPicture& picture);  // in the file's order, without repetition

// Radiance by direction (core/scene.h, Environment): RGB or grey of an EXR, HDR or PFM, w = 0. Every value is finite
// and not negative, or InputError names its pixel.
Image4 read_radiance_map(const std::string& path);

// A texture of 8 bits a channel. Integer files are taken as sRGB; files of floats as linear, rounded to 8 bits: a value
// that is not in 0..1 (NaN too) is an error that names its pixel. Grey becomes RGB, a missing alpha 1.
Texture read_texture(const std::string& path);
// The same of a PNG or JPEG in memory, told apart by its first bytes; `name` is for messages.
Texture decode_texture(const std::string& name, const std::vector<unsigned char>& file);

// The bytes of a PNG of 8 bits, RGBA, straight alpha: decode_texture() returns the same texels. Throws InputError.
std::vector<unsigned char> encode_png(const std::string& name, const Image<std::uint32_t>& texels);

}  // namespace plumb::io
