// A room whose walls are squared stone with a normal map, a pillar and a step, open to the viewer: what a normal map does where nothing
// moves and most light is indirect (IPR figure 5.23).
#include <algorithm>

#include "io/scenes/builder.h"
#include "io/scenes/generate.h"
#include "io/scenes/textures.h"

namespace plumb::io::scenes {
namespace {

constexpr double half_width = 2, height = 3, depth = 4, texture_size = 2;  // m; a texture is 2 m wide

struct Stones {
    int walls = 0, floor = 0, red = 0;
};

Stones make_stones(Builder& b) {
    textures::Blocks masonry;
    masonry.columns = 4, masonry.rows = 6, masonry.joint = 0.014, masonry.seed = 41;
    textures::Blocks slabs = masonry;
    slabs.columns = 3, slabs.rows = 3, slabs.joint = 0.01, slabs.seed = 43;
    const auto material = [&](const std::string& name, const textures::Blocks& of, const glm::vec3& tone, double bump, double specular) {
        Material m;
        m.name = name, m.reflectance = tone;
        m.texture = b.texture(textures::blocks(name, of));
        m.normal_texture = b.texture(textures::blocks_normals(name + "_normals", of, bump));
        m.specular = glm::vec3(float(specular)), m.exponent = 25;
        return b.material(m);
    };
    return {material("masonry", masonry, glm::vec3(0.95f), 0.03, 0), material("slabs", slabs, glm::vec3(0.85f), 0.012, 0.12),
            material("painted", masonry, {0.95f, 0.3f, 0.2f}, 0.03, 0)};
}

void build(Builder& b, const Stones& s, int cells) {
    const double x = half_width, y = height, back = -depth;
    const auto wall = [&](const char* name, int material, const Point& a, const Point& bb, const Point& c, const Point& d) {
        b.object(name);
        const Point corners[4] = {a, bb, c, d};
        b.quad(material, Place(1), corners, cells, cells, texture_size);
    };
    wall("floor", s.floor, {-x, 0, 0}, {x, 0, 0}, {x, 0, back}, {-x, 0, back});
    wall("ceiling", s.walls, {-x, y, back}, {x, y, back}, {x, y, 0}, {-x, y, 0});
    wall("back", s.walls, {-x, 0, back}, {x, 0, back}, {x, y, back}, {-x, y, back});
    wall("left", s.red, {-x, 0, 0}, {-x, 0, back}, {-x, y, back}, {-x, y, 0});
    wall("right", s.walls, {x, 0, back}, {x, 0, 0}, {x, y, 0}, {x, y, back});
    b.object("pillar");
    const int side = std::max(1, cells / 2);
    b.box(s.walls, Place(1), {0.3, 0, -2.9}, {0.9, 2.2, -2.3}, texture_size, {side, side, side});
    b.object("step");
    b.box(s.walls, Place(1), {-1.6, 0, -3.6}, {-0.5, 0.45, -2.4}, texture_size, {side, side, side});
}

}  // namespace

Scene alcove(const GenerateOptions& options) {
    const double detail = fit_detail(options.triangles, 1, 250, [](Builder& b, double d) { build(b, {}, int(d)); });
    Builder b("alcove");
    const Stones stones = make_stones(b);
    build(b, stones, int(detail));
    Scene scene = b.take();
    scene.camera.position = {0, 1.5, 2.6}, scene.camera.look_at = {0, 1.3, -2};
    scene.camera.fov_y_deg = 50, scene.camera.near = 0.05, scene.camera.far = 30;
    scene.frame_size = {768, 512};
    // Onto the left part of the floor and the red wall; the rest is lit by what they send back.
    Light lamp;
    lamp.name = "lamp", lamp.type = LightType::spot;
    lamp.position = {1.2f, 2.7f, -0.6f}, lamp.direction = glm::vec3(glm::normalize(glm::dvec3(-1.9, -1.6, -0.5)));
    lamp.cone_inner_deg = 22, lamp.cone_outer_deg = 32;
    lamp.intensity = {110, 100, 85};
    lamp.rsm_size = 512;
    scene.lights = {lamp};
    scene.method = "probes";
    return scene;
}

}  // namespace plumb::io::scenes
