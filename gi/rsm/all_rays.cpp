#include "gi/rsm/all_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/rsm/all_rays_data.h"
#include "gi/rsm/all_rays_rows.h"

namespace plumb::rsm {

std::uint64_t texels_asked(const GatherParams& params, std::uint64_t points, std::uint64_t texels) {
    const double limit = params.max_rays > 0 ? double(params.max_rays) : std::numeric_limits<double>::infinity();
    if (double(points) * double(texels) <= limit) return texels;
    std::uint64_t asked = replicates;
    while (double(points) * 2 * double(asked) <= limit) asked *= 2;
    return std::min(asked, texels);
}

RayOffsets ray_offsets(const raster::Layout& layout, const glm::vec3& low, const glm::vec3& high, const View& view,
                       glm::ivec2 size) {
    constexpr double single = 0x1p-24, half = 0x1p-11;  // relative errors of rounding
    auto largest = [](const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); };
    const double extent = std::max(largest(glm::dvec3(low)), largest(glm::dvec3(high))), root3 = std::sqrt(3.0);
    // Interpolation rounds by at most 6 parts in 2^24 of the extent along each axis, the ray by 3 more.
    auto offset = [&](Format format) {
        return float(extent * (16 * single + (format == Format::rgba16f ? root3 * half : 0)));
    };
    RayOffsets offsets{offset(layout.position), offset(layout.rsm_position)};
    if (layout.position_from_depth) {
        // A depth belongs to a point up to 2^-9 of a pixel beside the centre: vertices lie on a grid of 2^-8.
        const double x = 2 / (view.view_to_clip[0][0] * size.x), y = 2 / (view.view_to_clip[1][1] * size.y);
        const double snapping = 0x1p-9 * std::sqrt(x * x + y * y), distance = root3 * (extent + largest(view.eye));
        const double rounding = 16 * single + (layout.depth == Format::r16f ? half : 0);
        offsets.receiver = float(distance * (rounding + snapping));
    }
    return offsets;
}

std::string summary(const RaysReport& r) {
    if (r.asked == r.lit) return fmt::format("all {} lit texels a pixel, {} rays", r.lit, r.traced);
    return fmt::format("subset of {} of {} lit texels a pixel, {} rays", r.asked, r.lit, r.traced);
}

namespace {

using Texel = std::array<float, record_stride>;

Texel texel_of(const raster::Rsm& map, std::size_t i) {
    Texel t{};
    for (std::size_t c = 0; c < 12; ++c) {
        const std::size_t at = i * record_stride + c;
        t[c] = map.half ? half_to_float(map.half_records[at]) : map.records[at];
    }
    return t;
}

// A texel without flux or without a surface sends nothing.
bool lit(const Texel& t) {
    const bool dark = t[8] == 0 && t[9] == 0 && t[10] == 0, nothing = t[4] == 0 && t[5] == 0 && t[6] == 0;
    return !dark && !nothing;
}

// The even bits of a Morton code, packed.
std::uint32_t even_bits(std::uint32_t code) {
    code &= 0x55555555;
    code = (code | code >> 1) & 0x33333333;
    code = (code | code >> 2) & 0x0f0f0f0f;
    code = (code | code >> 4) & 0x00ff00ff;
    return (code | code >> 8) & 0x0000ffff;
}

void push(LitTexels& out, const Texel& t) {
    if (lit(t)) out.records.insert(out.records.end(), t.begin(), t.end());
}

// Row by row, in the order in which gather_all() adds.
void collect_rows(std::span<const raster::Rsm> maps, LitTexels& out) {
    for (const raster::Rsm& map : maps) {
        for (int y = 0; y < map.size; ++y) {
            for (int x = 0; x < map.size; ++x) push(out, texel_of(map, std::size_t(y) * std::size_t(map.size) + x));
            out.row_ends.push_back(out.count());
        }
        out.map_ends.push_back(std::int32_t(out.row_ends.size()));
    }
}

// Along Morton's curve, so that what is near along it is near on the map.
void collect_curve(std::span<const raster::Rsm> maps, LitTexels& out) {
    for (const raster::Rsm& map : maps) {
        if (map.size == 0) continue;
        const std::uint64_t side = std::bit_ceil(unsigned(map.size));
        for (std::uint64_t code = 0; code < side * side; ++code) {
            const int x = int(even_bits(std::uint32_t(code))), y = int(even_bits(std::uint32_t(code >> 1)));
            if (x < map.size && y < map.size) push(out, texel_of(map, std::size_t(y) * std::size_t(map.size) + x));
        }
    }
}

// Gives every texel a share of [0, 2^31): 1, and of the rest in proportion to its flux, summed over the channels.
void share_by_flux(std::uint64_t strata, LitTexels& out) {
    const std::int32_t n = out.count();
    auto weight = [&](std::int32_t i) {
        const float* flux = out.records.data() + record_stride * std::ptrdiff_t(i) + 8;
        const double sum = double(flux[0]) + flux[1] + flux[2];
        return std::isfinite(sum) ? std::max(sum, 0.0) : 0.0;
    };
    double total = 0, before = 0;
    for (std::int32_t i = 0; i < n; ++i) total += weight(i);
    const double rest = 0x1p31 - n;
    for (std::int32_t i = 0; i <= n; ++i) {
        const double share = total > 0 ? before / total : double(i) / n;
        // The last is 2^31 itself, and wraps: only differences to it are taken.
        out.starts.push_back(std::int32_t(std::uint32_t(i) + std::uint32_t(i < n ? std::floor(rest * share) : rest)));
        if (i < n) before += weight(i);
    }
    const std::uint32_t width = std::uint32_t((std::uint64_t(1) << 31) / strata);
    for (std::uint32_t k = 0, texel = 0; k < strata; ++k) {
        while (texel + 1 < std::uint32_t(n) && std::uint32_t(out.starts[texel + 1]) <= k * width) ++texel;
        out.firsts.push_back(std::int32_t(texel));
    }
    out.firsts.push_back(n - 1);
}

// validate() of each map that is not left out.
void validate_maps(const GatherParams& params, GatherInputs in, std::span<const raster::Rsm> maps) {
    for (const raster::Rsm& map : maps) {
        if (maps.size() > 1 && map.size == 0) continue;
        in.rsm = &map;
        validate(params, in);
    }
}

}  // namespace

AllRaysData prepare_all_rays(const GatherParams& params, const GatherInputs& in, std::span<const raster::Rsm> maps) {
    validate_maps(params, in, maps);
    AllRaysData p;
    for (const glm::vec4& n : in.normal->texels) p.report.points += !(n.x == 0 && n.y == 0 && n.z == 0);
    for (const raster::Rsm& map : maps) {
        const std::size_t texels = std::size_t(map.size) * std::size_t(map.size);
        for (std::size_t i = 0; i < texels; ++i) p.report.lit += lit(texel_of(map, i));
        p.report.texels += texels;
    }
    if (p.report.lit >> 31) throw InputError(fmt::format("rsm.all_rays: {} lit texels: at most 2^31 - 1", p.report.lit));
    p.report.asked = texels_asked(params, p.report.points, p.report.lit);
    p.texels.records.reserve(p.report.lit * record_stride);
    const std::uint64_t strata = p.report.asked / replicates;
    const bool complete = p.report.asked == p.report.lit;
    complete ? collect_rows(maps, p.texels) : collect_curve(maps, p.texels);
    if (!complete) share_by_flux(strata, p.texels);

    AllRaysView& v = p.view;
    v.position = &in.position->data()->x;
    v.normal = &in.normal->data()->x;
    v.records = p.texels.records.data();
    v.map_ends = p.texels.map_ends.data(), v.row_ends = p.texels.row_ends.data();
    v.starts = p.texels.starts.data(), v.firsts = p.texels.firsts.data();
    v.least_distance2 = least_distance2(params);
    v.scale = irradiance_scale(params);
    v.width = in.position->width, v.height = in.position->height;
    v.maps = complete ? std::int32_t(maps.size()) : 0;
    v.strata_log2 = complete ? -1 : std::countr_zero(strata);
    v.seed = in.seed;
    return p;
}

void run_all_rays(const GatherParams& params, const GatherInputs& in, std::span<const raster::Rsm> maps,
                  const RunOptions& options, Image4& irradiance, RaysReport* report) {
    AllRaysData p = prepare_all_rays(params, in, maps);
    const int width = in.position->width, height = in.position->height;
    irradiance = Image4(width, height);
    Image4 standard_error(width, height);
    p.view.irradiance = &irradiance.data()->x;
    p.view.standard_error = &standard_error.data()->x;
    std::atomic<std::uint64_t> traced{0};
    dispatch(options.isa, [&](auto isa) {
        parallel_bands(height, all_rays_band, options, [&](int first, int last) {
            traced += all_rays_rows<isa()>(p.view, *in.rays, in.offsets, first, last);
        });
    });
    if (!report) return;
    *report = p.report;
    report->traced = traced;
    report->standard_error = std::move(standard_error);
}

std::vector<TapValue> explain_all_rays(const GatherParams& params, const GatherInputs& in,
                                       std::span<const raster::Rsm> maps, glm::ivec2 pixel) {
    const AllRaysData p = prepare_all_rays(params, in, maps);
    FpEnvironment environment;
    Recorder recorder;
    ShadowRays<float> rays(*in.rays, in.offsets);
    if (p.view.strata_log2 < 0)
        gather_all_rays<float>(p.view, pixel.x, pixel.y, rays, recorder);
    else
        gather_subset<float>(p.view, pixel.x, pixel.y, rays, recorder);
    return recorder.values;
}

}  // namespace plumb::rsm
