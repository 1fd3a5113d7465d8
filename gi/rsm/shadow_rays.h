// Shadow rays of a kernel: whether shading points see pixel lights, a packet of lanes at a time.
#pragma once

#include <cstdint>
#include <cstring>

#include "core/number.h"
#include "core/ray_query.h"

namespace plumb::rsm {

// How far a ray keeps off the two surfaces that it runs between, m: no less than their positions may be wrong by.
struct RayOffsets {
    float receiver = 0, texel = 0;
};

// F is float or the packet of the instruction set.
template <class F>
struct ShadowRays {
    static constexpr int width = number<F>::width;
    using I = index_t<F>;

    const RayQuery& query;
    RayOffsets offsets;
    std::uint64_t traced = 0;
    alignas(64) std::int32_t active[width];
    RayPacket<width> packet;

    ShadowRays(const RayQuery& rays, RayOffsets offsets) : query(rays), offsets(offsets) {
        std::memset(&packet, 0, sizeof packet);
        std::memset(packet.mask, 0xff, sizeof packet.mask);
    }

    // Lanes of `wanted` whose x sees x_p, distance2 = |x_p - x|^2 apart. The ray runs from above x to above x_p, along
    // their normals, and leaves out both ends of its length, so that neither a surface that meets x's at an edge nor
    // rounding of x itself hides the light. Surfaces closer than that see each other.
    PLUMB_INLINE mask_t<F> visible(const vec3<F>& x, const vec3<F>& n, const vec3<F>& x_p, const vec3<F>& n_p,
                                   F distance2, const mask_t<F>& wanted) {
        const vec3<F> start = x + n * F(offsets.receiver), end = x_p + n_p * F(offsets.texel);
        const F inverse = F(1.0f) / sqrt(distance2);
        const F t_near = F(offsets.receiver) * inverse, t_far = F(1.0f) - F(offsets.texel) * inverse;
        const mask_t<F> open = wanted & (t_near < t_far);
        if (!any(open)) return wanted;

        put(packet.origin_x, start.x), put(packet.origin_y, start.y), put(packet.origin_z, start.z);
        put(packet.direction_x, end.x - start.x);
        put(packet.direction_y, end.y - start.y);
        put(packet.direction_z, end.z - start.z);
        put(packet.t_near, t_near), put(packet.t_far, t_far);
        put(active, select(open, I(-1), I(0)));
        for (int k = 0; k < width; ++k) traced += std::uint64_t(active[k] & 1);
        query.occluded(active, packet);

        F ends;
        std::memcpy(&ends, packet.t_far, sizeof ends);
        return wanted & !(open & (ends < F(0.0f)));
    }

  private:
    template <class T, class V>
    static PLUMB_INLINE void put(T* lanes, const V& value) {
        static_assert(sizeof(V) == sizeof(T) * width);
        std::memcpy(lanes, &value, sizeof value);
    }
};

}  // namespace plumb::rsm
