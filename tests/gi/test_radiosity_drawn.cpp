// The scene that radiosity draws: split evenly, cut, and split again where light changes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "gi/radiosity/contacts.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/host_stages.h"
#include "gi/radiosity/lamp_light.h"
#include "gi/radiosity/own_light.h"
#include "gi/radiosity/tessellate.h"
#include "radiosity_scenes.h"

using namespace plumb;
using namespace plumb::radiosity;
using namespace plumb::test;

namespace {

// A grey cube of 2 m with a lamp in its ceiling's middle, and a wall across a third of its floor, away from all edges.
Scene room() {
    Scene s = cube(1, {{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, {}}, 2);
    s.meshes.push_back(grid({0.8, 1.99, 0.8}, {0.4, 0, 0}, {0, 0, 0.4}, 1, 1, add_material(s, 0.5, 10)));
    s.meshes.push_back(grid({0.7, 0, 0.6}, {0, 0.8, 0}, {0, 0, 0.6}, 1, 1, 0));
    append(s.meshes.back(), grid({0.72, 0, 0.6}, {0, 0, 0.6}, {0, 0.8, 0}, 1, 1, 0));
    return s;
}

Buffer<glm::vec4> irradiance_of(const Scene& s, const Elements& e, const RadiosityParams& p) {
    const FormFactors rows = form_factors(e, row_params(p), {});
    const Buffer<glm::vec4> own = own_light(s, e, rows, p, {});
    Buffer<glm::vec4> radiosity, irradiance;
    solve(rows, e, lamps_on(s, e, {}), own, p, {}, radiosity);
    gather(rows, own, radiosity, {}, irradiance);
    return irradiance;
}

// How much irradiance changes on triangles, weighted by their area.
double change_on(const Scene& s, const RadiosityParams& p) {
    const Elements e = elements_of(s, element_params(p));
    const std::vector<double> d = differences(e, irradiance_of(s, e, p), 0.05);
    double sum = 0, all = 0;
    for (std::size_t t = 0; t < d.size(); ++t) {
        const glm::uvec3 v = e.geometry.triangles[t];
        const glm::dvec3 a(e.geometry.vertices[v.x].position);
        const double area = glm::length(glm::cross(glm::dvec3(e.geometry.vertices[v.y].position) - a, glm::dvec3(e.geometry.vertices[v.z].position) - a));
        sum += area * d[t], all += area;
    }
    return sum / all;
}

std::size_t triangles_of(const Scene& s) { return flatten(s).triangles.size(); }

}  // namespace

TEST_CASE("drawn by radiosity: without cuts and rounds it is tessellate()", "[radiosity][HEM 4.5.4]") {
    RadiosityParams p;
    p.edge = 0.5f, p.cut = false, p.refine = 0;
    const Geometry a = flatten(drawn_by_radiosity(room(), p)), b = flatten(tessellate(room(), {0.5, 100'000}));
    REQUIRE(a.triangles == b.triangles);
    CHECK(std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(Vertex)) == 0);
    CHECK(inspect_contacts(a).contacts > 0);
    p.cut = true;
    CHECK(inspect_contacts(flatten(drawn_by_radiosity(room(), p))).contacts == 0);
}

TEST_CASE("drawn by radiosity: rounds of refining split where irradiance changes", "[radiosity][HEM 4.5.4]") {
    RadiosityParams p;
    p.edge = 0.7f, p.size = 16, p.refine_tolerance = 0.2f;
    double change = 1e9;
    std::size_t count = 0;
    for (const int rounds : {0, 1, 2}) {
        p.refine = rounds;
        const Scene s = drawn_by_radiosity(room(), p);
        const Contacts c = inspect_contacts(flatten(s));
        CAPTURE(rounds, change, count, triangles_of(s));
        CHECK(c.t_junctions == 0);
        CHECK(c.contacts == 0);
        const double now = change_on(s, p);
        CHECK(triangles_of(s) > count);
        CHECK(now < 0.8 * change);
        count = triangles_of(s), change = now;
    }
}

TEST_CASE("drawn by radiosity: bounds are kept, and the same triangles come for any number of threads", "[radiosity][bits]") {
    RadiosityParams p;
    p.edge = 0.7f, p.size = 16, p.refine = 2, p.least_edge = 0.3f;
    const Geometry g = flatten(drawn_by_radiosity(room(), p));
    for (const int threads : {1, 3})
        for (const Isa isa : supported_isas()) {
            RunOptions options;
            options.threads = threads, options.isa = isa;
            const Geometry other = flatten(drawn_by_radiosity(room(), p, options));
            REQUIRE(other.triangles == g.triangles);
            CHECK(std::memcmp(other.vertices.data(), g.vertices.data(), g.vertices.size() * sizeof(Vertex)) == 0);
        }
    p.most_triangles = 200;
    CHECK_THROWS_WITH(drawn_by_radiosity(room(), p), Catch::Contains("expected at most 200"));
    // In the dark nothing changes.
    Scene dark = room();
    dark.materials[6].emission = glm::vec3(0);
    p.most_triangles = 4'000'000;
    RadiosityParams none = p;
    none.refine = 0;
    CHECK(triangles_of(drawn_by_radiosity(dark, p)) == triangles_of(drawn_by_radiosity(dark, none)));
}
