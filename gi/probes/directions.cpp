#include "gi/probes/directions.h"

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "core/sh.h"

namespace plumb::probes {

namespace {

void check_rays(int rays) {
    if (rays < 1 || rays > 32768) throw InputError("rays = " + std::to_string(rays) + ": expected 1 to 32768");
}

// Sobol's sequence begins at a corner: moved by half of a box of the first 2^16 points, so that none lies on an edge.
glm::dvec2 point(int k) { return sobol(std::uint32_t(k)) + glm::dvec2(0x1p-17); }

}  // namespace

Buffer<glm::vec4> relight_directions(int rays) {
    check_rays(rays);
    Buffer<glm::vec4> directions;
    for (int k = 0; k < rays; ++k) directions.emplace_back(glm::vec3(sample_sphere(point(k))), 0);
    return directions;
}

Buffer<glm::vec4> receiver_directions(int rays, Distribution distribution) {
    check_rays(rays);
    Buffer<glm::vec4> directions;
    for (int k = 0; k < rays; ++k) {
        const glm::dvec2 u = point(k);
        const glm::dvec3 d = distribution == Distribution::cosine ? sample_cosine_hemisphere(u) : sample_hemisphere(u);
        directions.emplace_back(glm::vec3(d), 0);
    }
    return directions;
}

Buffer<float> ray_factors(const Buffer<glm::vec4>& directions, Distribution distribution) {
    Buffer<float> factors;
    const double n = double(directions.size());
    for (const glm::vec4& d : directions)
        factors.push_back(float(distribution == Distribution::cosine ? host::pi / n : 2 * host::pi * double(d.z) / n));
    return factors;
}

Buffer<float> harmonics_of(const Buffer<glm::vec4>& directions, int degree) {
    Buffer<float> values;
    for (const glm::vec4& d : directions) {
        // Of the direction as it is stored, made unit again: rounding moved it.
        const glm::dvec3 exact(d);
        const sh::Values y = sh::basis(exact / std::sqrt(glm::dot(exact, exact)), degree);
        for (int j = 0; j < sh::count(degree); ++j) values.push_back(float(y[std::size_t(j)]));
    }
    return values;
}

}  // namespace plumb::probes
