// Samples as large as their texels (`sample_area = "texels"`): the area of a texel on a surface, the form factor of the disc that
// a sample is, and where the sums go.
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/host_math.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const glm::dvec3& a) { return std::sqrt(dot(a, a)); }
glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Rows of world to texels.
std::array<glm::dvec4, 3> rows_of(const View& view, int size) {
    const glm::dmat4 clip = view.world_to_clip();
    auto row = [&](int r) { return glm::dvec4(clip[0][r], clip[1][r], clip[2][r], clip[3][r]); };
    return {(row(0) + row(3)) * (0.5 * size), (row(1) + row(3)) * (0.5 * size), row(3)};
}

double by_formula(const View& view, int size, const glm::dvec3& at, const glm::dvec3& normal) {
    const auto [x, y, w] = rows_of(view, size);
    const glm::dvec4 area = rsm::texel_area(x, y, w);
    const double h = dot(glm::dvec3(w), at) + w.w;
    return h * h * h / std::abs(dot(normal, glm::dvec3(area) - area.w * at));
}

// Where the ray of a place on the map meets the plane through `at`: the three equations of the place and the plane.
glm::dvec3 on_plane(const View& view, int size, const glm::dvec2& place, const glm::dvec3& at, const glm::dvec3& normal) {
    const auto [x, y, w] = rows_of(view, size);
    const glm::dvec4 first = x - place.x * w, second = y - place.y * w;
    const glm::dvec3 a(first), b(second);
    const glm::dvec3 right{-first.w, -second.w, dot(normal, at)};
    const double determinant = dot(normal, cross(a, b));
    return (right.x * cross(b, normal) + right.y * cross(normal, a) + right.z * cross(a, b)) / determinant;
}

// The area of the square of side `side` texels about the place of `at`, over side^2.
double by_corners(const View& view, int size, const glm::dvec3& at, const glm::dvec3& normal, double side) {
    const glm::dvec2 place = raster::project_to_texels(view, size, at);
    auto corner = [&](double u, double v) {
        return on_plane(view, size, place + glm::dvec2(u, v) * (side / 2), at, normal);
    };
    const glm::dvec3 a = corner(-1, -1), b = corner(1, -1), c = corner(1, 1), d = corner(-1, 1);
    return 0.5 * length(cross(c - a, d - b)) / (side * side);
}

Light light_of(LightType type) {
    Light light;
    light.type = type;
    light.position = {0.3f, 2.1f, -0.4f};
    light.direction = {0.2f, -1, 0.35f};
    light.cone_outer_deg = 50;
    return light;
}

rsm::GatherParams own_samples(std::vector<glm::dvec3> rows, rsm::SampleArea area) {
    rsm::GatherParams params{.gather = rsm::Gather::disc};
    params.rotations = 1;
    params.sample_area = area;
    params.pattern = "own.npy";
    params.own = std::make_shared<const SampleRows>(SampleRows{"own.npy", "own.npy", std::move(rows)});
    return params;
}

float gathered(const rsm::GatherParams& params, const Points& point, const raster::Rsm& map) {
    const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
    return gather(params, point, map, &pattern)(0, 0).x;
}

// A map's every texel as a sample that stands for itself, of a point that projects to the texel (column, row).
rsm::GatherParams every_texel(int size, int column, int row, rsm::SampleArea area) {
    std::vector<glm::dvec3> rows;
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) rows.push_back({double(i - column), double(j - row), 1});
    return own_samples(std::move(rows), area);
}

}  // namespace

TEST_CASE("rsm: the area of a texel on a surface", "[rsm][sample_area][analytic]") {
    for (const LightType type : {LightType::spot, LightType::directional, LightType::point}) {
        const std::vector<View> views = raster::light_views(light_of(type), {-1, 0, -1}, {1, 2, 1});
        for (const View& view : views)
            for (int k = 0; k < 12; ++k) {
                // In front of the light, and turned every way.
                const glm::dvec3 side = cross(view.forward, glm::dvec3(0.31, 0.52, 0.79));
                const glm::dvec3 at = view.eye + view.forward * (0.4 + 0.3 * k) + side * (0.02 * k);
                const glm::dvec3 turned = view.forward + side * (0.3 * k - 1.6) + cross(view.forward, side) * (0.1 * k);
                const glm::dvec3 normal = turned / length(turned);
                CAPTURE(int(type), k);
                // Of squares that shrink the corners' area is off by their side squared.
                const double exact = by_corners(view, 1024, at, normal, 1e-3);
                CHECK(by_formula(view, 1024, at, normal) == Approx(exact).epsilon(1e-6).margin(0));
            }
    }
}

TEST_CASE("rsm: the area of a texel that faces a spot is its share of the cone's square", "[rsm][sample_area][analytic]") {
    // On the axis, facing the light from h: (2 h tan(a) / size)^2, and turned by beta over cos(beta).
    const View view = raster::light_views(light_of(LightType::spot), {-1, 0, -1}, {1, 2, 1}).front();
    const double tangent = std::tan(50 * host::pi / 180);
    for (const double h : {0.01, 0.5, 3.0, 1000.0}) {
        const glm::dvec3 at = view.eye + view.forward * h;
        const double side = 2 * h * tangent / 256;
        CHECK(by_formula(view, 256, at, -view.forward) == Approx(side * side).epsilon(1e-9).margin(0));
        const glm::dvec3 across = cross(view.forward, glm::dvec3(1, 0, 0)) / length(cross(view.forward, glm::dvec3(1, 0, 0)));
        const glm::dvec3 turned = across * std::sin(1.2) - view.forward * std::cos(1.2);
        CHECK(by_formula(view, 256, at, turned) == Approx(side * side / std::cos(1.2)).epsilon(1e-9).margin(0));
    }
}

TEST_CASE("rsm: a sample of an area sends what a disc does along its axis", "[rsm][sample_area][analytic]") {
    const int n = 65;  // a texel's middle lies on the axis
    const double radiosity = 3, texel = 4.0 / n / n;
    const raster::Rsm map = plane_map(n, [&](double, double) { return radiosity; });
    for (const double texels : {0.5, 1.0, 37.0, 900.0})
        for (const double d : {1e-6, 1e-3, 0.05, 0.4, 3.0, 100.0}) {
            const double area = texels * texel, exact = radiosity * area / (area + host::pi * d * d);
            const Points point({0, 0, float(d)}, {0, 0, -1});
            const double got = gathered(own_samples({{0, 0, texels}}, rsm::SampleArea::texels), point, map);
            const double as_points = gathered(own_samples({{0, 0, texels}}, rsm::SampleArea::none), point, map);
            CAPTURE(texels, d, got, as_points);
            CHECK(got == Approx(exact).epsilon(3e-6).margin(0));
            CHECK(as_points == Approx(radiosity * area / (host::pi * d * d)).epsilon(3e-6).margin(0));
            // However near it is, it sends no more than its radiosity.
            CHECK(got <= radiosity * (1 + 1e-6));
        }
}

TEST_CASE("rsm: under a spot a sample's area follows depth and slope", "[rsm][sample_area][analytic]") {
    Light light = light_of(LightType::spot);
    light.rsm_size = 64;
    raster::Rsm map = empty_map(64);
    map.view = raster::light_views(light, {-1, 0, -1}, {1, 2, 1}).front();
    for (const double h : {0.2, 1.0, 2.5})
        for (const double slope : {0.0, 0.7, 1.4}) {
            const glm::dvec3 across = cross(map.view.forward, glm::dvec3(1, 0, 0));
            const glm::dvec3 unit = across / length(across);
            const glm::dvec3 normal = unit * std::sin(slope) - map.view.forward * std::cos(slope);
            // A third of a texel off the axis both ways.
            const glm::dvec3 other = cross(map.view.forward, unit);
            const glm::dvec3 at = map.view.eye + map.view.forward * h + (unit + other) * (0.012 * h), x = at + normal * 0.1;
            const glm::dvec2 place = raster::project_to_texels(map.view, 64, x);
            const glm::dvec2 own = raster::project_to_texels(map.view, 64, at);
            const int column = int(std::floor(own.x)), row = int(std::floor(own.y));
            set_texel(map, column, row, glm::vec3(at), glm::vec3(normal), glm::vec3(2));
            const double tangent = std::tan(50 * host::pi / 180), side = 2 * h * tangent / 64;
            const double area = side * side * h / std::abs(dot(normal, at - map.view.eye));
            const glm::dvec3 sample{column - std::floor(place.x), row - std::floor(place.y), 11};
            const double got = gathered(own_samples({sample}, rsm::SampleArea::texels),
                                        Points(glm::vec3(x), glm::vec3(-normal)), map);
            CAPTURE(h, slope);
            CHECK(got == Approx(11 * 2 / (host::pi * 0.1 * 0.1 + 11 * area)).epsilon(1e-5).margin(0));
        }
}

TEST_CASE("rsm: samples of an area, every texel of ever finer maps, lead to the form factor", "[rsm][sample_area][analytic]") {
    // dA to a rectangle that stands on its plane: a high and b wide, c away: (atan(b/c) - c/s atan(b/s)) / 2 pi, s^2 = a^2 + c^2.
    // The wall is 2 m high and 1 m wide to both sides.
    for (const double c : {0.5, 0.02}) {
        const double s = std::sqrt(4 + c * c), exact = (std::atan(1 / c) - c / s * std::atan(1 / s)) / host::pi;
        std::vector<double> errors;
        for (const int n : {16, 64, 256}) {
            const raster::Rsm map = plane_map(n, [](double, double) { return 1.0; });
            const Points foot({0, -1, float(c)}, {0, 1, 0});
            errors.push_back(gathered(every_texel(n, n / 2, n, rsm::SampleArea::texels), foot, map) / exact - 1);
        }
        INFO(fmt::format("{} m: {:+.5f} {:+.5f} {:+.5f}", c, errors[0], errors[1], errors[2]));
        CHECK(std::abs(errors[2]) < 0.25 * std::abs(errors[1]));
        CHECK(std::abs(errors[2]) < (c < 0.1 ? 0.01 : 1e-4));
    }
}

TEST_CASE("rsm: of the variant published a sample is a point", "[rsm][sample_area][published][bits]") {
    const raster::Rsm map = plane_map(64, [](double x, double) { return 1 + x; });
    const Points point({0.1f, 0.2f, 0.05f}, {0, 0, -1});
    for (const rsm::Gather gather_by : {rsm::Gather::disc, rsm::Gather::paths}) {
        rsm::GatherParams points, areas;
        points.gather = areas.gather = gather_by;
        points.sample_area = rsm::SampleArea::none, areas.sample_area = rsm::SampleArea::texels;
        CHECK(gathered(points, point, map) > gathered(areas, point, map));
        points.variant = areas.variant = rsm::Variant::published;
        CHECK(gathered(points, point, map) == gathered(areas, point, map));
    }
}

TEST_CASE("rsm: a sample without a surface, or of one that the light sees edge-on, sends nothing",
          "[rsm][sample_area][extreme]") {
    raster::Rsm map = plane_map(16, [](double, double) { return 1.0; });
    const Points point({0, 0, 0.1f}, {0, 0, -1});
    for (float* record = map.records.data(); record != map.records.data() + map.records.size(); record += record_stride)
        for (int c = 0; c < int(record_stride); ++c) record[c] = 0;
    rsm::GatherParams params{.gather = rsm::Gather::disc};
    params.sample_area = rsm::SampleArea::texels;
    CHECK(gathered(params, point, map) == 0);
    for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i) set_texel(map, i, j, {0.05f, 0, 0}, {-1, 0, 0}, glm::vec3(1));
    CHECK(gathered(params, point, map) == 0);
}
