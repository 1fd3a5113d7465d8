// A ray query for packets of every width, of one written for the widths that the processor traverses. Private to
// gi/reference/*rays.cpp.
#pragma once

#include <cmath>
#include <cstring>

#include "core/ray_query.h"

namespace plumb::reference {

// Derived has trace_nearest<W>(active, rays) and trace_occluded<W>(active, rays), const. What they are given: `active`
// is aligned to its own size and 0 where a ray is not finite; `mask` is set, and nothing is hit yet. A packet wider
// than widest() is traced in halves: Embree's own way of doing so reads no mask.
template <class Derived>
class PacketQuery : public RayQuery {
  public:
    void nearest(const std::int32_t* active, RayPacket<1>& rays) const final { find(active, rays); }
    void nearest(const std::int32_t* active, RayPacket<4>& rays) const final { find(active, rays); }
    void nearest(const std::int32_t* active, RayPacket<8>& rays) const final { find(active, rays); }
    void nearest(const std::int32_t* active, RayPacket<16>& rays) const final { find(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<1>& rays) const final { block(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<4>& rays) const final { block(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<8>& rays) const final { block(active, rays); }
    void occluded(const std::int32_t* active, RayPacket<16>& rays) const final { block(active, rays); }

  protected:
    explicit PacketQuery(int widest) : widest_(widest) {}

  private:
    template <int W>
    void find(const std::int32_t* active, RayPacket<W>& rays) const {
        if (W > 4 && W > widest_) return halve(active, rays, 20, [&](auto* a, auto& half) { find(a, half); });
        alignas(4 * W) std::int32_t usable[W];
        for (int i = 0; i < W; ++i) {
            rays.triangle[i] = active[i] ? no_hit : rays.triangle[i];
            rays.geometry[i] = active[i] ? no_hit : rays.geometry[i];
        }
        if (prepare(active, rays, usable)) self().trace_nearest(usable, rays);
    }
    template <int W>
    void block(const std::int32_t* active, RayPacket<W>& rays) const {
        if (W > 4 && W > widest_) return halve(active, rays, 12, [&](auto* a, auto& half) { block(a, half); });
        alignas(4 * W) std::int32_t usable[W];
        if (prepare(active, rays, usable)) self().trace_occluded(usable, rays);
    }

    // Leaves out rays that Embree does not take: those hit nothing. False where none is left.
    template <int W>
    static bool prepare(const std::int32_t* active, RayPacket<W>& rays, std::int32_t* usable) {
        std::int32_t any = 0;
        for (int i = 0; i < W; ++i) {
            const int finite = is_coordinate(rays.origin_x[i]) & is_coordinate(rays.origin_y[i]) &
                               is_coordinate(rays.origin_z[i]) & is_coordinate(rays.direction_x[i]) &
                               is_coordinate(rays.direction_y[i]) & is_coordinate(rays.direction_z[i]);
            const int range = int(rays.t_near[i] >= 0) & int(rays.t_far[i] >= rays.t_near[i]);
            usable[i] = (finite & range) != 0 ? active[i] : 0;
            rays.mask[i] = active[i] ? 0xffffffff : rays.mask[i];
            any |= usable[i];
        }
        return any != 0;
    }

    // By Embree's bound.
    static int is_coordinate(float x) { return std::abs(x) <= 1.844e18f; }

    // Moves the packet's first `rows` arrays through packets of half the width.
    template <int W, class Body>
    static void halve(const std::int32_t* active, RayPacket<W>& rays, int rows, const Body& body) {
        constexpr int half = W >= 8 ? W / 2 : W;
        auto* whole = reinterpret_cast<char*>(&rays);
        for (int side = 0; side < 2; ++side) {
            RayPacket<half> part;
            auto* copy = reinterpret_cast<char*>(&part);
            for (int row = 0; row < rows; ++row)
                std::memcpy(copy + row * 4 * half, whole + row * 4 * W + side * 4 * half, 4 * half);
            body(active + side * half, part);
            for (int row = 0; row < rows; ++row)
                std::memcpy(whole + row * 4 * W + side * 4 * half, copy + row * 4 * half, 4 * half);
        }
    }

    const Derived& self() const { return static_cast<const Derived&>(*this); }
    int widest_;
};

}  // namespace plumb::reference
