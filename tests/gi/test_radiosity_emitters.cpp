// Light before it is reflected: small emitters by outlines and rays, and maps of the sky by texels, against closed forms.
#include <catch2/catch.hpp>
#include <cmath>

#include "gi/radiosity/emitters.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/lamp_light.h"
#include "gi/radiosity/own_light.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;
using namespace plumb::test;

namespace {

constexpr double emitted = 7;

// A floor [0, 4]^2 that looks up, and over its corner at the origin an a x b emitter that looks down from height c.
Scene floor_and_lamp(double a, double b, double c, int n) {
    Scene s;
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 4}, {4, 0, 0}, 8, 8, add_material(s, 0.5)));
    s.meshes.push_back(grid({0, c, 0}, {a, 0, 0}, {0, 0, b}, n, n, add_material(s, 0.5, emitted)));
    return s;
}

// From a point to a parallel rectangle, a corner of which is right above it (Howell B-4).
double corner_factor(double a, double b, double c) {
    const double x = a / c, y = b / c, p = std::sqrt(1 + x * x), q = std::sqrt(1 + y * y);
    return (x / p * std::atan(y / p) + y / q * std::atan(x / q)) / (2 * M_PI);
}
// Of a floor's point anywhere: four rectangles with a corner above it.
double factor(double x, double z, double a, double b, double c) {
    const auto signed_corner = [&](double u, double v) { return (u < 0 ? -1 : 1) * (v < 0 ? -1 : 1) * corner_factor(std::fabs(u), std::fabs(v), c); };
    return signed_corner(a - x, b - z) - signed_corner(-x, b - z) - signed_corner(a - x, -z) + signed_corner(-x, -z);
}

Elements elements_with(const Scene& s, double share) {
    ElementParams p;
    p.small_emitters = share;
    return elements_of(s, p);
}

}  // namespace

TEST_CASE("emitters: irradiance below a rectangle is its closed form, where texels miss it by per cent", "[radiosity][analytic]") {
    for (const int n : {1, 3}) {
        const Scene s = floor_and_lamp(0.4, 0.3, 1.5, n);
        const Elements e = elements_with(s, 0.02), by_texels = elements_with(s, 0);
        REQUIRE(e.lamp_exitance.size() == e.position.size());
        const Buffer<glm::vec4> sent = emitters_at(s, e, {});
        Buffer<glm::vec4> gathered;
        const FormFactors rows = form_factors(by_texels, {}, {});
        gather(rows, Buffer<glm::vec4>(e.position.size(), glm::vec4(0)), by_texels.exitance, {}, gathered);
        double worst = 0, worst_of_texels = 0;
        for (std::size_t i = 0; i < e.position.size(); ++i) {
            if (e.normal[i].y < 0.9f) continue;
            const glm::dvec3 eye(e.eye[i]);
            const double truth = emitted * factor(eye.x, eye.z, 0.4, 0.3, 1.5 - eye.y);
            worst = std::max(worst, std::fabs(double(sent[i].x) / truth - 1));
            worst_of_texels = std::max(worst_of_texels, std::fabs(double(gathered[i].x) / truth - 1));
            CHECK((sent[i].x == sent[i].y && sent[i].x == sent[i].z));
        }
        CAPTURE(n, worst, worst_of_texels);
        CHECK(worst < 1e-5);
        CHECK(worst_of_texels > 0.02);
    }
}

TEST_CASE("emitters: behind a plate there is what rays find of them", "[radiosity][analytic]") {
    // A plate right below half of the lamp: from far below, half of it is hidden.
    Scene s = floor_and_lamp(0.2, 0.2, 3, 2);
    s.meshes.push_back(grid({-1, 2.999, -1}, {0, 0, 3}, {1.1, 0, 0}, 1, 1, 0));
    const Elements e = elements_with(s, 0.02);
    const Buffer<glm::vec4> sent = emitters_at(s, e, {});
    for (std::size_t i = 0; i < e.position.size(); ++i) {
        const glm::dvec3 eye(e.eye[i]);
        if (e.normal[i].y < 0.9f || eye.y > 1 || std::fabs(eye.x - 0.1) > 1 || eye.z > 1) continue;
        CHECK(double(sent[i].x) == Approx(emitted * factor(eye.x, eye.z, 0.2, 0.2, 3 - eye.y) / 2).epsilon(0.1));
    }
    // All of it hidden, and from behind.
    s.meshes.back() = grid({-1, 2.9, -1}, {0, 0, 9}, {9, 0, 0}, 1, 1, 0);
    const Elements dark = elements_with(s, 0.02);
    const Buffer<glm::vec4> nothing = emitters_at(s, dark, {});
    for (std::size_t i = 0; i < nothing.size(); ++i)
        if (dark.eye[i].y < 1) CHECK(nothing[i].x == 0);
}

TEST_CASE("emitters: of one triangle, a board's edge hides the part that similar triangles say", "[radiosity][analytic]") {
    // A right triangle of legs 0.2 in a height of 3, and a board in 1.5 up to x = 0.6: of the lamp a point sees what is beyond
    // x = 2 0.6 - eye's x, or nearly so. The part of it that is seen is similar to the whole: its square.
    constexpr double leg = 0.2, lamp = 3, board = 1.5, edge = 0.6;
    for (const bool at_corner : {false, true}) {  // which end of the leg has the corner
        Scene s = floor_and_lamp(leg, leg, lamp, 1);
        Mesh& m = s.meshes[1];
        m.triangles.pop_back(), m.material.pop_back();
        const glm::vec3 flat(0, float(lamp), 0), along(float(leg), 0, 0), aside(0, 0, float(leg));
        const glm::vec3 corners[2][3] = {{flat, flat + along, flat + aside}, {flat + along, flat + along + aside, flat}};
        for (int k = 0; k < 3; ++k) m.vertices[m.triangles[0][k]].position = corners[at_corner][k];
        s.meshes[0] = grid({0, 0, 0}, {0, 0, 1}, {2, 0, 0}, 2, 80, 0);
        const Scene free = s;
        s.meshes.push_back(grid({-9, board, -9}, {0, 0, 18}, {9 + edge, 0, 0}, 1, 1, 0));
        const Elements e = elements_with(s, 0.02), open = elements_with(free, 0.02);
        const Buffer<glm::vec4> sent = emitters_at(s, e, {}), all = emitters_at(free, open, {});
        int partly = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (open.normal[i].y < 0.9f) continue;
            const glm::dvec3 eye(e.eye[i]);
            REQUIRE(e.position[i] == open.position[i]);
            const double shadow = (eye.x + (edge - eye.x) * (lamp - eye.y) / (board - eye.y)) / leg, x = std::min(std::max(shadow, 0.0), 1.0);
            const double truth = at_corner ? 1 - x * x : (1 - x) * (1 - x), seen = double(sent[i].x) / double(all[i].x);
            CAPTURE(at_corner, eye.x, truth);
            CHECK(seen == Approx(truth).margin(0.08));
            partly += truth > 0.25 && truth < 0.75;
        }
        CHECK(partly > 5);
    }
}

TEST_CASE("emitters: a textured lamp sends what it has in the mean, wherever on it that is", "[radiosity][analytic]") {
    // A quarter of it is lit: along its left, its right, and either other side; from far it is a lamp of a quarter of the exitance.
    for (int side = 0; side < 4; ++side) {
        Scene s = floor_and_lamp(0.04, 0.04, 3, 1);
        Texture stripe;
        stripe.texels = side < 2 ? Image<std::uint32_t>(8, 1, 0xff000000u) : Image<std::uint32_t>(1, 8, 0xff000000u);
        for (int k = 0; k < 2; ++k) stripe.texels.texels[std::size_t(side % 2 ? 7 - k : k)] = 0xffffffffu;
        stripe.filter = Filter::nearest;
        s.textures.push_back(stripe);
        s.materials[1].emission_texture = 0;
        const Elements e = elements_with(s, 0.02);
        const Buffer<glm::vec4> sent = emitters_at(s, e, {});
        int below = 0;
        for (std::size_t i = 0; i < sent.size(); ++i) {
            const glm::dvec3 eye(e.eye[i]);
            if (e.normal[i].y < 0.9f) continue;
            CAPTURE(side, eye.x, eye.z);
            CHECK(double(sent[i].x) == Approx(emitted / 4 * factor(eye.x, eye.z, 0.04, 0.04, 3 - eye.y)).epsilon(0.02));
            ++below;
        }
        CHECK(below == 81);
    }
}

TEST_CASE("emitters: they are lamps up to a share of the area, and what they send is not seen twice", "[radiosity]") {
    const Scene s = floor_and_lamp(0.4, 0.3, 1.5, 1);  // 0.12 of 16.12 m2
    const double share = 0.12 / 16.12;
    for (const double allowed : {0.0, 0.9 * share, 1.1 * share, 1.0}) {
        const Elements e = elements_with(s, allowed);
        const bool lamps = allowed > share;
        CHECK(e.lamp_exitance.empty() == !lamps);
        double seen = 0, sent = 0;
        for (std::size_t i = 0; i < e.area.size(); ++i) {
            seen += e.area[i] * double(e.exitance[i].x);
            if (lamps) sent += e.area[i] * double(e.lamp_exitance[i].x);
        }
        CHECK((lamps ? sent : seen) == Approx(0.12 * emitted).epsilon(1e-6));
        CHECK((lamps ? seen : sent) == 0);
    }
    Scene dark = s;
    dark.materials[1].emission = glm::vec3(0);
    const Elements e = elements_with(dark, 1);
    CHECK(e.lamp_exitance.empty());
    for (const glm::vec4& h : emitters_at(dark, e, {})) CHECK(h == glm::vec4(0));
}

TEST_CASE("emitters: the same bits for every number of threads", "[radiosity][bits]") {
    Scene s = floor_and_lamp(0.4, 0.3, 1.5, 3);
    s.meshes.push_back(grid({-1, 1, -1}, {0, 0, 3}, {1.2, 0, 0}, 1, 1, 0));
    const Elements e = elements_with(s, 0.02);
    RunOptions one, more;
    one.threads = 1, more.threads = 3;
    const Buffer<glm::vec4> a = emitters_at(s, e, one), b = emitters_at(s, e, more);
    for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == b[i]);
}

TEST_CASE("sky: a map's upper half is pi L of a floor, half of it of a wall, and what hides it takes its share", "[radiosity][sky][analytic]") {
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));        // looks up
    s.meshes.push_back(grid({9, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, 1, white));        // along x
    s.meshes.push_back(grid({20, 5, 0}, {1, 0, 0}, {0, 0, 1}, 1, 1, white));       // down
    s.environment.radiance = {2, 1, 0};
    s.environment.map = Image4(8, 4, glm::vec4(0));
    for (int x = 0; x < 8; ++x) s.environment.map(x, 0) = s.environment.map(x, 1) = glm::vec4(1, 3, 1, 0);
    RadiosityParams params;
    const Elements e = elements_of(s, {});
    const FormFactors rows = form_factors(e, row_params(params), {});
    const Buffer<glm::vec4> own = own_light(s, e, rows, params, {});
    REQUIRE(own.size() == 12);
    for (std::size_t i = 0; i < own.size(); ++i) {
        const double share = e.normal[i].y > 0.9f ? 1 : e.normal[i].x > 0.9f ? 0.5 : 0;
        CAPTURE(i, share);
        CHECK(double(own[i].x) == Approx(2 * M_PI * share).margin(0.02));  // what little the meshes hide of each other
        CHECK(double(own[i].y) == Approx(3 * M_PI * share).margin(0.03));
        CHECK(own[i].z == 0);
    }
    // Everywhere alike, it is the sky of that colour.
    for (glm::vec4& texel : s.environment.map.texels) texel = glm::vec4(1);
    const Buffer<glm::vec4> even = own_light(s, e, rows, params, {});
    s.environment.map = {};
    const Buffer<glm::vec4> constant = own_light(s, e, rows, params, {});
    for (std::size_t i = 0; i < own.size(); ++i)
        for (int c = 0; c < 3; ++c) CHECK(even[i][c] == Approx(constant[i][c]).epsilon(1e-6));
    // The same bits for any number of threads.
    s.environment.map = Image4(8, 4, glm::vec4(0.3f));
    s.environment.map(3, 1) = glm::vec4(50);
    RunOptions one, more;
    one.threads = 1, more.threads = 3;
    CHECK(own_light(s, e, rows, params, one) == own_light(s, e, rows, params, more));
}

TEST_CASE("sky: at a wall's foot a map's octants come from where they are, and none from behind the wall", "[radiosity][sky][analytic]") {
    // A map of eight octants: the integral of directions over one is pi / 4 along each of its axes. A floor at the foot of a wall,
    // which fills half of what it sees, gets pi L / 4 of an octant before both and nothing of others, whichever axes they look
    // along. No texel's middle lies on a border between octants.
    constexpr double radiance = 3;
    RadiosityParams params;
    params.size = 32;
    for (int way = 0; way < 24; ++way) {
        const int axis = way / 8, other = (axis + 1 + way % 2) % 3, third = 3 - axis - other;
        Point3 up(0), out(0), along(0);
        up[axis] = way & 2 ? 1 : -1, out[other] = way & 4 ? 1 : -1, along[third] = 1;  // of the floor, of the wall, of the edge between
        if (glm::dot(glm::cross(along, out), up) < 0) along = -along;
        Scene s;
        const int white = add_material(s, 0.5);
        s.meshes.push_back(grid(-0.5 * along, along, out, 1, 1, white));
        s.meshes.push_back(grid(-50.0 * along, 50.0 * up, 100.0 * along, 1, 1, white));
        s.environment.radiance = glm::vec3(float(radiance));
        const Elements e = elements_of(s, {});
        REQUIRE(e.count() == 8);
        const FormFactors rows = form_factors(e, row_params(params), {});
        int looked = 0;
        for (int first = 0; first < 8; first += 3) {  // three of them at once, a channel each
            s.environment.map = Image4(4, 2, glm::vec4(0));
            for (int c = 0; c < 3 && first + c < 8; ++c) s.environment.map.texels[std::size_t(first + c)][c] = 1;
            const Buffer<glm::vec4> own = own_light(s, e, rows, params, {});
            for (std::size_t i = 0; i < 4; ++i) {
                REQUIRE(glm::dot(Point3(e.normal[i]), up) == 1);
                if (glm::dot(Point3(e.position[i]), out) > 0) continue;
                for (int c = 0; c < 3 && first + c < 8; ++c, ++looked) {
                    // u = 1/2 + atan2(x, -z) / (2 pi): longitudes from -180 degrees on, 90 a column.
                    const int column = (first + c) % 4;
                    const Point3 octant(column < 2 ? -1 : 1, first + c < 4 ? 1 : -1, column % 3 == 0 ? 1 : -1);
                    const bool seen = glm::dot(octant, up) > 0 && glm::dot(octant, out) > 0;
                    CAPTURE(way, i, octant.x, octant.y, octant.z);
                    CHECK(double(own[i][c]) == Approx(seen ? radiance * M_PI / 4 : 0).epsilon(1e-5).margin(0));
                }
            }
        }
        CHECK(looked == 16);
    }
}

TEST_CASE("lamps: the power that elements get of a spot is what it sends, on a mesh coarser than its cone", "[radiosity][analytic]") {
    // A cone of 20 degrees from 3 m: a disc of 1.09 m, on triangles of 0.5 m.
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}, 8, 8, white));
    Light spot;
    spot.name = "spot", spot.position = {0.13f, 3, 0.07f}, spot.direction = {0, -1, 0}, spot.intensity = {5, 1, 0};
    spot.cone_inner_deg = 19.99f, spot.cone_outer_deg = 20;
    s.lights.push_back(spot);
    const double sent = 2 * M_PI * (1 - std::cos(20 * M_PI / 180));  // W for 1 W/sr
    for (const Kind kind : {Kind::vertices, Kind::triangles}) {
        ElementParams p;
        p.kind = kind;
        const Elements e = elements_of(s, p);
        const Buffer<glm::vec4> light = lamps_on(s, e, {});
        double power[3] = {};
        for (std::size_t i = 0; i < light.size(); ++i)
            for (int c = 0; c < 3; ++c) power[c] += e.area[i] * double(light[i][c]);
        CAPTURE(int(kind), power[0] / (5 * sent));
        CHECK(power[0] == Approx(5 * sent).epsilon(0.02));
        CHECK(power[1] == Approx(sent).epsilon(0.02));
        CHECK(power[2] == 0);
    }
    // An even light is the same everywhere.
    s.lights[0].type = LightType::directional;
    const Elements e = elements_of(s, {});
    for (const glm::vec4& h : lamps_on(s, e, {})) CHECK(h.x == Approx(5).epsilon(1e-5));
}

TEST_CASE("lamps: light on part of a triangle goes to its corners by their interpolants", "[radiosity][analytic]") {
    // A right triangle of legs 1 under a light straight from above, and a board over x < s. Of the light that is left the corner at
    // x = 1 has the integral of 6 x (1 - x) from s on, each of the others that of 3 (1 - x)^2: over all s 1/2 and 1/4. In the mean
    // over which corner comes first, as sixteen places alone are 1/10 off.
    Scene s;
    const int white = add_material(s, 0.5);
    s.meshes.push_back(grid({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1, 1, white));  // corners 0, 2 and 1 at (0, 0), (1, 0) and (0, 1)
    s.meshes[0].material = {white};
    Light sun;
    sun.name = "sun", sun.type = LightType::directional, sun.direction = {0, -1, 0}, sun.intensity = {4, 4, 4};
    s.lights.push_back(sun);
    s.meshes.push_back({});
    constexpr int edges = 20;
    double far_over_all = 0, near_over_all = 0;
    for (int k = 0; k < edges; ++k) {
        const double edge = (k + 0.5) / edges, rest = 1 - edge;
        s.meshes[1] = grid({-1, 1, -1}, {0, 0, 3}, {1 + edge, 0, 0}, 1, 1, white);
        double far = 0, near = 0;
        for (const glm::uvec3& corners : {glm::uvec3(0, 1, 2), glm::uvec3(1, 2, 0), glm::uvec3(2, 0, 1)}) {
            s.meshes[0].triangles = {corners};
            const Elements e = elements_of(s, {});
            REQUIRE(e.count() == 7);
            const Buffer<glm::vec4> light = lamps_on(s, e, {});
            for (std::size_t i = 0; i < 3; ++i) (e.position[i].x == 1 ? far : near) += double(light[i].x) / (e.position[i].x == 1 ? 12 : 24);
        }
        CAPTURE(edge);
        CHECK(far == Approx(1 - edge * edge * (3 - 2 * edge)).margin(0.08));
        CHECK(near == Approx(rest * rest * rest).margin(0.08));
        far_over_all += far / edges, near_over_all += near / edges;
    }
    CHECK(far_over_all == Approx(0.5).margin(0.01));
    CHECK(near_over_all == Approx(0.25).margin(0.01));
}
