// The comparator: how two pictures differ, in numbers and as pictures, and whether the difference is within bounds.
//
// Everything fails closed: a picture that is empty, of another size, with other channels or with a NaN or an infinity
// on either side disagrees, whatever the bounds. By convention a is the picture under test and b the reference.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/flip.h"
#include "core/image.h"

namespace plumb::compare {

// Channels interleaved, row-major, first row on top.
struct Picture {
    std::vector<std::string> channels;  // one name each, in the order of the data: {"R", "G", "B"}
    int width = 0, height = 0;
    std::vector<float> data;  // width * height * channels.size() values
};

// What the values are. It decides FLIP and, unless Options::peak is set, the peak of PSNR and the range of SSIM.
enum class Encoding {
    hdr,         // linear radiance of any range; peak = the largest value of b; HDR-FLIP
    ldr_linear,  // linear, shown as 0..1; peak = 1; LDR-FLIP
    ldr_srgb,    // encoded by the sRGB curve, 0..1; peak = 1; LDR-FLIP
};

struct Options {
    Encoding encoding = Encoding::hdr;
    std::optional<double> max_error;        // bound on mean_error, >= 0
    std::optional<std::uint32_t> max_ulp;   // bound on max_ulp
    std::optional<double> max_differing;    // bound on differing, 0..1
    std::optional<double> peak;             // > 0
    double pixels_per_degree = default_pixels_per_degree;  // 1..1000
    bool perceptual = true;                 // false: neither SSIM nor FLIP, which take most of the time
    int threads = 0;                        // 0: all processors
};

// The distance of a NaN or an infinity from anything.
inline constexpr std::uint32_t saturated_ulp = 0xffffffffu;

// One value of one channel, and what the two pictures hold there.
struct Worst {
    int x = 0, y = 0;
    std::string channel;
    float a = 0, b = 0;
};

// A metric is none where it is undefined; it is never NaN. All of them are none for pictures that cannot be compared,
// and only pixels, nonfinite, differing and max_ulp have a meaning for pictures with a NaN or an infinity.
struct Report {
    std::optional<double> mean_error;  // ISR (19): mean of |a - b| over all pixels and channels
    std::optional<double> rmse;        // root of the mean of (a - b)^2
    std::optional<double> rel_mse;     // mean of (a - b)^2 / (b^2 + 0.01)
    std::optional<double> psnr;        // 10 log10(peak^2 / mse); infinity for equal values, none without a peak > 0
    std::optional<double> ssim;        // of the luminance; none below 11 x 11 pixels, without RGB or without a peak
    std::optional<double> flip;        // mean of the error map; none without RGB
    std::optional<double> pearson;     // ISR (20) over all pixels and channels; none where a or b is constant
    std::uint32_t max_ulp = saturated_ulp;  // -0 and +0 are at distance 0
    double differing = 1;                   // share of pixels with a channel whose bits differ or that is not finite
    std::int64_t pixels = 0;                // of a
    std::int64_t nonfinite = 0;             // pixels with a NaN or an infinity in a or b
    bool equal = false;                     // the same bits everywhere (-0 and +0 differ), and all finite
    double max_absolute = 0;                // largest |a - b|, and where it is first met: the worst
    std::optional<Worst> worst;             // none for equal values

    bool sizes_match = false, channels_match = false;
    bool agree = false;
    std::string reason;  // why it disagrees, one line; empty if it agrees
};

// Agrees if the pictures can be compared, every value is finite and every bound that is set holds (at most): without a
// bound, pictures that differ agree. Options out of range are an InputError that names the option. The same bits for
// every number of threads.
Report compare(const Picture& a, const Picture& b, const Options& options = {});

// Why the two cannot be compared, in one line; empty if they can.
std::string mismatch(const Picture& a, const Picture& b);

// Linear RGB, from the channels named R, G, B (also "layer.R", ..., of one layer only) or from a lone channel as grey;
// none otherwise. Values decode by the sRGB curve if the encoding says so.
std::optional<Image<glm::dvec3>> linear_rgb(const Picture& picture, Encoding encoding);

}  // namespace plumb::compare
