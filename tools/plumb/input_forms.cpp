#include "tools/plumb/input_forms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/bounded.h"
#include "core/error.h"
#include "core/host_math.h"
#include "core/inexact_inputs.h"
#include "core/parallel.h"
#include "io/file.h"
#include "tools/plumb/case_sampling.h"
#include "tools/plumb/input_decoding.h"

namespace plumb::cli {

namespace {

constexpr double unit = 0x1p-23;  // of the last place of 1

bool is_normal(const Slot& slot) { return slot.name.ends_with("normal"); }

Bounded about(double value, double bound) { return Bounded::within(float(value), value, bound); }

// m (x, y, z, w), each row.
template <class Matrix>
Bounded row_of(const Matrix& m, int row, const Bounded& x, const Bounded& y, const Bounded& z, const Bounded& w) {
    const auto* r = &m[std::size_t(4 * row)];
    return Bounded(r[0]) * x + Bounded(r[1]) * y + Bounded(r[2]) * z + Bounded(r[3]) * w;
}

bool is_affine(const io::MatrixRows& m) { return m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] != 0; }

// The rows that normals take: the inverse transpose, of the size that leaves lengths as they are where the matrix turns and
// scales alike in all directions.
io::MatrixRows for_normals(const io::MatrixRows& m, const std::string& place) {
    glm::dmat3 linear(0);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) linear[column][row] = m[std::size_t(4 * row + column)] / m[15];
    const double volume = glm::determinant(linear);
    if (!is_affine(m) || !(std::fabs(volume) > 0) || !std::isfinite(volume))
        throw InputError(place + ": matrix: normals ask for one whose last row is 0 0 0 1 and that has an inverse");
    const glm::dmat3 inverse = glm::inverse(linear);
    const double size = host::exp(host::log(std::fabs(volume)) / 3);
    io::MatrixRows rows{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rows[std::size_t(4 * row + column)] = inverse[row][column] * size;
    rows[15] = 1;
    return rows;
}

bool is_formed(const io::DumpSpec& spec) {
    return spec.from_depth || spec.matrix || !spec.scale.empty() || !spec.factors.empty() || spec.normalized ||
           !spec.w.empty();
}

// One input, texel by texel.
class Former {
  public:
    Former(const io::DumpSpec& spec, const Slot& slot, const io::DumpedImage& dump, const std::string& place, glm::ivec2 size)
        : spec_(spec), decoding_(spec, dump), place_(place), size_(size) {
        normalises_ = spec.normalized && !is_unit_once_filtered(spec);
        if (spec.matrix) find_matrix(slot);
        for (const io::DumpSpec& factor : spec.factors) {
            const io::DumpedImage image = read_image("factor", factor);
            alone_.push_back((image.channels & 7u) == 1);
            factors_.push_back(image.array);
        }
        for (const io::DumpSpec& w : spec.w) {
            fourth_ = read_image("w", w);
            fourth_decoding_.emplace(w, *fourth_);
        }
        if (spec.from_depth) find_inverse(*spec.from_depth);
    }

    bool any() const { return is_formed(spec_) || decoding_.any(); }

    void form(glm::ivec2 pixel, const float* from, SrgbBounds& known, Bounded* v) const {
        for (int c = 0; c < 4; ++c) v[c] = Bounded(from[c]);
        if (!spec_.from_depth) decoding_.decode(v, known);
        if (spec_.from_depth && !unproject(pixel, from[0], v)) return;
        if (spec_.matrix) turn(v);
        multiply(pixel, v);
        if (normalises_) normalise(v);
        if (fourth_) read_fourth(pixel, known, v);
    }

  private:
    void find_matrix(const Slot& slot) {
        const std::string of = !spec_.matrix->of.empty() ? spec_.matrix->of : is_normal(slot) ? "normals" : "points";
        matrix_ = spec_.matrix->rows;
        moves_ = of == "points";
        if (of == "normals") matrix_ = for_normals(matrix_, place_);
        divides_ = moves_ && !is_affine(matrix_);
        if (!moves_ && !is_affine(matrix_))
            throw InputError(place_ + ": matrix: directions ask for one whose last row is 0 0 0 1");
        const double last = matrix_[15];
        if (!divides_)
            for (double& number : matrix_) number /= last;
    }

    io::DumpedImage read_image(const std::string& key, const io::DumpSpec& spec) const {
        io::DumpedImage image = io::read_dump(spec);
        const std::vector<std::int64_t> expected = {size_.y, size_.x, 4};
        if (image.array.dtype != DType::f32 || image.array.shape != expected)
            throw InputError(fmt::format("{}: {}: {} is {}: expected an image of {} x {} floats", place_, key,
                                         io::shown(spec.file.string()), shape_text(image.array.shape), size_.x, size_.y));
        if (key == "w" && (image.channels & (image.channels - 1)) != 0)
            throw InputError(fmt::format("{}: w: {} has more than one channel: expected channels = \"x\", or another of them",
                                         place_, io::shown(spec.file.string())));
        return image;
    }

    void read_fourth(glm::ivec2 pixel, SrgbBounds& known, Bounded* v) const {
        const float* texel = texel_of(fourth_->array, pixel);
        Bounded w[4];
        for (int c = 0; c < 4; ++c) w[c] = Bounded(texel[c]);
        fourth_decoding_->decode(w, known);
        v[3] = w[fourth_->channels == 8 ? 3 : fourth_->channels == 4 ? 2 : fourth_->channels == 2 ? 1 : 0];
    }
    const float* texel_of(const Array& image, glm::ivec2 pixel) const {
        return reinterpret_cast<const float*>(image.bytes.data()) + 4 * (std::ptrdiff_t(pixel.y) * size_.x + pixel.x);
    }

    // A device that inverts the matrix itself has each number of the inverse rounded.
    void find_inverse(const io::FromDepth& from) {
        const io::MatrixRows inverse = from.forward ? io::inverse_of(from.matrix) : from.matrix;
        for (std::size_t i = 0; i < inverse.size(); ++i)
            inverse_[i] = from.forward ? about(inverse[i], unit * std::fabs(inverse[i])) : Bounded(inverse[i]);
        parallel_ = is_affine(inverse);
    }

    // A depth that nothing has left its mark in is nowhere: zeros, as stages hold it.
    bool unproject(glm::ivec2 pixel, float depth, Bounded* v) const {
        const io::FromDepth& from = *spec_.from_depth;
        if (depth == (from.reversed_z ? 0.0f : 1.0f)) {
            std::fill_n(v, 4, Bounded(0.0f));
            return false;
        }
        // Texture coordinates are interpolated: two units of 1, as of what is computed from a pixel's index.
        auto clip = [](int at, int side) {
            const double place = (at + 0.5) / side;
            return Bounded(2.0f) * about(place, 2 * unit) - Bounded(1.0f);
        };
        const Bounded x = clip(pixel.x, size_.x), down = clip(pixel.y, size_.y), y = from.y_up ? -down : down;
        const Bounded d = spec_.vk_format.find("UNORM") == std::string::npos ? Bounded(depth) : about(depth, unit * depth);
        const Bounded z = from.below_zero ? Bounded(2.0f) * d - Bounded(1.0f) : d;
        const std::array<Bounded, 16>& m = inverse_;
        const Bounded one(1.0f), w = row_of(m, 3, x, y, z, one);
        for (int c = 0; c < 3; ++c) v[c] = row_of(m, c, x, y, z, one) / w;
        if (!parallel_) {
            v[3] = one / w;  // of a perspective clip space w is the linear depth
            return true;
        }
        // Of parallel rays it is the way from the near plane.
        const Bounded nearest(from.reversed_z ? 1.0f : from.below_zero ? -1.0f : 0.0f);
        Bounded square(0.0f);
        for (std::size_t c = 0; c < 3; ++c) square += (m[4 * c + 2] / m[15]) * (m[4 * c + 2] / m[15]);
        v[3] = abs(z - nearest) * sqrt(square);
        return true;
    }

    void turn(Bounded* v) const {
        const Bounded x = v[0], y = v[1], z = v[2], w(moves_ ? 1.0f : 0.0f);
        for (int c = 0; c < 3; ++c) v[c] = row_of(matrix_, c, x, y, z, w);
        if (!divides_) return;
        const Bounded divisor = row_of(matrix_, 3, x, y, z, w);
        for (int c = 0; c < 3; ++c) v[c] = v[c] / divisor;
    }

    void multiply(glm::ivec2 pixel, Bounded* v) const {
        for (std::size_t c = 0; c < 3 && !spec_.scale.empty(); ++c)
            v[c] = v[c] * Bounded(spec_.scale[spec_.scale.size() == 1 ? 0 : c]);
        for (std::size_t i = 0; i < factors_.size(); ++i) {
            const float* by = texel_of(factors_[i], pixel);
            for (std::size_t c = 0; c < 3; ++c) v[c] = v[c] * Bounded(by[alone_[i] ? 0 : c]);
        }
    }

    // 0 has no direction, and stays.
    static void normalise(Bounded* v) {
        if (v[0].shadow == 0 && v[1].shadow == 0 && v[2].shadow == 0) return;
        const Bounded length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (int c = 0; c < 3; ++c) v[c] = v[c] / length;
    }

    const io::DumpSpec& spec_;
    InputDecoding decoding_;
    const std::string& place_;
    glm::ivec2 size_;
    io::MatrixRows matrix_{};
    bool moves_ = false, divides_ = false, normalises_ = false;
    std::array<Bounded, 16> inverse_{};
    bool parallel_ = false;  // clip space has no perspective
    std::optional<io::DumpedImage> fourth_;
    std::optional<InputDecoding> fourth_decoding_;
    std::vector<Array> factors_;
    std::vector<bool> alone_;  // a factor of one channel multiplies all three
};

// One step of a stored component to the next, or a few roundings of what is exact. 0: vectors are unit by their encoding.
double step_of(const io::DumpSpec& spec, const io::DumpedImage& dump) {
    if (spec.encoding.starts_with("octahedral") || spec.encoding.starts_with("hemi")) return 0;
    switch (dump.stored) {
        case Format::rgba16f: return 0x1p-10;
        case Format::rgba8: return 1.0 / 255;
        case Format::normal8: return 2.0 / 255;
        case Format::r10g10b10a2: return 1.0 / 1023;
        case Format::r11g11b10f: return 0x1p-5;
        default: return 8 * unit;
    }
}

// Normals that are longer or shorter than their format explains were interpolated, scaled, or are encoded otherwise.
void note_lengths(const io::DumpSpec& spec, const Slot& slot, const std::vector<bool>& covered,
                  const io::DumpedImage& dump, std::vector<std::string>& notes) {
    const double step = step_of(spec, dump);
    if (step == 0) return;
    const auto* texels = reinterpret_cast<const float*>(dump.array.bytes.data());
    const auto* rounding = reinterpret_cast<const float*>(dump.rounding.bytes.data());
    const std::size_t count = dump.array.bytes.size() / (4 * sizeof(float));
    std::size_t off = 0;
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (covered.size() == count && !covered[i]) continue;
        double square = 0, may = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const double v = texels[4 * i + c], moved = dump.rounding.bytes.empty() ? step : double(rounding[4 * i + c]);
            square += v * v, may += moved * moved;
        }
        const double length = std::sqrt(square), slack = std::sqrt(may);
        if (length <= slack || !(std::fabs(length - 1) > slack)) continue;  // nothing is there; or NaN
        ++off;
        least = std::min(least, length), most = std::max(most, length);
    }
    if (off > 0)
        notes.push_back(fmt::format("{}: at {} of {} texels the length differs from 1 by more than the format allows: {:.4g} to "
                                    "{:.4g}{}", slot.name, off, count, least, most,
                                    spec.normalized ? "" : "; normalized = true where the shader makes it unit"));
}

void check(const io::DumpSpec& spec, const Slot& slot, const io::DumpedImage& dump, const std::string& place) {
    const bool image = dump.array.dtype == DType::f32 && dump.array.shape.size() == 3 && dump.array.shape[2] == 4;
    if (!image || slot.kind != SlotKind::image || slot.dtype != DType::f32)
        throw InputError(place + ": from_depth, matrix, scale, factor, normalized and w are of images of floats");
    if (spec.normalized && !is_normal(slot))
        throw InputError(fmt::format("{}: normalized: expected it of normals alone", place));
    const bool vectors = (dump.channels & 7u) == 7u || spec.from_depth;
    if ((spec.matrix || spec.normalized) && !vectors)
        throw InputError(place + ": matrix and normalized ask for x, y and z");
    if (spec.from_depth && (slot.channels != 4 || !(dump.channels & 1u)))
        throw InputError(place + ": from_depth: expected one of an input of positions");
}

}  // namespace

Array form_input(const io::DumpSpec& spec, const Slot& slot, const Precision& precision,
                 const std::vector<bool>& covered, const std::string& place, io::DumpedImage& dump,
                 std::vector<std::string>& notes) {
    if (is_formed(spec)) check(spec, slot, dump, place);
    if (slot.kind != SlotKind::image || dump.array.dtype != DType::f32 || dump.array.shape.size() != 3) return {};
    const bool frame = slot.frame;
    if (is_normal(slot) && (dump.channels & 7u) == 7u)
        note_lengths(spec, slot, frame ? covered : std::vector<bool>{}, dump, notes);
    const glm::ivec2 size(int(dump.array.shape[1]), int(dump.array.shape[0]));
    const Former former(spec, slot, dump, place, size);
    if (!former.any()) return {};
    Bundle made;
    Array moved = std::move(add(made, moved_name(slot.name), DType::f32, dump.array.shape));
    auto* texels = reinterpret_cast<float*>(dump.array.bytes.data());
    auto* bounds = reinterpret_cast<float*>(moved.bytes.data());
    parallel_bands(size.y, 8, 0, [&](int first, int last) {
        const PrecisionScope scope(precision);
        SrgbBounds known;
        Bounded v[4];
        for (int y = first; y < last; ++y)
            for (int x = 0; x < size.x; ++x) {
                const std::ptrdiff_t at = 4 * (std::ptrdiff_t(y) * size.x + x);
                former.form({x, y}, texels + at, known, v);
                for (int c = 0; c < 4; ++c) {
                    texels[at + c] = float(v[c].shadow);
                    const double off = v[c].bound + std::fabs(double(texels[at + c]) - v[c].shadow);
                    // Rounded up; what may be anything stays so.
                    bounds[at + c] = off == 0 ? 0.0f : float(off * (1 + 0x1p-20) + 0x1p-140);
                }
            }
    });
    if (spec.from_depth) dump.channels = 15;
    if (!spec.w.empty()) dump.channels |= 8;
    return moved;
}

}  // namespace plumb::cli
