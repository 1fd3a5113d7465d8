#include <catch2/catch.hpp>
#include <cmath>

#include "core/camera.h"
#include "core/host_math.h"

using namespace plumb;

namespace {

const Convention conventions[] = {Convention::vulkan, Convention::opengl, Convention::d3d11, Convention::d3d9,
                                  Convention::left_handed};

Camera skewed() {
    Camera c;
    c.position = {3, 2, -4}, c.look_at = {-1, 0.5, 2}, c.up = {0.2, 3, 0.1};
    c.fov_y_deg = 63, c.near = 0.25, c.far = 40;
    return c;
}

// A point at eye depth d, fractions (u, v) of the frame from its top left corner.
glm::dvec3 point_at(const Camera& c, double aspect, double u, double v, double d) {
    const CameraAxes a = axes(c);
    const double t = host::tan(c.fov_y_deg * host::pi / 360);
    return c.position + d * (a.forward + (2 * u - 1) * aspect * t * a.right + (1 - 2 * v) * t * a.up);
}

glm::dvec3 divide(const glm::dvec4& clip) { return glm::dvec3(clip) / clip.w; }

// Fails for NaN.
void require_near(double got, double expected, double tolerance) {
    CAPTURE(got, expected);
    REQUIRE(std::fabs(got - expected) <= tolerance);
}

}  // namespace

TEST_CASE("camera: the near plane maps to depth 0 and the far plane to 1, or the reverse", "[camera]") {
    for (bool reversed : {false, true})
        for (Convention convention : conventions) {
            Camera c = skewed();
            c.reversed_z = reversed;
            const glm::dmat4 clip = projection_matrix(c, 1.5, convention) * view_matrix(c, convention);
            const double low = convention == Convention::opengl ? -1 : 0;
            for (double u : {0.0, 0.3, 1.0}) {
                const glm::dvec3 at_near = point_at(c, 1.5, u, 0.2, c.near), at_far = point_at(c, 1.5, u, 0.9, c.far);
                require_near(divide(clip * glm::dvec4(at_near, 1)).z, reversed ? 1 : low, 1e-13);
                require_near(divide(clip * glm::dvec4(at_far, 1)).z, reversed ? low : 1, 1e-13);
            }
        }
}

TEST_CASE("camera: the corners of the frame are the corners of canonical clip space, y down", "[camera]") {
    const Camera c = skewed();
    const glm::dmat4 clip = make_view(c, 1.7).world_to_clip();
    for (double u : {0.0, 0.5, 1.0})
        for (double v : {0.0, 0.5, 1.0}) {
            const glm::dvec3 p = divide(clip * glm::dvec4(point_at(c, 1.7, u, v, 7), 1));
            require_near(p.x, 2 * u - 1, 1e-14);
            require_near(p.y, 2 * v - 1, 1e-14);
        }
}

TEST_CASE("camera: w is the linear eye depth in every convention", "[camera]") {
    const Camera c = skewed();
    const glm::dvec3 p(0.3, -0.7, 1.1);
    for (Convention convention : conventions) {
        const glm::dvec4 clip = projection_matrix(c, 1, convention) * view_matrix(c, convention) * glm::dvec4(p, 1);
        require_near(clip.w, linear_depth(c, p), 1e-14);
    }
}

TEST_CASE("camera: depth of a point between the planes has its closed form", "[camera]") {
    // far (d - near) / ((far - near) d): near 1, far 3, d 2 gives 3/4.
    Camera c;
    c.position = {0, 0, 0}, c.look_at = {0, 0, -1}, c.near = 1, c.far = 3;
    auto depth = [&] { return divide(make_view(c, 1).world_to_clip() * glm::dvec4(0, 0, -2, 1)).z; };
    require_near(depth(), 0.75, 1e-15);
    c.reversed_z = true;
    require_near(depth(), 0.25, 1e-15);
    c.far = INFINITY;  // near / d
    require_near(depth(), 0.5, 1e-15);
    c.reversed_z = false;
    require_near(depth(), 0.5, 1e-15);
}

TEST_CASE("camera: the projection tends to the infinite one as far grows", "[camera]") {
    for (bool reversed : {false, true})
        for (Convention convention : conventions) {
            Camera c = skewed();
            c.reversed_z = reversed, c.far = INFINITY;
            const glm::dmat4 limit = projection_matrix(c, 1.2, convention);
            for (double far : {1e3, 1e9, 1e300, 1.7e308}) {
                c.far = far;
                const glm::dmat4 m = projection_matrix(c, 1.2, convention);
                for (int i = 0; i < 16; ++i)
                    require_near(m[i / 4][i % 4], limit[i / 4][i % 4], 3 * c.near / far + 1e-16);
            }
        }
}

TEST_CASE("camera: clip depth inverts to linear depth", "[camera]") {
    for (bool reversed : {false, true})
        for (double far : {40.0, double(INFINITY)}) {
            Camera c = skewed();
            c.reversed_z = reversed, c.far = far;
            for (double d : {0.25, 1.0, 13.0, 39.0}) {
                const glm::dvec4 clip = make_view(c, 1).world_to_clip() * glm::dvec4(point_at(c, 1, 0.5, 0.5, d), 1);
                require_near(linear_depth_from_clip(c, clip.z / clip.w), d, 1e-11);
            }
            if (std::isinf(far)) REQUIRE(linear_depth_from_clip(c, reversed ? 0 : 1) == INFINITY);
        }
}

TEST_CASE("camera: every convention puts a point into the same pixel", "[camera][convention]") {
    const Camera c = skewed();
    const glm::ivec2 size(37, 21);
    const double aspect = double(size.x) / size.y;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (double inside : {0.02, 0.5, 0.98}) {
                const glm::dvec3 p = point_at(c, aspect, (x + inside) / size.x, (y + 1 - inside) / size.y, 3);
                for (Convention k : conventions) {
                    const glm::dmat4 projection = half_pixel_shift(size, k) * projection_matrix(c, aspect, k);
                    const glm::dvec4 clip = projection * view_matrix(c, k) * glm::dvec4(p, 1);
                    CAPTURE(rules(k).name, x, y, inside);
                    REQUIRE(pixel_from_window(window_from_clip(clip, size, k), size, k) == glm::ivec2(x, y));
                }
            }
}

TEST_CASE("camera: Direct3D 9 without its half-pixel shift is off by half a pixel", "[camera][convention]") {
    const Camera c = skewed();
    const glm::dvec3 p = point_at(c, 1, 0.7 / 8, 0.7 / 8, 3);  // in pixel (0, 0) of 8 x 8, beyond its centre
    const Convention k = Convention::d3d9;
    const glm::dvec4 clip = projection_matrix(c, 1, k) * view_matrix(c, k) * glm::dvec4(p, 1);
    REQUIRE(pixel_from_window(window_from_clip(clip, {8, 8}, k), {8, 8}, k) == glm::ivec2(1, 1));
}

TEST_CASE("camera: view space is right-handed looking along -z, or left-handed along +z", "[camera][convention]") {
    const Camera c = skewed();
    for (Convention k : conventions) {
        const glm::dmat4 view = view_matrix(c, k);
        const bool left = rules(k).view_left_handed;
        require_near(glm::determinant(glm::dmat3(view)), left ? -1 : 1, 1e-14);
        require_near((view * glm::dvec4(c.look_at, 1)).z, (left ? 1 : -1) * glm::length(c.look_at - c.position), 1e-14);
    }
    REQUIRE(view_matrix(c)[0][3] == 0);
}

TEST_CASE("camera: the ray through a pixel centre projects back onto it", "[camera]") {
    const Camera c = skewed();
    const glm::ivec2 size(40, 30);
    const glm::dmat4 clip = make_view(c, 4. / 3).world_to_clip();
    for (int y = 0; y < size.y; y += 7)
        for (int x = 0; x < size.x; x += 3) {
            const Ray ray = ray_through_pixel(c, size, {x, y});
            require_near(glm::length(ray.direction), 1, 1e-15);
            const glm::dvec4 p = clip * glm::dvec4(ray.origin + 5. * ray.direction, 1);
            const glm::dvec2 window = window_from_clip(p, size, Convention::vulkan);
            require_near(window.x, x + 0.5, 1e-12);
            require_near(window.y, y + 0.5, 1e-12);
        }
}

TEST_CASE("camera: the orthographic box maps to the corners of clip space", "[camera]") {
    for (bool reversed : {false, true})
        for (Convention k : conventions) {
            const OrthographicBox box{2, 3, -1, 7, reversed};
            const bool left = rules(k).view_left_handed;
            const glm::dmat4 m = orthographic_matrix(box, k);
            auto at = [&](double x, double y, double d) { return m * glm::dvec4(x, y, left ? d : -d, 1); };
            const glm::dvec4 p = at(2, 3, -1), q = at(-2, -3, 7);
            const double low = k == Convention::opengl ? -1 : 0, y = rules(k).clip_y_up ? 1 : -1;
            REQUIRE(p.w == 1);
            require_near(p.x, 1, 1e-15), require_near(q.x, -1, 1e-15);
            require_near(p.y, y, 1e-15), require_near(q.y, -y, 1e-15);
            require_near(p.z, reversed ? 1 : low, 1e-15), require_near(q.z, reversed ? low : 1, 1e-15);
        }
}

TEST_CASE("camera: validate names the field, its value and what is allowed", "[camera]") {
    auto refuses = [](auto change, const std::string& words) {
        Camera c;
        change(c);
        REQUIRE_THROWS_WITH(validate(c), Catch::Contains(words));
    };
    REQUIRE_NOTHROW(validate(Camera{}));
    refuses([](Camera& c) { c.position.x = NAN; }, "camera: position = [nan, 0, 5]: must be finite");
    refuses([](Camera& c) { c.look_at = c.position; }, "look_at");
    refuses([](Camera& c) { c.up = {0, 0, 0}; }, "up = [0, 0, 0]");
    refuses([](Camera& c) { c.up = {0, 0, -1e200}; }, "not parallel");
    refuses([](Camera& c) { c.fov_y_deg = 180; }, "fov_y_deg = 180");
    refuses([](Camera& c) { c.fov_y_deg = NAN; }, "fov_y_deg = nan");
    refuses([](Camera& c) { c.near = 0; }, "near = 0");
    refuses([](Camera& c) { c.near = c.far = INFINITY; }, "near = inf");
    refuses([](Camera& c) { c.far = 0.1; }, "far = 0.1: must be above near = 0.1 m, or inf");
    refuses([](Camera& c) { c.far = NAN; }, "far = nan");
}

TEST_CASE("convention: names parse, and an unknown one lists the known", "[convention]") {
    for (Convention k : conventions) REQUIRE(parse_convention(rules(k).name, "") == k);
    REQUIRE_THROWS_WITH(
        parse_convention("metal", "scene.toml: line 3"),
        "scene.toml: line 3: convention \"metal\" is unknown; expected one of vulkan, opengl, d3d11, d3d9, "
        "left_handed");
}
