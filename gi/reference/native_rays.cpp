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
        scene_ = new_scene(device_.get());
        if (surfaces.any_masked) {
            split(g, surfaces);
            attach(g, plain_, false);
            attach(g, masked_, true);
        } else {
            attach(g, g.triangles, false);
        }
        build(scene_.get());
    }

    template <int W>
    void trace_nearest(const std::int32_t* active, RayPacket<W>& rays) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        intersect(active, scene_.get(), &context, embree_hits(rays));
    }
    template <int W>
    void trace_occluded(const std::int32_t* active, RayPacket<W>& rays) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        occlude(active, scene_.get(), &context, embree_rays(rays));
    }

  private:
    // Of all triangles twice: those without a mask, and those with one. The others name corners that do not exist, so
    // Embree leaves them out; a filter that it calls for every hit would cost a third of the speed.
    void split(const Geometry& g, const raster::Surfaces& surfaces) {
        plain_ = masked_ = g.triangles;
        for (std::size_t i = 0; i < g.triangles.size(); ++i)
            (surfaces.masked[std::size_t(g.material[i])] ? plain_ : masked_)[i] = glm::uvec3(no_hit);
    }
    void attach(const Geometry& g, const std::vector<glm::uvec3>& triangles, bool masked) {
        EmbreeGeometry mesh(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        rtcSetSharedGeometryBuffer(mesh.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g.vertices.data(),
                                   offsetof(Vertex, position), sizeof(Vertex), g.vertices.size());
        rtcSetSharedGeometryBuffer(mesh.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                                   sizeof(glm::uvec3), triangles.size());
        if (masked) {
            rtcSetGeometryUserData(mesh.get(), &masks_);
            rtcSetGeometryIntersectFilterFunction(mesh.get(), pass);
            rtcSetGeometryOccludedFilterFunction(mesh.get(), pass);
        }
        plumb::reference::attach(scene_.get(), std::move(mesh));
    }

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
    std::vector<glm::uvec3> plain_, masked_;  // empty where nothing has a mask
    EmbreeDevice device_;
    EmbreeScene scene_;
};

}  // namespace

std::unique_ptr<RayQuery> build_native(const Geometry& geometry, const raster::Surfaces& surfaces,
                                       EmbreeDevice device) {
    return std::make_unique<NativeRays>(geometry, surfaces, std::move(device));
}

}  // namespace plumb::reference
