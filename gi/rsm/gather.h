// The stages rsm.disc, rsm.paths, rsm.all and rsm.all_rays: indirect irradiance from one light's reflective shadow map.
// See gi/rsm/README.md.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/binding.h"
#include "core/image.h"
#include "core/isa.h"
#include "core/ray_query.h"
#include "core/sample_rows.h"
#include "core/stage.h"
#include "core/tap.h"
#include "gi/rsm/shadow_rays.h"
#include "raster/covered.h"
#include "raster/rsm.h"

namespace plumb::rsm {

enum class Gather : int { disc, all, all_rays, paths };
// How samples become texels: whole texels away from the one rounded projection of x, or each by its own position.
enum class Texels : int { whole, continuous };
struct GatherStage {
    Gather gather;
    Texels texels = Texels::whole;
};
inline constexpr GatherStage gather_stages[] = {{Gather::disc}, {Gather::disc, Texels::continuous},
                                                {Gather::paths}, {Gather::paths, Texels::continuous},
                                                {Gather::all}, {Gather::all_rays}};
enum class Variant : int { corrected, published };
enum class Sequence : int { hammersley, r2, random };
enum class Projection : int { plain, clamped };
// VRSM's algorithms of that number; 3 and 6 are the same function.
enum class Visibility : int { none, algorithm_2, algorithm_3, algorithm_6 };
enum class SlotEdges : int { angle, solid_angle };
// How the steps of a path grow with the distance from its start: not, with its root, or with it.
enum class Spacing : int { uniform, quadratic, geometric };
enum class Turn : int { automatic, hash, tile };
// How large the samples of disc and paths are: points, or discs of the area of the texels that they stand for.
enum class SampleArea : int { none, texels };

struct GatherParams {
    Gather gather = Gather::paths;
    Variant variant = Variant::corrected;
    int samples = 400;
    float radius = 0.3f;
    int rotations = 64;
    Sequence sequence = Sequence::hammersley;
    Projection projection = Projection::plain;
    float min_distance = 0;
    Rays rays = Rays::exact;
    float max_rays = 1e9f;
    int directions = 10;
    int steps = 15;
    Spacing spacing = Spacing::quadratic;
    float growth = 64;  // geometric: the last of many steps over the first
    float jitter = 1;
    float turn_jitter = 0;
    Visibility visibility = Visibility::algorithm_6;
    int slots = 5;
    SlotEdges slot_edges = SlotEdges::angle;
    float fade = 0.125f;
    float thickness = 0;
    Turn turn = Turn::automatic;
    Texels texels = Texels::whole;
    SampleArea sample_area = SampleArea::none;  // of the variant published none
    std::string pattern = {};  // disc, paths: a file's samples, which `own` holds, in place of made ones
    SampleRowsPtr own = {};
};
std::vector<Field> fields(GatherParams& params);

// hash or tile: what automatic stands for.
Turn turn_of(const GatherParams& params);

// Samples of a pixel, for those that read a pattern; validate() allows so many.
int sample_count(const GatherParams& params);
inline constexpr int most_samples = 65536;
inline constexpr int most_side = 32767;  // texels of a map

// A sample pattern around the projection of the shading point, as the kernel binds it.
struct Pattern {
    int samples = 0, rotations = 0;
    Buffer<std::int32_t> offsets;  // [samples][rotations]: whole texels, dx in the lower 16 bits, dy in the upper 16
    Buffer<float> positions;       // instead of offsets, continuous: [samples][rotations][2]: dx, dy in texels
    Buffer<float> weights;         // disc: [samples], paths: [samples][rotations]: texels that a sample stands for
};

// The disc pattern of `params` for a map of map_size texels a side, made in double precision: xi1, xi2 from the sequence,
// offset = round(r (xi1 sin 2 pi (xi2 + i / rotations), xi1 cos ...)). Weight 2 pi r^2 xi1 / N; published: xi1^2, scaled
// so that a constant is integrated exactly.
Pattern disc_pattern(const GatherParams& params, int map_size, std::uint32_t seed);

// The paths of `params`, directions * steps samples path by path. Rotation i turns path m to the angle
// 2 pi (m + (i + 1/2) / rotations + turn_jitter a) / directions; step k lies at rho = r g((k + 1/2 + jitter b) / steps), a
// and b in [-1/2, 1/2), b spread evenly over the rotations; g(u) = u, u^2 or (growth^u - 1) / (growth - 1). Weight: a path's
// share of the ring about rho, (2 pi rho / directions)(r g' / steps), scaled so that on the average over b it is the share of
// step k's ring; published: rho^2, scaled so that a constant is integrated exactly.
Pattern paths_pattern(const GatherParams& params, int map_size, std::uint32_t seed);

// The rows of params.own. Rotation i turns them by i / rotations of a circle (disc) or of a path's sector (paths).
Pattern own_pattern(const GatherParams& params);

// What the gather of `params` reads: empty for those that read every texel. Throws InputError for rows that do not fit.
Pattern pattern_of(const GatherParams& params, int map_size, std::uint32_t seed);

// The pattern whose rotation i is `pattern`'s (i + columns) mod rotations.
Pattern turned(Pattern pattern, int columns);

// Texels: the largest |dx| or |dy| of whole-texel offsets; of positions a texel more, rounded up.
int reach_of(const Pattern& pattern);

// What the uniform texel_area holds, of the rows of world to texels of a map: the texel that sees x_p, on a surface of the
// normal n_p, has the area h^3 / |n_p . (xyz - w x_p)|, h = w . (x_p, 1).
//
// A step dX on the surface moves the texel by (x - X w) . dX / h and (y - Y w) . dX / h, X and Y being x_p's place on the map.
// So h^2 over the area is the part along n_p of (x - X w) x (y - Y w) = x x y + X y x w + Y w x x (of their first three
// components): times h it is linear in x_p.
glm::dvec4 texel_area(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& w);

// Where slots of the micro linear buffer meet, ascending: s |s|, s the sine of the elevation. slots - 1 numbers; without
// visibility one, which is not read.
Buffer<float> slot_edges(const GatherParams& params);

struct GatherInputs {
    const Image4* position = nullptr;  // xyz world, m
    const Image4* normal = nullptr;    // xyz unit; all 0 where there is no surface
    const raster::Rsm* rsm = nullptr;
    const Pattern* pattern = nullptr;  // disc, paths
    std::uint32_t seed = 1;            // of the choice of rotation, or of a subset
    const RayQuery* rays = nullptr;    // all_rays only
    RayOffsets offsets = {};           // all_rays only: ray_offsets(), all_rays.h
    const raster::Covered* tiles = nullptr;  // not all_rays: the others keep irradiance 0; null: all are shaded
};

// What all_rays reports of a run beside its irradiance.
struct RaysReport {
    Image4 standard_error;       // of the irradiance, by channel; 0 everywhere where every texel was asked
    std::uint64_t points = 0;    // pixels with a surface
    std::uint64_t lit = 0;       // texels that reflect flux, of `texels`: only they are asked
    std::uint64_t texels = 0;
    std::uint64_t asked = 0;     // texels a pixel: lit, or fewer
    std::uint64_t traced = 0;    // rays: texels that face the point and are faced by it
};

// Throws InputError that names the parameter at fault; pattern_of() asks first, so that no table is made in vain.
void validate(const GatherParams& params);

// Throws InputError that names the input or parameter at fault.
void validate(const GatherParams& params, const GatherInputs& inputs);

// What disc, paths and all are bound as. Throws std::logic_error for all_rays, which no device runs.
const StageBinding& stage_of(Gather gather, Texels texels = Texels::whole);
inline const StageBinding& stage_of(const GatherParams& params) { return stage_of(params.gather, params.texels); }
// One dispatch for the map inputs.rsm: what it reads is lent, not copied.
StageData data_of(const GatherParams& params, const GatherInputs& inputs);

// irradiance: W/m2 in xyz, w = 0; the size of `position`. Allocates the result, nothing else per pixel.
void run(const GatherParams& params, const GatherInputs& inputs, const RunOptions& options, Image4& irradiance);

// All maps of a light, one after the other, added in their order: the six faces of a point light, each a map of its own.
// A map of size 0 sends nothing. inputs.rsm is not read. `report` is written by all_rays.
void run_maps(const GatherParams& params, const GatherInputs& inputs, std::span<const raster::Rsm> maps,
              const RunOptions& options, Image4& irradiance, RaysReport* report = nullptr);

// Every named value of one invocation, in the order in which the kernel computes them.
std::vector<TapValue> explain(const GatherParams& params, const GatherInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain_maps(const GatherParams& params, const GatherInputs& inputs,
                                   std::span<const raster::Rsm> maps, glm::ivec2 pixel);

// "rsm.disc", "rsm.disc_continuous", ...
std::string stage_name(Gather gather, Texels texels = Texels::whole);
std::string stage_name(const GatherParams& params);
StageInfo info_all_rays();

}  // namespace plumb::rsm
