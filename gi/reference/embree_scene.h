// What both kinds of ray query share: Embree's device, scenes and packets. Private to gi/reference/*ray*.cpp.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>
#include <memory>
#include <string>

#include "core/ray_query.h"
#include "core/scene.h"
#include "raster/surfaces.h"

namespace plumb::reference {

struct ReleaseEmbree {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using EmbreeDevice = std::unique_ptr<RTCDeviceTy, ReleaseEmbree>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, ReleaseEmbree>;
using EmbreeGeometry = std::unique_ptr<RTCGeometryTy, ReleaseEmbree>;

// A device: "" is the one that the process shares, else a new one of this configuration. Both throw InputError with
// Embree's message.
EmbreeDevice retain_device(const std::string& config);
// A scene for rays: filled by attach(), then built, which throws InputError with Embree's message.
EmbreeScene new_scene(RTCDevice device);
void attach(RTCScene scene, EmbreeGeometry geometry);
void build(RTCScene scene);

// The widest packet that the device's instruction set traverses: 4, 8 or 16.
int widest_packet(RTCDevice device);

std::unique_ptr<RayQuery> build_native(const Geometry& geometry, const raster::Surfaces& surfaces, EmbreeDevice device);
std::unique_ptr<RayQuery> build_exact(const Geometry& geometry, const raster::Surfaces& surfaces, EmbreeDevice device);

template <int W>
struct EmbreePacket;
template <>
struct EmbreePacket<1> {
    using Hit = RTCRayHit;
    using Ray = RTCRay;
};
template <>
struct EmbreePacket<4> {
    using Hit = RTCRayHit4;
    using Ray = RTCRay4;
};
template <>
struct EmbreePacket<8> {
    using Hit = RTCRayHit8;
    using Ray = RTCRay8;
};
template <>
struct EmbreePacket<16> {
    using Hit = RTCRayHit16;
    using Ray = RTCRay16;
};

template <int W>
constexpr bool laid_out_as_embree() {
    using P = RayPacket<W>;
    using E = typename EmbreePacket<W>::Hit;
    constexpr std::size_t row = 4 * W;
    return sizeof(P) == sizeof(E) && alignof(P) == alignof(E) && offsetof(E, ray) == 0 &&
           offsetof(E, hit) == 12 * row && offsetof(P, origin_x) == 0 && offsetof(P, t_near) == 3 * row &&
           offsetof(P, direction_x) == 4 * row && offsetof(P, time) == 7 * row && offsetof(P, t_far) == 8 * row &&
           offsetof(P, mask) == 9 * row && offsetof(P, id) == 10 * row && offsetof(P, flags) == 11 * row &&
           offsetof(P, normal_x) == 12 * row && offsetof(P, normal_z) == 14 * row && offsetof(P, u) == 15 * row &&
           offsetof(P, v) == 16 * row && offsetof(P, triangle) == 17 * row && offsetof(P, geometry) == 18 * row &&
           offsetof(P, instance) == 19 * row;
}
static_assert(laid_out_as_embree<1>() && laid_out_as_embree<4>() && laid_out_as_embree<8>() &&
              laid_out_as_embree<16>());

template <int W>
auto* embree_hits(RayPacket<W>& rays) {
    return reinterpret_cast<typename EmbreePacket<W>::Hit*>(&rays);
}
template <int W>
auto* embree_rays(RayPacket<W>& rays) {
    return reinterpret_cast<typename EmbreePacket<W>::Ray*>(&rays);
}

// Embree's calls by width. `active` is aligned to its own size; not read for one ray.
inline void intersect(const int*, RTCScene s, RTCIntersectContext* c, RTCRayHit* r) { rtcIntersect1(s, c, r); }
inline void intersect(const int* a, RTCScene s, RTCIntersectContext* c, RTCRayHit4* r) { rtcIntersect4(a, s, c, r); }
inline void intersect(const int* a, RTCScene s, RTCIntersectContext* c, RTCRayHit8* r) { rtcIntersect8(a, s, c, r); }
inline void intersect(const int* a, RTCScene s, RTCIntersectContext* c, RTCRayHit16* r) { rtcIntersect16(a, s, c, r); }
inline void occlude(const int*, RTCScene s, RTCIntersectContext* c, RTCRay* r) { rtcOccluded1(s, c, r); }
inline void occlude(const int* a, RTCScene s, RTCIntersectContext* c, RTCRay4* r) { rtcOccluded4(a, s, c, r); }
inline void occlude(const int* a, RTCScene s, RTCIntersectContext* c, RTCRay8* r) { rtcOccluded8(a, s, c, r); }
inline void occlude(const int* a, RTCScene s, RTCIntersectContext* c, RTCRay16* r) { rtcOccluded16(a, s, c, r); }

}  // namespace plumb::reference
