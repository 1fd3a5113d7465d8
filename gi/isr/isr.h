// Image-space radiosity (ISR, Rohleder 2010): one bounce or more of diffuse light, and ambient occlusion, from what the
// camera sees alone. See gi/isr/README.md.
//
//     G-buffer, direct --isr.downsample--> surface, radiosity, reflectance      a quarter of the pixels
//     surface, radiosity --isr.gather--> irradiance --isr.bounce--> radiosity --isr.gather--> ...
//     surface, irradiance --isr.ssao--> irradiance and accessibility --isr.blur (horizontal, vertical)-->
//     --isr.upsample--> every pixel --isr.compose--> radiance
//
// A coarse pixel (x, y) stands for the full pixels (2 x, 2 y) .. (2 x + 1, 2 y + 1); its centre is their common corner.
// The buffer that goes through the chain is ISR_4 of Listing 6: xyz irradiance, w accessibility.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/isa.h"
#include "core/stage.h"
#include "core/tap.h"
#include "raster/covered.h"

namespace plumb::isr {

enum class Variant : int { corrected, published };
enum class Position : int { linear, inverse_matrix };
enum class Mode : int { f2, f3, f4, f5 };
enum class Blur : int { none, gaussian, edge_aware };
enum class Upsample : int { bilateral, bilinear };
enum class Ambient : int { none, environment };

// The table [isr] of a scene file; fields() says what each means.
struct IsrParams {
    Variant variant = Variant::corrected;
    Mode mode = Mode::f2;
    int rings = 4;
    float spacing = 8;
    int ssao_rings = 2;
    float ssao_spacing = 2;
    int rotations = 1;
    int bounces = 1;
    int far_rings = 0;
    float full_depth = 0;
    int guard = 0;
    int layers = 1;
    int cameras = 0;
    float camera_angle = 30;
    Position position = Position::linear;
    float least_cosine = 0.1f;
    Blur blur = Blur::gaussian;
    int blur_radius = 4;
    float blur_sigma = 2;
    Upsample upsample = Upsample::bilateral;
    float epsilon = 1e-3f;
    float k_ssao = 0;
    float k_isr = 1;
    Ambient ambient = Ambient::none;
};
std::vector<Field> fields(IsrParams& params);

// Throws InputError that names the parameter: what no range of one says.
void validate(const IsrParams& params);

// (2 k + 1)^2 - 1
inline int sample_count(int rings) { return (2 * rings + 1) * (2 * rings + 1) - 1; }
inline glm::ivec2 coarse_size(glm::ivec2 size) { return (size + 1) / 2; }

// ---- The camera --------------------------------------------------------------------------------------------------------

// How coarse pixels become positions (ISR 4.3): eye + (f_o + x f_u + y f_v) z, x and y whole coarse pixels, z linear eye
// depth in m. The vectors are in world space; kernels compute relative to the eye.
struct CoarseCamera {
    glm::dvec3 eye{0};
    glm::dvec3 f_o{0}, f_u{0}, f_v{0};  // at eye depth 1 m: of pixel (0, 0)'s centre; a pixel to the right; a pixel down
    double footprint = 0;               // m: side of a coarse pixel at depth 1
    double near = 0, far = 0;           // m
    glm::dmat4 view_to_world{1};        // of the canonical view space, without its translation
    glm::dmat4 clip_to_view{1};         // the inverse of the canonical projection of these coarse pixels' rectangle
    glm::ivec2 size{0};                 // coarse pixels
};
// `guard` full pixels on each side of the frame, an even number, belong to it as well.
CoarseCamera coarse_camera(const Camera& camera, glm::ivec2 frame_size, int guard = 0);

// f_o, f_u, f_v of ISR (23) and (24), corrected, through the matrices of a convention: what a program of it uploads for
// texture coordinates u, v in 0..1 and z over the far plane. World space, relative to the eye.
struct FrustumVectors {
    glm::dvec3 f_o{0}, f_u{0}, f_v{0};  // m, on the far plane
};
FrustumVectors frustum_vectors(const Camera& camera, glm::ivec2 size, Convention convention);

// ---- Downsampling ------------------------------------------------------------------------------------------------------

// surface: xyz unit normal, w linear eye depth, m (position = inverse_matrix: clip depth); all 0 where none is.
// radiosity: xyz W/m2, w the radiation mask. reflectance: xyz rho.
enum class Coarse : int { surface, radiosity, reflectance };

struct DownsampleInputs {
    const Image4* position = nullptr;  // w: linear eye depth, m
    const Image4* normal = nullptr;    // xyz unit, w 1; all 0 where nothing is
    const Image4* albedo = nullptr;    // rho; w: radiation mask where the layout has one
    const Image4* emission = nullptr;  // radiant exitance, W/m2
    const Image4* direct = nullptr;    // irradiance, W/m2
    double near = 0, far = 0;          // m; read by position = inverse_matrix
    const raster::Covered* tiles = nullptr;  // of coarse pixels: the others get 0; null: all are computed
};
void run_downsample(const IsrParams& params, Coarse what, const DownsampleInputs& inputs, const RunOptions& options,
                    Image4& coarse);

// ---- Gathering ---------------------------------------------------------------------------------------------------------

// Where samples lie around a pixel: rings of a square grid, the nearest first; in each rotation whole coarse pixels away.
struct Pattern {
    Buffer<std::int32_t> offsets;  // [samples][rotations]: dx in the lower 16 bits, dy in the upper 16
    int samples = 0, rotations = 1;
    int reach = 0;                 // coarse pixels: the largest |dx| or |dy|
};
Pattern gather_pattern(const IsrParams& params);
Pattern ssao_pattern(const IsrParams& params);

struct GatherInputs {
    const Image4* surface = nullptr;           // of the receivers, [coarse]
    const Image4* source_surface = nullptr;    // where light comes from: the same image, one with a guard band, a layer
    const Image4* source_radiosity = nullptr;  // of source_surface's size
    const Image4* before = nullptr;            // what other sources sent, as this stage makes it; null: nothing
    CoarseCamera camera;                       // of the receivers
    int margin = 0;                            // coarse pixels of the sources left of and above pixel (0, 0)
    const Pattern* pattern = nullptr;          // gather_pattern()
    std::uint32_t seed = 1;                    // of the rotations
    const raster::Covered* tiles = nullptr;    // of `surface`
};
// gathered: xyz irradiance, W/m2: sum F B / max(1, sum F); w: sum F, of all sources so far.
void run(const IsrParams& params, const GatherInputs& inputs, const RunOptions& options, Image4& gathered);

// Where form factors sum to more than 1.
struct Excess {
    double share = 0;    // of the pixels with a surface
    double largest = 0;  // sum F
};
Excess excess_of(const Image4& surface, const Image4& gathered);

struct SsaoInputs {
    const Image4* surface = nullptr;   // of the receivers
    const Image4* source_surface = nullptr;
    const Image4* gathered = nullptr;  // xyz goes through; null: 0
    CoarseCamera camera;
    int margin = 0;
    const Pattern* pattern = nullptr;  // ssao_pattern()
    std::uint32_t seed = 1;
    const raster::Covered* tiles = nullptr;
};
// lit: xyz irradiance, W/m2; w accessibility, 1 open .. 0 closed; 0, 0, 0, 1 where no surface is.
void run(const IsrParams& params, const SsaoInputs& inputs, const RunOptions& options, Image4& lit);

// B = B0 + rho E: what the next bounce gathers.
struct BounceInputs {
    const Image4* radiosity = nullptr;    // B0 of all sources, with their margin
    const Image4* reflectance = nullptr;  // of the receivers
    const Image4* gathered = nullptr;     // of the receivers
    int margin = 0;
};
void run(const IsrParams& params, const BounceInputs& inputs, const RunOptions& options, Image4& radiosity);

// ---- Additional cameras -----------------------------------------------------------------------------------------------

// Leaves out of an additional camera's surface what another view sees itself: its light is counted there.
struct UnseenInputs {
    const Image4* surface = nullptr;       // of the additional camera, or what is left of it
    CoarseCamera camera;
    const Image4* view_surface = nullptr;  // of the other view, with its margin
    CoarseCamera view;
    int margin = 0;
};
void run(const IsrParams& params, const UnseenInputs& inputs, const RunOptions& options, Image4& unseen);

// isr.gather from an additional camera's image: samples lie around the projections of the receivers.
struct CameraGatherInputs {
    const Image4* surface = nullptr;           // of the receivers
    CoarseCamera camera;
    const Image4* source_surface = nullptr;    // isr.unseen's
    const Image4* source_radiosity = nullptr;
    CoarseCamera source_camera;
    const Image4* before = nullptr;            // as GatherInputs has it
    const Pattern* pattern = nullptr;
    std::uint32_t seed = 1;
    const raster::Covered* tiles = nullptr;
};
void run(const IsrParams& params, const CameraGatherInputs& inputs, const RunOptions& options, Image4& gathered);

// ---- To every pixel ----------------------------------------------------------------------------------------------------

enum class Direction : int { horizontal, vertical };

struct BlurInputs {
    const Image4* lit = nullptr;      // xyz irradiance, W/m2, w accessibility
    const Image4* surface = nullptr;
    Direction direction = Direction::horizontal;
    const raster::Covered* tiles = nullptr;
};
void run(const IsrParams& params, const BlurInputs& inputs, const RunOptions& options, Image4& blurred);

struct UpsampleInputs {
    const Image4* lit = nullptr;       // coarse
    const Image4* surface = nullptr;   // coarse
    const Image4* position = nullptr;  // w: linear eye depth, m
    const Image4* normal = nullptr;    // all 0 where nothing is
    double near = 0, far = 0;          // m
    const raster::Covered* tiles = nullptr;
};
// upsampled: xyz irradiance, W/m2, w accessibility; 0, 0, 0, 1 where no surface is.
void run(const IsrParams& params, const UpsampleInputs& inputs, const RunOptions& options, Image4& upsampled);

struct ComposeInputs {
    const Image4* normal = nullptr;    // w: 1 on a surface, 0 where nothing is
    const Image4* albedo = nullptr;    // rho
    const Image4* emission = nullptr;  // W/m2
    const Image4* direct = nullptr;    // W/m2
    const Image4* indirect = nullptr;  // xyz W/m2, w accessibility
    glm::vec3 environment{0};          // W/(m2 sr)
};
void run(const IsrParams& params, const ComposeInputs& inputs, const RunOptions& options, Image4& radiance);

// ---- What stages say ---------------------------------------------------------------------------------------------------

std::vector<TapValue> explain_downsample(const IsrParams& params, Coarse what, const DownsampleInputs& inputs,
                                         glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const GatherInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const SsaoInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const BounceInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const UnseenInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const CameraGatherInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const BlurInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const UpsampleInputs& inputs, glm::ivec2 pixel);
std::vector<TapValue> explain(const IsrParams& params, const ComposeInputs& inputs, glm::ivec2 pixel);

StageInfo info_downsample();
StageInfo info_gather();
StageInfo info_ssao();
StageInfo info_bounce();
StageInfo info_unseen();
StageInfo info_gather_camera();
StageInfo info_blur();
StageInfo info_upsample();
StageInfo info_compose();

}  // namespace plumb::isr
