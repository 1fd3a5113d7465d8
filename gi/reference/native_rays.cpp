// Rays by Embree's own triangles. See ray_query.h.
#include "core/view.h"
#include "gi/reference/embree_scene.h"
#include "gi/reference/packet_query.h"

namespace plumb::reference {
namespace {

// Embree reads 16 bytes where a corner has 12.
static_assert(offsetof(Vertex, position) + 16 <= sizeof(Vertex));

class NativeRays final : public PacketQuery<NativeRays> {
  public:
    NativeRays(const Geometry& g, const raster::Surfaces& surfaces, EmbreeDevice device)
        : PacketQuery(widest_packet(device.get())),
          masks_(raster::surface_args(g, surfaces, View{})),
          device_(std::move(device)) {
        EmbreeGeometry mesh(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        rtcSetSharedGeometryBuffer(mesh.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g.vertices.data(),
                                   offsetof(Vertex, position), sizeof(Vertex), g.vertices.size());
        rtcSetSharedGeometryBuffer(mesh.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g.triangles.data(), 0,
                                   sizeof(glm::uvec3), g.triangles.size());
        if (surfaces.any_masked) {
            rtcSetGeometryUserData(mesh.get(), &masks_);
            rtcSetGeometryIntersectFilterFunction(mesh.get(), pass);
            rtcSetGeometryOccludedFilterFunction(mesh.get(), pass);
        }
        scene_ = build_scene(device_.get(), std::move(mesh));
    }

    template <int W>
    void trace_nearest(const std::int32_t* active, RayPacket<W>& rays) const {
        for (int i = 0; i < W; ++i) {
            rays.mask[i] = active[i] ? 0xffffffff : rays.mask[i];
            rays.triangle[i] = active[i] ? no_hit : rays.triangle[i];
            rays.geometry[i] = active[i] ? RTC_INVALID_GEOMETRY_ID : rays.geometry[i];
        }
        if (W == 1 && !active[0]) return;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        intersect(active, scene_.get(), &context, embree_hits(rays));
    }
    template <int W>
    void trace_occluded(const std::int32_t* active, RayPacket<W>& rays) const {
        for (int i = 0; i < W; ++i) rays.mask[i] = active[i] ? 0xffffffff : rays.mask[i];
        if (W == 1 && !active[0]) return;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        occlude(active, scene_.get(), &context, embree_rays(rays));
    }

  private:
    // Takes back the hits where a mask says that there is no surface.
    static void pass(const RTCFilterFunctionNArguments* call) {
        const auto& masks = *static_cast<const raster::SurfaceArgs*>(call->geometryUserPtr);
        for (unsigned i = 0; i < call->N; ++i) {
            if (!call->valid[i]) continue;
            const auto triangle = std::int32_t(RTCHitN_primID(call->hit, call->N, i));
            const vec2<float> l{RTCHitN_u(call->hit, call->N, i), RTCHitN_v(call->hit, call->N, i)};
            if (!raster::passes_alpha<float>(masks, triangle, l)) call->valid[i] = 0;
        }
    }

    raster::SurfaceArgs masks_;
    EmbreeDevice device_;
    EmbreeScene scene_;
};

}  // namespace

std::unique_ptr<RayQuery> build_native(const Geometry& geometry, const raster::Surfaces& surfaces,
                                       EmbreeDevice device) {
    return std::make_unique<NativeRays>(geometry, surfaces, std::move(device));
}

}  // namespace plumb::reference
