#include "tests/foreign/textures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "core/host_math.h"
#include "io/npy.h"

namespace plumb::foreign {

namespace {

int bytes_of(const Texture& t) { return int(t.bytes.size()) / (t.width * t.height); }

Format format_of(const Texture& texture) {
    for (const FormatInfo& f : formats())
        if (f.vulkan_name == texture.format) return f.format;
    throw std::runtime_error("no format " + texture.format);
}

void write_bytes(const std::string& path, const void* data, std::size_t bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(static_cast<const char*>(data), std::streamsize(bytes));
    if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace

Texture pack(const Image4& image, Format format) {
    const FormatInfo& f = info(format);
    Texture out{f.vulkan_name, image.width, image.height,
                std::vector<unsigned char>(image.size() * std::size_t(f.bytes)), false};
    for (std::size_t i = 0; i < image.size(); ++i)
        encode(format, image.texels[i], out.bytes.data() + i * std::size_t(f.bytes));
    return out;
}

Texture pack_biased(const Image4& image, Format format) {
    Image4 codes = image;
    for (glm::vec4& c : codes.texels) c = {0.5f * glm::vec3(c) + 0.5f, c.w};
    return pack(codes, format);
}

Image4 unpack(const Texture& texture) {
    Image4 out(texture.width, texture.height);
    const Format format = format_of(texture);
    const std::size_t bytes = std::size_t(bytes_of(texture));
    for (std::size_t i = 0; i < out.size(); ++i) out.texels[i] = decode(format, texture.bytes.data() + i * bytes);
    return out;
}

Texture upside_down(const Texture& texture) {
    Texture out = texture;
    const std::size_t row = texture.bytes.size() / std::size_t(texture.height);
    for (int y = 0; y < texture.height; ++y) {
        const unsigned char* from = texture.bytes.data() + std::size_t(y) * row;
        std::memcpy(out.bytes.data() + std::size_t(texture.height - 1 - y) * row, from, row);
    }
    out.bottom_first = !texture.bottom_first;
    return out;
}

Texture moved(const Texture& texture, int pixels) {
    Texture out = texture;
    const std::ptrdiff_t texel = bytes_of(texture), row = texel * texture.width;
    for (int y = 0; y < texture.height; ++y) {
        unsigned char* first = out.bytes.data() + y * row;
        std::rotate(first, first + pixels * texel, first + row);
    }
    return out;
}

io::DumpSpec write_texture(const std::string& folder, const std::string& name, const Texture& texture,
                           const std::string& channels, const std::string& encoding) {
    io::DumpSpec spec;
    spec.file = folder + "/" + name + ".raw";
    spec.vk_format = texture.format;
    spec.width = texture.width, spec.height = texture.height;
    spec.channels = channels, spec.encoding = encoding;
    spec.flip_y = texture.bottom_first;
    write_bytes(spec.file.string(), texture.bytes.data(), texture.bytes.size());
    return spec;
}

Pattern spiral(int samples, float radius, bool whole) {
    Pattern out;
    const double golden_angle = host::pi * (3 - std::sqrt(5.0)),
                 area = host::pi * double(radius) * double(radius) / samples;
    for (int i = 0; i < samples; ++i) {
        const double r = radius * std::sqrt((i + 0.5) / samples);
        glm::dvec2 d{r * host::cos(golden_angle * i), r * host::sin(golden_angle * i)};
        if (whole) d = {std::floor(d.x + 0.5), std::floor(d.y + 0.5)};
        out.push_back({float(d.x), float(d.y), float(area)});
    }
    return out;
}

io::DumpSpec write_pattern(const std::string& folder, const std::string& name, const Pattern& pattern) {
    io::DumpSpec spec;
    spec.file = folder + "/" + name + ".npy";
    io::write_npy(spec.file.string(), DType::f32, {std::int64_t(pattern.size()), 3}, pattern.data());
    return spec;
}

}  // namespace plumb::foreign
