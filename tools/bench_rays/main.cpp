// The speed of rays: bare calls of Embree against RayQuery, native and exact, the same rays on the same instruction
// set.
#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <memory>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/reference/ray_query.h"
#include "tools/bench_raster/measure.h"
#include "tools/bench_rays/rays.h"

namespace plumb::bench {
namespace {

// A scene as a program would give it to Embree itself.
class BareScene {
  public:
    explicit BareScene(const Geometry& g) : device_(rtcNewDevice("")), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g.vertices.data(), 0,
                                   sizeof(Vertex), g.vertices.size());
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g.triangles.data(), 0,
                                   sizeof(glm::uvec3), g.triangles.size());
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_);
    }
    ~BareScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareScene(const BareScene&) = delete;

    template <int W>
    bool takes() const {
        return W <= 4 || rtcGetDeviceProperty(device_, W == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                              : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED);
    }
    using Active = const std::int32_t*;
    void nearest(Active, RayPacket<1>& r) const { rtcIntersect1(scene_, context(), as<RTCRayHit>(r)); }
    void nearest(Active a, RayPacket<8>& r) const { rtcIntersect8(a, scene_, context(), as<RTCRayHit8>(r)); }
    void nearest(Active a, RayPacket<16>& r) const { rtcIntersect16(a, scene_, context(), as<RTCRayHit16>(r)); }
    void occluded(Active, RayPacket<1>& r) const { rtcOccluded1(scene_, context(), as<RTCRay>(r)); }
    void occluded(Active a, RayPacket<8>& r) const { rtcOccluded8(a, scene_, context(), as<RTCRay8>(r)); }
    void occluded(Active a, RayPacket<16>& r) const { rtcOccluded16(a, scene_, context(), as<RTCRay16>(r)); }

  private:
    template <class To, class From>
    static To* as(From& rays) {
        return reinterpret_cast<To*>(&rays);
    }
    static RTCIntersectContext* context() {
        static thread_local RTCIntersectContext context = [] {
            RTCIntersectContext c;
            rtcInitIntersectContext(&c);
            return c;
        }();
        return &context;
    }
    RTCDevice device_;
    RTCScene scene_;
};

template <int W>
std::vector<RayPacket<W>> packets_of(const std::vector<BenchRay>& rays) {
    std::vector<RayPacket<W>> packets(rays.size() / W);
    for (std::size_t k = 0; k < packets.size() * W; ++k) {
        RayPacket<W>& p = packets[k / W];
        const int i = int(k % W);
        const BenchRay& r = rays[k];
        p.origin_x[i] = r.origin.x, p.origin_y[i] = r.origin.y, p.origin_z[i] = r.origin.z;
        p.direction_x[i] = r.direction.x, p.direction_y[i] = r.direction.y, p.direction_z[i] = r.direction.z;
        p.t_near[i] = r.t_near, p.t_far[i] = r.t_far, p.time[i] = 0;
        p.mask[i] = 0xffffffff, p.id[i] = p.flags[i] = 0;
        p.triangle[i] = p.geometry[i] = p.instance[i] = no_hit;
    }
    return packets;
}

// Milliseconds to trace all packets; a copy of each, so that the next run finds them as they were.
template <bool shadow, int W, class Side>
double run(const Side& side, const std::vector<RayPacket<W>>& packets, int threads) {
    alignas(64) static constexpr std::int32_t active[16] = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                            -1, -1, -1, -1, -1, -1, -1, -1};
    return clock_ms([&] {
        parallel_bands(int(packets.size()), 4096 / W, threads, [&](int first, int last) {
            for (int i = first; i < last; ++i) {
                RayPacket<W> rays = packets[std::size_t(i)];
                if constexpr (shadow)
                    side.occluded(active, rays);
                else
                    side.nearest(active, rays);
            }
        });
    });
}

struct Contest {
    const BareScene& bare;
    const RayQuery &native, &exact;
    int runs;
};

template <bool shadow, int W>
void measure(const Contest& c, const std::string& what, const std::vector<BenchRay>& rays, int threads) {
    if (!c.bare.takes<W>()) return;
    const std::vector<RayPacket<W>> packets = packets_of<W>(rays);
    const std::vector<Times> times = interleave(c.runs, {[&] { return run<shadow>(c.bare, packets, threads); },
                                                         [&] { return run<shadow>(c.native, packets, threads); },
                                                         [&] { return run<shadow>(c.exact, packets, threads); }});
    // By processor time: whoever else computes meanwhile falls on no side.
    const auto speed = [&](int i) { return double(packets.size() * W) / (times[std::size_t(i)].cpu_median() * 1e3); };
    fmt::print("| {} | {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.3f} | {:.3f} |\n", what, W, threads, speed(0), speed(1),
               speed(2), speed(1) / speed(0), speed(2) / speed(1));
    std::fflush(stdout);
}

template <bool shadow>
void measure_widths(const Contest& c, const std::string& what, const std::vector<BenchRay>& rays, int threads) {
    measure<shadow, 1>(c, what, rays, threads);
    measure<shadow, 8>(c, what, rays, threads);
    measure<shadow, 16>(c, what, rays, threads);
}

void measure_world(const std::string& name, glm::ivec2 size, int runs, const std::vector<int>& threads) {
    const World world = load_world(name, PLUMB_SOURCE_DIR);
    const RaySet rays = make_rays(world, size);
    const BareScene bare(world.geometry);
    const auto native = reference::build_ray_query(world.geometry, world.surfaces, Rays::native);
    const auto exact = reference::build_ray_query(world.geometry, world.surfaces, Rays::exact);
    const Contest contest{bare, *native, *exact, runs};
    for (const int n : threads) {
        measure_widths<false>(contest, name + " primary", rays.primary, n);
        measure_widths<false>(contest, name + " bounce", rays.bounce, n);
        measure_widths<true>(contest, name + " shadow", rays.shadow, n);
    }
}

}  // namespace
}  // namespace plumb::bench

int main(int argc, char** argv) {
    using namespace plumb;
    std::vector<std::string> scenes{"cornell", "atrium", "atrium+masks", "city"};
    std::vector<int> threads{1, 2};
    glm::ivec2 size(512, 384);
    int runs = 7;
    CLI::App app("Measures rays: bare Embree calls against RayQuery, native and exact", "tools/bench rays");
    app.add_option("--scenes", scenes, "cornell, atrium+masks and generated scenes (cornell,atrium,atrium+masks,city)")
        ->delimiter(',');
    app.add_option("--threads", threads, "(1,2)")->delimiter(',')->check(CLI::Range(1, 1024));
    app.add_option("--width", size.x, "of the camera's frame (512)")->check(CLI::Range(4, 8192));
    app.add_option("--height", size.y, "of the camera's frame (384)")->check(CLI::Range(4, 8192));
    app.add_option("--runs", runs, "of each side, in turns; medians are shown (7)")->check(CLI::Range(1, 1000));
    CLI11_PARSE(app, argc, argv);
    try {
        fmt::print(
            "| rays | packet | threads | bare, million rays a second of a processor | native | exact | native / bare | "
            "exact / native |\n"
            "|---|---|---|---|---|---|---|---|\n");
        for (const std::string& name : scenes) bench::measure_world(name, size, runs, threads);
        return 0;
    } catch (const InputError& error) {
        std::cerr << "bench rays: " << error.what() << "\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "bench rays: " << error.what() << "\n";
        return 1;
    }
}
