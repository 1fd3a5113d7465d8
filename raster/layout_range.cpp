// What a view may show of a scene, against what the targets of a layout hold.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "core/error.h"
#include "core/parallel.h"
#include "raster/layout.h"
#include "raster/surfaces.h"

namespace plumb::raster {
namespace {

constexpr double largest_half = 65504;
constexpr int vertices_per_band = 65536;

// The largest |coordinate| along each axis among all vertices.
glm::dvec3 extent_of(const Geometry& geometry, int threads) {
    glm::vec3 extent(0);
    std::mutex mutex;  // a maximum does not depend on the order in which it is taken
    const int n = int(geometry.vertices.size());
    parallel_bands(n, vertices_per_band, threads, [&](int first, int last) {
        glm::vec3 m(0);
        for (int i = first; i < last; ++i) {
            const glm::vec3 p = glm::abs(geometry.vertices[std::size_t(i)].position);
            m = {std::max(m.x, p.x), std::max(m.y, p.y), std::max(m.z, p.z)};
        }
        const std::lock_guard lock(mutex);
        extent = {std::max(extent.x, m.x), std::max(extent.y, m.y), std::max(extent.z, m.z)};
    });
    return glm::dvec3(extent);
}

// Linear depth of the far plane, m.
double far_of(const View& view) {
    if (!view.orthographic) return view.far;
    // z = a depth + b is 0 at one end and 1 at the other.
    const glm::dmat4 clip = view.world_to_clip();
    double a = 0, b = clip[3][2];
    for (int c = 0; c < 3; ++c) a += clip[c][2] * view.forward[c], b += clip[c][2] * view.eye[c];
    return std::max(-b / a, (1 - b) / a);
}

// Distance from the eye to the corner of the far plane that lies farthest away, m; infinite without a far plane.
double reach_of(const View& view) {
    const double x = 1 / view.view_to_clip[0][0], y = 1 / view.view_to_clip[1][1], far = far_of(view);
    return view.orthographic ? std::sqrt(far * far + x * x + y * y) : far * std::sqrt(1 + x * x + y * y);
}

// What a pass stores in halves, and what else it could do.
struct Halves {
    bool positions, depths;
    const char *instead_of_positions, *instead_of_depths;
};

// Throws InputError where a position or a depth that the view may see overflows its target: what is seen lies within the
// frustum and within the scene.
void check_range(const std::string& place, const std::string& layout, const Halves& halves, const Geometry& geometry,
                 const View& view, int threads) {
    if (!halves.positions && !halves.depths) return;
    const double reach = reach_of(view);
    const glm::dvec3 eye = glm::abs(view.eye);
    if (std::max({eye.x, eye.y, eye.z}) + reach <= largest_half) return;
    const glm::dvec3 extent = extent_of(geometry, threads);
    double coordinate = 0, squared = 0;
    for (int c = 0; c < 3; ++c) {
        coordinate = std::max(coordinate, std::min(extent[c], eye[c] + reach));
        squared += (extent[c] + eye[c]) * (extent[c] + eye[c]);
    }
    const double depth = std::min(far_of(view), std::sqrt(squared));
    if (halves.positions && !(coordinate <= largest_half))
        throw InputError(fmt::format("{}: positions up to {:.6g} km do not fit rgba16f (65.504 km), which layout "
                                     "\"{}\" stores them in: use {}",
                                     place, coordinate / 1000, layout, halves.instead_of_positions));
    if (halves.depths && !(depth <= largest_half))
        throw InputError(fmt::format("{}: depths up to {:.6g} km do not fit r16f (65.504 km), which layout \"{}\" "
                                     "stores them in: use {}",
                                     place, depth / 1000, layout, halves.instead_of_depths));
}

double largest(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

// The least of what any target of radiances holds at most: emission up to it fits without a look at its texture.
constexpr double fits_always = 64512;

// The largest value of a texture, by channel: neither a filter nor a smaller level makes it larger.
glm::vec3 largest_texel(const Texture& texture, const Buffer<float>& decode) {
    const std::size_t curve = texture.srgb ? 256 : 0;
    std::uint32_t most[3] = {};
    for (const std::uint32_t texel : texture.texels.texels)
        for (int c = 0; c < 3; ++c) most[c] = std::max(most[c], texel >> (8 * c) & 255);
    return {decode[curve + most[0]], decode[curve + most[1]], decode[curve + most[2]]};
}

}  // namespace

Range range_of(Format format) {
    if (format == Format::rgba16f || format == Format::r16f) return {glm::dvec3(largest_half), 0x1p-25};
    // Six bits of mantissa, in blue five.
    if (format == Format::r11g11b10f) return {{65024, 65024, 64512}, 0x1p-20};
    return {glm::dvec3(std::numeric_limits<float>::max()), 0x1p-150};
}

Brightest brightest_of(const Scene& scene, const Geometry& geometry) {
    std::vector<char> drawn(scene.materials.size(), 0);
    for (const std::int32_t m : geometry.material)
        if (m >= 0 && m < int(drawn.size())) drawn[std::size_t(m)] = 1;
    Brightest b;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        const Material& m = scene.materials[i];
        if (!drawn[i]) continue;
        glm::vec3 emission = m.emission;
        if (largest(emission) > fits_always && m.emission_texture >= 0 &&
            m.emission_texture < int(scene.textures.size()))
            emission *= largest_texel(scene.textures[std::size_t(m.emission_texture)], decode_table());
        if (largest(emission) > largest(b.emission)) b.emitting = m.name;
        for (int c = 0; c < 3; ++c) {
            b.reflectance[c] = std::max(b.reflectance[c], m.reflectance[c]);
            b.emission[c] = std::max(b.emission[c], emission[c]);
        }
    }
    return b;
}

glm::dvec3 largest_flux(const Light& light, const View& view, const Brightest& brightest) {
    const double side = 2 / (std::abs(view.view_to_clip[0][0]) * light.rsm_size);
    // (1 - s) s is at most 1/4.
    const double reach = light.radius > 0 ? double(light.radius) * double(light.radius) / 4 : 1;
    return glm::dvec3(light.intensity) * glm::dvec3(brightest.reflectance) * (side * side * reach);
}

void check_view(const Layout& layout, const View& view) {
    validate(layout, "gbuffer");
    if (layout.position_from_depth && view.orthographic)
        throw InputError(fmt::format("gbuffer: layout \"{}\" rebuilds positions from depth (ISR 4.3): expected a "
                                     "perspective view", layout.name));
    if (layout.depth_over_far && !std::isfinite(view.far))
        throw InputError(fmt::format("gbuffer: layout \"{}\" divides depth by the far plane, which is infinite: "
                                     "expected a finite one, or a layout that stores metres", layout.name));
}

void check_gbuffer(const Layout& layout, const Geometry& geometry, const Brightest& brightest, const View& view,
                   bool emission, int threads) {
    check_view(layout, view);
    check_range("gbuffer", layout.name,
                {layout.position == Format::rgba16f && !layout.position_from_depth,
                 layout.depth == Format::r16f && !layout.depth_from_position && !layout.depth_over_far,
                 "fp32, or positions rebuilt from depth", "fp32, or a nearer far plane"},
                geometry, view, threads);
    const glm::dvec3 most = range_of(layout.emission).largest;
    for (int c = 0; emission && c < 3; ++c)
        if (!(brightest.emission[c] <= most[c]))
            throw InputError(fmt::format("gbuffer: material \"{}\": emission of {:.4g} W/m2 does not fit {} ({:g}), which "
                                         "layout \"{}\" stores it in: use fp32",
                                         brightest.emitting, largest(brightest.emission), info(layout.emission).name,
                                         most[c], layout.name));
}

void check_rsm(const Layout& layout, const Light& light, const Geometry& geometry, const Brightest& brightest,
               const View& view, bool flux, int threads) {
    const std::string place = fmt::format("rsm: light \"{}\"", light.name);
    validate(layout, place);
    check_range(place, layout.name,
                {layout.rsm_position == Format::rgba16f, layout.rsm_depth == Format::r16f, "fp32", "fp32"}, geometry,
                view, threads);
    const glm::dvec3 most = range_of(layout.rsm_flux).largest, bound = largest_flux(light, view, brightest);
    // What falls on a texel is a float, too, before any of it is reflected.
    Brightest white;
    white.reflectance = glm::vec3(1);
    const glm::dvec3 falls = largest_flux(light, view, white);
    for (int c = 0; flux && c < 3; ++c)
        if (!(std::abs(falls[c]) <= std::numeric_limits<float>::max()))
            throw InputError(fmt::format("{}: flux of {:.4g} W falls on a texel, more than a float holds: use more texels "
                                         "(rsm_size = {}) or a weaker light", place, falls[c], light.rsm_size));
    for (int c = 0; flux && c < 3; ++c)
        if (!(std::abs(bound[c]) <= most[c]))
            throw InputError(fmt::format("{}: flux up to {:.4g} W a texel does not fit {} ({:g} W), which layout \"{}\" "
                                         "stores it in: use fp32, more texels (rsm_size = {}) or a weaker light",
                                         place, bound[c], info(layout.rsm_flux).name, most[c], layout.name,
                                         light.rsm_size));
}

}  // namespace plumb::raster
