// The kernels over double and Bounded, beside float.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/bounded.h"
#include "core/tap.h"
#include "drawing.h"
#include "raster/gbuffer_kernel.h"
#include "raster/light_view.h"
#include "raster/rsm_kernel.h"
#include "raster/surfaces.h"
#include "raster/texture_bounded.h"
#include "raster/visibility.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

// Float must lie within the bound that Bounded derives around its double-precision shadow, where no branch was in
// doubt, and close to double. Returns whether it was in doubt.
bool check(float value, double exact, const Bounded& bounded, double scale) {
    REQUIRE(bounded.value == value);
    if (bounded.ambiguous) return true;
    CAPTURE(value, exact, bounded.shadow, bounded.bound);
    REQUIRE(std::abs(double(value) - bounded.shadow) <= bounded.bound);
    REQUIRE(std::abs(double(value) - exact) <= 2 * bounded.bound + 64 * 0x1p-24 * scale);
    return false;
}

int check(const vec4<float>& value, const vec4<double>& exact, const vec4<Bounded>& bounded, double scale) {
    int doubtful = 0;
    for (int c = 0; c < 4; ++c) doubtful += check(value[c], exact[c], bounded[c], scale);
    return doubtful;
}

struct Soup {
    Scene scene;
    Geometry geometry;
};

Soup textured_soup() {
    Soup s;
    Random random(21);
    Image<std::uint32_t> texels(16, 8);
    for (std::uint32_t& x : texels.texels) x = random.next();
    s.scene.textures.push_back({"noise", texels, true, Filter::bilinear});
    s.scene.textures.push_back(
        {"more", texels, false, Filter::bilinear, Wrap::mirrored_repeat, Wrap::clamp_to_edge, false});
    s.scene.materials.push_back({"plain", glm::vec3(0.2f, 0.4f, 0.6f), glm::vec3(1), -1});
    s.scene.materials.push_back({"noise", glm::vec3(0.9f), glm::vec3(0), 0});
    s.scene.materials.push_back({"all", glm::vec3(0.9f), glm::vec3(1), 1, 0, 1, 0.3f});
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 centre = random.vector(-4, 4) - glm::vec3(0, 0, 6);
        auto corner = [&] {
            const glm::vec3 position = centre + random.vector(-1, 1);
            const glm::vec3 normal = random.vector(-0.3, 0.3) + glm::vec3(0, 0, 1);
            const float u = float(random.uniform()), v = float(random.uniform());
            return at(position, normal, u, v);
        };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(s.geometry, a, b, c, i % 3);
        for (int k = 0; k < 3; ++k) s.geometry.tangents.push_back({1, 0, 0, i % 2 ? 1 : -1});
    }
    return s;
}

}  // namespace

TEST_CASE("kernels: the G-buffer in float is within Bounded's bound of double", "[raster][bounded]") {
    const Soup s = textured_soup();
    const Surfaces surfaces = prepare(s.scene, s.geometry);
    Camera camera;
    camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1};
    const View view = make_view(camera, 1);
    const VisibilityBuffer visible = draw_visibility(s.geometry, view, {64, 64}, {});
    GBufferArgs in{};
    in.surfaces = surface_args(s.geometry, surfaces, view);
    for (int c = 0; c < 3; ++c) in.eye[c] = float(view.eye[c]), in.forward[c] = float(view.forward[c]);
    int covered = 0, doubtful = 0;
    for (std::size_t i = 0; i < visible.triangle.size(); ++i) {
        const std::int32_t t = visible.triangle.texels[i];
        if (t < 0) continue;
        NoTap tap;
        const glm::vec2 l = visible.barycentrics.texels[i];
        const GBufferPixel<float> f = gbuffer<float>(in, t, l, tap);
        const GBufferPixel<double> d = gbuffer<double>(in, t, vec2<double>(l), tap);
        const GBufferPixel<Bounded> b = gbuffer<Bounded>(in, t, vec2<Bounded>(Bounded(l.x), Bounded(l.y)), tap);
        doubtful += check(f.position, d.position, b.position, 10) + check(f.normal, d.normal, b.normal, 1) +
                    check(f.albedo, d.albedo, b.albedo, 16) + check(f.emission, d.emission, b.emission, 1);
        ++covered;
    }
    REQUIRE(covered > 1000);
    REQUIRE(doubtful < covered / 10);
}

TEST_CASE("kernels: the reflective shadow map in float is within Bounded's bound of double", "[raster][bounded]") {
    const Soup s = textured_soup();
    const Surfaces surfaces = prepare(s.scene, s.geometry);
    for (LightType type : {LightType::spot, LightType::directional}) {
        Light light;
        light.type = type;
        light.position = {0, 0, 2}, light.direction = {0, 0.1f, -1};
        light.rsm_size = 48;
        const View view = light_view(light, {-5, -5, -10}, {5, 5, -1});
        const VisibilityBuffer visible = draw_visibility(s.geometry, view, {48, 48}, {});
        RsmArgs in{};
        in.surfaces = surface_args(s.geometry, surfaces, view);
        for (int c = 0; c < 3; ++c) in.eye[c] = float(view.eye[c]), in.forward[c] = float(view.forward[c]);
        in.light = light_args(light);
        in.texel_scale = float(2 / view.view_to_clip[0][0] / 48);
        in.half_width = float(1 / view.view_to_clip[0][0]);
        in.size = 48;
        int covered = 0, doubtful = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                const std::int32_t t = visible.triangle(x, y);
                if (t < 0) continue;
                NoTap tap;
                const glm::vec2 l = visible.barycentrics(x, y);
                const RsmTexel<float> f = rsm<float>(in, x, y, t, l, tap);
                const RsmTexel<double> d = rsm<double>(in, x, y, t, vec2<double>(l), tap);
                const RsmTexel<Bounded> b = rsm<Bounded>(in, x, y, t, vec2<Bounded>(Bounded(l.x), Bounded(l.y)), tap);
                doubtful += check(f.position, d.position, b.position, 10) + check(f.normal, d.normal, b.normal, 1) +
                            check(f.flux, d.flux, b.flux, 1);
                ++covered;
            }
        REQUIRE(covered > 300);
        REQUIRE(doubtful < covered / 4);
    }
}
