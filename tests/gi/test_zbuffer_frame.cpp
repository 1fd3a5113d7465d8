// Frames of the method zbuffer: what techniques make of a scene, beside the methods that are known to be right.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/host_math.h"
#include "gi/frame/frame.h"
#include "gi/zbuffer/normal_lines.h"
#include "tests/gi/random_scene.h"
#include "tests/gi/zbuffer_scenes.h"

namespace {

using namespace plumb;
using namespace plumb::zbuffer;

// A room with a box in it, seen from inside; a lamp, and a sun that walls do not stop.
Scene room_scene() {
    Scene scene;
    scene.name = "room";
    Material wall, box;
    wall.reflectance = {0.75f, 0.5f, 0.25f}, wall.specular = glm::vec3(0.25f), wall.exponent = 8;
    box.reflectance = {0.25f, 0.5f, 0.75f}, box.emission = {0.5f, 0, 0};
    scene.materials = {wall, box};
    Mesh mesh;
    test::add_box(mesh, glm::vec3(-1), glm::vec3(1), 0, true);
    test::add_box(mesh, {-0.5f, -1, -0.5f}, {0.1f, -0.2f, 0.1f}, 1);
    scene.meshes = {mesh};
    Light lamp;
    lamp.name = "lamp", lamp.type = LightType::point, lamp.position = {0.3f, 0.6f, 0.2f};
    scene.lights = {lamp, test::sun_from(glm::normalize(glm::vec3(0.2f, 1, 0.4f)))};
    scene.lights[1].name = "sun";
    scene.camera.position = {0.7, 0.3, 0.9}, scene.camera.look_at = {-0.3, -0.4, -0.5}, scene.camera.fov_y_deg = 70;
    scene.frame_size = {61, 45};
    return scene;
}

frame::Settings settings_of(Technique technique) {
    frame::Settings s;
    s.method = frame::Method::zbuffer;
    s.zbuffer.technique = technique;
    return s;
}

frame::Frame frame_of(const Scene& scene, const frame::Settings& settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

double largest_difference(const Image4& a, const Image4& b) {
    double d = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 3; ++c) d = std::max(d, std::fabs(double(a.texels[i][c]) - double(b.texels[i][c])));
    return d;
}

}  // namespace

TEST_CASE("zbuffer: in a frame per-pixel diffuse light is that of direct where nothing is in the way", "[zbuffer][frame]") {
    Scene scene = room_scene();
    // A map of one texel whose bias passes everything: direct light without shadows.
    frame::Settings direct;
    direct.method = frame::Method::direct, direct.shadow.bias = 1e6f;
    frame::Settings ours = settings_of(Technique::cads_p);
    ours.zbuffer.ambient = glm::vec3(0);
    for (Material& m : scene.materials) m.specular = glm::vec3(0);
    const frame::Frame a = frame_of(scene, direct), b = frame_of(scene, ours);
    CHECK(a.direct(30, 20).x > 0.1f);
    CHECK(largest_difference(a.direct, b.direct) < 1e-5);
    CHECK(largest_difference(a.radiance, b.radiance) < 1e-5);
}

TEST_CASE("zbuffer: pictures of the techniques", "[zbuffer][frame][HEM 5.3][analytic]") {
    const Scene scene = room_scene();
    frame::Settings s = settings_of(Technique::c);
    const frame::Frame c = frame_of(scene, s);
    s.zbuffer.technique = Technique::ca, s.zbuffer.ambient = {0.5f, 0.25f, 0.125f};
    const frame::Frame ca = frame_of(scene, s);
    for (std::size_t i = 0; i < c.radiance.size(); ++i) {
        const glm::vec4 rho = c.gbuffer.albedo.texels[i], m = c.gbuffer.emission.texels[i];
        for (int k = 0; k < 3; ++k) {
            CHECK(c.radiance.texels[i][k] == Approx(rho[k] + m[k] / host::pi).margin(1e-6));
            CHECK(ca.radiance.texels[i][k] == Approx(rho[k] * s.zbuffer.ambient[k] + m[k] / host::pi).margin(1e-6));
        }
    }
    // With a box's corners and nothing between, light of vertices is another picture than light of pixels.
    s.zbuffer.technique = Technique::cads;
    const frame::Frame vertices = frame_of(scene, s);
    s.zbuffer.technique = Technique::cads_p;
    const frame::Frame pixels = frame_of(scene, s);
    CHECK(largest_difference(vertices.radiance, pixels.radiance) > 0.05);
    CHECK(vertices.zbuffer.vertex_light.diffuse.size() == 96);  // 48 corners of two boxes, either side
    CHECK(pixels.zbuffer.vertex_light.diffuse.empty());
    CHECK(c.rsms[0].empty());  // no maps: HEM's techniques have no shadows
}

TEST_CASE("zbuffer: a mesh that is refined comes to light of pixels", "[zbuffer][frame][plate C.4]") {
    // Each wall in n x n squares.
    const auto refined = [](int n) {
        Scene scene = room_scene();
        const Mesh coarse = scene.meshes[0];
        Mesh& mesh = scene.meshes[0];
        mesh.vertices.clear(), mesh.triangles.clear(), mesh.material.clear();
        for (std::size_t q = 0; q < coarse.triangles.size(); q += 2) {
            const glm::vec3 a = coarse.vertices[coarse.triangles[q].x].position, b = coarse.vertices[coarse.triangles[q].y].position,
                            d = coarse.vertices[coarse.triangles[q + 1].z].position;
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x) {
                    const glm::vec3 u = (b - a) / float(n), v = (d - a) / float(n), at = a + float(x) * u + float(y) * v;
                    test::add_quad(mesh, at, at + u, at + v, coarse.material[q]);
                }
        }
        return scene;
    };
    double before = 1e9;
    for (const int n : {4, 16, 64}) {
        const Scene scene = refined(n);
        const double error = largest_difference(frame_of(scene, settings_of(Technique::cads)).radiance,
                                                frame_of(scene, settings_of(Technique::cads_p)).radiance);
        CHECK(error < before / 3);
        before = error;
    }
    CHECK(before < 0.02);
}

TEST_CASE("zbuffer: normals over the picture, red, where nothing is in front of them", "[zbuffer][HEM C.8]") {
    Scene scene = room_scene();
    frame::Settings s = settings_of(Technique::cad);
    CHECK(frame_of(scene, s).zbuffer.vertex_normals.empty());
    s.zbuffer.normals = true, s.zbuffer.normal_length = 0.1f;
    const frame::Frame f = frame_of(scene, s);
    int red = 0;
    for (std::size_t i = 0; i < f.display.size(); ++i) {
        const bool is = f.zbuffer.vertex_normals.texels[i] == glm::vec4(1, 0, 0, 1);
        red += is;
        if (!is) CHECK((f.zbuffer.vertex_normals.texels[i] == f.display.texels[i]));
    }
    CHECK(red > 30);
    CHECK(red < int(f.display.size()) / 4);

    // One normal across the view from its middle: a row of pixels, half as wide as the picture, and none where something is nearer.
    VertexTable table;
    table.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}};
    Camera camera;
    camera.position = {0, 0, 1}, camera.look_at = {0, 0, 0}, camera.fov_y_deg = 90;
    const View view = make_view(camera, 1, Convention::vulkan, {40, 40});
    Image4 position(40, 40, glm::vec4(0, 0, 0, 0)), picture(40, 40, glm::vec4(0, 0, 0, 1));
    for (int y = 0; y < 40; ++y) position(25, y).w = 0.5f;  // in front
    draw_normals(table, view, position, 1, picture);
    for (int x = 0; x < 40; ++x) {
        const bool drawn = picture(x, 20).x == 1 || picture(x, 19).x == 1;
        CHECK(drawn == (x >= 20 && x != 25));
    }
}

TEST_CASE("zbuffer: every named value of a pixel is that of the frame", "[zbuffer][frame][explain]") {
    const Scene scene = room_scene();
    for (const Technique technique : {Technique::cads, Technique::cads_p}) {
        const frame::Settings s = settings_of(technique);
        const frame::Plan plan = frame::plan(scene, s);
        const frame::Frame f = frame::execute(scene, s, plan, {});
        const std::string stage = per_pixel(technique) ? plumb::stage<PixelsKernel>().info.name : plumb::stage<InterpolateKernel>().info.name;
        const std::vector<frame::Explanation> e = frame::explain(scene, s, plan, f, stage, -1, {20, 30});
        REQUIRE(e.size() == 1);
        bool found = false;
        for (const TapValue& v : e[0].values)
            if (v.name == "irradiance") {
                found = true;
                for (int c = 0; c < 3; ++c) CHECK(float(v.value[std::size_t(c)]) == f.direct(20, 30)[c]);
            }
        CHECK(found);
    }
}
