// Pictures that OpenImageIO reads, and arrays of NumPy, as dumps.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/nearest_known.h"
#include "core/number.h"
#include "io/dump_source.h"
#include "io/file.h"
#include "io/image_decode.h"
#include "io/npy.h"

namespace plumb::io {
namespace {

using OIIO::TypeDesc;

template <class T>
double load(const unsigned char* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return double(value);
}

double load_half(const unsigned char* p) {
    Half half;
    std::memcpy(&half, p, sizeof half);
    return half_to_float(half);
}

bool is_readable(TypeDesc type) {
    const auto t = type.basetype;
    return t == TypeDesc::UINT8 || t == TypeDesc::UINT16 || t == TypeDesc::UINT32 || t == TypeDesc::INT32 ||
           t == TypeDesc::HALF || t == TypeDesc::FLOAT || t == TypeDesc::DOUBLE;
}

double value_of(const unsigned char* p, TypeDesc type, bool normalise) {
    switch (type.basetype) {
        case TypeDesc::UINT8:
            return *p / (normalise ? 255.0 : 1.0);
        case TypeDesc::UINT16:
            return load<std::uint16_t>(p) / (normalise ? 65535.0 : 1.0);
        case TypeDesc::UINT32:
            return load<std::uint32_t>(p);
        case TypeDesc::INT32:
            return load<std::int32_t>(p);
        case TypeDesc::HALF:
            return load_half(p);
        case TypeDesc::FLOAT:
            return load<float>(p);
        default:
            return load<double>(p);
    }
}

std::string layer_of(const std::string& channel) {
    const std::size_t dot = channel.rfind('.');
    return dot == std::string::npos ? "" : channel.substr(0, dot);
}

// A channel of the layer, and which component it is.
struct Channel {
    std::string name;
    TypeDesc type;
    std::size_t offset = 0;  // bytes from the start of a pixel
    int component = 0;
};

class PictureSource : public DumpSource {
  public:
    PictureSource(const DumpSpec& spec, bool normalise) : raw_(read_raw(spec.file.string())), normalise_(normalise) {
        if (raw_.spec.width > max_side || raw_.spec.height > max_side)
            fail_dump(spec, fmt::format("{} x {} pixels; expected 1 to {} a side", raw_.spec.width, raw_.spec.height,
                                        max_side));
        width = raw_.spec.width, height = raw_.spec.height;
        find_channels(spec);
        place_channels();
        find_types(spec);
    }

    void read(int x, int y, int n, double* to) const override {
        const unsigned char* from =
            raw_.bytes.data() + (std::size_t(y) * std::size_t(width) + std::size_t(x)) * stride_;
        for (int i = 0; i < n; ++i, from += stride_, to += 4) {
            to[0] = to[1] = to[2] = 0, to[3] = 1;
            for (const Channel& c : from_) to[c.component] = value_of(from + c.offset, c.type, normalise_);
        }
    }

  private:
    static constexpr int max_side = 32767;

    void find_channels(const DumpSpec& spec) {
        std::vector<std::string> layers;
        for (int c = 0; c < raw_.spec.nchannels; ++c) {
            const std::string name = raw_.spec.channelnames[std::size_t(c)], layer = layer_of(name);
            const TypeDesc type = raw_.spec.channelformat(c);
            if (layer == spec.layer)
                from_.push_back({name.substr(layer.empty() ? 0 : layer.size() + 1), type, stride_, int(from_.size())});
            if (std::find(layers.begin(), layers.end(), layer) == layers.end()) layers.push_back(layer);
            stride_ += type.size();
        }
        if (from_.empty())
            fail_dump(spec, fmt::format("has no layer \"{}\"{}", printable(spec.layer),
                                        shown(nearest_known(spec.layer, layers, "\"\""))));
        if (from_.size() > 4)
            fail_dump(spec, fmt::format("layer \"{}\" has {} channels; expected 1 to 4", printable(spec.layer),
                                        from_.size()));
    }

    // R, G, B, A or X, Y, Z, W are the components of those names where the first is there; other names go by their
    // order.
    void place_channels() {
        for (const std::string letters : {"RGBA", "XYZW"}) {
            const auto is_first = [&](const Channel& c) { return c.name == letters.substr(0, 1); };
            const auto is_known = [&](const Channel& c) {
                return c.name.size() == 1 && letters.find(c.name) != letters.npos;
            };
            if (std::none_of(from_.begin(), from_.end(), is_first) ||
                !std::all_of(from_.begin(), from_.end(), is_known))
                continue;
            for (Channel& c : from_) c.component = int(letters.find(c.name));
        }
        for (const Channel& c : from_) channels = std::max(channels, c.component + 1);
    }

    void find_types(const DumpSpec& spec) {
        const auto all = [&](auto holds) {
            return std::all_of(from_.begin(), from_.end(), [&](const Channel& c) { return holds(c.type.basetype); });
        };
        for (const Channel& c : from_)
            if (!is_readable(c.type))
                fail_dump(spec, fmt::format("channel {} is of type {}; expected unsigned integers, int32 or floats",
                                            printable(c.name), c.type.c_str()));
        const auto any = [&](TypeDesc::BASETYPE t) { return !all([t](auto other) { return other != t; }); };
        // Of mixed types integers are numbers among others, and the coarsest says how all are rounded.
        if (all([](auto t) { return t == TypeDesc::UINT32 || t == TypeDesc::INT32; }) ||
            (!normalise_ && all([](auto t) { return t == TypeDesc::UINT8 || t == TypeDesc::UINT16; })))
            kind = TexelKind::uint32;
        else if (any(TypeDesc::UINT8))
            kind = TexelKind::unorm8;
        else if (any(TypeDesc::HALF))
            kind = TexelKind::float16;
        else if (any(TypeDesc::UINT16))
            kind = TexelKind::unorm16;
        if (extension_of(spec.file.string()) == "hdr") kind = TexelKind::shared_exponent;
    }

    Raw raw_;
    bool normalise_;
    std::size_t stride_ = 0;  // bytes of a pixel
    std::vector<Channel> from_;
};

class NpySource : public DumpSource {
  public:
    // An image has two extents and up to four channels. Anything else is a row of numbers, of the array's own shape.
    NpySource(const DumpSpec& spec, bool as_image) : array_(read_npy(spec.file.string())) {
        const DType type = array_.dtype;
        if (type == DType::f16) kind = TexelKind::float16;
        if (type == DType::u8 || type == DType::u16 || type == DType::i32 || type == DType::u32)
            kind = TexelKind::uint32;
        const Shape& extents = array_.shape;
        const std::size_t rank = extents.size(), count = array_.bytes.size() / dtype_size(array_.dtype);
        if (count < 1 || count > std::size_t(std::numeric_limits<int>::max()))
            fail_dump(spec, fmt::format("shape {}: expected 1 to 2^31 - 1 numbers", shape_text(extents)));
        channels = as_image && rank == 3 ? int(std::min<std::int64_t>(extents[2], 5)) : 1;
        if (!as_image) {
            width = int(count), height = 1, shape = extents, keeps_shape = true;
        } else if ((rank == 2 || rank == 3) && is_side(extents[0]) && is_side(extents[1]) && channels <= 4) {
            height = int(extents[0]), width = int(extents[1]);
        } else {
            fail_dump(spec, fmt::format("shape {}: expected an image, [height, width] or [height, width, 1 to 4]",
                                        shape_text(extents)));
        }
    }

    void read(int x, int y, int n, double* to) const override {
        const std::size_t first = (std::size_t(y) * std::size_t(width) + std::size_t(x)) * std::size_t(channels);
        for (int i = 0; i < n; ++i) {
            to[4 * i] = to[4 * i + 1] = to[4 * i + 2] = 0, to[4 * i + 3] = 1;
            for (int c = 0; c < channels; ++c)
                to[4 * i + c] = value(first + std::size_t(i) * std::size_t(channels) + std::size_t(c));
        }
    }

  private:
    static bool is_side(std::int64_t n) { return n >= 1 && n <= 32767; }

    double value(std::size_t i) const {
        const unsigned char* p = array_.bytes.data() + i * dtype_size(array_.dtype);
        switch (array_.dtype) {
            case DType::f32:
                return load<float>(p);
            case DType::f64:
                return load<double>(p);
            case DType::u8:
                return *p;
            case DType::u16:
                return load<std::uint16_t>(p);
            case DType::i32:
                return load<std::int32_t>(p);
            case DType::u32:
                return load<std::uint32_t>(p);
            case DType::f16:
                return load_half(p);
        }
        return 0;
    }

    Array array_;
};

}  // namespace

std::unique_ptr<DumpSource> open_picture(const DumpSpec& spec) {
    return std::make_unique<PictureSource>(spec, spec.encoding != "integer");
}

std::unique_ptr<DumpSource> open_npy(const DumpSpec& spec) {
    const bool as_image = spec.width > 0 || !spec.channels.empty() || spec.encoding != "plain" || spec.flip_y;
    return std::make_unique<NpySource>(spec, as_image);
}

}  // namespace plumb::io
