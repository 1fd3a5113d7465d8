#include "gi/radiosity/projections.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/radiosity/hemicube_factor.h"
#include "gi/radiosity/plane_weight.h"
#include "raster/hemicube.h"
#include "raster/visibility.h"

namespace plumb::radiosity {
namespace {

void check(const ProjectionParams& p) {
    if (p.size < 2 || p.size > 4096 || p.size % 2 != 0)
        throw InputError(fmt::format("projection: size = {}: must be even, 2 to 4096 texels", p.size));
    if (!(p.view_deg > 0 && p.view_deg < 180))
        throw InputError(fmt::format("projection: view_deg = {}: must be above 0, below 180", p.view_deg));
}

// Half of the plane's side at distance 1.
double edge_of(double view_deg) { return host::tan(view_deg * host::pi / 360); }

std::vector<double> plane_weights(int size, double edge) {
    std::vector<double> corners, weights;
    const auto at = [&](int k) { return (2.0 * k / size - 1) * edge; };
    for (int j = 0; j <= size; ++j)
        for (int i = 0; i <= size; ++i) corners.push_back(plane_weight(at(i), at(j)));
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const double* low = &corners[std::size_t(j) * std::size_t(size + 1) + std::size_t(i)];
            const double* high = low + size + 1;
            weights.push_back((high[1] - high[0]) - (low[1] - low[0]));
        }
    return weights;
}

// A texel of the disc at (x, y) looks along (x, y, root(1 - x^2 - y^2)), and so at that over the last on the plane. It weighs its
// area over that of the disc.
std::vector<double> fish_eye_weights(int size, double edge) {
    std::vector<double> weights(std::size_t(size) * std::size_t(size), 0.0);
    double inside = 0;
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
            const double x = (2 * i + 1.0) / size - 1, y = (2 * j + 1.0) / size - 1, z2 = 1 - x * x - y * y;
            if (!(z2 > 0)) continue;
            inside += 1;
            const double z = std::sqrt(z2), u = (x / (z * edge) + 1) / 2 * size, v = (y / (z * edge) + 1) / 2 * size;
            if (u >= 0 && u < size && v >= 0 && v < size) weights[std::size_t(v) * std::size_t(size) + std::size_t(u)] += 1;
        }
    for (double& w : weights) w /= inside;
    return weights;
}

raster::VisibilityBuffer draw(const Geometry& g, const raster::Surfaces* surfaces, const glm::dvec3& eye, const glm::dvec3& normal,
                              const ProjectionParams& p, double near, const RunOptions& options) {
    View view = raster::hemicube_views(eye, normal, near)[0];
    const double edge = edge_of(p.view_deg);
    view.view_to_clip[0][0] /= edge, view.view_to_clip[1][1] /= edge;
    raster::VisibilityBuffer seen;
    raster::draw_visibility(g, surfaces, view, {p.size, p.size}, options, seen);
    return seen;
}

}  // namespace

double share_of_view(double view_deg) {
    check({Projection::plane, 2, view_deg, false});
    const double edge = edge_of(view_deg);
    return 4 * plane_weight(edge, edge);
}

std::vector<double> projection_weights(const ProjectionParams& p) {
    check(p);
    const double edge = edge_of(p.view_deg);
    std::vector<double> weights = p.projection == Projection::plane ? plane_weights(p.size, edge) : fish_eye_weights(p.size, edge);
    if (!p.rescale) return weights;
    double sum = 0;
    for (const double w : weights) sum += w;
    if (!(sum > 0)) throw InputError(fmt::format("projection: view_deg = {}: no texel of the lens looks into the picture: expected a wider one", p.view_deg));
    for (double& w : weights) w /= sum;
    return weights;
}

double projected_form_factor(const Geometry& geometry, const raster::Surfaces* surfaces, const std::vector<SourcePoint>& points,
                             const std::vector<std::int32_t>& targets, const ProjectionParams& params, double offset,
                             const RunOptions& options) {
    const std::vector<double> weights = projection_weights(params);
    double sum = 0;
    for (const SourcePoint& p : points) {
        const glm::dvec3 eye = p.position + p.normal * offset;
        const std::vector<bool> counts = counted_from(geometry, targets, eye);
        const raster::VisibilityBuffer seen = draw(geometry, surfaces, eye, p.normal, params, 0.5 * offset, options);
        for (std::size_t i = 0; i < weights.size(); ++i) {
            const std::int32_t t = seen.triangle.texels[i];
            if (t >= 0 && counts[std::size_t(t)]) sum += weights[i];
        }
    }
    return sum / double(points.size());
}

int size_of_equal_texels(int hemicube) { return 2 * int(std::floor(std::sqrt(3.0) * hemicube / 2 + 0.5)); }

}  // namespace plumb::radiosity
