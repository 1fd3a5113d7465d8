// Rays against the triangles of a scene: what Embree does for the path tracer, the exact gathers and the probes' bake.
// gi/reference/ray_query.cpp implements it; nothing else sees Embree.
#pragma once

#include <cstdint>

namespace plumb {

// exact: our own triangle test in double precision, the same bits on every processor: for whatever reaches a hash or a
// bake. native: Embree's own test, faster, whose last bits differ between instruction sets: where a standard error is
// reported anyway.
enum class Rays : int { exact, native };

// W rays and what they hit, an array a member. Laid out as Embree's RTCRayHit<W>, so that nothing is copied. Directions
// may have any length: a point of the ray is origin + t direction, t_near < t <= t_far. Rays that are not finite meet
// nothing.
template <int W>
struct alignas(W == 16 ? 64 : W == 8 ? 32 : 16) RayPacket {
    float origin_x[W], origin_y[W], origin_z[W];  // m, world
    float t_near[W];                              // not negative; a ray whose is meets nothing
    float direction_x[W], direction_y[W], direction_z[W];
    float time[W];
    float t_far[W];          // in: the end; out: of the nearest hit, or as it was
    std::uint32_t mask[W], id[W], flags[W];       // the query sets the mask
    // Written where something is hit. The point is (1 - u - v) a + u b + v c of the triangle's corners.
    float normal_x[W], normal_y[W], normal_z[W];  // (b - a) x (c - a), of any length
    float u[W], v[W];
    std::uint32_t triangle[W];                    // no_hit: nothing
    std::uint32_t geometry[W], instance[W];
};
inline constexpr std::uint32_t no_hit = 0xffffffff;

// Triangles are two-sided; where a material's alpha mask says that there is no surface, rays pass. Of triangles hit at
// the same t the lower index counts (exact; native promises nothing). Thread-safe.
class RayQuery {
  public:
    virtual ~RayQuery();

    // The nearest hit of each ray with active[lane] = -1; the others (0) are not touched. Sets `triangle` to no_hit
    // first.
    virtual void nearest(const std::int32_t* active, RayPacket<1>& rays) const = 0;
    virtual void nearest(const std::int32_t* active, RayPacket<4>& rays) const = 0;
    virtual void nearest(const std::int32_t* active, RayPacket<8>& rays) const = 0;
    virtual void nearest(const std::int32_t* active, RayPacket<16>& rays) const = 0;

    // Whether anything is hit: t_far becomes -infinity where it is. Reads nothing behind `flags`.
    virtual void occluded(const std::int32_t* active, RayPacket<1>& rays) const = 0;
    virtual void occluded(const std::int32_t* active, RayPacket<4>& rays) const = 0;
    virtual void occluded(const std::int32_t* active, RayPacket<8>& rays) const = 0;
    virtual void occluded(const std::int32_t* active, RayPacket<16>& rays) const = 0;
};

}  // namespace plumb
