// What procedural scenes are built from: parts that are appended to one mesh, and noise for their textures.
//
// Deterministic: double precision, core/host_math.h instead of the C library, integer hashes instead of random numbers.
// The same bytes come out on every machine. Metres, +Y up, front faces counter-clockwise seen from outside.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/scene.h"

namespace plumb::io::scenes {

using Point = glm::dvec3;
using Place = glm::dmat4;  // where a part goes: translation, turn, scale

Place move(const Point& by);
Place turn_y(double degrees);  // counter-clockwise seen from above: +z towards +x
Place scale(const Point& by);

Place turn_x(double degrees);  // counter-clockwise seen from the right: +y towards +z

// A point (u, v) of a surface patch, both 0..1; the front is where d/du x d/dv points.
using Patch = std::function<Point(double u, double v)>;

struct Grid {
    int columns = 1, rows = 1;          // quads along u and v
    glm::dvec2 texture{1, 1};           // texture coordinates at u = 1, v = 1; (0, 0) lies at u = 0, v = 0
    bool smooth = true;                 // shared vertices and smooth normals; false: each quad flat
    bool closed_u = false;  // u = 1 is u = 0: the normals of the seam agree (its texture coordinates do not)
    bool pole = false;                  // v = 0 is one point: its row is of triangles
    std::function<glm::dvec2(const Point&)> projection = {};  // texture coordinates of a position, instead of `texture`
};

// A curve in a plane that sweeps out a surface. It bends sharply where it turns by more than crease_deg.
struct Profile {
    std::vector<glm::dvec2> points;
    double crease_deg = 40;
};
// A point of a swept surface: how far along (0..1), and which point of the profile. The front is where d/d along x
// d/d profile points.
using Sweep = std::function<Point(double along, const glm::dvec2& point)>;

class Builder {
  public:
    // counting: nothing is built, triangles() alone goes up.
    explicit Builder(std::string scene_name, bool counting = false);

    // Adds a material or a texture and returns its index.
    int material(const Material& material);
    int texture(const Texture& texture);

    // Triangles that follow belong to a new mesh of that name: an object of its own in the picture.
    void object(const std::string& name);

    // Appends parts. A degenerate quad (a pole) becomes one triangle; a triangle of no area is left out.
    void grid(int material, const Place& place, const Grid& grid, const Patch& patch);
    // Corners counter-clockwise from the front; cut into columns x rows; texture coordinates in metres /
    // `texture_size`.
    void quad(int material, const Place& place, const Point corners[4], int columns = 1, int rows = 1,
              double texture_size = 1);
    // A wall with openings: the rectangle between the first and last lines at x = across, y = up in the plane z = 0,
    // its front towards +z, cut at all lines; a cell (column, row) for which `open` is true is left out.
    void sheet(int material, const Place& place, const std::vector<double>& across, const std::vector<double>& up,
               const std::function<bool(int, int)>& open, double texture_size = 1);
    // The box [low, high], outside in front; texture coordinates in metres / texture_size. cells: along each axis.
    void box(int material, const Place& place, const Point& low, const Point& high, double texture_size = 1,
             const glm::ivec3& cells = {1, 1, 1});
    // A profile of (radius, height) turned about the y axis, from bottom to top; corners sharper than `crease_deg` stay
    // sharp. Closed where the radius is 0.
    void lathe(int material, const Place& place, const std::vector<glm::dvec2>& profile, int segments,
               double texture_size = 1, double crease_deg = 40);
    // A profile moved along a path, cut into `columns`; `length` of the path in metres, for the texture.
    void sweep(int material, const Place& place, const Profile& profile, int columns, double length,
               double texture_size, const Sweep& path, bool closed_u = false);
    // The same around the rectangle |x| <= half.x, |z| <= half.y with mitred corners: profile points are (inwards from
    // the rectangle, height), from bottom to top for a front that faces the middle; columns: along x, along z.
    void frame(int material, const Place& place, const Profile& profile, const glm::dvec2& half,
               const glm::ivec2& columns, double texture_size);
    // A patch with a back `thickness` behind it and four edges: closed.
    void cloth(int material, const Place& place, const Grid& grid, const Point& thickness, const Patch& patch);
    // A triangle with flat normal, for what nothing above fits.
    void triangle(int material, const Place& place, const Point& a, const Point& b, const Point& c);

    std::int64_t triangles() const { return triangles_; }  // so far

    // What has been built: meshes, materials, textures. Camera, lights and settings are the scene's own.
    Scene take();

  private:
    // A place as its vertices need it, worked out once a part.
    struct Mapping {
        explicit Mapping(const Place& place);
        Place place;
        glm::dmat3 normals;  // the inverse transpose
        bool mirrored;       // turns the order of corners around
    };
    void begin_mesh();
    std::uint32_t vertex(const Mapping& mapping, const Point& position, const Point& normal, double u, double v);
    void face(int material, const Mapping& mapping, std::uint32_t a, std::uint32_t b, std::uint32_t c);

    Scene scene_;
    std::int64_t triangles_ = 0;
    bool counting_ = false;
    std::vector<Point> points_, normals_;  // of the grid at hand: kept, since a scene has a million of them
};

// The detail in [low, high] with which `build` makes about so many triangles, by bisection of its logarithm: more
// detail has to mean more triangles, apart from small steps.
double fit_detail(std::int64_t triangles, double low, double high,
                  const std::function<void(Builder& builder, double detail)>& build);

// Noise of the plane for textures and for variety, 0..1: white from a hash of integers; smooth, with that many periods
// across the unit square so that it tiles; and a sum of octaves of it.
double white_noise(int x, int y, std::uint32_t seed);
double smooth_noise(double u, double v, int periods, std::uint32_t seed);
double fractal_noise(double u, double v, int periods, int octaves, std::uint32_t seed);

// Draws of a fixed sequence. Two draws in one list of arguments have no order: they take a statement each.
struct Dice {
    std::uint32_t seed = 1;
    int row = 0;    // of the hash: scenes draw from rows of their own
    int rolls = 0;
    double operator()() { return white_noise(rolls++, row, seed); }  // [0, 1)
    double between(double low, double high) { return low + (high - low) * (*this)(); }
    int pick(int count) { return int((*this)() * count); }
    bool chance(double probability) { return (*this)() < probability; }
};

// A texture of side x side texels from linear colours 0..1 at texel centres, sRGB-encoded; with alpha from the second.
// `colour` is called by several threads.
Texture paint(const std::string& name, int side, const std::function<glm::dvec3(double u, double v)>& colour);
Texture paint_masked(const std::string& name, int side, const std::function<glm::dvec4(double u, double v)>& colour);

}  // namespace plumb::io::scenes
