// A ray query for packets of every width, of one written for the widths that the processor traverses. Private to
// gi/reference/*rays.cpp.
#pragma once

#include <cstring>

#include "core/ray_query.h"

namespace plumb::reference {

// Derived has trace_nearest<W>(active, rays) and trace_occluded<W>(active, rays), const; `active` is
// aligned to its own size. A packet wider than widest() is traced in halves: Embree's own way of doing so reads no mask.
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
        if (W > 4 && W > widest_)
            halve<W>(active, rays, 20, [&](auto* a, auto& half) { find(a, half); });
        else
            aligned<W>(active, [&](auto* a) { self().template trace_nearest<W>(a, rays); });
    }
    template <int W>
    void block(const std::int32_t* active, RayPacket<W>& rays) const {
        if (W > 4 && W > widest_)
            halve<W>(active, rays, 12, [&](auto* a, auto& half) { block(a, half); });
        else
            aligned<W>(active, [&](auto* a) { self().template trace_occluded<W>(a, rays); });
    }

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

    template <int W, class Body>
    static void aligned(const std::int32_t* active, const Body& body) {
        if (reinterpret_cast<std::uintptr_t>(active) % (4 * W) == 0) return body(active);
        alignas(64) std::int32_t copy[W];
        std::memcpy(copy, active, sizeof copy);
        body(static_cast<const std::int32_t*>(copy));
    }

    const Derived& self() const { return static_cast<const Derived&>(*this); }
    int widest_;
};

}  // namespace plumb::reference
