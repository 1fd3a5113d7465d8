#include "io/dump_encoding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/flip.h"
#include "core/nearest_known.h"

namespace plumb::io {
namespace {

constexpr std::string_view letters[] = {"xr", "yg", "zb", "wa", "0", "1", "_"};

// Decoded from n = 2 code - 1 or from codes of -1 to 1; folded and normalised as in core/formats.h, in double.
void decode_octahedral(double* v) {
    double x = v[0], y = v[1];
    const double z = 1 - std::fabs(x) - std::fabs(y);
    if (z < 0) {
        const double folded_x = 1 - std::fabs(y), folded_y = 1 - std::fabs(x);
        x = x >= 0 ? folded_x : -folded_x, y = y >= 0 ? folded_y : -folded_y;
    }
    const double length = std::sqrt(x * x + y * y + z * z);
    v[0] = x / length, v[1] = y / length, v[2] = z / length, v[3] = 0;
}

// z of a unit vector that points towards +z; rounding may have left x and y longer than 1.
void decode_hemisphere(double* v) {
    const double square = 1 - v[0] * v[0] - v[1] * v[1];
    v[2] = square < 0 ? 0 : std::sqrt(square), v[3] = 0;
}

// HEM 5.7 as core/formats.h has it: the exponent is the code of the fourth component less 128.
void decode_rgbe_record(double* v) {
    const double code = std::floor(v[3] * 255 + 0.5);
    const double scale = code >= 0 && code <= 255 ? std::ldexp(1.0, int(code) - 128) : std::nan("");
    for (int c = 0; c < 3; ++c) v[c] *= scale;
    v[3] = 0;
}

// Perspective depth d = f / (f - n) (1 - n / z) solved for z; 1 - d for reversed; (1 + d) / 2 for -1..1. Linear depth is
// one of a range.
double eye_depth(Encoding encoding, double d, double n, double f) {
    if (encoding == Encoding::linear_depth) return n + d * (f - n);
    if (encoding == Encoding::depth_gl) d = 0.5 * d + 0.5;
    if (encoding == Encoding::reversed_depth) return std::isinf(f) ? n / d : n / (n / f + d * (1 - n / f));
    return std::isinf(f) ? n / (1 - d) : n / (1 - d * (1 - n / f));
}

// Codes of 8 and 16 bits, k / 65535 both, from a table: the curve costs a hundred times as much as the rest of a texel.
double decode_srgb(double x) {
    static const std::vector<double> table = [] {
        std::vector<double> linear(65536);
        for (std::size_t code = 0; code < linear.size(); ++code)
            linear[code] = compare::srgb_to_linear(double(code) / 65535);
        return linear;
    }();
    if (!std::isfinite(x)) return x;
    const double code = std::floor(x * 65535 + 0.5);
    if (code >= 0 && code <= 65535 && code / 65535 == x) return table[std::size_t(code)];
    return compare::srgb_to_linear(x);
}

std::string channels_fault(const DumpSpec& spec, Encoding encoding) {
    if (spec.channels.empty()) return "";
    const std::string expected = "expected 1 to 4 of x y z w, r g b a, 0, 1 and _";
    if (spec.channels.size() > 4) return expected;
    bool any = false;
    int largest = 0, of_file = 0;
    for (const char c : spec.channels) {
        const auto has = [&](std::string_view set) { return set.find(c) != set.npos; };
        const auto at = std::find_if(std::begin(letters), std::end(letters), has);
        if (at == std::end(letters)) return expected;
        const int from = int(at - std::begin(letters));
        any |= from != Pick::absent;
        if (from < 4) largest = std::max(largest, from + 1);
        of_file += from < 4;
        if (from >= 4 && encoded_components(encoding) && !is_depth(encoding))
            return fmt::format("{} decodes the file's own channels", spec.encoding);
    }
    if (!any) return "names no component";
    const int wanted = encoded_components(encoding);
    if (is_depth(encoding) && of_file != 1)
        return fmt::format("expected 1 of x y z w, r g b a, beside 0, 1 and _: as many as {} takes", spec.encoding);
    if (wanted && !is_depth(encoding) && int(spec.channels.size()) != wanted)
        return fmt::format("expected {} of x y z w, r g b a: as many as {} takes", wanted, spec.encoding);
    if (spec.vk_format.empty()) return "";
    const TexelFormat& format = *find_texel_format(spec.vk_format);
    return largest > format.channels
               ? fmt::format("{} has {} channel{}", format.name, format.channels, format.channels == 1 ? "" : "s")
               : "";
}

// Of raw files; and what only raw files have.
std::optional<SpecFault> raw_fault(const DumpSpec& spec) {
    if (spec.vk_format.empty()) {
        for (const auto& [key, is_set] : {std::pair{"row_pitch", spec.row_pitch != 0},
                                          {"offset", spec.offset != 0},
                                          {"count", spec.count != 0},
                                          {"trailing", spec.trailing}})
            if (is_set) return SpecFault{key, "stands without vk_format: only raw files have it"};
        return {};
    }
    const TexelFormat* format = find_texel_format(spec.vk_format);
    std::vector<std::string> names;
    for (const TexelFormat& f : texel_formats()) names.push_back(f.name);
    if (!format)
        return SpecFault{"vk_format", "unknown format" + nearest_known(spec.vk_format, names)};
    if (spec.count && (spec.width || spec.height || spec.row_pitch || spec.flip_y))
        return SpecFault{"count", "is of a buffer, which has no width, height, row_pitch or flip_y"};
    if (!spec.layer.empty()) return SpecFault{"layer", "raw files have none"};
    if (!spec.count && (spec.width < 1 || spec.height < 1))
        return SpecFault{spec.width < 1 ? "width" : "height",
                         "expected at least 1; a raw image needs both sides, a buffer count"};
    const std::int64_t row = std::int64_t(spec.width) * format->bytes;
    if (spec.row_pitch && spec.row_pitch < row)
        return SpecFault{"row_pitch", fmt::format("{} texels of {} take {} bytes", spec.width, format->name, row)};
    if (is_integer(format->kind) && spec.encoding != "plain" && spec.encoding != "integer")
        return SpecFault{"encoding", fmt::format("{} holds integers, which have no encoding", format->name)};
    if (format->kind == TexelKind::srgb8 && spec.encoding == "srgb")
        return SpecFault{"encoding", fmt::format("{} is decoded already", format->name)};
    if (!is_integer(format->kind) && spec.encoding == "integer")
        return SpecFault{"encoding", fmt::format("{} does not hold integers", format->name)};
    return {};
}

}  // namespace

const std::vector<std::string>& encoding_names() {
    static const std::vector<std::string> names = {
        "plain",   "integer",       "biased", "srgb",  "octahedral",     "octahedral_unorm",
        "hemi_xy", "hemi_xy_unorm", "rgbe",   "depth", "reversed_depth", "depth_gl", "linear_depth"};
    return names;
}

Encoding parse_encoding(const std::string& name) {
    const auto& names = encoding_names();
    return Encoding(std::find(names.begin(), names.end(), name) - names.begin());
}

int encoded_components(Encoding encoding) {
    if (is_depth(encoding)) return 1;
    if (encoding == Encoding::rgbe) return 4;
    return encoding >= Encoding::octahedral ? 2 : 0;
}

bool is_depth(Encoding encoding) { return encoding >= Encoding::depth; }

unsigned decoded_mask(Encoding encoding) {
    if (is_depth(encoding)) return 0;
    return encoding >= Encoding::octahedral ? 7 : 0;
}

std::vector<Pick> parse_channels(const std::string& channels) {
    std::vector<Pick> picks;
    for (const char c : channels)
        for (int from = 0; from < int(std::size(letters)); ++from)
            if (letters[from].find(c) != std::string_view::npos) picks.push_back({from});
    return picks;
}

void decode_record(Encoding encoding, const std::vector<Pick>& picks, const std::vector<double>& near_far, double* v) {
    switch (encoding) {
        case Encoding::plain:
        case Encoding::integer:
            return;
        case Encoding::biased:
        case Encoding::srgb:
            // Colours and vectors: the fourth component is neither.
            for (std::size_t c = 0; c < std::min<std::size_t>(picks.size(), 3); ++c)
                if (picks[c].from < 4) v[c] = encoding == Encoding::biased ? 2 * v[c] - 1 : decode_srgb(v[c]);
            return;
        case Encoding::octahedral_unorm:
            v[0] = 2 * v[0] - 1, v[1] = 2 * v[1] - 1;
            return decode_octahedral(v);
        case Encoding::octahedral:
            return decode_octahedral(v);
        case Encoding::hemi_xy_unorm:
            v[0] = 2 * v[0] - 1, v[1] = 2 * v[1] - 1;
            return decode_hemisphere(v);
        case Encoding::hemi_xy:
            return decode_hemisphere(v);
        case Encoding::rgbe:
            return decode_rgbe_record(v);
        case Encoding::depth:
        case Encoding::reversed_depth:
        case Encoding::depth_gl:
        case Encoding::linear_depth:
            for (std::size_t c = 0; c < picks.size(); ++c)
                if (picks[c].from < 4) v[c] = eye_depth(encoding, v[c], near_far[0], near_far[1]);
            return;
    }
}

double srgb_slope(double x) {
    // 2.4 / 1.055 s^1.4; the power lies below s^1.25 up to 1, below s^1.5 from there on. The straight part has 1
    // / 12.92.
    const double s = (std::max(x, 0.0) + 0.055) / 1.055, root = std::sqrt(s);
    return std::max(2.4 / 1.055 * s * (s > 1 ? root : std::sqrt(root)), 1 / 12.92);
}

namespace {

StoredAs plain_stored_as(TexelKind kind, bool is_depth) {
    switch (kind) {
        case TexelKind::float32:
            return {is_depth ? Format::d32f : Format::rgba32f};
        case TexelKind::float16:
            return {Format::rgba16f};
        case TexelKind::unorm8:
            return {Format::rgba8};
        case TexelKind::unorm_10_2:
            return {Format::r10g10b10a2};
        case TexelKind::ufloat_11_11_10:
            return {Format::r11g11b10f};
        case TexelKind::shared_exponent:
            return {Format::rgbe};
        case TexelKind::depth24:
            return {Format::d24s8};
        case TexelKind::unorm16:
            return {Format::r10g10b10a2, true, 0, 1};
        case TexelKind::snorm8:
        case TexelKind::snorm16:
            return {Format::normal8, true, -1, 1};
        case TexelKind::srgb8:
            return {Format::normal8, true, 0, 1};
        default:
            return {};
    }
}

// Formats whose components are not all alike.
bool is_uneven(TexelKind kind) {
    return kind == TexelKind::unorm_10_2 || kind == TexelKind::ufloat_11_11_10 || kind == TexelKind::shared_exponent;
}

bool is_unorm(TexelKind kind) {
    return kind == TexelKind::unorm8 || kind == TexelKind::unorm16 || kind == TexelKind::unorm_10_2;
}

}  // namespace

StoredAs stored_as(TexelKind kind, bool is_depth_format, Encoding encoding, const std::vector<Pick>& picks) {
    const bool is_exact = kind == TexelKind::float32;
    const bool is_8 = kind == TexelKind::unorm8 || kind == TexelKind::snorm8;
    const bool is_16 = kind == TexelKind::unorm16 || kind == TexelKind::snorm16;
    switch (encoding) {
        case Encoding::plain:
        case Encoding::integer: {
            StoredAs stored = plain_stored_as(kind, is_depth_format);
            for (std::size_t c = 0; c < picks.size() && is_uneven(kind); ++c)
                stored.by_value |= picks[c].from != int(c);
            return stored;
        }
        case Encoding::biased:
            if (kind == TexelKind::unorm8) return {Format::normal8};
            if (is_unorm(kind)) return {Format::normal8, true, -1, 1};
            return {is_exact ? Format::octahedral16 : Format::normal8, true};
        case Encoding::srgb:
            if (is_unorm(kind)) return {Format::normal8, true, 0, 1};
            return {is_exact ? Format::octahedral16 : Format::normal8, true};
        case Encoding::octahedral:
        case Encoding::octahedral_unorm:
            return {is_exact || is_16 ? Format::octahedral16 : Format::octahedral8, !is_8 && !is_16};
        case Encoding::hemi_xy:
        case Encoding::hemi_xy_unorm:
            return {Format::normal8, true};
        case Encoding::rgbe:
            return {Format::rgbe, kind != TexelKind::unorm8};
        case Encoding::depth:
        case Encoding::reversed_depth:
        case Encoding::depth_gl:
        case Encoding::linear_depth:
            return {Format::r11g11b10f, true};
    }
    return {};
}

std::optional<SpecFault> fault_of(const DumpSpec& spec) {
    const auto& names = encoding_names();
    if (spec.file.empty()) return SpecFault{"file", "expected the name of a file"};
    if (std::find(names.begin(), names.end(), spec.encoding) == names.end())
        return SpecFault{"encoding", "unknown encoding" + nearest_known(spec.encoding, names)};
    if (auto fault = raw_fault(spec)) return fault;
    const Encoding encoding = parse_encoding(spec.encoding);
    if (const std::string cause = channels_fault(spec, encoding); !cause.empty()) return SpecFault{"channels", cause};
    if (is_depth(encoding) != !spec.near_far.empty())
        return SpecFault{"near_far", is_depth(encoding)
                                         ? "is missing; " + spec.encoding + " needs [near, far], in metres"
                                         : "stands without an encoding of depth"};
    const auto& planes = spec.near_far;
    if (encoding == Encoding::linear_depth) {
        if (!(planes.size() == 2 && planes[0] >= 0 && planes[1] > planes[0] && std::isfinite(planes[1])))
            return SpecFault{"near_far", "expected [near, far] with 0 <= near < far, finite"};
    } else if (!planes.empty() &&
               !(planes.size() == 2 && planes[0] > 0 && planes[1] > planes[0] && std::isfinite(planes[0]))) {
        return SpecFault{"near_far", "expected [near, far] with 0 < near < far; far may be inf"};
    }
    if (spec.from_depth && spec.encoding != "plain")
        return SpecFault{"from_depth", fmt::format("takes the depth buffer as it is; expected the encoding plain, not {}",
                                                   spec.encoding)};
    const bool formed = spec.from_depth || spec.matrix || !spec.scale.empty() || !spec.factors.empty() || spec.normalized ||
                        !spec.w.empty();
    if (formed && (spec.count || spec.encoding == "integer"))
        return SpecFault{spec.count ? "count" : "encoding",
                         "from_depth, matrix, scale, factor, normalized and w are of images of floats"};
    return {};
}

}  // namespace plumb::io
