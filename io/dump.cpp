#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "io/dump_encoding.h"
#include "io/dump_source.h"
#include "io/file.h"

namespace plumb::io {
namespace {

constexpr int max_run = 65536;                              // texels that are decoded at a time
constexpr std::int64_t max_texels = std::int64_t(1) << 28;  // of an image, as of a scene's frame

// From records of four doubles to the array's own numbers.
class DumpReader {
  public:
    DumpReader(const DumpSpec& spec, const DumpSource& source)
        : spec_(spec),
          source_(source),
          encoding_(parse_encoding(spec.encoding)),
          picks_(parse_channels(spec.channels)),
          integer_(is_integer(source.kind)) {
        check_source();
        // As they lie: the file's components, or those that the encoding takes.
        const int wanted = encoded_components(encoding_);
        for (int c = 0; picks_.size() < std::size_t(wanted ? wanted : source.channels) && spec.channels.empty(); ++c)
            picks_.push_back({c});
        for (std::size_t c = 0; c < picks_.size(); ++c) mask_ |= unsigned(picks_[c].from != Pick::absent) << c;
        if (decoded_mask(encoding_)) mask_ = decoded_mask(encoding_);
        if (wanted == 2) second_ = picks_[1].from;
    }

    DumpedImage read() {
        DumpedImage image;
        image.channels = mask_;
        const StoredAs stored = stored_as(source_.kind, source_.is_depth, encoding_, picks_);
        image.stored = stored.format, image.lowest = stored.lowest, image.highest = stored.highest;
        const bool is_buffer = spec_.count > 0 || source_.keeps_shape;
        const int components = is_buffer || integer_ ? components_of_result() : 4;
        Shape shape = {source_.height, source_.width, components};
        if (spec_.count > 0) shape = {source_.width, components};
        if (source_.keeps_shape) shape = source_.shape;
        Bundle bundle;
        const std::string name = stem_of(spec_.file.string());
        image.array = std::move(add(bundle, name, integer_ ? DType::i32 : DType::f32, shape));
        to_ = image.array.bytes.data(), components_ = components;
        if (stored.by_value) {
            image.rounding = std::move(add(bundle, name + ".rounding", DType::f32, shape));
            rounding_ = reinterpret_cast<float*>(image.rounding.bytes.data());
        }

        // Rows of any length are cut into runs.
        const int runs = (source_.width + max_run - 1) / max_run;
        const std::int64_t items = std::int64_t(runs) * source_.height;
        const int band = int(std::clamp<std::int64_t>(max_run / std::max(source_.width, 1), 1, 64));
        parallel_bands(int(items), band, 0, [&](int first, int last) {
            std::vector<double> records(4 * std::size_t(std::min(source_.width, max_run)));
            for (int i = first; i < last; ++i) read_run(i % runs * max_run, i / runs, records.data());
        });
        if (spec_.filling) find_unwritten(image);
        return image;
    }

  private:
    [[noreturn]] void fail(const std::string& key, const std::string& cause) const {
        throw InputError(fmt::format("{}: {}", shown(spec_.file.string()), key + ": " + cause));
    }

    int components_of_result() const { return decoded_mask(encoding_) ? std::bit_width(mask_) : int(picks_.size()); }

    void check_source() const {
        if (source_.height > 1 && std::int64_t(source_.width) * source_.height > max_texels)
            fail("size", fmt::format("{} x {} texels; the limit is 2^28", source_.width, source_.height));
        if (!source_.keeps_shape && spec_.width > 0 && (source_.width != spec_.width || source_.height != spec_.height))
            fail("size",
                 fmt::format("is {} x {}; expected {} x {}", source_.width, source_.height, spec_.width, spec_.height));
        const int wanted = encoded_components(encoding_);
        if (integer_ && encoding_ != Encoding::plain && encoding_ != Encoding::integer)
            fail("encoding", fmt::format("the file holds integers, which have no encoding; expected plain, not {}",
                                         spec_.encoding));
        if (encoding_ == Encoding::integer && !integer_) fail("encoding", "the file does not hold integers");
        if (source_.kind == TexelKind::srgb8 && encoding_ == Encoding::srgb)
            fail("encoding", "the format is sRGB, and decoded already");
        if (picks_.empty() && wanted > source_.channels)
            fail("encoding",
                 fmt::format("{} takes {} channels; the file has {}", spec_.encoding, wanted, source_.channels));
        for (const Pick& pick : picks_)
            if (pick.from < 4 && pick.from >= source_.channels)
                fail("channels", fmt::format("\"{}\": the file has {} channel{}", spec_.channels, source_.channels,
                                             source_.channels == 1 ? "" : "s"));
    }

    void read_run(int x, int y, double* records) const {
        const int n = std::min(source_.width - x, max_run);
        source_.read(x, y, n, records);
        const int row = spec_.flip_y ? source_.height - 1 - y : y;
        const std::size_t first =
            (std::size_t(row) * std::size_t(source_.width) + std::size_t(x)) * std::size_t(components_);
        const bool as_they_lie = encoding_ == Encoding::plain && spec_.channels.empty();
        for (int i = 0; i < n; ++i) {
            double v[4] = {0, 0, 0, 1};
            const double* from = records + 4 * i;
            if (as_they_lie)
                std::copy_n(from, 4, v);
            else
                decode(from, v);
            const std::size_t at = first + std::size_t(i) * std::size_t(components_);
            store(v, at);
            if (rounding_) store_rounding(from, v, rounding_ + at);
        }
    }

    void find_unwritten(DumpedImage& image) const {
        image.absent = source_.absent;
        std::vector<std::uint8_t> marks(std::size_t(source_.width) * std::size_t(source_.height));
        for (int y = 0; y < source_.height; ++y) {
            const int row = spec_.flip_y ? source_.height - 1 - y : y;
            source_.mark_unwritten(0, y, source_.width, marks.data() + std::ptrdiff_t(row) * source_.width);
        }
        const bool any = std::any_of(marks.begin(), marks.end(), [](std::uint8_t mark) { return mark != 0; });
        if (any) image.unwritten = std::move(marks);
    }

    void decode(const double* from, double* v) const {
        for (std::size_t c = 0; c < picks_.size(); ++c)
            if (picks_[c].from != Pick::absent)
                v[c] = picks_[c].from < 4 ? from[picks_[c].from] : double(picks_[c].from == Pick::one);
        decode_record(encoding_, picks_, spec_.near_far, v);
    }

    // How far each decoded number moves where the stored ones go to the next code.
    void store_rounding(const double* from, const double* v, float* to) const {
        double moved_by[4] = {0, 0, 0, 0};
        if (encoding_ == Encoding::srgb)
            move_by_slope(from, moved_by);
        else
            move_by_codes(from, v, moved_by);
        // The result itself was rounded to float.
        for (int c = 0; c < components_; ++c)
            to[c] = std::isfinite(v[c]) ? float((moved_by[c] + std::fabs(v[c]) * 0x1p-24) * (1 + 0x1p-20)) : 0.0f;
    }

    // All up, all down, and of two numbers crosswise.
    void move_by_codes(const double* from, const double* v, double* moved_by) const {
        double record[4], w[4];
        for (unsigned signs = 0; signs < (second_ < 0 ? 2u : 4u); ++signs) {
            std::copy_n(from, 4, record);
            // The exponent of rgbe is no quantity that was rounded.
            for (int c = 0; c < (encoding_ == Encoding::rgbe ? 3 : source_.channels); ++c) {
                const bool up = c == second_ ? (signs ^ signs >> 1) & 1 : signs & 1;
                record[c] += (up ? 1 : -1) * texel_step(source_.kind, from, c);
            }
            std::fill_n(w, 3, 0.0), w[3] = 1;
            decode(record, w);
            for (int c = 0; c < components_; ++c) moved_by[c] = std::max(moved_by[c], std::fabs(w[c] - v[c]));
        }
    }

    void move_by_slope(const double* from, double* moved_by) const {
        for (std::size_t c = 0; c < picks_.size(); ++c) {
            if (picks_[c].from >= 4) continue;
            const double step = texel_step(source_.kind, from, picks_[c].from);
            moved_by[c] = c < 3 ? step * srgb_slope(from[picks_[c].from] + step) : step;
        }
    }

    void store(const double* v, std::size_t at) const {
        if (integer_) {
            // Unsigned numbers wrap, as GLSL's int() of a uint does.
            auto* to = reinterpret_cast<std::int32_t*>(to_) + at;
            for (int c = 0; c < components_; ++c) to[c] = std::int32_t(std::uint32_t(std::int64_t(v[c])));
        } else {
            auto* to = reinterpret_cast<float*>(to_) + at;
            for (int c = 0; c < components_; ++c) to[c] = v[c] == v[c] ? float(v[c]) : __builtin_nanf("");
        }
    }

    const DumpSpec& spec_;
    const DumpSource& source_;
    Encoding encoding_;
    std::vector<Pick> picks_;
    bool integer_;
    unsigned mask_ = 0;
    int second_ = -1;  // the file's component that a vector's second number comes from
    unsigned char* to_ = nullptr;
    float* rounding_ = nullptr;
    int components_ = 4;
};

}  // namespace

void fail_dump(const DumpSpec& spec, const std::string& cause) {
    throw InputError(shown(spec.file.string()), "", cause);
}

std::unique_ptr<DumpSource> open_dump(const DumpSpec& spec) {
    if (!spec.vk_format.empty()) return open_raw(spec);
    const std::string extension = extension_of(spec.file.string());
    if (extension == "npy") return open_npy(spec);
    if (extension == "dds")
        if (auto source = open_dds(spec)) return source;
    for (const char* known : {"exr", "pfm", "hdr", "tif", "tiff", "dds", "png"})
        if (extension == known) return open_picture(spec);
    fail_dump(spec, "is no .exr, .pfm, .hdr, .tif, .tiff, .dds, .png or .npy by its name; a raw file needs vk_format");
}

DumpedImage read_dump(const DumpSpec& spec) {
    const std::string place = spec.place.empty() ? shown(spec.file.string()) : spec.place;
    if (const auto fault = fault_of(spec)) throw InputError(place, fault->key, fault->cause);
    try {
        const std::unique_ptr<DumpSource> source = open_dump(spec);
        return DumpReader(spec, *source).read();
    } catch (const InputError& e) {
        if (spec.place.empty()) throw;
        throw InputError(fmt::format("{} ({} names it)", e.what(), place));
    }
}

}  // namespace plumb::io
