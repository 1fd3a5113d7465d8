// What the rasterizer sees against what Embree's primary rays hit. The two may differ where the centre of a pixel is
// within half a subpixel of an edge, since corners are snapped to 1/256 pixel, and where two surfaces change places
// within half a subpixel or are nearer to each other than the depth buffer tells apart. Nowhere else.
#include <embree3/rtcore.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "core/camera.h"
#include "io/scenes/generate.h"
#include "raster/visibility.h"
#include "tests/raster/drawing.h"

namespace plumb::raster {
namespace {

constexpr double half_subpixel = 1.0 / 512;

struct Release {
    void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
    void operator()(RTCScene s) const { rtcReleaseScene(s); }
};

class Rays {
  public:
    explicit Rays(const Geometry& g) : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_.get())) {
        rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
        RTCGeometry mesh = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g.vertices.data(), 0,
                                   sizeof(Vertex), g.vertices.size());
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g.triangles.data(), 0,
                                   sizeof(glm::uvec3), g.triangles.size());
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_.get(), mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_.get());
    }
    // The first triangle that is hit; -1: none.
    int first_hit(const Ray& ray, double near, double far) const {
        RTCRayHit hit{};
        hit.ray = {float(ray.origin.x), float(ray.origin.y), float(ray.origin.z), float(near),
                   float(ray.direction.x), float(ray.direction.y), float(ray.direction.z), 0,
                   float(far), 0xffffffffu, 0, 0};
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_.get(), &context, &hit);
        return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1 : int(hit.hit.primID);
    }

  private:
    std::unique_ptr<RTCDeviceTy, Release> device_;
    std::unique_ptr<RTCSceneTy, Release> scene_;
};

// How the ray through a pixel's centre meets a triangle, in double: the least and the largest distance along rays that
// pass the centre within half a subpixel, which is how far snapping moves the triangle; and the distance in pixels from
// the centre to the nearest edge, negative outside. in_front: all corners are in front of the viewer, so that edges have
// a place on the screen.
struct Meeting {
    double t_low, t_high, pixels;
    bool in_front;
};
Meeting meet(const Geometry& g, int triangle, const Camera& camera, const View& view, glm::ivec2 size,
             glm::ivec2 pixel) {
    const glm::uvec3 index = g.triangles[std::size_t(triangle)];
    const glm::dmat4 m = view.world_to_clip();
    glm::dvec2 w[3];
    glm::dvec3 p[3];
    Meeting r{1e30, -1e30, 1e30, true};
    for (int i = 0; i < 3; ++i) {
        p[i] = glm::dvec3(g.vertices[index[i]].position);
        const glm::dvec4 c = m * glm::dvec4(p[i], 1);
        r.in_front = r.in_front && c.w > 1e-4;
        w[i] = {(c.x / c.w + 1) * 0.5 * size.x, (c.y / c.w + 1) * 0.5 * size.y};
    }
    const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
    const glm::dvec2 centre(pixel.x + 0.5, pixel.y + 0.5);
    for (int k = 0; k < 4; ++k) {
        const glm::dvec2 moved = centre + half_subpixel * glm::dvec2(k % 2 ? 1 : -1, k / 2 ? 1 : -1);
        const Ray ray = ray_through(camera, size, moved);
        const double t = test::dot(n, p[0] - ray.origin) / test::dot(n, ray.direction);
        r.t_low = std::min(r.t_low, t), r.t_high = std::max(r.t_high, t);
    }
    const double area = (w[1].x - w[0].x) * (w[2].y - w[0].y) - (w[1].y - w[0].y) * (w[2].x - w[0].x);
    for (int i = 0; i < 3; ++i) {
        const glm::dvec2 a = w[i], e = w[(i + 1) % 3] - a, d = centre - a;
        const double side = (e.x * d.y - e.y * d.x) * (area > 0 ? 1 : -1) / std::sqrt(e.x * e.x + e.y * e.y);
        r.pixels = std::min(r.pixels, side);
    }
    return r;
}

struct Tally {
    int same = 0, at_edge = 0, at_equal_depth = 0, at_viewer = 0, wrong = 0, seen = 0;
};

Tally compare(const Geometry& g, const Camera& camera, glm::ivec2 size) {
    const View view = make_view(camera, double(size.x) / size.y);
    const VisibilityBuffer drawn = draw_visibility(g, view, size, {});
    const Rays rays(g);
    Tally tally;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const Ray ray = ray_through_pixel(camera, size, {x, y});
            const double cosine = test::dot(ray.direction, view.forward);
            const int ours = drawn.triangle(x, y), theirs = rays.first_hit(ray, camera.near / cosine, camera.far / cosine);
            tally.seen += ours >= 0;
            if (ours == theirs) {
                ++tally.same;
                continue;
            }
            // One of the two has its edge here, or both are hit at the same place.
            bool edge = false, viewer = false;
            Meeting met[2];
            int k = 0;
            for (int triangle : {ours, theirs}) {
                if (triangle < 0) continue;
                const Meeting m = met[k++] = meet(g, triangle, camera, view, size, {x, y});
                edge = edge || std::fabs(m.pixels) <= std::sqrt(2.0) * half_subpixel * 1.01;
                viewer = viewer || !m.in_front;
            }
            // A depth buffer from 0 at the near plane to 1 resolves t^2 / near 2^-24 m; Embree's t has a few roundings.
            const double t = k == 2 ? std::fabs(met[0].t_low) : 0;
            const double slack = 4e-6 * t + (camera.reversed_z ? 0 : t * t / camera.near * 0x1p-24);
            const bool depth = k == 2 && met[0].t_low <= met[1].t_high + slack && met[1].t_low <= met[0].t_high + slack;
            if (edge)
                ++tally.at_edge;
            else if (depth)
                ++tally.at_equal_depth;
            else if (viewer)
                ++tally.at_viewer;
            else
                ++tally.wrong;
        }
    return tally;
}

void report(const char* name, const Tally& t) {
    WARN(name << ": " << t.seen << " pixels see something; same as Embree " << t.same << ", at an edge " << t.at_edge
              << ", at equal depth " << t.at_equal_depth << ", edge behind the viewer " << t.at_viewer << ", wrong "
              << t.wrong);
}

Geometry soup(int triangles, double extent, double size) {
    Geometry g;
    test::Random random(11);
    for (int i = 0; i < triangles; ++i) {
        const glm::vec3 c = random.vector(-extent, extent);
        auto corner = [&] { return test::at(c + random.vector(-size, size)); };
        const Vertex a = corner(), b = corner(), d = corner();
        test::add_triangle(g, a, b, d);
    }
    return g;
}

}  // namespace

TEST_CASE("visibility: a soup of triangles is seen as Embree's primary rays see it", "[raster][embree]") {
    Camera camera;
    camera.position = {0.3, 0.2, 6};
    camera.near = 0.05;
    for (const auto& [count, size] : {std::pair(3000, 0.8), std::pair(40000, 0.05), std::pair(200, 20.0)}) {
        const Tally t = compare(soup(count, 2, size), camera, {317, 231});
        report("soup", t);
        CHECK(t.wrong == 0);
        CHECK(t.seen > 10000);
        CHECK(t.at_edge + t.at_equal_depth + t.at_viewer < (t.same + t.at_edge) / 100);
    }
}

TEST_CASE("visibility: generated scenes are seen as Embree's primary rays see them", "[raster][embree]") {
    for (const io::GeneratedScene& entry : io::generated_scenes()) {
        const std::string name = entry.name;
        if (name == "stress") continue;  // its coincident triangles are the earlier one's, which Embree does not promise
        INFO(name);
        const Scene scene = io::generate_scene(name, {std::max(entry.least_triangles, std::min<std::int64_t>(entry.triangles, 30000)), 1}, "test");
        const Tally t = compare(flatten(scene), scene.camera, {320, 200});
        report(entry.name, t);
        CHECK(t.wrong == 0);
        CHECK(t.seen > (name == "character" ? 3000 : 10000));  // a figure that stands is narrow
        CHECK(t.at_edge < 640);
    }
}

}  // namespace plumb::raster
