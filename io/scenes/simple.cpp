// Small closed scenes whose light is known: a box, a box with two shapes, and furnaces.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/host_math.h"
#include "io/scenes/builder.h"
#include "io/scenes/generate.h"

namespace plumb::io::scenes {
namespace {

constexpr double half_side = 1;      // m: rooms are 2 m wide
constexpr double lamp_half = 0.25;   // m: patches of the ceiling whose centre is nearer to its middle are the lamp

Material diffuse(const std::string& name, const glm::vec3& reflectance, const glm::vec3& emission = glm::vec3(0)) {
    Material m;
    m.name = name;
    m.reflectance = reflectance;
    m.emission = emission;
    return m;
}

Light lamp_light(const glm::vec3& intensity) {
    Light light;
    light.name = "lamp";
    light.type = LightType::spot;
    light.position = {0, float(2 * half_side - 0.02), 0};
    light.direction = {0, -1, 0};
    light.cone_inner_deg = 60, light.cone_outer_deg = 75;
    light.intensity = intensity;
    light.rsm_size = 1024;
    return light;
}

// Every point gathers from the whole map: half of the walls lie outside of what the lamp's map sees.
void gather_everywhere(Scene& scene) {
    scene.settings.push_back({"rsm", "radius", 1.0, scene.name});
    scene.settings.push_back({"rsm", "projection", std::string("clamped"), scene.name});
}

// n x n patches, corners shared within a wall.
void add_wall(Builder& b, const char* name, int n, int material, const std::array<Point, 4>& corners) {
    b.object(name);
    b.quad(material, Place(1), corners.data(), n, n, 2 * half_side);
}
void add_floor(Builder& b, int n, int white) {
    const double s = half_side;
    add_wall(b, "floor", n, white, {Point{-s, 0, s}, {s, 0, s}, {s, 0, -s}, {-s, 0, -s}});
}
void add_sides(Builder& b, int n, int white, int red, int green) {
    const double s = half_side, top = 2 * half_side;
    auto wall = [&](const char* name, int material, const Point& a, const Point& bb, const Point& c, const Point& d) {
        add_wall(b, name, n, material, {a, bb, c, d});
    };
    wall("back", white, {-s, 0, -s}, {s, 0, -s}, {s, top, -s}, {-s, top, -s});
    wall("front", white, {s, 0, s}, {-s, 0, s}, {-s, top, s}, {s, top, s});
    wall("left", red, {-s, 0, s}, {-s, 0, -s}, {-s, top, -s}, {-s, top, s});
    wall("right", green, {s, 0, -s}, {s, 0, s}, {s, top, s}, {s, top, -s});
}
// The room of HEM plate C.9 from inside: red on the left, green on the right, and a lamp in the middle of the ceiling that the
// builder does not know: it has the ceiling's vertices.
void add_room(Builder& b, int n, int white, int red, int green) {
    const double s = half_side, top = 2 * half_side;
    add_floor(b, n, white);
    add_wall(b, "ceiling", n, white, {Point{-s, top, -s}, {s, top, -s}, {s, top, s}, {-s, top, s}});
    add_sides(b, n, white, red, green);
}

// Turns patches of the ceiling into the lamp.
void light_ceiling(Scene& scene, int n, int lamp) {
    Mesh& ceiling = scene.meshes[1];
    auto centre = [&](int i) { return (i + 0.5) / n * 2 * half_side - half_side; };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            if (std::fabs(centre(i)) < lamp_half && std::fabs(centre(j)) < lamp_half)
                for (int k = 0; k < 2; ++k) ceiling.material[std::size_t(2 * (j * n + i) + k)] = lamp;
}

void look_into_room(Scene& scene) {
    // Just in front of the front wall, whose back side hides nothing: the camera is inside.
    scene.camera.position = {0, 1, 0.98};
    scene.camera.look_at = {0, 0.95, -1};
    scene.camera.fov_y_deg = 90;
    scene.camera.near = 0.01;
    scene.camera.far = 10;
    scene.frame_size = {768, 768};
}

int nearest_root(double x) { return std::max(1, int(std::floor(std::sqrt(std::max(x, 0.0)) + 0.5))); }

// A geodesic sphere: the faces of an icosahedron, cut into n^2 triangles each. Corners are shared: a corner is named by
// the icosahedron's corners that it lies between and its weights, so that two faces find the same one.
struct Geodesic {
    std::vector<Point> points;  // unit
    std::vector<glm::uvec3> triangles;
};
Geodesic geodesic(int n) {
    const double phi = (1 + std::sqrt(5.0)) / 2;
    const Point corners[12] = {{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0}, {0, -1, phi}, {0, 1, phi},
                               {0, -1, -phi}, {0, 1, -phi}, {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
    static constexpr int faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                         {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                         {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                         {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    Geodesic g;
    std::map<std::vector<int>, std::uint32_t> known;
    auto point = [&](const int* face, int i, int j) {
        std::vector<std::pair<int, int>> weights{{face[0], n - i - j}, {face[1], i}, {face[2], j}};
        std::sort(weights.begin(), weights.end());
        std::vector<int> name;
        Point sum(0);
        for (const auto& [corner, weight] : weights) {
            if (weight == 0) continue;
            name.insert(name.end(), {corner, weight});
            sum += double(weight) * corners[corner];
        }
        const auto [at, added] = known.try_emplace(name, std::uint32_t(g.points.size()));
        if (added) g.points.push_back(sum / std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z));
        return at->second;
    };
    for (const auto& face : faces)
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j) {
                g.triangles.push_back({point(face, i, j), point(face, i + 1, j), point(face, i, j + 1)});
                if (i + j + 1 < n)
                    g.triangles.push_back({point(face, i + 1, j), point(face, i + 1, j + 1), point(face, i, j + 1)});
            }
    return g;
}

// Appends a sphere to the scene as an object of its own. inside: its front faces the centre.
void add_sphere(Scene& scene, const std::string& name, int material, int n, const Point& centre, double radius,
                bool inside) {
    const Geodesic g = geodesic(n);
    Mesh mesh;
    mesh.name = name;
    for (const Point& p : g.points) {
        Vertex v;
        v.position = glm::vec3(centre + radius * p);
        v.normal = glm::vec3(inside ? -p : p);
        v.u = float(0.5 + host::atan2(p.x, p.z) / (2 * host::pi));
        v.v = float(host::acos(p.y) / host::pi);
        mesh.vertices.push_back(v);
    }
    for (glm::uvec3 t : g.triangles) {
        if (inside) std::swap(t.y, t.z);
        mesh.triangles.push_back(t);
        mesh.material.push_back(material);
    }
    scene.meshes.push_back(std::move(mesh));
}

// The torus of HEM plate C.10, tilted over the sphere.
void add_torus(Builder& b, int material, int columns, int rows) {
    b.object("torus");
    Grid ring;
    ring.columns = columns, ring.rows = rows;
    ring.closed_u = true;
    ring.texture = {6, 1};
    const double tilt = 0.35, major = 0.3, minor = 0.09;
    b.grid(material, move({0.05, 0.95, -0.3}), ring, [&](double u, double v) {
        const double a = 2 * host::pi * u, t = -2 * host::pi * v;
        const double r = major + minor * host::cos(t), y = minor * host::sin(t);
        const Point p(r * host::cos(a), y, r * host::sin(a));
        return Point(p.x * host::cos(tilt) - p.y * host::sin(tilt), p.x * host::sin(tilt) + p.y * host::cos(tilt), p.z);
    });
}

constexpr glm::vec3 hemicube_light{100.4f, 96.8f, 90.0f};  // W/m2: the colour of HEM plate C.10

// The ceiling as nine blocks with vertices of their own, the middle one the lamp: as a modeller leaves it who cut a lamp's four
// lines through it. With n^2 quads it has (n + 3)^2 vertices. Blocks' corners are the floats that one grid would have.
void add_cut_ceiling(Builder& b, int n, int white, int lamp) {
    const double s = half_side, top = 2 * half_side;
    const int wide = std::max(1, (n + 2) / 5), before = (n - wide) / 2;
    const int lines[4] = {0, before, before + wide, n};
    const auto along = [&](int i) { return (1 - double(i) / n) * -s + double(i) / n * s; };
    b.object("ceiling");
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            Grid g;
            g.columns = lines[column + 1] - lines[column], g.rows = lines[row + 1] - lines[row];
            g.texture = {double(g.columns) / n, double(g.rows) / n};
            b.grid(row == 1 && column == 1 ? lamp : white, Place(1), g, [&](double u, double v) {
                return Point(along(lines[column] + int(u * g.columns + 0.5)), top, along(lines[row] + int(v * g.rows + 0.5)));
            });
        }
}

// The box of HEM 5.8: 12 n^2 triangles and 6 n^2 + 16 n + 14 vertices, which five walls of (n + 1)^2 and a ceiling of
// (n + 3)^2 have. That the ceiling is cut so, and how large the lamp is, are guesses: the text gives the counts alone.
void add_hemicube_room(Builder& b, int n) {
    const int white = b.material(diffuse("white", glm::vec3(0.75f))),
              red = b.material(diffuse("red", {0.65f, 0.06f, 0.06f}));
    const int green = b.material(diffuse("green", {0.12f, 0.5f, 0.1f}));
    const int lamp = b.material(diffuse("lamp", glm::vec3(0.75f), hemicube_light));
    add_floor(b, n, white);
    add_sides(b, n, white, red, green);
    add_cut_ceiling(b, n, white, lamp);
}

constexpr glm::vec3 furnace_reflectance{0.5f}, furnace_exitance{1};

void look_into_furnace(Scene& scene) {
    scene.camera.position = {0, 0, 0.5};
    scene.camera.look_at = {0, 0, -1};
    scene.camera.fov_y_deg = 90;
    scene.camera.near = 0.01;
    scene.camera.far = 10;
    scene.frame_size = {512, 512};
}

}  // namespace

// HEM plate C.9: an empty box. 12 n^2 triangles; n = 10 is its tessellation of 1200 triangles.
Scene box(const GenerateOptions& options) {
    const int n = nearest_root(double(options.triangles) / 12);
    Builder b("box");
    const int white = b.material(diffuse("white", glm::vec3(0.75f))),
              red = b.material(diffuse("red", {0.65f, 0.06f, 0.06f}));
    const int green = b.material(diffuse("green", {0.12f, 0.5f, 0.1f}));
    const int lamp = b.material(diffuse("lamp", glm::vec3(0.75f), glm::vec3(40)));
    add_room(b, n, white, red, green);
    Scene scene = b.take();
    light_ceiling(scene, n, lamp);
    look_into_room(scene);
    scene.lights.push_back(lamp_light(glm::vec3(2.5f)));
    gather_everywhere(scene);
    return scene;
}

// HEM plate C.10: the box with a sphere on the floor's middle and a torus above it, under a lamp of the colour (100.4,
// 96.8, 90.0). The two throw shadows, one of them onto the other. Sizes are ours.
Scene shapes(const GenerateOptions& options) {
    // A wall takes n x n patches, the sphere 20 (2 n / 5)^2 triangles, the torus 3 n x n patches.
    int n = 1, frequency = 1;
    auto count = [](int n, int f) { return 12 * n * n + 20 * f * f + 6 * n * n; };
    auto frequency_of = [](int n) { return std::max(1, (2 * n + 2) / 5); };
    while (count(n + 1, frequency_of(n + 1)) <= options.triangles) ++n;
    frequency = frequency_of(n);
    Builder b("shapes");
    const int white = b.material(diffuse("white", glm::vec3(0.75f))),
              red = b.material(diffuse("red", {0.65f, 0.06f, 0.06f}));
    const int green = b.material(diffuse("green", {0.12f, 0.5f, 0.1f}));
    const int lamp = b.material(diffuse("lamp", glm::vec3(0.75f), {100.4f, 96.8f, 90.0f}));
    const int blue = b.material(diffuse("blue", {0.2f, 0.35f, 0.7f})),
              yellow = b.material(diffuse("yellow", {0.8f, 0.6f, 0.15f}));
    add_room(b, n, white, red, green);
    add_torus(b, yellow, 3 * n, n);
    Scene scene = b.take();
    add_sphere(scene, "sphere", blue, frequency, {0.05, 0.3, -0.3}, 0.3, false);
    light_ceiling(scene, n, lamp);
    look_into_room(scene);
    scene.lights.push_back(lamp_light({5.02f, 4.84f, 4.5f}));
    gather_everywhere(scene);
    return scene;
}

// HEM 5.8: n = 10, 20, 40, 50 are its tessellation factors 20, 10, 5, 4. No lamp but the ceiling's middle.
Scene hemicube_box(const GenerateOptions& options) {
    Builder b("hemicube_box");
    add_hemicube_room(b, std::max(3, nearest_root(double(options.triangles) / 12)));
    Scene scene = b.take();
    look_into_room(scene);
    return scene;
}

// HEM plate C.10 with n x n patches a wall, a sphere of 20 (4 n / 5)^2 triangles and a torus of 5 n x 5 n / 2 quads. n = 10 has
// 2,742 vertices: the plate took 3.5 times as long as C.9, which is 2,709 at C.9's time a vertex if that had 774.
Scene hemicube_shapes(const GenerateOptions& options) {
    const int n = std::max(3, nearest_root(double(options.triangles) / 49.8));
    Builder b("hemicube_shapes");
    add_hemicube_room(b, n);
    const int blue = b.material(diffuse("blue", {0.2f, 0.35f, 0.7f})),
              yellow = b.material(diffuse("yellow", {0.8f, 0.6f, 0.15f}));
    add_torus(b, yellow, 5 * n, 5 * n / 2);
    Scene scene = b.take();
    add_sphere(scene, "sphere", blue, (4 * n + 2) / 5, {0.05, 0.3, -0.3}, 0.3, false);
    look_into_room(scene);
    return scene;
}

// A closed sphere of radius 1 m whose inside emits M everywhere and reflects rho: B = M / (1 - rho) everywhere.
Scene furnace(const GenerateOptions& options) {
    Builder b("furnace");
    const int wall = b.material(diffuse("wall", furnace_reflectance, furnace_exitance));
    Scene scene = b.take();
    add_sphere(scene, "sphere", wall, nearest_root(double(options.triangles) / 20), Point(0), 1, true);
    look_into_furnace(scene);
    return scene;
}

// The same with a cube of side 2 m.
Scene furnace_cube(const GenerateOptions& options) {
    Builder b("furnace_cube");
    const int wall = b.material(diffuse("wall", furnace_reflectance, furnace_exitance));
    const int n = nearest_root(double(options.triangles) / 12);
    b.object("cube");
    b.box(wall, Place(1), Point(-1), Point(1), 2, glm::ivec3(n));
    Scene scene = b.take();
    // Turn its front to the inside.
    for (Vertex& v : scene.meshes[0].vertices) v.normal = -v.normal;
    for (glm::uvec3& t : scene.meshes[0].triangles) std::swap(t.y, t.z);
    look_into_furnace(scene);
    return scene;
}

}  // namespace plumb::io::scenes
