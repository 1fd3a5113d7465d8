// The z-buffer techniques in closed form: what Lambert's cosine, Phong's and Blinn's lobes send, at vertices and at pixels.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "tests/gi/zbuffer_scenes.h"

namespace {

using namespace plumb;
using namespace plumb::test;
using namespace plumb::zbuffer;

constexpr Technique techniques[] = {Technique::c,    Technique::ca,   Technique::cad,   Technique::cas,
                                    Technique::cads, Technique::cas_p, Technique::cads_p};

double power(double x, int n) {
    double p = 1;
    for (int i = 0; i < n; ++i) p *= x;
    return p;
}

// What either form sends of a pixel at the origin, where the light and the eye are so far away that all vertices see the same.
PixelLight sent_of(const ZbufferParams& params, const PlanePixels& p, const glm::vec3& towards_eye) {
    const glm::vec3 eye = 1e6f * towards_eye;
    return per_pixel(params.technique) ? lit_pixels(params, p, eye) : interpolated(params, p, eye);
}

}  // namespace

TEST_CASE("zbuffer: Lambert's cosine from 0 to 90 degrees, and nothing from behind", "[zbuffer][HEM 4.4.4][analytic]") {
    PlanePixels p(1);
    for (const Technique technique : {Technique::cad, Technique::cads, Technique::cads_p})
        for (int degrees = 0; degrees <= 180; degrees += 5) {
            p.lights = {sun_from(at_angle(degrees))};
            const glm::vec4 e = sent_of(params_of(technique, {0.5f, 0, 0}), p, {0, 0, 1}).irradiance(0, 0);
            const double lit = 3 * std::max(0.0, host::cos(radians(degrees)));
            INFO(degrees);
            CHECK(double(e.x) == Approx(host::pi / 2 + lit).epsilon(2e-6).margin(1e-6));
            CHECK(double(e.y) == Approx(lit).margin(1e-6));
        }
    // Lights add up.
    p.lights = {sun_from(at_angle(0)), sun_from(at_angle(60)), sun_from(at_angle(120))};
    CHECK(sent_of(params_of(Technique::cads_p), p, {0, 0, 1}).irradiance(0, 0).x == Approx(4.5));
}

TEST_CASE("zbuffer: a lamp with a place sends I / d^2, and its cone ends", "[zbuffer][analytic]") {
    PlanePixels p(2);
    p.position(1, 0) = glm::vec4(3, 0, 0, 0);
    Light lamp;
    lamp.type = LightType::point, lamp.position = {0, 0, 4}, lamp.intensity = glm::vec3(32);
    p.lights = {lamp};
    const PixelLight light = lit_pixels(params_of(Technique::cads_p), p, {0, 0, 4});
    CHECK(light.irradiance(0, 0).x == Approx(2));                    // 32 / 16
    CHECK(light.irradiance(1, 0).x == Approx(32.0 / 25 * 4 / 5));    // at 5 m, cosine 4/5
    CHECK(light.sent(0, 0).z == Approx(2));                          // seen from the lamp, along the normal: C_s E
    lamp.type = LightType::spot, lamp.cone_inner_deg = 20, lamp.cone_outer_deg = 30, lamp.direction = {0, 0, -1};
    p.lights = {lamp};
    const PixelLight spot = lit_pixels(params_of(Technique::cads_p), p, {0, 0, 4});
    CHECK(spot.irradiance(0, 0).x == Approx(2));
    CHECK(spot.irradiance(1, 0) == glm::vec4(0));                    // 36.9 degrees off its axis
}

TEST_CASE("zbuffer: Phong's lobe is the specular colour at the mirrored direction, cos^n beside it", "[zbuffer][HEM 4.4.5][analytic]") {
    PlanePixels p(1);
    for (const Technique technique : {Technique::cas, Technique::cads, Technique::cas_p, Technique::cads_p})
        for (const int from : {0, 20, 45}) {
            p.lights = {sun_from(at_angle(from))};
            for (const int beside : {-10, 0, 10, 25}) {
                INFO("technique " << int(technique) << ", light at " << from << ", eye " << beside << " degrees beside");
                const glm::vec4 s = sent_of(params_of(technique), p, at_angle(-from + beside)).sent(0, 0);
                const double expected = 3 * power(host::cos(radians(beside)), 10);
                CHECK(double(s.x) == Approx(0.25 * expected).epsilon(2e-5));
                CHECK(double(s.y) == Approx(0.5 * expected).epsilon(2e-5));
                CHECK(double(s.z) == Approx(expected).epsilon(2e-5));
            }
        }
}

TEST_CASE("zbuffer: Blinn's lobe by the half angle", "[zbuffer][HEM 4.4.5][analytic]") {
    PlanePixels p(1);
    p.lights = {sun_from(at_angle(30))};
    for (const Technique technique : {Technique::cas, Technique::cas_p})
        for (const int beside : {-20, 0, 10, 40}) {
            ZbufferParams params = params_of(technique);
            params.lobe = Lobe::blinn;
            const double s = double(sent_of(params, p, at_angle(-30 + beside)).sent(0, 0).z);
            CHECK(s == Approx(3 * power(host::cos(radians(beside / 2.0)), 10)).epsilon(2e-5));
        }
}

TEST_CASE("zbuffer: no highlight of a lamp behind the surface", "[zbuffer][HEM 4.4.5]") {
    PlanePixels p(1);
    for (const Lobe lobe : {Lobe::phong, Lobe::blinn})
        for (const Technique technique : {Technique::cads, Technique::cads_p})
            for (int from = 91; from <= 269; from += 7)
                for (int eye = -80; eye <= 80; eye += 20) {
                    ZbufferParams params = params_of(technique);
                    params.lobe = lobe;
                    p.lights = {sun_from(at_angle(from))};
                    CHECK(sent_of(params, p, at_angle(eye)).sent(0, 0) == glm::vec4(0));
                }
}

TEST_CASE("zbuffer: what each technique adds up", "[zbuffer][HEM 5.3][HEM 5.4]") {
    PlanePixels p(1);
    p.lights = {sun_from(at_angle(0))};
    p.emission(0, 0) = glm::vec4(7, 0, 0, 0);
    for (const Technique technique : techniques) {
        INFO(int(technique));
        const PixelLight light = sent_of(params_of(technique, glm::vec3(0.5f)), p, {0, 0, 1});
        const double ambient = technique == Technique::c ? host::pi : host::pi / 2, diffuse = has_diffuse(technique) ? 3 : 0;
        CHECK(double(light.irradiance(0, 0).y) == Approx(ambient + diffuse));
        CHECK(double(light.sent(0, 0).z) == Approx(has_specular(technique) ? 3 : 0));
        CHECK(double(light.sent(0, 0).x) == Approx(7 + (has_specular(technique) ? 0.75 : 0)));
    }
    // Where nothing is seen nothing is sent.
    p.id(0, 0) = glm::ivec2(-1);
    for (const Technique technique : techniques) {
        const PixelLight light = sent_of(params_of(technique, glm::vec3(0.5f)), p, {0, 0, 1});
        CHECK(light.irradiance(0, 0) == glm::vec4(0));
        CHECK(light.sent(0, 0) == glm::vec4(0));
    }
}

TEST_CASE("zbuffer: exponents 0 and a million", "[zbuffer][extreme]") {
    for (const Technique technique : {Technique::cas, Technique::cas_p})
        for (const Lobe lobe : {Lobe::phong, Lobe::blinn}) {
            ZbufferParams params = params_of(technique);
            params.lobe = lobe;
            PlanePixels p(1, {1, 1, 1, 0});
            p.lights = {sun_from(at_angle(0))};
            // n = 0: everywhere in front, as bright as the mirrored direction.
            CHECK(sent_of(params, p, at_angle(60)).sent(0, 0).x == 3);
            // A mirror: at the mirrored direction alone.
            p.table.materials[1].w = 1e6f;
            CHECK(sent_of(params, p, {0, 0, 1}).sent(0, 0).x == 3);
            // A degree beside it, of the half angle half of one: cos^n is exp(-n a^2 / 2), 1e-66 and 3e-17.
            CHECK(sent_of(params, p, at_angle(1)).sent(0, 0).x < 1e-15f);
        }
}

TEST_CASE("zbuffer: saturated colours end at 1, of vertices before they are interpolated", "[zbuffer][HEM 5.3.3]") {
    PlanePixels p(2, {0.5f, 0.5f, 0.5f, 10});
    p.lights = {sun_from(at_angle(0), glm::vec3(float(2 * host::pi)))};
    p.position(1, 0) = glm::vec4(4, 4, 0, 0);
    const auto colour = [&](const PixelLight& light, int i) {
        return (glm::dvec3(p.albedo(i, 0)) * glm::dvec3(light.irradiance(i, 0)) + glm::dvec3(light.sent(i, 0))) / host::pi;
    };
    for (const Technique technique : {Technique::cads, Technique::cads_p}) {
        ZbufferParams params = params_of(technique);
        const glm::dvec3 hdr = colour(sent_of(params, p, {0, 0, 1}), 0);
        CHECK(hdr.x == Approx(2));     // 0.5 x 2 + 0.5 x 2
        CHECK(hdr.y == Approx(1.5));
        CHECK(hdr.z == Approx(3));
        params.range = Range::saturate;
        const glm::dvec3 ends = colour(sent_of(params, p, {0, 0, 1}), 0);
        for (int c = 0; c < 3; ++c) CHECK(ends[c] == Approx(1));
        // What is no brighter stays as it is.
        p.lights[0].intensity = glm::vec3(0.3f);
        const PixelLight dim = sent_of(params, p, {0, 0, 1});
        CHECK(dim.irradiance(0, 0).x == Approx(0.3));
        CHECK(dim.sent(0, 0).x == Approx(0.15));
        p.lights[0].intensity = glm::vec3(float(2 * host::pi));
    }
    // Of a highlight at one corner alone, half way to the next: HDR interpolates (2 + 1) / 2, saturated (1 + 1) / 2.
    p.table.materials = {{0.5f, 0.5f, 0.5f, 0}, {0.5f, 0.5f, 0.5f, 1e6f}};
    p.position(0, 0) = glm::vec4(4, -4, 0, 0), p.albedo(0, 0) = glm::vec4(0.5f, 0.5f, 0.5f, 0);
    ZbufferParams params = params_of(Technique::cads);
    CHECK(colour(interpolated(params, p, {-4, -4, 9}), 0).x == Approx(1.5));
    params.range = Range::saturate;
    CHECK(colour(interpolated(params, p, {-4, -4, 9}), 0).x == Approx(1));
}

TEST_CASE("zbuffer: the same bits by every instruction set and number of threads", "[zbuffer][bits]") {
    PlanePixels p(37, {0.25f, 0.5f, 1, 12.5f});
    for (int i = 0; i < 37; ++i) {
        p.position(i, 0) = glm::vec4(0.2f * float(i) - 3, 0.1f * float(i) - 3, 0, 0);
        if (i % 7 == 3) p.id(i, 0) = glm::ivec2(-1);
    }
    Light lamp;
    lamp.position = {1, 1, 3}, lamp.direction = {0, 0, -1}, lamp.intensity = {5, 6, 7};
    p.lights = {sun_from(glm::normalize(glm::vec3(1, 2, 3))), lamp};
    for (const Technique technique : {Technique::cads, Technique::cads_p})
        for (const Variant variant : {Variant::corrected, Variant::published}) {
            ZbufferParams params = params_of(technique, glm::vec3(0.2f));
            params.variant = variant;
            const auto sent = [&](const RunOptions& options) {
                return per_pixel(technique) ? lit_pixels(params, p, {1, -2, 5}, options) : interpolated(params, p, {1, -2, 5}, options);
            };
            const PixelLight base = sent({Isa::scalar, 1, {}});
            CHECK(base.sent(0, 0).x > 0);
            for (const Isa isa : supported_isas())
                for (const int threads : {1, 3}) {
                    const PixelLight other = sent({isa, threads, {}});
                    CHECK((other.irradiance.texels == base.irradiance.texels));
                    CHECK((other.sent.texels == base.sent.texels));
                }
        }
}

TEST_CASE("zbuffer: refuses what is not bound, and what HEM does not print", "[zbuffer][extreme]") {
    PlanePixels p(3);
    ZbufferParams params;
    PixelsInputs in = p.inputs({0, 0, 1});
    in.table = nullptr;
    CHECK_THROWS_AS(data_of(params, in), InputError);
    in = p.inputs({0, 0, 1}), in.id = nullptr;
    CHECK_THROWS_AS(data_of(params, in), InputError);
    in = p.inputs({0, 0, 1}), in.albedo = nullptr;
    CHECK_THROWS_AS(data_of(params, in), InputError);
    CHECK_THROWS_AS(data_of(params, VerticesInputs{}), InputError);
    CHECK_THROWS_AS(data_of(params, InterpolateInputs{&p.position, &p.id, &p.emission, &p.table, nullptr, {}}), InputError);
    params.variant = Variant::published, params.lobe = Lobe::blinn;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("prints no listing"));
    params.lobe = Lobe::phong, params.renormalise = false;
    CHECK_THROWS_WITH(validate(params), Catch::Contains("figure 5.2") || Catch::Contains("unit again"));
    params = {};
    params.ambient.y = -1;
    CHECK_THROWS_AS(validate(params), InputError);
    // Without a vertex, a triangle or a lamp there is nothing to see.
    p.table = {}, p.lights.clear();
    for (glm::ivec2& id : p.id.texels) id = glm::ivec2(-1);
    for (const Technique technique : techniques) CHECK(sent_of(params_of(technique), p, {0, 0, 1}).irradiance(1, 0) == glm::vec4(0));
}
