#include "tools/bench_raster/hemicubes.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "core/error.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/rows.h"
#include "io/scenes/generate.h"
#ifdef PLUMB_WITH_VULKAN
#include "tools/bench_raster/peer.h"
#include "tools/vulkan/device.h"
#endif

namespace plumb::bench {

namespace {

constexpr int hemicube = 64, vertices_of_peer = 100, faces = 5;

#ifdef PLUMB_WITH_VULKAN
// The top as a square picture, sides as pictures half as high that look a little up, as those of a hemicube do.
View face_view(const glm::vec4* eye, int face, float offset, glm::ivec2 size) {
    const glm::dvec3 at(eye[0]), u(eye[1]), t(eye[2]), n(eye[3]);
    const glm::dvec3 sides[] = {n, u, -u, t, -t};
    Camera camera;
    camera.position = at;
    camera.look_at = at + sides[face] + (face == 0 ? glm::dvec3(0) : 0.5 * n);
    camera.up = face == 0 ? u : n;
    camera.fov_y_deg = face == 0 ? 90 : 50;
    camera.near = 0.5 * double(offset), camera.far = 100;
    return make_view(camera, double(size.x) / size.y);
}

// Milliseconds of five pictures, the median over vertices.
Times peer_times(const Scene& scene, const radiosity::Elements& e, const Options& options) {
    const vulkan::Device device({.name = "llvmpipe"});
    Peer peer(device, scene, flatten(scene));
    const Buffer<glm::vec4> eyes = radiosity::eyes_of(e.eye, e.normal);
    Times times;
    const int step = std::max(1, e.count() / (options.quick ? 4 : vertices_of_peer));
    for (int i = 0; i < e.count(); i += step) {
        double ms = 0;
        for (int face = 0; face < faces; ++face) {
            const glm::ivec2 size(hemicube, face == 0 ? hemicube : hemicube / 2);
            peer.set_view(face_view(&eyes[4 * std::size_t(i)], face, e.eye[std::size_t(i)].w, size), size);
            peer.draw();  // once to warm it
            ms += peer.draw();
        }
        times.ms.push_back(ms);
    }
    return times;
}
#else
Times peer_times(const Scene&, const radiosity::Elements&, const Options&) { throw InputError("--against lavapipe: built without Vulkan"); }
#endif

}  // namespace

void compare_hemicubes(const Options& options) {
    io::GenerateOptions generate;
    generate.triangles = options.quick ? 1200 : 30000;
    const Scene scene = io::generate_scene("hemicube_box", generate, "bench");
    radiosity::ElementParams p;
    p.of_file = true, p.inset = false;
    const radiosity::Elements e = radiosity::elements_of(scene, p);
    const Buffer<glm::vec4> own(e.position.size(), glm::vec4(1)), leaving(e.position.size(), glm::vec4(2, 1, 0.5f, 0));
    Buffer<glm::vec4> irradiance;
    radiosity::FormFactors factors;
    const RunOptions run = options.run_options();
    const auto rows = [&] {
        factors = {};
        return clock_ms([&] { factors = radiosity::form_factors(e, {hemicube, radiosity::Weights::exact}, run); });
    };
    const Times visibility = interleave(options.runs, {rows})[0];
    const Times pass = interleave(options.runs, {[&] { return clock_ms([&] { radiosity::gather(factors, own, leaving, run, irradiance); }); }})[0];
    fmt::print("\n## Hemicubes\n\n{} vertices, {} triangles, hemicubes of {}, form factors {:.1f} MB\n\n| passes | ours, s (processor) | lavapipe, s | "
               "lavapipe / ours |\n|---|---|---|---|\n",
               e.count(), e.geometry.triangles.size(), hemicube, double(factors.bytes()) * 1e-6);
    const double theirs = options.against_lavapipe ? peer_times(scene, e, options).median() * e.count() * 1e-3 : 0;
    for (const int passes : {1, 10}) {
        const double ours = (visibility.median() + passes * pass.median()) * 1e-3, cpu = (visibility.cpu_median() + passes * pass.cpu_median()) * 1e-3;
        fmt::print("| {} | {:.2f} ({:.2f}) | {:.0f} | {:.1f} |\n", passes, ours, cpu, passes * theirs, passes * theirs / ours);
    }
    fmt::print("\nOurs: visibility {:.2f} s (least {:.2f}), a pass {:.1f} ms (least {:.1f}).\n", visibility.median() * 1e-3, visibility.least() * 1e-3,
               pass.median(), pass.least());
}

}  // namespace plumb::bench
