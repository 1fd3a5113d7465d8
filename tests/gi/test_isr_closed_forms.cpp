// Image-space radiosity against closed forms: form factors and occlusion of surfaces that a pinhole camera sees, from
// images made in double precision.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/isr/sample_uniforms.h"
#include "gi/isr/isr.h"
#include "gi/reference/closed_form_scenes.h"

using namespace plumb;
using namespace plumb::isr;

namespace {

// A camera's coarse pixels: surface and radiosity.
struct CoarseView {
    CoarseCamera camera;
    Image4 surface, radiosity;

    // surface_at(ray, normal): eye depth along a ray of depth 1 m, and the normal there; 0 where nothing is.
    template <class SurfaceAt>
    CoarseView(const CoarseCamera& c, SurfaceAt surface_at)
        : camera(c), surface(c.size.x, c.size.y), radiosity(c.size.x, c.size.y) {
        for (int y = 0; y < c.size.y; ++y)
            for (int x = 0; x < c.size.x; ++x) {
                glm::dvec3 normal(0);
                double sent = 0;
                const double z = surface_at(ray(x, y), normal, sent);
                if (!(z > 0)) continue;
                surface(x, y) = glm::vec4(glm::vec3(normal), float(z));
                radiosity(x, y) = glm::vec4(glm::vec3(float(sent)), 0.5f);
            }
    }
    glm::dvec3 ray(double x, double y) const { return camera.f_o + x * camera.f_u + y * camera.f_v; }
};

// Rings 1 pixel apart that cover an image of up to 127 pixels a side from any of its pixels.
IsrParams every_pixel(int size) {
    IsrParams params;
    params.rings = params.ssao_rings = std::min(size, 127);
    params.spacing = params.ssao_spacing = 1;
    return params;
}

// One receiver at pixel p of a view: depth z, normal n.
Image4 receiver(const CoarseView& view, glm::ivec2 p, double z, const glm::dvec3& n) {
    Image4 image(view.surface.width, view.surface.height);
    image(p.x, p.y) = glm::vec4(glm::vec3(n), float(z));
    return image;
}

glm::vec4 gathered_at(const CoarseView& view, const Image4& receivers, glm::ivec2 p, float least_cosine = 1e-3f) {
    IsrParams params = every_pixel(view.surface.width);
    params.least_cosine = least_cosine;
    const Pattern pattern = gather_pattern(params, view.surface.height);
    GatherInputs in;
    in.surface = &receivers, in.source_surface = &view.surface, in.source_radiosity = &view.radiosity;
    in.camera = view.camera, in.pattern = &pattern;
    Image4 out;
    run(params, in, {}, out);
    return out(p.x, p.y);
}

// The kernel at one pixel in double, the mean over the rotations of its samples: a float sum of a million samples has an error of its own.
double gathered_in_double(const CoarseView& view, glm::ivec2 p, const IsrParams& params, const Pattern& pattern, int rings) {
    GatherInputs in;
    in.surface = in.source_surface = &view.surface, in.source_radiosity = &view.radiosity;
    in.camera = view.camera, in.pattern = &pattern;
    GatherInputsView inputs{};
    inputs.u = uniforms(params, in);
    inputs.u.rings = rings;
    inputs.surface = inputs.source_surface = &view.surface.data()->x, inputs.source_radiosity = &view.radiosity.data()->x;
    inputs.offsets = pattern.offsets.data(), inputs.weights = pattern.weights.data();
    double sum = 0;
    NoTap tap;
    for (int turn = 0; turn < pattern.rotations; ++turn)
        sum += gather<double>(inputs, p.x, p.y, SourceImages<double>{inputs, p.x, p.y, turn}, tap).x;
    return sum / pattern.rotations;
}

// With every other pixel as a sample: more rings than parameters allow.
double gathered_from_all(const CoarseView& view, glm::ivec2 p) {
    const int n = view.surface.width;
    IsrParams params;
    params.rings = 1, params.spacing = 1, params.least_cosine = 1e-3f;
    Pattern all = gather_pattern(params, n);
    all.offsets.clear();
    for (int dy = -n; dy <= n; ++dy)
        for (int dx = -n; dx <= n; ++dx)
            if (dx != 0 || dy != 0) all.offsets.push_back(std::int32_t((unsigned(dx) & 0xffffu) | unsigned(dy) << 16));
    all.weights.assign(all.offsets.size(), 1.0f);
    return gathered_in_double(view, p, params, all, n);
}

double occlusion_at(const CoarseView& view, const Image4& receivers, glm::ivec2 p) {
    const IsrParams params = every_pixel(view.surface.width);
    const Pattern pattern = ssao_pattern(params);
    SsaoInputs in;
    in.surface = &receivers, in.source_surface = &view.surface, in.camera = view.camera, in.pattern = &pattern;
    Image4 out;
    run(params, in, {}, out);
    return 1 - double(out(p.x, p.y).w);
}

// A floor, 1 m x 1 m, in front of a wall of the same size, seen from above: the floor is lit.
Camera above_the_corner() {
    Camera camera;
    camera.position = {0.5, 1.7, 2.2}, camera.look_at = {0, 0.35, 0.45};
    camera.fov_y_deg = 40, camera.near = 0.1, camera.far = 10;
    return camera;
}

CoarseView floor_and_wall(const CoarseCamera& c) {
    return CoarseView(c, [&](const glm::dvec3& ray, glm::dvec3& normal, double& sent) {
        const double to_floor = -c.eye.y / ray.y, to_wall = -c.eye.z / ray.z;
        const glm::dvec3 on_floor = c.eye + ray * to_floor, on_wall = c.eye + ray * to_wall;
        if (to_floor > 0 && std::abs(on_floor.x) <= 0.5 && on_floor.z >= 0 && on_floor.z <= 1)
            return normal = {0, 1, 0}, sent = 1, to_floor;
        if (to_wall > 0 && std::abs(on_wall.x) <= 0.5 && on_wall.y >= 0 && on_wall.y <= 1)
            return normal = {0, 0, 1}, to_wall;
        return 0.0;
    });
}

// The floor and the wall in n x n coarse pixels, and the pixel of the wall, in the middle, `height` above the floor's edge. The camera
// is moved so that a pixel lies there exactly.
struct Corner {
    CoarseView view;
    glm::ivec2 pixel;
};
Corner corner(int n, double height) {
    Camera camera = above_the_corner();
    const glm::ivec2 size(2 * n);
    const glm::dvec3 target(0, height, 0);
    CoarseCamera c = coarse_camera(camera, size);
    const double z = linear_depth(camera, target);
    const glm::dvec3 d = (target - c.eye) / z - c.f_o;
    const double footprint2 = c.footprint * c.footprint;
    const glm::ivec2 p(int(std::lround(glm::dot(d, c.f_u) / footprint2)), int(std::lround(glm::dot(d, c.f_v) / footprint2)));
    const glm::dvec3 moved = target - (c.f_o + double(p.x) * c.f_u + double(p.y) * c.f_v) * z - c.eye;
    camera.position += moved, camera.look_at += moved;
    return {floor_and_wall(coarse_camera(camera, size)), p};
}

// The form factor from there to the floor.
double wall_to_floor(int n, double height) {
    const Corner c = corner(n, height);
    return gathered_from_all(c.view, c.pixel);
}
// The same by a pattern's samples alone.
double wall_to_floor(const Corner& c, PatternKind kind, int rings, int rotations, float reach) {
    IsrParams params;
    params.pattern = kind, params.rings = rings, params.rotations = rotations, params.reach = reach, params.least_cosine = 1e-3f;
    return gathered_in_double(c.view, c.pixel, params, gather_pattern(params, c.view.surface.height), rings);
}

// The camera is 100 m away and sees a disc of radius 0.5 m, or a unit square on the xy plane, head-on.
template <class Inside>
CoarseView head_on(int n, Inside inside) {
    Camera camera;
    camera.position = {0, 0, 100}, camera.look_at = {0, 0, 0}, camera.near = 1, camera.far = 200;
    camera.fov_y_deg = 0.7;
    const CoarseCamera c = coarse_camera(camera, glm::ivec2(2 * n));
    return CoarseView(c, [&](const glm::dvec3& ray, glm::dvec3& normal, double& sent) {
        if (!inside(c.eye + ray * 100.0)) return 0.0;
        return normal = {0, 0, 1}, sent = 1, 100.0;
    });
}

}  // namespace

TEST_CASE("isr.gather: a wall next to a lit floor, form factors against the closed form as resolution grows",
          "[isr][ISR 4.4][analytic]") {
    // dA to a perpendicular rectangle that it stands in the middle of, from its height.
    const double expected_half = 2 * reference::to_perpendicular_rectangle(0.5, 1, 0.5);
    const double expected_near = 2 * reference::to_perpendicular_rectangle(0.5, 1, 0.02);
    CHECK(expected_half == Approx(0.190135882384807).epsilon(1e-12));
    CHECK(expected_near == Approx(0.484323815518066).epsilon(1e-12));
    // 0.5 m away the floor's border, which falls between pixels, errs most: half a pixel of 1.5 m / n on three edges that
    // hold a tenth of the form factor each. 0.02 m away a pixel is as large as the distance until n = 64.
    const double allowed_half[] = {0.01, 0.005, 0.0025, 0.00125, 0.0006, 0.0003, 0.0003};
    const double allowed_near[] = {0.9, 0.7, 0.3, 0.2, 0.1, 0.05, 0.025};
    int i = 0;
    for (int n : {16, 32, 64, 128, 256, 512, 1024}) {
        const double half = wall_to_floor(n, 0.5), near = wall_to_floor(n, 0.02);
        INFO(n << " pixels: " << half << " off " << half / expected_half - 1 << ", " << near << " off "
                        << near / expected_near - 1);
        CHECK(std::abs(half / expected_half - 1) <= allowed_half[i]);
        CHECK(std::abs(near / expected_near - 1) <= allowed_near[i]);
        ++i;
    }
}

TEST_CASE("isr.gather: rings and grid gather what the screen sees within their reach, the closer the more samples there are",
          "[isr][pattern][analytic]") {
    const double closed = 2 * reference::to_perpendicular_rectangle(0.5, 1, 0.5);
    const Corner c = corner(256, 0.5);
    const double off_rings[] = {0.02, 0.006, 0.0015, 0.0005}, off_grid[] = {0.06, 0.06, 0.03, 0.006};
    int i = 0;
    for (const int rings : {4, 8, 16, 32}) {
        const double in_rings = wall_to_floor(c, PatternKind::rings, rings, 16, 1.25f), on_grid = wall_to_floor(c, PatternKind::grid, rings, 16, 1.25f);
        INFO(rings << " rings: " << in_rings / closed - 1 << " in rings, " << on_grid / closed - 1 << " on the grid");
        CHECK(std::abs(in_rings / closed - 1) <= off_rings[i]);
        CHECK(std::abs(on_grid / closed - 1) <= off_grid[i]);
        ++i;
    }
    // What lies beyond the reach is not gathered: the share of the frame's height decides, and not its pixels.
    for (const float reach : {0.2f, 0.4f, 1.25f}) {
        CAPTURE(reach);
        const double large = wall_to_floor(corner(512, 0.5), PatternKind::rings, 8, 16, reach) / closed;
        CHECK(large == Approx(reach == 0.2f ? 0 : reach == 0.4f ? 0.539 : 1).margin(2e-3));
        for (const int n : {64, 128, 256}) {
            const double in_rings = wall_to_floor(corner(n, 0.5), PatternKind::rings, 8, 16, reach) / closed;
            INFO(n << " pixels: " << in_rings << ", 512 pixels: " << large);
            CHECK(std::abs(in_rings - large) <= 1.0 / n);
        }
    }
}

TEST_CASE("isr.gather: a disc seen head-on has the form factor a^2 / (a^2 + d^2)", "[isr][ISR 4.4][analytic]") {
    // The image cuts the disc along pixels: its area is off by the pixels on its rim, of which half fall either way.
    const CoarseView view = head_on(127, [](const glm::dvec3& x) { return x.x * x.x + x.y * x.y <= 0.25; });
    for (double distance : {0.25, 0.5, 1.0, 2.0}) {
        CAPTURE(distance);
        const double expected = 0.25 / (0.25 + distance * distance);
        const Image4 receivers = receiver(view, {63, 63}, 100 - distance, {0, 0, -1});
        CHECK(double(gathered_at(view, receivers, {63, 63}).x) == Approx(expected).epsilon(0.005));
    }
}

TEST_CASE("isr.ssao: spheres on a disc and on a wall occlude what their integral says", "[isr][ISR (26)][analytic]") {
    // Each pixel is a sphere of r^2 = A / pi that covers r^2 cos / d^2 of the receiver's hemisphere: over a disc seen from
    // its axis, integral of cos_p / (pi d^2) dA = 2 (1 - d / sqrt(d^2 + a^2)).
    const CoarseView disc = head_on(127, [](const glm::dvec3& x) { return x.x * x.x + x.y * x.y <= 0.25; });
    for (double distance : {0.5, 1.0, 2.0}) {
        CAPTURE(distance);
        const double expected = 2 * (1 - distance / std::sqrt(distance * distance + 0.25));
        const Image4 receivers = receiver(disc, {63, 63}, 100 - distance, {0, 0, -1});
        CHECK(occlusion_at(disc, receivers, {63, 63}) == Approx(expected).epsilon(0.005));
    }
    // A wall of 1 m x 1 m, a point before the middle of its foot: 2 / pi (asinh(1 / 2 a) - asinh(1 / (2 sqrt(1 + a^2)))).
    // The receiver is the pixel whose ray passes by the foot's middle, within half a pixel: 0.5 % of a metre.
    const CoarseView wall =
        head_on(127, [](const glm::dvec3& x) { return std::abs(x.x) <= 0.5 && std::abs(x.y) <= 0.5; });
    for (double a : {0.25, 0.5, 1.0}) {
        CAPTURE(a);
        const glm::ivec2 foot(63, int(std::lround(63 + 0.5 / (100 * wall.camera.footprint))));
        const Image4 receivers = receiver(wall, foot, 100 - a, {0, 1, 0});
        const double y = (wall.camera.eye + wall.ray(foot.x, foot.y) * (100 - a)).y;
        REQUIRE(std::abs(y + 0.5) < 0.011);
        // From there up to the upper edge, and what is below the receiver's horizon does not occlude.
        auto of_height = [&](double h) { return std::asinh(0.5 / std::sqrt(a * a + h * h)); };
        const double low = std::max(0.0, -0.5 - y);
        const double expected = 2 / M_PI * (of_height(low) - of_height(0.5 - y));
        // Three edges, each within half a pixel: half a percent of the wall.
        CHECK(occlusion_at(wall, receivers, foot) == Approx(expected).epsilon(0.015));
    }
}

TEST_CASE("isr.ssao: a sphere's occlusion is (11) over its cap, which neither (13) nor (14) is", "[isr][ISR (13)][ISR (14)][analytic]") {
    // README, Ambient occlusion: 1 / pi times the cosine's integral over directions within asin(q) of the sphere's centre, which
    // lies `tilt` from the normal; by the midpoint rule.
    auto over_cap = [](double q, double tilt) {
        const int n = 400;
        const double edge = std::asin(q);
        double sum = 0;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const double theta = edge * (i + 0.5) / n, phi = 2 * M_PI * (j + 0.5) / n;
                const double cosine = std::cos(tilt) * std::cos(theta) + std::sin(tilt) * std::sin(theta) * std::cos(phi);
                sum += std::max(0.0, cosine) * std::sin(theta);
            }
        return sum * (edge / n) * (2 * M_PI / n) / M_PI;
    };
    const double printed[] = {0.0050, 0.1340, 0.5641};
    int row = 0;
    for (double q : {0.1, 0.5, 0.9}) {
        CAPTURE(q);
        for (double tilt : {0.0, 0.4 * std::acos(q)})  // above the horizon
            CHECK(over_cap(q, tilt) == Approx(q * q * std::cos(tilt)).epsilon(1e-4));
        const double h = 1 - std::sqrt(1 - q * q);
        CHECK(h == Approx(printed[row++]).margin(5e-5));
        CHECK(h < 0.7 * over_cap(q, 0));      // (14) at 1 m
        CHECK(2 * h > over_cap(q, 0));        // with 2 pi and 1 / pi, but one cosine for all of the cap
    }
    CHECK(2 * (1 - std::sqrt(1 - 0.01)) == Approx(over_cap(0.1, 0)).epsilon(0.003));
}

TEST_CASE("isr.ssao: published, (26) as printed on one small sphere over its share", "[isr][ISR (26)][analytic]") {
    // (26) on a distant small sphere is (2 pi / N) (r^2 / 2 d^2) d cos_p in the limit: what it should be, r^2 / d^2 cos_p, times
    // pi d / N. So it falls with N, and d is in a unit that (26) does not name: of length_unit, or of its own length.
    const CoarseView one = head_on(33, [](const glm::dvec3& x) { return x.x * x.x + x.y * x.y <= 1e-4; });
    IsrParams params = every_pixel(33);
    params.variant = Variant::published;
    const Pattern pattern = ssao_pattern(params);
    const Image4 receivers = receiver(one, {16, 20}, 98, {0, 0, -1});
    SsaoInputs in;
    in.surface = &receivers, in.source_surface = &one.surface, in.camera = one.camera, in.pattern = &pattern;
    Image4 published, corrected, in_metres, in_halves;
    run(params, in, {}, published);
    params.length_unit = 1;
    run(params, in, {}, in_metres);
    params.length_unit = 0.5f;
    run(params, in, {}, in_halves);
    params.variant = Variant::corrected;
    run(params, in, {}, corrected);
    const glm::dvec3 d = one.ray(16, 16) * 100.0 - one.ray(16, 20) * 98.0;
    const double distance = std::sqrt(glm::dot(d, d)), cosine = -d.z / distance;
    const double side = one.camera.footprint * 100, ratio = side * side / M_PI / (distance * distance);
    // Accessibilities near 1 are rounded to 2^-24.
    CHECK(1 - double(corrected(16, 20).w) == Approx(ratio * cosine).margin(1e-7).epsilon(1e-3));
    const double printed = 2 * M_PI / pattern.samples * (1 - std::sqrt(1 - ratio)) * cosine;
    CHECK(1 - double(published(16, 20).w) == Approx(printed).margin(1e-7));
    CHECK(1 - double(in_metres(16, 20).w) == Approx(printed * distance).margin(1e-7));
    CHECK(1 - double(in_halves(16, 20).w) == Approx(printed * distance * 2).margin(1e-7));
}
