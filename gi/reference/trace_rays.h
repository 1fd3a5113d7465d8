// Rays of a packet of lanes: between the kernels' numbers and core/ray_query.h.
#pragma once

#include <type_traits>

#include "core/number.h"
#include "core/ray_query.h"

namespace plumb::reference {

// Lane k of x lies at p[k].
template <class F>
PLUMB_INLINE void store_lanes(float* p, const F& x) {
    if constexpr (std::is_same_v<F, double>)
        *p = float(x);
    else
        std::memcpy(p, &x, number<F>::width * sizeof(float));
}
template <class I, class T>
PLUMB_INLINE void copy_lanes(T* p, const I& x) {
    static_assert(sizeof(T) == 4);
    std::memcpy(p, &x, sizeof x);
}
template <class F>
PLUMB_INLINE F load_lanes(const float* p) {
    if constexpr (std::is_same_v<F, double>) return *p;
    F x;
    std::memcpy(&x, p, number<F>::width * sizeof(float));
    return x;
}

template <class F>
struct RayHit {
    mask_t<F> found;
    F t;                  // in units of the direction's length; 0 where nothing is found
    index_t<F> triangle;  // 0 where nothing is found
    vec2<F> barycentrics;
};

// One packet that is used again and again.
template <class F>
class RayTracer {
    using I = index_t<F>;
    static constexpr int width = number<F>::width;

  public:
    explicit RayTracer(const RayQuery& query) : query_(query) {
        for (int k = 0; k < width; ++k) packet_.time[k] = 0, packet_.id[k] = packet_.flags[k] = 0;
    }

    // The nearest triangle on origin + t direction, 0 < t < t_far.
    PLUMB_INLINE RayHit<F> nearest(const vec3<F>& origin, const vec3<F>& direction, const mask_t<F>& active) {
        set(origin, direction, F(0.0f), F(__builtin_inff()), active);
        query_.nearest(active_, packet_);
        I triangle;
        std::memcpy(&triangle, packet_.triangle, sizeof triangle);
        RayHit<F> hit;
        hit.found = active & !(triangle == I(-1));
        hit.triangle = select(hit.found, triangle, I(0));
        hit.t = select(hit.found, load_lanes<F>(packet_.t_far), F(0.0f));
        hit.barycentrics = {select(hit.found, load_lanes<F>(packet_.u), F(0.0f)),
                            select(hit.found, load_lanes<F>(packet_.v), F(0.0f))};
        return hit;
    }

    // Whether nothing lies between.
    PLUMB_INLINE mask_t<F> visible(const vec3<F>& origin, const vec3<F>& direction, F t_far, const mask_t<F>& active) {
        set(origin, direction, F(0.0f), t_far, active);
        query_.occluded(active_, packet_);
        return active & !(load_lanes<F>(packet_.t_far) < F(0.0f));
    }

  private:
    PLUMB_INLINE void set(const vec3<F>& origin, const vec3<F>& direction, F t_near, F t_far, const mask_t<F>& active) {
        store_lanes(packet_.origin_x, origin.x);
        store_lanes(packet_.origin_y, origin.y);
        store_lanes(packet_.origin_z, origin.z);
        store_lanes(packet_.direction_x, direction.x);
        store_lanes(packet_.direction_y, direction.y);
        store_lanes(packet_.direction_z, direction.z);
        store_lanes(packet_.t_near, t_near);
        store_lanes(packet_.t_far, t_far);
        copy_lanes(active_, select(active, I(-1), I(0)));
    }

    const RayQuery& query_;
    RayPacket<width> packet_;
    alignas(64) std::int32_t active_[width];
};

}  // namespace plumb::reference
