#include "gi/ddgi/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/formats.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "gi/ddgi/blend.h"
#include "gi/lend.h"
#include "gi/probes/directions.h"

namespace plumb::ddgi {

std::vector<Field> fields(VolumeParams& p) {
    return {
        {"side", &p.side, "", "texels a side of a probe's irradiance, without the gutter", 1, most_side, {}, false},
        {"depth_side", &p.depth_side, "", "texels a side of a probe's moments of distance, without the gutter", 1, most_side, {},
         false},
        {"rays", &p.rays, "", "rays of a probe in a round", 1, 32767, {}, false},
        {"sharpness", &p.sharpness, "", "power of the cosine that weighs a ray's distance", 1, 256, {}, false},
        {"turned", &p.turned, "", "every round turns all rays by another rotation", 0, 1, {}, false},
        {"seed", &p.seed, "", "of the rotations", 0, 1 << 30, {}, false},
        {"hysteresis", &p.hysteresis, "", "share of the last round that a texel keeps", 0, 0.999, {}, false},
        {"normal_bias", &p.normal_bias, "", "share of the normal in the direction of the bias", 0, 10, {}, false},
        {"view_bias", &p.view_bias, "", "share of the direction towards the viewer in the direction of the bias", 0, 10, {}, false},
        {"bias", &p.bias, "", "the bias that keeps a surface from shadowing itself, in spacings of the grid, the least of the three",
         0, 10, {}, false},
        {"farthest", &p.farthest, "", "where distances are cut, in diagonals of a cell", 0.01, 1e6, {}, false},
        {"back_share", &p.back_share, "", "share of its distance that a ray is given which met the back of a surface", 0, 1, {},
         false},
        {"visibility", &p.visibility, "", "weigh probes by what their moments of distance say of what lies between", 0, 1, {}, false},
        {"wrapped", &p.wrapped, "", "weigh probes by the side of the surface that they lie on", 0, 1, {}, false},
        {"root", &p.root, "", "means of the probes' square roots, as the published code has it", 0, 1, {}, false},
        {"crush", &p.crush, "", "weights below it are crushed to w^3 / crush^2", 1e-12, 1e9, {}, false},
        {"energy", &p.energy, "", "share of the radiance that a ray brings back which counts", 0, 1, {}, false},
        {"packed", &p.packed, "", "texels are stored as DDGI 2019 has them: R11G11B10F and RG16F", 0, 1, {}, false},
        {"rounds", &p.rounds, "", "rounds at most", 1, 1 << 20, {}, false},
        {"change", &p.change, "", "of a texel, over the mean, at which rounds end", 0, 1, {}, false},
    };
}

Grid grid_over(const glm::vec3& low, const glm::vec3& high, const glm::ivec3& count, double inset) {
    if (!(inset >= 0 && inset <= 1)) throw InputError(fmt::format("ddgi: inset = {}: expected 0 to 1", inset));
    Grid g;
    g.count = count;
    for (int c = 0; c < 3; ++c) {
        if (count[c] < 1 || count[c] > 1024) throw InputError(fmt::format("ddgi: {} probes along an axis: expected 1 to 1024", count[c]));
        const double size = double(high[c]) - double(low[c]);
        if (!(size >= 0 && size < 1e15)) throw InputError("ddgi: the scene's bounds are no numbers");
        if (size == 0 && count[c] > 1) throw InputError("ddgi: the scene has no extent along an axis of more than one probe");
        const double cells = count[c] == 1 ? 1 : count[c] - 1 + 2 * inset;
        // Of a plane any spacing will do.
        g.spacing[c] = size > 0 ? float(size / cells) : 1.0f;
        g.origin[c] = float(double(low[c]) + (count[c] == 1 ? 0.5 : inset) * size / cells);
    }
    return g;
}

glm::dmat3 rotation_of(std::uint32_t seed, int round) {
    if (round == 0) return glm::dmat3(1);
    const auto draw = [&](int k) { return double(std::uint32_t(pixel_hash<std::int32_t>(round, k, 0, std::int32_t(seed)).x)) * 0x1p-32; };
    const double a = draw(0), b = 2 * host::pi * draw(1), c = 2 * host::pi * draw(2);
    const double s = std::sqrt(1 - a), t = std::sqrt(a);
    const double x = s * host::sin(b), y = s * host::cos(b), z = t * host::sin(c), w = t * host::cos(c);
    return {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
            {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
            {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
}

Volume::Volume(const probes::LitScene& scene, const Grid& grid, const VolumeParams& params)
    : scene_(scene), grid_(grid), params_(params) {
    VolumeParams copy = params;
    validate_fields("ddgi", fields(copy));
    for (const int side : {params.side, params.depth_side}) {
        const glm::ivec2 size = grid.atlas_size(side);
        if (size.x > 32767 || size.y > 32767 || grid.probes() > 32767)
            throw InputError(fmt::format("ddgi: {} x {} x {} probes need an atlas of {} x {} texels: expected at most 32767 a side, and "
                                         "as many probes",
                                         grid.count.x, grid.count.y, grid.count.z, size.x, size.y));
    }
    for (int z = 0; z < grid.count.z; ++z)
        for (int y = 0; y < grid.count.y; ++y)
            for (int x = 0; x < grid.count.x; ++x) probes_.emplace_back(grid.origin + glm::vec3(x, y, z) * grid.spacing, 0);
    const glm::ivec2 irradiance = grid.atlas_size(params.side), moments = grid.atlas_size(params.depth_side);
    irradiance_ = Image4(irradiance.x, irradiance.y), moments_ = Image4(moments.x, moments.y);
}

void Volume::trace(const RunOptions& options) {
    const glm::dmat3 rotation = rotation_of(std::uint32_t(params_.seed), params_.turned ? rounds_ : 0);
    directions_ = probes::relight_directions(params_.rays);
    for (glm::vec4& d : directions_) {
        const glm::dvec3 turned = rotation * glm::dvec3(d);
        d = glm::vec4(glm::vec3(turned / std::sqrt(glm::dot(turned, turned))), 0);
    }
    hits_ = probes::lit_hits(scene_, probes_, directions_, options);
    rays_ += hits_.rays;
}

BlendInputs Volume::blend_inputs(const Image4& atlas, bool moments) const {
    BlendInputs in;
    in.side = moments ? params_.depth_side : params_.side, in.columns = grid_.tiles().x;
    in.moments = moments, in.sharpness = moments ? params_.sharpness : 1;
    in.hysteresis = rounds_ == 0 ? 0.0f : params_.hysteresis;
    in.scale = moments ? 1.0f : float(host::pi);
    const glm::dvec3 cell(grid_.spacing);
    in.farthest = float(double(params_.farthest) * std::sqrt(glm::dot(cell, cell)));
    in.directions = &directions_, in.hits = &lit_, in.previous = &atlas;
    return in;
}

void Volume::blend(Image4& atlas, bool moments, const RunOptions& options) const {
    const BlendInputs in = blend_inputs(atlas, moments);
    Image4 blended, bordered;
    run(stage<BlendKernel>(), data_of(in), options, blended);
    if (params_.packed)
        for (glm::vec4& t : blended.texels) quantise(moments ? Format::rgba16f : Format::r11g11b10f, t);
    run(stage<BorderKernel>(), data_of(BorderInputs{in.side, &blended}), options, bordered);
    atlas = std::move(bordered);
}

void Volume::round(const RunOptions& options) {
    const bool new_rays = rounds_ == 0 || params_.turned;
    if (new_rays) trace(options);
    lit_ = hits_.emitted;
    const Image4 indirect = rounds_ == 0 ? Image4(lit_.width, lit_.height) : sample(hits_.position, hits_.normal, hits_.towards, options);
    for (std::size_t i = 0; i < lit_.size(); ++i) {
        const glm::vec4 &where = hits_.position.texels[i], &e = hits_.direct.texels[i], &more = indirect.texels[i],
                        &albedo = hits_.albedo.texels[i];
        for (int c = 0; c < 3; ++c)
            lit_.texels[i][c] = params_.energy * (lit_.texels[i][c] + albedo[c] * float(1 / host::pi) * (e[c] + more[c]));
        const float distance = hits_.towards.texels[i].w;
        // A miss is as far away as anything.
        lit_.texels[i].w = where.w == 0 ? 1e15f : where.w < 0 ? distance * params_.back_share : distance;
    }
    if (new_rays) blend(moments_, true, options);
    const Image4 before = irradiance_;
    blend(irradiance_, false, options);
    double largest = 0, sum = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            largest = std::max(largest, std::fabs(double(irradiance_.texels[i][c]) - double(before.texels[i][c])));
            sum += std::fabs(double(irradiance_.texels[i][c]));
        }
    change_ = sum > 0 ? largest * 3 * double(before.size()) / sum : 0;
    ++rounds_;
}

int Volume::converge(const RunOptions& options) {
    while (rounds_ < params_.rounds) {
        round(options);
        if (!params_.turned && params_.hysteresis == 0 && rounds_ > 1 && change_ <= double(params_.change)) break;
    }
    return rounds_;
}

SampleInputs Volume::sample_inputs(const Image4& position, const Image4& normal, const Image4& view) const {
    SampleInputs in;
    in.grid = grid_, in.side = params_.side, in.depth_side = params_.depth_side;
    const float least = std::min({grid_.spacing.x, grid_.spacing.y, grid_.spacing.z});
    in.weighing = {params_.visibility, params_.wrapped, params_.root, params_.normal_bias * params_.bias * least,
                   params_.view_bias * params_.bias * least, params_.crush, 1e-6f, 1.0f};
    in.position = &position, in.normal = &normal, in.view = &view;
    in.irradiance = &irradiance_, in.moments = &moments_;
    return in;
}

Image4 Volume::sample(const Image4& position, const Image4& normal, const Image4& view, const RunOptions& options) const {
    Image4 out;
    run(stage<SampleKernel>(), data_of(sample_inputs(position, normal, view)), options, out);
    return out;
}

std::vector<StageData> Volume::dispatches() const {
    if (rounds_ == 0) throw InputError("ddgi: a volume has nothing to show before its first round");
    return {owned(stage<BlendKernel>(), data_of(blend_inputs(moments_, true))),
            owned(stage<BlendKernel>(), data_of(blend_inputs(irradiance_, false))),
            owned(stage<BorderKernel>(), data_of(BorderInputs{params_.side, &irradiance_})),
            owned(stage<SampleKernel>(), data_of(sample_inputs(hits_.position, hits_.normal, hits_.towards)))};
}

std::size_t Volume::bytes() const { return 4 * (irradiance_.size() + moments_.size()); }

}  // namespace plumb::ddgi
