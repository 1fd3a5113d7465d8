// A ray query that asks every triangle, in double precision: the test double of Embree.
#pragma once

#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "core/ray_query.h"
#include "core/scene.h"

namespace plumb::test {

struct BruteRays : RayQuery {
    std::vector<glm::dvec3> corners;           // three a triangle
    mutable std::atomic<std::uint64_t> asked{0};

    BruteRays() = default;
    explicit BruteRays(const Geometry& geometry) {
        for (const glm::uvec3& t : geometry.triangles)
            for (int c = 0; c < 3; ++c) corners.emplace_back(geometry.vertices[t[c]].position);
    }
    void add_quad(glm::dvec3 a, glm::dvec3 b, glm::dvec3 d) {
        for (const glm::dvec3& p : {a, b, b + d - a, a, b + d - a, d}) corners.push_back(p);
    }

    static double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    static glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }

    // Möller and Trumbore 1997.
    bool hits(const glm::dvec3& o, const glm::dvec3& d, double t_near, double t_far) const {
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            const glm::dvec3 e1 = corners[i + 1] - corners[i], e2 = corners[i + 2] - corners[i], p = cross(d, e2);
            const double det = dot(e1, p);
            if (det == 0) continue;
            const glm::dvec3 s = o - corners[i], q = cross(s, e1);
            const double u = dot(s, p) / det, v = dot(d, q) / det, t = dot(e2, q) / det;
            if (u >= 0 && v >= 0 && u + v <= 1 && t > t_near && t < t_far) return true;
        }
        return false;
    }

    template <int W>
    void shoot(const std::int32_t* active, RayPacket<W>& rays) const {
        for (int k = 0; k < W; ++k) {
            if (active[k] == 0) continue;
            ++asked;
            const glm::dvec3 o(rays.origin_x[k], rays.origin_y[k], rays.origin_z[k]);
            const glm::dvec3 d(rays.direction_x[k], rays.direction_y[k], rays.direction_z[k]);
            if (hits(o, d, rays.t_near[k], rays.t_far[k])) rays.t_far[k] = -std::numeric_limits<float>::infinity();
        }
    }

    void nearest(const std::int32_t*, RayPacket<1>&) const override {}
    void nearest(const std::int32_t*, RayPacket<4>&) const override {}
    void nearest(const std::int32_t*, RayPacket<8>&) const override {}
    void nearest(const std::int32_t*, RayPacket<16>&) const override {}
    void occluded(const std::int32_t* active, RayPacket<1>& rays) const override { shoot(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<4>& rays) const override { shoot(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<8>& rays) const override { shoot(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<16>& rays) const override { shoot(active, rays); }
};

}  // namespace plumb::test
