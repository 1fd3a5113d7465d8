// The generated objects `container` and `character`: sound, closed to the outside, of real sizes, the same everywhere.
#include <catch2/catch.hpp>

#include "core/content_hash.h"
#include "core/hash.h"
#include "core/sequences.h"
#include "io/scenes/generate.h"
#include "scene_checks.h"

using namespace plumb;

namespace {

Scene make(const std::string& name, std::int64_t triangles = 0) { return io::generate_scene(name, {triangles, 1}, "test"); }

struct Extent {
    glm::dvec3 low{1e30}, high{-1e30};
};
Extent extent_of(const Scene& scene) {
    Extent e;
    for (const Mesh& mesh : scene.meshes)
        for (const Vertex& v : mesh.vertices) e.low = glm::min(e.low, glm::dvec3(v.position)), e.high = glm::max(e.high, glm::dvec3(v.position));
    return e;
}

}  // namespace

TEST_CASE("container and character: as many triangles as asked for, sound, with normal maps and tangents", "[scenes]") {
    for (const auto& [name, counts] : {std::pair<std::string, std::vector<std::int64_t>>{"container", {600, 2400, 20'000}},
                                       {"character", {1600, 4800, 40'000}}})
        for (const std::int64_t wanted : counts) {
            const Scene s = make(name, wanted);
            INFO(name << ": " << wanted << ", made " << triangle_count(s));
            CHECK(std::abs(double(triangle_count(s) - wanted)) < 0.16 * double(wanted));
            const Faults f = faults_of(s);
            CHECK(f.index == 0);
            CHECK(f.area == 0);
            CHECK(f.normal == 0);
            CHECK(f.side == 0);
            CHECK(f.coordinate == 0);
            int mapped = 0;
            for (const Mesh& mesh : s.meshes) {
                CHECK(mesh.dynamic);
                for (const std::int32_t m : mesh.material)
                    if (s.materials[std::size_t(m)].normal_texture >= 0) {
                        REQUIRE(mesh.tangents.size() == mesh.vertices.size());
                        ++mapped;
                    }
            }
            CHECK(mapped > 0);
        }
}

TEST_CASE("container and character: stand on the ground at their real sizes", "[scenes]") {
    const Extent box = extent_of(make("container")), figure = extent_of(make("character"));
    CHECK(box.low.y == 0);
    // ISO 668, 1CC: 6058 x 2438 x 2591 mm; the bars of the doors stand out by 65 mm at most.
    CHECK(box.high.x - box.low.x > 6.057);
    CHECK(box.high.x - box.low.x < 6.058 + 0.066);
    CHECK(box.high.z - box.low.z == Approx(2.438).epsilon(1e-6));
    CHECK(box.high.y == Approx(2.591).epsilon(1e-6));
    CHECK(figure.low.y == 0);
    CHECK(figure.high.y > 1.7);
    CHECK(figure.high.y < 1.9);
    CHECK(std::fabs(figure.high.x + figure.low.x) < 0.05);
}

TEST_CASE("container and character: from outside nothing but fronts is seen", "[scenes]") {
    for (const char* name : {"container", "character"}) {
        const Scene s = make(name);
        const Extent e = extent_of(s);
        const glm::dvec3 middle = 0.5 * (e.low + e.high);
        int met = 0;
        for (int i = 0; i < 400; ++i) {
            const glm::dvec2 a = sobol(std::uint32_t(i)), b = sobol(std::uint32_t(i) + 4096);
            const double z = 2 * a.x - 1, r = std::sqrt(1 - z * z), angle = 6.283185307179586 * a.y;
            const glm::dvec3 from = middle + 12.0 * glm::dvec3(r * std::cos(angle), z, r * std::sin(angle));
            const glm::dvec3 to = e.low + (e.high - e.low) * glm::dvec3(b.x, b.y, a.x);
            const RayHit hit = first_hit(s, from, glm::normalize(to - from));
            if (hit.t > 1e29) continue;
            INFO(name << ": ray " << i);
            CHECK(hit.front);
            ++met;
        }
        CHECK(met > 100);
    }
}

TEST_CASE("container and character: the same bytes on every machine", "[scenes]") {
    // From this program, on x86-64 with gcc 12; no other source.
    CHECK(hash_text(scene_hash(make("container"))) == "ee841452a55cdd76");
    CHECK(hash_text(scene_hash(make("character"))) == "bba1e3ed5dbc8808");
}
