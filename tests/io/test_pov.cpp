// Scripts of POV-Ray: their text, and what POV-Ray itself makes of them against closed forms.
#include "io/pov.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <regex>

#include "core/camera.h"
#include "core/host_math.h"
#include "files.h"
#include "io/image_file.h"

using namespace plumb;
using namespace plumb::io;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

Material diffuse(const glm::vec3& reflectance, const glm::vec3& exitance = glm::vec3(0)) {
    Material m;
    m.name = "m";
    m.reflectance = reflectance, m.emission = exitance;
    return m;
}

// A parallelogram of a material of its own, from a corner and two edges; its normal is edge_u x edge_v.
void add_quad(Scene& scene, const Material& material, glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
    Mesh mesh;
    mesh.name = "quad";
    const glm::vec3 n = glm::normalize(glm::cross(u, v));
    for (const glm::vec3& p : {corner, corner + u, corner + u + v, corner + v}) {
        Vertex vertex;
        vertex.position = p, vertex.normal = n;
        mesh.vertices.push_back(vertex);
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = {std::int32_t(scene.materials.size()), std::int32_t(scene.materials.size())};
    scene.materials.push_back(material);
    scene.meshes.push_back(mesh);
}

// A floor, seen from straight above so that x runs right and -z up.
Scene floor_from_above(float reflectance, double height = 4, float half = 50) {
    Scene scene;
    scene.name = "floor";
    add_quad(scene, diffuse(glm::vec3(reflectance)), {-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
    scene.camera.position = {0, height, 0}, scene.camera.look_at = {0, 0, 0}, scene.camera.up = {0, 0, -1};
    scene.camera.fov_y_deg = 45;
    scene.frame_size = {40, 30};
    return scene;
}

glm::dvec3 on_floor(const Scene& scene, int x, int y) {
    const Ray ray = ray_through_pixel(scene.camera, scene.frame_size, {x, y});
    return ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
}

bool povray() {
    static const bool there = std::system("command -v povray > /dev/null 2>&1") == 0;
    if (!there) std::cout << "SKIPPED: no povray here (Debian's package povray; tools/install-deps)\n";
    return there;
}

struct Rendered {
    FloatPicture picture;
    glm::dvec3 at(int x, int y) const {
        const std::size_t i = (std::size_t(y) * std::size_t(picture.width) + std::size_t(x)) * picture.channels.size();
        return {picture.data[i], picture.data[i + 1], picture.data[i + 2]};
    }
};

Rendered rendered(const Scene& scene, PovOptions options) {
    const Folder folder;
    options.size = scene.frame_size;
    const std::string script = folder / "it's a scene.pov", picture = folder / "a picture.exr";
    write_pov(script, scene, options);
    const std::string command = povray_command_line(script, picture, scene.frame_size);
    const int exit = std::system((command + " > '" + (folder / "log") + "' 2>&1").c_str());
    if (exit != 0) FAIL(read_text(folder / "log"));
    Rendered r{read_picture(picture)};
    REQUIRE((r.picture.width == scene.frame_size.x && r.picture.height == scene.frame_size.y));
    REQUIRE(r.picture.channels.size() >= 3);
    return r;
}

PovOptions with(PovPreset preset, int bounces = 1) {
    PovOptions options;
    options.preset = preset, options.bounces = bounces;
    return options;
}

// POV-Ray's EXR holds halves: 2^-11 of a value.
constexpr double half_rounding = 0x1p-11;

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
    return n;
}

}  // namespace

// ---- the text ---------------------------------------------------------------------------------------------------------

TEST_CASE("pov: the radiosity block of ISR table 1, the physical one, or none", "[pov][ISR table 1]") {
    const Scene scene = floor_from_above(0.5f);
    const std::string published = pov_text(scene, with(PovPreset::published));
    CHECK_THAT(published, StartsWith("#version 3.7;\n"));
    CHECK_THAT(published, Contains("assumed_gamma 1.0") &&
                              Contains("radiosity {\n    brightness 2.4\n    pretrace_start 0.08\n    pretrace_end 0.01\n"
                                       "    count 250\n    error_bound 0.25\n    recursion_limit 2\n  }"));
    const std::string physical = pov_text(scene, with(PovPreset::physical, 7));
    CHECK_THAT(physical, Contains("brightness 1\n") && Contains("recursion_limit 7\n") && Contains("count 400\n"));
    CHECK_THAT(pov_text(scene, with(PovPreset::direct)), !Contains("radiosity {"));
    for (const std::string& text : {published, physical}) CHECK_THAT(text, Contains("ambient 0"));
}

TEST_CASE("pov: a mesh2 for each object and material, without triangles of no area, every digit of a vertex", "[pov]") {
    Scene scene = floor_from_above(0.5f);
    add_quad(scene, diffuse({0.25f, 0.5f, 0.125f}), {0, 0, 0}, {1.0f / 3, 0, 0}, {0, 0.1f, 0});
    Mesh& mesh = scene.meshes[1];
    mesh.triangles.push_back({0, 1, 1}), mesh.material.push_back(1);
    mesh.triangles.push_back({0, 2, 3}), mesh.material.push_back(0);
    const std::string text = pov_text(scene);
    CHECK(count(text, "mesh2 {") == 3);
    CHECK(count(text, "texture { material_0 }") == 2);
    CHECK(count(text, "texture { material_1 }") == 1);
    CHECK_THAT(text, Contains("face_indices { 2,\n<0,1,2>,\n<0,2,3> }"));
    CHECK_THAT(text, Contains("<0.33333334,0.1,0>") && Contains("pigment { rgb <0.25,0.5,0.125> }"));
    CHECK_THAT(text, !Contains("<0,1,1>"));
}

TEST_CASE("pov: names cannot leave their comments", "[pov]") {
    Scene scene = floor_from_above(0.5f);
    scene.name = scene.meshes[0].name = scene.materials[0].name = "a\n\"}} #error \"x\\\r\n*/";
    Light lamp;
    lamp.name = scene.name, lamp.type = LightType::point, lamp.position = {0, 1, 0};
    scene.lights = {lamp};
    const std::string text = pov_text(scene);
    const std::regex comment("//[^\n]*");
    CHECK_THAT(std::regex_replace(text, comment, ""), !Contains("#error") && !Contains("\"") && !Contains("\r"));
    if (povray()) CHECK(rendered(scene, with(PovPreset::direct)).at(20, 15).x > 0);
}

TEST_CASE("pov: what it cannot show is said, what is replaced is the mean", "[pov]") {
    Scene scene = floor_from_above(1);
    Texture texture;
    texture.texels = Image<std::uint32_t>(2, 1, 0xff000000u);
    texture.texels(1, 0) = 0xff0000ffu;  // red in half of it
    scene.textures = {texture};
    Material& m = scene.materials[0];
    m.texture = 0, m.normal_texture = 0, m.alpha_cutoff = 0.5f, m.mirror = glm::vec3(0.25f), m.reflectance = glm::vec3(0.5f);
    // Rows of solid angle 1/4, 1/2, 1/4 of the sphere, of which the middle one shines.
    scene.environment.map = Image4(1, 3);
    scene.environment.map(0, 1) = glm::vec4(4);
    scene.environment.radiance = glm::vec3(2);
    const std::vector<std::string> notes = pov_notes(scene);
    std::string all;
    for (const std::string& note : notes) all += note + "\n";
    CHECK(all == "1 textures of materials are replaced by their mean\n1 normal maps are left out\n1 masked materials are "
                 "solid\n1 materials reflect their diffuse part alone\nthe environment map is replaced by its mean\n");
    CHECK_THAT(pov_text(scene), Contains("// " + notes[0]) && Contains("pigment { rgb <0.25,0,0> }"));
    CHECK(pov_scene(scene).environment.radiance.x == Approx(4).epsilon(1e-6));
    CHECK(pov_scene(scene).materials[0].reflectance == glm::vec3(0.25f, 0, 0));
    CHECK(pov_notes(floor_from_above(1)).empty());
    CHECK_THAT(pov_notes(scene, with(PovPreset::published)).back(), Contains("not physical"));
    CHECK_THAT(pov_notes(scene, with(PovPreset::direct)).back(), Contains("light nothing"));
}

TEST_CASE("pov: lamps without shadows, and brightness 1 of table 1's block", "[pov][ISR listing 9]") {
    Scene scene = floor_from_above(0.5f);
    Light point, sun;
    point.type = LightType::point, sun.type = LightType::directional;
    point.position = {0, 1, 0};
    scene.lights = {point, sun};
    CHECK(count(pov_text(scene, with(PovPreset::direct)), "shadowless") == 0);
    PovOptions options = with(PovPreset::published);
    options.shadowless = true, options.brightness = 1;
    const std::string text = pov_text(scene, options);
    CHECK(count(text, "light_source {") == 2);
    CHECK(count(text, "  shadowless\n}") == 2);
    CHECK_THAT(text, Contains("brightness 1\n") && !Contains("not physical"));
}

TEST_CASE("pov: bad scenes, options and places are refused in a line", "[pov]") {
    const Scene scene = floor_from_above(0.5f);
    auto refused = [&](auto&& change, PovOptions options = {}) {
        Scene s = scene;
        s.lights.resize(1);
        s.lights[0].name = "key";
        change(s);
        return error_of([&] { pov_text(s, options); });
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK(refused([](Scene&) {}).empty());
    CHECK(refused([](Scene& s) { s.lights[0].radius = 2; }).empty());
    require_message(refused([&](Scene& s) { s.lights[0].intensity.x = nan; }), {"light \"key\"", "finite"});
    require_message(refused([&](Scene& s) { s.lights[0].direction = glm::vec3(0); }), {"light \"key\"", "direction"});
    require_message(refused([&](Scene& s) { s.materials[0].reflectance.y = nan; }), {"material \"m\"", "finite"});
    require_message(refused([&](Scene& s) { s.meshes[0].vertices[2].position.z = nan; }), {"floor", "vertex", "finite"});
    require_message(refused([&](Scene& s) { s.environment.radiance.z = nan; }), {"environment"});
    require_message(refused([&](Scene& s) { s.camera.fov_y_deg = 180; }), {"fov_y_deg"});
    for (int bounces : {0, 21}) require_message(refused([](Scene&) {}, with(PovPreset::physical, bounces)), {"bounces"});
    PovOptions options;
    options.samples = 1601;
    require_message(refused([](Scene&) {}, options), {"samples = 1601", "1 to 1600"});
    options = {};
    options.size = {0, 5};
    require_message(refused([](Scene&) {}, options), {"size = 0 x 5"});
    const Folder folder;
    require_message(error_of([&] { write_pov(folder / "missing/a.pov", scene); }), {"missing/a.pov"});
    CHECK(folder.files() == 0);
    CHECK(povray_command_line("a.pov", "b c'.exr", {4, 3}) ==
          "povray +Ia.pov '+O\"b c'\\''.exr\"' +FE +W4 +H3 -A -D +WT1");
    CHECK(povray_command("a\".pov", "b.exr", {4, 3})[1] == "+I'a\".pov'");
    require_message(error_of([] { povray_command("a\"'.pov", "b.exr", {4, 3}); }), {"a\"'.pov", "quotes"});
}

// ---- what POV-Ray makes of it -----------------------------------------------------------------------------------------

TEST_CASE("pov: POV-Ray's lamp over a floor is P / (4 pi) h / (h^2 + r^2)^(3/2)", "[pov][povray][analytic]") {
    if (!povray()) return;
    const double power = 10, h = 1.5, rho = 0.5;
    Scene scene = floor_from_above(float(rho), 1.2);  // the camera hangs below the lamp
    Light lamp;
    lamp.type = LightType::point;
    lamp.position = {0.25f, float(h), -0.125f};
    lamp.intensity = glm::vec3(float(power / (4 * host::pi)));
    scene.lights = {lamp};
    const Rendered r = rendered(scene, with(PovPreset::direct));
    for (int y = 0; y < 30; y += 3)
        for (int x = 0; x < 40; x += 3) {
            const glm::dvec3 p = on_floor(scene, x, y);
            const double dx = p.x - 0.25, dz = p.z + 0.125, d2 = h * h + dx * dx + dz * dz;
            const double want = rho / host::pi * power / (4 * host::pi) * h / (d2 * std::sqrt(d2));
            CAPTURE(x, y, p.x, p.z, r.at(x, y).x, want);
            CHECK(std::abs(r.at(x, y).x / want - 1) < 2 * half_rounding);
        }
}

TEST_CASE("pov: POV-Ray's sum of fadings is a light that ends at its radius, ISR (16)", "[pov][povray][ISR (16)][analytic]") {
    if (!povray()) return;
    const double h = 0.25, rho = 0.5, intensity = 3;
    for (const double radius : {0.9, 2.0}) {
        CAPTURE(radius);
        Scene scene = floor_from_above(float(rho), 1.2);
        Light lamp;
        lamp.type = LightType::point;
        lamp.position = {0.25f, float(h), -0.125f};
        lamp.intensity = glm::vec3(float(intensity)), lamp.radius = float(radius);
        scene.lights = {lamp};
        CHECK_THAT(pov_notes(scene).front(), Contains("end at a radius"));
        const Rendered r = rendered(scene, with(PovPreset::direct));
        int lit = 0, dark = 0;
        for (int y = 0; y < 30; ++y)
            for (int x = 0; x < 40; ++x) {
                const glm::dvec3 p = on_floor(scene, x, y);
                const double dx = p.x - 0.25, dz = p.z + 0.125, d = std::sqrt(h * h + dx * dx + dz * dz);
                const double full = rho / host::pi * intensity * h / d, sent = std::max(0.0, 1 - d * d / (radius * radius));
                CAPTURE(x, y, d, r.at(x, y).x, full * sent);
                CHECK(std::abs(r.at(x, y).x - full * sent) <= 0.015 * full + half_rounding * full);
                lit += sent > 0.2, dark += sent == 0;
            }
        CHECK(lit > 100);
        if (radius < 1) CHECK(dark > 20);
    }
}

TEST_CASE("pov: POV-Ray's spot falls off as ours between its cones", "[pov][povray][analytic]") {
    if (!povray()) return;
    Scene scene = floor_from_above(0.8f, 1.9);
    Light spot;
    spot.type = LightType::spot;
    spot.position = {0.1f, 2, 0.2f}, spot.direction = glm::normalize(glm::vec3(0.1f, -1, -0.15f));
    spot.cone_inner_deg = 8, spot.cone_outer_deg = 25, spot.intensity = {5, 2, 1};
    scene.lights = {spot};
    const Rendered r = rendered(scene, with(PovPreset::direct));
    const double inner = std::cos(8 * host::pi / 180), outer = std::cos(25 * host::pi / 180);
    int between = 0, dark = 0;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            const glm::dvec3 d = on_floor(scene, x, y) - glm::dvec3(spot.position);
            const double distance = glm::length(d), cosine = glm::dot(d, glm::dvec3(spot.direction)) / distance;
            const double t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
            const double want = 0.8 / host::pi * 5 * t * t * (3 - 2 * t) * (2 / distance) / (distance * distance);
            CAPTURE(x, y, t, r.at(x, y).x, want);
            CHECK(std::abs(r.at(x, y).x - want) < 2 * half_rounding * want + 1e-5);
            CHECK(std::abs(r.at(x, y).y - 0.4 * want) < 2 * half_rounding * want + 1e-5);
            between += t > 0 && t < 1, dark += t == 0;
        }
    CHECK((between > 300 && dark > 100));
}

TEST_CASE("pov: POV-Ray's sun is E cos theta over pi, and what stands in its way casts a shadow", "[pov][povray][analytic]") {
    if (!povray()) return;
    Scene scene = floor_from_above(0.8f, 3, 10);
    Light sun;
    sun.type = LightType::directional;
    sun.direction = glm::normalize(glm::vec3(1, -1, 0)), sun.intensity = glm::vec3(3);
    scene.lights = {sun};
    add_quad(scene, diffuse(glm::vec3(0.5f)), {-3, 2.5f, 10}, {0, 0, -20}, {0, 0.5f, 0});  // its shadow: x from -0.5 to 0
    const Rendered r = rendered(scene, with(PovPreset::direct));
    int lit = 0, shadowed = 0;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            const double at = on_floor(scene, x, y).x;
            if (std::abs(at) < 1e-3 || std::abs(at + 0.5) < 1e-3) continue;
            const bool dark = at > -0.5 && at < 0;
            const double want = dark ? 0 : 0.8 / host::pi * 3 * std::sqrt(0.5);
            CAPTURE(x, y, at);
            CHECK(std::abs(r.at(x, y).x - want) <= 2 * half_rounding * want);
            lit += !dark, shadowed += dark;
        }
    CHECK((lit > 500 && shadowed > 60));
}

// Squares that shine in colours of their own, seen by a camera that leans: each is where our camera sees it, so that
// nothing is mirrored, turned or shifted by half a pixel.
TEST_CASE("pov: POV-Ray's camera is ours", "[pov][povray]") {
    if (!povray()) return;
    Scene scene;
    scene.frame_size = {160, 90};
    scene.camera.position = {1, 2, 6}, scene.camera.look_at = {0.2, 0.5, 0}, scene.camera.up = {0.3, 1, 0.1};
    scene.camera.fov_y_deg = 38;
    const std::vector<glm::vec3> places = {{-2, 1.5f, 0}, {2, 1.6f, -1}, {-1.5f, -0.8f, 0.5f}, {1.8f, -0.5f, 1}};
    const std::vector<glm::vec3> colours = {{4, 0, 0}, {0, 3, 0}, {0, 0, 2}, {5, 0, 1}};
    const CameraAxes a = axes(scene.camera);
    const glm::vec3 right(a.right), up(a.up);
    for (std::size_t i = 0; i < places.size(); ++i)
        add_quad(scene, diffuse(glm::vec3(0), colours[i]), places[i] - 0.3f * right - 0.3f * up, 0.6f * right, 0.6f * up);
    const Rendered r = rendered(scene, with(PovPreset::direct));
    std::size_t seen[4] = {};
    int doubtful = 0;
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 160; ++x) {
            glm::dvec3 want(0);
            const Ray ray = ray_through_pixel(scene.camera, scene.frame_size, {x, y});
            double nearest = 1e30, edge = 1e30;
            for (std::size_t i = 0; i < places.size(); ++i) {
                const glm::dvec3 to = glm::dvec3(places[i]) - ray.origin;
                const glm::dvec3 d = ray.direction * (glm::dot(a.forward, to) / glm::dot(a.forward, ray.direction)) - to;
                const double beyond = std::max(std::abs(glm::dot(d, a.right)), std::abs(glm::dot(d, a.up))) - 0.3;
                edge = std::min(edge, std::abs(beyond));
                if (beyond < 0 && glm::dot(a.forward, to) < nearest)
                    nearest = glm::dot(a.forward, to), want = glm::dvec3(colours[i]) / host::pi, ++seen[i];
            }
            // A pixel is 0.05 m wide there.
            if (edge < 1e-3) ++doubtful;
            CAPTURE(x, y, edge);
            CHECK((edge < 1e-3 || glm::length(r.at(x, y) - want) <= 2 * half_rounding * glm::length(want)));
        }
    CHECK(doubtful < 40);
    for (const std::size_t n : seen) CHECK(n > 100);
}

TEST_CASE("pov: by radiosity a uniform environment makes a floor rho L", "[pov][povray][analytic]") {
    if (!povray()) return;
    Scene scene = floor_from_above(0.6f);
    scene.environment.radiance = {2, 1, 0.5f};
    const Rendered r = rendered(scene, with(PovPreset::physical));
    for (int y = 1; y < 30; y += 4)
        for (int x = 1; x < 40; x += 4)
            for (int c = 0; c < 3; ++c)
                CHECK(r.at(x, y)[c] == Approx(0.6 * scene.environment.radiance[c]).epsilon(0.005));
}

// A square of side 2 that shines both ways at the height of 1: beneath its middle
// F = 4/(2 pi) [2 X/sqrt(1+X^2) atan(X/sqrt(1+X^2))], X = 1 (Howell B-3, four quarters).
TEST_CASE("pov: by radiosity a square of exitance M over a floor is M F rho / pi", "[pov][povray][analytic]") {
    if (!povray()) return;
    Scene scene = floor_from_above(0.5f, 0.9);
    scene.camera.fov_y_deg = 10;
    add_quad(scene, diffuse({0, 0.5f, 0.5f}, {8, 4, 0}), {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
    const double x = 1 / std::sqrt(2.0), factor = 4 / (2 * host::pi) * 2 * x * std::atan(x);
    const Rendered r = rendered(scene, with(PovPreset::physical));
    glm::dvec3 mean(0);
    for (int j = 0; j < 30; ++j)
        for (int i = 0; i < 40; ++i) mean += r.at(i, j) / 1200.0;
    const double want = 8 * factor * 0.5 / host::pi;
    CAPTURE(mean.x, mean.y, mean.z, want);
    CHECK(mean.x == Approx(want).epsilon(0.02));
    CHECK(mean.y == Approx(want / 2).epsilon(0.02));
    CHECK(mean.z < 1e-5);
}
