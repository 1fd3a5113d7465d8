// Whatever the convention of the matrices that go in, the same picture comes out.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/camera.h"
#include "drawing.h"
#include "raster/gbuffer.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

const Convention conventions[] = {Convention::vulkan, Convention::opengl, Convention::d3d11, Convention::d3d9,
                                  Convention::left_handed};

constexpr glm::ivec2 frame{137, 91};
constexpr double aspect = 137.0 / 91;

Camera skewed(bool reversed_z, double far) {
    Camera c;
    c.position = {3, 2, -4}, c.look_at = {-1, 0.5, 2}, c.up = {0.2, 3, 0.1};
    c.fov_y_deg = 63, c.near = 0.25, c.far = far, c.reversed_z = reversed_z;
    return c;
}

Scene three_materials() {
    Scene scene;
    for (int i = 0; i < 3; ++i) scene.materials.push_back({"m", glm::vec3(0.2f, 0.5f, 0.3f * float(i)), glm::vec3(i)});
    return scene;
}

// Triangles around the point that the camera looks at, all of them beyond the near plane.
Geometry cluster(int n) {
    Random random(17);
    Geometry g;
    for (int i = 0; i < n; ++i) {
        const glm::vec3 centre = random.vector(-2.5, 2.5);
        auto corner = [&] {
            const glm::vec3 p = centre + random.vector(-0.6, 0.6);
            return at(p, random.vector(-1, 1));
        };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(g, a, b, c, i % 3, i % 5);
    }
    return g;
}

GBuffer draw(const Scene& scene, const Geometry& g, const View& view, glm::ivec2 size = frame) {
    GBuffer out;
    draw_gbuffer(g, prepare(scene, g), view, size, Layout::fp32, {}, out);
    return out;
}

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0);
}

}  // namespace

TEST_CASE("conventions: every interface's matrices draw the same bits, reversed z and infinite far too",
          "[raster][convention]") {
    const Scene scene = three_materials();
    const Geometry g = cluster(400);
    const GBuffer truth = draw(scene, g, make_view(skewed(false, 40), aspect));
    REQUIRE(std::count(truth.id.texels.begin(), truth.id.texels.end(), glm::ivec2(-1)) < frame.x * frame.y * 2 / 3);
    for (Convention k : conventions)
        for (bool reversed : {false, true})
            for (double far : {40.0, double(INFINITY)}) {
                CAPTURE(rules(k).name, reversed, far);
                const Camera camera = skewed(reversed, far);
                const GBuffer out = draw(scene, g, make_view(camera, aspect, k, frame));
                CHECK(out.id.texels == truth.id.texels);
                CHECK(same(out.position, truth.position));
                CHECK(same(out.normal, truth.normal));
                CHECK(same(out.albedo, truth.albedo));
                CHECK(same(out.emission, truth.emission));

                // d = offset / (z - slope): an error e of z moves d by e d^2 / |offset|. e: half a unit in the last place
                // of the stored float, 2^-25; three roundings of corners' clip z to float at depths up to 13 m and as
                // much from w, divided by a depth above 2 m: 2 * 13 * 2^-24 / 2. |offset| is n f / (f - n) or n.
                for (std::size_t i = 0; i < out.depth.size(); ++i) {
                    if (out.id.texels[i].y < 0) {
                        REQUIRE(out.depth.texels[i] == (reversed ? 0.0f : 1.0f));
                        continue;
                    }
                    const double d = linear_depth_from_clip(camera, out.depth.texels[i]);
                    const double truth_d = linear_depth_from_clip(skewed(false, 40), truth.depth.texels[i]);
                    const double bound = 2 * (0x1p-25 + 13 * 0x1p-24) * d * d / 0.25;
                    REQUIRE(std::abs(d - truth_d) <= bound);
                }
            }
}

TEST_CASE("conventions: the matrices of a view are the interface's own", "[raster][convention]") {
    const Camera camera = skewed(true, 40);
    for (Convention k : conventions) {
        const View view = make_view(camera, aspect, k, frame);
        CHECK(view.world_to_view == view_matrix(camera, k));
        CHECK(view.view_to_clip == half_pixel_shift(frame, k) * projection_matrix(camera, aspect, k));
        // Back in canonical clip space, x, y and w carry no rounding at all.
        const glm::dmat4 back = view.to_canonical * view.view_to_clip, canonical = make_view(camera, aspect).view_to_clip;
        for (int column = 0; column < 4; ++column)
            for (int row : {0, 1, 3}) {
                const double mirrored = column == 2 && rules(k).view_left_handed ? -1 : 1;
                CHECK(back[column][row] == mirrored * canonical[column][row]);
            }
    }
}

// The diagonal edge of a half-plane through pixel centres tells half a pixel apart.
TEST_CASE("conventions: Direct3D 9 without its shift differs by half a pixel", "[raster][convention]") {
    const Scene scene = three_materials();
    Geometry g;
    add_triangle(g, at({-1, -1, 0}), at({1, -1, 0}), at({-1, 1, 0}));
    Camera camera;
    camera.position = {0, 0, 2}, camera.look_at = {0, 0, 0}, camera.fov_y_deg = 60;
    const glm::ivec2 size(64, 64);
    const View shifted = make_view(camera, 1, Convention::d3d9, size);
    View unshifted = shifted;
    unshifted.view_to_clip = projection_matrix(camera, 1, Convention::d3d9);
    const GBuffer right = draw(scene, g, shifted, size), wrong = draw(scene, g, unshifted, size);
    CHECK(right.id.texels == draw(scene, g, make_view(camera, 1), size).id.texels);
    CHECK(wrong.id.texels != right.id.texels);
    // A point of the plane z = 0 is drawn half a pixel to the lower right: side / 2 = 2 tan 30 / 64 metres.
    const double half_pixel = 2 * (1 / std::sqrt(3.0)) * 2 / 64 / 2;
    int compared = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            if (right.id(x, y).y < 0 || wrong.id(x, y).y < 0) continue;
            const glm::dvec4 moved = glm::dvec4(wrong.position(x, y)) - glm::dvec4(right.position(x, y));
            REQUIRE(std::abs(moved.x + half_pixel) <= 2 * half_pixel / 128);  // corners snap to 1/256 pixel
            REQUIRE(std::abs(moved.y - half_pixel) <= 2 * half_pixel / 128);
            ++compared;
        }
    CHECK(compared > 500);
}

// far / near = 1e7. Two planes a part in 10^4 apart at depth d: reversed z with an infinite far plane stores near / d, of
// which a float keeps 24 bits at any d; forward z stores 1 - near / d, which beyond d = near 2^24 / 10^4 differs from
// its neighbour by less than a unit in the last place.
TEST_CASE("conventions: reversed z with an infinite far plane resolves depths up to 1e7 near planes",
          "[raster][convention][depth]") {
    const Scene scene = three_materials();
    for (Convention k : conventions)
        for (bool reversed : {false, true}) {
            Camera camera;
            camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1}, camera.fov_y_deg = 90;
            camera.near = 0.1, camera.far = reversed ? double(INFINITY) : 1e6, camera.reversed_z = reversed;
            const glm::ivec2 size(9, 9);
            int nearer_seen = 0, tried = 0;
            for (float d : {1e3f, 1e4f, 1e5f, 9e5f}) {
                // The farther plane is drawn first, so that equal depths show it.
                Geometry g;
                for (float z : {-d * 1.0001f, -d})
                    add_triangle(g, at({-3 * d, -3 * d, z}), at({3 * d, -3 * d, z}), at({0, 4 * d, z}));
                const GBuffer out = draw(scene, g, make_view(camera, 1, k, size), size);
                ++tried;
                nearer_seen += out.id(4, 4).y == 1;
                if (reversed) {
                    CAPTURE(rules(k).name, d);
                    // near / d, and OpenGL's -1..1 costs 2^-53 of w in double: 2^-53 d / near, relative.
                    CHECK(std::abs(linear_depth_from_clip(camera, out.depth(4, 4)) - d) <= 4 * 0x1p-24 * d);
                }
            }
            CAPTURE(rules(k).name, reversed, nearer_seen);
            CHECK((reversed ? nearer_seen == tried : nearer_seen < tried));
        }
}

TEST_CASE("conventions: what a device holds, and back", "[convention]") {
    for (Convention k : conventions) {
        CAPTURE(rules(k).name);
        const bool opengl = k == Convention::opengl;
        CHECK(clip_depth_from_depth_buffer(0.25, k) == (opengl ? -0.5 : 0.25));
        CHECK(depth_buffer_from_clip_depth(-0.5, k) == (opengl ? 0.25 : -0.5));
        CHECK(memory_row(0, 5, k) == (opengl ? 4 : 0));
        for (int y = 0; y < 5; ++y) CHECK(memory_row(memory_row(y, 5, k), 5, k) == y);
        Image<int> rows(2, 3);
        for (int i = 0; i < 6; ++i) rows.texels[std::size_t(i)] = i;
        const Image<int> held = in_memory_order(rows, k);
        CHECK(held(1, 0) == (opengl ? 5 : 1));
        CHECK(in_memory_order(held, k).texels == rows.texels);

        // A point's clip depth, after the interface's own matrices, is what its depth buffer holds.
        const Camera camera = skewed(false, 40);
        const View canonical = make_view(camera, 1), view = make_view(camera, 1, k, {8, 8});
        const glm::dvec4 x(0.1, 0.2, 0.3, 1);
        const glm::dvec4 a = canonical.world_to_clip() * x, b = view.view_to_clip * view.world_to_view * x;
        CHECK(std::abs(depth_buffer_from_clip_depth(b.z / b.w, k) - a.z / a.w) <= 1e-15);
    }
}
