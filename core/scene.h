// The scene: plain data, in metres, right-handed, +Y up, counter-clockwise front faces, radiometric SI units.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/convention.h"
#include "core/fields.h"
#include "core/image.h"
#include "core/sample_rows.h"

namespace plumb {

// 32 bytes: two texels of four floats, fetched whole by kernels.
struct Vertex {
    glm::vec3 position;  // m
    float u = 0;         // texture coordinates: (0, 0) is the top left of the image
    glm::vec3 normal;    // unit
    float v = 0;
};
static_assert(sizeof(Vertex) == 32);

// Textures are indices into Scene::textures; -1: none.
struct Material {
    std::string name;
    glm::vec3 reflectance{0.5f};  // rho, diffuse, 0..1; multiplied by the texture where there is one
    glm::vec3 emission{0};        // radiant exitance, W/m2; multiplied by its texture where there is one
    int texture = -1;
    int emission_texture = -1;
    int normal_texture = -1;      // tangent space, x right, y up, as glTF stores it; never sRGB
    float normal_scale = 1;       // of the normal map's x and y
    float alpha = 1;              // multiplied by the texture's alpha
    float alpha_cutoff = 0;       // above 0: where alpha is below it, there is no surface (glTF: alphaMode MASK)
    // Beside the diffuse lobe: the path tracer reflects them, the methods for diffuse light do not. reflectance +
    // specular + mirror is at most 1 in each channel.
    glm::vec3 specular{0};        // of Phong's lobe, (n + 2)/(2 pi) cos^n about the mirrored direction (Lafortune 1994)
    float exponent = 50;          // n of that lobe, 0..1e6
    glm::vec3 mirror{0};          // reflectance of a perfect mirror
    // In place of diffuse part, lobe and mirror the path tracer has glTF's rough metal or coated dielectric, of which
    // reflectance is the base colour; methods for diffuse light show that as if it were diffuse.
    bool microfacet = false;
    float metalness = 0;          // 0..1; multiplied by the blue of surface_texture
    float roughness = 1;          // 0..1, perceptual: its square is alpha; multiplied by the green of surface_texture
    int surface_texture = -1;     // never sRGB
};

enum class Filter : int { bilinear, nearest };
enum class Wrap : int { repeat, mirrored_repeat, clamp_to_edge };

struct Texture {
    std::string name;
    Image<std::uint32_t> texels;  // RGBA8, red in the lowest byte, first row on top
    bool srgb = true;             // decode red, green and blue by the exact table; alpha is linear always
    Filter filter = Filter::bilinear;
    Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
    bool mips = false;            // choose a level of detail; off: level 0 everywhere
};

struct Mesh {
    std::string name;
    std::vector<Vertex> vertices;  // in the mesh's own space
    std::vector<glm::vec4> tangents;     // xyz unit, w +1 or -1: side of the bitangent; a vertex each, or none at all
    std::vector<glm::uvec3> triangles;
    std::vector<std::int32_t> material;  // of each triangle: index into Scene::materials
    glm::dmat4 transform{1};             // to world space
    bool dynamic = false;
    double share = 1;                    // part of the triangles that is drawn: the first share * n
};

enum class LightType : int { spot, point, directional };

struct Light {
    std::string name;
    LightType type = LightType::spot;
    glm::vec3 position{0};            // m; not used by a directional light
    glm::vec3 direction{0, -1, 0};    // unit: the way the light travels
    float cone_inner_deg = 40, cone_outer_deg = 45;  // half angles of a spot; full intensity within the inner one
    glm::vec3 intensity{1};           // spot, point: W/sr; directional: irradiance on a plane across the light, W/m2
    bool on = true;
    int rsm_size = 512;               // texels a side
    // Above 0: m, where the light ends, by ISR (16). A spot or point light then sends the irradiance intensity
    // max(0, 1 - (d/radius)^2), W/m2, to a surface across its rays at distance d, in place of intensity / d^2.
    float radius = 0;
};
inline constexpr float least_light_radius = 1e-6f, largest_light_radius = 1e9f;  // m

struct Environment {
    glm::vec3 radiance{0};  // W/(m2 sr), from everywhere; multiplied by the map where there is one
    // Directions by longitude and latitude: u = 1/2 + atan2(x, -z) / (2 pi), v = acos(y) / pi, v = 0 the top row. Empty:
    // none.
    Image4 map;
    // Nearest: texels are constant patches. Bilinear: between the middles of four; columns go round, and from the middles
    // of the first and the last row to the poles nothing changes along a column.
    Filter filter = Filter::nearest;
};

// A value that the scene file gives for a stage's parameter: [rsm] samples = 400.
struct Setting {
    std::string table, key;
    FieldValue value;
    std::string place;  // for messages: "cornell.toml: line 31"
    SampleRowsPtr rows = {};  // where the value names a sample pattern's file: what it holds
};

// A value at a frame. Numbers alone lie in x, pairs in x and y, truth values are 0 or 1.
struct Key {
    double frame = 0;
    glm::dvec3 value{0};
};
using Track = std::vector<Key>;  // by ascending frames, none twice; empty: what it would move stays as it is

// What a curve does at its end: rests there, begins again, or goes back and forth.
enum class PathEnd : int { hold, repeat, swing };

// Motion without keys, from the frame `start` on (IPR figure A.1): along a Bezier curve, by a vector a frame, and about
// an axis by an angle a frame.
struct Motion {
    std::vector<glm::dvec3> bezier;  // m, control points, one more than the curve's degree; empty: no curve
    double speed = 0;                // of the curve's parameter, which is 0..1 along it, a frame
    PathEnd end = PathEnd::hold;
    glm::dvec3 translate{0};         // m a frame
    double turn_deg = 0;             // a frame, counter-clockwise as seen against the axis
    glm::dvec3 axis{0, 1, 0};        // unit
    double start = 0;
    bool empty() const { return bezier.empty() && translate == glm::dvec3(0) && turn_deg == 0; }
};

// The curve is the camera's position, and a curve of a light its position. `translate` moves what the tracks or the curve
// place (the camera with what it looks at), and turns what they direct: tracks of those are there.
struct CameraTracks {
    Track position, look_at, up, fov_y_deg;
    Motion motion = {};
    bool empty() const {
        return position.empty() && look_at.empty() && up.empty() && fov_y_deg.empty() && motion.empty();
    }
};

struct LightTracks {
    int light = 0;  // index into Scene::lights
    Track position, direction, cone_deg, intensity;
    Track on;       // changes at its keys and not between them
    Motion motion = {};
};

struct MovingMesh {
    int mesh = 0;       // index into Scene::meshes
    glm::dmat4 own{1};  // its transform without motion
};

// Meshes that move as one: they are scaled, turned (yaw about y, pitch about x, roll about z; then by the motion) about
// the pivot, then moved, all in world space. The motion's curve takes the place of `translate`.
struct MeshTracks {
    std::string name;
    std::vector<MovingMesh> meshes;
    glm::dvec3 pivot{0};  // m, world
    Track translate, rotate_deg, scale;
    Motion motion = {};
};

// What moves, core/animation.h. A mesh is in one entry at most.
struct Animation {
    CameraTracks camera;
    std::vector<LightTracks> lights;
    std::vector<MeshTracks> meshes;
};

struct Scene {
    std::string name;
    std::vector<Mesh> meshes;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Light> lights;
    Environment environment;
    Camera camera;
    Convention convention = Convention::vulkan;
    std::uint32_t seed = 1;
    glm::ivec2 frame_size{1024, 1024};
    std::string method = "rsm";   // [render] method
    std::string layout = "fp32";  // [render] layout
    Animation animation;          // what moves from frame to frame; the rest of the scene is its pose at one of them
    std::vector<Setting> settings;
    std::vector<std::string> notes;  // what was chosen for the user: "no camera in the file: one that sees everything"
};

// All meshes in world space, as the rasterizer reads them: one list of vertices, one list of triangles, in the order of
// the meshes.
struct Geometry {
    Buffer<Vertex> vertices;
    Buffer<glm::vec4> tangents;  // a vertex each (0, 0, 0, 0 where its mesh has none); empty where no mesh has any
    std::vector<glm::uvec3> triangles;
    std::vector<std::int32_t> material;  // of each triangle
    std::vector<std::int32_t> object;    // of each triangle: index into Scene::meshes
};

// Transforms positions by the meshes' matrices and normals by their inverse transposes, in double, rounded once.
Geometry flatten(const Scene& scene);

// Axis-aligned bounds of the world-space geometry; false where there is none.
bool bounds(const Geometry& geometry, glm::vec3& low, glm::vec3& high);

}  // namespace plumb
