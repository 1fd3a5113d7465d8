// Degenerate and extreme triangles, for the eye and for `plumb stability`: sixteen cells of a shelf, a case a cell.
//
//     zero area          slivers            a fan of one point   a million pixels wide
//     coincident         nested depths      thin gaps            far away
//     tiny               checkered edges    crossing the near    w = 0 and w < 0
//                                           plane
//     normals away       opposed normals    T junctions          one pixel each
#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "io/scenes/builder.h"
#include "io/scenes/generate.h"

namespace plumb::io::scenes {
namespace {

constexpr int side = 4;           // cells a row
constexpr int far_away = 7;       // a cell
constexpr double pitch = 1;       // m
constexpr double eye_depth = 5;   // the camera's distance from the shelf, m

Material diffuse(const std::string& name, const glm::vec3& reflectance) {
    Material m;
    m.name = name;
    m.reflectance = reflectance;
    return m;
}

// A shelf of triangles that are kept whatever they are: the builder leaves out those of no area.
struct Shelf {
    Scene scene;
    int cell = -1;
    Point centre{0};

    void begin(const char* name) {
        ++cell;
        const int column = cell % side, row = cell / side;
        centre = {(column - (side - 1) / 2.0) * pitch, ((side - 1) / 2.0 - row) * pitch, 0};
        Mesh mesh;
        mesh.name = name;
        scene.meshes.push_back(mesh);
        Material m = diffuse(name, glm::vec3(0));
        // Sixteen hues: the cells are told apart by colour.
        for (int c = 0; c < 3; ++c)
            m.reflectance[c] = float(0.45 + 0.35 * host::cos(2 * host::pi * (cell / 16.0 + c / 3.0)));
        scene.materials.push_back(m);
    }
    // Corners relative to the cell's centre, in metres.
    void add(const Point& a, const Point& b, const Point& c, const glm::vec3& normal = {0, 0, 1}) {
        Mesh& mesh = scene.meshes.back();
        const std::uint32_t first = std::uint32_t(mesh.vertices.size());
        for (const Point& p : {a, b, c}) {
            Vertex v;
            v.position = glm::vec3(centre + p);
            v.normal = normal;
            mesh.vertices.push_back(v);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.material.push_back(std::int32_t(scene.materials.size()) - 1);
    }
    void square(const Point& low, const Point& high, const glm::vec3& normal = {0, 0, 1}) {
        add(low, {high.x, low.y, low.z}, high, normal);
        add(low, high, {low.x, high.y, high.z}, normal);
    }
};

Point on_circle(double radius, double turns, double z = 0) {
    return {radius * host::cos(2 * host::pi * turns), radius * host::sin(2 * host::pi * turns), z};
}

void degenerate_cells(Shelf& s, int n) {
    // Points and lines among visible triangles: they must leave no mark.
    s.begin("zero_area");
    for (int i = 0; i < n / 2; ++i) {
        const Point p = on_circle(0.4 * (i + 0.5) / (n / 2), i * 0.618034);
        s.add(p, p, p);
        s.add(p, p + Point(0.1, 0, 0), p + Point(0.2, 0, 0));
    }
    s.square({-0.2, -0.2, -0.01}, {0.2, 0.2, -0.01});

    s.begin("slivers");
    for (int i = 0; i < n; ++i) {
        const double y = -0.4 + 0.8 * i / n;
        s.add({-0.4, y, 0}, {0.4, y + 0.8 / n * 1e-3, 0}, {0.4, y + 0.8 / n, 0});
    }

    s.begin("fan");
    for (int i = 0; i < n; ++i) s.add({0, 0, 0}, on_circle(0.42, double(i) / n), on_circle(0.42, double(i + 1) / n));

    // 10^4 m wide at a distance of 5 m, seen at an angle: about a million pixels.
    s.begin("wide");
    s.add({-1e4, -0.4, -0.5}, {1e4, -0.4, -0.5}, {0, -0.38, -0.5});
    s.add({0, -0.3, -0.2}, {0.3, 0.35, -0.2}, {-0.3, 0.35, -0.2});
}

void depth_cells(Shelf& s, int n) {
    // The first of a stack in one place is seen, whatever comes after it.
    s.begin("coincident");
    for (int i = 0; i < n / 2; ++i) s.square({-0.35, -0.35, 0}, {0.35, 0.35, 0});

    s.begin("nested");
    for (int i = 0; i < n / 2; ++i) {
        const double half = 0.4 * (1 - double(i) / (n / 2));
        s.square({-half, -half, i * 1e-6}, {half, half, i * 1e-6});
    }

    s.begin("thin_gaps");
    for (int i = 0; i < n / 2; ++i) {
        const double low = -0.4 + 0.8 * i / (n / 2), high = low + 0.8 / (n / 2) * 0.999;
        s.square({low, -0.4, 0}, {high, 0.4, 0});
    }

    // The same size on the screen at a thousand and at ten million metres.
    s.begin("far_away");
    for (double depth : {1e3, 1e5, 1e7}) {
        const double grow = (eye_depth + depth) / eye_depth, slot = depth == 1e3 ? -0.27 : depth == 1e5 ? 0 : 0.27;
        const Point eye_to_cell = s.centre + Point(slot, 0, 0);
        const Point low = (eye_to_cell + Point(-0.12, -0.3, 0)) * grow - s.centre;
        const Point high = (eye_to_cell + Point(0.12, 0.3, 0)) * grow - s.centre;
        s.square({low.x, low.y, -depth}, {high.x, high.y, -depth});
    }
}

void screen_cells(Shelf& s, int n) {
    s.begin("tiny");
    const int tiny = std::max(2, int(std::sqrt(n)));
    for (int j = 0; j < tiny; ++j)
        for (int i = 0; i < tiny; ++i) {
            const Point p(-0.4 + 0.8 * i / tiny, -0.4 + 0.8 * j / tiny, 0);
            s.add(p, p + Point(0.2 / tiny, 0, 0), p + Point(0, 0.2 / tiny, 0));
        }

    // Neighbours with alternating diagonals: every inner edge is shared.
    s.begin("checkered_edges");
    const int cells = std::max(2, int(std::sqrt(n / 2)));
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            auto corner = [&](int a, int b) {
                return Point(-0.4 + 0.8 * (i + a) / cells, -0.4 + 0.8 * (j + b) / cells, 0);
            };
            if ((i + j) % 2 == 0) {
                s.add(corner(0, 0), corner(1, 0), corner(1, 1));
                s.add(corner(0, 0), corner(1, 1), corner(0, 1));
            } else {
                s.add(corner(0, 0), corner(1, 0), corner(0, 1));
                s.add(corner(1, 0), corner(1, 1), corner(0, 1));
            }
        }

    // From behind the shelf past the camera's near plane, beside its axis.
    s.begin("near_plane");
    for (int i = 0; i < 8; ++i) {
        const double x = -0.4 + 0.1 * i;
        s.add({x, -0.45, -1}, {x + 0.06, -0.45, -1}, {x * 0.2 - s.centre.x, -0.9 - s.centre.y, eye_depth - 0.005},
              {0, 1, 0});
    }

    // One corner at the viewer, and one far behind it.
    s.begin("behind_viewer");
    s.add({-0.3, -0.3, -0.5}, {0.1, 0.35, -0.5}, Point(0.7, -1.5, eye_depth) - s.centre);
    s.add({0, -0.3, -0.6}, {0.4, 0.35, -0.6}, Point(1.5, -3, 1e3) - s.centre);
}

void shading_cells(Shelf& s, int n) {
    // A cone that faces the viewer, with normals that point away: to light and gather it is a back.
    s.begin("normals_away");
    for (int i = 0; i < n; ++i)
        s.add({0, 0, 0.1}, on_circle(0.4, double(i) / n), on_circle(0.4, double(i + 1) / n), {0, 0, -1});

    // The three normals of each triangle cancel in its middle.
    s.begin("opposed_normals");
    for (int i = 0; i < 4; ++i) {
        s.add(on_circle(0.1, i / 4.0), on_circle(0.42, i / 4.0), on_circle(0.42, (i + 0.8) / 4.0));
        auto& vertices = s.scene.meshes.back().vertices;
        const std::size_t last = vertices.size();
        vertices[last - 3].normal = {0, 0, 1}, vertices[last - 2].normal = {0.8660254f, 0, -0.5f};
        vertices[last - 1].normal = {-0.8660254f, 0, -0.5f};
    }

    s.begin("t_junctions");
    const int steps = std::max(2, n / 2);
    s.add({-0.4, 0, 0}, {0.4, 0, 0}, {0, 0.4, 0});
    for (int i = 0; i < steps; ++i)
        s.add({-0.4 + 0.8 * i / steps, 0, 0}, {0, -0.4, 0}, {-0.4 + 0.8 * (i + 1) / steps, 0, 0});

    s.begin("pixels");
    const int pixels = std::max(2, int(std::sqrt(n)));
    for (int j = 0; j < pixels; ++j)
        for (int i = 0; i < pixels; ++i) {
            const Point p(-0.4 + 0.8 * i / pixels, -0.4 + 0.8 * j / pixels, 0.05 * ((i * 7 + j * 3) % 5));
            s.add(p, p + Point(0.005, 0, 0), p + Point(0, 0.005, 0));
        }
}

}  // namespace

// Eleven cells take a share of the triangles each; the others have a handful.
Scene stress(const GenerateOptions& options) {
    const int n = int(std::max<std::int64_t>(options.triangles / 11, 16));
    Shelf s;
    s.scene.name = "stress";
    degenerate_cells(s, n);
    depth_cells(s, n);
    screen_cells(s, n);
    shading_cells(s, n);

    Scene scene = std::move(s.scene);
    const int grey = int(scene.materials.size());
    scene.materials.push_back(diffuse("shelf", glm::vec3(0.3f)));
    Builder shelf("shelf");
    shelf.object("shelf");
    for (int cell = 0; cell < side * side; ++cell) {
        if (cell == far_away) continue;  // seen through the shelf
        const double left = (cell % side - side / 2) * pitch, bottom = (side / 2 - 1 - cell / side) * pitch;
        const Point corners[4] = {{left, bottom, -0.7}, {left + pitch, bottom, -0.7},
                                  {left + pitch, bottom + pitch, -0.7}, {left, bottom + pitch, -0.7}};
        shelf.quad(0, Place(1), corners);
    }
    Mesh board = shelf.take().meshes[0];
    for (std::int32_t& m : board.material) m = grey;
    scene.meshes.push_back(std::move(board));

    scene.camera.position = {0, 0, eye_depth};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.fov_y_deg = 48;
    scene.camera.near = 0.01;
    scene.camera.far = unbounded;
    scene.camera.reversed_z = true;
    scene.frame_size = {1000, 1000};
    Light sun;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = {-0.48f, -0.36f, -0.8f};
    sun.intensity = glm::vec3(3);
    scene.lights.push_back(sun);
    scene.environment.radiance = glm::vec3(0.1f);
    scene.method = "direct";
    return scene;
}

}  // namespace plumb::io::scenes
