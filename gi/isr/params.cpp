#include <fmt/format.h>

#include "core/error.h"
#include "core/tile.h"
#include "gi/isr/isr_params.h"

namespace plumb::isr {

std::vector<Field> fields(IsrParams& p) {
    return {
        {"variant", as_int(p.variant), "",
         "corrected, or ISR (25), (26) and (29) as printed: without areas' cosines, scaled by 2 pi / N, and with the unlit "
         "colour for the light that a surface sends", 0, 1, {"corrected", "published"}, true},
        {"mode", as_int(p.mode), "",
         "what is shown (ISR appendix D): F2 indirect light and shadows, F3 without shadows, F4 direct light alone with "
         "shadows, F5 without", 0, 3, {"F2", "F3", "F4", "F5"}, false},
        {"resolution", as_int(p.resolution), "",
         "of the buffers in which light is gathered: a quarter of the frame's pixels (ISR 4.2), or all of them (chapter 6: full native "
         "resolution), with no upsampling", 0, 1, {"quarter", "native"}, false, {SweepRange::Role::curves, {}, "", ""}},
        {"rings", &p.rings, "",
         "k: (2 k + 1)^2 - 1 samples of indirect light a pixel; 2, 3 and 4 are ISR 5.3.1's 24, 48 and 80", 1, 127, {}, false,
         {SweepRange::Role::along, {1, 2, 3, 4, 6, 8}, "", ""}},
        {"pattern", as_int(p.pattern), "",
         "where samples of indirect light lie: in rings of growing radius (ours), or on the square grid of Listing 6; automatic: "
         "on the grid where spacing is set or variant is published, else in rings",
         0, 2, {"automatic", "rings", "grid"}, false},
        {"reach", &p.reach, "heights of the frame",
         "how far away the area ends for which samples of indirect light stand: the radius of the rings, half a side of the grid; "
         "ours", 0.01, 1.5, {}, false, {SweepRange::Role::curves, {0.5, 1}, "spacing", "0"}},
        {"growth", &p.growth, "", "the outer radius of ring r of n is reach (r / n)^growth; ours", 1, 4, {}, false,
         {SweepRange::Role::curves, {}, "spacing", "0"}},
        {"spacing", &p.spacing, "coarse pixels",
         "between samples of indirect light on the grid, in place of reach; 0: by reach, and as published 8; ours", 0, 255, {}, true,
         {SweepRange::Role::curves, {}, "", ""}},
        {"ssao_rings", &p.ssao_rings, "", "k of the samples of ambient occlusion", 1, 127, {}, false},
        {"ssao_spacing", &p.ssao_spacing, "coarse pixels", "between samples of ambient occlusion; ours", 1, 255, {}, true},
        {"rotations", &p.rotations, "",
         "rotations of the samples, of which each pixel has one; a power of two, 1: none; 0: 64 of rings, 1 of the grid; ours",
         0, 1024, {}, true, {SweepRange::Role::curves, {}, "", ""}},
        {"turn", as_int(p.turn), "",
         "which rotation a pixel has: by a hash of the pixel, or one after the other in a tile of so many pixels as there are "
         "rotations, in Bayer's order; automatic: by tiles where there are 4, 16, 64, 256 or 1024; ours",
         0, 2, {"automatic", "hash", "tile"}, false, {SweepRange::Role::curves, {}, "", ""}},
        {"bounces", &p.bounces, "", "of indirect light (ISR chapter 6)", 1, 64, {}, false, {SweepRange::Role::curves, {1, 2}, "", ""}},
        {"far_rings", &p.far_rings, "",
         "rings of samples that remain for pixels far away (ISR chapter 6: fewer than for near ones); 0: all rings everywhere",
         0, 127, {}, true, {SweepRange::Role::curves, {}, "", ""}},
        {"full_depth", &p.full_depth, "m",
         "linear depth to which a pixel has all rings; beyond they fall with 1 / depth, down to far_rings; ours", 0, 1e20, {},
         true},
        {"guard", &p.guard, "pixels", "width of the guard band around the frame (ISR chapter 6: wider FOV); even", 0, 4096, {},
         false, {SweepRange::Role::curves, {}, "", ""}},
        {"layers", &p.layers, "", "depth layers that send light (ISR chapter 6: depth peeling)", 1, 8, {}, false,
         {SweepRange::Role::curves, {}, "", ""}},
        {"cameras", &p.cameras, "", "additional cameras whose surfaces send light (ISR chapter 6)", 0, 4, {}, false,
         {SweepRange::Role::curves, {}, "", ""}},
        {"camera_angle", &p.camera_angle, "degrees", "by which they are turned about the point in the frame's middle, as far away as the median of what the frame shows; ours",
         1, 180, {}, false},
        {"position", as_int(p.position), "",
         "how positions are rebuilt: from linear depth (ISR 4.3), or by inverse matrices and a division by w (4.7)", 0, 1,
         {"linear", "inverse_matrix"}, true},
        {"least_cosine", &p.least_cosine, "",
         "below it a surface's slope does not enlarge the area that a sample stands for; ours", 1e-3, 1, {}, true},
        {"blur", as_int(p.blur), "",
         "of irradiance and accessibility: a Gaussian along rows and columns (ISR 4.2), or one that stops at edges (ours); automatic: "
         "that stops at edges, but as published or by inverse matrices", 0, 3, {"automatic", "none", "gaussian", "edge_aware"}, true},
        {"blur_radius", &p.blur_radius, "coarse pixels", "of that Gaussian; 0: 8 where it stops at edges, else 4; ours", 0, 32, {},
         true},
        {"blur_sigma", &p.blur_sigma, "coarse pixels", "of that Gaussian; 0: half its radius; ours", 0, 1e6, {}, false},
        {"upsample", as_int(p.upsample), "", "bilinear weights times similarity of depth, ISR (27), or bilinear alone", 0, 1,
         {"bilateral", "bilinear"}, true},
        {"epsilon", &p.epsilon, "", "of ISR (27), added to the difference of depths; a share of the depth; ours", 1e-9, 1e9, {},
         true},
        {"solid_angle", as_int(p.solid_angle), "",
         "of variant = published, what 2 pi / N of (25) and (26) is: printed, a factor beside the form factor; none, since form factor "
         "and cap have their solid angle; hemisphere, the solid angle that the sample itself has, in place of the area in (6)",
         0, 2, {"printed", "none", "hemisphere"}, true},
        {"ssao_term", as_int(p.ssao_term), "",
         "of variant = published, what (29) adds to 1 - k_ssao: accessibility, 1 less the occlusion of (26), or occlusion itself, as "
         "printed, more of which brightens", 0, 1, {"accessibility", "occlusion"}, true},
        {"light_unit", &p.light_unit, "W/(m2 sr)",
         "of variant = published: the radiance for which a colour of 1 in (25) and (29) stands; 0: what a white surface sends in "
         "the mean where lamps shine in the frame; ours", 0, 1e30, {}, true},
        {"length_unit", &p.length_unit, "m",
         "of variant = published: the length for which 1 stands in the cosine of (26), whose vector is not unit; 0: the sample's "
         "distance, with which it is; ours", 0, 1e20, {}, true},
        {"k_ssao", &p.k_ssao, "",
         "ambient occlusion's power over direct light, ISR (29); 0: none, as light travels; 0.5 is ISR 4.7's", 0, 1, {}, true},
        {"k_isr", &p.k_isr, "", "indirect light's power, ISR (29); 0.5 is ISR 4.7's", 0, 1, {}, true},
        {"ambient", as_int(p.ambient), "",
         "light from everywhere that accessibility lets through: none, or the environment's radiance; ours", 0, 1,
         {"none", "environment"}, false},
    };
}

void validate(const IsrParams& params) {
    IsrParams copy = params;
    validate_fields("isr", fields(copy));
    if (params.spacing != 0 && !(params.spacing >= 1))
        throw InputError(fmt::format("isr: spacing = {}: expected 0, or 1 to 255", params.spacing));
    if (params.pattern == PatternKind::rings && params.spacing != 0)
        throw InputError(fmt::format("isr: spacing = {} with pattern = rings: expected pattern = grid, whose it is, or reach in "
                                     "its place", params.spacing));
    if (params.pattern == PatternKind::rings && params.variant == Variant::published)
        throw InputError("isr: pattern = rings with variant = published: ISR (25) takes all samples for equal areas, which rings "
                         "are not: expected pattern = grid");
    if ((params.rotations & (params.rotations - 1)) != 0)
        throw InputError(fmt::format("isr: rotations = {}: expected a power of two", params.rotations));
    if (params.turn == Turn::tile && tile_of(resolved(params).rotations) < 2)
        throw InputError(fmt::format("isr: turn = tile with rotations = {}: expected 4, 16, 64, 256 or 1024: a square tile deals "
                                     "them out", params.rotations));
    if (params.blur_sigma != 0 && !(params.blur_sigma >= 1e-3f))
        throw InputError(fmt::format("isr: blur_sigma = {}: expected 0, or 0.001 to 1e6", params.blur_sigma));
    if (params.guard % 2 != 0) throw InputError(fmt::format("isr: guard = {}: expected an even number", params.guard));
    const auto reach = [](int rings, float spacing) { return 1.5 * rings * double(spacing); };  // 1.5: the diagonal
    if (reach(params.rings, params.spacing) > 32000)
        throw InputError(fmt::format("isr: rings = {} with spacing = {}: samples would lie more than 32,000 coarse pixels "
                                     "away", params.rings, params.spacing));
    if (reach(params.ssao_rings, params.ssao_spacing) > 32000)
        throw InputError(fmt::format("isr: ssao_rings = {} with ssao_spacing = {}: samples would lie more than 32,000 coarse "
                                     "pixels away", params.ssao_rings, params.ssao_spacing));
    if (params.blur == Blur::edge_aware && params.position == Position::inverse_matrix)
        throw InputError("isr: blur = edge_aware with position = inverse_matrix: expected position = linear, since edges are "
                         "found in linear depth");
    if (params.length_unit != 0 && !(params.length_unit >= 1e-20f))
        throw InputError(fmt::format("isr: length_unit = {}: expected 0, or 1e-20 to 1e+20", params.length_unit));
    if (params.far_rings > 0 && params.full_depth <= 0)
        throw InputError(fmt::format("isr: far_rings = {}: expected a full_depth above 0", params.far_rings));
    if (params.far_rings > params.rings)
        throw InputError(fmt::format("isr: far_rings = {}: expected at most rings = {}", params.far_rings, params.rings));
}

IsrParams resolved(const IsrParams& params) {
    IsrParams p = params;
    const bool published = p.variant == Variant::published;
    if (p.pattern == PatternKind::automatic) {
        p.pattern = p.spacing != 0 || published ? PatternKind::grid : PatternKind::rings;
        if (published && p.spacing == 0) p.spacing = 8;
    }
    if (p.rotations == 0) p.rotations = p.pattern == PatternKind::rings ? 64 : 1;
    if (p.turn == Turn::automatic) p.turn = tile_of(p.rotations) > 1 ? Turn::tile : Turn::hash;
    if (p.blur == Blur::automatic)
        p.blur = published || p.position == Position::inverse_matrix ? Blur::gaussian : Blur::edge_aware;
    if (p.blur_radius == 0) p.blur_radius = p.blur == Blur::edge_aware ? 8 : 4;
    if (p.blur_sigma == 0) p.blur_sigma = float(p.blur_radius) / 2;
    return p;
}

std::vector<ParamInfo> params_of(const std::vector<std::string>& names) {
    IsrParams defaults;
    return describe(fields(defaults), names);
}

}  // namespace plumb::isr
