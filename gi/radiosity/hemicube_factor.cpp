#include "gi/radiosity/hemicube_factor.h"

#include <cmath>

#include "core/host_math.h"
#include "raster/hemicube.h"

namespace plumb::radiosity {
namespace {

double seen_by(const raster::Hemicube& cube, const std::vector<double>& weights, const std::vector<bool>& counts) {
    double sum = 0;
    std::size_t texel = 0;
    for (const raster::VisibilityBuffer& face : cube.faces)
        for (const std::int32_t t : face.triangle.texels) {
            if (t >= 0 && counts[std::size_t(t)]) sum += weights[texel];
            ++texel;
        }
    return sum;
}

Geometry quad(const glm::dvec3 (&corners)[4]) {
    Geometry g;
    for (const glm::dvec3& c : corners) {
        Vertex v;
        v.position = glm::vec3(c), v.normal = {0, -1, 0};
        g.vertices.push_back(v);
    }
    g.triangles = {{0, 1, 2}, {0, 2, 3}};
    g.material = g.object = {0, 0};
    return g;
}

}  // namespace

std::vector<bool> counted_from(const Geometry& g, const std::vector<std::int32_t>& targets, const glm::dvec3& eye) {
    std::vector<bool> counts(g.triangles.size());
    for (std::size_t t = 0; t < g.triangles.size(); ++t) {
        const glm::uvec3 c = g.triangles[t];
        const glm::dvec3 a(g.vertices[c.x].position), b(g.vertices[c.y].position), d(g.vertices[c.z].position);
        const bool back = glm::dot(glm::cross(b - a, d - a), eye - a) < 0;
        counts[t] = targets[2 * t + (back ? 1 : 0)] == 0;
    }
    return counts;
}

double hemicube_form_factor(const Geometry& geometry, const raster::Surfaces* surfaces,
                            const std::vector<SourcePoint>& points, const std::vector<std::int32_t>& targets, int size,
                            Weights weights, double offset, const RunOptions& options) {
    const std::vector<double> texels = texel_weights(size, weights);
    raster::Hemicube cube;
    double sum = 0;
    for (const SourcePoint& p : points) {
        const glm::dvec3 eye = p.position + p.normal * offset;
        raster::draw_hemicube(geometry, surfaces, eye, p.normal, 0.5 * offset, size, options, cube);
        sum += seen_by(cube, texels, counted_from(geometry, targets, eye));
    }
    return sum / double(points.size());
}

RotationErrors rotation_errors(const std::function<double(const Geometry&)>& seen) {
    const double truth = 0.239456470460774;
    RotationErrors errors;
    double squares = 0;
    for (int degree = 0; degree <= 90; ++degree) {
        const double a = degree * host::pi / 180, c = host::cos(a) / 2, s = host::sin(a) / 2;
        auto corner = [&](double x, double y) { return glm::dvec3(c * x - s * y, 1, s * x + c * y); };
        const Geometry g = quad({corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
        const double error = 100 * (seen(g) / truth - 1);
        squares += error * error, errors.largest = std::fmax(errors.largest, std::fabs(error));
    }
    errors.rms = std::sqrt(squares / 91);
    return errors;
}

RotationErrors rotation_errors(int size, Weights weights, const RunOptions& options) {
    const std::vector<double> texels = texel_weights(size, weights);
    const std::vector<bool> both(2, true);
    raster::Hemicube cube;
    return rotation_errors([&](const Geometry& g) {
        raster::draw_hemicube(g, nullptr, {0, 0, 0}, {0, 1, 0}, 1e-4, size, options, cube);
        return seen_by(cube, texels, both);
    });
}

}  // namespace plumb::radiosity
