// probes.volume in closed form: radiances whose irradiance is known, six directions of a grid, and what is made of them.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "gi/probes/volume.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

float draw(int i, int seed) { return float(std::uint32_t(pixel_hash<std::int32_t>(i, seed, 0, 9).x) >> 8) * 0x1p-24f; }
// Uniform on the sphere.
glm::dvec3 direction(int i, int seed) {
    const double z = 2 * double(draw(i, seed)) - 1, phi = 2 * host::pi * double(draw(i, seed + 1)), r = std::sqrt(1 - z * z);
    return {r * host::cos(phi), r * host::sin(phi), z};
}

// E_d at each place of a grid.
Buffer<glm::vec4> filled(const SpatialGrid& g, const std::function<glm::dvec3(const glm::dvec3& at, const glm::dvec3& d)>& e) {
    Buffer<glm::vec4> values;
    for (int z = 0; z < g.count.z; ++z)
        for (int y = 0; y < g.count.y; ++y)
            for (int x = 0; x < g.count.x; ++x)
                for (int d = 0; d < spatial_directions; ++d)
                    values.push_back(glm::vec4(glm::vec3(e(glm::dvec3(g.origin) + glm::dvec3(x, y, z) * glm::dvec3(g.spacing),
                                                           glm::dvec3(spatial_direction(d)))), 1));
    return values;
}

struct Points {
    Image4 position, normal, uv;
    Points(int n, const std::function<void(int, glm::vec3&, glm::vec3&)>& each) : position(n, 1), normal(n, 1), uv(n, 1, glm::vec4(-1)) {
        for (int i = 0; i < n; ++i) {
            glm::vec3 p(0), d(0, 0, 1);
            each(i, p, d);
            position(i, 0) = glm::vec4(p, 0), normal(i, 0) = glm::vec4(d, 1);
        }
    }
};
Points anywhere(int n, float reach = 3) {
    return Points(n, [&](int i, glm::vec3& p, glm::vec3& d) {
        p = reach * (2.0f * glm::vec3(draw(i, 11), draw(i, 12), draw(i, 13)) - 1.0f), d = glm::vec3(direction(i, 14));
    });
}

VolumeLight lit(const SpatialGrid& g, const Buffer<glm::vec4>& values, const Points& points, VolumeForm form, bool everywhere = false,
                const RunOptions& options = {}) {
    VolumeInputs in;
    in.grid = g, in.form = form, in.everywhere = everywhere, in.irradiance = &values;
    in.position = &points.position, in.normal = &points.normal, in.lightmap_uv = &points.uv;
    VolumeLight out;
    run(in, options, out);
    return out;
}

const SpatialGrid some_grid{{4, 3, 2}, {-1.5f, -1, -0.5f}, {1, 0.9f, 1.3f}};

}  // namespace

TEST_CASE("probes.volume: constant radiance L gives pi L at all points and normals", "[probes][volume][IPR 4.1.2][analytic]") {
    const Buffer<glm::vec4> values = filled(some_grid, [](auto&, auto&) { return host::pi * glm::dvec3(0.25, 2, 1e4); });
    const Points points = anywhere(500);
    for (const VolumeForm form : {VolumeForm::cube, VolumeForm::linear}) {
        const VolumeLight v = lit(some_grid, values, points, form);
        for (int i = 0; i < 500; ++i) {
            const glm::vec4 e = v.irradiance(i, 0), l = v.light(i, 0), m = v.from_light(i, 0), n = points.normal(i, 0);
            CHECK(e.x == Approx(0.25 * host::pi).epsilon(2e-6));
            CHECK(e.y == Approx(2 * host::pi).epsilon(2e-6));
            CHECK(e.z == Approx(1e4 * host::pi).epsilon(2e-6));
            CHECK(e.w == 1);
            CHECK(m.y == Approx(2 * host::pi).epsilon(2e-6));
            // Light from everywhere alike comes along the normal.
            CHECK(glm::length(glm::vec3(l) - glm::vec3(n)) < 1e-4f);
        }
    }
}

TEST_CASE("probes.volume: as printed, a constant radiance gives 2.283 L along an axis and 1.1755 times that on a cube's diagonal",
          "[probes][volume][IPR 4.1][analytic]") {
    // w = 1 - 2 theta / pi over the hemisphere: 2 pi - 4. On the diagonal three weights of 1 - 2 acos(1 / sqrt 3) / pi.
    const double whole = 2 * host::pi - 4, diagonal = 3 * (1 - 2 * host::acos(1 / std::sqrt(3.0)) / host::pi);
    CHECK(whole == Approx(2.283).epsilon(1e-4));
    CHECK(diagonal == Approx(1.1755).epsilon(1e-4));
    const Buffer<glm::vec4> values = filled(some_grid, [&](auto&, auto&) { return glm::dvec3(whole); });
    const Points points(14, [](int i, glm::vec3&, glm::vec3& d) {
        d = i < 6 ? spatial_direction(i) : glm::normalize(glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    });
    const VolumeLight v = lit(some_grid, values, points, VolumeForm::angles);
    for (int i = 0; i < 14; ++i) {
        CHECK(v.irradiance(i, 0).y == Approx(i < 6 ? whole : diagonal * whole).epsilon(1e-5));
        CHECK(glm::length(glm::vec3(v.light(i, 0)) - glm::vec3(points.normal(i, 0))) < 1e-5f);
    }
    // The angle itself, by double's acos.
    const Points turned = anywhere(300);
    const VolumeLight t = lit(some_grid, values, turned, VolumeForm::angles);
    for (int i = 0; i < 300; ++i) {
        double sum = 0;
        for (int d = 0; d < spatial_directions; ++d) {
            const double c = glm::dot(glm::dvec3(spatial_direction(d)), glm::dvec3(turned.normal(i, 0)));
            sum += 1 - 2 * host::acos(std::min(1.0, std::max(c, 0.0))) / host::pi;
        }
        CHECK(t.irradiance(i, 0).x == Approx(sum * whole).epsilon(1e-5));
    }
}

TEST_CASE("probes.volume: `linear` is exact for radiance of degree 0 and 1", "[probes][volume][analytic]") {
    // Of L = a + b . w irradiance is pi a + 2 pi / 3 b . n (Ramamoorthi and Hanrahan 2001: A_0 = pi, A_1 = 2 pi / 3).
    const glm::dvec3 b(0.5, -0.3, 0.7);
    const auto e_of = [&](const glm::dvec3& n) { return host::pi + 2 * host::pi / 3 * glm::dot(b, n); };
    const Buffer<glm::vec4> values = filled(some_grid, [&](auto&, const glm::dvec3& d) { return glm::dvec3(e_of(d)); });
    const Points points = anywhere(500);
    const VolumeLight linear = lit(some_grid, values, points, VolumeForm::linear), cube = lit(some_grid, values, points, VolumeForm::cube);
    double worst_cube = 0;
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 n(points.normal(i, 0));
        CHECK(double(linear.irradiance(i, 0).x) == Approx(e_of(n)).epsilon(3e-6));
        worst_cube = std::max(worst_cube, std::fabs(double(cube.irradiance(i, 0).x) - e_of(n)));
        // Light comes along b, or where that is behind the surface, from its horizon; and a little from the normal.
        const glm::dvec3 l(linear.light(i, 0)), side = glm::normalize(b - std::min(0.0, glm::dot(b, n)) * n);
        CHECK(glm::dot(l, n) > 0);
        if (glm::dot(b, n) > -0.8 * glm::length(b)) CHECK(glm::dot(l, side) > 0.97);
    }
    CHECK(worst_cube > 0.2);
}

TEST_CASE("probes.volume: light along an axis leaves an rms of 0.1291 to the cube and 0.0913 to `linear`", "[probes][volume][analytic]") {
    // A sun of irradiance 1 from +z: E = max(0, n_z). The cube makes n_z^2 of it where n_z > 0: the integral over n_z of
    // (z - z^2)^2 / 2 = 1 / 60. `linear` makes max(0, (z^2 + z) / 2): 1 / 240 above, and 0 below, where z^2 + z < 0.
    const Buffer<glm::vec4> values = filled(some_grid, [](auto&, const glm::dvec3& d) { return glm::dvec3(std::max(0.0, d.z)); });
    const int n = 4096;
    const Points points(n, [&](int i, glm::vec3&, glm::vec3& d) {
        const double z = 2 * (i + 0.5) / n - 1, phi = 2.399963 * i, r = std::sqrt(1 - z * z);
        d = glm::vec3(r * host::cos(phi), r * host::sin(phi), z);
    });
    const auto rms = [&](VolumeForm form) {
        const VolumeLight v = lit(some_grid, values, points, form);
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            const double d = double(v.irradiance(i, 0).x) - std::max(0.0, double(points.normal(i, 0).z));
            sum += d * d;
        }
        return std::sqrt(sum / n);
    };
    CHECK(rms(VolumeForm::cube) == Approx(std::sqrt(1 / 60.0)).epsilon(1e-4));
    CHECK(std::sqrt(1 / 60.0) == Approx(0.1291).epsilon(1e-3));
    CHECK(rms(VolumeForm::linear) == Approx(std::sqrt(1 / 240.0)).epsilon(1e-4));
}

TEST_CASE("probes.volume: the light vector of a single light is its direction", "[probes][volume][IPR 4.1.2][analytic]") {
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, 0.8, -0.5));
    const Buffer<glm::vec4> values =
        filled(some_grid, [&](auto&, const glm::dvec3& d) { return glm::dvec3(3, 1, 0) * std::max(0.0, glm::dot(d, sun)); });
    const Points points = anywhere(400);
    const VolumeLight v = lit(some_grid, values, points, VolumeForm::linear);
    for (int i = 0; i < 400; ++i) {
        const glm::dvec3 l(v.light(i, 0)), n(points.normal(i, 0));
        CHECK(glm::length(l) == Approx(1).epsilon(1e-5));
        CHECK(glm::dot(l, n) > 0);
        // `least` turns it by at most asin(1 / 64 / |D|); |D| is 1 over the sum of the direction's components.
        const double turned = (std::fabs(sun.x) + std::fabs(sun.y) + std::fabs(sun.z)) / 64;
        if (glm::dot(sun, n) > 0) CHECK(glm::dot(l, sun) > std::sqrt(1 - turned * turned) - 1e-6);
    }
    // In the dark: the normal.
    const VolumeLight dark = lit(some_grid, filled(some_grid, [](auto&, auto&) { return glm::dvec3(0); }), points, VolumeForm::linear);
    for (int i = 0; i < 400; ++i) {
        CHECK(glm::length(glm::vec3(dark.light(i, 0)) - glm::vec3(points.normal(i, 0))) < 1e-6f);
        CHECK(dark.irradiance(i, 0) == glm::vec4(0, 0, 0, 1));
    }
}

TEST_CASE("probes.volume: between places it is trilinear, beyond the grid it is that of its edge", "[probes][volume][IPR 4.1.1][analytic]") {
    const auto field = [](const glm::dvec3& p) { return 10 + p.x - 2 * p.y + 3 * p.z + 0.5 * p.x * p.y * p.z; };
    const Buffer<glm::vec4> values = filled(some_grid, [&](const glm::dvec3& p, auto&) { return glm::dvec3(field(p)); });
    const glm::dvec3 low(some_grid.origin), high = low + glm::dvec3(some_grid.count - 1) * glm::dvec3(some_grid.spacing);
    const Points points = anywhere(2000);
    const VolumeLight v = lit(some_grid, values, points, VolumeForm::cube);
    int outside = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 p(points.position(i, 0)), held = glm::clamp(p, low, high);
        outside += p != held ? 1 : 0;
        CHECK(double(v.irradiance(i, 0).x) == Approx(field(held)).epsilon(5e-6));
    }
    CHECK((outside > 500 && outside < 1990));
    // A kilometre away.
    const Points far(2, [](int i, glm::vec3& p, glm::vec3&) { p = glm::vec3(i == 0 ? 1000.0f : -1000.0f); });
    const VolumeLight there = lit(some_grid, values, far, VolumeForm::linear);
    CHECK(double(there.irradiance(0, 0).x) == Approx(field(high)).epsilon(1e-5));
    CHECK(double(there.irradiance(1, 0).x) == Approx(field(low)).epsilon(1e-5));
}

TEST_CASE("probes.volume: a grid of one place, and what it does not serve", "[probes][volume]") {
    const SpatialGrid one{{1, 1, 1}, {1, 2, 3}, {0.5f, 0.5f, 0.5f}};
    const Buffer<glm::vec4> values = filled(one, [](auto&, const glm::dvec3& d) { return glm::dvec3(1 + d.x, 2, 3); });
    Points points = anywhere(40);
    points.normal(3, 0) = glm::vec4(0);
    points.uv(4, 0) = glm::vec4(0, 0, 0, 0), points.uv(5, 0) = glm::vec4(0.3f, 0.4f, 0, 0);
    const VolumeLight v = lit(one, values, points, VolumeForm::linear);
    for (int i = 0; i < 40; ++i) {
        const bool is = i != 3 && i != 4 && i != 5;
        CHECK(v.irradiance(i, 0).w == (is ? 1.0f : 0.0f));
        CHECK(v.irradiance(i, 0).x == Approx(is ? 1 + points.normal(i, 0).x : 0).margin(2e-6));
        if (is) continue;
        CHECK(v.light(i, 0) == glm::vec4(0));
        CHECK(v.from_light(i, 0) == glm::vec4(0));
    }
    const VolumeLight all = lit(one, values, points, VolumeForm::linear, true);
    CHECK(all.irradiance(3, 0).w == 0);
    CHECK(all.irradiance(4, 0).x == Approx(1 + points.normal(4, 0).x).margin(2e-6));
    // Negative irradiance, as cut-off transport may leave it, is none.
    const VolumeLight negative = lit(one, filled(one, [](auto&, auto&) { return glm::dvec3(-1, -1, 2); }), points, VolumeForm::cube);
    CHECK(negative.irradiance(0, 0).x == 0);
    CHECK(negative.irradiance(0, 0).z == Approx(2));
}

TEST_CASE("probes.volume: refuses in one line what does not fit", "[probes][volume]") {
    const Points points = anywhere(4);
    Buffer<glm::vec4> values(6 * 24, glm::vec4(1));
    const auto refused = [&](const SpatialGrid& g, const Buffer<glm::vec4>& list) {
        try {
            lit(g, list, points, VolumeForm::cube);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    using Catch::Matchers::Contains;
    CHECK(refused(some_grid, values) == "nothing");
    values.pop_back();
    CHECK_THAT(refused(some_grid, values), Contains("143 irradiances") && Contains("4 x 3 x 2"));
    CHECK_THAT(refused(SpatialGrid{}, {}), Contains("0 irradiances"));
    values.resize(6 * 24);
    SpatialGrid flat = some_grid;
    flat.spacing.y = 0;
    CHECK_THAT(refused(flat, values), Contains("spacing"));
    flat.spacing.y = std::nanf("");
    CHECK(refused(flat, values) != "nothing");
}

TEST_CASE("probes.volume: the same bits for every instruction set and number of threads", "[probes][volume][bits]") {
    Buffer<glm::vec4> values;
    for (int i = 0; i < 6 * 24; ++i) values.push_back({draw(i, 31), draw(i, 32), draw(i, 33), 0});
    Points points(97 * 31, [](int i, glm::vec3& p, glm::vec3& d) {
        p = 3.0f * (2.0f * glm::vec3(draw(i, 41), draw(i, 42), draw(i, 43)) - 1.0f), d = glm::vec3(direction(i, 44));
    });
    for (Image4* image : {&points.position, &points.normal, &points.uv}) image->width = 97, image->height = 31;
    for (const VolumeForm form : {VolumeForm::cube, VolumeForm::linear, VolumeForm::angles}) {
        std::vector<Image4> first;
        for (const Isa isa : supported_isas())
            for (const int threads : {1, 3}) {
                RunOptions options;
                options.isa = isa, options.threads = threads;
                const VolumeLight v = lit(some_grid, values, points, form, false, options);
                if (first.empty()) first = {v.irradiance, v.light, v.from_light};
                CHECK(v.irradiance.texels == first[0].texels);
                CHECK(v.light.texels == first[1].texels);
                CHECK(v.from_light.texels == first[2].texels);
            }
    }
}
