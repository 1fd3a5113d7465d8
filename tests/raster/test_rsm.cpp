#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/formats.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "drawing.h"
#include "raster/light_view.h"
#include "raster/rsm.h"
#include "raster/workspace.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

const glm::vec3 rho(0.25f, 0.5f, 0.75f);
const glm::vec3 low(-400, -130, -400), high(400, 10, 400);  // bounds that contain the light and all that it sees

Scene plain_scene() {
    Scene scene;
    scene.materials.push_back({"wall", rho, glm::vec3(0), -1});
    return scene;
}

Light spot_light(int size) {
    Light light;
    light.name = "lamp";
    light.position = {1, 4, -2};
    light.direction = {0.3f, -1, 0.2f};
    light.cone_inner_deg = 30, light.cone_outer_deg = 42;
    light.intensity = {10, 20, 5};
    light.rsm_size = size;
    return light;
}

// One triangle far below, so large that every ray of the light meets it; tilted by `slope`.
Geometry floor_of(float slope = 0) {
    Geometry g;
    const auto y = [&](float x) { return -30 + slope * x; };
    add_triangle(g, at({-1000, y(-1000), -1000}), at({1000, y(1000), -1000}), at({0, y(0), 2000}));
    return g;
}

Rsm draw(const Geometry& g, const Light& light, const View& view, RunOptions options = {},
         Layout layout = Layout::fp32) {
    Rsm out;
    draw_rsm(g, prepare(plain_scene(), g), light, view, layout, options, out);
    return out;
}

glm::dvec3 total_flux(const Rsm& rsm) {
    glm::dvec3 sum(0);
    for (const glm::vec4& flux : rsm.flux.texels) sum += glm::dvec3(flux);
    return sum;
}

// The integrand of the spot's power over the map's plane at depth 1: f = I(cos) cos^3, I the falloff alone.
double integrand(double x, double y, double inner, double outer) {
    const double cosine = 1 / std::sqrt(1 + x * x + y * y);
    const double t = std::min(1.0, std::max(0.0, (cosine - outer) / (inner - outer)));
    return t * t * (3 - 2 * t) * cosine * cosine * cosine;
}

}  // namespace

// A spot of intensity I0 smoothstep(cos outer, cos inner, cos) sends 2 pi I0 times the integral over cos, that is
// 2 pi I0 (1 - (cos inner + cos outer) / 2): the smooth step's mean is 1/2, and the map contains the cone.
//
// The sum over texels is the midpoint rule on f = I cos^3 over the map's plane. Its error is at most h^2 / 24 times the
// integral of |f_xx| + |f_yy|, which is evaluated here by second differences on a grid four times finer.
TEST_CASE("rsm: a spot's flux sums to its power times the albedo, VRSM 4.2", "[raster][rsm][analytic]") {
    const Geometry g = floor_of();
    double last = 0;
    for (int size : {32, 64, 128, 256}) {
        const Light light = spot_light(size);
        const double inner = std::cos(30 * host::pi / 180), outer = std::cos(42 * host::pi / 180);
        const double half = std::tan(42 * host::pi / 180), h = 2 * half / size, d = h / 4;
        double bend = 0;
        for (int j = 0; j < 4 * size; ++j)
            for (int i = 0; i < 4 * size; ++i) {
                const double x = (i + 0.5) * d - half, y = (j + 0.5) * d - half, f = integrand(x, y, inner, outer);
                bend += std::abs(integrand(x - d, y, inner, outer) - 2 * f + integrand(x + d, y, inner, outer)) +
                        std::abs(integrand(x, y - d, inner, outer) - 2 * f + integrand(x, y + d, inner, outer));
            }
        const double predicted = h * h / 24 * bend;  // second differences times d^2 / d^2
        const double shape = 2 * host::pi * (1 - (inner + outer) / 2);
        const Rsm rsm = draw(g, light, light_view(light, low, high));
        const glm::dvec3 sum = total_flux(rsm);
        CAPTURE(size, predicted, sum.x, shape);
        for (int c = 0; c < 3; ++c) {
            const double exact = double(light.intensity[c]) * rho[c] * shape;
            REQUIRE(std::abs(sum[c] / (double(light.intensity[c]) * rho[c]) - shape) <= predicted + 4e-7 * shape);
            REQUIRE(sum[c] == Approx(exact).epsilon(0.01));
        }
        // Second order: four times the texels, a quarter of the bound.
        if (last > 0) REQUIRE(predicted == Approx(last / 4).epsilon(0.1));
        last = predicted;
    }
}

// A spot in front of the scene, 1 m from its nearest point and 9 m from its farthest: the near plane lies before the
// nearest corner, not at it and not behind it.
TEST_CASE("rsm: a spot outside of the scene sees its nearest corner", "[raster][rsm]") {
    Light light = spot_light(33);
    light.position = {0, 0, 0};
    light.direction = {0, 0, -1};
    // A triangle across the axis at depth 1, before a wall at depth 9.
    Geometry g;
    add_triangle(g, at({-0.4f, -0.4f, -1}), at({0.4f, -0.4f, -1}), at({0, 0.5f, -1}));
    add_triangle(g, at({-90, -90, -9}), at({90, -90, -9}), at({0, 90, -9}));
    const Rsm rsm = draw(g, light, light_view(light, {-90, -90, -9}, {90, 90, -1}));
    CHECK(rsm.position(16, 16).w == Approx(1).epsilon(1e-6));
    CHECK(rsm.position(2, 16).w == Approx(9).epsilon(1e-6));
    CHECK(rsm.flux(16, 16).x > 0);
}

// z >= 0 and z <= w, reversed: no corner of the bounds is beyond the far plane or before the near plane, whatever the
// light's direction; bounds that begin in front of the light have no other points.
TEST_CASE("rsm: from outside, bounds lie wholly between a spot's near and far planes", "[raster][rsm]") {
    int ahead = 0;
    for (int i = 0; i < 2000; ++i) {
        auto uniform = [&](int channel, double from, double to) {
            return from + (to - from) * unit_float<float>(pixel_hash<std::int32_t>(i, channel, 0, 5).x);
        };
        Light light = spot_light(16);
        const glm::vec3 from(uniform(0, -9, 0), uniform(1, -9, 0), uniform(2, -9, 0));
        const glm::vec3 to = from + glm::vec3(uniform(3, 0.1, 20), uniform(4, 0.1, 20), uniform(5, 0.1, 20));
        light.position = glm::vec3(from.x - uniform(6, 0.01, 9), uniform(7, -9, 9), uniform(8, -9, 9));
        light.direction = {1, float(uniform(9, -0.5, 0.5)), float(uniform(10, -0.5, 0.5))};
        const View view = light_view(light, from, to);
        auto depth = [&](const glm::dvec3& p) {
            const glm::dvec3 d = p - view.eye;
            return view.forward.x * d.x + view.forward.y * d.y + view.forward.z * d.z;
        };
        double nearest = 1e30;
        glm::dvec3 corners[8];
        for (int c = 0; c < 8; ++c) {
            corners[c] = {c & 1 ? to.x : from.x, c & 2 ? to.y : from.y, c & 4 ? to.z : from.z};
            nearest = std::min(nearest, depth(corners[c]));
        }
        if (nearest < 0.001) continue;
        ++ahead;
        for (const glm::dvec3& corner : corners) {
            const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(corner, 1);
            CAPTURE(i, nearest, clip.z, clip.w);
            REQUIRE((clip.z >= 0 && clip.z <= clip.w));
        }
    }
    CHECK(ahead > 500);
}

TEST_CASE("rsm: flux does not depend on how the surface is tilted", "[raster][rsm]") {
    const Light light = spot_light(64);
    const View view = light_view(light, low, high);
    const Rsm flat = draw(floor_of(), light, view), tilted = draw(floor_of(0.3f), light, view);
    REQUIRE(std::memcmp(flat.flux.data(), tilted.flux.data(), flat.flux.size() * sizeof(glm::vec4)) == 0);
}

TEST_CASE("rsm: a directional light's flux sums to E_perp times the map's area times the albedo",
          "[raster][rsm][analytic]") {
    Light light;
    light.type = LightType::directional;
    light.direction = {0.4f, -1, 0.3f};
    light.intensity = {3, 2, 1};
    for (int size : {1, 33, 256}) {
        light.rsm_size = size;
        const View view = light_view(light, {-5, -40, -5}, {5, 0, 5});
        const double radius = std::sqrt(25 + 400 + 25) * (1 + 0x1p-10);
        // The floor cuts through the box within the map: y = -20 at its middle.
        Geometry g;
        add_triangle(g, at({-1000, -20, -1000}), at({1000, -20, -1000}), at({0, -20, 2000}));
        const Rsm rsm = draw(g, light, view);
        CHECK(rsm.texel_scale == Approx(2 * radius / size).epsilon(1e-14));
        const glm::dvec3 sum = total_flux(rsm);
        for (int c = 0; c < 3; ++c)
            CHECK(sum[c] == Approx(double(light.intensity[c]) * rho[c] * 4 * radius * radius).epsilon(4e-7));
    }
}

TEST_CASE("rsm: positions are where the light's rays meet the floor, depth is linear", "[raster][rsm][analytic]") {
    const Light light = spot_light(128);
    const View view = light_view(light, low, high);
    const Rsm rsm = draw(floor_of(), light, view);
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const glm::vec4 p = rsm.position(x, y);
            const glm::dvec2 texel = project_to_texels(rsm.view, 128, glm::dvec3(p));
            CAPTURE(x, y, texel.x, texel.y);
            // 1/512 texel by snapping, and the rounding of a position on a triangle of 2 km.
            REQUIRE(std::abs(texel.x - (x + 0.5)) <= 1 / 512.0 + 2e-3);
            REQUIRE(std::abs(texel.y - (y + 0.5)) <= 1 / 512.0 + 2e-3);
            REQUIRE(p.y == -30);
            REQUIRE(p.w == Approx(dot(view.forward, glm::dvec3(p) - view.eye)).epsilon(1e-6));
            REQUIRE(rsm.normal(x, y) == glm::vec4(0, 1, 0, 1));
        }
}

TEST_CASE("rsm: records are the images, side by side", "[raster][rsm]") {
    const Light light = spot_light(20);
    const View view = light_view(light, low, high);
    const Rsm exact = draw(floor_of(), light, view), half = draw(floor_of(), light, view, {}, Layout::rgba16f);
    REQUIRE(exact.records.size() == 20 * 20 * 16);
    REQUIRE(half.half_records.size() == 20 * 20 * 16);
    CHECK((exact.half_records.empty() && half.records.empty() && half.half && !exact.half));
    const Image4* e[3] = {&exact.position, &exact.normal, &exact.flux};
    const Image4* h[3] = {&half.position, &half.normal, &half.flux};
    for (int i = 0; i < 400; ++i) {
        const Record<float> r = number<float>::fetch_record(exact.records.data(), i);
        const Record<float> q = number<float>::fetch_record(half.half_records.data(), i);
        const vec4<float> parts[3] = {r.a, r.b, r.c}, halves[3] = {q.a, q.b, q.c};
        for (int part = 0; part < 3; ++part)
            for (int c = 0; c < 4; ++c) {
                const float value = e[part]->texels[std::size_t(i)][c];
                REQUIRE(parts[part][c] == value);
                REQUIRE(halves[part][c] == half_to_float(float_to_half(value)));
                REQUIRE(h[part]->texels[std::size_t(i)][c] == halves[part][c]);
            }
    }
}

TEST_CASE("light view: every vertex of the bounds is inside a directional light's map", "[raster][light]") {
    Random random(9);
    for (int i = 0; i < 200; ++i) {
        Light light;
        light.type = LightType::directional;
        light.direction = {random.between(-1, 1), random.between(-1, 1), i % 5 ? random.between(-1, 1) : 0};
        if (i % 7 == 0) light.direction = {0, i % 2 ? 1 : -1, 0};
        const glm::vec3 low{random.between(-1e4, 0), random.between(-10, 0), random.between(-3, 0)};
        const glm::vec3 high = low + glm::vec3{random.between(0, 100), random.between(0, 1e4), random.between(0, 1)};
        const View view = light_view(light, low, high);
        for (int k = 0; k < 8; ++k) {
            const glm::dvec3 x(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
            const glm::dvec2 texel = project_to_texels(view, 64, x);
            const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(x, 1);
            REQUIRE((texel.x > 0 && texel.x < 64 && texel.y > 0 && texel.y < 64));
            REQUIRE((clip.z > 0 && clip.z < clip.w));
            REQUIRE(dot(view.forward, x - view.eye) > 0);
        }
    }
}

TEST_CASE("light view: a spot's outer cone touches the map's border, and its depths are inside", "[raster][light]") {
    const Light light = spot_light(100);
    const View view = light_view(light, low, high);
    const CameraAxes a = axes(view.forward, {0, 1, 0});
    const glm::dvec3 rim = view.eye + 10.0 * (a.forward + a.right * std::tan(42 * host::pi / 180));
    const glm::dvec2 on_border = project_to_texels(view, 100, rim);
    const glm::dvec2 middle = project_to_texels(view, 100, view.eye + a.forward);
    CHECK(on_border.x == Approx(100).epsilon(1e-6));
    CHECK(on_border.y == Approx(50).epsilon(1e-6));
    CHECK(middle.x == Approx(50).epsilon(1e-12));
    // Texel rows count downwards: a point above the axis lies in the upper half.
    CHECK(project_to_texels(view, 100, view.eye + a.forward + 0.1 * a.up).y < 50);
    for (double depth : {1e-2, 1.0, 35.0}) {
        const glm::dvec4 clip = view.world_to_clip() * glm::dvec4(view.eye + a.forward * depth, 1);
        CAPTURE(depth);
        CHECK((clip.z > 0 && clip.z < clip.w));
    }
}

TEST_CASE("light view: what no map can show is refused by name", "[raster][light]") {
    Light light = spot_light(16);
    light.type = LightType::point;
    CHECK_THROWS_WITH(light_view(light, {0, 0, 0}, {1, 1, 1}), Catch::Contains("lamp"));
    light = spot_light(16);
    light.cone_outer_deg = 90;
    CHECK_THROWS_WITH(light_view(light, {0, 0, 0}, {1, 1, 1}), Catch::Contains("cone_outer_deg"));
    light = spot_light(16);
    light.direction = {0, 0, 0};
    CHECK_THROWS_WITH(light_view(light, {0, 0, 0}, {1, 1, 1}), Catch::Contains("direction"));
    light = spot_light(0);
    CHECK_THROWS_WITH(draw(floor_of(), light, View{}), Catch::Contains("rsm_size"));
}

TEST_CASE("light: falloff is 1 in the inner cone, 0 outside the outer one, 1/2 in the middle", "[raster][light]") {
    Light light = spot_light(16);
    LightArgs a = light_args(light);
    const float inner = float(std::cos(30 * host::pi / 180)), outer = float(std::cos(42 * host::pi / 180));
    CHECK(spot_falloff(a, 1.0f) == 1.0f);
    CHECK(spot_falloff(a, inner + 1e-6f) == 1.0f);
    CHECK(spot_falloff(a, outer) == 0.0f);
    CHECK(spot_falloff(a, -1.0f) == 0.0f);
    CHECK(spot_falloff(a, (inner + outer) / 2) == Approx(0.5f).epsilon(1e-5));
    // A quarter of the way: t^2 (3 - 2 t) = 5/32.
    CHECK(spot_falloff(a, outer + (inner - outer) / 4) == Approx(5 / 32.0).epsilon(1e-5));
    light.cone_inner_deg = light.cone_outer_deg;
    a = light_args(light);
    CHECK(spot_falloff(a, outer + 1e-6f) == 1.0f);
    CHECK(spot_falloff(a, outer - 1e-6f) == 0.0f);
    light.type = LightType::point;
    a = light_args(light);
    for (float cosine : {-1.0f, 0.0f, 1.0f}) CHECK(light_intensity(a, cosine, 4.0f) == glm::vec3(10, 20, 5));
}

TEST_CASE("rsm: the same bits for every instruction set and 1, 2, 3 threads", "[raster][rsm][bits]") {
    Geometry g = floor_of(0.2f);
    Random random(4);
    for (int i = 0; i < 400; ++i) {
        auto corner = [&] { return at({random.between(-15, 15), random.between(-20, 2), random.between(-15, 15)}); };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(g, a, b, c);
    }
    for (LightType type : {LightType::spot, LightType::directional}) {
        Light light = spot_light(101);
        light.type = type;
        const View view = light_view(light, {-15, -40, -15}, {15, 2, 15});
        RunOptions options;
        options.isa = Isa::scalar, options.threads = 1;
        const Rsm truth = draw(g, light, view, options);
        for (Isa isa : supported_isas())
            for (int threads : {1, 2, 3}) {
                options.isa = isa, options.threads = threads;
                const Rsm out = draw(g, light, view, options);
                CAPTURE(isa_name(isa), threads);
                REQUIRE(std::memcmp(out.records.data(), truth.records.data(), 4 * truth.records.size()) == 0);
                const Rsm half = draw(g, light, view, options, Layout::rgba16f);
                for (std::size_t k = 0; k < half.half_records.size(); ++k)
                    REQUIRE(half.half_records[k].bits == float_to_half(truth.records[k]).bits);
            }
    }
}

TEST_CASE("rsm: memory that held another map changes nothing", "[raster][rsm][bits]") {
    const Geometry g = floor_of();
    const Surfaces surfaces = prepare(plain_scene(), g);
    Workspace workspace;
    Rsm out;
    for (const Layout& layout : {Layout::fp32, Layout::rgba16f, Layout::fp32})
        for (int size : {40, 40, 17, 40}) {
            Light light = spot_light(size);
            // Every other map sees sky beside the floor.
            light.direction = size == 40 && out.size == 40 ? glm::vec3(1, -0.2f, 0) : glm::vec3(0.3f, -1, 0.2f);
            const View view = light_view(light, low, high);
            draw_rsm(g, surfaces, light, view, layout, {}, out, &workspace);
            const Rsm fresh = draw(g, light, view, {}, layout);
            CAPTURE(size, layout.name);
            CHECK(out.half == fresh.half);
            CHECK(out.texel_scale == fresh.texel_scale);
            for (auto image : {&Rsm::position, &Rsm::normal, &Rsm::flux}) {
                REQUIRE((out.*image).size() == (fresh.*image).size());
                CHECK(std::memcmp((out.*image).data(), (fresh.*image).data(), 16 * (fresh.*image).size()) == 0);
            }
            REQUIRE(out.records.size() == fresh.records.size());
            REQUIRE(out.half_records.size() == fresh.half_records.size());
            auto bytes = [](const auto& records) { return content_hash(records.data(), records.size() * sizeof records[0]); };
            CHECK(bytes(out.records) == bytes(fresh.records));
            CHECK(bytes(out.half_records) == bytes(fresh.half_records));
        }
}

TEST_CASE("rsm: positions and depths that halves cannot hold are refused", "[raster][rsm][errors]") {
    Geometry far_away;
    add_triangle(far_away, at({-81000, 0, -81000}), at({81000, 0, -81000}), at({0, 0, 81000}));
    const glm::vec3 from(-81000, 0, -81000), to(81000, 0, 81000);
    Light sun = spot_light(16);
    sun.type = LightType::directional;
    const View view = light_view(sun, from, to);
    CHECK_NOTHROW(draw(far_away, sun, view));
    CHECK_THROWS_WITH(draw(far_away, sun, view, {}, Layout::rgba16f),
                      "rsm: light \"lamp\": positions up to 81 km do not fit rgba16f (65.504 km), which layout "
                      "\"rgba16f\" stores them in: use fp32");
    // Depth reaches from one end of the bounding sphere to the other.
    Layout depths;
    depths.name = "custom";
    depths.rsm_depth = Format::r16f;
    CHECK_THROWS_WITH(draw(far_away, sun, view, {}, depths), Catch::Contains("km do not fit r16f (65.504 km)"));
    Light spot = spot_light(16);
    spot.direction = {1, -0.2f, 0};
    CHECK_THROWS_WITH(draw(far_away, spot, light_view(spot, from, to), {}, Layout::lra),
                      Catch::Contains("positions up to 81 km"));
    // Where the light's map ends well before, everything fits.
    CHECK_NOTHROW(draw(far_away, spot_light(16), light_view(spot_light(16), {-9, -9, -9}, {9, 9, 9}), {}, Layout::lra));
}

TEST_CASE("rsm: flux in rgbe, which no kernel rounds, is rounded all the same", "[raster][rsm][layout]") {
    const Light light = spot_light(24);
    const View view = light_view(light, low, high);
    Layout layout;
    layout.name = "custom";
    layout.rsm_flux = Format::rgbe;
    const Rsm plain = draw(floor_of(), light, view), rounded = draw(floor_of(), light, view, {}, layout);
    int moved = 0;
    for (std::size_t i = 0; i < plain.flux.size(); ++i) {
        glm::vec4 expected = plain.flux.texels[i];
        quantise(Format::rgbe, expected);
        REQUIRE(rounded.flux.texels[i] == expected);
        for (int c = 0; c < 3; ++c) REQUIRE(rounded.records[i * record_stride + 8 + std::size_t(c)] == expected[c]);
        moved += expected != plain.flux.texels[i];
    }
    CHECK(moved > 100);
}

// rgba16f and VRSM fig. 4.2 keep depth in the fourth half of the position; LRA 6.2.1 keeps it in 32 bits.
TEST_CASE("rsm: linear depth has the layout's format, whatever the position's", "[raster][rsm][layout]") {
    const Light light = spot_light(24);
    const View view = light_view(light, low, high);
    Layout half_depth, half_position;
    half_depth.name = half_position.name = "custom";
    half_depth.rsm_depth = Format::r16f, half_position.rsm_position = Format::rgba16f;
    const struct {
        Layout layout;
        bool half;
    } rows[] = {{half_depth, true}, {half_position, false}, {Layout::rgba16f, true}, {Layout::vrsm, true},
                {Layout::lra, false}};
    const Rsm plain = draw(floor_of(0.1f), light, view);
    for (const auto& [layout, half] : rows)
        for (Isa isa : supported_isas()) {
            RunOptions options;
            options.isa = isa;
            const Rsm stored = draw(floor_of(0.1f), light, view, options, layout);
            CAPTURE(layout.name, half, isa_name(isa));
            int moved = 0;
            for (std::size_t i = 0; i < plain.position.size(); ++i) {
                glm::vec4 position = plain.position.texels[i], depth(position.w, 0, 0, 1);
                quantise(layout.rsm_position, position);
                if (half) quantise(Format::r16f, depth);
                position.w = depth.x;
                REQUIRE(stored.position.texels[i] == position);
                moved += position.w != plain.position.texels[i].w;
            }
            CHECK(moved > (half ? 500 : -1));
        }
}

TEST_CASE("rsm: explain multiplies up to the flux of the map", "[raster][rsm][explain]") {
    const Light light = spot_light(32);
    const View view = light_view(light, low, high);
    const Geometry g = floor_of();
    const Rsm rsm = draw(g, light, view);
    const auto taps = explain_rsm(g, prepare(plain_scene(), g), light, view, {9, 13});
    std::vector<double> dw, intensity, albedo, flux;
    for (const TapValue& t : taps) {
        CAPTURE(t.name);
        CHECK(!t.equation.empty());
        if (t.name == "dw") dw = t.value;
        if (t.name == "intensity") intensity = t.value;
        if (t.name == "albedo") albedo = t.value;
        if (t.name == "flux") flux = t.value;
    }
    REQUIRE((dw.size() == 1 && intensity.size() == 3 && albedo.size() == 3 && flux.size() == 3));
    for (int c = 0; c < 3; ++c) {
        CHECK(flux[std::size_t(c)] == rsm.flux(9, 13)[c]);
        CHECK(flux[std::size_t(c)] == float(albedo[c]) * (float(intensity[c]) * float(dw[0])));
    }
}
