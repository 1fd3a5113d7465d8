// What the listings of HEM 5.3 and 5.4 get wrong, each beside what is right; and what interpolation does.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/gi/zbuffer_scenes.h"

namespace {

using namespace plumb;
using namespace plumb::test;
using namespace plumb::zbuffer;

ZbufferParams printed(Technique technique) {
    ZbufferParams p = params_of(technique);
    p.variant = Variant::published;
    return p;
}

double power(double x, int n) {
    double p = 1;
    for (int i = 0; i < n; ++i) p *= x;
    return p;
}

PixelLight sent_of(const ZbufferParams& params, const PlanePixels& p, const glm::vec3& towards_eye) {
    const glm::vec3 eye = 1e6f * towards_eye;
    return per_pixel(params.technique) ? lit_pixels(params, p, eye) : interpolated(params, p, eye);
}

// A square of the plane through the origin with that normal in its mesh's own space, under a transform; lit by suns.
VertexTable table_under(const glm::dmat4& transform, const glm::vec3& normal) {
    Scene scene;
    scene.materials = {Material{}};
    Mesh mesh;
    const glm::vec3 across = glm::normalize(glm::cross(glm::vec3(0, 1, 0), normal)), up = glm::cross(normal, across);
    for (const glm::vec2 c : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1)})
        mesh.vertices.push_back({c.x * across + c.y * up, 0, normal, 0});
    mesh.triangles = {{0, 1, 2}}, mesh.material = {0}, mesh.transform = transform;
    scene.meshes = {mesh};
    return vertex_table(scene, flatten(scene));
}

glm::dmat4 scaled(const glm::dvec3& s) {
    glm::dmat4 m(1);
    for (int c = 0; c < 3; ++c) m[c][c] = s[c];
    return m;
}

}  // namespace

TEST_CASE("zbuffer: as printed a lit surface sends its highlight back to the lamp", "[zbuffer][HEM 5.3.4][published]") {
    // dot(vecLightWorld, n) < 0 there, so that saturate() leaves R = -vecLightWorld = L: the lobe is (L . V)^n.
    PlanePixels p(1);
    for (const Technique technique : {Technique::cas, Technique::cads, Technique::cas_p, Technique::cads_p})
        for (const int eye : {-30, 0, 30, 50}) {
            p.lights = {sun_from(at_angle(30), glm::vec3(0.5f))};
            INFO(int(technique) << " " << eye);
            const double right = double(sent_of(params_of(technique), p, at_angle(eye)).sent(0, 0).z);
            const double wrong = double(sent_of(printed(technique), p, at_angle(eye)).sent(0, 0).z);
            CHECK(right == Approx(0.5 * power(std::max(0.0, host::cos(radians(eye + 30))), 10)).epsilon(3e-5).margin(1e-7));
            CHECK(wrong == Approx(0.5 * power(host::cos(radians(eye - 30)), 10)).epsilon(3e-5));
        }
}

TEST_CASE("zbuffer: as printed the mirrored highlight is that of a lamp behind the surface", "[zbuffer][HEM 5.3.4][published]") {
    // "specular reflection will be rendered in the other side of the world" (5.3.3): vecLightWorld points out of the surface.
    PlanePixels p(1);
    p.lights = {sun_from(at_angle(180 + 20), glm::vec3(0.5f))};
    for (const Technique technique : {Technique::cads, Technique::cads_p}) {
        CHECK(sent_of(params_of(technique), p, at_angle(-20)).sent(0, 0) == glm::vec4(0));
        const PixelLight wrong = sent_of(printed(technique), p, at_angle(-20));
        CHECK(wrong.sent(0, 0).z == Approx(0.5).epsilon(2e-5));
        CHECK(wrong.irradiance(0, 0) == glm::vec4(0));  // VS_CAD's diffuse part has the sign right
    }
}

TEST_CASE("zbuffer: as printed normals are multiplied by the world matrix, not by its inverse transpose", "[zbuffer][HEM 5.3.3][published]") {
    const float half = float(std::sqrt(0.5));
    const VertexTable table = table_under(scaled({2, 1, 1}), {half, 0, half});
    const std::vector<Light> lights = {sun_from({0, 0, 1}, glm::vec3(1))};
    // (1/2, 0, 1) is across the surface; (2, 0, 1) is not.
    CHECK(lit_vertices(params_of(Technique::cad), table, lights, {0, 0, 9}).diffuse(0, 0).x == Approx(1 / std::sqrt(1.25)));
    CHECK(lit_vertices(printed(Technique::cad), table, lights, {0, 0, 9}).diffuse(0, 0).x == Approx(1 / std::sqrt(5.0)));
    // A matrix that turns, and one that scales all sides alike, change nothing of it.
    for (const double s : {1e-3, 1.0, 1e6}) {
        const VertexTable even = table_under(scaled(glm::dvec3(s)), {half, 0, half});
        CHECK(lit_vertices(printed(Technique::cad), even, lights, {0, 0, 9}).diffuse(0, 0).x == Approx(std::sqrt(0.5)));
    }
}

TEST_CASE("zbuffer: as printed light turns with what it shines on", "[zbuffer][HEM 5.3.3][published]") {
    // mul(vecLightDirection, matWorld): a quarter turn about y takes z to x.
    glm::dmat4 turn(1);
    turn[0] = {0, 0, -1, 0}, turn[2] = {1, 0, 0, 0};
    const VertexTable table = table_under(turn, {0, 0, 1});
    CHECK(table.vertices[1].x == Approx(1));
    const std::vector<Light> lights = {sun_from({0, 0, 1}, glm::vec3(1))};
    CHECK(lit_vertices(params_of(Technique::cad), table, lights, {9, 0, 0}).diffuse(0, 0).x == Approx(0).margin(1e-6));
    CHECK(lit_vertices(printed(Technique::cad), table, lights, {9, 0, 0}).diffuse(0, 0).x == Approx(1));
}

TEST_CASE("zbuffer: as printed the direction to the viewer is interpolated from unit vectors", "[zbuffer][HEM 5.4.1][published]") {
    PlanePixels p(1);
    const glm::dvec3 eye(-4, -4, 1), half_way(4, -4, 0);  // above a corner, close; half way to the next, 16 m away
    p.position(0, 0) = glm::vec4(glm::vec3(half_way), 0);
    const glm::dvec3 near(0, 0, 1), far = glm::normalize(glm::dvec3(-16, 0, 1)), right = glm::normalize(eye - half_way);
    const glm::dvec3 wrong = glm::normalize(near + far);
    // Lit along the normal, the mirrored direction is the normal; as printed the lobe is about L, which is the same.
    p.lights = {sun_from({0, 0, 1}, glm::vec3(1))};
    p.table.materials[1] = glm::vec4(1, 1, 1, 2);
    CHECK(double(lit_pixels(params_of(Technique::cas_p), p, glm::vec3(eye)).sent(0, 0).x) == Approx(right.z * right.z).epsilon(1e-5));
    CHECK(double(lit_pixels(printed(Technique::cas_p), p, glm::vec3(eye)).sent(0, 0).x) == Approx(wrong.z * wrong.z).epsilon(1e-5));
    CHECK(wrong.z * wrong.z > 20 * right.z * right.z);
}

TEST_CASE("zbuffer: interpolated normals are shorter than 1 where they are not made unit again", "[zbuffer][HEM 5.4.1][figure 5.2][analytic]") {
    // Half way between normals 45 degrees to either side of z: (0, 0, cos 45).
    PlanePixels p(1);
    p.table.vertices[1] = glm::vec4(at_angle(-45), 0), p.table.vertices[3] = glm::vec4(at_angle(45), 0);
    p.position(0, 0) = glm::vec4(4, -4, 0, 0);
    p.lights = {sun_from({0, 0, 1}, glm::vec3(1))};
    ZbufferParams params = params_of(Technique::cads_p);
    CHECK(lit_pixels(params, p, {4, -4, 9}).irradiance(0, 0).x == Approx(1));
    params.renormalise = false;
    const PixelLight dark = lit_pixels(params, p, {4, -4, 9});
    CHECK(dark.irradiance(0, 0).x == Approx(std::sqrt(0.5)).epsilon(1e-5));
    // 2 (N . L) N - L = 2 / 2 z - z = 0: the mirrored vector vanishes, and nothing is sent along it; nor is anything not a number.
    CHECK(dark.sent(0, 0).z == Approx(0).margin(1e-3));
    // The listings do make them unit again.
    CHECK(lit_pixels(printed(Technique::cads_p), p, {4, -4, 9}).irradiance(0, 0).x == Approx(1));
}

TEST_CASE("zbuffer: normals that cancel, or are none, send numbers", "[zbuffer][extreme]") {
    PlanePixels p(1);
    p.table.vertices[1] = glm::vec4(1, 0, 0, 0), p.table.vertices[3] = glm::vec4(-1, 0, 0, 0);
    p.position(0, 0) = glm::vec4(4, -4, 0, 0);
    p.lights = {sun_from(at_angle(10))};
    for (const glm::vec4& third : {glm::vec4(0, 0, 1, 0), glm::vec4(0)}) {
        p.table.vertices[5] = third;
        for (const Technique technique : {Technique::cads, Technique::cads_p})
            for (const int kind : {0, 1, 2}) {
                ZbufferParams params = params_of(technique, glm::vec3(0.2f));
                if (kind == 1) params.variant = Variant::published;
                params.renormalise = kind != 2;
                const PixelLight light = sent_of(params, p, {0, 0, 1});
                for (int c = 0; c < 3; ++c) {
                    CHECK(std::isfinite(light.irradiance(0, 0)[c]));
                    CHECK(std::isfinite(light.sent(0, 0)[c]));
                }
                CHECK(double(light.irradiance(0, 0).x) >= 0.2 * host::pi * 0.9999);
            }
    }
    // The eye on the surface itself.
    CHECK(std::isfinite(lit_pixels(params_of(Technique::cads_p), p, {4, -4, 0}).sent(0, 0).x));
}

TEST_CASE("zbuffer: a triangle from behind is lit from behind", "[zbuffer][analytic]") {
    // The normals point away from the eye; the G-buffer's to it.
    PlanePixels p(1);
    p.normal(0, 0) = glm::vec4(0, 0, -1, 1);
    p.lights = {sun_from(at_angle(180 - 25)), sun_from(at_angle(0))};
    for (const Technique technique : {Technique::cads, Technique::cads_p}) {
        const PixelLight light = sent_of(params_of(technique), p, {0, 0, -1});
        CHECK(double(light.irradiance(0, 0).x) == Approx(3 * host::cos(radians(25))));
        CHECK(double(light.sent(0, 0).z) == Approx(3 * power(host::cos(radians(25)), 10)).epsilon(2e-5));
    }
}

TEST_CASE("zbuffer: light of vertices is linear between them", "[zbuffer][HEM 5.3][plate C.4][analytic]") {
    PlanePixels p(3 * 25);
    Light lamp;
    lamp.type = LightType::point, lamp.position = {0, 0, 2}, lamp.intensity = glm::vec3(20);
    p.lights = {lamp};
    const glm::vec3 eye(2, 1, 5);
    const ZbufferParams params = params_of(Technique::cads, glm::vec3(0.1f));
    const VertexLight at = lit_vertices(params, p.table, p.lights, eye);
    std::vector<glm::dvec2> bc;
    for (int i = 0; i < 75; ++i) {
        bc.emplace_back((i % 9) / 9.0 * (1 - (i / 9) / 9.0), (i / 9) / 9.0);
        p.position(i, 0) = glm::vec4(float(-4 + 16 * bc.back().x), float(-4 + 16 * bc.back().y), 0, 0);
    }
    const PixelLight light = interpolated(params, p, eye);
    for (int i = 0; i < 75; ++i)
        for (int c = 0; c < 3; ++c) {
            const auto mix = [&](const Image4& of) {
                const double a = double(of(0, 0)[c]), b = double(of(1, 0)[c]), d = double(of(2, 0)[c]);
                return a + bc[std::size_t(i)].x * (b - a) + bc[std::size_t(i)].y * (d - a);
            };
            CHECK(double(light.irradiance(i, 0)[c]) == Approx(mix(at.diffuse)).epsilon(1e-5));
            CHECK(double(light.sent(i, 0)[c]) == Approx(mix(at.specular)).epsilon(1e-5).margin(1e-7));
        }
}

TEST_CASE("zbuffer: light of vertices comes to that of pixels as h^2", "[zbuffer][HEM 5.3.4][plate C.4][convergence]") {
    Light lamp;
    lamp.type = LightType::point, lamp.position = {0.1f, 0.2f, 1}, lamp.intensity = glm::vec3(1);
    const glm::vec3 eye(-0.3f, 0.4f, 2);
    constexpr int n = 61;  // samples a side, at no fixed place of a cell
    std::vector<double> errors;
    for (const int cells : {16, 32, 64, 128}) {
        PlanePixels p(n * n, {1, 1, 1, 4});
        p.lights = {lamp};
        p.table.vertices.clear(), p.table.kinds.clear(), p.table.corners.clear();
        for (int y = 0; y <= cells; ++y)
            for (int x = 0; x <= cells; ++x) {
                p.table.vertices.emplace_back(2.0f * float(x) / float(cells) - 1, 2.0f * float(y) / float(cells) - 1, 0, 0);
                p.table.vertices.emplace_back(0, 0, 1, 0);
                p.table.kinds.emplace_back(0, 0);
            }
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x) {
                const int a = y * (cells + 1) + x, b = a + cells + 1;
                p.table.corners.emplace_back(a, a + 1, b + 1, 0), p.table.corners.emplace_back(a, b + 1, b, 0);
            }
        for (int i = 0; i < n * n; ++i) {
            const double x = (i % n + 0.37) / n, y = (i / n + 0.61) / n;
            p.position(i, 0) = glm::vec4(float(2 * x - 1), float(2 * y - 1), 0, 0);
            const int cx = int(x * cells), cy = int(y * cells);
            p.id(i, 0) = {0, 2 * (cy * cells + cx) + (y * cells - cy > x * cells - cx ? 1 : 0)};
        }
        const PixelLight vertices = interpolated(params_of(Technique::cads), p, eye), pixels = lit_pixels(params_of(Technique::cads_p), p, eye);
        double worst = 0;
        for (int i = 0; i < n * n; ++i)
            worst = std::max({worst, std::fabs(double(vertices.irradiance(i, 0).x - pixels.irradiance(i, 0).x)),
                              std::fabs(double(vertices.sent(i, 0).z - pixels.sent(i, 0).z))});
        errors.push_back(worst);
    }
    CHECK(errors[0] > 1e-3);
    for (std::size_t i = 1; i < errors.size(); ++i) {
        INFO(errors[i - 1] << " " << errors[i]);
        CHECK(errors[i - 1] / errors[i] == Approx(4).epsilon(0.15));
    }
}

TEST_CASE("zbuffer: a vertex of two materials is two, and one without a normal has its triangles'", "[zbuffer]") {
    Scene scene;
    scene.materials = {Material{}, Material{}};
    scene.materials[1].exponent = 7;
    Mesh mesh;
    for (const glm::vec3 x : {glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(1, 1, 0), glm::vec3(0, 1, 0)})
        mesh.vertices.push_back({x, 0, {0, 0, 1}, 0});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 0}}, mesh.material = {0, 1, 0};
    scene.meshes = {mesh};
    VertexTable t = vertex_table(scene, flatten(scene));
    CHECK(t.kinds.size() == 6);  // 0, 1, 2 of the first; 0, 2, 3 of the second
    CHECK((t.corners[0] == glm::ivec4(0, 1, 2, 0)));
    CHECK((t.corners[1] == glm::ivec4(3, 4, 5, 0)));
    CHECK((t.corners[2] == glm::ivec4(2, 1, 0, 0)));
    for (int i = 0; i < 3; ++i) CHECK((t.kinds[std::size_t(i)].x == 0 && t.kinds[std::size_t(3 + i)].x == 1));
    CHECK(t.materials[3].w == 7);
    scene.meshes[0].vertices[0].normal = glm::vec3(0);
    t = vertex_table(scene, flatten(scene));
    CHECK(t.kinds.size() == 7);  // the third triangle's corner is its own, and looks the other way
    CHECK(t.vertices[std::size_t(2 * t.corners[0].x + 1)].z == 1);
    CHECK(t.vertices[std::size_t(2 * t.corners[2].z + 1)].z == -1);
}
