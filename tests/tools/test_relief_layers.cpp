// The layers of IPR figure 5.20 against the path tracer, on the container in the Cornell box. The figures of gi/probes/README.md:
// test_tools "[relief][truth]" -s
#include <catch2/catch.hpp>
#include <cmath>

#include "core/host_math.h"
#include "gi/frame/frame.h"
#include "gi/frame/probe_bake.h"
#include "gi/reference/reference.h"
#include "io/scene_file.h"

namespace {

using namespace plumb;

// By channel over the pixels that count: how far a is from b, of the mean of b.
struct Off {
    double rms = 0, bias = 0;
};
template <class A, class B, class Counts>
Off off(std::size_t pixels, A a, B b, Counts counts) {
    double square = 0, sum = 0, mean = 0;
    int n = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        if (!counts(i)) continue;
        const glm::dvec3 d = a(i) - b(i);
        square += glm::dot(d, d), sum += d.x + d.y + d.z, mean += glm::dot(b(i), glm::dvec3(1)), n += 3;
    }
    return {std::sqrt(square / n) / (mean / n), sum / mean};
}

glm::dvec3 at(const Image4& image, std::size_t i) { return glm::dvec3(image.texels[i]); }

}  // namespace

TEST_CASE("relief: the layers of figure 5.20 against the path tracer", "[relief][truth][IPR 5.2.1.3]") {
    Scene scene = io::load_scene(PLUMB_SOURCE_DIR "/data/scenes/cornell/cornell_container.toml", frame::method_tables());
    scene.frame_size = {128, 128}, scene.method = "probes";
    for (Texture& t : scene.textures) t.mips = false;  // a pixel is its middle, as the path tracer's
    frame::Settings settings = frame::settings_of(scene);
    settings.probes.lightmap_size = 128, settings.probes.receiver_rays = 512, settings.probe_run.layers = true;
    frame::add_bake(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings), {});
    const frame::ReliefBuffers& r = f.probes.relief;

    reference::PathParams params;
    params.samples = 256;
    const auto paths = reference::prepare(scene, params.rays);
    const auto irradiance = [&](const Image4& normal) {
        return reference::trace_irradiance(params, *paths, {&f.gbuffer.position, &normal}, 3, {}).mean;
    };
    const Image4 plain = irradiance(r.plain.normal), mapped = irradiance(f.gbuffer.normal);
    const Image4 color = reference::trace(params, *paths, scene.camera, scene.frame_size, 4, {}).mean;
    const auto diffuse = [&](std::size_t i) { return f.gbuffer.normal.texels[i].w > 0 && f.gbuffer.emission.texels[i] == glm::vec4(0); };
    const auto moves = [&](std::size_t i) {
        const int object = f.gbuffer.id.texels[i].x;
        return object >= 0 && scene.meshes[std::size_t(object)].dynamic;
    };
    const auto glossy = [&](std::size_t i) {
        return at(color, i) - at(f.gbuffer.albedo, i) * at(mapped, i) / host::pi;
    };
    struct Row {
        const char* name;
        Off moving, still;
    };
    const auto row = [&](const char* name, auto a, auto b) {
        return Row{name, off(color.size(), a, b, moves), off(color.size(), a, b, [&](std::size_t i) { return !moves(i) && diffuse(i); })};
    };
    const auto over_pi = [](const Image4& e) { return [&e](std::size_t i) { return at(e, i) / host::pi; }; };
    const Row rows[] = {
        row("diffuse", [&](std::size_t i) { return at(r.layers[0].radiance, i); }, over_pi(plain)),
        row("normals", [&](std::size_t i) { return at(r.layers[1].radiance, i); }, over_pi(mapped)),
        row("diffuse, held against normals", [&](std::size_t i) { return at(r.layers[0].radiance, i); }, over_pi(mapped)),
        row("specular", [&](std::size_t i) { return at(r.layers[2].radiance, i); }, [&](std::size_t i) { return at(mapped, i) / host::pi + glossy(i); }),
        row("normals, held against specular", [&](std::size_t i) { return at(r.layers[1].radiance, i); },
            [&](std::size_t i) { return at(mapped, i) / host::pi + glossy(i); }),
        row("all", [&](std::size_t i) { return at(f.radiance, i); }, [&](std::size_t i) { return at(color, i); }),
        row("all without highlights", [&](std::size_t i) { return at(f.radiance, i) - at(r.made.glossy, i); }, [&](std::size_t i) { return at(color, i); }),
    };
    int moving = 0;
    for (std::size_t i = 0; i < color.size(); ++i) moving += moves(i);
    CHECK(moving > 1000);
    for (const Row& one : rows) {
        INFO(one.name << ": container rms " << 100 * one.moving.rms << " %, bias " << 100 * one.moving.bias << " %; room rms "
                      << 100 * one.still.rms << " %, bias " << 100 * one.still.bias << " %");
        CHECK(std::isfinite(one.moving.rms));
        CHECK(std::isfinite(one.still.rms));
    }
    // Normal maps take the container to its truth. Highlights bring what is missing in the mean, but by one direction a point: of a room
    // that shines from everywhere they show too little, in the wrong places.
    CHECK(rows[1].moving.rms < 0.7 * rows[2].moving.rms);
    CHECK(std::fabs(rows[3].moving.bias) < std::fabs(rows[4].moving.bias));
    CHECK(std::fabs(rows[5].moving.bias) < std::fabs(rows[6].moving.bias));
}
