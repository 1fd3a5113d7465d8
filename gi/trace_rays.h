// Rays of a packet of lanes: between the kernels' numbers and core/ray_query.h. Only kernel files include it.
#pragma once

#include <cstring>
#include <type_traits>

#include "core/number.h"
#include "core/ray_query.h"

namespace plumb {

template <class F>
struct RayHit {
    mask_t<F> found;
    F t;                  // in units of the direction's length; 0 where nothing is found
    index_t<F> triangle;  // 0 where nothing is found
    vec2<F> barycentrics;
};

// One packet that is used again and again, and how many rays went through it.
template <class F>
class RayTracer {
    using I = index_t<F>;
    static constexpr int width = number<F>::width;

  public:
    explicit RayTracer(const RayQuery& query) : query_(query) {
        for (int k = 0; k < width; ++k) packet_.time[k] = 0, packet_.id[k] = packet_.flags[k] = 0;
    }

    // The nearest triangle on origin + t direction, t > 0.
    PLUMB_INLINE RayHit<F> nearest(const vec3<F>& origin, const vec3<F>& direction, const mask_t<F>& active) {
        return nearest(origin, direction, F(0.0f), active);
    }
    // The same, t > t_near.
    PLUMB_INLINE RayHit<F> nearest(const vec3<F>& origin, const vec3<F>& direction, F t_near, const mask_t<F>& active) {
        set(origin, direction, t_near, F(__builtin_inff()), active);
        query_.nearest(active_, packet_);
        I triangle;
        std::memcpy(&triangle, packet_.triangle, sizeof triangle);
        RayHit<F> hit;
        hit.found = active & !(triangle == I(-1));
        hit.triangle = select(hit.found, triangle, I(0));
        hit.t = select(hit.found, get(packet_.t_far), F(0.0f));
        hit.barycentrics = {select(hit.found, get(packet_.u), F(0.0f)), select(hit.found, get(packet_.v), F(0.0f))};
        return hit;
    }

    // Active lanes whose ray meets nothing for t_near < t <= t_far.
    PLUMB_INLINE mask_t<F> visible(const vec3<F>& origin, const vec3<F>& direction, F t_near, F t_far,
                                   const mask_t<F>& active) {
        set(origin, direction, t_near, t_far, active);
        query_.occluded(active_, packet_);
        return active & !(get(packet_.t_far) < F(0.0f));
    }

    std::uint64_t traced() const { return traced_; }

  private:
    PLUMB_INLINE void set(const vec3<F>& origin, const vec3<F>& direction, F t_near, F t_far, const mask_t<F>& active) {
        put(packet_.origin_x, origin.x), put(packet_.origin_y, origin.y), put(packet_.origin_z, origin.z);
        put(packet_.direction_x, direction.x), put(packet_.direction_y, direction.y);
        put(packet_.direction_z, direction.z);
        put(packet_.t_near, t_near), put(packet_.t_far, t_far);
        const I lanes = select(active, I(-1), I(0));
        std::memcpy(active_, &lanes, sizeof lanes);
        for (const std::int32_t lane : active_) traced_ += std::uint64_t(lane & 1);
    }

    // Lane k of x lies at p[k].
    static PLUMB_INLINE void put(float* p, const F& x) {
        if constexpr (std::is_same_v<F, double>)
            *p = float(x);
        else
            std::memcpy(p, &x, width * sizeof(float));
    }
    static PLUMB_INLINE F get(const float* p) {
        if constexpr (std::is_same_v<F, double>) return *p;
        F x;
        std::memcpy(&x, p, width * sizeof(float));
        return x;
    }

    const RayQuery& query_;
    std::uint64_t traced_ = 0;
    RayPacket<width> packet_;
    alignas(64) std::int32_t active_[width];
};

}  // namespace plumb
