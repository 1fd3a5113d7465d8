// The parameters of image-space radiosity, its coarse camera and its patterns: what its stages share.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/stage.h"
#include "core/stage_description.h"

namespace plumb::isr {

enum class Variant : int { corrected, published };
enum class Position : int { linear, inverse_matrix };
enum class Mode : int { f2, f3, f4, f5 };
enum class Blur : int { automatic, none, gaussian, edge_aware };
enum class Upsample : int { bilateral, bilinear };
enum class Ambient : int { none, environment };
enum class Turn : int { automatic, hash, tile };
enum class Resolution : int { quarter, native };
enum class SolidAngle : int { printed, none, hemisphere };
enum class SsaoTerm : int { accessibility, occlusion };
enum class PatternKind : int { automatic, rings, grid };

// The table [isr] of a scene file; fields() says what each means.
struct IsrParams {
    Variant variant = Variant::corrected;
    Mode mode = Mode::f2;
    Resolution resolution = Resolution::quarter;
    PatternKind pattern = PatternKind::automatic;
    int rings = 4;
    float reach = 1.25f;
    float growth = 3;
    float spacing = 0;
    int ssao_rings = 2;
    float ssao_spacing = 2;
    int rotations = 0;
    Turn turn = Turn::automatic;
    int bounces = 1;
    int far_rings = 0;
    float full_depth = 0;
    int guard = 0;
    int layers = 1;
    int cameras = 0;
    float camera_angle = 30;
    Position position = Position::linear;
    float least_cosine = 0.1f;
    Blur blur = Blur::automatic;
    int blur_radius = 0;
    float blur_sigma = 0;
    Upsample upsample = Upsample::bilateral;
    float epsilon = 1e-3f;
    SolidAngle solid_angle = SolidAngle::printed;
    SsaoTerm ssao_term = SsaoTerm::accessibility;
    float light_unit = 0;
    float length_unit = 0;
    float k_ssao = 0;
    float k_isr = 1;
    Ambient ambient = Ambient::none;
};
std::vector<Field> fields(IsrParams& params);

std::vector<ParamInfo> params_of(const std::vector<std::string>& names);

// Throws InputError that names the parameter: what no range of one says.
void validate(const IsrParams& params);

// With what `pattern`, `rotations`, `turn`, `spacing` and the blur's leave open: never automatic, never 0 rotations, and a
// radius and a sigma above 0.
IsrParams resolved(const IsrParams& params);

// (2 k + 1)^2 - 1
inline int sample_count(int rings) { return (2 * rings + 1) * (2 * rings + 1) - 1; }
// Pixels of the frame along a side of a coarse pixel.
inline int coarse_side(const IsrParams& params) { return params.resolution == Resolution::native ? 1 : 2; }
inline glm::ivec2 coarse_size(glm::ivec2 size, int side = 2) { return (size + side - 1) / side; }

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
// `guard` full pixels on each side of the frame, an even number, belong to it as well. side: coarse_side().
CoarseCamera coarse_camera(const Camera& camera, glm::ivec2 frame_size, int guard = 0, int side = 2);

// f_o, f_u, f_v of ISR (23) and (24), corrected, through the matrices of a convention: what a program of it uploads for
// texture coordinates u, v in 0..1 and z over the far plane. World space, relative to the eye.
struct FrustumVectors {
    glm::dvec3 f_o{0}, f_u{0}, f_v{0};  // m, on the far plane
};
FrustumVectors frustum_vectors(const Camera& camera, glm::ivec2 size, Convention convention);

// ---- Patterns ----------------------------------------------------------------------------------------------------------

// Where samples lie around a pixel, the nearest first, in each rotation whole coarse pixels away; and the area for which
// each stands: weights[k] squares of `side`. Ring r has 8 r samples.
struct Pattern {
    Buffer<std::int32_t> offsets;  // [samples][rotations]: dx in the lower 16 bits, dy in the upper 16
    Buffer<float> weights;         // [samples]
    int samples = 0, rotations = 1;
    int reach = 0;                 // coarse pixels: the largest |dx| or |dy|
    double side = 1;               // coarse pixels
};
// height: of the frame that the samples lie in, without its guard band, coarse pixels.
Pattern gather_pattern(const IsrParams& params, int height);
Pattern ssao_pattern(const IsrParams& params);

}  // namespace plumb::isr
