#include "gi/radiosity/ray_form_factors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/error.h"
#include "core/parallel.h"
#include "core/sequences.h"
#include "gi/reference/light_kernel.h"
#include "gi/reference/sampler_kernel.h"
#include "gi/reference/warp_kernel.h"

namespace plumb::radiosity {
namespace {

constexpr int width = 8;
using Packet = RayPacket<width>;

// The faces as triangles, for points on them.
struct Surface {
    std::vector<glm::dvec3> corners;  // three a triangle
    std::vector<double> up_to;        // share of the area up to each triangle's end
    SourcePoint single{};

    explicit Surface(const RaySource& from) : single{from.point, from.normal} {
        double sum = 0;
        for (const Polygon& face : from.faces)
            for (std::size_t i = 2; i < face.size(); ++i) {
                corners.insert(corners.end(), {face[0], face[i - 1], face[i]});
                up_to.push_back(sum += 0.5 * glm::length(glm::cross(face[i - 1] - face[0], face[i] - face[0])));
            }
        for (double& share : up_to) share /= sum;
        if (!up_to.empty() && !(sum > 0)) throw InputError("form factors: a surface without area sends no rays");
        if (up_to.empty()) single.normal /= glm::length(single.normal);
    }

    SourcePoint at(glm::dvec2 u) const {
        if (up_to.empty()) return single;
        std::size_t t = std::size_t(std::upper_bound(up_to.begin(), up_to.end(), u.x) - up_to.begin());
        t = std::min(t, up_to.size() - 1);
        const double before = t > 0 ? up_to[t - 1] : 0;
        const double x = std::sqrt(std::fmin((u.x - before) / (up_to[t] - before), 1));
        const glm::dvec3 *c = &corners[3 * t], ab = c[1] - c[0], ac = c[2] - c[0], n = glm::cross(ab, ac);
        return {c[0] + ab * (x * (1 - u.y)) + ac * (x * u.y), n / glm::length(n)};
    }
};

struct Numbers {
    glm::dvec2 place, direction;
};
Numbers numbers(int batch, std::uint32_t seed, std::int64_t i) {
    const auto s = reference::Sampler<float>::start(0, 0, batch, std::int32_t(seed), std::int32_t(i));
    return {glm::dvec2(s.pair(0)), glm::dvec2(s.pair(1))};
}

void put(Packet& rays, int lane, const glm::dvec3& origin, const glm::dvec3& direction, float t_far) {
    rays.origin_x[lane] = float(origin.x), rays.origin_y[lane] = float(origin.y), rays.origin_z[lane] = float(origin.z);
    rays.direction_x[lane] = float(direction.x), rays.direction_y[lane] = float(direction.y);
    rays.direction_z[lane] = float(direction.z);
    rays.t_near[lane] = 0, rays.t_far[lane] = t_far, rays.time[lane] = 0, rays.id[lane] = rays.flags[lane] = 0;
}

// Sends rays [0, rays) eight at a time: aim(i, packet, lane) makes one, met(packet, lane, side) gets what meets something; side is
// above 0 where that is a back.
template <class Aim, class Met>
void shoot(const RayQuery& query, std::int64_t rays, const Aim& aim, const Met& met) {
    Packet packet{};
    alignas(64) std::int32_t active[width];
    for (std::int64_t first = 0; first < rays; first += width) {
        for (int lane = 0; lane < width; ++lane) {
            active[lane] = first + lane < rays ? -1 : 0;
            aim(std::min(first + lane, rays - 1), packet, lane);
        }
        query.nearest(active, packet);
        for (int lane = 0; lane < width; ++lane) {
            if (!active[lane] || packet.triangle[lane] == no_hit) continue;
            met(packet, lane, packet.direction_x[lane] * packet.normal_x[lane] + packet.direction_y[lane] * packet.normal_y[lane] +
                                  packet.direction_z[lane] * packet.normal_z[lane]);
        }
    }
}

// Adds what the batch's rays meet to `met`, by target.
void count_targets(const RayQuery& query, const Surface& surface, double offset, const std::vector<std::int32_t>& targets,
                   std::int64_t rays, int batch, std::uint32_t seed, std::vector<std::int64_t>& met) {
    shoot(
        query, rays,
        [&](std::int64_t i, Packet& packet, int lane) {
            const Numbers u = numbers(batch, seed, i);
            const SourcePoint p = surface.at(u.place);
            put(packet, lane, p.position + p.normal * offset, reference::to_world(reference::basis_of<double>(p.normal), sample_cosine_hemisphere(u.direction)),
                __builtin_inff());
        },
        [&](const Packet& packet, int lane, float side) {
            const std::int32_t target = targets[2 * std::size_t(packet.triangle[lane]) + (side > 0 ? 1 : 0)];
            if (target >= 0) ++met[std::size_t(target)];
        });
}

}  // namespace

RaySource turned(const RaySource& from) {
    RaySource other = from;
    other.normal = -other.normal;
    for (Polygon& face : other.faces) face = Polygon(face.rbegin(), face.rend());
    return other;
}

std::vector<RayFactor> ray_form_factors(const RayQuery& query, const Geometry& geometry, const RaySource& from,
                                        const std::vector<std::int32_t>& targets, int count,
                                        const RayFactorParams& params, const RunOptions& options) {
    if (params.batches < 2 || params.batches > 4096)
        throw InputError(fmt::format("form factors: {} batches: 2 to 4096", params.batches));
    const std::int64_t batches = params.batches, each = (params.rays + batches - 1) / batches;
    if (params.rays < batches || each > 1 << 25)
        throw InputError(fmt::format("form factors: {} rays in {} batches: 1 to 2^25 a batch", params.rays, batches));
    if (targets.size() != 2 * geometry.triangles.size())
        throw InputError("form factors: two targets a triangle, of its front and of its back");
    const Surface surface(from);
    const double offset = surface_offset(geometry);
    // Sums of counts and of their squares: whole, so that their order is all the same.
    std::vector<std::int64_t> sum(std::size_t(count), 0);
    std::vector<std::uint64_t> squares(std::size_t(count), 0);
    std::mutex mutex;
    parallel_bands(params.batches, 1, options, [&](int first, int last) {
        std::vector<std::int64_t> met(std::size_t(count), 0);
        for (int batch = first; batch < last; ++batch) {
            std::fill(met.begin(), met.end(), 0);
            count_targets(query, surface, offset, targets, each, batch, params.seed, met);
            const std::lock_guard<std::mutex> lock(mutex);
            for (std::size_t k = 0; k < met.size(); ++k) sum[k] += met[k], squares[k] += std::uint64_t(met[k] * met[k]);
        }
    });
    std::vector<RayFactor> factors(std::size_t(count), RayFactor{});
    for (std::size_t k = 0; k < factors.size(); ++k) {
        const double mean = double(sum[k]) / double(batches);
        const double deviation = std::fmax(double(squares[k]) - mean * double(sum[k]), 0);
        factors[k] = {mean / double(each), std::sqrt(deviation / double(batches * (batches - 1))) / double(each)};
    }
    return factors;
}

std::vector<RayFactor> ray_form_factor_row(const RayQuery& query, const Geometry& geometry, const RaySource& from,
                                           const RayFactorParams& params, const RunOptions& options) {
    std::vector<std::int32_t> targets;
    for (std::size_t t = 0; t < geometry.triangles.size(); ++t) targets.insert(targets.end(), 2, std::int32_t(t));
    return ray_form_factors(query, geometry, from, targets, int(geometry.triangles.size()), params, options);
}

std::vector<glm::dvec3> cosine_directions(std::int64_t rays, std::uint32_t seed) {
    if (rays < 1 || rays > 1 << 25) throw InputError(fmt::format("form factors: {} rays: 1 to 2^25", rays));
    std::vector<glm::dvec2> squares;
    for (std::int64_t i = 0; i < rays; ++i) squares.push_back(numbers(0, seed, i).direction);
    const double tiles = std::ceil(std::sqrt(double(rays) / width));
    const auto tile = [&](const glm::dvec2& u) { return std::floor(u.x * tiles) * tiles + std::floor(u.y * tiles); };
    std::stable_sort(squares.begin(), squares.end(), [&](const glm::dvec2& a, const glm::dvec2& b) { return tile(a) < tile(b); });
    std::vector<glm::dvec3> directions;
    for (const glm::dvec2& u : squares) directions.push_back(sample_cosine_hemisphere(u));
    return directions;
}

void add_ray_row(const RayQuery& query, const Elements& elements, int element, const std::vector<glm::dvec3>& directions, std::vector<double>& share) {
    const glm::dvec3 eye(elements.eye[std::size_t(element)]), normal(elements.normal[std::size_t(element)]);
    if (!(glm::dot(normal, normal) > 0)) return;
    const auto frame = reference::basis_of<double>(normal / glm::length(normal));
    const double each = 1 / double(directions.size());
    shoot(
        query, std::int64_t(directions.size()),
        [&](std::int64_t i, Packet& packet, int lane) {
            put(packet, lane, eye, reference::to_world<double>(frame, directions[std::size_t(i)]), __builtin_inff());
        },
        [&](const Packet& packet, int lane, float side) {
            if (side > 0) return;
            const glm::uvec3& of = elements.of[packet.triangle[lane]];
            const double u = double(packet.u[lane]), v = double(packet.v[lane]);
            share[of.x] += each * (1 - u - v), share[of.y] += each * u, share[of.z] += each * v;
        });
}

double surface_offset(const Geometry& geometry) {
    float extent = 0;
    for (const Vertex& v : geometry.vertices)
        extent = std::max({extent, std::fabs(v.position.x), std::fabs(v.position.y), std::fabs(v.position.z)});
    return double(reference::ray_offset(extent));
}

std::vector<SourcePoint> source_points(const RaySource& from, int count, std::uint32_t seed) {
    const Surface surface(from);
    std::vector<SourcePoint> points;
    for (int i = 0; i < (from.faces.empty() ? 1 : count); ++i) points.push_back(surface.at(numbers(0, seed, i).place));
    return points;
}

Between between(const RayQuery& query, const Geometry& geometry, const RaySource& from, const RaySource& to,
                const std::vector<std::int32_t>& owner, Sides sides, int segments, std::uint32_t seed) {
    const Surface a(from), b(to);
    const double offset = surface_offset(geometry);
    std::vector<bool> blocks(geometry.triangles.size(), false);
    Between found;
    Packet packet{};
    alignas(64) std::int32_t active[width] = {-1};
    for (int i = 0; i < segments; ++i) {
        const Numbers u = numbers(0, seed, i);
        const SourcePoint p = a.at(u.place), q = b.at(u.direction);
        const glm::dvec3 way = q.position - p.position;
        const double behind = glm::dot(q.normal, way);
        if (!(glm::dot(p.normal, way) > 0) || behind == 0 || (sides == Sides::front && behind > 0)) continue;
        ++found.segments;
        const glm::dvec3 start = p.position + p.normal * offset,
                         end = q.position + q.normal * (behind > 0 ? -offset : offset);
        put(packet, 0, start, end - start, 1);
        query.nearest(active, packet);
        if (packet.triangle[0] == no_hit) continue;
        ++found.hidden;
        blocks[packet.triangle[0]] = true;
    }
    for (std::size_t t = 0; t < blocks.size(); ++t)
        if (blocks[t]) ++(owner[t] == 0 || owner[t] == 1 ? found.own : found.occluders);
    return found;
}

}  // namespace plumb::radiosity
