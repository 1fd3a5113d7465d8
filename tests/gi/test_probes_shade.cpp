// probes.indirect_shadow in closed form: what spheres hide of a hemisphere, and of radiance that is known. The spheres of a mesh, and rays.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/shadow_rays.h"
#include "random_scene.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

// Points in a row, at the origin, under a normal along z, with E = 1.
struct Row {
    Image4 position, normal, irradiance;
    Image<glm::ivec2> id;
    ShadowSpheres spheres;
    explicit Row(int n)
        : position(n, 1, glm::vec4(0)), normal(n, 1, glm::vec4(0, 0, 1, 1)), irradiance(n, 1, glm::vec4(1, 1, 1, 0)), id(n, 1, glm::ivec2(0)) {}
    Row& sphere(const glm::vec4& s, const glm::vec4& light = glm::vec4(0), const glm::vec4& sends = glm::vec4(0)) {
        spheres.rows.push_back(s);
        spheres.rows.insert(spheres.rows.end(), 3, light);
        spheres.rows.insert(spheres.rows.end(), 3, sends);
        spheres.owner.push_back({1, 1});
        return *this;
    }
    IndirectShadowInputs inputs(bool directional = false) const {
        IndirectShadowInputs in;
        in.position = &position, in.normal = &normal, in.irradiance = &irradiance, in.id = &id, in.spheres = &spheres, in.directional = directional;
        return in;
    }
};
Image4 shaded(const IndirectShadowInputs& in, const RunOptions& options = {}) {
    Image4 out(in.position->width, in.position->height);
    plumb::run(stage<IndirectShadowKernel>(), data_of(in), options, out);
    return out;
}
// F of one sphere, seen from the origin under a normal along z.
double share_of(const glm::vec4& sphere) { return 1 - double(shaded(Row(1).sphere(sphere).inputs())(0, 0).x); }

// The same by quadrature: cosine-weighted cells of the hemisphere, r^2 and azimuth, that a ray hits the sphere from.
double quadrature(const glm::dvec3& c, double radius, int side) {
    double hits = 0;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            const double u = (j + 0.5) / side, angle = 2 * host::pi * (i + 0.5) / side, across = std::sqrt(u);
            const glm::dvec3 w(across * host::cos(angle), across * host::sin(angle), std::sqrt(1 - u));
            const double along = w.x * c.x + w.y * c.y + w.z * c.z, d2 = c.x * c.x + c.y * c.y + c.z * c.z;
            hits += along > 0 && d2 - along * along < radius * radius;
        }
    return hits / side / side;
}

}  // namespace

TEST_CASE("probes.indirect_shadow: a sphere above the horizon hides (r/d)^2 cos", "[probes][shade][analytic]") {
    // Lambert: a disc of solid angle pi sin^2 sigma about omega, its projection (r/d)^2 cos omega pi.
    for (const double d : {1.5, 4.0, 300.0})
        for (const double omega : {0.0, 0.4, 0.7}) {
            const double q = 1 / (d * d);
            if (omega + 0.01 > host::pi / 2 - host::asin(1 / d)) continue;
            CAPTURE(d, omega);
            CHECK(share_of(glm::vec4(d * host::sin(omega), 0, d * host::cos(omega), 1)) == Approx(q * host::cos(omega)).epsilon(2e-6).margin(7e-8));
        }
    // Far away: r^2 / d^2. 1e-5 of the light: 1 - F has 6e-8.
    Row far(1);
    far.irradiance(0, 0) = glm::vec4(1e6f), far.sphere({0, 0, 1e3f, 1});
    CHECK(1e6 - double(shaded(far.inputs())(0, 0).x) == Approx(1).epsilon(0.07));
}

TEST_CASE("probes.indirect_shadow: the horizon cuts spheres exactly", "[probes][shade][analytic]") {
    // The centre lies in the horizon: (sigma - sin sigma cos sigma) / pi, the segment between a great circle and a cone.
    for (const double ratio : {0.05, 0.3, 0.7, 0.99}) {
        const double sigma = host::asin(ratio);
        CHECK(share_of({1, 0, 0, float(ratio)}) == Approx((sigma - host::sin(sigma) * host::cos(sigma)) / host::pi).epsilon(2e-5).margin(2e-7));
    }
    // Whatever the place, what a quadrature of 400 x 400 cells counts: off by less than a cell along the edge.
    for (int k = 0; k < 60; ++k) {
        const double height = -1 + 2.2 * (k % 10) / 10, across = 0.3 + 0.5 * (k / 10), radius = 0.2 + 0.15 * (k % 7);
        if (height * height + across * across < radius * radius) continue;
        CAPTURE(height, across, radius);
        CHECK(share_of(glm::vec4(0.6 * across, 0.8 * across, height, radius)) == Approx(quadrature({0.6 * across, 0.8 * across, height}, radius, 400)).margin(2e-3));
    }
    // Continuous where the cut begins and ends: radius 1, centre at 1 +- 1e-4 above and below.
    for (const double side : {1.0, -1.0}) {
        const double inner = share_of(glm::vec4(1, 0, side * 0.9999, 1)), outer = share_of(glm::vec4(1, 0, side * 1.0001, 1));
        CHECK(inner == Approx(outer).margin(1e-4));
    }
    CHECK(share_of({0.3f, 0, -1.01f, 1}) == 0);
}

TEST_CASE("probes.indirect_shadow: within a sphere the share stays between 0 and 1, and is continuous", "[probes][shade][analytic]") {
    // On its surface (1 + cos) / 2: all of it under the sphere's lowest point, half at its side, nothing on its top.
    CHECK(share_of({0, 0, 1, 1}) == Approx(1).margin(1e-6));
    CHECK(share_of({1, 0, 0, 1}) == Approx(0.5).margin(1e-6));
    CHECK(share_of({0, 0, -1, 1}) == Approx(0).margin(1e-6));
    // Inside: (1 + n . D / r) / 2.
    CHECK(share_of({0, 0, 0, 1}) == Approx(0.5).margin(1e-6));
    for (int k = -9; k <= 9; ++k) {
        const float z = 0.1f * float(k);
        CHECK(share_of({0.1f, 0, z, 1}) == Approx(0.5 + 0.5 * double(z)).margin(2e-6));
        const float edge = std::sqrt(1 - z * z);
        CHECK(share_of({edge * 0.9999f, 0, z * 0.9999f, 1}) == Approx(share_of({edge * 1.0001f, 0, z * 1.0001f, 1})).margin(0.01));
    }
}

TEST_CASE("probes.indirect_shadow: several spheres, and those that a surface belongs to", "[probes][shade][analytic]") {
    Row row(4);
    row.sphere({0, 0, 2, 1}).sphere({0, 0, -2, 1}).sphere({0, 0, 4, 1});  // 1/4, nothing, 1/16
    row.spheres.owner = {{1, 1}, {1, 1}, {2, 5}};
    row.id(1, 0) = {1, 0}, row.id(2, 0) = {4, 0}, row.normal(3, 0) = glm::vec4(0);
    const Image4 e = shaded(row.inputs());
    CHECK(e(0, 0).x == Approx(0.75 * 15 / 16));
    CHECK(e(1, 0).x == Approx(15.0 / 16));
    CHECK(e(2, 0).x == Approx(0.75));
    CHECK(e(3, 0) == row.irradiance(3, 0));  // no point
    // Nothing hidden: the same bits, the fourth component included.
    Row none(3);
    none.irradiance(0, 0) = {0.1f, 1e-30f, 3e30f, 0.7f};
    none.sphere({0, 0, -2, 1}).sphere({0, 0, 5, 0});
    for (const bool directional : {false, true}) CHECK(shaded(none.inputs(directional)).texels == none.irradiance.texels);
}

TEST_CASE("probes.indirect_shadow: light of degree 0 and 1 is hidden as the sphere has it", "[probes][shade][analytic]") {
    // Overhead, of any size: a = 0.2, b along z = 0.1. The cap's cosine-weighted mean of w_z is m = 2 (1 - C^3) / (3 (1 - C^2)).
    for (const double d : {1.0, 1.2, 3.0, 20.0}) {
        const double open = std::sqrt(1 - 1 / (d * d)), m = d == 1 ? 2.0 / 3 : 2 * (1 - open * open * open) / (3 * (1 - open * open));
        const double hidden = host::pi / (d * d) * (0.2 + m * 0.1);
        CAPTURE(d);
        CHECK(double(shaded(Row(1).sphere(glm::vec4(0, 0, d, 1), {0, 0, 0.1f, 0.2f}).inputs(true))(0, 0).x) == Approx(1 - hidden).margin(2e-6));
    }
    // All of the hemisphere: all of its irradiance, pi a + 2 pi / 3 b . n.
    Row all(1);
    all.irradiance(0, 0) = glm::vec4(float(host::pi * (0.2 + 0.2 / 3)));
    CHECK(shaded(all.sphere({0, 0, 1, 1}, {0, 0, 0.1f, 0.2f}).inputs(true))(0, 0).x == Approx(0).margin(2e-6));
    // From everywhere alike, a = E / pi: as `uniform`, for every sphere.
    for (int k = 0; k < 20; ++k) {
        Row row(1);
        row.sphere({0.4f * float(k % 5), 0, 0.3f * float(k / 5) - 0.2f, 0.5f}, {0, 0, 0, float(1 / host::pi)});
        CHECK(shaded(row.inputs(true))(0, 0).x == Approx(double(shaded(row.inputs(false))(0, 0).x)).margin(3e-7));
    }
    // More than there is: 0, never less. Radiance below 0 hides nothing.
    CHECK(shaded(Row(1).sphere({0, 0, 2, 1}, {0, 0, 0, 9}).inputs(true))(0, 0) == glm::vec4(0));
    CHECK(shaded(Row(1).sphere({0, 0, 2, 1}, {0, 0, -1, 0.5f}).inputs(true))(0, 0).x == 1);
    // What the object sends comes back: a white one in light from everywhere is not seen.
    CHECK(shaded(Row(1).sphere({0, 0, 2, 1}, {0, 0, 0, 0.3f}, {0, 0, 0, 0.3f}).inputs(true))(0, 0).x == Approx(1).margin(1e-7));
    CHECK(double(shaded(Row(1).sphere({0, 0, 2, 1}, glm::vec4(0), {0, 0, 0, 0.3f}).inputs(true))(0, 0).x) == Approx(1 + host::pi * 0.3 / 4));
}

TEST_CASE("probes.indirect_shadow: refuses what is not bound or does not fit; the same bits everywhere", "[probes][shade][bits]") {
    Row row(33);
    CHECK_THROWS_AS(shaded(row.inputs()), InputError);  // no sphere
    for (int i = 0; i < 5; ++i) row.sphere({0.5f * float(i) - 1, 0.3f, 0.4f * float(i) - 0.5f, 0.4f}, {0.1f, -0.2f, 0.3f, 0.4f}, {0, 0, 0.1f, 0.1f});
    for (int i = 0; i < 33; ++i) row.position(i, 0) = {0.1f * float(i) - 1.6f, 0.03f * float(i), 0, 0};
    IndirectShadowInputs in = row.inputs(true);
    in.normal = nullptr;
    CHECK_THROWS_AS(shaded(in), InputError);
    in = row.inputs(true), in.id = nullptr;
    CHECK_THROWS_AS(shaded(in), InputError);
    ShadowSpheres short_list = row.spheres;
    short_list.rows.pop_back();
    in = row.inputs(true), in.spheres = &short_list;
    CHECK_THROWS_AS(shaded(in), InputError);
    const Image4 first = shaded(row.inputs(true));
    CHECK(first.texels != row.irradiance.texels);
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            CHECK(shaded(row.inputs(true), options).texels == first.texels);
        }
}

// ---- Spheres of meshes -----------------------------------------------------------------------------------------------

namespace {

Mesh box_mesh(const glm::vec3& low, const glm::vec3& high) {
    Mesh mesh;
    test::add_box(mesh, low, high, 0);
    mesh.material.resize(mesh.triangles.size(), 0);
    return mesh;
}
double discs(const Buffer<glm::vec4>& spheres) {
    double sum = 0;
    for (const glm::vec4& s : spheres) sum += host::pi * double(s.w) * double(s.w);
    return sum;
}

}  // namespace

TEST_CASE("shadow spheres: their discs are the mesh's mean projected area, a quarter of a convex mesh's surface", "[probes][shade][spheres][analytic]") {
    // Cauchy: 2 (ab + bc + ca) / 4. 32 directions and grids of 64 x 64 lines leave 2 %.
    for (const glm::vec3& size : {glm::vec3(1), glm::vec3(1, 2, 3), glm::vec3(0.1f, 4, 0.1f)}) {
        const Mesh mesh = box_mesh(glm::vec3(5, -3, 1), glm::vec3(5, -3, 1) + size);
        const double area = double(size.x * size.y + size.y * size.z + size.z * size.x) / 2;
        CHECK(projected_area({&mesh, 1}) == Approx(area).epsilon(0.02));
        for (const int count : {1, 4, 16}) {
            const Buffer<glm::vec4> spheres = fit_spheres({&mesh, 1}, count);
            CHECK(int(spheres.size()) == count);
            CHECK(discs(spheres) == Approx(projected_area({&mesh, 1})).epsilon(1e-5));
            glm::dvec3 middle(0);
            for (const glm::vec4& s : spheres) {
                middle += glm::dvec3(s) / double(count);
                for (int c = 0; c < 3; ++c) CHECK((s[c] > glm::vec3(5, -3, 1)[c] && s[c] < glm::vec3(5, -3, 1)[c] + size[c]));
            }
            if (count == 1)
                for (int c = 0; c < 3; ++c) CHECK(middle[c] == Approx(double(glm::vec3(5, -3, 1)[c]) + double(size[c]) / 2).epsilon(1e-6));
        }
    }
    // Without extent there is nothing: no triangle, or only such without area.
    const Mesh none, point = box_mesh(glm::vec3(1), glm::vec3(1));
    CHECK(fit_spheres({&none, 1}, 4).empty());
    CHECK(projected_area({&none, 1}) == 0);
    CHECK(fit_spheres({&point, 1}, 4).empty());
    // A sheet has no inside, but hides: half of its area, as seen from everywhere.
    Mesh sheet = box_mesh(glm::vec3(0), glm::vec3(2, 1, 0));
    sheet.triangles.erase(sheet.triangles.begin(), sheet.triangles.begin() + 8), sheet.triangles.resize(2);
    const double seen = projected_area({&sheet, 1});
    CHECK(seen == Approx(1).epsilon(0.05));
    CHECK(discs(fit_spheres({&sheet, 1}, 8)) == Approx(seen).epsilon(1e-5));
    sheet.vertices[0].position.x = std::nanf("");
    CHECK_THROWS_AS(fit_spheres({&sheet, 1}, 8), InputError);
}

TEST_CASE("shadow spheres: meshes that move together are one thing, and cover no more than it", "[probes][shade][spheres]") {
    // A box, and another around it: of both the outer one's area.
    Scene scene;
    scene.meshes = {box_mesh(glm::vec3(-9), glm::vec3(9)), box_mesh(glm::vec3(-1), glm::vec3(1)), box_mesh(glm::vec3(-0.5f), glm::vec3(0.5f)), box_mesh(glm::vec3(2), glm::vec3(3))};
    for (std::size_t i = 1; i < 4; ++i) scene.meshes[i].dynamic = true;
    scene.meshes[3].transform[3].x = 1;
    const std::vector<MovingGroup> groups = moving_groups(scene);
    REQUIRE(groups.size() == 2);
    CHECK((groups[0].first == 1 && groups[0].last == 2 && groups[1].first == 3 && groups[1].last == 3));
    CHECK(projected_area({&scene.meshes[1], 2}) == projected_area({&scene.meshes[1], 1}));
    CHECK(discs(fit_spheres({&scene.meshes[1], 2}, 8)) == Approx(projected_area({&scene.meshes[1], 1})).epsilon(1e-5));
    scene.meshes[2].dynamic = false;
    CHECK(moving_groups(scene).size() == 2);
    scene.meshes[1].triangles.clear();
    CHECK(moving_groups(scene).size() == 1);
}

TEST_CASE("shadow spheres: they move with their mesh, and know the light where they are", "[probes][shade][spheres]") {
    Scene scene;
    scene.materials.resize(1);
    scene.materials[0].reflectance = glm::vec3(0.5f, 0.25f, 0);
    scene.meshes = {box_mesh(glm::vec3(-9), glm::vec3(9)), box_mesh(glm::vec3(-1), glm::vec3(1))};
    scene.meshes[1].dynamic = true;
    glm::dmat4& t = scene.meshes[1].transform;
    t[0] = {0, 2, 0, 0}, t[1] = {-2, 0, 0, 0}, t[2] = {0, 0, 2, 0}, t[3] = {1, 2, 3, 1};  // a quarter turn, twice as large
    ShadowSpheres s = place_spheres(scene, {{1, 1}}, {{{0.5f, 0, 0, 0.25f}}});
    REQUIRE(s.count() == 1);
    CHECK(s.owner[0] == glm::ivec2(1, 1));
    CHECK(s.rows[0] == glm::vec4(1, 3, 3, 0.5f));
    // Nothing that moves: a sphere that hides nothing.
    const ShadowSpheres none = place_spheres(scene, {}, {});
    CHECK(none.count() == 1);
    CHECK(none.rows[0].w == 0);
    // Radiance 0.3 + (0.1, -0.05, 0.02) . w: E_d = pi a + 2 pi / 3 b . d.
    const SpatialGrid grid{{1, 1, 1}, {0, 0, 0}, {1, 1, 1}};
    Buffer<glm::vec4> six;
    const glm::dvec3 b(0.1, -0.05, 0.02);
    for (int d = 0; d < spatial_directions; ++d) {
        const glm::dvec3 w(spatial_direction(d));
        six.push_back(glm::vec4(float(host::pi * 0.3 + 2 * host::pi / 3 * (b.x * w.x + b.y * w.y + b.z * w.z))));
    }
    light_spheres(grid, six, mean_reflectance(scene), {}, s);
    for (int c = 0; c < 3; ++c) {
        const double rho = c == 0 ? 0.5 : c == 1 ? 0.25 : 0;
        for (int k = 0; k < 4; ++k) {
            const double is = k == 3 ? 0.3 : b[k], sends = k == 3 ? rho * 0.3 : -4.0 / 9 * rho * b[k];
            CHECK(double(s.rows[std::size_t(1 + c)][k]) == Approx(is).margin(1e-6));
            CHECK(double(s.rows[std::size_t(4 + c)][k]) == Approx(sends).margin(1e-6));
        }
    }
}

TEST_CASE("shadow rays: a box over a floor hides what its faces' form factors say", "[probes][shade][rays][analytic]") {
    // A rectangle of half sides a and b at height h, above its middle: 4 times the corner's form factor (Lambert).
    Scene scene;
    scene.materials.resize(1);
    scene.meshes = {box_mesh({-1, -0.5f, 0.8f}, {1, 0.5f, 0.801f})};
    scene.meshes[0].dynamic = true;
    const double a = 1 / 0.8, b = 0.5 / 0.8, sa = std::sqrt(1 + a * a), sb = std::sqrt(1 + b * b);
    const double expected = 4 / (2 * host::pi) * (a / sa * host::atan(b / sa) + b / sb * host::atan(a / sb));
    const auto world = dynamic_world(scene, flatten(scene));
    Row row(16);
    ShadowRaysInputs in;
    in.world = world.get(), in.rays = 1024, in.position = &row.position, in.normal = &row.normal, in.irradiance = &row.irradiance;
    Image4 e;
    run(in, {}, e);
    for (int i = 0; i < 16; ++i) CHECK(1 - double(e(i, 0).x) == Approx(expected).margin(0.01));
    // Light from everywhere alike, by a grid: the same.
    const SpatialGrid grid{{1, 1, 1}, {0, 0, 0}, {1, 1, 1}};
    const Buffer<glm::vec4> six(6, glm::vec4(1));
    in.grid = &grid, in.six = &six;
    Image4 by_grid;
    run(in, {}, by_grid);
    for (int i = 0; i < 16; ++i) CHECK(by_grid(i, 0).x == Approx(double(e(i, 0).x)).margin(1e-5));
    RunOptions three;
    three.threads = 3;
    run(in, three, e);
    CHECK(e.texels == by_grid.texels);
    // Facing away, and without anything that moves: the same bits.
    for (int i = 0; i < 16; ++i) row.normal(i, 0) = {0, 0, -1, 1};
    run(in, {}, e);
    CHECK(e.texels == row.irradiance.texels);
    in.world = nullptr;
    CHECK_THROWS_AS(run(in, {}, e), InputError);
}
