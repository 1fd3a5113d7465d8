// Rays by our own triangle test, with Embree finding the triangles whose boxes a ray meets. See ray_query.h.
//
// The result is the least (t, index) among all triangles that the ray meets. It cannot depend on the order in which
// Embree visits them, so all that is to show is that the box of that triangle is never passed over. Embree compares
// planes at (p - o) / d with each other and with t_far. In its way without ROBUST, which user geometry always gets,
// that is p r - o r with r = 1 / d to about 2^-22: a plane seems moved by up to 2^-22 (|p| + |o|) + 2^-24 |o|. t,
// rounded to float, and the double test's own errors move the hit along an axis by at most 2^-24 (|p| + |o|). With M
// the scene's largest coordinate and |o| <= 2 M that is less than 2^-19.9 M in all, and boxes are padded by 2^-19 M, 16
// to 32 ULPs of M. A direction of 0 along an axis, which Embree replaces by 1e-18, is covered as well: the box has
// width there.
//
// A ray from farther away, or of a direction so long or short that 1e-18 counts, visits boxes by another ray: the same
// line, started where it enters the cube of +-M, of unit length, whose end is not drawn in as hits are found. The test
// itself takes the true ray.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/view.h"
#include "gi/reference/embree_scene.h"
#include "gi/reference/packet_query.h"
#include "gi/reference/triangle_test.h"

namespace plumb::reference {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float relative_padding = 0x1p-19f, largest_origin = 2, shortest = 1e-6f, longest = 1e6f;

// What the callbacks find behind Embree's context.
template <int W>
struct Packet {
    RTCIntersectContext context;
    ShearedRay ray[W];
};
struct Single {
    RTCIntersectContext context;
    ShearedRay ray;
    float t_near, t_far;  // t_far: of the nearest hit so far
    std::uint32_t triangle;
    float u, v;
    bool draws_in;  // whether Embree's ray ends at the nearest hit, too
};

template <int W>
ShearedRay shear_lane(const RayPacket<W>& rays, int i) {
    return shear(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i], rays.direction_x[i], rays.direction_y[i],
                 rays.direction_z[i]);
}

class ExactRays final : public PacketQuery<ExactRays> {
  public:
    ExactRays(const Geometry& g, const raster::Surfaces& surfaces, EmbreeDevice device)
        : PacketQuery(widest_packet(device.get())),
          masks_(raster::surface_args(g, surfaces, View{})),
          device_(std::move(device)) {
        copy_corners(g, surfaces);
        EmbreeGeometry user(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
        rtcSetGeometryUserPrimitiveCount(user.get(), unsigned(corners_.size()));
        rtcSetGeometryUserData(user.get(), this);
        rtcSetGeometryBoundsFunction(user.get(), bound, nullptr);
        rtcSetGeometryIntersectFunction(user.get(), intersected);
        rtcSetGeometryOccludedFunction(user.get(), occluding);
        scene_ = new_scene(device_.get());
        attach(scene_.get(), std::move(user));
        build(scene_.get());
    }

    template <int W>
    void trace_nearest(const std::int32_t* active, RayPacket<W>& rays) const {
        Packet<W> packet;
        if (start(active, rays, packet))
            intersect(active, scene_.get(), &packet.context, embree_hits(rays));
        else
            for (int i = 0; i < W; ++i)
                if (active[i]) trace_single(rays, i);
        for (int i = 0; i < W; ++i)
            if (active[i] && rays.triangle[i] != no_hit) complete(rays, i);
    }

    template <int W>
    void trace_occluded(const std::int32_t* active, RayPacket<W>& rays) const {
        Packet<W> packet;
        if (start(active, rays, packet))
            occlude(active, scene_.get(), &packet.context, embree_rays(rays));
        else
            for (int i = 0; i < W; ++i)
                if (active[i]) block_single(rays, i);
    }

  private:
    void copy_corners(const Geometry& g, const raster::Surfaces& surfaces) {
        corners_.resize(g.triangles.size());
        for (std::size_t i = 0; i < g.triangles.size(); ++i) {
            Corners& t = corners_[i];
            t.a[3] = surfaces.any_masked && surfaces.masked[std::size_t(g.material[i])] ? 1 : 0;
            float* corner[3] = {t.a, t.b, t.c};
            for (int k = 0; k < 3; ++k) {
                const glm::vec3& p = g.vertices[g.triangles[i][k]].position;
                for (int axis = 0; axis < 3; ++axis) corner[k][axis] = p[axis];
            }
            if (!has_area(t)) continue;
            for (const float* p : corner)
                for (int axis = 0; axis < 3; ++axis) largest_ = std::max(largest_, std::abs(p[axis]));
        }
    }
    // Not where a coordinate is so large that Embree takes no box, either.
    static bool has_area(const Corners& t) {
        for (const float* p : {t.a, t.b, t.c})
            for (int axis = 0; axis < 3; ++axis)
                if (!(std::abs(p[axis]) < 1e18f)) return false;
        const FaceNormal n = face_normal(t);
        return n.x != 0 || n.y != 0 || n.z != 0;
    }

    // Embree leaves out a triangle whose box is empty.
    static void bound(const RTCBoundsFunctionArguments* call) {
        const auto& self = *static_cast<const ExactRays*>(call->geometryUserPtr);
        const Corners& t = self.corners_[call->primID];
        const float padding = self.largest_ * relative_padding;
        float low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min({t.a[axis], t.b[axis], t.c[axis]}) - padding;
            high[axis] = std::max({t.a[axis], t.b[axis], t.c[axis]}) + padding;
        }
        RTCBounds& b = *call->bounds_o;
        b.lower_x = low[0], b.lower_y = low[1], b.lower_z = low[2];
        b.upper_x = high[0], b.upper_y = high[1], b.upper_z = high[2];
        if (!has_area(t)) b.lower_x = 1, b.upper_x = -1;
    }

    bool there(unsigned triangle, const TriangleHit& hit) const {
        return corners_[triangle].a[3] == 0 ||
               raster::passes_alpha<float>(masks_, std::int32_t(triangle), {hit.u, hit.v});
    }

    static void intersected(const RTCIntersectFunctionNArguments* call) {
        const auto& self = *static_cast<const ExactRays*>(call->geometryUserPtr);
        switch (call->N) {
            case 1:
                return self.intersect_single(call);
            case 4:
                return self.intersect_packet<4>(call);
            case 8:
                return self.intersect_packet<8>(call);
            case 16:
                return self.intersect_packet<16>(call);
        }
    }
    static void occluding(const RTCOccludedFunctionNArguments* call) {
        const auto& self = *static_cast<const ExactRays*>(call->geometryUserPtr);
        switch (call->N) {
            case 1:
                return self.occlude_single(call);
            case 4:
                return self.occlude_packet<4>(call);
            case 8:
                return self.occlude_packet<8>(call);
            case 16:
                return self.occlude_packet<16>(call);
        }
    }

    // Whether the rays are to be traced together. Embree takes a packet through user geometry until its last ray is
    // done, so it pays for rays alone that stay together: those of one origin. Same bits either way.
    template <int W>
    bool start(const std::int32_t* active, const RayPacket<W>& rays, Packet<W>& packet) const {
        if (W == 1) return false;
        int first = 0;
        while (!active[first]) ++first;
        for (int i = first; i < W; ++i) {
            const bool alike = rays.origin_x[i] == rays.origin_x[first] && rays.origin_y[i] == rays.origin_y[first] &&
                               rays.origin_z[i] == rays.origin_z[first];
            if (active[i] && (!alike || is_far(rays, i))) return false;
        }
        for (int i = first; i < W; ++i)
            if (active[i]) packet.ray[i] = shear_lane(rays, i);
        rtcInitIntersectContext(&packet.context);
        return true;
    }

    void intersect_single(const RTCIntersectFunctionNArguments* call) const {
        Single& s = *reinterpret_cast<Single*>(call->context);
        TriangleHit hit;
        if (!meets(s.ray, corners_[call->primID], hit) || !(hit.t > s.t_near)) return;
        if (!(hit.t < s.t_far || (hit.t == s.t_far && call->primID < s.triangle)) || !there(call->primID, hit)) return;
        s.t_far = hit.t, s.triangle = call->primID, s.u = hit.u, s.v = hit.v;
        if (s.draws_in) reinterpret_cast<RTCRayHit*>(call->rayhit)->ray.tfar = hit.t;
    }
    void occlude_single(const RTCOccludedFunctionNArguments* call) const {
        const Single& s = *reinterpret_cast<const Single*>(call->context);
        TriangleHit hit;
        if (!meets(s.ray, corners_[call->primID], hit) || !(hit.t > s.t_near && hit.t <= s.t_far)) return;
        if (there(call->primID, hit)) reinterpret_cast<RTCRay*>(call->ray)->tfar = -infinity;
    }

    template <int W>
    void intersect_packet(const RTCIntersectFunctionNArguments* call) const {
        const auto& packet = *reinterpret_cast<const Packet<W>*>(call->context);
        auto& rays = *reinterpret_cast<RayPacket<W>*>(call->rayhit);
        const Corners& corners = corners_[call->primID];
        for (int i = 0; i < W; ++i) {
            TriangleHit hit;
            if (!call->valid[i] || !meets(packet.ray[i], corners, hit) || !(hit.t > rays.t_near[i])) continue;
            const bool nearer = hit.t < rays.t_far[i] || (hit.t == rays.t_far[i] && call->primID < rays.triangle[i]);
            if (!nearer || !there(call->primID, hit)) continue;
            rays.t_far[i] = hit.t, rays.triangle[i] = call->primID, rays.u[i] = hit.u, rays.v[i] = hit.v;
        }
    }
    template <int W>
    void occlude_packet(const RTCOccludedFunctionNArguments* call) const {
        const auto& packet = *reinterpret_cast<const Packet<W>*>(call->context);
        auto& rays = *reinterpret_cast<typename EmbreePacket<W>::Ray*>(call->ray);
        const Corners& corners = corners_[call->primID];
        for (int i = 0; i < W; ++i) {
            TriangleHit hit;
            if (!call->valid[i] || !meets(packet.ray[i], corners, hit)) continue;
            if (hit.t > rays.tnear[i] && hit.t <= rays.tfar[i] && there(call->primID, hit)) rays.tfar[i] = -infinity;
        }
    }

    // Whether Embree's arithmetic on this very ray is not good enough. True for what is not finite.
    template <int W>
    bool is_far(const RayPacket<W>& rays, int i) const {
        const float origin =
            std::max({std::abs(rays.origin_x[i]), std::abs(rays.origin_y[i]), std::abs(rays.origin_z[i])});
        const float length =
            std::max({std::abs(rays.direction_x[i]), std::abs(rays.direction_y[i]), std::abs(rays.direction_z[i])});
        return !(origin <= largest_origin * largest_ && length >= shortest && length <= longest);
    }

    // The ray that Embree is given. False: it meets nothing.
    template <int W>
    bool traversed(const RayPacket<W>& rays, int i, Single& s, RTCRay& ray) const {
        const float o[3] = {rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]};
        const float d[3] = {rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]};
        rtcInitIntersectContext(&s.context);
        s.ray = shear_lane(rays, i);
        s.t_near = rays.t_near[i], s.t_far = rays.t_far[i], s.triangle = no_hit;
        s.draws_in = !is_far(rays, i);
        if (s.draws_in) {
            ray = {o[0], o[1], o[2], s.t_near, d[0], d[1], d[2], 0, s.t_far, 0xffffffff, 0, 0};
            return true;
        }
        const double length = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
        const double cube = 1.01 * largest_;
        double first = 0, last = std::numeric_limits<double>::infinity();
        float from[3], along[3];
        for (int axis = 0; axis < 3; ++axis) {
            const double direction = d[axis] / length;
            const double low = (-cube - o[axis]) / direction, high = (cube - o[axis]) / direction;
            if (direction == 0 ? !(std::abs(o[axis]) <= cube) : !(std::abs(direction) <= 1)) return false;
            if (direction == 0) continue;
            first = std::max(first, std::min(low, high)), last = std::min(last, std::max(low, high));
        }
        if (!(first <= last)) return false;
        for (int axis = 0; axis < 3; ++axis) {
            from[axis] = float(o[axis] + first * (d[axis] / length));
            along[axis] = float(d[axis] / length);
        }
        ray = {from[0], from[1], from[2], 0, along[0], along[1], along[2], 0, infinity, 0xffffffff, 0, 0};
        return true;
    }

    template <int W>
    void trace_single(RayPacket<W>& rays, int i) const {
        Single s;
        RTCRayHit ray;
        if (!traversed(rays, i, s, ray.ray)) return;
        intersect(nullptr, scene_.get(), &s.context, &ray);
        if (s.triangle == no_hit) return;
        rays.t_far[i] = s.t_far, rays.triangle[i] = s.triangle, rays.u[i] = s.u, rays.v[i] = s.v;
    }
    template <int W>
    void block_single(RayPacket<W>& rays, int i) const {
        Single s;
        RTCRay ray;
        if (!traversed(rays, i, s, ray)) return;
        occlude(nullptr, scene_.get(), &s.context, &ray);
        if (ray.tfar < 0) rays.t_far[i] = -infinity;
    }

    template <int W>
    void complete(RayPacket<W>& rays, int i) const {
        const FaceNormal n = face_normal(corners_[rays.triangle[i]]);
        rays.normal_x[i] = n.x, rays.normal_y[i] = n.y, rays.normal_z[i] = n.z;
        rays.geometry[i] = 0, rays.instance[i] = RTC_INVALID_GEOMETRY_ID;
    }

    raster::SurfaceArgs masks_;
    EmbreeDevice device_;
    Buffer<Corners> corners_;  // a[3]: 1 where the material has an alpha mask
    float largest_ = 0;        // coordinate of the triangles that have an area
    EmbreeScene scene_;
};

}  // namespace

std::unique_ptr<RayQuery> build_exact(const Geometry& geometry, const raster::Surfaces& surfaces, EmbreeDevice device) {
    return std::make_unique<ExactRays>(geometry, surfaces, std::move(device));
}

}  // namespace plumb::reference
