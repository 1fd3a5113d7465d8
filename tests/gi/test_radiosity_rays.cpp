// Form factors by rays and by hemicubes: against contour integrals and each other.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/error.h"
#include "gi/radiosity/hemicube_factor.h"
#include "gi/radiosity/ray_form_factors.h"
#include "gi/radiosity/rows.h"
#include "gi/reference/ray_query.h"
#include "tests/gi/radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;

namespace {

// Polygons as a scene, each an object.
struct World {
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> query;
    std::vector<Polygon> polygons;

    explicit World(const std::vector<Polygon>& all) : polygons(all) {
        Scene scene;
        scene.materials.emplace_back();
        for (const Polygon& p : all) {
            Mesh mesh;
            const glm::dvec3 n = area_vector(p);
            for (const glm::dvec3& c : p) {
                Vertex v;
                v.position = glm::vec3(c), v.normal = glm::vec3(n / glm::length(n));
                mesh.vertices.push_back(v);
            }
            for (std::uint32_t i = 2; i < p.size(); ++i) mesh.triangles.push_back({0, i - 1, i});
            mesh.material.assign(mesh.triangles.size(), 0);
            scene.meshes.push_back(mesh);
        }
        geometry = flatten(scene);
        surfaces = raster::prepare(scene, geometry);
        query = reference::build_ray_query(geometry, surfaces, Rays::exact);
    }
    RaySource source(std::size_t k) const { return {{polygons[k]}, {}, {}}; }
    // Both sides of polygon k count as target 0; or its front, or its back alone.
    std::vector<std::int32_t> targets(std::size_t k, bool front = true, bool back = true) const {
        std::vector<std::int32_t> t(2 * geometry.triangles.size(), -1);
        for (std::size_t i = 0; i < geometry.triangles.size(); ++i)
            if (std::size_t(geometry.object[i]) == k) t[2 * i] = front ? 0 : -1, t[2 * i + 1] = back ? 0 : -1;
        return t;
    }
    std::vector<std::int32_t> owners(std::int32_t a, std::int32_t b) const {
        std::vector<std::int32_t> owner;
        for (const std::int32_t o : geometry.object) owner.push_back(o == a ? 0 : o == b ? 1 : -1);
        return owner;
    }
};

Polygon rectangle(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
    return {corner, corner + u, corner + u + v, corner + v};
}
const Polygon low = rectangle({0, 0, 0}, {0, 0, 1}, {1, 0, 0}), high = rectangle({0, 1, 0}, {1, 0, 0}, {0, 0, 1});
const Polygon wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
const Polygon screen = rectangle({0, 0.5, 0}, {0.5, 0, 0}, {0, 0, 1});

RayFactorParams params(std::int64_t rays, std::uint32_t seed = 1) {
    RayFactorParams p;
    p.rays = rays, p.seed = seed;
    return p;
}

}  // namespace

TEST_CASE("ray form factors: contour integrals lie within honest standard errors", "[radiosity][analytic]") {
    const World world({low, high, wall});
    const double opposed = 0.199824895698387, right = 0.200043776075403;  // verification.md 3
    double squares = 0;
    int runs = 0;
    for (std::uint32_t seed = 1; seed <= 20; ++seed)
        for (const std::size_t k : {1, 2}) {
            const RayFactor f = ray_form_factors(*world.query, world.geometry, world.source(0), world.targets(k), 1,
                                                 params(8192, seed), {})[0];
            const double sigmas = (f.value - (k == 1 ? opposed : right)) / f.standard_error;
            CAPTURE(seed, k, f.value, f.standard_error);
            CHECK(std::fabs(sigmas) < 5);
            CHECK(f.standard_error < 1.5 * std::sqrt(0.2 * 0.8 / 8192));  // of independent rays: 0.0044
            squares += sigmas * sigmas, ++runs;
        }
    // Of 40 squares of Student's t with 31 degrees of freedom the mean is 1.07 with a deviation of 0.26.
    CHECK(squares / runs > 0.4);
    CHECK(squares / runs < 1.9);
}

TEST_CASE("ray form factors: from a point, and which side is met", "[radiosity][analytic]") {
    const Polygon above = rectangle({-0.5, 1, -0.5}, {1, 0, 0}, {0, 0, 1});  // looks down
    const World world({above});
    const RaySource point{{}, {0, 0, 0}, {0, 1, 0}};
    auto factor = [&](const std::vector<std::int32_t>& targets, const RaySource& from) {
        return ray_form_factors(*world.query, world.geometry, from, targets, 1, params(1 << 16), {})[0];
    };
    const RayFactor f = factor(world.targets(0), point);
    CHECK(std::fabs(f.value - 0.239456470460774) < 5 * f.standard_error);  // Howell's B-3
    CHECK(factor(world.targets(0, true, false), point).value == f.value);
    CHECK(factor(world.targets(0, false, true), point).value == 0);
    CHECK(factor(world.targets(0), turned(point)).value == 0);
}

TEST_CASE("ray form factors: the same bits for any number of threads, and for any target list", "[radiosity]") {
    const World world({low, high, wall, screen});
    RunOptions one, three;
    one.threads = 1, three.threads = 3;
    const std::vector<RayFactor> row =
        ray_form_factor_row(*world.query, world.geometry, world.source(0), params(10000), one);
    const std::vector<RayFactor> again =
        ray_form_factor_row(*world.query, world.geometry, world.source(0), params(10000), three);
    REQUIRE(row.size() == world.geometry.triangles.size());
    for (std::size_t t = 0; t < row.size(); ++t)
        CHECK((row[t].value == again[t].value && row[t].standard_error == again[t].standard_error));
    const RayFactor both =
        ray_form_factors(*world.query, world.geometry, world.source(0), world.targets(1), 1, params(10000), one)[0];
    CHECK(both.value == Approx(row[2].value + row[3].value).epsilon(1e-14));
}

TEST_CASE("ray form factors: a row in a closed room sums to one, and is a hemicube's", "[radiosity]") {
    auto moved = [](Polygon p, const glm::dvec3& by) {
        for (glm::dvec3& c : p) c += by;
        return p;
    };
    const World room({low, high, wall, moved(Polygon(wall.rbegin(), wall.rend()), {1, 0, 0}),
                      rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0})});
    const RaySource point{{}, {0.3, 0, 0.6}, {0, 1, 0}};
    const std::vector<RayFactor> row = ray_form_factor_row(*room.query, room.geometry, point, params(1 << 16), {});
    double sum = 0;
    int seen = 0;
    for (std::size_t t = 0; t < row.size(); ++t) {
        sum += row[t].value;
        std::vector<std::int32_t> only(2 * row.size(), -1);
        only[2 * t] = only[2 * t + 1] = 0;
        const double cube = hemicube_form_factor(room.geometry, &room.surfaces, source_points(point, 1), only, 256,
                                                 Weights::exact, surface_offset(room.geometry), {});
        CAPTURE(t, row[t].value, row[t].standard_error, cube);
        CHECK(std::fabs(cube - row[t].value) < 5 * row[t].standard_error + 5e-4);  // 0.1 % of a row, verification.md 3
        seen += cube > 0.01;
    }
    CHECK(sum == Approx(1).epsilon(1e-12));
    CHECK(seen == 10);  // all but the floor's own two
}

TEST_CASE("ray form factors: what hides is found, and takes its share", "[radiosity][analytic]") {
    const World open({low, high}), hidden({low, high, screen});
    const Between nothing =
        between(*open.query, open.geometry, open.source(0), open.source(1), open.owners(0, 1), Sides::both, 1024);
    CHECK((nothing.segments == 1024 && nothing.hidden == 0 && nothing.occluders == 0 && nothing.own == 0));
    const Between some = between(*hidden.query, hidden.geometry, hidden.source(0), hidden.source(1),
                                 hidden.owners(0, 1), Sides::both, 1024);
    CHECK(some.occluders == 2);
    CHECK(some.own == 0);
    // At half height a segment's x is the mean of two even ones: half of them lie below 1/2.
    CHECK(double(some.hidden) / some.segments == Approx(0.5).margin(0.05));
    const RayFactor f = ray_form_factors(*hidden.query, hidden.geometry, hidden.source(0), hidden.targets(1), 1,
                                         params(1 << 16), {})[0];
    // What passes the screen's place and what passes beside it are mirror images: half.
    CHECK(std::fabs(f.value - 0.5 * 0.199824895698387) < 5 * f.standard_error);
    // A surface that hides a part of itself.
    std::vector<std::int32_t> owner = hidden.owners(0, 1);
    for (std::size_t t = 0; t < owner.size(); ++t)
        if (owner[t] < 0) owner[t] = 1;
    CHECK(between(*hidden.query, hidden.geometry, hidden.source(0), hidden.source(1), owner, Sides::both, 1024).own ==
          2);
}

TEST_CASE("hemicube form factors: the mean over points is that of Lambert's formula", "[radiosity]") {
    const World world({low, high, wall});
    const std::vector<SourcePoint> points = source_points(world.source(0), 16);
    REQUIRE(points.size() == 16);
    double mean[3] = {};
    for (const SourcePoint& p : points)
        for (const std::size_t k : {1, 2}) mean[k] += point_form_factor(p.position, p.normal, world.polygons[k]) / 16;
    for (const std::size_t k : {1, 2})
        for (const auto& [size, error] : {std::pair{64, 5e-3}, {256, 1e-3}})
            CHECK(hemicube_form_factor(world.geometry, &world.surfaces, points, world.targets(k), size, Weights::exact,
                                       surface_offset(world.geometry), {}) == Approx(mean[k]).epsilon(error));
}

TEST_CASE("hemicube form factors: how they err over rotations", "[radiosity][HEM 4.5.3][analytic]") {
    // verification.md 3, in %: at texels' centres, corners rounded to 1/256 pixel. Exact weights err as much: it is the
    // outline that does.
    const struct {
        int size;
        double rms, largest;
    } known[] = {{64, 0.267, 0.898}, {256, 0.0252, 0.0808}};
    for (const auto& [size, rms, largest] : known) {
        const RotationErrors centre = rotation_errors(size, Weights::centre, {}),
                             exact = rotation_errors(size, Weights::exact, {});
        CHECK(centre.rms == Approx(rms).epsilon(2e-3));
        CHECK(centre.largest == Approx(largest).epsilon(2e-3));
        CHECK(exact.rms == Approx(rms).epsilon(5e-3));
        CHECK(exact.largest == Approx(largest).epsilon(0.02));
        CHECK(exact.largest != centre.largest);
    }
    // Most of 32 texels: 0.78 and 2.41, by this program.
    CHECK(rotation_errors(32, Weights::centre, {}).rms > 2 * 0.267);
    // One cosine where three are due: far off, however fine.
    CHECK(rotation_errors(256, Weights::published, {}).rms > 5);
}

TEST_CASE("ray rows: a room's walls have their form factors, elements those of a fine hemicube, backs nothing", "[radiosity][analytic]") {
    test::CubeFaces grey;
    grey.reflectance.fill(0.5);
    Scene scene = test::cube(5, grey);
    const auto row_of = [](const Scene& s, const Elements& e, int i, std::int64_t rays) {
        const raster::Surfaces surfaces = raster::prepare(s, e.geometry);
        std::vector<double> row(std::size_t(e.count()), 0.0);
        add_ray_row(*reference::build_ray_query(e.geometry, surfaces, Rays::exact), e, i, cosine_directions(rays), row);
        return row;
    };
    const Elements e = elements_of(scene, {});
    int eye = 0;  // away from edges of the room
    for (int i = 0; i < e.count(); ++i) {
        const glm::dvec3 off = glm::abs(glm::dvec3(e.position[std::size_t(i)]) - 0.5);
        if ((off.x < 0.2) + (off.y < 0.2) + (off.z < 0.2) == 2) eye = i;
    }
    const std::vector<double> row = row_of(scene, e, eye, 1 << 17);
    double sum = 0;
    std::map<std::array<int, 3>, double> walls;  // by normal
    const auto wall_of = [](const glm::vec4& n) { return std::array{int(std::lround(n.x)), int(std::lround(n.y)), int(std::lround(n.z))}; };
    for (std::size_t j = 0; j < row.size(); ++j) sum += row[j], walls[wall_of(e.normal[j])] += row[j];
    CHECK(sum == Approx(1).epsilon(1e-12));
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {0, 1}) {
            std::array<int, 3> n{};
            n[std::size_t(axis)] = side == 0 ? 1 : -1;
            glm::dvec3 from(0), u(0), v(0);
            from[axis] = side, u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1;
            const double expected = point_form_factor(glm::dvec3(e.eye[std::size_t(eye)]), glm::dvec3(e.normal[std::size_t(eye)]), rectangle(from, u, v));
            CAPTURE(axis, side, expected);
            CHECK(walls[n] == Approx(expected).margin(5e-4));
        }
    // Element by element: corners in their order.
    const FormFactors fine = form_factors(e, {512, Weights::exact}, {});
    std::vector<float> hemicube(row.size(), 0.0f);
    fine.add_row(eye, hemicube);
    double apart = 0;
    for (std::size_t j = 0; j < row.size(); ++j) apart += std::fabs(row[j] - double(hemicube[j]));
    CHECK(apart < 0.01);
    CHECK(row_of(scene, e, eye, 1 << 17) == row);
    // A sheet that turns its back on the eye takes away what it hides, and gets none of it.
    const glm::dvec3 at(e.eye[std::size_t(eye)]), n(e.normal[std::size_t(eye)]);
    const glm::dvec3 u(n.y, n.z, n.x), v = glm::cross(n, u);  // n lies along an axis
    scene.meshes.push_back(test::grid(at + 0.1 * n - 0.05 * (u + v), 0.1 * u, 0.1 * v, 1, 1, 0));
    const Elements with = elements_of(scene, {});
    int same = -1;
    for (int i = 0; i < with.count(); ++i)
        if (glm::length(glm::dvec3(with.eye[std::size_t(i)]) - at) < 1e-3 && glm::dot(glm::dvec3(with.normal[std::size_t(i)]), n) > 0.99) same = i;
    REQUIRE(same >= 0);
    const std::vector<double> less = row_of(scene, with, same, 1 << 17);
    sum = 0;
    double sheet = 0;
    for (std::size_t j = 0; j < less.size(); ++j) {
        sum += less[j];
        if (glm::length(glm::dvec3(with.position[j]) - at) < 0.15 && glm::dot(glm::dvec3(with.position[j]) - at, n) > 0.05) sheet += less[j];
    }
    CHECK(sheet == 0);
    // A square of side s at height h above its middle: 4 corners' factors.
    const double a = 0.5, sa = std::sqrt(1 + a * a), hides = 4 / (2 * M_PI) * 2 * (a / sa) * std::atan(a / sa);
    CHECK(1 - sum == Approx(hides).margin(2e-3));
    CHECK_THROWS_AS(cosine_directions(0), InputError);
}

TEST_CASE("ray form factors: what cannot be is refused", "[radiosity]") {
    const World world({low, high});
    auto shoot = [&](const RayFactorParams& p, const RaySource& from, std::vector<std::int32_t> targets) {
        return ray_form_factors(*world.query, world.geometry, from, targets, 1, p, {});
    };
    RayFactorParams few = params(1 << 10), many = few;
    few.batches = 1;
    CHECK_THROWS_AS(shoot(few, world.source(0), world.targets(1)), InputError);
    CHECK_THROWS_AS(shoot(params(31), world.source(0), world.targets(1)), InputError);
    many.rays = std::int64_t(1) << 31;
    CHECK_THROWS_AS(shoot(many, world.source(0), world.targets(1)), InputError);
    CHECK_THROWS_AS(shoot(params(64), world.source(0), {}), InputError);
    const RaySource flat{{Polygon{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}, {}, {}};
    CHECK_THROWS_AS(shoot(params(64), flat, world.targets(1)), InputError);
}
