// Closed forms of open scenes: lamps, the environment, mirrors and Phong's lobe; and of quadratures.
#include <fmt/format.h>

#include <cmath>

#include "core/host_math.h"
#include "core/number.h"
#include "gi/reference/closed_form_scenes.h"

namespace plumb::reference {
namespace {

using Point = glm::dvec3;
using host::pi;

const Point up{0, 1, 0};
constexpr double degrees = pi / 180;

PointMaker point_maker(const Point& position, const Point& normal) {
    return [=](std::uint64_t n) { return repeated(position, normal, n); };
}

// ---- Lamps over a floor -------------------------------------------------------------------------------------------

Light spot_lamp(const Point& position, double intensity, double inner_deg, double outer_deg) {
    Light light;
    light.position = glm::vec3(position);
    light.intensity = glm::vec3(float(intensity));
    light.cone_inner_deg = float(inner_deg), light.cone_outer_deg = float(outer_deg);
    return light;
}

// Irradiance on the floor from a lamp of intensity 1 at height h, r aside.
double from_height(double h, double r) {
    const double d2 = h * h + r * r;
    return h / (d2 * std::sqrt(d2));
}

double smoothstep(double low, double high, double x) {
    const double t = std::fmin(std::fmax((x - low) / (high - low), 0), 1);
    return t * t * (3 - 2 * t);
}

void add_lamps(ClosedFormList& list) {
    auto add = [&](const std::string& name, const std::string& source, double expected, const Point& at,
                   const std::vector<Light>& lights, bool roofed = false) {
        list.add("lamp: " + name, source, "W/m2", expected, [=](const ClosedFormOptions& options) {
            Scene scene;
            add_rectangle(scene, grey(0.5), {-10, 0, -10}, {10, 0, 10});
            if (roofed) add_rectangle(scene, grey(0.5), {-1, 0.5, -1}, {1, 0.5, 1});
            scene.lights = lights;
            return trace_points(scene, Mode::direct, point_maker(at, up), options);
        });
    };
    const Light point = point_lamp({0, 1, 0}, 100);
    for (double r : {0.0, 1.0, 5.0})
        add(fmt::format("point, {} aside", r), "P/(4 pi) h / (h^2 + r^2)^(3/2)", 100 / (4 * pi) * from_height(1, r),
            {r, 0, 0}, {point});
    add("point behind a roof", "0", 0, Point(0), {point}, true);

    // Full intensity up to 20 degrees, none from 40.
    const double inner = host::cos(20 * degrees), outer = host::cos(40 * degrees);
    for (double angle : {10.0, 30.0, 45.0}) {
        const double r = 2 * host::tan(angle * degrees);
        add(fmt::format("spot, {} degrees off its axis", angle), "I smoothstep h / (h^2 + r^2)^(3/2)",
            50 * smoothstep(outer, inner, host::cos(angle * degrees)) * from_height(2, r), {r, 0, 0},
            {spot_lamp({0, 2, 0}, 50, 20, 40)});
    }
    Light sun;
    sun.type = LightType::directional;
    sun.direction = {0.8f, -0.6f, 0};
    sun.intensity = glm::vec3(3);
    add("directional, at a cosine of 0.6", "E cos", 1.8, {0, 0, 1}, {sun});
    // One of them is chosen at random.
    add("all three kinds", "sum", 1.8 + 100 / (4 * pi) * from_height(1, 1) + 50 * from_height(2, 0.5), {0.5, 0, 0},
        {point_lamp({-0.5, 1, 0}, 100), sun, spot_lamp({0.5, 2, 0.5}, 50, 20, 40)});
}

// ---- The environment ----------------------------------------------------------------------------------------------

// A map that is black but for one patch, which may be a whole row or column.
Image4 map_of(int width, int height, int column, int row) {
    Image4 map(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if ((column < 0 || x == column) && (row < 0 || y == row)) map(x, y) = glm::vec4(1, 1, 1, 0);
    return map;
}

void add_environment(ClosedFormList& list) {
    auto add = [&](const std::string& name, const std::string& source, double expected, const Point& normal,
                   const Image4& map, std::function<void(Scene&)> build = {}) {
        list.add("environment: " + name, source, "W/m2", expected, [=](const ClosedFormOptions& options) {
            Scene scene;
            if (build)
                build(scene);
            else
                // Rays need a scene; this one lies behind the point's back.
                add_rectangle(scene, grey(0), Point(-1, 0, -1) - 9.0 * normal, Point(1, 0, 1) - 9.0 * normal);
            scene.environment = {glm::vec3(1), map};
            return trace_points(scene, Mode::direct, point_maker(Point(0), normal), options);
        });
    };
    const Image4 uniform, upper = map_of(1, 2, -1, 0), zone = map_of(1, 4, -1, 1), sector = map_of(8, 1, 4, -1);
    add("uniform sky", "pi L", pi, up, uniform);
    add("upper half of the sky, a wall", "pi L / 2", pi / 2, {1, 0, 0}, upper);
    add("45 to 90 degrees from the zenith", "pi L (sin^2 90 - sin^2 45)", pi / 2, up, zone);
    // Longitudes 0 to 45 degrees from -z towards +x. A wall gets L pi/2 times the integral of its normal's cosine.
    const double s = std::sqrt(0.5);
    add("an eighth of all longitudes, the floor", "pi L / 8", pi / 8, up, sector);
    add("an eighth of all longitudes, a wall to +x", "L pi/2 (1 - cos 45)", pi / 2 * (1 - s), {1, 0, 0}, sector);
    add("an eighth of all longitudes, a wall to -z", "L pi/2 sin 45", pi / 2 * s, {0, 0, -1}, sector);
    add("an eighth of all longitudes, a wall to +z", "0", 0, {0, 0, 1}, sector);
    add("through a square hole", "pi L F, Howell B-3", 4 * pi * to_parallel_rectangle(0.5, 0.5, 1), up, uniform,
        [](Scene& scene) {
            add_cube(scene, grey(0), {-2, -1, -2}, {2, 1, 2});
            // The cube without its top, and a lid with a hole.
            Mesh& cube = scene.meshes[0];
            std::erase_if(cube.triangles, [&](const glm::uvec3& t) {
                return cube.vertices[t.x].position.y == 1 && cube.vertices[t.y].position.y == 1 &&
                       cube.vertices[t.z].position.y == 1;
            });
            cube.material.resize(cube.triangles.size());
            add_frame(scene, grey(0), 1, 4, 1);
        });
    add("behind a unit square", "pi L (1 - F), Howell B-3", pi * (1 - 4 * to_parallel_rectangle(0.5, 0.5, 1)), up,
        uniform, [](Scene& scene) {
            add_rectangle(scene, grey(0), {-0.5, 1, -0.5}, {0.5, 1, 0.5});
        });
}

// ---- Mirrors and Phong's lobe -------------------------------------------------------------------------------------

Camera narrow_camera(const Point& position) {
    Camera camera;
    camera.position = position;
    camera.look_at = {0, 0, 0};
    camera.up = {0, 0, 1};
    camera.fov_y_deg = 0.01;
    return camera;
}

void add_glossy(ClosedFormList& list) {
    Material mirror = grey(0);
    mirror.mirror = glm::vec3(0.9f);
    // A floor that emits around the receiver and is black below it, seen in a ceiling 1 m above: its image is at 2 m.
    const double image = 4 * (to_parallel_rectangle(4, 4, 2) - to_parallel_rectangle(0.5, 0.5, 2));
    for (Mode mode : {Mode::one_bounce, Mode::all})
        list.add(fmt::format("mirror: emitter seen in a ceiling, {}", mode == Mode::all ? "all" : "one bounce"),
                 "k F to the image, Howell B-3", "W/m2", 0.9 * image, [=](const ClosedFormOptions& options) {
                     Scene scene;
                     add_frame(scene, grey(0, 1), 0, 8, 1);
                     add_rectangle(scene, mirror, {-8, 1, -8}, {8, 1, 8});
                     return trace_points(scene, mode, point_maker(Point(0), up), options);
                 });
    list.add("mirror: emitter seen by a camera", "k M / pi", "W/(m2 sr)", 0.9 * 2 / pi,
             [=](const ClosedFormOptions& options) {
                 Scene scene;
                 add_rectangle(scene, mirror, {-1, 0, -1}, {1, 0, 1});
                 add_rectangle(scene, grey(0, 2), {-5, 3, -5}, {-1, 3, 5});
                 return trace_frame(scene, narrow_camera({2, 2, 0}), options);
             });

    // Directional albedo k (n + 2)/(2 pi) times the integral of cos^n(alpha) cos(theta): k along the normal for every
    // n; for n = 1 at an angle b, k / pi (sin b + (pi - b) cos b).
    auto lobe = [&](const std::string& name, const std::string& source, double expected, float k, float exponent,
                    double rho, const Point& eye) {
        list.add("Phong: " + name, source, "W/(m2 sr)", expected, [=](const ClosedFormOptions& options) {
            Scene scene;
            Material m = grey(rho);
            m.specular = glm::vec3(k);
            m.exponent = exponent;
            add_rectangle(scene, m, {-1, 0, -1}, {1, 0, 1});
            scene.environment.radiance = glm::vec3(1);
            return trace_frame(scene, narrow_camera(eye), options);
        });
    };
    const double b = 60 * degrees, slant = (host::sin(b) + (pi - b) * host::cos(b)) / pi;
    for (double n : {1.0, 50.0, 5000.0})
        lobe(fmt::format("uniform sky from above, n = {}", n), "k L", 0.8, 0.8f, float(n), 0, {0, 1, 0});
    lobe("uniform sky at 60 degrees, n = 1", "k L (sin b + (pi - b) cos b) / pi", 0.8 * slant, 0.8f, 1, 0,
         {2 * host::sin(b), 2 * host::cos(b), 0});
    lobe("uniform sky from above, n = 10 and rho 0.3", "(rho + k) L", 0.8, 0.5f, 10, 0.3, {0, 1, 0});
    lobe("diffuse, uniform sky at 60 degrees", "rho L", 0.7, 0, 1, 0.7, {2 * host::sin(b), 2 * host::cos(b), 0});
}

// ---- Quadratures --------------------------------------------------------------------------------------------------

// A wall of radiosity 1 W/m2 at x = 0, y in [0, 1], z in [-1/2, 1/2], facing +x, as n x n pixel lights.
raster::Rsm unit_wall(int n) {
    raster::Rsm map;
    map.size = n;
    map.records.assign(std::size_t(record_stride) * n * n, 0.0f);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            float* r = map.records.data() + record_stride * (std::size_t(j) * n + i);
            r[1] = float((j + 0.5) / n), r[2] = float((i + 0.5) / n - 0.5);
            r[4] = 1;
            for (int c = 0; c < 3; ++c) r[8 + c] = float(1.0 / n / n);
        }
    return map;
}

}  // namespace

void add_open_scenes(ClosedFormList& list) {
    add_lamps(list);
    add_environment(list);
    add_glossy(list);
}

void add_quadratures(ClosedFormList& list) {
    // The errors that these quadratures have by themselves, verification.md 3.
    struct Row {
        int size;
        double distance, error;
    };
    for (const Row& row : {Row{16, 0.5, 0.00206},
                           {64, 0.5, 0.00014},
                           {256, 0.5, 0.00002},
                           {16, 0.02, 0.118},
                           {64, 0.02, 0.0318},
                           {256, 0.02, 0.00167}})
        list.add_quadrature(
            fmt::format("rsm.all: unit wall of {0} x {0} texels, {1} from its foot", row.size, row.distance),
            "Howell B-4", "W/m2", 2 * to_perpendicular_rectangle(0.5, 1, row.distance), row.error,
            [=](const ClosedFormOptions& options) {
                return gather_maps({unit_wall(row.size)}, repeated({row.distance, 0, 0}, up, 1), options);
            });

    // A screen halfway to the wall hides its lower half: its shadow's edge lies between two rows of texels.
    const double upper_half = 2 * (to_perpendicular_rectangle(0.5, 1, 0.5) - to_perpendicular_rectangle(0.5, 0.5, 0.5));
    auto behind_screen = [](const ClosedFormOptions& options, std::uint64_t paths, double texels_asked) {
        Scene scene;
        add_rectangle(scene, grey(0), {0.25, 0, -1}, {0.25, 0.25, 1});
        const ReceiverPoints points = repeated({0.5, 0, 0}, up, paths);
        return gather_maps({unit_wall(256)}, points, options,
                           {&scene, float(texels_asked * double(points.position.size()))});
    };
    list.add_quadrature("rsm.all_rays: unit wall behind a screen, every texel", "Howell B-4, upper half", "W/m2",
                        upper_half, 0.0001, [=](const ClosedFormOptions& o) { return behind_screen(o, 1, 0); });
    // A point's subset errs by 0.37 %; `repeated` makes a point of 256 paths.
    list.add("rsm.all_rays: unit wall behind a screen, subsets of 1024 texels", "Howell B-4, upper half", "W/m2",
             upper_half, [=](const ClosedFormOptions& o) {
                 return behind_screen(o, std::uint64_t(256 * 1.4e-5 / (o.error * o.error)), 1024);
             });

    list.add_quadrature("rsm.all: unit wall in a directional light, as drawn", "rho E F, Howell B-4", "W/m2",
                        2 * to_perpendicular_rectangle(0.5, 1, 0.5), 0.002, [](const ClosedFormOptions& options) {
                            Scene scene;
                            add_rectangle(scene, grey(0.5), {0, 0, -0.5}, {0, 1, 0.5});
                            Light sun;
                            sun.type = LightType::directional;
                            sun.direction = {-1, 0, 0};
                            sun.intensity = glm::vec3(2);
                            sun.rsm_size = 1024;
                            scene.lights.push_back(sun);
                            return gather_points(scene, repeated({0.5, 0, 0}, up, 1), options);
                        });
    for (const Point& at : {Point(0, 0, 0), Point(0.3, 0.2, -0.4)})
        list.add_quadrature(fmt::format("rsm.all: lamp at ({}, {}, {}) in a sphere, rho 0.8", at.x, at.y, at.z),
                            "(P/A) rho", "W/m2", 100 / (4 * pi) * 0.8, 0.002, [=](const ClosedFormOptions& options) {
                                Scene scene;
                                add_sphere(scene, grey(0.8), Point(0), 1);
                                Light lamp = point_lamp(at, 100);
                                lamp.rsm_size = 128;
                                scene.lights.push_back(lamp);
                                return gather_points(scene, spread(scene.meshes[0], Point(0), 8192), options);
                            });
}

}  // namespace plumb::reference
