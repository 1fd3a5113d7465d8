// How the passes store what they draw: a format for each buffer. A layout is data. In memory everything stays fp32 (or
// half) records; a pass rounds what it writes to what a render target of the format gives back. raster/README.md has a
// table for each preset.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/fields.h"
#include "core/formats.h"
#include "core/image.h"
#include "core/scene.h"
#include "core/view.h"

namespace plumb::raster {

struct Layout {
    std::string name = "fp32";  // of a preset, or "custom"

    // The G-buffer: the target that each part lies in. `depth` is linear eye depth, position's w, whose target may be
    // the position's fourth channel; `depth_buffer` is what the depth test leaves behind.
    Format position = Format::rgba32f;
    Format normal = Format::rgba32f;
    Format albedo = Format::rgba32f;
    Format emission = Format::rgba32f;
    Format depth = Format::r32f;
    Format depth_buffer = Format::d32f;

    // ISR 4.3: positions are rebuilt from the stored depth, not stored. LRA: depth follows from the stored position.
    bool position_from_depth = false;
    bool depth_from_position = false;
    bool depth_over_far = false;  // depth is stored divided by the far plane (ISR Listing 4)
    bool radiation_mask = false;  // albedo's w: luminance of rho (ISR 4.2: alpha of CLR; weights of ISR (17))

    // Reflective shadow maps.
    Format rsm_position = Format::rgba32f;
    Format rsm_normal = Format::rgba32f;
    Format rsm_flux = Format::rgba32f;
    Format rsm_depth = Format::r32f;  // position's w

    // What later stages store: a light's shadow density (VRSM fig. 4.3: albedo's alpha), and the irradiance that a gather
    // makes (VRSM fig. 4.4; its alpha, linear eye depth, is that of `depth`).
    Format visibility = Format::r32f;
    Format indirect = Format::rgba32f;

    // True where a texel record of the map fits halves without loss: a gather then reads 32 bytes a texel, not 64.
    bool half_records() const {
        return rsm_position == Format::rgba16f && rsm_normal == Format::rgba16f && rsm_flux == Format::rgba16f &&
               rsm_depth == Format::r16f;
    }

    bool operator==(const Layout&) const = default;

    static const Layout fp32;     // nothing is rounded
    static const Layout rgba16f;  // every colour target is RGBA16F, rounded to nearest even
    static const Layout vrsm;     // VRSM fig. 4.2-4.4
    static const Layout isr;      // ISR fig. 4.1
    static const Layout lra;      // LRA 4.2.1, 6.2.1
};

// All presets, in the order of their names' list: fp32, rgba16f, vrsm, isr, lra.
const std::vector<Layout>& layouts();

// A preset by name, or the start of a user's own: fp32 by the name "custom". Throws InputError at `place`.
Layout parse_layout(const std::string& name, const std::string& place);

// What a [layout] table holds.
std::vector<Field> fields(Layout& layout);

// Throws InputError at `place` that names the buffer: for a format that cannot hold it, for parts that contradict each
// other, and for a preset's name on anything but the preset.
void validate(const Layout& layout, const std::string& place);

// The largest number that a target holds, by channel, and below which all of them round to 0.
struct Range {
    glm::dvec3 largest;
    double least;
};
Range range_of(Format format);

// The most that any material which is drawn reflects and emits, by channel. Textures darken: a reflectance counts
// without its texture, an emission that may not fit with the largest texel of its own.
struct Brightest {
    glm::vec3 reflectance{0};
    glm::vec3 emission{0};     // W/m2
    std::string emitting;      // the material that emits most
};
Brightest brightest_of(const Scene& scene, const Geometry& geometry);

// An upper bound of the flux of any texel of a light's map, W: its whole intensity through the largest texel onto the
// brightest surface.
glm::dvec3 largest_flux(const Light& light, const View& view, const Brightest& brightest);

// Throws InputError where the layout asks what the view has not: a far plane, a perspective.
void check_view(const Layout& layout, const View& view);

// Before a pass computes: check_view(), and throws InputError that names layout and extent where a position or a depth
// that the view may see overflows its 16-bit target, or `emission` is asked for and some does not fit its own.
void check_gbuffer(const Layout& layout, const Geometry& geometry, const Brightest& brightest, const View& view,
                   bool emission, int threads);

// The same for a light's map; `flux`: whether it is asked for.
void check_rsm(const Layout& layout, const Light& light, const Geometry& geometry, const Brightest& brightest,
               const View& view, bool flux, int threads);

// Rounds what a compute stage made to what a target of that format gives back. threads = 0: all processors.
//
// A finite value that becomes infinite there did not fit: of these the first, row by row, is returned, so that the caller
// can say what it is (gi/frame refuses to go on).
struct Overflow {
    glm::ivec2 pixel{0};
    float value = 0;
};
std::optional<Overflow> quantise(Format format, Image4& image, int threads);
// The same of single numbers in rows, which a target of one channel stores.
std::optional<Overflow> quantise(Format format, float* values, glm::ivec2 size, int threads);

// Rounds pixels [first, end) where the kernels leave a format out (quantised_by_kernel()); else does nothing.
void quantise_rest(Format format, Image4& image, glm::ivec2 first, glm::ivec2 end);

}  // namespace plumb::raster
