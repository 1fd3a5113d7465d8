#include "gi/reference/ray_query.h"

#include <new>
#include <utility>

#include "core/error.h"
#include "gi/reference/embree_scene.h"
#include "gi/reference/ray_device.h"

namespace plumb::reference {
namespace {

// Embree reports to the thread that called it.
thread_local std::string failure;

[[noreturn]] void refuse(const std::string& cause) { throw InputError("rays: Embree: " + cause); }

EmbreeDevice new_device(const std::string& config) {
    EmbreeDevice device(rtcNewDevice(config.c_str()));
    if (!device) refuse("no device for the configuration '" + config + "'");
    rtcSetDeviceErrorFunction(
        device.get(), [](void*, RTCError, const char* message) { failure = message ? message : "unknown error"; },
        nullptr);
    return device;
}

}  // namespace

EmbreeDevice retain_device(const std::string& config) {
    if (!config.empty()) return new_device(config);
    static const EmbreeDevice shared = new_device("");
    rtcRetainDevice(shared.get());
    return EmbreeDevice(shared.get());
}

int widest_packet(RTCDevice device) {
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
    return rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8 : 4;
}

EmbreeScene new_scene(RTCDevice device) {
    EmbreeScene scene(rtcNewScene(device));
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    return scene;
}

void attach(RTCScene scene, EmbreeGeometry geometry) {
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene, geometry.get());
}

void build(RTCScene scene) {
    rtcCommitScene(scene);
    if (!failure.empty()) refuse(std::exchange(failure, {}));
}

std::unique_ptr<RayQuery> build_ray_query(const Geometry& geometry, const raster::Surfaces& surfaces, Rays rays,
                                          const std::string& config) {
    failure.clear();
    EmbreeDevice device = retain_device(config);
    try {
        return rays == Rays::exact ? build_exact(geometry, surfaces, std::move(device))
                                   : build_native(geometry, surfaces, std::move(device));
    } catch (const std::bad_alloc&) {
        throw InputError("rays: out of memory for " + std::to_string(geometry.triangles.size()) + " triangles");
    }
}

std::string embree_version() {
    const EmbreeDevice device = retain_device("");
    auto number = [&](RTCDeviceProperty which) { return std::to_string(rtcGetDeviceProperty(device.get(), which)); };
    return number(RTC_DEVICE_PROPERTY_VERSION_MAJOR) + "." + number(RTC_DEVICE_PROPERTY_VERSION_MINOR) + "." +
           number(RTC_DEVICE_PROPERTY_VERSION_PATCH);
}

std::unique_ptr<RayQuery> build_ray_query(const Geometry& geometry, const raster::Surfaces& surfaces, Rays rays) {
    return build_ray_query(geometry, surfaces, rays, "");
}

}  // namespace plumb::reference
