// Things that move through other scenes: the container of IPR figure 5.20 and a figure that walks. Each is one object
// group about its own origin on the ground, its front towards +z, with a normal map.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "core/host_math.h"
#include "core/rotation.h"
#include "io/scenes/atrium_parts.h"
#include "io/scenes/builder.h"
#include "io/scenes/generate.h"

namespace plumb::io::scenes {
namespace {

using parts::cut;
using parts::Surface;

constexpr int side = 512;  // texels of a texture

double fraction(double x) { return x - std::floor(x); }

// A normal map from slopes dh/du, dh/dv at texel centres; v runs down, the map's y up.
Texture normals(const std::string& name, const std::function<glm::dvec2(double u, double v)>& slope) {
    Texture texture;
    texture.name = name;
    texture.srgb = false, texture.mips = true;
    texture.texels = Image<std::uint32_t>(side, side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const glm::dvec2 s = slope((x + 0.5) / side, (y + 0.5) / side);
            const double scale = 1 / std::sqrt(s.x * s.x + s.y * s.y + 1);
            const double n[3] = {-s.x * scale, s.y * scale, scale};
            std::uint32_t texel = 0xff000000u;
            for (int k = 0; k < 3; ++k) texel |= std::uint32_t(std::floor(127.5 * (n[k] + 1) + 0.5)) << (8 * k);
            texture.texels(x, y) = texel;
        }
    return texture;
}

Surface surface(Builder& b, const std::string& name, const glm::vec3& reflectance, double size, int texture = -1,
                int normal_texture = -1, float specular = 0, float exponent = 50) {
    Material m;
    m.name = name;
    m.reflectance = reflectance;
    m.texture = texture, m.normal_texture = normal_texture;
    m.specular = glm::vec3(specular), m.exponent = exponent;
    return {b.material(m), size};
}

// ---- Container -----------------------------------------------------------------------------------------------------

// Outer sizes of a 20-foot container (ISO 668: 1CC), m.
constexpr double length = 6.058, width = 2.438, height = 2.591, post = 0.16;
constexpr int ridges = 8;  // across a texture

struct ContainerPalette {
    Surface panel, frame, metal;
};

// Sheet steel in trapezoids: flat, up, flat, down; a ramp rises as much as it is long.
double ramp(double u) {
    const double at = fraction(u * ridges);
    return at >= 0.3 && at < 0.5 ? 1 : at >= 0.8 ? -1 : 0;
}

ContainerPalette container_palette(Builder& b) {
    Texture paint_work = paint("container_paint", side, [](double u, double v) {
        const glm::dvec3 coat(0.62, 0.14, 0.07), rust(0.2, 0.09, 0.05);
        const double tone = 0.8 + 0.35 * fractal_noise(u, v, 4, 4, 71);
        const double worn = fractal_noise(u, v, 8, 5, 72), amount = std::clamp((worn - 0.56) / 0.08, 0.0, 1.0);
        return (1 - amount) * tone * coat + amount * rust;
    });
    paint_work.mips = true;
    const int colour = b.texture(paint_work);
    const int relief = b.texture(normals("container_relief", [](double u, double v) {
        const double dent = 0.25 * (smooth_noise(u, v, 12, 73) - 0.5);
        return glm::dvec2(0.9 * ramp(u) + dent, 0.25 * (smooth_noise(v, u, 12, 74) - 0.5));
    }));
    return {surface(b, "container_panel", glm::vec3(0.85f), 2.24, colour, relief, 0.15f, 40),
            surface(b, "container_frame", {0.4f, 0.1f, 0.06f}, 1, -1, -1, 0.1f, 40),
            surface(b, "container_bars", glm::vec3(0.35f), 1, -1, -1, 0.4f, 80)};
}

void build_container(Builder& b, const ContainerPalette& p, double d) {
    const double x = length / 2, z = width / 2, in = 0.03;  // panels lie back behind the frame
    const int along = cut(d, 16, 1), across = cut(d, 6, 1), up = cut(d, 6, 1);
    auto panel = [&](const Point& a, const Point& right, const Point& rise, int columns, int rows) {
        const Point corners[4] = {a, a + right, a + right + rise, a + rise};
        b.quad(p.panel.material, Place(1), corners, columns, rows, p.panel.size);
    };
    const Point rise(0, height, 0);
    b.object("sides");
    panel({-x, 0, z - in}, {length, 0, 0}, rise, along, up);
    panel({x, 0, -z + in}, {-length, 0, 0}, rise, along, up);
    b.object("roof");
    panel({-x, height - in, z}, {length, 0, 0}, {0, 0, -width}, along, across);
    b.object("floor");
    panel({-x, in, -z}, {length, 0, 0}, {0, 0, width}, along, across);
    b.object("ends");
    panel({x - in, 0, z}, {0, 0, -width}, rise, across, up);
    panel({-x + in, 0, -z}, {0, 0, width}, rise, across, up);
    b.object("frame");
    auto beam = [&](const Point& low, const Point& high, const glm::ivec3& cells) {
        b.box(p.frame.material, Place(1), low, high, p.frame.size, cells);
    };
    for (int s = -1; s <= 1; s += 2) {
        const double z0 = s < 0 ? -z : z - post, x0 = s < 0 ? -x : x - post;
        for (double y : {0.0, height - post}) {
            beam({-x, y, z0}, {x, y + post, z0 + post}, {along, 1, 1});
            beam({x0, y, -z + post}, {x0 + post, y + post, z - post}, {1, 1, across});
        }
        for (int t = -1; t <= 1; t += 2) {
            const double x1 = t < 0 ? -x : x - post;
            beam({x1, post, z0}, {x1 + post, height - post, z0 + post}, {1, up, 1});
        }
    }
    // Lock bars of the doors, at the end x = length / 2.
    b.object("bars");
    const int around = cut(d, 10, 4);
    for (double at : {-0.75, -0.3, 0.3, 0.75}) {
        const Place place = move({x + 0.035, 0, at});
        b.lathe(p.metal.material, place, {{0, 0.1}, {0.025, 0.1}, {0.025, height - 0.1}, {0, height - 0.1}}, around, 1);
        for (double y : {0.5, 1.1, 2.2}) b.box(p.metal.material, place, {-0.04, y, -0.06}, {0.03, y + 0.08, 0.06});
    }
}

// ---- Character -----------------------------------------------------------------------------------------------------

struct Dress {
    Surface skin, shirt, trousers, shoes, hair;
};

// Threads over and under each other.
glm::dvec2 weave_slope(double u, double v, int threads, double depth) {
    const glm::dvec2 a = {2 * host::pi * threads * u, 2 * host::pi * threads * v};
    return depth * glm::dvec2(host::cos(a.x) * (0.6 + 0.4 * host::sin(a.y)), host::cos(a.y) * (0.6 + 0.4 * host::sin(a.x)));
}

Dress make_dress(Builder& b) {
    const int knit = b.texture(normals("knit", [](double u, double v) { return weave_slope(u, v, 24, 0.8); }));
    const int creases = b.texture(normals("creases", [](double u, double v) {
        return weave_slope(u, v, 48, 0.3) + glm::dvec2(0, 1.6 * (smooth_noise(u, v, 10, 81) - 0.5));
    }));
    Texture stripes = paint("shirt", side, [](double, double v) {
        return fraction(4 * v) < 0.5 ? glm::dvec3(0.72, 0.66, 0.55) : glm::dvec3(0.1, 0.2, 0.5);
    });
    stripes.mips = true;
    const int shirt = b.texture(stripes);
    return {surface(b, "skin", {0.62f, 0.4f, 0.3f}, 1, -1, -1, 0.05f, 20),
            surface(b, "shirt", glm::vec3(1), 0.32, shirt, knit),
            surface(b, "trousers", {0.12f, 0.13f, 0.17f}, 0.5, -1, creases),
            surface(b, "shoes", {0.1f, 0.06f, 0.04f}, 1, -1, -1, 0.3f, 60),
            surface(b, "hair", {0.07f, 0.045f, 0.03f}, 1, -1, -1, 0.1f, 20)};
}

// From y = -length to 0, rounded at both ends, radius `top` above and `bottom` below; flattened along z by `flat`.
void limb(Builder& b, const Surface& s, const Place& place, double length, double top, double bottom, double d,
          double flat = 1) {
    const int rounds = cut(d, 5, 2), bands = cut(d, 4, 1), around = cut(d, 16, 6);
    std::vector<glm::dvec2> profile;
    for (int k = 0; k <= rounds; ++k) {
        const glm::dvec2 sc = sin_cos_deg(90.0 * k / rounds);
        profile.push_back({k == 0 ? 0 : bottom * sc.x, -length - bottom * sc.y});
    }
    for (int k = 1; k < bands; ++k)
        profile.push_back({bottom + (top - bottom) * k / bands, -length + length * k / bands});
    for (int k = 0; k <= rounds; ++k) {
        const glm::dvec2 sc = sin_cos_deg(90.0 * k / rounds);
        profile.push_back({k == rounds ? 0 : top * sc.y, top * sc.x});
    }
    b.lathe(s.material, place * scale({1, 1, flat}), profile, around, s.size, 91);
}

// A leg or an arm: two limbs and what is at their end. Positive angles swing what hangs backwards.
void leg(Builder& b, const Dress& w, double at, double swing, double knee, double ankle, double d) {
    const Place hip = move({at, 0.92, 0}) * turn_x(swing);
    limb(b, w.trousers, hip, 0.42, 0.085, 0.06, d);
    const Place shin = hip * move({0, -0.43, 0}) * turn_x(knee);
    limb(b, w.trousers, shin, 0.38, 0.06, 0.045, d);
    const Place foot = shin * move({0, -0.41, -0.04}) * turn_x(ankle) * turn_x(-90);
    limb(b, w.shoes, foot, 0.18, 0.045, 0.04, d, 0.8);
}
void arm(Builder& b, const Dress& w, double at, double swing, double elbow, double d) {
    const Place shoulder = move({at, 1.42, 0}) * turn_x(swing);
    limb(b, w.shirt, shoulder, 0.27, 0.055, 0.045, d);
    const Place forearm = shoulder * move({0, -0.28, 0}) * turn_x(elbow);
    limb(b, w.skin, forearm, 0.23, 0.04, 0.03, d);
    limb(b, w.skin, forearm * move({0, -0.27, 0}), 0.08, 0.035, 0.03, d, 0.6);
}

void build_character(Builder& b, const Dress& w, double d) {
    b.object("torso");
    limb(b, w.shirt, move({0, 1.4, 0}), 0.36, 0.17, 0.14, d, 0.65);
    limb(b, w.trousers, move({0, 0.98, 0}), 0.06, 0.15, 0.14, d, 0.75);
    b.object("head");
    limb(b, w.skin, move({0, 1.58, 0}), 0.08, 0.055, 0.06, d);
    limb(b, w.skin, move({0, 1.72, 0.01}), 0.07, 0.095, 0.075, d, 1.1);
    limb(b, w.hair, move({0, 1.75, -0.015}), 0.03, 0.1, 0.098, d, 1.05);
    b.object("legs");
    leg(b, w, 0.085, -24, 8, 6, d);
    leg(b, w, -0.085, 20, 30, -10, d);
    b.object("arms");
    arm(b, w, 0.22, 24, -20, d);
    arm(b, w, -0.22, -26, -30, d);
}

// ---- Both ----------------------------------------------------------------------------------------------------------

// Down to the ground: the lowest point lies at y = 0.
void stand(Scene& scene) {
    float low = scene.meshes[0].vertices[0].position.y;
    for (const Mesh& mesh : scene.meshes)
        for (const Vertex& v : mesh.vertices) low = std::min(low, v.position.y);
    for (Mesh& mesh : scene.meshes)
        for (Vertex& v : mesh.vertices) v.position.y -= low;
}

// A light from the upper left and a sky, for the object alone.
void show(Scene& scene, const Point& middle, double radius) {
    for (Mesh& mesh : scene.meshes) mesh.dynamic = true;
    scene.camera.look_at = middle;
    scene.camera.position = middle + radius * Point(2.2, 0.8, 2.4);
    scene.camera.fov_y_deg = 40;
    scene.camera.near = radius / 20, scene.camera.far = radius * 20;
    scene.frame_size = {768, 768};
    Light sun;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = glm::vec3(glm::normalize(glm::dvec3(-0.2, -0.8, -1)));
    sun.intensity = glm::vec3(3);
    scene.lights = {sun};
    scene.environment.radiance = glm::vec3(0.3f);
    scene.method = "direct";
}

}  // namespace

Scene container(const GenerateOptions& options) {
    const double detail =
        fit_detail(options.triangles, 0.02, 40, [](Builder& b, double d) { build_container(b, {}, d); });
    Builder b("container");
    build_container(b, container_palette(b), detail);
    Scene scene = b.take();
    show(scene, {0, height / 2, 0}, 3.4);
    return scene;
}

Scene character(const GenerateOptions& options) {
    const double detail =
        fit_detail(options.triangles, 0.02, 40, [](Builder& b, double d) { build_character(b, {}, d); });
    Builder b("character");
    build_character(b, make_dress(b), detail);
    Scene scene = b.take();
    stand(scene);
    show(scene, {0, 0.9, 0}, 0.95);
    return scene;
}

}  // namespace plumb::io::scenes
