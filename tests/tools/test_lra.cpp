// plumb experiment lra: fragments that are counted, lines that are fitted, and the share of a model.
#include <catch2/catch.hpp>

#include "core/camera.h"
#include "raster/visibility.h"
#include "tools/experiments/lra.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

// Appends a square across the view, that far along -z and that wide.
void add_square(Geometry& g, float distance, float half) {
    const std::uint32_t first = std::uint32_t(g.vertices.size());
    for (const glm::vec2 c : {glm::vec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        Vertex v{};
        v.position = {half * c.x, half * c.y, -distance};
        g.vertices.push_back(v);
    }
    g.triangles.push_back({first, first + 1, first + 2}), g.triangles.push_back({first, first + 2, first + 3});
    for (int i = 0; i < 2; ++i) g.material.push_back(0), g.object.push_back(0);
}

View view_from_origin() {
    Camera camera;
    camera.position = {0, 0, 0}, camera.look_at = {0, 0, -1}, camera.fov_y_deg = 90, camera.near = 0.1, camera.far = 100;
    return make_view(camera, 1);
}

}  // namespace

TEST_CASE("experiment lra: fragments of squares before each other", "[experiment][LRA 7.3][analytic]") {
    // At 90 degrees a square of half its distance covers the frame's middle half: a quarter of 40 x 40 pixels.
    constexpr glm::ivec2 size{40, 40};
    Geometry far_first, near_first;
    add_square(far_first, 4, 4), add_square(far_first, 2, 1);
    add_square(near_first, 2, 1), add_square(near_first, 4, 4);
    const LraFragments a = count_fragments(far_first, view_from_origin(), size), b = count_fragments(near_first, view_from_origin(), size);
    for (const LraFragments& f : {a, b}) {
        CHECK(f.triangles == 4);
        CHECK(f.covered == 1600);
        CHECK(f.drawn == 1600 + 400);
    }
    CHECK(a.passing == 2000);  // what is drawn first is hidden later
    CHECK(b.passing == 1600);
    CHECK(a.overdraw() == 1.25);
    CHECK(b.overdraw() == 1);

    // What lies outside or has no pixel centre draws nothing; an empty view has no overdraw.
    Geometry none;
    add_square(none, -4, 4), add_square(none, 4, 0.01f);
    const LraFragments c = count_fragments(none, view_from_origin(), size);
    CHECK((c.triangles == 0 && c.drawn == 0 && c.covered == 0 && c.overdraw() == 0));
}

TEST_CASE("experiment lra: covered pixels are those of the rasterizer", "[experiment]") {
    const LraRequest request{{}, true, 20'000, 8, 128, 200, 5, 1};
    LraWorld world(request);
    LraCase row;
    const Scene& scene = world.scene(row);
    const LraFragments counted = world.fragments(row);
    const View view = make_view(scene.camera, 1);
    const raster::VisibilityBuffer drawn = raster::draw_visibility(flatten(scene), view, scene.frame_size, {});
    std::uint64_t seen = 0;
    for (const std::int32_t t : drawn.triangle.texels) seen += t >= 0;
    CHECK(counted.covered == seen);
    CHECK(counted.drawn > counted.passing);
    CHECK(counted.passing > counted.covered);

    // The model's bounds have the thesis' half width for a radius, and lie in the frame.
    glm::vec3 low, high;
    REQUIRE(bounds(flatten(scene), low, high));
    CHECK(double(glm::length(high - low)) / 2 == Approx(lra_half_width).epsilon(1e-5));
    const glm::dmat4 m = view.world_to_clip();
    double widest = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 p = m * glm::dvec4(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z, 1);
        widest = std::max({widest, std::abs(p.x / p.w), std::abs(p.y / p.w)});
    }
    CHECK(widest == Approx(1).epsilon(1e-5));
}

TEST_CASE("experiment lra: a line through times", "[experiment][analytic]") {
    const std::optional<LraLine> exact = fitted_line({1, 2, 5}, {5, 7, 13});
    REQUIRE(exact);
    CHECK(exact->fixed == Approx(3));
    CHECK(exact->each == Approx(2));
    CHECK(exact->off == Approx(0).margin(1e-9));
    // LRA, table 7.4: frames a second fall by less with each light, times lie on a line within a percent and a half.
    const std::optional<LraLine> thesis = fitted_line({1, 2, 3, 4, 5}, {1000 / 32.63, 1000 / 17.30, 1000 / 11.66, 1000 / 8.85, 1000 / 7.29});
    REQUIRE(thesis);
    CHECK(thesis->off < 0.015);
    CHECK(thesis->each > 25);
    CHECK_FALSE(fitted_line({2, 2}, {1, 3}));
    CHECK_FALSE(fitted_line({}, {}));
}

TEST_CASE("scene: the share of a mesh is its first triangles, rounded down", "[experiment][LRA 8]") {
    Scene scene;
    Mesh& mesh = scene.meshes.emplace_back();
    mesh.vertices.resize(3);
    for (std::uint32_t i = 0; i < 7; ++i) mesh.triangles.push_back({i % 3, (i + 1) % 3, (i + 2) % 3}), mesh.material.push_back(std::int32_t(i));
    for (const auto& [share, count] : {std::pair(0.0, 0), {0.14, 0}, {0.15, 1}, {0.5, 3}, {0.999, 6}, {1.0, 7}}) {
        CAPTURE(share);
        mesh.share = share;
        const Geometry g = flatten(scene);
        REQUIRE(g.triangles.size() == std::size_t(count));
        for (int i = 0; i < count; ++i) CHECK(g.material[std::size_t(i)] == i);
    }
}
