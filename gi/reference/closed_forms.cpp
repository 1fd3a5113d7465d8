#include "gi/reference/closed_forms.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "core/content_hash.h"
#include "core/host_math.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/form_factors.h"

namespace plumb::reference {
namespace {

using Point = glm::dvec3;
using host::pi;

constexpr double rounding = 4e-6;  // relative: floats in the scene, on the way, and in the result

// ---- Form factors -------------------------------------------------------------------------------------------------

double to_centred_square(double side, double distance) {
    return 4 * to_parallel_rectangle(side / 2, side / 2, distance);
}
double to_wall_from_foot(double distance) { return 2 * to_perpendicular_rectangle(0.5, 1, distance); }

double to_sphere(double radius, double height, double offset) {
    const double d2 = height * height + offset * offset;
    return radius * radius * height / (d2 * std::sqrt(d2));
}

const Point up{0, 1, 0};

// The shapes that a point at the origin, looking up, sees as an emitter or as what hides the sky.
void add_unit_square(Scene& scene, const Material& m) { add_rectangle(scene, m, {-0.5, 1, -0.5}, {0.5, 1, 0.5}); }
// Its foot runs through (-distance, 0, 0).
void add_wall(Scene& scene, const Material& m, double distance, double half_length = 0.5) {
    add_rectangle(scene, m, {-distance, 0, -half_length}, {-distance, 1, half_length});
}

using Shape = std::function<void(Scene&, const Material&)>;

// Of the point at the origin, by irradiance under a shape that emits 1 W/m2, and by what the shape hides.
void add_shape(ClosedFormList& list, const std::string& name, const std::string& source, double factor,
               const Shape& shape) {
    const PointMaker origin = [](std::uint64_t n) { return repeated(Point(0), up, n); };
    list.add("form factor: " + name, source, "W/m2", factor, [=](const ClosedFormOptions& options) {
        Scene scene;
        shape(scene, grey(0, 1));
        return trace_points(scene, Mode::direct, origin, options);
    });
    list.add("openness: " + name, "1 - F", "", 1 - factor, [=](const ClosedFormOptions& options) {
        Scene scene;
        shape(scene, grey(0));
        return trace_points(scene, Mode::ambient_occlusion, origin, options);
    });
}

void add_form_factors(ClosedFormList& list) {
    add_shape(list, "unit square at 1", "Howell B-3", to_centred_square(1, 1), add_unit_square);
    for (double d : {0.25, 0.5, 2.0})
        add_shape(list, fmt::format("disc of radius 0.5 at {}", d), "a^2 / (a^2 + d^2)", patch_to_disc(0.5, d),
                  [=](Scene& s, const Material& m) { add_disc(s, m, d, 0.5); });
    for (double d : {0.5, 0.02})
        add_shape(list, fmt::format("unit wall, {} from its foot", d), "Howell B-4", to_wall_from_foot(d),
                  [=](Scene& s, const Material& m) { add_wall(s, m, d); });
    // A wall 100 m long lacks h^2 d / (3 pi 50^3) = 8e-7.
    for (double d : {1.0, 0.25})
        add_shape(list, fmt::format("endless wall of height 1 at {}", d), "(1 - d / sqrt(d^2 + h^2)) / 2",
                  (1 - d / std::sqrt(d * d + 1)) / 2, [=](Scene& s, const Material& m) { add_wall(s, m, d, 50); });
    struct Ball {
        double radius, height, aside;
    };
    for (const Ball& b : {Ball{0.5, 1, 0}, {0.5, 1, 1}, {0.5, 0.5, 0.75}})
        add_shape(list, fmt::format("sphere of radius {} at height {}, {} aside", b.radius, b.height, b.aside),
                  "R^2 h / (h^2 + s^2)^(3/2)", to_sphere(b.radius, b.height, b.aside),
                  [=](Scene& s, const Material& m) {
                      add_sphere(s, m, {b.aside, b.height, 0}, b.radius, 5);
                  });

    // Between two squares: the mean over points of one of them.
    const Shape floor = [](Scene& s, const Material& m) { add_rectangle(s, m, {-0.5, 0, -0.5}, {0.5, 0, 0.5}); };
    auto between = [&](const std::string& name, const std::string& source, double factor, const Shape& emitter) {
        list.add("form factor: " + name, source, "W/m2", factor, [=](const ClosedFormOptions& options) {
            Scene scene;
            floor(scene, grey(0));
            emitter(scene, grey(0, 1));
            return trace_points(
                scene, Mode::direct, [&](std::uint64_t n) { return spread(scene.meshes[0], up, n); }, options);
        });
    };
    between("opposed unit squares", "Howell C-11", opposed_rectangles(1, 1, 1), add_unit_square);
    between("perpendicular unit squares", "Howell C-14", perpendicular_rectangles(1, 1, 1),
            [](Scene& s, const Material& m) { add_wall(s, m, 0.5); });
}

// ---- Closed rooms -------------------------------------------------------------------------------------------------

const std::vector<double> reflectances = {0, 0.2, 0.5, 0.8, 0.95, 0.99};

void add_furnaces(ClosedFormList& list) {
    auto add = [&](const std::string& name, double expected, const Material& wall, bool cube, int channel) {
        list.add("furnace: " + name, "M / (1 - rho)", "W/m2", expected, [=](const ClosedFormOptions& options) {
            Scene scene;
            if (cube)
                add_cube(scene, wall, Point(-1), Point(1));
            else
                add_sphere(scene, wall, Point(0), 1);
            return trace_points(
                scene, Mode::all, [&](std::uint64_t n) { return spread(scene.meshes[0], Point(0), n); }, options,
                channel);
        });
    };
    for (double rho : reflectances) {
        add(fmt::format("cube, rho {}", rho), 1 / (1 - rho), grey(rho, 1), true, 0);
        add(fmt::format("sphere, rho {}", rho), 1 / (1 - rho), grey(rho, 1), false, 0);
    }
    Material coloured;
    coloured.reflectance = {0.8f, 0.5f, 0.2f};
    coloured.emission = {1, 2, 3};
    for (int c = 0; c < 3; ++c)
        add(fmt::format("cube, {} of three colours", c == 0   ? "red"
                                                     : c == 1 ? "green"
                                                              : "blue"),
            double(coloured.emission[c]) / (1 - double(coloured.reflectance[c])), coloured, true, c);
    // Radiance M / (pi (1 - rho)) in every direction feeds a mirror as it feeds a diffuse wall.
    Material mirror = grey(0.3, 1);
    mirror.mirror = glm::vec3(0.5f);
    add("cube, rho 0.3 and mirror 0.5", 1 / (1 - 0.8), mirror, true, 0);
}

// A point does not see its own triangle, whose share of the sphere goes to the others. Where the light on it is a
// multiple of the mean, that errs by as many times 1/20480.
constexpr int fine = 5;

PointMaker at_triangle(const Mesh& mesh, std::size_t triangle) {
    const SurfacePoint p = middle_of(mesh, triangle, Point(0));
    return [=](std::uint64_t paths) { return repeated(p.position, p.normal, paths); };
}

// A sphere of radius 1 whose upper half, material 1, emits 1 W/m2.
Scene half_emitting_sphere(double rho) {
    Scene scene;
    add_sphere(scene, grey(rho), Point(0), 1, fine);
    scene.materials.push_back(grey(rho, 1));
    Mesh& wall = scene.meshes[0];
    for (std::size_t t = 0; t < wall.triangles.size(); ++t)
        wall.material[t] = middle_of(wall, t, Point(0)).position.y > 0;
    return scene;
}

struct SphereLamp {
    Point position{0};
    std::size_t triangle = 0;  // the receiver
    Mode mode = Mode::indirect;
};

// A lamp of 100 W in a sphere of radius 1: each point of the wall sends 1 / A of its flux to every other.
void add_lamp_in_sphere(ClosedFormList& list, const std::string& name, const std::string& source, double rho,
                        double expected, const SphereLamp& lamp) {
    list.add("sphere: " + name, source, "W/m2", expected, [=](const ClosedFormOptions& options) {
        Scene scene;
        add_sphere(scene, grey(rho), Point(0), 1, fine);
        scene.lights.push_back(point_lamp(lamp.position, 100));
        return trace_points(scene, lamp.mode, at_triangle(scene.meshes[0], lamp.triangle), options);
    });
}

void add_spheres(ClosedFormList& list) {
    const double mean = 100 / (4 * pi);  // P / A
    const Point places[] = {{0, 0, 0}, {0.3, 0.2, -0.4}, {0, -0.5, 0}};
    for (std::size_t i = 0; i < reflectances.size(); ++i) {
        const double rho = reflectances[i];
        const Point& at = places[i % 3];
        add_lamp_in_sphere(list, fmt::format("lamp at ({}, {}, {}), rho {}", at.x, at.y, at.z, rho),
                           "(P/A) rho / (1 - rho)", rho, mean * rho / (1 - rho), {at, 3000 * i, Mode::indirect});
    }
    for (std::size_t triangle : {400, 10400, 20000})
        add_lamp_in_sphere(list, fmt::format("lamp at (0, -0.5, 0), rho 0.8, triangle {}", triangle),
                           "(P/A) rho / (1 - rho)", 0.8, mean * 4, {places[2], triangle, Mode::indirect});
    add_lamp_in_sphere(list, "lamp at (0.3, 0.2, -0.4), rho 0.8, one bounce", "(P/A) rho", 0.8, mean * 0.8,
                       {places[1], 5000, Mode::one_bounce});
    add_lamp_in_sphere(list, "lamp at (0, 0, 0), rho 0.8, all", "(P/A) / (1 - rho)", 0.8, mean * 5,
                       {places[0], 17000, Mode::all});

    // B = E + rho / (1 - rho) mean(E), so that the irradiance is mean(E) / (1 - rho) everywhere. Triangles make the
    // border of the halves jagged: 3000, in the dark one, and 14000, in the other, lie far from it.
    for (double rho : {0.5, 0.95})
        for (std::size_t triangle : {3000, 14000}) {
            const Scene scene = half_emitting_sphere(rho);
            const Mesh& wall = scene.meshes[0];
            list.add(fmt::format("sphere: half of it emits, rho {}, triangle {}", rho, triangle), "mean(E) / (1 - rho)",
                     "W/m2", area(wall, 1) / area(wall) / (1 - rho), [=](const ClosedFormOptions& options) {
                         return trace_points(scene, Mode::all, at_triangle(scene.meshes[0], triangle), options);
                     });
        }
}

// Radii 0.5 and 1. The outer wall is asked by its mean, the inner one, from which nothing else of it is seen, at a
// point.
void add_concentric(ClosedFormList& list) {
    auto add = [&](const std::string& name, const std::string& source, double expected, const Material& inner,
                   const Material& outer, bool at_outer, Mode mode) {
        list.add("concentric spheres: " + name, source, "W/m2", expected, [=](const ClosedFormOptions& options) {
            Scene scene;
            add_sphere(scene, inner, Point(0), 0.5);
            add_sphere(scene, outer, Point(0), 1);
            const SurfacePoint p = middle_of(scene.meshes[0], 777, Point(0));
            return trace_points(
                scene, mode,
                [&](std::uint64_t n) {
                    return at_outer ? spread(scene.meshes[1], Point(0), n) : repeated(p.position, -p.normal, n);
                },
                options);
        });
    };
    add("F12", "1", 1, grey(0), grey(0, 1), false, Mode::direct);
    add("F21", "(r1 / r2)^2", 0.25, grey(0, 1), grey(0), true, Mode::direct);
    add("F22", "1 - F21", 0.75, grey(0), grey(0, 1), true, Mode::direct);
    // B1 = 1 + rho H1, B2 = rho H2; H1 = B2, H2 = F21 B1 + F22 B2.
    add("H1 at rho 0.5", "B2 = 2/9", 2.0 / 9, grey(0.5, 1), grey(0.5), false, Mode::all);
    add("H2 at rho 0.5", "B2 / rho = 4/9", 4.0 / 9, grey(0.5, 1), grey(0.5), true, Mode::all);
}

void add_cubes(ClosedFormList& list) {
    for (double rho : {0.5, 0.8, 0.95, 0.99})
        list.add(fmt::format("unit cube: one face emits, rho {}", rho), "mean of all walls: 1 / (6 (1 - rho))", "W/m2",
                 1 / (6 * (1 - rho)), [=](const ClosedFormOptions& options) {
                     Scene scene;
                     add_cube(scene, grey(rho), Point(0), Point(1));
                     scene.materials.push_back(grey(rho, 1));
                     scene.meshes[0].material[0] = scene.meshes[0].material[1] = 1;
                     return trace_points(
                         scene, Mode::all, [&](std::uint64_t n) { return spread(scene.meshes[0], Point(0.5), n); },
                         options);
                 });
    // A cube of 4 m with a lamp of 10,000 lm in its middle; lumens stand for watts.
    auto cie = [&](const std::string& name, const std::string& source, double rho, double expected) {
        list.add("CIE 171:2006 case 5.8: " + name, source, "lx", expected, [=](const ClosedFormOptions& options) {
            Scene scene;
            add_cube(scene, grey(rho), Point(-2), Point(2));
            scene.lights.push_back(point_lamp(Point(0), 10000));
            return trace_points(
                scene, Mode::indirect, [&](std::uint64_t n) { return spread(scene.meshes[0], Point(0), n); }, options);
        });
    };
    for (double rho : {0.2, 0.5, 0.8, 0.95, 0.99})
        cie(fmt::format("indirect, rho {}", rho), "(P/S) rho / (1 - rho)", rho, 10000.0 / 96 * rho / (1 - rho));
}

}  // namespace

double to_parallel_rectangle(double a, double b, double distance) {
    const double x = a / distance, y = b / distance, sx = std::sqrt(1 + x * x), sy = std::sqrt(1 + y * y);
    return (x / sx * host::atan(y / sx) + y / sy * host::atan(x / sy)) / (2 * pi);
}
double to_perpendicular_rectangle(double width, double height, double distance) {
    const double slant = std::sqrt(height * height + distance * distance);
    return (host::atan(width / distance) - distance / slant * host::atan(width / slant)) / (2 * pi);
}

std::vector<ClosedForm> closed_forms() {
    ClosedFormList list;
    add_form_factors(list);
    add_furnaces(list);
    add_spheres(list);
    add_concentric(list);
    add_cubes(list);
    add_open_scenes(list);
    add_quadratures(list);
    return list.forms;
}

Measured measure(const ClosedForm& form, const ClosedFormOptions& options) {
    ClosedFormOptions own = options;
    own.seed = std::uint32_t(content_hash(form.name.data(), form.name.size(), options.seed));
    const auto start = std::chrono::steady_clock::now();
    Measured measured = form.run(own);
    measured.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return measured;
}

Verdict judge(const ClosedForm& form, const Measured& measured, double max_sigmas) {
    const double difference = measured.got - form.expected, scale = form.expected == 0 ? 1 : std::fabs(form.expected);
    const double rounded = rounding * std::fabs(form.expected);
    const double error = std::sqrt(measured.standard_error * measured.standard_error + rounded * rounded);
    Verdict v;
    v.relative = difference / scale;
    v.sigmas = difference == 0 ? 0 : difference / error;
    v.agrees = measured.nonfinite == 0 && std::isfinite(error) && std::fabs(v.relative) <= form.bound &&
               (!form.statistical || std::fabs(v.sigmas) <= max_sigmas);
    return v;
}

bool is_noisy(const ClosedForm& form, const Measured& measured) {
    return form.statistical && measured.standard_error > 25 * rounding * std::fabs(form.expected);
}

}  // namespace plumb::reference
